//! Value edits, followed through the levels: only what depends on a changed vertex is computed again, and what comes out
//! the same is followed no further.

use super::index::{Index, LevelIndex, Source};
use super::ValueEdit;
use crate::mesh::{HalfEdgeMesh, NONE};
use crate::refine::Refinement;
use crate::scene::{CornerRule, Scene};
use crate::subdiv::edit::{step, LocalMove};
use crate::subdiv::gather::{self, Around};
use crate::subdiv::level::{Level, CUT};
use glam::{DVec2, DVec4};

/// What changed beside values.
#[derive(Default)]
pub struct News {
    /// Vertices that are new, of each level.
    pub vertices: Vec<Vec<u32>>,
    /// Level and vertex of geometry edits that came or went.
    pub moves: Vec<(u32, u32)>,
    /// Level and group of colour edits that came.
    pub groups: Vec<(u32, u32)>,
    /// Level and vertices of colour edits that went.
    pub painted: Vec<(u32, Vec<u32>)>,
    /// Points of M^0 of handles that came or went.
    pub points: Vec<u32>,
}

/// Writes what follows from `edits` and `news`, which `scene` and `mesh` have already, into the levels, and returns the changed
/// vertices of each level, ascending. `None`: an edge becomes sharp or stops being so; the levels are then half-way and
/// to be made anew.
///
/// # Panics
/// If an edit's index is out of range, or the index belongs to another refinement.
pub fn spread(
    index: &mut Index,
    scene: &Scene,
    mesh: &HalfEdgeMesh,
    refinement: &mut Refinement,
    edits: &[ValueEdit],
    news: &News,
) -> Option<Vec<Vec<u32>>> {
    let mut seeds = Seeds::of(index, mesh, edits)?;
    seeds.points.extend_from_slice(&news.points);
    seeds.groups.extend_from_slice(&news.groups);
    let mut changed = Vec::with_capacity(refinement.levels.len());
    let (mut moved, mut painted) = (Vec::new(), Vec::new());
    for l in 0..refinement.levels.len() {
        let (coarser, rest) = refinement.levels.split_at_mut(l);
        let level = &mut rest[0];
        let below = |coarse: &[u32], level: &Level| match coarser.last() {
            Some(above) => dependents(above, &index.levels[l - 1].around, coarse, level),
            None => Vec::new(),
        };
        let mut to_move = if l == 0 { seeds.points.clone() } else { below(&moved, level) };
        let mut to_paint = below(&painted, level);
        to_move.extend(news.moves.iter().filter(|m| m.0 == l as u32).map(|m| m.1));
        let faded = news.painted.iter().filter(|p| p.0 == l as u32).flat_map(|p| &p.1);
        to_paint.extend(faded.filter(|&&v| !index.has_left(l, v)));
        if let Some(new) = news.vertices.get(l) {
            to_move.extend_from_slice(new);
            to_paint.extend_from_slice(new);
        }
        let groups = seeds.groups.iter().filter(|g| g.0 == l as u32).map(|g| g.1).collect();
        let epochs = [index.next_epoch(), index.next_epoch()];

        let own = &mut index.levels[l];
        if !own.moves.is_empty() {
            // A frame's ends carry the vertex along.
            let frames = to_move.iter().filter_map(|v| own.read.get(v)).flatten().copied();
            let edited = seeds.moves.iter().filter(|m| m.0 == l as u32).map(|m| m.1);
            let vertices = frames.chain(edited).map(|m| own.moves[m as usize].vertices[0]);
            to_move.extend(vertices.collect::<Vec<_>>());
        }
        unmarked(&mut to_move, &mut own.vertex_mark, epochs[0]);
        unmarked(&mut to_paint, &mut own.vertex_mark, epochs[1]);

        let index = &*index;
        let own = &index.levels[l];
        let above = coarser.last().map(|a| Above { level: a, around: &index.levels[l - 1].around, own });
        let plain = |v: u32| match &above {
            Some(above) => above.position(v, refinement.corners),
            None => match index.placed.get(&v) {
                Some(&(false, i)) => scene.handles[i as usize].at,
                Some(&(true, i)) => scene.face_points[i as usize].at,
                None => gather::ternary_point(mesh, v),
            },
        };
        moved.clear();
        for v in to_move {
            let mut p = plain(v);
            for &m in own.moved.get(&v).map_or(&[][..], |m| m) {
                let m = &own.moves[m as usize];
                let e = &scene.geometry[m.entry as usize];
                let [v, end1, end2] = m.vertices.map(plain);
                p += step(&LocalMove { a: e.a, b: e.b, ..m.local }, end1 - v, end2 - v);
            }
            if set_position(level, &own.around, v, p) {
                moved.push(v);
            }
        }
        painted.clear();
        recolour(level, above.as_ref(), own, scene, refinement.corners, &to_paint, groups, &mut painted)?;

        let mut all = moved.clone();
        all.extend_from_slice(&painted);
        all.sort_unstable();
        all.dedup();
        changed.push(all);
    }
    Some(changed)
}

