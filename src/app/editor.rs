//! What is open, and what happens to it: files, steps, the journal.

mod document;

use super::canvas::Hand;
use super::dialog::Dialog;
use super::reference::Picture;
use super::render::{Look, Renderer};
use super::timing::Timing;
use super::view::View;
use crate::edit::folds::Cost;
use crate::edit::handle::{Id, Stage};
use crate::edit::history::History;
use crate::edit::influence::Influence;
use crate::edit::journal::Journal;
use crate::edit::model::{Drawing, Model};
use crate::edit::overlay::{self, Overlay};
use crate::edit::EditError;
use crate::gpu::Show;
use crate::mesh::HalfEdgeMesh;
use crate::patch::tess::TessRule;
use crate::scene::{shapes, Scene};
use glam::{DVec2, DVec4};
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// How often a gesture that goes on is written to the journal.
const LIVE: Duration = Duration::from_millis(400);

/// What the pointer does on the canvas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tool {
    /// Selects and moves handles.
    Move,
    /// Paints or moves what lies within a circle.
    Brush,
    /// Tags edges of the input mesh as sharp.
    Sharp,
    /// Takes a colour from the surface or the reference picture.
    Pick,
    /// Draws a polygon click by click.
    Draw,
}

/// The brush.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brush {
    /// Points of the window.
    pub radius: f32,
    /// Straight alpha.
    pub colour: DVec4,
    /// Moves the geometry handle nearest the centre (true), or paints.
    pub moves: bool,
}

/// What is shown over the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// The control mesh of the stage.
    pub mesh: bool,
    /// Its handles.
    pub handles: bool,
    /// Control points in place of limit points.
    pub control: bool,
    /// Outlines of what the selection influences.
    pub influence: bool,
    /// A grid that points snap to, scene units; 0: none.
    pub grid: f64,
    /// Points snap to each other.
    pub snap_points: bool,
    /// Opacity of the surface over a reference picture.
    pub opacity: f32,
}

/// A change that is being made with the pointer held down: one step in the end.
struct Gesture {
    label: String,
    before: Scene,
    written: Instant,
}

/// A message in the status line.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// One line.
    pub text: String,
    /// Whether something was not done.
    pub error: bool,
}

/// A handle that was dragged, for the report of a scripted session.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Dragged {
    /// The handle.
    pub handle: Id,
    /// Where its limit point was left.
    pub at: DVec2,
}

/// The editor without its window.
pub struct Editor {
    /// The scene and what follows from it.
    pub model: Model,
    /// A gradient mesh in place of the model.
    pub gradient: Option<crate::edit::gradient::Gradient>,
    /// A surface in space in place of the model.
    pub solid: Option<super::surface::Solid>,
    /// Where it was read from or written to.
    pub file: Option<PathBuf>,
    /// Its steps.
    pub history: History,
    journal: Option<Journal>,
    saved_at: Option<usize>,
    gesture: Option<Gesture>,
    /// Where state that belongs to no scene is kept.
    pub state: Option<PathBuf>,
    /// Files opened lately, the last first.
    pub recent: Vec<PathBuf>,
    /// The part of the model in the canvas.
    pub view: View,
    /// Whether the view is to be fitted as soon as the canvas has its size.
    pub fit_next: bool,
    /// How the surface is drawn.
    pub look: Look,
    /// Which mesh is edited.
    pub stage: Stage,
    /// What is shown over the surface.
    pub shown: Shown,
    /// What the pointer does.
    pub tool: Tool,
    /// The brush.
    pub brush: Brush,
    /// Selected handles.
    pub selection: BTreeSet<Id>,
    /// What the pointer holds or is over.
    pub hand: Hand,
    /// Whether folds stop a drag.
    pub prevent_folds: bool,
    /// Cost of the last fold tests.
    pub fold_cost: Cost,
    overlay: Option<(u64, overlay::Look, Overlay)>,
    influence: Option<(u64, BTreeSet<Id>, [Influence; 2])>,
    /// The window in front, if any.
    pub dialog: Option<Dialog>,
    /// What was said last.
    pub message: Option<Message>,
    /// Colours at hand.
    pub swatches: Vec<DVec4>,
    /// Colour to paste.
    pub copied: Option<DVec4>,
    /// The picture under the mesh.
    pub reference: Picture,
    /// Live times and captures.
    pub timing: Timing,
    /// Whether the times are shown.
    pub timing_open: bool,
    /// The device, where there is a window.
    pub renderer: Option<Renderer>,
    /// Handles dragged so far.
    pub dragged: Vec<Dragged>,
    /// Whether the window is to close.
    pub quit: bool,
}

