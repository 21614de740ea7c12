//! A gradient mesh (BLHK18) that is open in the editor: its steps, its patch table, and what is under the pointer.

use crate::ferguson::fit::Target;
use crate::ferguson::inherit::Continuity;
use crate::ferguson::live::LiveTable;
use crate::ferguson::mesh::{HalfEdge, Journal};
use crate::ferguson::split::Axis;
use crate::ferguson::{FergusonError, Mesh};
use crate::patch::tess::TessRule;
use crate::patch::PatchTable;
use glam::{DVec2, DVec4};
use std::collections::BTreeSet;

/// What can be selected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pick {
    /// A control point.
    Point(u32),
    /// A handle of a curve, at its end 0 or 1.
    Handle(u32, usize),
    /// The twist of a corner.
    Twist(HalfEdge),
    /// The colour of a corner.
    Sector(HalfEdge),
    /// A curve.
    Curve(u32),
}

/// What a step does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Op {
    /// [`Mesh::move_point`].
    Point(u32, DVec2),
    /// [`Mesh::move_handle`].
    Handle(u32, usize, DVec2),
    /// [`Mesh::set_twist`].
    Twist(HalfEdge, DVec2),
    /// [`Mesh::set_colour`], in the mesh's space.
    Colour(u32, DVec4),
    /// [`Mesh::set_sector_colour`], in the mesh's space.
    Sector(HalfEdge, DVec4),
    /// [`Mesh::split`].
    Split(u32, Axis, f64),
    /// [`Mesh::remove_split`].
    Remove(u32),
}

impl Op {
    fn label(&self) -> &'static str {
        match self {
            Op::Point(..) => "move point",
            Op::Handle(..) => "move handle",
            Op::Twist(..) => "move twist",
            Op::Colour(..) => "colour",
            Op::Sector(..) => "sector colour",
            Op::Split(..) => "split",
            Op::Remove(_) => "remove split",
        }
    }
}

/// A step: taken back by its journal, done again by its operation.
struct Step {
    op: Op,
    continuity: Continuity,
    journal: Journal,
}

/// The mesh and what follows from it.
pub struct Gradient {
    /// The mesh.
    pub mesh: Mesh,
    /// Whether handles mirror each other.
    pub continuity: Continuity,
    /// Whether twists are shown.
    pub twists: bool,
    /// What is selected.
    pub selected: Option<Pick>,
    /// What the pointer holds, and from the pointer to it.
    pub held: Option<(Pick, DVec2)>,
    /// Grows with every change of the table.
    pub revision: u64,
    done: Vec<Step>,
    undone: Vec<(Op, Continuity)>,
    gesture: Option<Step>,
    saved_at: Option<usize>,
    live: LiveTable,
    target: Target,
    // Control points that the last revision changed; `None`: the whole table.
    changed: Option<Vec<u32>>,
}

impl Gradient {
    /// A mesh without steps.
    pub fn new(mut mesh: Mesh) -> Gradient {
        mesh.take_journal();
        let target = Target::default();
        Gradient {
            live: LiveTable::new(&mesh, target),
            mesh,
            continuity: Continuity::C1,
            twists: false,
            selected: None,
            held: None,
            revision: 1,
            done: Vec::new(),
            undone: Vec::new(),
            gesture: None,
            saved_at: Some(0),
            target,
            changed: None,
        }
    }

    /// The patches as a view of `unit` scene units a pixel needs them; made anew when the view is another.
    pub fn look(&mut self, rule: TessRule, unit: f64, seen: [f64; 4]) {
        let rule = if let TessRule::Base(_) = rule { TessRule::Pixels(6.0) } else { rule };
        let target = Target { rule, scale: [1.0 / unit; 2], view: Some(seen) };
        if target != self.target {
            self.target = target;
            self.live = LiveTable::new(&self.mesh, target);
            self.revision += 1;
            self.changed = None;
        }
    }

    /// The table as of the last look and edit.
    pub fn table(&self) -> &PatchTable {
        self.live.table()
    }