/// Where edits enter the levels.
#[derive(Default)]
struct Seeds {
    /// Vertices of M^0 that are placed anew.
    points: Vec<u32>,
    /// Level and number of geometry edits.
    moves: Vec<(u32, u32)>,
    /// Level and number of groups of colour edits.
    groups: Vec<(u32, u32)>,
}

impl Seeds {
    fn of(index: &Index, mesh: &HalfEdgeMesh, edits: &[ValueEdit]) -> Option<Seeds> {
        let mut seeds = Seeds::default();
        for e in edits {
            match *e {
                ValueEdit::Position(v, _) => {
                    gather::ternary_dependents(mesh, v, index.input.of(v), |p| seeds.points.push(p));
                }
                ValueEdit::Handle(i, _) => seeds.points.extend(index.point_of.get(&(false, i))),
                ValueEdit::FacePoint(i, _) => seeds.points.extend(index.point_of.get(&(true, i))),
                ValueEdit::Geometry(i, _) => seeds.moves.extend(index.move_of.get(&i)),
                ValueEdit::CornerColour(..) | ValueEdit::Colour(..) if index.twice => return None,
                ValueEdit::CornerColour(h, _) => {
                    // Input vertices have the same numbers in M^0.
                    let painted = index.levels[0].painted[mesh.origin[h as usize] as usize];
                    seeds.groups.push((0, painted));
                }
                ValueEdit::Colour(i, _) => seeds.groups.extend(index.group_of.get(&i)),
            }
        }
        Some(seeds)
    }
}

/// Vertices of `next` that depend on the vertices `changed` of the level above it, with repetitions.
fn dependents(level: &Level, around: &Around, changed: &[u32], next: &Level) -> Vec<u32> {
    let mut faces: Vec<u32> = changed.iter().flat_map(|&v| around.of(v)).map(|&h| level.face_of(h)).collect();
    faces.sort_unstable();
    faces.dedup();
    let mut found = Vec::with_capacity(16 * faces.len());
    // A face's vertex reaches its face point, the points of its edges and all of its corners: the corners of its children.
    for h in faces.into_iter().flat_map(|f| level.of_face(f)) {
        let child = level.child[h as usize];
        if child < CUT {
            found.extend(Level::quad(&next.origin, child));
        }
    }
    found
}

/// Drops what is marked already, and marks the rest.
fn unmarked(list: &mut Vec<u32>, mark: &mut [u32], epoch: u32) {
    list.retain(|&v| std::mem::replace(&mut mark[v as usize], epoch) != epoch);
}

/// The level above one, and the way back to it.
struct Above<'a> {
    level: &'a Level,
    around: &'a Around,
    own: &'a LevelIndex,
}

impl Above<'_> {
    /// Position of a vertex before the edits of its level.
    fn position(&self, v: u32, corners: CornerRule) -> DVec2 {
        let h = self.own.around.of(v)[0];
        gather::position(self.level, self.around, self.own.parent[h as usize >> 2], h & 3, corners)
    }

    /// Colour of the corner at the origin of `h` before the edits of its level.
    fn colour(&self, h: u32, corners: CornerRule) -> DVec4 {
        gather::colour(self.level, self.around, self.own.parent[h as usize >> 2], h & 3, corners)
    }
}