impl Editor {
    /// An editor with a new scene. `state`: where journals of unsaved scenes and recent files are kept.
    pub fn new(state: Option<PathBuf>) -> Editor {
        let model = Model::new(Editor::fresh("quad"), Drawing::default()).expect("a built-in mesh can be drawn");
        Editor {
            model,
            gradient: None,
            solid: None,
            file: None,
            history: History::default(),
            journal: None,
            saved_at: Some(0),
            gesture: None,
            recent: super::files::recent(state.as_deref()),
            state,
            view: View::default(),
            fit_next: true,
            look: Look {
                show: Show::Surface,
                tess: TessRule::Pixels(6.0),
                background: Some([0.86, 0.86, 0.88, 1.0]),
                samples: 1,
            },
            stage: Stage::Input,
            shown: Shown {
                mesh: true,
                handles: true,
                control: false,
                influence: true,
                grid: 0.0,
                snap_points: false,
                opacity: 0.75,
            },
            tool: Tool::Move,
            brush: Brush { radius: 40.0, colour: DVec4::new(0.9, 0.35, 0.25, 1.0), moves: false },
            selection: BTreeSet::new(),
            hand: Hand::default(),
            prevent_folds: true,
            fold_cost: Cost::default(),
            overlay: None,
            influence: None,
            dialog: None,
            message: None,
            swatches: super::colour::first_swatches(),
            copied: None,
            reference: Picture::default(),
            timing: Timing::default(),
            timing_open: false,
            renderer: None,
            dragged: Vec::new(),
            quit: false,
        }
    }

    /// A scene of a built-in mesh with mild colours.
    pub fn fresh(builtin: &str) -> Scene {
        Editor::coloured(shapes::builtin(builtin).unwrap_or_default())
    }

    /// A scene of polygons with mild colours.
    pub fn coloured(mesh: crate::scene::InputMesh) -> Scene {
        let ends = crate::scene::numbering::ends(&mesh);
        let corner_colours = ends.iter().map(|&(origin, _)| Editor::shade(origin)).collect();
        Scene { name: "untitled".to_owned(), mesh, corner_colours, ..Scene::default() }
    }

    /// One of four mild colours.
    pub fn shade(v: u32) -> DVec4 {
        let shades = [[0.96, 0.84, 0.62], [0.91, 0.42, 0.36], [0.16, 0.6, 0.58], [0.55, 0.75, 0.9]];
        let [r, g, b] = shades[v as usize % 4];
        DVec4::new(r, g, b, 1.0)
    }

    // Messages.

    /// Says something in the status line.
    pub fn say(&mut self, text: impl std::fmt::Display) {
        self.message = Some(Message { text: text.to_string(), error: false });
    }

    /// Says what was not done.
    pub fn fail(&mut self, text: impl std::fmt::Display) {
        self.message = Some(Message { text: text.to_string(), error: true });
    }

    // Files.

    /// Whether the scene differs from its file.
    pub fn unsaved(&self) -> bool {
        if let Some(gradient) = &self.gradient {
            return gradient.unsaved();
        }
        if let Some(solid) = &self.solid {
            return solid.unsaved();
        }
        self.gesture.is_some() || self.saved_at != Some(self.history.position())
    }

    // Steps.

    /// Makes a change in one step.
    pub fn change(
        &mut self,
        label: &str,
        change: impl FnOnce(&mut Scene, &HalfEdgeMesh) -> Result<(), EditError>,
    ) -> bool {
        let alone = self.gesture.is_none();
        self.begin(label);
        let done = self.during(change);
        if alone {
            self.commit();
        }
        done
    }

