//! An edit costs what it touches (ZHHK22 7.2 names it as future work).
//!
//! A [`State`] keeps the levels and the patches of a scene. A change of values is followed level by level: the vertices of
//! M^0 that it moves, what depends on them in M^1, edits in their local frames and so on ([`spread`]); then the faces
//! within two rings of a changed vertex are built anew from a cut-out of the levels, and their control points replace the
//! old ones in place ([`patches`]). A geometry edit that comes or goes, or one colour all around a vertex, first changes what is refined: faces of the levels
//! come and go around it (`plan.rs`, `grow.rs`), and so do patches, control points and indices in the table (`slots.rs`).
//! Everything has the bits that a fresh [`refine`](fn@crate::refine::refine) and [`build`](fn@crate::patch::build::build)
//! would give; after an edit that came or went, levels and patches may stand in another order, and the table has places
//! that nothing uses.
//!
//! # Worst case
//!
//! A change of values takes time linear in the faces within its influence, on all levels. So does an edit that comes or
//! goes; beside that, it renumbers the scene's edits behind it (some nanoseconds each) unless it is the last one. A table
//! that such edits leave with more room than patches is built anew ([`State::apply`]), which costs each edit a constant
//! share of its own faces.
//!
//! Rebuilt as a whole is: other polygons or corner rules, sharp tags, colour edits of single sectors that come or go or any
//! beside sharp edges, a colour that becomes equal to its neighbour's or stops being so, edits that come or go under
//! [`Rules::Authors`], with isolation or in global mode, and those whose faces would come beside a colour edit's. The [`Outcome`] says which it was. The inverse
//! indices of [`Index`] are made at the first local edit after a rebuild and take time linear in the levels.

mod diff;
mod grow;
mod index;
mod memory;
pub mod patches;
mod plan;
mod slots;
pub mod spread;

pub use diff::{between, delta, Delta, Splice};
pub use index::Index;

use crate::mesh::{self, HalfEdgeMesh, MeshError};
use crate::patch::build::build;
use crate::patch::points::Irregular;
use crate::patch::PatchTable;
use crate::refine::edits::{resolve_move, resolve_paint, EditError, Move, Paint};
use crate::refine::{refine, Mode, Options, RefineError, Refinement, Rules};
use crate::scene::{ColourEdit, GeometryEdit, Handle, Scene};
use crate::subdiv::index_map::IndexMap;
use glam::{DVec2, DVec4};
use std::ops::Range;
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
    /// What of the table is to be uploaded.
    pub changed: Changed,
    /// Faces of the levels that came and that went.
    pub came: usize,
    /// See `came`.
    pub went: usize,
    /// Wall time of the levels and of the patches.
    pub times: [Duration; 2],
}

/// What of a table is not what it was. Its length never shrinks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changed {
    /// Control points, ascending.
    pub control: Vec<u32>,
    /// Stretches of indices, ascending; empty if faces and ranges are what they were.
    pub indices: Vec<Range<u32>>,
}

impl Changed {
    /// All of several changes together.
    pub fn together<'a>(all: impl Iterator<Item = &'a Changed>) -> Changed {
        let mut changed = Changed::default();
        for c in all {
            changed.control.extend_from_slice(&c.control);
            changed.indices.extend_from_slice(&c.indices);
        }
        changed.control.sort_unstable();
        changed.control.dedup();
        changed.indices = joined(changed.indices);
        changed
    }
}

/// Stretches that touch become one.
fn joined(mut stretches: Vec<Range<u32>>) -> Vec<Range<u32>> {
    stretches.sort_unstable_by_key(|r| r.start);
    let mut joined: Vec<Range<u32>> = Vec::new();
    for r in stretches {
        match joined.last_mut() {
            Some(last) if r.start <= last.end => last.end = last.end.max(r.end),
            _ => joined.push(r),
        }
    }
    joined
}

/// How an edit was followed.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// In place: other control points, and what came and went with an edit.
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
    /// How the levels were made.
    pub mode: Mode,
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
    let changed = spread::spread(index, kept.scene, kept.mesh, kept.refinement, edits, &spread::News::default())?;
    let spread = Instant::now();
    let mut touched = patches::replace(index, kept.refinement, kept.table, kept.irregular, &changed);
    touched.vertices = changed.iter().map(Vec::len).sum();
    touched.times = [spread - start, spread.elapsed()];
    Some(touched)
}

/// Whether all that comes fits the mesh.
pub fn fits(delta: &Delta, mesh: &HalfEdgeMesh) -> bool {
    let placed = |splice: &Splice<Handle>, in_face| {
        splice.added.iter().all(|handle| index::point_of(mesh, handle, in_face).is_some())
    };
    resolved(&delta.geometry, mesh).is_ok()
        && resolved_paints(&delta.colours, mesh).is_ok()
        && placed(&delta.handles, false)
        && placed(&delta.face_points, true)
}

