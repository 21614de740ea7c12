//! An edit costs what it touches (ZHHK22 7.2 names it as future work).
//!
//! A [`State`] keeps the levels and the patches of a scene. A change of values is followed level by level: the vertices of
//! M^0 that it moves, what depends on them in M^1, edits in their local frames and so on ([`spread`]), colours and the
//! edges that they make sharp (`colour.rs`); then the faces within two rings of a changed vertex are built anew from a
//! cut-out of the levels, and their control points replace the old ones in place ([`patches`]). An edit or a sharp tag that
//! comes or goes first changes what is refined: faces of the levels come and go around it (`plan.rs`, `grow.rs`), and so do
//! patches, control points and indices in the table (`slots.rs`). Everything has the bits that a fresh
//! [`refine`](fn@crate::refine::refine) and [`build`](fn@crate::patch::build::build) would give; after an edit that came or
//! went, levels and patches may stand in another order, and the table has places that nothing uses.
//!
//! # Worst case
//!
//! A change of values takes time linear in the faces within its influence, on all levels. So does an edit that comes or
//! goes, and a sharp tag; beside that, it renumbers the scene's edits behind it (some nanoseconds each) unless it is the
//! last one, and when one goes that was there from the beginning, it looks at the places of all (likewise). The first
//! colour edit or sharp tag that comes or goes counts what sharp edges reach, unless [`State::prepare`] did. A table that
//! such edits leave with more room than patches is built anew ([`State::apply`]), which costs each edit a constant share of
//! its own faces; one with an eighth of room as soon as nobody waits ([`State::compact`]).
//!
//! Rebuilt as a whole is: other polygons, corner rules or none of the initial colours any more; whatever changes more than
//! values under [`Rules::Authors`], whose cascade follows the colours of each level before there is a next, and with
//! isolation while sharp edges meet somewhere. The [`Outcome`] says which it was ([`Whole`]). The inverse indices of
//! [`Index`] are made at the first local edit after a rebuild and take time linear in the levels.

mod asked;
mod colour;
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
use index::Source;

use crate::mesh::{self, HalfEdgeMesh, MeshError};
use crate::patch::build::build;
use crate::patch::points::Irregular;
use crate::patch::PatchTable;
use crate::refine::edits::{resolve_move, resolve_paint, EditError, Move, Paint};
use crate::refine::meetings::Birth;
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
    /// By a full rebuild, for a reason.
    Rebuilt(Whole),
}

/// Why an edit is not followed in place.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum Whole {
    /// Other polygons or rules, or initial colours that come or go.
    #[error("other polygons, rules or initial colours")]
    Mesh,
    /// Nothing was drawn before.
    #[error("nothing was drawn before")]
    Empty,
    /// Under [`Rules::Authors`] the cascade follows the colours of whole levels.
    #[error("the authors' rules cascade over whole levels")]
    Cascade,
    /// How deep the vertices where sharp edges meet are isolated follows from all edits together.
    #[error("isolation of meeting sharp edges follows from all edits together")]
    Isolation,
    /// An edit does not fit the mesh.
    #[error("an edit does not fit the mesh")]
    Unfit,
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

/// Whether all that comes fits the mesh.
pub fn fits(delta: &Delta, mesh: &HalfEdgeMesh) -> bool {
    let placed = |splice: &Splice<Handle>, in_face| {
        splice.added.iter().all(|handle| index::point_of(mesh, handle, in_face).is_some())
    };
    resolved(&delta.geometry, mesh).is_ok()
        && resolved_paints(&delta.colours, mesh).is_ok()
        && placed(&delta.handles, false)
        && placed(&delta.face_points, true)
        && delta.sharp.added.iter().all(|&h| h < mesh.half_edges())
}

