//! The pointer on the canvas: hover, select, move, paint, pan, zoom.

use super::editor::{Dragged, Editor, Tool};
use super::reference::sample;
use crate::edit::brush::{boxed, pick, within};
use crate::edit::drag::Drag;
use crate::edit::folds::{drag_within, shift_within, Cost, Watch};
use crate::edit::handle::{least_slot, Id, Kind, Stage};
use crate::edit::overlay::{input_edge, Handle};
use crate::edit::paint;
use crate::edit::together::Together;
use crate::subdiv::index_map::IndexMap;
use egui::{Event, InputState, Key, PointerButton, Pos2, Response, Ui};
use glam::{DVec2, DVec4};
use std::collections::{HashMap, HashSet};

/// Distance within which a handle is under the pointer, points.
pub const REACH: f32 = 9.0;

/// What the pointer holds or is over.
#[derive(Default)]
pub struct Hand {
    /// The handle under the pointer.
    pub hover: Option<Id>,
    /// The input half-edge under the pointer, with the tool for edges.
    pub edge: Option<u32>,
    /// Corner of the box that is being drawn, model coordinates.
    pub from: Option<DVec2>,
    /// Corners of the polygon that is being drawn.
    pub corners: Vec<DVec2>,
    /// What the pointer holds of a gradient mesh, and from the pointer to it.
    pub gradient: Option<(crate::edit::gradient::pick::Pick, DVec2)>,
    /// The polygon becomes a scene of its own.
    pub anew: bool,
    held: Option<Held>,
    // The handle was pressed while it was the one selected: without a move, the next one at its place is meant.
    again: bool,
}

/// Handles that are being moved.
struct Held {
    /// None while painting.
    together: Option<Together>,
    /// From the pointer to the limit point of the first.
    offset: DVec2,
    /// Where the first was last.
    at: DVec2,
    watch: Option<Watch>,
}

impl Held {
    /// The handle that the pointer is at.
    fn first(&self) -> Option<&Drag> {
        self.together.as_ref().and_then(|t| t.drags().first())
    }
}

/// Where the pointer's first button was let go in this frame: on a slow machine the last move before and the first one
/// after it may come in the same frame.
pub(super) fn released_at(input: &InputState) -> Option<Pos2> {
    input.events.iter().rev().find_map(|event| match *event {
        Event::PointerButton { pos, button: PointerButton::Primary, pressed: false, .. } => Some(pos),
        _ => None,
    })
}

impl Editor {
    /// Takes the pointer's and the wheel's part of a frame.
    pub fn pointer(&mut self, ui: &Ui, canvas: &Response) {
        self.wheel(ui, canvas);
        let (pos, down, pressed, released, modifiers, middle, space, delta) = ui.input(|i| {
            (
                i.pointer.interact_pos(),
                i.pointer.primary_down(),
                i.pointer.button_pressed(PointerButton::Primary),
                released_at(i),
                i.modifiers,
                i.pointer.button_down(PointerButton::Middle),
                i.key_down(Key::Space),
                i.pointer.delta(),
            )
        });
        let Some(pos) = pos else {
            (self.hand.hover, self.hand.edge) = (None, None);
            return;
        };
        let over = canvas.hovered() || canvas.dragged();
        if over && (middle || (space && down)) {
            self.view.pan(delta);
            return;
        }
        let at = self.view.to_model(pos);
        if !down && released.is_none() {
            self.hover(pos, over);
        }
        if pressed && canvas.hovered() {
            self.press(at, pos, modifiers.shift);
        }
        if let Some(pos) = released {
            let at = self.view.to_model(pos);
            self.drag(at);
            self.release(at, modifiers.shift);
        } else if down {
            self.drag(at);
        }
    }