    /// Control points changed since a revision; `None`: all.
    pub fn changed_since(&self, revision: u64) -> Option<Vec<u32>> {
        if revision + 1 == self.revision {
            self.changed.clone()
        } else {
            None
        }
    }

    fn follow(&mut self, touched: &BTreeSet<u32>) {
        let counts = |table: &PatchTable| table.ranges.iter().map(|r| r.count).collect::<Vec<_>>();
        let before = counts(self.live.table());
        let update = self.live.update(&self.mesh, touched);
        let whole = update.whole || counts(self.live.table()) != before;
        self.changed = (!whole).then(|| update.control.into_iter().flatten().map(|i| i as u32).collect());
        self.revision += 1;
    }

    fn apply(&mut self, op: Op, continuity: Continuity) -> Result<Step, FergusonError> {
        let mesh = &mut self.mesh;
        let done = match op {
            Op::Point(p, to) => mesh.move_point(p, to, continuity),
            Op::Handle(c, end, to) => mesh.move_handle(c, end, to, continuity),
            Op::Twist(h, twist) => mesh.set_twist(h, twist, continuity),
            Op::Colour(p, colour) => mesh.set_colour(p, colour, continuity),
            Op::Sector(h, colour) => mesh.set_sector_colour(h, colour, continuity),
            Op::Split(p, axis, at) => mesh.split(p, axis, at).map(drop),
            Op::Remove(c) => mesh.remove_split(c).map(drop),
        };
        let journal = mesh.take_journal();
        if let Err(e) = done {
            mesh.undo(journal);
            return Err(e);
        }
        let touched = journal.touched(mesh);
        self.follow(&touched);
        Ok(Step { op, continuity, journal })
    }

    fn take_back(&mut self, journal: Journal) {
        let touched = journal.touched(&self.mesh);
        self.mesh.undo(journal);
        self.follow(&touched);
    }

    fn push(&mut self, step: Step) {
        if self.saved_at.is_some_and(|at| at > self.done.len()) {
            self.saved_at = None;
        }
        self.undone.clear();
        self.done.push(step);
    }

    /// Does something in one step.
    ///
    /// # Errors
    /// As the operation; the mesh is as it was.
    pub fn act(&mut self, op: Op) -> Result<(), FergusonError> {
        self.commit();
        let step = self.apply(op, self.continuity)?;
        self.push(step);
        Ok(())
    }

    /// Does something as part of a gesture, in place of what the gesture did before.
    ///
    /// # Errors
    /// As the operation; the gesture has then done nothing.
    pub fn during(&mut self, op: Op) -> Result<(), FergusonError> {
        self.cancel();
        self.gesture = Some(self.apply(op, self.continuity)?);
        Ok(())
    }

    /// Drags a thing to a place, as part of a gesture.
    ///
    /// # Errors
    /// As the operation.
    pub fn drag(&mut self, pick: Pick, to: DVec2) -> Result<(), FergusonError> {
        match self.moving(pick, to) {
            Some(op) => self.during(op),
            None => Ok(()),
        }
    }

    /// Ends the gesture, which is one step.
    pub fn commit(&mut self) {
        if let Some(step) = self.gesture.take() {
            self.push(step);
        }
    }

    /// Gives the gesture up.
    pub fn cancel(&mut self) {
        if let Some(step) = self.gesture.take() {
            self.take_back(step.journal);
        }
    }

