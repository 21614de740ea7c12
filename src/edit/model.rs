//! A scene with everything that follows from it.

use super::place::{exact_limit, finest, limit_in};
use super::EditError;
use crate::incremental::{delta, fits, follow, Changed, Delta, Index, Kept, Touched, ValueEdit, Whole};
use crate::mesh::{self, HalfEdgeMesh, ShapeNote};
use crate::patch::build::build;
use crate::patch::points::Irregular;
use crate::patch::PatchTable;
use crate::refine::{fate, refine, Mode, Options, Refinement, Rules};
use crate::scene::Scene;
use crate::subdiv::index_map::Slot;
use glam::DVec2;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// How the scene is turned into patches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawing {
    /// Adaptive or global.
    pub mode: Mode,
    /// What draws irregular faces.
    pub irregular: Irregular,
}

impl Default for Drawing {
    fn default() -> Self {
        Drawing { mode: ADAPTIVE, irregular: Irregular::Gregory }
    }
}

/// A scene, its mesh, levels and patches.
pub struct Model {
    /// What the user edits.
    pub scene: Scene,
    /// Its polygons as half-edges.
    pub mesh: HalfEdgeMesh,
    /// Adaptive levels: where the surface and its handles are, whatever is drawn.
    pub refinement: Refinement,
    /// What is drawn.
    pub table: PatchTable,
    /// Faces whose shape asks for trouble.
    pub notes: Vec<ShapeNote>,
    /// How the table was made.
    pub drawing: Drawing,
    /// Rises with every change of the scene or of the drawing.
    pub revision: u64,
    /// Wall time of the last refinement and of the last patch table.
    pub times: [Duration; 2],
    /// Ways back from edits to the patches of the adaptive levels, once an edit was followed in place.
    index: Option<Index>,
    /// In other modes, what is drawn.
    aside: Option<Aside>,
    /// What the latest revisions changed in place, the last one last.
    steps: VecDeque<(u64, Changed)>,
}

/// What is drawn in another mode than that of the levels in which handles are found.
struct Aside {
    /// Levels of [`Model::table`].
    refinement: Refinement,
    /// Ways back from edits to its patches, once an edit was followed in place.
    index: Option<Index>,
    /// The adaptive levels' own table, which nobody sees. Empty until an edit is followed in place.
    unseen: PatchTable,
}

const ADAPTIVE: Mode = Mode::Adaptive { isolate: 0 };

/// Revisions whose changes are remembered, for whoever has seen one of them.
const STEPS: usize = 16;

impl Model {
    /// Builds everything.
    ///
    /// # Errors
    /// The polygons form no mesh, or an edit does not fit it.
    pub fn new(scene: Scene, drawing: Drawing) -> Result<Model, EditError> {
        let mesh = mesh::build(&scene.mesh)?;
        let mut model = Model {
            notes: mesh::shape_notes(&mesh),
            refinement: adaptive(&scene, &mesh)?,
            scene,
            mesh,
            table: PatchTable::default(),
            drawing,
            revision: 0,
            times: [Duration::ZERO; 2],
            index: None,
            aside: None,
            steps: VecDeque::new(),
        };
        model.draw(drawing)?;
        Ok(model)
    }

    /// Takes another scene, and everything that follows: in place where that can be done
    /// ([`crate::incremental`]). After an error the model is as it was.
    ///
    /// # Errors
    /// As [`Model::new`].
    pub fn set(&mut self, scene: Scene) -> Result<(), EditError> {
        if self.follow(&scene) {
            self.scene = scene;
            self.revision += 1;
            return Ok(());
        }
        self.rebuild(scene)
    }