/// Follows edits that come and go, and value edits, in place. `None`: that cannot be done; scene and mesh have the edits
/// then, and everything else must be made anew, the index too.
///
/// # Panics
/// If an index is out of range, or an edit does not fit the mesh ([`fits`]).
pub fn follow(index: &mut Index, kept: &mut Kept, delta: &Delta) -> Option<Touched> {
    if delta.is_values() {
        return update(index, kept, &delta.values);
    }
    let start = Instant::now();
    let Splice { at, removed, added } = &delta.geometry;
    let new = resolved(&delta.geometry, kept.mesh).expect("it fits the mesh");
    let new_paints = resolved_paints(&delta.colours, kept.mesh).expect("it fits the mesh");
    let handles = [(&delta.handles, &kept.scene.handles, false), (&delta.face_points, &kept.scene.face_points, true)];
    let mut news = spread::News::default();
    for (splice, list, in_face) in handles {
        let handles = list[splice.at..splice.at + splice.removed].iter().chain(&splice.added);
        for handle in handles {
            news.points.push(index::point_of(kept.mesh, handle, in_face).expect("it fits the mesh"));
        }
    }
    let planned = kept.mode == Mode::Adaptive { isolate: 0 } && kept.refinement.rules == Rules::Gradtess;
    let unplanned = !delta.geometry.is_empty() || !delta.colours.is_empty();
    if (unplanned && !planned) || kept.table.faces.is_empty() {
        write(kept, delta);
        return None;
    }
    let old = Splice { at: *at, removed: 0, added: kept.scene.geometry[*at..at + removed].to_vec() };
    let old = resolved(&old, kept.mesh).expect("the scene was refined");
    if planned {
        index.count_causes(kept.scene, kept.mesh, kept.refinement)?;
    }
    let [mut went, mut came] =
        [&old, &new].map(|moves| moves.iter().map(|m| index.asked_by(kept.mesh, m)).collect::<Vec<_>>());
    let Splice { at: first, removed: gone, .. } = delta.colours;
    let mut vertices = Vec::new();
    if !delta.colours.is_empty() {
        let old = Splice { at: first, removed: 0, added: kept.scene.colours[first..first + gone].to_vec() };
        let old = resolved_paints(&old, kept.mesh).expect("the scene was refined");
        vertices.extend(old.iter().chain(&new_paints).map(|p| p.vertex));
        vertices.sort_unstable();
        vertices.dedup();
        let own = first..first + gone;
        let smooth = index.are_smooth(kept.scene, kept.mesh, &old, own.clone())
            && index.are_smooth(kept.scene, kept.mesh, &new_paints, own);
        for &vertex in &vertices {
            went.push(index.asked_by_colours(kept.scene, kept.mesh, vertex));
        }
        for (p, entry) in old.iter().zip(first as u32..) {
            // All edits of a vertex go at once.
            if smooth && old.iter().take(entry as usize - first).all(|q| (q.vertex, q.level) != (p.vertex, p.level)) {
                match index.displace_group(entry, kept.refinement) {
                    Some(painted) => news.painted.push(painted),
                    None => {
                        write(kept, delta);
                        return None;
                    }
                }
            }
        }
        if !smooth {
            write(kept, delta);
            return None;
        }
        let behind = kept.scene.colours.len() > first + gone;
        index.recount_colours(first, &old, &new_paints, behind);
    }

    write(kept, delta);
    for &vertex in &vertices {
        came.push(index.asked_by_colours(kept.scene, kept.mesh, vertex));
    }
    if kept.scene.colours.len() > first + delta.colours.added.len() {
        index.renumber_colours((first + gone) as u32, delta.colours.added.len() as i64 - gone as i64);
    }
    if !news.points.is_empty() {
        index.place_points(kept.scene, kept.mesh);
    }
    let mut changes = grow::Changes::default();
    news.moves.extend((*at..at + removed).filter_map(|entry| index.displace_move(entry as u32)));
    if kept.scene.geometry.len() > at + added.len() {
        index.renumber((at + removed) as u32, added.len() as i64 - *removed as i64);
    }
    index.rise(kept.refinement, &came, &mut changes)?;
    let places = (*at as u32..).zip(&new);
    news.moves.extend(places.filter_map(|(entry, m)| index.place_move(m, entry, kept.refinement)));
    let mut groups: Vec<(u32, Paint)> = (first as u32..).zip(new_paints).collect();
    groups.sort_by_key(|(_, p)| (p.level, p.vertex));
    for group in groups.chunk_by(|(_, p), (_, q)| (p.level, p.vertex) == (q.level, q.vertex)) {
        news.groups.push(index.place_group(group, kept.refinement)?);
    }
    index.fall(kept.refinement, &went, &mut changes);
    let levels = old.iter().chain(&new).map(|m| m.level);
    let levels = levels.chain(delta.colours.added.iter().map(|e| e.level));
    kept.refinement.edit_level = deepest(kept.scene, kept.refinement.edit_level.max(levels.max().unwrap_or(0)));
    for l in 0..kept.refinement.levels.len() {
        let mut vertices = std::mem::take(&mut changes.dirty(l).vertices);
        vertices.retain(|&v| !index.has_left(l, v));
        changes.dirty(l).corners.retain(|&v| !index.has_left(l, v));
        news.vertices.push(vertices);
    }
    news.moves.retain(|&(l, v)| !index.has_left(l as usize, v));
    let changed = spread::spread(index, kept.scene, kept.mesh, kept.refinement, &delta.values, &news)?;
    let spread = Instant::now();
    let mut touched = if changes.turned > 0 {
        let draw = index.decide(kept.refinement, &mut changes);
        let Kept { refinement, table, irregular, .. } = kept;
        let touched = patches::redraw(index, refinement, table, *irregular, &changed, &mut changes, draw);
        index.trim(refinement);
        touched
    } else {
        patches::replace(index, kept.refinement, kept.table, kept.irregular, &changed)
    };
    (touched.came, touched.went) = (changes.came, changes.went);
    touched.vertices = changed.iter().map(Vec::len).sum();
    touched.times = [spread - start, spread.elapsed()];
    Some(touched)
}