    fn wheel(&mut self, ui: &Ui, canvas: &Response) {
        if !canvas.hovered() {
            return;
        }
        let size = crate::edit::drag::size_of(&self.model.scene);
        let (pos, turns, alt, pinch) = ui.input(|i| {
            let mut turns = 0.0;
            for event in &i.events {
                if let Event::MouseWheel { unit, delta, .. } = event {
                    let step = if *unit == egui::MouseWheelUnit::Point { 1.0 / 50.0 } else { 1.0 };
                    turns += (delta.y + delta.x) * step;
                }
            }
            (i.pointer.hover_pos(), turns, i.modifiers.alt, i.multi_touch().map(|t| t.zoom_delta))
        });
        let Some(pos) = pos else { return };
        if let Some(pinch) = pinch {
            self.view.zoom(f64::from(pinch), pos, size);
        }
        if turns == 0.0 {
            return;
        }
        if alt {
            self.brush.radius = (self.brush.radius * 1.1f32.powf(turns)).clamp(3.0, 1000.0);
        } else {
            self.view.zoom(1.2f64.powf(f64::from(turns)), pos, size);
        }
    }

    fn hover(&mut self, pos: Pos2, over: bool) {
        (self.hand.hover, self.hand.edge) = (None, None);
        if !over {
            return;
        }
        match self.tool {
            Tool::Move => self.hand.hover = self.handle_at(pos, false),
            Tool::Sharp => self.hand.edge = self.edge_at(pos),
            Tool::Brush | Tool::Pick | Tool::Draw => {}
        }
    }

    /// The handle under a window point; `next`: of several at one place the one after the selected.
    fn handle_at(&mut self, pos: Pos2, next: bool) -> Option<Id> {
        let at = self.view.to_model(pos);
        let reach = f64::from(REACH) * self.view.per_point();
        let current = if next && self.selection.len() == 1 { self.selection.first().copied() } else { None };
        // A single selected handle stays on top while it is only hovered over.
        let kept = self.selection.first().copied().filter(|_| self.selection.len() == 1 && !next);
        let handles = &self.overlay().handles;
        let found = pick(handles, at, reach, |_| true, current)?;
        let same = |id: Id| handles.iter().find(|h| h.id == id).map(|h| h.shown);
        match kept {
            Some(id) if same(id).is_some() && same(id) == same(found) => Some(id),
            _ => Some(found),
        }
    }

    /// The edge of the input mesh under a window point.
    fn edge_at(&mut self, pos: Pos2) -> Option<u32> {
        if self.stage.level() > 0 {
            return None;
        }
        let at = self.view.to_model(pos);
        let reach = f64::from(REACH) * self.view.per_point();
        let mut best = (reach, None);
        for edge in self.overlay().edges.iter().filter(|e| e.input) {
            for k in 0..=16 {
                let distance = cubic(&edge.curve, f64::from(k) / 16.0).distance(at);
                if distance < best.0 {
                    best = (distance, Some(edge.slot));
                }
            }
        }
        best.1.and_then(|slot| input_edge(&self.model.mesh, slot))
    }

    fn press(&mut self, at: DVec2, pos: Pos2, add: bool) {
        match self.tool {
            Tool::Move => match self.handle_at(pos, false) {
                Some(id) => self.press_handle(id, at, add),
                None => {
                    if !add {
                        self.selection.clear();
                    }
                    self.hand.from = Some(at);
                }
            },
            Tool::Brush => self.press_brush(at),
            Tool::Sharp => {
                if let Some(h) = self.edge_at(pos) {
                    let sharp = !paint::is_sharp(&self.model.scene, &self.model.mesh, h);
                    let label = if sharp { "make edge sharp" } else { "make edge smooth" };
                    self.change(label, |scene, mesh| paint::set_sharp(scene, mesh, h, sharp));
                } else {
                    self.say("edges are made sharp in the input mesh (M) and level 0; point at one");
                }
            }
            Tool::Pick => self.pick_colour(at),
            Tool::Draw => self.add_corner(at),
        }
    }

    fn press_handle(&mut self, id: Id, at: DVec2, add: bool) {
        if add {
            if !self.selection.remove(&id) {
                self.selection.insert(id);
            }
            return;
        }
        self.hand.again = self.selection.len() == 1 && self.selection.contains(&id);
        if !self.selection.contains(&id) {
            self.selection.clear();
            self.selection.insert(id);
        }
        if !id.kind.is_geometry() {
            if let Some(handle) = self.find(id) {
                self.brush.colour = handle.colour;
            }
            return;
        }
        let mut ids = vec![id];
        ids.extend(self.selection.iter().copied().filter(|s| *s != id && s.kind.is_geometry()));
        self.hold(&ids, at, "move");
    }

