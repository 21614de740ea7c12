//! Fold-over prevention (ZHHK22 5.2, GD01): a drag stops where a drawn patch would turn over.
//!
//! The paper tests a bicubic in place of each Gregory patch. Here every patch is tested as what it is
//! ([`crate::check::folds`]): first the sufficient test of GD01, then the Jacobian's sign all over the patch. What
//! stays undecided counts as folded, so that nothing is let through that folds.

use super::drag::Drag;
use super::handle::Id;
use super::model::Model;
use super::together::Together;
use super::EditError;
use crate::check::folds::{base_face, gd01, jacobian_sign, orientations, JacobianSign};
use crate::patch::build::face_control;
use crate::patch::{ControlPoint, Face, PatchTable};
use crate::scene::Scene;
use glam::DVec2;
use std::collections::{BTreeSet, HashMap};
use std::time::{Duration, Instant};

/// Rectangles that the Jacobian test may cut a patch into.
const RECTANGLES: usize = 1000;

/// The patches at the beginning of a gesture, of which those that were folded may stay so, and a model on which edits are
/// tried. It follows them in place ([`crate::incremental`]), and a try looks only at patches that changed since they were
/// last found sound.
pub struct Watch {
    tried: Model,
    /// Revision of the tried model up to which changes are marked.
    marked: u64,
    start: PatchTable,
    /// Faces of the start by level and name.
    known: HashMap<(u32, u64), u32>,
    /// Whether a face of the start was folded, as far as anybody asked.
    folded: HashMap<u32, bool>,
    orientations: Vec<f64>,
    faces: FacesOf,
    /// Faces of the tried table that may be neither as at the start nor sound, ascending.
    open: BTreeSet<u32>,
}

/// Faces of a table by control point.
#[derive(Default)]
struct FacesOf {
    start: Vec<u32>,
    faces: Vec<u32>,
}

impl FacesOf {
    fn new(table: &PatchTable) -> FacesOf {
        let points = |f: &Face| &table.indices[f.first as usize..f.first as usize + f.kind.points()];
        let mut start = vec![0; table.control.len() + 1];
        for &i in table.faces.iter().flat_map(points) {
            start[i as usize] += 1;
        }
        let mut end = 0;
        for s in &mut start {
            end += *s;
            *s = end;
        }
        let mut faces = vec![0; end as usize];
        for (n, face) in table.faces.iter().enumerate() {
            for &i in points(face) {
                start[i as usize] -= 1;
                faces[start[i as usize] as usize] = n as u32;
            }
        }
        FacesOf { start, faces }
    }

    fn of(&self, point: u32) -> &[u32] {
        &self.faces[self.start[point as usize] as usize..self.start[point as usize + 1] as usize]
    }
}

/// What a test cost and found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Wall time of the tests.
    pub time: Duration,
    /// Positions tried.
    pub tries: u32,
    /// Patches that the last try looked at: those that had moved since they were last found sound.
    pub patches: usize,
}

fn sound(face: &Face, points: &[ControlPoint], orientation: f64) -> bool {
    gd01(face.kind, points, orientation)
        || jacobian_sign(face.kind, points, orientation, RECTANGLES) == JacobianSign::Positive
}

impl Watch {
    /// Takes the patches of a scene as it is drawn adaptively.
    pub fn new(model: &Model) -> Watch {
        let tried = model.to_try();
        Watch {
            marked: tried.revision,
            start: tried.table.clone(),
            known: tried.table.faces.iter().zip(0..).map(|(f, n)| ((f.level, f.name), n)).collect(),
            folded: HashMap::new(),
            orientations: orientations(&tried.refinement.levels[0]),
            faces: FacesOf::new(&tried.table),
            open: BTreeSet::new(),
            tried,
        }
    }

    /// Faces that were folded, or not proved sound, at the beginning. Tests all of them.
    pub fn folded(&mut self) -> usize {
        (0..self.start.faces.len() as u32).filter(|&n| self.was_folded_at(n)).count()
    }

    /// Whether a scene of the same polygons folds nothing that was sound; and how many patches had to be looked at.
    ///
    /// # Errors
    /// The scene cannot be refined.
    pub fn allows(&mut self, scene: &Scene) -> Result<(bool, usize), EditError> {
        self.tried.set(scene.clone())?;
        self.mark();
        let mut looked = 0;
        while let Some(&n) = self.open.first() {
            let face = self.tried.table.faces[n as usize];
            let points = face_control(&self.tried.table, &face);
            if !self.as_at_start(&face, &points) {
                looked += 1;
                if !sound(&face, &points, self.orientation(&face)) && !self.was_folded(&face) {
                    return Ok((false, looked));
                }
            }
            self.open.pop_first();
        }
        Ok((true, looked))
    }

    /// Limit point of a vertex in a scene of the same polygons. See [`Model::limit`].
    fn limit(&mut self, scene: &Scene, id: Id) -> Result<DVec2, EditError> {
        self.tried.set(scene.clone())?;
        self.tried.limit(id.level, id.slot)
    }

