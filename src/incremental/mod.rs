//! An edit costs what it touches (ZHHK22 7.2 names it as future work).
//!
//! A [`State`] keeps the levels and the patches of a scene. An edit that leaves the plan as it is (what is refined, what
//! is sharp) is followed level by level: the vertices of M^0 that it moves, what depends on them in M^1, edits in their
//! local frames and so on ([`spread`]); then the faces within two rings of a changed vertex are built anew from a cut-out
//! of the levels, and their control points replace the old ones in place ([`patches`]). Everything has the bits that a
//! fresh [`refine`](fn@crate::refine::refine) and [`build`](fn@crate::patch::build::build) would give.
//!
//! # Worst case
//!
//! An edit that changes the plan or the sharp edges (edits added or removed, other polygons, corner rules, tags, a colour
//! that becomes equal to its neighbour's or stops being so) rebuilds everything; the [`Outcome`] says which it was. The
//! inverse indices of [`Index`] are made at the first local edit after a rebuild and take time linear in the levels.

mod diff;
mod index;
pub mod patches;
pub mod spread;

pub use diff::between;
pub use index::Index;

use crate::mesh::{self, HalfEdgeMesh, MeshError};
use crate::patch::build::build;
use crate::patch::points::Irregular;
use crate::patch::PatchTable;
use crate::refine::{refine, Options, RefineError, Refinement};
use crate::scene::Scene;
use glam::{DVec2, DVec4};
use std::time::{Duration, Instant};
use thiserror::Error;

/// A change of one value of a scene. Indices count in the scene's lists and must be in range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ValueEdit {
    /// An input vertex goes to another place.
    Position(u32, DVec2),
    /// An entry of [`Scene::handles`].
    Handle(u32, DVec2),
    /// An entry of [`Scene::face_points`].
    FacePoint(u32, DVec2),
    /// Both coordinates of an entry of [`Scene::geometry`].
    Geometry(u32, [f64; 2]),
    /// An entry of [`Scene::corner_colours`].
    CornerColour(u32, DVec4),
    /// The colour of an entry of [`Scene::colours`].
    Colour(u32, DVec4),
}

impl ValueEdit {
    /// Makes the change in the scene, and nothing that follows from it.
    ///
    /// # Panics
    /// If the index is out of range.
    pub fn write(&self, scene: &mut Scene) {
        match *self {
            ValueEdit::Position(v, at) => scene.mesh.positions[v as usize] = at,
            ValueEdit::Handle(i, at) => scene.handles[i as usize].at = at,
            ValueEdit::FacePoint(i, at) => scene.face_points[i as usize].at = at,
            ValueEdit::Geometry(i, [a, b]) => {
                let e = &mut scene.geometry[i as usize];
                (e.a, e.b) = (a, b);
            }
            ValueEdit::CornerColour(h, c) => scene.corner_colours[h as usize] = c,
            ValueEdit::Colour(i, c) => scene.colours[i as usize].colour = c,
        }
    }
}

/// What a local update did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Touched {
    /// Control vertices of all levels that changed.
    pub vertices: usize,
    /// Drawn faces within reach of those: what was built anew.
    pub faces: usize,
    /// Patches that draw those faces; a transition face has two to four.
    pub patches: usize,
    /// Control points of the table that changed, ascending.
    pub control: Vec<u32>,
    /// Wall time of the levels and of the patches.
    pub times: [Duration; 2],
}

/// How an edit was followed.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// In place: the same plan, the same patches, other control points.
    Local(Touched),
    /// By a full rebuild.
    Rebuilt,
}

/// Why a scene has no state.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum IncrementalError {
    /// The polygons form no mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The scene cannot be refined.
    #[error(transparent)]
    Refine(#[from] RefineError),
}