    /// Takes hold of handles, the first of which the pointer is at.
    fn hold(&mut self, ids: &[Id], at: DVec2, label: &str) {
        let drags: Result<Vec<Drag>, _> =
            ids.iter().map(|&id| Drag::begin(&self.model.scene, &self.model.mesh, id)).collect();
        let together = drags.and_then(|drags| Together::begin(&self.model.scene, &self.model.mesh, drags));
        match together {
            Ok(together) => {
                let start = together.drags()[0].start();
                // Where control points are shown the limit moves as the pointer does.
                let offset = start - at;
                let watch = self.prevent_folds.then(|| Watch::new(&self.model));
                self.begin(label);
                self.hand.held = Some(Held { together: Some(together), offset, at: start, watch });
            }
            Err(e) => self.fail(e),
        }
    }

    fn find(&mut self, id: Id) -> Option<Handle> {
        self.overlay().handles.iter().find(|h| h.id == id).copied()
    }

    fn press_brush(&mut self, at: DVec2) {
        let radius = f64::from(self.brush.radius) * self.view.per_point();
        if self.brush.moves {
            let near = within(&self.overlay().handles, at, radius, |id| id.kind.is_geometry());
            self.selection = near.iter().copied().collect();
            let handles = self.overlay().handles.clone();
            let nearest = near.into_iter().min_by(|a, b| {
                let far = |id: &Id| handles.iter().find(|h| h.id == *id).map_or(f64::MAX, |h| h.shown.distance(at));
                far(a).total_cmp(&far(b))
            });
            match nearest {
                Some(id) => self.hold(&[id], at, "move with brush"),
                None => self.say("no point lies under the brush"),
            }
            return;
        }
        self.selection.clear();
        self.begin("paint");
        self.hand.held = Some(Held { together: None, offset: DVec2::ZERO, at, watch: None });
        self.paint_at(at);
    }

    /// Paints every colour handle under the brush: a vertex whose sectors have one colour as a whole, one that sharp edges
    /// part sector by sector.
    fn paint_at(&mut self, at: DVec2) {
        let radius = f64::from(self.brush.radius) * self.view.per_point();
        let colour = self.brush.colour;
        let handles = self.overlay().handles.clone();
        let map = IndexMap::new(&self.model.mesh);
        let owner = |id: Id| (id.level, least_slot(&map, id.level, id.slot));
        let near = within(&handles, at, radius, |id| !id.kind.is_geometry());
        // A lone sector beside others of its colour would become a sharp corner by accident, so that sectors are painted
        // one by one only where sharp edges part them already.
        let mut first: HashMap<(u32, u64), DVec4> = HashMap::new();
        let mut parted: HashSet<(u32, u64)> = HashSet::new();
        for h in handles.iter().filter(|h| h.id.kind == Kind::Sector) {
            let owner = owner(h.id);
            if *first.entry(owner).or_insert(h.colour) != h.colour {
                parted.insert(owner);
            }
        }
        let colours: HashMap<Id, DVec4> = handles.iter().map(|h| (h.id, h.colour)).collect();
        let new: Vec<(Id, DVec4)> = near
            .into_iter()
            .filter(|id| match id.kind {
                Kind::Colour => !parted.contains(&(id.level, id.slot)),
                _ => parted.contains(&owner(*id)),
            })
            .filter(|id| !self.selection.contains(id) && colours.get(id) != Some(&colour))
            .map(|id| (id, colour))
            .collect();
        if new.is_empty() {
            return;
        }
        self.selection.extend(new.iter().map(|n| n.0));
        self.during(|scene, mesh| paint::paint(scene, mesh, &new));
    }