    /// Marks what changed since the last time.
    fn mark(&mut self) {
        let table = &self.tried.table;
        match self.tried.changed_since(self.marked) {
            Some(changed) if changed.indices.is_empty() => {
                self.open.extend(changed.control.iter().flat_map(|&i| self.faces.of(i)));
            }
            _ => {
                self.faces = FacesOf::new(table);
                self.open = (0..table.faces.len() as u32).collect();
            }
        }
        self.marked = self.tried.revision;
    }

    fn orientation(&self, face: &Face) -> f64 {
        self.orientations[base_face(&self.tried.refinement.levels[0], face) as usize]
    }

    fn as_at_start(&self, face: &Face, points: &[ControlPoint]) -> bool {
        self.known.get(&(face.level, face.name)).is_some_and(|&n| {
            let before = &self.start.faces[n as usize];
            let indices = &self.start.indices[before.first as usize..];
            before.kind == face.kind
                && points.iter().zip(indices).all(|(a, &i)| a[..2] == self.start.control[i as usize][..2])
        })
    }

    fn was_folded_at(&mut self, n: u32) -> bool {
        if let Some(&known) = self.folded.get(&n) {
            return known;
        }
        let face = self.start.faces[n as usize];
        let folded = !sound(&face, &face_control(&self.start, &face), self.orientation(&face));
        self.folded.insert(n, folded);
        folded
    }

    /// Whether the face, or else the one above it or one below it, was folded before.
    fn was_folded(&mut self, face: &Face) -> bool {
        let zero = &self.tried.refinement.levels[0];
        let base = base_face(zero, face);
        let above = (0..=face.level).rev().find_map(|level| match level {
            0 => self.known.get(&(0, u64::from(base))),
            _ => self.known.get(&(level, face.name >> (2 * (face.level - level)))),
        });
        if let Some(&n) = above {
            return self.was_folded_at(n);
        }
        let below = |f: &Face| match face.level {
            0 => base_face(zero, f) == base,
            l => f.level > l && f.name >> (2 * (f.level - l)) == face.name,
        };
        let below: Vec<u32> = self.start.faces.iter().zip(0..).filter(|(f, _)| below(f)).map(|(_, n)| n).collect();
        below.into_iter().any(|n| self.was_folded_at(n))
    }
}

/// Brings the drag to `target` if nothing folds there, else as far from `from` (where nothing does) towards it as can be
/// proved, to within `tolerance` scene units; returns where it ended. `scene` becomes that scene.
///
/// # Errors
/// As [`Drag::to`].
pub fn drag_within(
    watch: &mut Watch,
    drag: &Drag,
    model: &Model,
    scene: &mut Scene,
    [from, target]: [DVec2; 2],
    tolerance: f64,
    cost: &mut Cost,
) -> Result<DVec2, EditError> {
    let put = |watch: &mut Watch, next: &mut Scene, at| {
        drag.to_by(next, &model.mesh, at, |tried| watch.limit(tried, drag.id())).map(drop)
    };
    bisect(watch, put, scene, [from, target], tolerance, cost)
}

/// As [`drag_within`], for several handles held together; places are those of the first.
///
/// # Errors
/// The scene cannot be refined.
pub fn shift_within(
    watch: &mut Watch,
    together: &Together,
    model: &Model,
    scene: &mut Scene,
    ways: [DVec2; 2],
    tolerance: f64,
    cost: &mut Cost,
) -> Result<DVec2, EditError> {
    let start = together.drags()[0].start();
    let put = |_: &mut Watch, next: &mut Scene, at| {
        together.shift(next, &model.mesh, at - start);
        Ok(())
    };
    bisect(watch, put, scene, ways, tolerance, cost)
}

fn bisect(
    watch: &mut Watch,
    put: impl Fn(&mut Watch, &mut Scene, DVec2) -> Result<(), EditError>,
    scene: &mut Scene,
    [from, target]: [DVec2; 2],
    tolerance: f64,
    cost: &mut Cost,
) -> Result<DVec2, EditError> {
    let start = Instant::now();
    let mut attempt = |at: DVec2| -> Result<Option<Scene>, EditError> {
        let mut next = scene.clone();
        put(watch, &mut next, at)?;
        let (allowed, looked) = watch.allows(&next)?;
        cost.tries += 1;
        cost.patches = looked;
        Ok(allowed.then_some(next))
    };
    let mut best = attempt(target)?.map(|done| (target, done));
    if best.is_none() {
        let (mut low, mut high) = (from, target);
        while low.distance(high) > tolerance {
            let middle = low.midpoint(high);
            if middle == low || middle == high {
                break;
            }
            match attempt(middle)? {
                Some(done) => {
                    low = middle;
                    best = Some((middle, done));
                }
                None => high = middle,
            }
        }
    }
    cost.time += start.elapsed();
    match best {
        Some((at, done)) => {
            *scene = done;
            Ok(at)
        }
        None => Ok(from),
    }
}