    /// Begins a gesture, unless one goes on.
    pub fn begin(&mut self, label: &str) {
        if self.gesture.is_none() {
            let before = self.model.scene.clone();
            self.gesture = Some(Gesture { label: label.to_owned(), before, written: Instant::now() });
        }
    }

    /// Changes the scene as part of the gesture that goes on.
    pub fn during(&mut self, change: impl FnOnce(&mut Scene, &HalfEdgeMesh) -> Result<(), EditError>) -> bool {
        let mut next = self.model.scene.clone();
        let done = change(&mut next, &self.model.mesh).and_then(|()| self.model.set(next));
        if let Err(e) = &done {
            self.fail(e);
        }
        done.is_ok()
    }

    /// Takes a whole scene as part of the gesture that goes on.
    pub fn replace(&mut self, scene: Scene) -> bool {
        self.during(|old, _| {
            *old = scene;
            Ok(())
        })
    }

    /// Ends the gesture; what it changed is one step.
    pub fn commit(&mut self) {
        if let Some(gradient) = &mut self.gradient {
            gradient.commit();
        }
        if let Some(solid) = &mut self.solid {
            solid.commit();
        }
        let Some(gesture) = self.gesture.take() else { return };
        let step = self.history.push(&gesture.label, &gesture.before, &self.model.scene).cloned();
        if let Some(step) = step {
            if self.saved_at.is_some_and(|at| at >= self.history.position()) {
                // The saved state was undone, and is now out of reach.
                self.saved_at = None;
            }
            self.note(&gesture.before, |journal| journal.step(&step));
            if step.change.renumbers() {
                self.selection.clear();
            }
        } else {
            self.note_abandoned();
        }
    }

    /// Gives the gesture up: the scene is as before it.
    pub fn cancel(&mut self) {
        if let Some(gradient) = &mut self.gradient {
            gradient.cancel();
        }
        if let Some(gesture) = self.gesture.take() {
            if let Err(e) = self.model.set(gesture.before) {
                self.fail(e);
            }
            self.note_abandoned();
        }
    }

    /// Takes a step back, or does it again.
    pub fn step(&mut self, forward: bool) {
        if self.gradient.is_some() {
            return self.gradient_step(forward);
        }
        if self.solid.is_some() {
            return self.surface_step(forward);
        }
        self.cancel();
        let before = self.model.scene.clone();
        let mut scene = before.clone();
        let done = if forward { self.history.redo(&mut scene) } else { self.history.undo(&mut scene) };
        let Some(label) = done.map(str::to_owned) else {
            self.say(if forward { "nothing to redo" } else { "nothing to undo" });
            return;
        };
        let renumbered = scene.mesh.corners != before.mesh.corners;
        if let Err(e) = self.model.set(scene) {
            self.fail(e);
            return;
        }
        if renumbered {
            self.selection.clear();
        }
        let after = self.model.scene.clone();
        self.note(&before, |journal| journal.moved(forward, &before, &after));
        self.say(format_args!("{} {label}", if forward { "redone:" } else { "undone:" }));
    }

    fn start_journal(&mut self, base: &Scene) {
        match Journal::begin(self.file.as_deref(), self.state.as_deref(), base) {
            Ok(journal) => self.journal = Some(journal),
            Err(e) => self.fail(format_args!("no journal can be written ({e}); save often")),
        }
    }

    /// Writes to the journal, which begins with `base` when there is none.
    fn note(&mut self, base: &Scene, write: impl FnOnce(&mut Journal) -> std::io::Result<()>) {
        if self.journal.is_none() {
            self.start_journal(base);
        }
        let Some(journal) = &mut self.journal else { return };
        if let Err(e) = write(journal) {
            self.journal = None;
            self.fail(format_args!("the journal cannot be written ({e}); save soon"));
        }
    }

    /// A gesture came to nothing; its journal may have more.
    fn note_abandoned(&mut self) {
        if let Some(Err(e)) = self.journal.as_mut().map(Journal::abandon) {
            self.journal = None;
            self.fail(format_args!("the journal cannot be written ({e}); save soon"));
        }
    }