    fn drag(&mut self, at: DVec2) {
        let Some(held) = &self.hand.held else { return };
        let Some(first) = held.first().map(Drag::start) else {
            if held.at != at {
                self.paint_at(at);
            }
            return;
        };
        let mut target = at + held.offset;
        // A click is no drag.
        if self.view.to_window(first).distance(self.view.to_window(target)) < 0.5 && held.at == first {
            return;
        }
        target = self.snapped(target);
        let Some(held) = self.hand.held.take() else { return };
        self.hand.held = Some(self.move_held(held, target));
    }

    fn move_held(&mut self, mut held: Held, target: DVec2) -> Held {
        if target == held.at {
            return held;
        }
        let Some(together) = &held.together else { return held };
        let mut scene = self.model.scene.clone();
        let alone = if together.drags().len() == 1 { together.drags().first() } else { None };
        let start = together.drags()[0].start();
        let done = match &mut held.watch {
            Some(watch) => {
                let mut cost = Cost::default();
                // A hundredth of a pixel.
                let tolerance = 0.01 * self.view.unit;
                let ways = [held.at, target];
                let done = match alone {
                    Some(drag) => drag_within(watch, drag, &self.model, &mut scene, ways, tolerance, &mut cost),
                    None => shift_within(watch, together, &self.model, &mut scene, ways, tolerance, &mut cost),
                };
                self.fold_cost = cost;
                done
            }
            None => match alone {
                Some(drag) => drag.to(&mut scene, &self.model.mesh, target).map(|_| target),
                None => {
                    together.shift(&mut scene, &self.model.mesh, target - start);
                    Ok(target)
                }
            },
        };
        match done {
            Ok(at) => {
                held.at = at;
                if at == target {
                    self.message = self.message.take().filter(|m| !m.text.starts_with("stopped"));
                } else {
                    self.say("stopped: a patch would fold over");
                }
                self.replace(scene);
            }
            Err(e) => self.fail(e),
        }
        held
    }

    /// A place on the grid, or at another point, where that is wanted.
    pub fn snapped(&mut self, target: DVec2) -> DVec2 {
        if self.shown.snap_points {
            let reach = f64::from(REACH) * self.view.per_point();
            let moving: Vec<Id> = self.selection.iter().copied().collect();
            let near = self.overlay().handles.iter().filter(|h| h.id.kind.is_geometry() && !moving.contains(&h.id));
            let best = near.map(|h| h.at).min_by(|a, b| a.distance(target).total_cmp(&b.distance(target)));
            if let Some(at) = best.filter(|at| at.distance(target) <= reach) {
                return at;
            }
        }
        if self.shown.grid > 0.0 {
            return (target / self.shown.grid).round() * self.shown.grid;
        }
        target
    }

    fn release(&mut self, at: DVec2, add: bool) {
        if let Some(from) = self.hand.from.take() {
            let least = 3.0 * self.view.per_point();
            if from.distance(at) > least {
                let inside = boxed(&self.overlay().handles, from, at, |id| id.kind != Kind::Sector);
                if !add {
                    self.selection.clear();
                }
                self.selection.extend(inside);
            }
        }
        let still = self.hand.held.as_ref().is_none_or(|h| h.first().is_some_and(|d| d.start() == h.at));
        if std::mem::take(&mut self.hand.again) && still {
            let pos = self.view.to_window(at);
            if let Some(next) = self.handle_at(pos, true) {
                self.selection = [next].into();
            }
        }
        if let Some(held) = self.hand.held.take() {
            if let Some(drag) = held.first() {
                self.dragged.push(Dragged { handle: drag.id(), at: held.at });
            }
            self.commit();
        }
    }

    /// Moves the selected points by pixels, as the arrow keys do.
    pub fn nudge(&mut self, by: DVec2) {
        let step = by * self.view.unit;
        let ids: Vec<Id> = self.selection.iter().copied().filter(|id| id.kind.is_geometry()).collect();
        let Some(&first) = ids.first() else {
            self.say("select points first");
            return;
        };
        let at = match Drag::begin(&self.model.scene, &self.model.mesh, first) {
            Ok(drag) => drag.start(),
            Err(e) => return self.fail(e),
        };
        self.hold(&ids, at, "nudge");
        if let Some(held) = self.hand.held.take() {
            let held = self.move_held(held, at + step);
            self.dragged.push(Dragged { handle: first, at: held.at });
            self.commit();
        }
    }