/// Whether that is another position.
fn set_position(level: &mut Level, around: &Around, v: u32, p: DVec2) -> bool {
    let old = level.value[v as usize].p;
    if old.to_array().map(f64::to_bits) == p.to_array().map(f64::to_bits) {
        return false;
    }
    level.value[v as usize].p = p;
    for &h in around.of(v) {
        level.value[level.tint[h as usize] as usize].p = p;
    }
    true
}

/// Whether that is another colour.
fn set_colour(level: &mut Level, tint: u32, c: DVec4) -> bool {
    let old = &mut level.value[tint as usize].c;
    let differs = old.to_array().map(f64::to_bits) != c.to_array().map(f64::to_bits);
    *old = c;
    differs
}

/// Colours of a level: first what Catmull-Clark gives `vertices`, then the edits that are in `groups` or near a vertex
/// that may have changed. `changed` gets the vertices with another colour.
#[allow(clippy::too_many_arguments)]
fn recolour(
    level: &mut Level,
    above: Option<&Above>,
    own: &LevelIndex,
    scene: &Scene,
    corners: CornerRule,
    vertices: &[u32],
    mut groups: Vec<u32>,
    changed: &mut Vec<u32>,
) -> Option<()> {
    let plain = |h: u32| above.map_or(DVec4::ONE, |above| above.colour(h, corners));
    for &v in vertices {
        match own.painted.get(v as usize) {
            Some(&group) if group != NONE => groups.push(group),
            _ => {
                let (mut last, mut differs) = (NONE, false);
                for &h in own.around.of(v) {
                    let tint = level.tint[h as usize];
                    if tint != last {
                        differs |= set_colour(level, tint, plain(h));
                        last = tint;
                    }
                }
                if differs {
                    changed.push(v);
                }
            }
        }
    }
    groups.sort_unstable();
    groups.dedup();
    for g in groups {
        repaint(level, own, g, scene, plain, changed)?;
    }
    Some(())
}

/// All colour edits of one vertex of the level (as [`crate::subdiv::edit::paint`], into the tints that are there).
/// `None`: the colours beside a spoke become equal or different, or corners that share a tint get different ones.
fn repaint(
    level: &mut Level,
    own: &LevelIndex,
    group: u32,
    scene: &Scene,
    plain: impl Fn(u32) -> DVec4,
    changed: &mut Vec<u32>,
) -> Option<()> {
    let (first, end) = (own.group[group as usize] as usize, own.group[group as usize + 1] as usize);
    let edits = &own.paints[first..end];
    let v = level.origin[edits[0].0 as usize];
    let sectors = own.around.of(v);
    let colours: Vec<DVec4> = sectors
        .iter()
        .map(|&h| match edits.iter().find(|e| e.0 == h) {
            Some(&(_, Source::Edit(i))) => scene.colours[i as usize].colour,
            Some(&(_, Source::Corner(i))) => scene.corner_colours[i as usize],
            None => plain(h),
        })
        .collect();
    let of = |h: u32| sectors.iter().position(|&s| s == h).map(|i| colours[i]);
    for &(h, _) in edits {
        let before = level.spoke_before(h);
        for beside in [before, level.spoke_after(h)].into_iter().flatten() {
            // A vertex that is new has no colour yet.
            let [a, b] = [beside, h].map(|h| level.tint[h as usize]);
            let differ = a != b && level.value[a as usize].c != level.value[b as usize].c;
            if differ != (of(beside)? != of(h)?) {
                return None;
            }
        }
    }
    // Tint, its vertex, its colour.
    let mut written: Vec<(u32, u32, DVec4)> = Vec::with_capacity(24);
    for (&h, &colour) in sectors.iter().zip(&colours) {
        let a = level.next(h);
        let (c, d) = (level.next(a), level.prev(h));
        let beyond = level.across(a).map(|t| level.next(t));
        let corners = [Some(h), Some(a), Some(d), beyond, Some(c)];
        for g in corners.into_iter().chain([level.across(c)]).flatten() {
            let tint = level.tint[g as usize];
            match written.iter().find(|w| w.0 == tint) {
                Some(w) if w.2 != colour => return None,
                Some(_) => {}
                None => written.push((tint, level.origin[g as usize], colour)),
            }
        }
    }
    for (tint, v, colour) in written {
        if set_colour(level, tint, colour) {
            changed.push(v);
        }
    }
    Some(())
}