    /// Follows what changes in place; `false` where that cannot be done.
    fn follow(&mut self, scene: &Scene) -> bool {
        if self.table.faces.is_empty() || self.has_room(Index::is_fragmented) {
            return false;
        }
        let Some(delta) = delta(&self.scene, scene).filter(|delta| fits(delta, &self.mesh)) else { return false };
        let Model { scene: own, mesh, refinement, table, index, aside, drawing, .. } = self;
        let Drawing { irregular, mode } = *drawing;
        let done = match aside {
            None => step(index, Kept { scene: own, mesh, refinement, table, irregular, mode }, &delta),
            Some(Aside { refinement: drawn, index: of_drawn, unseen }) => {
                // The levels in which handles are found take the same step from where the scene was.
                if unseen.faces.is_empty() {
                    *unseen = build(refinement, irregular);
                }
                let (scene, its_mesh) = (&mut own.clone(), &mut mesh.clone());
                let first = Kept { scene, mesh: its_mesh, refinement, table: unseen, irregular, mode: ADAPTIVE };
                let then = Kept { scene: own, mesh, refinement: drawn, table, irregular, mode };
                step(index, first, &delta).and_then(|_| step(of_drawn, then, &delta))
            }
        };
        let Ok(touched) = done else {
            // The levels are half-way, what is drawn of them too; the mesh may have its new positions.
            self.index = None;
            self.notes = mesh::shape_notes(&self.mesh);
            return false;
        };
        if delta.values.iter().any(|e| matches!(e, ValueEdit::Position(..))) {
            self.notes = mesh::shape_notes(&self.mesh);
        }
        self.times = touched.times;
        self.steps.push_back((self.revision + 1, touched.changed));
        if self.steps.len() > STEPS {
            self.steps.pop_front();
        }
        true
    }

    /// Builds everything anew, if edits have left room in the table that is worth it; whether it was. For times when
    /// nobody waits: takes a rebuild, and makes all that the next edit needs.
    ///
    /// # Errors
    /// As [`Model::new`]; but the scene was built before.
    pub fn compact(&mut self) -> Result<bool, EditError> {
        if !self.has_room(Index::is_loose) {
            return Ok(false);
        }
        self.rebuild(self.scene.clone())?;
        self.prepare();
        Ok(true)
    }

    /// Makes what the first edit in place would otherwise have to wait for, unless it is there. Linear in the levels.
    pub fn prepare(&mut self) {
        if self.index.is_some() || self.table.faces.is_empty() {
            return;
        }
        let Model { scene, mesh, refinement, table, aside, drawing, .. } = self;
        let ready = |refinement, table, mode| Some(Index::ready(scene, mesh, refinement, table, mode));
        self.index = match aside {
            None => ready(refinement, table, drawing.mode),
            Some(aside) => {
                aside.unseen = build(refinement, drawing.irregular);
                aside.index = ready(&mut aside.refinement, table, drawing.mode);
                ready(refinement, &mut aside.unseen, ADAPTIVE)
            }
        };
    }

    /// Whether one of the tables has much room that edits left.
    fn has_room(&self, much: impl Fn(&Index, &PatchTable) -> bool) -> bool {
        let adaptive = self.aside.as_ref().map_or(&self.table, |aside| &aside.unseen);
        let drawn = self.aside.as_ref().and_then(|aside| aside.index.as_ref());
        self.index.as_ref().is_some_and(|index| much(index, adaptive))
            || drawn.is_some_and(|index| much(index, &self.table))
    }

    /// What of the table differs from that of an earlier revision; `None` where all may, or it is too long ago.
    pub fn changed_since(&self, revision: u64) -> Option<Changed> {
        let newer = self.steps.iter().filter(|s| s.0 > revision);
        if newer.clone().count() as u64 != self.revision.checked_sub(revision)? {
            return None;
        }
        Some(Changed::together(newer.map(|s| &s.1)))
    }