    /// Takes the colour under the pointer, for the brush and all selected colour handles.
    fn pick_colour(&mut self, at: DVec2) {
        let Some(colour) = self.colour_under(at) else {
            self.say("there is no colour");
            return;
        };
        self.brush.colour = colour;
        self.paint_selected(colour);
    }

    /// Colour of the surface, or of the reference picture where there is none or it lies above.
    pub fn colour_under(&mut self, at: DVec2) -> Option<DVec4> {
        let look = self.look;
        if let Some(renderer) = &mut self.renderer {
            match renderer.colour_at(&self.view, &look, at) {
                Ok(Some(c)) => return Some(DVec4::from(c.map(f64::from)).clamp(DVec4::ZERO, DVec4::ONE)),
                Ok(None) => {}
                Err(e) => self.fail(e),
            }
        }
        sample(&self.model.scene, &self.reference, at)
    }

    /// Gives all selected colour handles a colour.
    pub fn paint_selected(&mut self, colour: DVec4) -> bool {
        let ids: Vec<(Id, DVec4)> =
            self.selection.iter().filter(|id| !id.kind.is_geometry()).map(|&id| (id, colour)).collect();
        !ids.is_empty() && self.change("paint", |scene, mesh| paint::paint(scene, mesh, &ids))
    }

    /// Gives each selected colour handle, or each one seen when none is selected, the reference picture's colour under it.
    pub fn pick_under_all(&mut self) {
        let any = self.selection.iter().any(|id| id.kind == Kind::Colour);
        let chosen = self.selection.clone();
        let handles: Vec<Handle> =
            self.overlay().handles.iter().filter(|h| h.id.kind == Kind::Colour).copied().collect();
        let colours: Vec<(Id, DVec4)> = handles
            .iter()
            .filter(|h| !any || chosen.contains(&h.id))
            .filter_map(|h| Some((h.id, sample(&self.model.scene, &self.reference, h.at)?)))
            .collect();
        if colours.is_empty() {
            self.say("no colour handle lies over the reference picture");
        } else {
            self.change("pick colours under handles", |scene, mesh| paint::paint(scene, mesh, &colours));
        }
    }

    /// Selects everything that is shown.
    pub fn select_all(&mut self) {
        let all: Vec<Id> = self.overlay().handles.iter().map(|h| h.id).filter(|id| id.kind != Kind::Sector).collect();
        self.selection = all.into_iter().collect();
    }

    /// Selects the handle after the selected one.
    pub fn select_next(&mut self) {
        let all: Vec<Id> = self.overlay().handles.iter().map(|h| h.id).collect();
        let at = self.selection.first().and_then(|id| all.iter().position(|i| i == id)).map_or(0, |i| i + 1);
        if let Some(&id) = all.get(at % all.len().max(1)) {
            self.selection = [id].into();
        }
    }

    /// Takes the selected points' edits and colours away.
    pub fn reset_selected(&mut self) {
        let ids: Vec<Id> = self.selection.iter().copied().collect();
        let stage = self.stage;
        self.change("reset", |scene, mesh| {
            let mut any = false;
            for id in ids {
                any |= match id.kind {
                    Kind::Colour | Kind::Sector => paint::unpaint(scene, mesh, id),
                    _ => crate::edit::drag::reset(scene, mesh, id),
                };
            }
            match (any, stage) {
                (true, _) => Ok(()),
                (false, Stage::Input) => Err(crate::edit::EditError::Refused(
                    "there is nothing to reset; vertices of M are deleted under Model".into(),
                )),
                (false, _) => Err(crate::edit::EditError::Refused("the selected handles have no edits".into())),
            }
        });
    }
}

/// Point of a cubic.
pub fn cubic(p: &[DVec2; 4], t: f64) -> DVec2 {
    let w = crate::patch::eval::bernstein(1.0 - t, t);
    p[0] * w[0] + p[1] * w[1] + p[2] * w[2] + p[3] * w[3]
}