/// Follows edits that come and go, and value edits, in place. An error says why that cannot be done; scene and mesh have
/// the edits then, and everything else must be made anew, the index too.
///
/// # Errors
/// See [`Whole`].
///
/// # Panics
/// If an index is out of range, or an edit does not fit the mesh ([`fits`]).
pub fn follow(index: &mut Index, kept: &mut Kept, delta: &Delta) -> Result<Touched, Whole> {
    let start = Instant::now();
    let Splice { at, removed, added } = &delta.geometry;
    let new = resolved(&delta.geometry, kept.mesh).expect("it fits the mesh");
    let new_paints = resolved_paints(&delta.colours, kept.mesh).expect("it fits the mesh");
    let old = Splice { at: *at, removed: 0, added: kept.scene.geometry[*at..at + removed].to_vec() };
    let old = resolved(&old, kept.mesh).expect("the scene was refined");
    let Splice { at: first, removed: gone, .. } = delta.colours;
    let old_paints = Splice { at: first, removed: 0, added: kept.scene.colours[first..first + gone].to_vec() };
    let old_paints = resolved_paints(&old_paints, kept.mesh).expect("the scene was refined");
    let handles = [(&delta.handles, &kept.scene.handles, false), (&delta.face_points, &kept.scene.face_points, true)];
    let mut news = spread::News::default();
    for (splice, list, in_face) in handles {
        let handles = list[splice.at..splice.at + splice.removed].iter().chain(&splice.added);
        for handle in handles {
            news.points.push(index::point_of(kept.mesh, handle, in_face).expect("it fits the mesh"));
        }
    }

    // Vertices whose colours are others now, as they were. New values ask for other faces if colours become equal or stop
    // being so.
    let mut repainted: Vec<Birth> = old_paints.iter().chain(&new_paints).map(|p| p.vertex).collect();
    repainted.sort_unstable();
    repainted.dedup();
    let mut before: Vec<Vec<(Source, Paint)>> =
        repainted.iter().map(|&v| plan::paints_of(index, kept.scene, kept.mesh, v)).collect();
    for (vertex, paints, values) in colour_values(index, kept, delta) {
        let mut now = paints.clone();
        for (source, paint) in &mut now {
            if let Some((_, colour)) = values.iter().rev().find(|v| v.0 == *source) {
                paint.colour = *colour;
            }
        }
        if !plan::alike(&paints, &now) && repainted.binary_search(&vertex).is_err() {
            before.push(paints);
            repainted.push(vertex);
        }
    }
    let recoloured = !repainted.is_empty() || !delta.sharp.is_empty();
    let replanned = !delta.geometry.is_empty() || recoloured;
    let global = matches!(kept.mode, Mode::Global(_));
    let planned = !global && kept.refinement.rules == Rules::Gradtess;
    let mut why = match kept.mode {
        _ if kept.table.faces.is_empty() => Some(Whole::Empty),
        Mode::Adaptive { .. } if replanned && !planned => Some(Whole::Cascade),
        _ => None,
    };
    if let (true, None, Mode::Adaptive { isolate }) = (planned && replanned, why, kept.mode) {
        index.make_plan(kept.scene, kept.mesh, kept.refinement, isolate);
        if recoloured || isolate > 0 {
            index.count_stars(kept.scene, kept.mesh);
        }
        why = index.has_isolated_meetings().then_some(Whole::Isolation);
    }
    if let Some(why) = why {
        write(kept, delta);
        return Err(why);
    }
    let (mut went, mut came) = (Vec::new(), Vec::new());
    if planned {
        for (moves, names) in [(&old, &mut went), (&new, &mut came)] {
            names.extend(moves.iter().map(|m| index.asked_by(kept.mesh, m)));
        }
    }
    let old_tags = kept.scene.sharp[delta.sharp.at..delta.sharp.at + delta.sharp.removed].to_vec();
    news.sectors.resize_with(kept.refinement.levels.len(), Vec::new);
    for p in old_paints.iter().chain(&new_paints) {
        if let Some(vertices) = index.displace_group(p.level, p.slot, kept.refinement) {
            news.sectors[p.level as usize].extend(vertices);
        }
    }

    write(kept, delta);
    let behind = kept.scene.colours.len() > first + delta.colours.added.len();
    index.renumber_entries(first, &old_paints, &new_paints, behind);
    if behind {
        index.renumber_colours((first + gone) as u32, delta.colours.added.len() as i64 - gone as i64);
    }
    if planned && recoloured {
        let after: Vec<_> =
            repainted.iter().map(|&v| plan::paints_of(index, kept.scene, kept.mesh, v)).map(without_sources).collect();
        let before: Vec<_> = before.into_iter().map(without_sources).collect();
        let recount = plan::Recount { paints: [&before, &after], tags: [&old_tags, &delta.sharp.added] };
        index.recount(kept.scene, kept.mesh, &recount, &mut went, &mut came);
        if index.has_isolated_meetings() {
            return Err(Whole::Isolation);
        }
    }
    for (tags, more) in [(&old_tags, false), (&delta.sharp.added, true)] {
        for &h in tags {
            index.count_tag(kept.mesh, h, more);
            let level = &kept.refinement.levels[0];
            colour::straight(level, 8 * h, |e| {
                news.sectors[0].extend([level.origin[e as usize], level.target(e)]);
            });
        }
    }
    if !news.points.is_empty() {
        index.place_points(kept.scene, kept.mesh);
    }
    let mut changes = grow::Changes::default();
    news.moves.extend((*at..at + removed).filter_map(|entry| index.displace_move(entry as u32)));
    if kept.scene.geometry.len() > at + added.len() {
        index.renumber((at + removed) as u32, added.len() as i64 - *removed as i64);
    }
    index.rise(kept.refinement, &came, &mut changes);
    let places = (*at as u32..).zip(&new);
    news.moves.extend(places.filter_map(|(entry, m)| index.place_move(m, entry, kept.refinement)));
    let mut placed: Vec<(u32, Birth)> = old_paints.iter().chain(&new_paints).map(|p| (p.level, p.vertex)).collect();
    placed.sort_unstable();
    placed.dedup();
    for (l, vertex) in placed {
        let paints = plan::paints_of(index, kept.scene, kept.mesh, vertex);
        let own = paints.into_iter().filter(|(_, p)| p.level == l).map(|(source, p)| (p.slot, source)).collect();
        news.groups.extend(index.place_group(l, own, kept.refinement));
    }
    index.fall(kept.scene, kept.mesh, kept.refinement, &went, &mut changes);
    if replanned {
        let levels = old.iter().chain(&new).map(|m| m.level);
        let levels = levels.chain(delta.colours.added.iter().map(|e| e.level));
        kept.refinement.edit_level = deepest(kept.scene, kept.refinement.edit_level.max(levels.max().unwrap_or(0)));
    }
    news.sectors.resize_with(kept.refinement.levels.len(), Vec::new);
    for l in 0..kept.refinement.levels.len() {
        let dirty = changes.dirty(l);
        let mut vertices = std::mem::take(&mut dirty.vertices);
        vertices.retain(|&v| !index.has_left(l, v));
        dirty.corners.retain(|&v| !index.has_left(l, v));
        news.sectors[l].append(&mut dirty.sectors);
        news.vertices.push(vertices);
    }
    news.moves.retain(|&(l, v)| !index.has_left(l as usize, v));
    let spreads = spread::spread(index, kept.scene, kept.mesh, kept.refinement, &delta.values, &news);
    for (l, spread) in spreads.iter().enumerate() {
        for &v in &spread.parted {
            changes.parted(&kept.refinement.levels[l], &index.levels[l], l, v);
        }
    }
    if kept.refinement.rules == Rules::Authors && !global && changes.turned > 0 {
        return Err(Whole::Cascade);
    }
    let changed: Vec<Vec<u32>> = spreads.into_iter().map(|spread| spread.changed).collect();
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
    Ok(touched)
}