/// What a local update works on: a scene and what was made of it.
pub struct Kept<'a> {
    /// The scene.
    pub scene: &'a mut Scene,
    /// Its mesh.
    pub mesh: &'a mut HalfEdgeMesh,
    /// Its levels.
    pub refinement: &'a mut Refinement,
    /// Its patches.
    pub table: &'a mut PatchTable,
    /// How they were made of the levels.
    pub irregular: Irregular,
}

/// Follows value edits in place. `None`: they change what is sharp, and everything but scene and mesh, which have the
/// edits, must be made anew, the index too. Time linear in what is touched.
///
/// # Panics
/// If an edit's index is out of range.
pub fn update(index: &mut Index, kept: &mut Kept, edits: &[ValueEdit]) -> Option<Touched> {
    let start = Instant::now();
    for e in edits {
        e.write(kept.scene);
        if let ValueEdit::Position(v, at) = *e {
            kept.mesh.positions[v as usize] = at;
        }
    }
    let changed = spread::spread(index, kept.scene, kept.mesh, kept.refinement, edits)?;
    let spread = Instant::now();
    let mut touched = patches::replace(index, kept.refinement, kept.table, kept.irregular, &changed);
    touched.vertices = changed.iter().map(Vec::len).sum();
    touched.times = [spread - start, spread.elapsed()];
    Some(touched)
}

/// A scene with all that follows from it, kept up to date.
pub struct State {
    /// The scene.
    pub scene: Scene,
    /// Its polygons as half-edges.
    pub mesh: HalfEdgeMesh,
    /// Its levels.
    pub refinement: Refinement,
    /// Its patches.
    pub table: PatchTable,
    options: Options,
    irregular: Irregular,
    index: Option<Index>,
}

impl State {
    /// Builds everything.
    ///
    /// # Errors
    /// The polygons form no mesh, or the scene cannot be refined.
    pub fn new(scene: Scene, options: Options, irregular: Irregular) -> Result<State, IncrementalError> {
        let mesh = mesh::build(&scene.mesh)?;
        let refinement = refine(&scene, &mesh, options)?;
        let table = build(&refinement, irregular);
        Ok(State { scene, mesh, refinement, table, options, irregular, index: None })
    }

    /// Takes another scene. Compares all of it with the one at hand; [`State::apply`] does without.
    ///
    /// # Errors
    /// As [`State::new`]; the state is then as it was.
    pub fn set(&mut self, scene: Scene) -> Result<Outcome, IncrementalError> {
        if let Some(edits) = between(&self.scene, &scene) {
            let outcome = self.apply(&edits);
            // What edits do not see: names, lines, the picture below.
            self.scene = scene;
            return Ok(outcome);
        }
        *self = State::new(scene, self.options, self.irregular)?;
        Ok(Outcome::Rebuilt)
    }

    /// Makes value edits.
    ///
    /// # Panics
    /// If an index is out of range.
    pub fn apply(&mut self, edits: &[ValueEdit]) -> Outcome {
        let State { scene, mesh, refinement, table, irregular, index, .. } = self;
        let index = index.get_or_insert_with(|| Index::new(scene, mesh, refinement, table));
        let mut kept = Kept { scene, mesh, refinement, table, irregular: *irregular };
        match update(index, &mut kept, edits) {
            Some(touched) => Outcome::Local(touched),
            None => {
                self.index = None;
                self.refinement = refine(&self.scene, &self.mesh, self.options)
                    .expect("other values in the same places can be refined like the old ones");
                self.table = build(&self.refinement, self.irregular);
                Outcome::Rebuilt
            }
        }
    }

    /// Makes the inverse indices now, which the first local edit would otherwise do.
    pub fn prepare(&mut self) {
        let State { scene, mesh, refinement, table, index, .. } = self;
        index.get_or_insert_with(|| Index::new(scene, mesh, refinement, table));
    }

    /// Bytes of the inverse indices; 0 before they are made.
    pub fn index_bytes(&self) -> usize {
        self.index.as_ref().map_or(0, Index::bytes)
    }
}