    /// Takes a step back, or does it again; its name.
    pub fn step(&mut self, forward: bool) -> Option<&'static str> {
        self.cancel();
        self.held = None;
        self.selected = None;
        if forward {
            let (op, continuity) = self.undone.pop()?;
            let step = self.apply(op, continuity).ok()?;
            self.done.push(step);
            Some(op.label())
        } else {
            let step = self.done.pop()?;
            self.undone.push((step.op, step.continuity));
            self.take_back(step.journal);
            Some(step.op.label())
        }
    }

    /// Whether the mesh differs from its file.
    pub fn unsaved(&self) -> bool {
        self.gesture.is_some() || self.saved_at != Some(self.done.len())
    }

    /// It is on the disk as it is.
    pub fn saved(&mut self) {
        self.saved_at = Some(self.done.len());
    }

    /// Steps that can be undone.
    pub fn steps(&self) -> usize {
        self.done.len()
    }

    /// The rectangle around all control points of the geometry.
    pub fn bounds(&self) -> Option<[f64; 4]> {
        let mut b = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for p in self.mesh.live().flat_map(|p| self.mesh.geometry(p)) {
            b = [b[0].min(p.x), b[1].min(p.y), b[2].max(p.x), b[3].max(p.y)];
        }
        (b[0] <= b[2]).then_some(b)
    }

    /// Where a thing is shown. A twist is the inner Bezier point that it moves.
    pub fn place(&self, pick: Pick) -> DVec2 {
        match pick {
            Pick::Point(p) => self.mesh.at(p),
            Pick::Handle(c, end) => self.mesh.curve(c).handles[end],
            Pick::Twist(h) => self.mesh.geometry(h.patch())[[5, 6, 10, 9][h.side()]],
            Pick::Sector(h) => {
                let [u, v] = [[0.12, 0.12], [0.88, 0.12], [0.88, 0.88], [0.12, 0.88]][h.side()];
                self.mesh.evaluate(h.patch(), u, v).0
            }
            Pick::Curve(c) => crate::ferguson::hermite::point(self.mesh.bezier(c), 0.5),
        }
    }

    /// The operation that brings a thing to a place; `None`: it cannot be moved.
    pub fn moving(&self, pick: Pick, to: DVec2) -> Option<Op> {
        match pick {
            Pick::Point(p) => Some(Op::Point(p, to)),
            Pick::Handle(c, end) => Some(Op::Handle(c, end, to)),
            Pick::Twist(h) => {
                let sign = if h.side() % 2 == 0 { 9.0 } else { -9.0 };
                let change = (to - self.place(pick)) * sign;
                Some(Op::Twist(h, self.mesh.corner(h).twist + change))
            }
            Pick::Sector(_) | Pick::Curve(_) => None,
        }
    }

    /// Points and handles of what is drawn, twists and sectors where they are shown.
    pub fn picks(&self) -> Vec<Pick> {
        let mut all = Vec::new();
        let used = |p: &u32| !self.mesh.points[*p as usize].corners.is_empty();
        all.extend(self.sectors().into_iter().map(Pick::Sector));
        all.extend((0..self.mesh.points.len() as u32).filter(used).map(Pick::Point));
        all.extend(self.curves().flat_map(|c| [Pick::Handle(c, 0), Pick::Handle(c, 1)]));
        if self.twists {
            all.extend(self.mesh.live().flat_map(|p| [0, 1, 2, 3].map(|i| Pick::Twist(HalfEdge::new(p, i)))));
        }
        all
    }

    /// Curves that are drawn.
    pub fn curves(&self) -> impl Iterator<Item = u32> + '_ {
        let used = |c: &u32| self.mesh.curves[*c as usize].sides.iter().any(|list| !list.is_empty());
        (0..self.mesh.curves.len() as u32).filter(used)
    }

    /// Corners around the point that is selected.
    pub fn sectors(&self) -> Vec<HalfEdge> {
        let point = match self.selected {
            Some(Pick::Point(p)) => p,
            Some(Pick::Sector(h)) => self.mesh.corner(h).point,
            _ => return Vec::new(),
        };
        self.mesh.points[point as usize].corners.clone()
    }

    /// What is within `reach` of a place: the nearest of the picks, else the nearest curve.
    pub fn at(&self, at: DVec2, reach: f64) -> Option<Pick> {
        let mut best = (reach, None);
        for pick in self.picks() {
            let far = self.place(pick).distance(at);
            if far < best.0 {
                best = (far, Some(pick));
            }
        }
        if best.1.is_some() {
            return best.1;
        }
        for c in self.curves() {
            let q = self.mesh.bezier(c);
            for k in 0..=32 {
                let far = crate::ferguson::hermite::point(q, f64::from(k) / 32.0).distance(at);
                if far < best.0 {
                    best = (far, Some(Pick::Curve(c)));
                }
            }
        }
        best.1
    }

    /// The topmost patch at a place, with its parameters there.
    pub fn patch_at(&self, at: DVec2) -> Option<(u32, f64, f64)> {
        let mut found = None;
        for p in self.mesh.live() {
            let net = self.mesh.geometry(p);
            let (low, high) = net.iter().fold((net[0], net[0]), |(l, h), q| (l.min(*q), h.max(*q)));
            if at.cmplt(low).any() || at.cmpgt(high).any() {
                continue;
            }
            let place = |u: f64, v: f64| crate::ferguson::mesh::tensor(&net, u, v);
            let grid = (0..81).map(|k| (f64::from(k % 9) / 8.0, f64::from(k / 9) / 8.0));
            let near = |x: &(f64, f64)| place(x.0, x.1).distance_squared(at);
            let Some((mut u, mut v)) = grid.min_by(|a, b| near(a).total_cmp(&near(b))) else { continue };
            for _ in 0..20 {
                let e = 1e-6;
                let du = (place(u + e, v) - place(u - e, v)) / (2.0 * e);
                let dv = (place(u, v + e) - place(u, v - e)) / (2.0 * e);
                let (off, det) = (at - place(u, v), du.perp_dot(dv));
                if det.abs() < 1e-300 {
                    break;
                }
                u = (u + off.perp_dot(dv) / det).clamp(0.0, 1.0);
                v = (v + du.perp_dot(off) / det).clamp(0.0, 1.0);
            }
            if place(u, v).distance(at) < 1e-6 * (high - low).max_element() {
                found = Some((p, u, v));
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drag_is_one_step_and_steps_go_back_and_forth_exactly() {
        let mesh = Mesh::grid(2, 2, [0.0, 0.0, 1.0, 1.0], |i, j| DVec4::new(f64::from(i), f64::from(j), 0.0, 1.0));
        let mut g = Gradient::new(mesh.unwrap());
        let written = |g: &Gradient| crate::scene::ferguson::write(&g.mesh);
        let mut states = vec![written(&g)];
        let (p, u, v) = g.patch_at(DVec2::new(0.2, 0.3)).unwrap();
        assert!((u - 0.4).abs() < 1e-9 && (v - 0.6).abs() < 1e-9, "{p} {u} {v}");
        g.act(Op::Split(p, Axis::U, u)).unwrap();
        states.push(written(&g));
        let middle = g.at(DVec2::splat(0.5), 0.01).unwrap();
        for k in 1..5 {
            let to = DVec2::splat(0.5 + 0.02 * f64::from(k));
            g.during(g.moving(middle, to).unwrap()).unwrap();
        }
        g.commit();
        states.push(written(&g));
        assert_eq!(g.steps(), 2);
        let Pick::Point(point) = middle else { panic!("{middle:?}") };
        assert_eq!(g.mesh.at(point), DVec2::splat(0.58));
        let corner = g.mesh.points[point as usize].corners[0];
        g.act(Op::Sector(corner, DVec4::ONE)).unwrap();
        states.push(written(&g));
        g.saved();
        for k in (0..3).rev() {
            g.step(false).unwrap();
            assert!(written(&g) == states[k] && g.unsaved());
        }
        assert!(g.step(false).is_none());
        for state in &states[1..] {
            g.step(true).unwrap();
            assert!(written(&g) == *state);
        }
        assert!(!g.unsaved() && g.step(true).is_none());
        // The inner point of a twist goes where it is put.
        let twist = Pick::Twist(HalfEdge::new(1, 1));
        let to = g.place(twist) + DVec2::new(0.01, 0.02);
        g.act(g.moving(twist, to).unwrap()).unwrap();
        assert!(g.place(twist).distance(to) < 1e-12);
    }
}