fn write(kept: &mut Kept, delta: &Delta) {
    delta.write(kept.scene);
    for e in &delta.values {
        if let ValueEdit::Position(v, at) = *e {
            kept.mesh.positions[v as usize] = at;
        }
    }
}

/// The geometry edits that come, resolved.
fn resolved(splice: &Splice<GeometryEdit>, mesh: &HalfEdgeMesh) -> Result<Vec<Move>, EditError> {
    let map = IndexMap::new(mesh);
    splice.added.iter().enumerate().map(|(i, e)| resolve_move(splice.at + i, e, &map)).collect()
}

fn resolved_paints(splice: &Splice<ColourEdit>, mesh: &HalfEdgeMesh) -> Result<Vec<Paint>, EditError> {
    let map = IndexMap::new(mesh);
    splice.added.iter().enumerate().map(|(i, e)| resolve_paint(splice.at + i, e, &map)).collect()
}

/// Deepest level that has an edit, which is `most` at most. As soon as one is found there, no other is looked at.
fn deepest(scene: &Scene, most: u32) -> u32 {
    let mut deepest = 0;
    for level in scene.geometry.iter().map(|e| e.level).rev().chain(scene.colours.iter().map(|e| e.level).rev()) {
        deepest = deepest.max(level);
        if deepest >= most {
            break;
        }
    }
    deepest
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
        let fitting = delta(&self.scene, &scene).filter(|delta| fits(delta, &self.mesh));
        if let Some(touched) = fitting.and_then(|delta| self.follow(&delta)) {
            // What edits do not see: names, lines, the picture below.
            self.scene = scene;
            return Ok(Outcome::Local(touched));
        }
        *self = State::new(scene, self.options, self.irregular)?;
        Ok(Outcome::Rebuilt)
    }

    /// Makes edits. A table that edits have left with more room than patches is built anew first.
    ///
    /// # Errors
    /// An edit does not fit the scene; the state is then as it was.
    ///
    /// # Panics
    /// If an index is out of range.
    pub fn apply(&mut self, delta: &Delta) -> Result<Outcome, IncrementalError> {
        if self.index.as_ref().is_some_and(|index| index.is_fragmented(&self.table)) {
            self.rebuild();
        }
        resolved(&delta.geometry, &self.mesh).map_err(RefineError::from)?;
        resolved_paints(&delta.colours, &self.mesh).map_err(RefineError::from)?;
        match self.follow(delta) {
            Some(touched) => Ok(Outcome::Local(touched)),
            None => {
                self.rebuild();
                Ok(Outcome::Rebuilt)
            }
        }
    }

    fn follow(&mut self, delta: &Delta) -> Option<Touched> {
        let State { scene, mesh, refinement, table, irregular, index, options } = self;
        let index = index.get_or_insert_with(|| Index::new(scene, mesh, refinement, table));
        let mut kept = Kept { scene, mesh, refinement, table, irregular: *irregular, mode: options.mode };
        let touched = follow(index, &mut kept, delta);
        if touched.is_none() {
            self.index = None;
        }
        touched
    }

    fn rebuild(&mut self) {
        self.index = None;
        self.refinement = refine(&self.scene, &self.mesh, self.options).expect("the edits fit the mesh");
        self.table = build(&self.refinement, self.irregular);
    }

    /// Makes the inverse indices now, which the first local edit would otherwise do.
    pub fn prepare(&mut self) {
        let State { scene, mesh, refinement, table, index, .. } = self;
        index.get_or_insert_with(|| Index::new(scene, mesh, refinement, table));
    }

    /// Control points that something is drawn with: those of the table but for places that edits left unused.
    pub fn points(&self) -> usize {
        self.index.as_ref().map_or(self.table.control.len(), Index::points)
    }

    /// Bytes of all that is held: scene, mesh, levels, table and indices, but for the few bytes of names.
    pub fn bytes(&self) -> usize {
        memory::of_scene(&self.scene)
            + memory::of_mesh(&self.mesh)
            + self.refinement.levels.iter().map(memory::of_level).sum::<usize>()
            + self.refinement.fates.iter().map(Vec::capacity).sum::<usize>()
            + memory::of_table(&self.table)
            + self.index_bytes()
    }

    /// Bytes of the inverse indices; 0 before they are made.
    pub fn index_bytes(&self) -> usize {
        self.index.as_ref().map_or(0, Index::bytes)
    }
}
