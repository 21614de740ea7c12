//! A gradient mesh (BLHK18) that is being edited: its steps, its patch table, what is under the pointer, its journal.
//!
//! ```text
//!   Op --apply--> Mesh --Journal (of the mesh)--> patches touched --> LiveTable, boxes
//!    |              \--> a step back
//!    +--> journal on the disk, a step again
//! ```
//!
//! An operation costs what it touches, whatever the size of the mesh; what is under the pointer, one comparison of boxes a
//! patch.

pub mod folds;
pub mod journal;
pub mod pick;

use crate::ferguson::fit::Target;
use crate::ferguson::inherit::Continuity;
use crate::ferguson::live::{LiveTable, Update};
use crate::ferguson::mesh::{HalfEdge, Journal};
use crate::ferguson::split::Axis;
use crate::ferguson::{FergusonError, Mesh};
use crate::incremental::Changed;
use crate::patch::tess::TessRule;
use crate::patch::PatchTable;
use folds::Watch;
use glam::{DVec2, DVec4};
use journal::Keeper;
use pick::{Boxes, Pick};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, VecDeque};
use std::ops::Range;

/// Revisions whose changes are known: a step of a drag takes several back and does them anew.
const REMEMBERED: usize = 256;

/// What a step does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
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
    touched: BTreeSet<u32>,
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
    /// Grows with every change of the table.
    pub revision: u64,
    boxes: Boxes,
    done: Vec<Step>,
    undone: Vec<(Op, Continuity)>,
    gesture: Option<Step>,
    watch: Watch,
    saved_at: Option<usize>,
    live: LiveTable,
    target: Target,
    // Control points that the last revisions changed; `None`: the whole table.
    changed: VecDeque<Option<Vec<Range<usize>>>>,
    keeper: Keeper,
}

impl Gradient {
    /// The mesh that is read from a file's bytes, without steps, and the notes of the reader; `name` is what messages call
    /// the file.
    ///
    /// # Errors
    /// As [`crate::scene::ferguson::parse`].
    pub fn read(bytes: Vec<u8>, name: String) -> Result<(Gradient, Vec<String>), crate::scene::SceneError> {
        let (mesh, notes) = crate::scene::ferguson::parse(&bytes, &name)?;
        Ok((Gradient::begin(mesh, Keeper::new(String::from_utf8_lossy(&bytes).into_owned(), name)), notes))
    }

    /// A mesh without steps that is in no file.
    pub fn new(mesh: Mesh) -> Gradient {
        let text = crate::scene::ferguson::write(&mesh);
        let name = mesh.name.clone();
        // Through its own text, so that numbers are those that a reader of the journal gives.
        let mesh = crate::scene::ferguson::parse(text.as_bytes(), &name).map_or(mesh, |(mesh, _)| mesh);
        Gradient::begin(mesh, Keeper::new(text, name))
    }

    fn begin(mut mesh: Mesh, keeper: Keeper) -> Gradient {
        mesh.take_journal();
        let target = Target::default();
        Gradient {
            live: LiveTable::new(&mesh, target),
            boxes: Boxes::new(&mesh),
            mesh,
            continuity: Continuity::C1,
            twists: false,
            selected: None,
            revision: 1,
            done: Vec::new(),
            undone: Vec::new(),
            gesture: None,
            watch: Watch::default(),
            saved_at: Some(0),
            target,
            changed: VecDeque::new(),
            keeper,
        }
    }

    /// The patches as a view of `unit` scene units a pixel needs them: of another view, those with T-sections, or all where
    /// some have to be virtually subdivided.
    pub fn look(&mut self, rule: TessRule, unit: f64, seen: [f64; 4]) {
        let rule = if let TessRule::Base(_) = rule { TessRule::Pixels(6.0) } else { rule };
        let target = Target { rule, scale: [1.0 / unit; 2], view: Some(seen) };
        if target != self.target {
            self.target = target;
            let large = self.boxes.large(seen, |size| target.may_be_cut(size));
            let update = self.live.retarget(&self.mesh, target, &large);
            self.take(update);
        }
    }

    /// The table as of the last look and edit.
    pub fn table(&self) -> &PatchTable {
        self.live.table()
    }

    /// What of the table changed since a revision; `None`: all.
    pub fn changed_since(&self, revision: u64) -> Option<Changed> {
        let steps = usize::try_from(self.revision.checked_sub(revision)?).ok()?;
        let skipped = self.changed.len().checked_sub(steps)?;
        let mut all = BTreeSet::new();
        for changed in self.changed.iter().skip(skipped) {
            all.extend(changed.as_ref()?.iter().cloned().flatten());
        }
        Some(Changed { control: all.into_iter().map(|i| i as u32).collect(), indices: Vec::new() })
    }

    fn follow(&mut self, touched: &BTreeSet<u32>) {
        let update = self.live.update(&self.mesh, touched);
        self.take(update);
        self.boxes.follow(&self.mesh, touched);
    }

    fn take(&mut self, update: Update) {
        if self.changed.len() == REMEMBERED {
            self.changed.pop_front();
        }
        self.changed.push_back((!update.whole).then_some(update.control));
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
        Ok(Step { op, continuity, journal, touched })
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
        self.keeper.step(step.op, step.continuity);
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
        if let Some(step) = self.gesture.take() {
            self.take_back(step.journal);
        }
        self.gesture = Some(self.apply(op, self.continuity)?);
        Ok(())
    }

    /// Ends the gesture, which is one step.
    pub fn commit(&mut self) {
        self.watch = Watch::default();
        if let Some(step) = self.gesture.take() {
            self.push(step);
        }
    }

    /// Gives the gesture up.
    pub fn cancel(&mut self) {
        self.watch = Watch::default();
        if let Some(step) = self.gesture.take() {
            self.take_back(step.journal);
            self.keeper.gave_up();
        }
    }

    /// Whether a gesture goes on.
    pub fn in_gesture(&self) -> bool {
        self.gesture.is_some()
    }

    /// Takes a step back, or does it again; its name.
    pub fn step(&mut self, forward: bool) -> Option<&'static str> {
        self.cancel();
        self.selected = None;
        let label = if forward {
            let (op, continuity) = self.undone.pop()?;
            let step = self.apply(op, continuity).ok()?;
            self.done.push(step);
            op.label()
        } else {
            let step = self.done.pop()?;
            self.undone.push((step.op, step.continuity));
            self.take_back(step.journal);
            step.op.label()
        };
        self.keeper.moved(forward);
        Some(label)
    }

    /// Whether the mesh differs from its file.
    pub fn unsaved(&self) -> bool {
        self.gesture.is_some() || self.saved_at != Some(self.done.len())
    }

    /// It is on the disk as it is.
    pub fn saved(&mut self) {
        self.saved_at = Some(self.done.len());
        self.keeper.end();
    }

    /// Steps that can be undone.
    pub fn steps(&self) -> usize {
        self.done.len()
    }

    /// The rectangle around all control points and handles.
    pub fn bounds(&self) -> Option<[f64; 4]> {
        self.boxes.bounds()
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
