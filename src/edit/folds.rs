//! Fold-over prevention (ZHHK22 5.2, GD01): a drag stops where a drawn patch would turn over.
//!
//! The paper tests a bicubic in place of each Gregory patch. Here every patch is tested as what it is
//! ([`crate::check::folds`]): first the sufficient test of GD01, then the Jacobian's sign all over the patch. What
//! stays undecided counts as folded, so that nothing is let through that folds.

use super::drag::Drag;
use super::model::Model;
use super::together::Together;
use super::EditError;
use crate::check::folds::{base_face, gd01, jacobian_sign, orientations, JacobianSign};
use crate::patch::build::{build, face_control};
use crate::patch::points::Irregular;
use crate::patch::{ControlPoint, Face, Kind, PatchTable};
use crate::refine::{refine, Options};
use crate::scene::Scene;
use crate::subdiv::level::Level;
use glam::DVec2;
use std::collections::{HashMap, HashSet};
use std::time::{Duration, Instant};

/// Rectangles that the Jacobian test may cut a patch into.
const RECTANGLES: usize = 1000;

/// The patches at the beginning of a gesture, and which of them were folded then: those may stay so.
pub struct Watch {
    known: HashMap<(u32, u64), (Kind, Vec<ControlPoint>)>,
    folded: HashSet<(u32, u64)>,
    orientations: Vec<f64>,
    irregular: Irregular,
}

/// What a test cost and found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Wall time of the tests.
    pub time: Duration,
    /// Positions tried.
    pub tries: u32,
    /// Patches whose control points had moved, in the last try.
    pub patches: usize,
}

fn sound(face: &Face, points: &[ControlPoint], orientation: f64) -> bool {
    gd01(face.kind, points, orientation)
        || jacobian_sign(face.kind, points, orientation, RECTANGLES) == JacobianSign::Positive
}

impl Watch {
    /// Looks at all patches of a scene as it is drawn adaptively.
    pub fn new(model: &Model) -> Watch {
        let irregular = model.drawing.irregular;
        let zero = &model.refinement.levels[0];
        let table = build(&model.refinement, irregular);
        let mut watch = Watch {
            known: HashMap::with_capacity(table.faces.len()),
            folded: HashSet::new(),
            orientations: orientations(zero),
            irregular,
        };
        for face in &table.faces {
            let points = face_control(&table, face);
            if !sound(face, &points, watch.orientations[base_face(zero, face) as usize]) {
                watch.folded.insert((face.level, face.name));
            }
            watch.known.insert((face.level, face.name), (face.kind, points));
        }
        watch
    }

    /// Faces that were folded, or not proved sound, at the beginning.
    pub fn folded(&self) -> usize {
        self.folded.len()
    }

    /// Whether a scene of the same polygons folds nothing that was sound; and how many patches had to be looked at.
    ///
    /// # Errors
    /// The scene cannot be refined.
    pub fn allows(&self, scene: &Scene, model: &Model) -> Result<(bool, usize), EditError> {
        let mut mesh = model.mesh.clone();
        mesh.positions.clone_from(&scene.mesh.positions);
        let refinement = refine(scene, &mesh, Options::default())?;
        let table = build(&refinement, self.irregular);
        Ok(self.sound(&table, &refinement.levels[0]))
    }

    fn sound(&self, table: &PatchTable, zero: &Level) -> (bool, usize) {
        let mut looked = 0;
        for face in &table.faces {
            let points = face_control(table, face);
            let same = self.known.get(&(face.level, face.name)).is_some_and(|(kind, known)| {
                *kind == face.kind && known.iter().zip(&points).all(|(a, b)| a[..2] == b[..2])
            });
            if same {
                continue;
            }
            looked += 1;
            let orientation = self.orientations[base_face(zero, face) as usize];
            if !sound(face, &points, orientation) && !self.was_folded(face) {
                return (false, looked);
            }
        }
        (true, looked)
    }

    /// Whether the face, one above it or one below it was folded before.
    fn was_folded(&self, face: &Face) -> bool {
        let mut name = face.name;
        for level in (1..=face.level).rev() {
            if self.folded.contains(&(level, name)) {
                return true;
            }
            name >>= 2;
        }
        self.folded.iter().any(|&(level, name)| {
            level > face.level && face.level > 0 && name >> (2 * (level - face.level)) == face.name
        })
    }
}

/// Brings the drag to `target` if nothing folds there, else as far from `from` (where nothing does) towards it as can be
/// proved, to within `tolerance` scene units; returns where it ended. `scene` becomes that scene.
///
/// # Errors
/// As [`Drag::to`].
pub fn drag_within(
    watch: &Watch,
    drag: &Drag,
    model: &Model,
    scene: &mut Scene,
    [from, target]: [DVec2; 2],
    tolerance: f64,
    cost: &mut Cost,
) -> Result<DVec2, EditError> {
    let put = |next: &mut Scene, at| drag.to(next, &model.mesh, at).map(drop);
    bisect(watch, put, model, scene, [from, target], tolerance, cost)
}

/// As [`drag_within`], for several handles held together; places are those of the first.
///
/// # Errors
/// The scene cannot be refined.
pub fn shift_within(
    watch: &Watch,
    together: &Together,
    model: &Model,
    scene: &mut Scene,
    ways: [DVec2; 2],
    tolerance: f64,
    cost: &mut Cost,
) -> Result<DVec2, EditError> {
    let start = together.drags()[0].start();
    let put = |next: &mut Scene, at| {
        together.shift(next, &model.mesh, at - start);
        Ok(())
    };
    bisect(watch, put, model, scene, ways, tolerance, cost)
}

fn bisect(
    watch: &Watch,
    put: impl Fn(&mut Scene, DVec2) -> Result<(), EditError>,
    model: &Model,
    scene: &mut Scene,
    [from, target]: [DVec2; 2],
    tolerance: f64,
    cost: &mut Cost,
) -> Result<DVec2, EditError> {
    let start = Instant::now();
    let mut attempt = |at: DVec2| -> Result<Option<Scene>, EditError> {
        let mut next = scene.clone();
        put(&mut next, at)?;
        let (allowed, looked) = watch.allows(&next, model)?;
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