    /// What is to be done from time to time: the journal of a gesture that goes on.
    pub fn tick(&mut self) {
        if let Some(gradient) = &mut self.gradient {
            if let Err(e) = gradient.keep_journal(self.file.as_deref(), self.state.as_deref()) {
                self.fail(format_args!("the journal cannot be written ({e}); save soon"));
            }
            return;
        }
        if let Some(solid) = &mut self.solid {
            if let Err(e) = solid.keep_journal(self.file.as_deref(), self.state.as_deref()) {
                self.fail(format_args!("the journal cannot be written ({e}); save soon"));
            }
            return;
        }
        let Some(gesture) = &mut self.gesture else { return };
        if gesture.written.elapsed() < LIVE {
            return;
        }
        gesture.written = Instant::now();
        let before = gesture.before.clone();
        let change = crate::edit::change::Change::between(&before, &self.model.scene);
        if !change.is_empty() {
            self.note(&before, |journal| journal.live(change));
        }
    }

    /// What is to be done when nobody has done anything for a while: the room that edits left in the patch table goes, and
    /// what the next edit needs is made.
    pub fn rest(&mut self) {
        if self.gesture.is_some() || self.gradient.is_some() || self.solid.is_some() {
            return;
        }
        match self.model.compact() {
            Ok(_) => self.model.prepare(),
            Err(e) => self.fail(e),
        }
    }

    /// Whether a gesture goes on.
    pub fn in_gesture(&self) -> bool {
        self.gesture.is_some()
    }

    // What is seen.

    /// Handles and control mesh of the stage within the view.
    pub fn overlay(&mut self) -> &Overlay {
        let look = overlay::Look {
            stage: self.stage,
            view: self.view.seen(),
            pixel: self.view.per_point(),
            control: self.shown.control,
        };
        let fresh = self.overlay.as_ref().is_some_and(|(r, l, _)| *r == self.model.revision && *l == look);
        if !fresh {
            let m = &self.model;
            let made = overlay::overlay(&m.scene, &m.mesh, &m.refinement, &look).unwrap_or_else(|e| {
                self.message = Some(Message { text: e.to_string(), error: true });
                Overlay::default()
            });
            self.overlay = Some((self.model.revision, look, made));
        }
        &self.overlay.as_ref().expect("just made").2
    }

    /// What the selection would change: by moving, and by painting.
    pub fn influence(&mut self) -> &[Influence; 2] {
        let fresh =
            self.influence.as_ref().is_some_and(|(r, ids, _)| *r == self.model.revision && *ids == self.selection);
        if !fresh {
            // Handles of another stage stay selected, but their outlines would say nothing here.
            let level = self.stage.level();
            let ids: Vec<Id> = self.selection.iter().copied().filter(|id| id.level == level).take(200).collect();
            let m = &self.model;
            let made = crate::edit::influence::influence(&m.scene, &m.mesh, &ids).unwrap_or_default();
            self.influence = Some((self.model.revision, self.selection.clone(), made));
        }
        &self.influence.as_ref().expect("just made").2
    }

    /// Edits another mesh; what was selected is not part of it.
    pub fn set_stage(&mut self, stage: Stage) {
        if self.stage != stage {
            self.stage = stage;
            self.selection.clear();
            self.hand = Hand::default();
        }
    }

    /// Shows everything.
    pub fn fit(&mut self) {
        if let Some(solid) = &mut self.solid {
            let orbit = solid.orbit;
            solid.orbit = super::surface::Orbit { yaw: orbit.yaw, pitch: orbit.pitch, ..Default::default() };
        }
        let bounds = match &self.gradient {
            Some(gradient) => gradient.bounds(),
            None => self.model.bounds(),
        };
        if let Some(bounds) = bounds {
            self.view.fit(bounds);
        }
    }

    /// Draws the scene in another way.
    pub fn draw(&mut self, drawing: Drawing) {
        if let Err(e) = self.model.draw(drawing) {
            self.fail(e);
        }
    }
}