    fn rebuild(&mut self, scene: Scene) -> Result<(), EditError> {
        let same = scene.mesh.corners == self.scene.mesh.corners && scene.mesh.face_start == self.scene.mesh.face_start;
        let mut mesh = if same { self.mesh.clone() } else { mesh::build(&scene.mesh)? };
        if same {
            mesh.positions.clone_from(&scene.mesh.positions);
        }
        let start = Instant::now();
        let refinement = adaptive(&scene, &mesh)?;
        let refined = Instant::now();
        let made = match self.drawing.mode {
            ADAPTIVE => None,
            mode => Some(refine(&scene, &mesh, Options { rules: Rules::Gradtess, mode })?),
        };
        let shown = Instant::now();
        self.table = build(made.as_ref().unwrap_or(&refinement), self.drawing.irregular);
        // The time of what is drawn; the other is there for the handles.
        let refining = if made.is_some() { shown - refined } else { refined - start };
        self.times = [refining, shown.elapsed()];
        if !same || self.scene.mesh.positions != scene.mesh.positions {
            self.notes = mesh::shape_notes(&mesh);
        }
        (self.scene, self.mesh, self.refinement) = (scene, mesh, refinement);
        let aside = |refinement| Aside { refinement, index: None, unseen: PatchTable::default() };
        (self.index, self.aside) = (None, made.map(aside));
        self.steps.clear();
        self.revision += 1;
        Ok(())
    }

    /// The same scene drawn adaptively, as a model to try edits on. Linear in the levels, which are not made anew.
    pub fn to_try(&self) -> Model {
        let r = &self.refinement;
        let refinement = Refinement { levels: r.levels.clone(), fates: r.fates.clone(), ..*r };
        Model {
            scene: self.scene.clone(),
            mesh: self.mesh.clone(),
            table: match &self.aside {
                None => self.table.clone(),
                Some(Aside { unseen, .. }) if !unseen.faces.is_empty() => unseen.clone(),
                Some(_) => build(&refinement, self.drawing.irregular),
            },
            refinement,
            notes: Vec::new(),
            drawing: Drawing { mode: ADAPTIVE, ..self.drawing },
            revision: 0,
            times: [Duration::ZERO; 2],
            // Once it is there, levels and table may stand in an order that none can be made of.
            index: self.index.clone(),
            aside: None,
            steps: VecDeque::new(),
        }
    }

    /// Limit point of the vertex that `slot` of M^`level` leaves: [`exact_limit`] but for rounding, from the levels at
    /// hand where they have the vertex.
    ///
    /// # Errors
    /// As [`exact_limit`].
    pub fn limit(&self, level: u32, slot: Slot) -> Result<DVec2, EditError> {
        let own = || {
            let at = self.refinement.levels.get(level as usize)?;
            let h = match level {
                0 => slot as u32,
                _ => 4 * self.refinement.find(level, slot >> 2)? + (slot & 3) as u32,
            };
            // Faces that are drawn have all that their corners depend on; what lies around them may not.
            let drawn = self.refinement.fates[level as usize][at.face_of(h) as usize] & fate::DRAWN != 0;
            drawn.then_some((level as usize, h))
        };
        match finest(&self.refinement, level, slot).or_else(own) {
            Some((l, h)) => Ok(limit_in(&self.refinement.levels[l], h, self.scene.corners)),
            None => Ok(exact_limit(&self.scene, &self.mesh, level, slot)?),
        }
    }

    /// Rectangle x0, y0, x1, y1 around all control points, which is around the surface; `None` without patches.
    pub fn bounds(&self) -> Option<[f64; 4]> {
        let mut b = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for p in &self.table.control {
            b = [b[0].min(p[0]), b[1].min(p[1]), b[2].max(p[0]), b[3].max(p[1])];
        }
        (b[0] <= b[2]).then_some(b)
    }

    /// Draws the same scene in another way.
    ///
    /// # Errors
    /// A global level that is too large.
    pub fn draw(&mut self, drawing: Drawing) -> Result<(), EditError> {
        let before = std::mem::replace(&mut self.drawing, drawing);
        let done = self.rebuild(self.scene.clone());
        if done.is_err() {
            self.drawing = before;
        }
        done
    }
}

/// Follows an edit in some levels and their table.
fn step(index: &mut Option<Index>, mut kept: Kept, delta: &Delta) -> Result<Touched, Whole> {
    let Kept { scene, mesh, refinement, table, .. } = &mut kept;
    let index = index.get_or_insert_with(|| Index::new(scene, mesh, refinement, table));
    follow(index, &mut kept, delta)
}

fn adaptive(scene: &Scene, mesh: &HalfEdgeMesh) -> Result<Refinement, EditError> {
    Ok(refine(scene, mesh, Options::default())?)
}