fn without_sources(paints: Vec<(Source, Paint)>) -> Vec<Paint> {
    paints.into_iter().map(|(_, paint)| paint).collect()
}

/// Colours of a vertex, and those that change.
type ColourValues = (Birth, Vec<(Source, Paint)>, Vec<(Source, DVec4)>);

/// Vertices whose colours get other values, as the scene has them before.
fn colour_values(index: &Index, kept: &Kept, delta: &Delta) -> Vec<ColourValues> {
    let map = IndexMap::new(kept.mesh);
    let Splice { at, removed, added } = &delta.colours;
    let mut values: Vec<(Birth, Source, DVec4)> = Vec::new();
    for e in &delta.values {
        match *e {
            ValueEdit::CornerColour(h, c) => {
                values.push((map.birth(0, 8 * u64::from(h)), Source::Corner(h), c));
            }
            ValueEdit::Colour(i, c) => {
                // Values change after edits have come and gone. What comes is looked at with them.
                let i = i as usize;
                let before = match i {
                    _ if i < *at => i,
                    _ if i < at + added.len() => continue,
                    _ => i - added.len() + removed,
                };
                let paint = resolve_paint(before, &kept.scene.colours[before], &map).expect("the scene was refined");
                values.push((paint.vertex, Source::Edit(before as u32), c));
            }
            _ => {}
        }
    }
    values.sort_by_key(|v| v.0);
    let of_vertex = |same: &[(Birth, Source, DVec4)]| {
        let paints = plan::paints_of(index, kept.scene, kept.mesh, same[0].0);
        (same[0].0, paints, same.iter().map(|&(_, source, c)| (source, c)).collect())
    };
    values.chunk_by(|a, b| a.0 == b.0).map(of_vertex).collect()
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
        let why = match delta(&self.scene, &scene) {
            None => Whole::Mesh,
            Some(delta) if !fits(&delta, &self.mesh) => Whole::Unfit,
            Some(delta) => match self.follow(&delta) {
                Ok(touched) => {
                    // What edits do not see: names, lines, the picture below.
                    self.scene = scene;
                    return Ok(Outcome::Local(touched));
                }
                Err(why) => why,
            },
        };
        *self = State::new(scene, self.options, self.irregular)?;
        Ok(Outcome::Rebuilt(why))
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
            Ok(touched) => Ok(Outcome::Local(touched)),
            Err(why) => {
                self.rebuild();
                Ok(Outcome::Rebuilt(why))
            }
        }
    }

    fn follow(&mut self, delta: &Delta) -> Result<Touched, Whole> {
        let State { scene, mesh, refinement, table, irregular, index, options } = self;
        let index = index.get_or_insert_with(|| Index::new(scene, mesh, refinement, table));
        let mut kept = Kept { scene, mesh, refinement, table, irregular: *irregular, mode: options.mode };
        let touched = follow(index, &mut kept, delta);
        if touched.is_err() {
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
        let State { scene, mesh, refinement, table, index, options, .. } = self;
        index.get_or_insert_with(|| Index::ready(scene, mesh, refinement, table, options.mode));
    }

    /// Builds everything anew, if edits have left room in the table that is worth it; whether it was. For times when
    /// nobody waits: takes a rebuild, and makes all that the next edit needs.
    pub fn compact(&mut self) -> bool {
        if !self.index.as_ref().is_some_and(|index| index.is_loose(&self.table)) {
            return false;
        }
        self.rebuild();
        self.index =
            Some(Index::ready(&self.scene, &self.mesh, &mut self.refinement, &mut self.table, self.options.mode));
        true
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
