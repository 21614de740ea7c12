//! Faces of the levels come and go in place: the children of all half-edges around one vertex at a time, which is what a
//! face to be refined needs at each of its corners ([`crate::subdiv::catmull_clark`]). Only what is there and how it hangs
//! together; values are for [`super::spread`].

use super::index::LevelIndex;
use super::memory::{extend_to, push};
use crate::mesh::NONE;
use crate::refine::Refinement;
use crate::subdiv::level::{vertex_bits, Level, Value, CUT};
use glam::{DVec2, DVec4};
use vertex_bits::{BOUNDARY, DART, EXTRAORDINARY, SECTORS};

/// Value of a vertex before it has one: differs from all.
const NOTHING: Value = Value { p: DVec2::NAN, c: DVec4::NAN };

/// What came and went in one level.
#[derive(Default)]
pub(super) struct Dirty {
    /// Vertices that are new.
    pub vertices: Vec<u32>,
    /// Faces whose fate may be another.
    pub faces: Vec<u32>,
    /// Corners of faces that are refined now or were before, and vertices with other sectors.
    pub corners: Vec<u32>,
    /// Corners of faces that came.
    pub sectors: Vec<u32>,
}

/// What came and went.
#[derive(Default)]
pub(super) struct Changes {
    levels: Vec<Dirty>,
    /// Faces in the table that are not there any more or drawn otherwise: level and number.
    pub gone: Vec<(u32, u32)>,
    /// Faces that are refined now and were not before, or the other way round, and vertices with other sectors.
    pub turned: usize,
    /// Faces that came.
    pub came: usize,
    /// Faces that went.
    pub went: usize,
}

impl Changes {
    pub fn dirty(&mut self, l: usize) -> &mut Dirty {
        if self.levels.len() <= l {
            self.levels.resize_with(l + 1, Dirty::default);
        }
        &mut self.levels[l]
    }

    /// A vertex of level `l` with other sharp edges or colour sectors.
    pub fn parted(&mut self, level: &Level, own: &LevelIndex, l: usize, v: u32) {
        self.turned += 1;
        let dirty = self.dirty(l);
        dirty.corners.push(v);
        dirty.faces.extend(own.around.of(v).iter().map(|&h| level.face_of(h)));
    }

    /// A face that is refined from now on, or not any more.
    pub fn turned(&mut self, refinement: &mut Refinement, l: usize, f: u32, refined: bool) {
        let (coarse, fine) = refinement.levels.split_at_mut(l + 1);
        let level = &coarse[l];
        self.turned += 1;
        let dirty = self.dirty(l);
        dirty.faces.push(f);
        for h in level.of_face(f) {
            dirty.corners.push(level.origin[h as usize]);
            dirty.faces.extend(level.across(h).map(|t| level.face_of(t)));
        }
        for c in level.of_face(f).map(|h| level.child[h as usize]).filter(|&c| c < CUT) {
            fine[0].inside[c as usize] = refined;
            self.dirty(l + 1).faces.push(c);
        }
    }
}

fn new_value(level: &mut Level, own: &mut LevelIndex) -> u32 {
    if let Some(v) = own.free_values.pop() {
        level.value[v as usize] = NOTHING;
        return v;
    }
    push(&mut level.value, NOTHING);
    level.value.len() as u32 - 1
}

fn new_vertex(level: &mut Level, own: &mut LevelIndex, bits: u8) -> u32 {
    let v = new_value(level, own);
    let all = level.value.len();
    if level.bits.len() <= v as usize {
        extend_to(&mut level.bits, all, 0);
    }
    own.around.extend_to(all);
    extend_to(&mut own.vertex_mark, all, 0);
    if !own.painted.is_empty() {
        extend_to(&mut own.painted, all, NONE);
        own.painted[v as usize] = NONE;
    }
    level.bits[v as usize] = bits;
    v
}

fn new_face(level: &mut Level, fates: &mut Vec<u8>, own: &mut LevelIndex) -> u32 {
    if let Some(f) = own.free_faces.pop() {
        return f;
    }
    let f = level.face.len() as u32;
    push(&mut level.face, 0);
    push(&mut level.inside, false);
    level.quads = f + 1;
    let half_edges = 4 * level.face.len();
    extend_to(&mut level.origin, half_edges, NONE);
    extend_to(&mut level.twin, half_edges, CUT);
    extend_to(&mut level.tint, half_edges, NONE);
    if !level.sharp.is_empty() {
        extend_to(&mut level.sharp, half_edges, false);
    }
    if !level.child.is_empty() {
        extend_to(&mut level.child, half_edges, NONE);
    }
    push(fates, 0);
    push(&mut own.parent, NONE);
    push(&mut own.drawn, NONE);
    push(&mut own.face_mark, 0);
    push(&mut own.asked, 0);
    f
}

/// Makes the children of all half-edges around vertex `v` of level `l`, which has none yet. Sharp edges and colour sectors
/// are left to [`super::colour`].
pub(super) fn grow(refinement: &mut Refinement, index: &mut [LevelIndex], l: usize, v: u32, changes: &mut Changes) {
    let (coarse, fine) = refinement.levels.split_at_mut(l + 1);
    let (level, next) = (&mut coarse[l], &mut fine[0]);
    let (above, below) = index.split_at_mut(l + 1);
    let (own, under) = (&above[l], &mut below[0]);
    let fates = &mut refinement.fates[l + 1];
    let spokes = own.around.of(v).to_vec();

    let to = new_vertex(next, under, level.bits[v as usize] & !(SECTORS | DART));
    changes.dirty(l + 1).vertices.push(to);
    // A vertex that is there already.
    let there = |level: &Level, next: &Level, h: u32, slot: u32| {
        let c = level.child[h as usize];
        (c < CUT).then(|| next.origin[(4 * c + slot) as usize])
    };
    for &h in &spokes {
        let f = level.face_of(h);
        let (n, p) = (level.next(h), level.prev(h));
        let mut at = [to; 4];
        // The points of the edges ahead and behind: known in this face, else across, else new.
        for (slot, edge, other, other_slot) in [(1, h, n, 3), (3, p, p, 1)] {
            let own_side = there(level, next, other, other_slot);
            let known = own_side.or_else(|| {
                // The child at either end of the twin has the point.
                let t = level.across(edge)?;
                there(level, next, t, 1).or_else(|| there(level, next, level.next(t), 3))
            });
            at[slot] = known.unwrap_or_else(|| {
                let boundary = if level.twin[edge as usize] == NONE { BOUNDARY } else { 0 };
                let x = new_vertex(next, under, boundary);
                changes.dirty(l + 1).vertices.push(x);
                x
            });
        }
        let centre = level.of_face(f).find_map(|g| there(level, next, g, 2));
        at[2] = centre.unwrap_or_else(|| {
            let x = new_vertex(next, under, if level.valence(f) == 4 { 0 } else { EXTRAORDINARY });
            changes.dirty(l + 1).vertices.push(x);
            x
        });
        let c = new_face(next, fates, under);
        changes.came += 1;
        changes.dirty(l + 1).faces.push(c);
        changes.dirty(l + 1).corners.extend(at);
        changes.dirty(l + 1).sectors.extend(at);
        next.face[c as usize] = if l == 0 { u64::from(h) } else { 4 * level.face[f as usize] + u64::from(h & 3) };
        next.inside[c as usize] = own.asked[f as usize] > 0;
        under.parent[c as usize] = h;
        level.child[h as usize] = c;
        for (k, x) in at.into_iter().enumerate() {
            let g = 4 * c + k as u32;
            next.origin[g as usize] = x;
            next.tint[g as usize] = x;
            next.twin[g as usize] = CUT;
            if !next.sharp.is_empty() {
                next.sharp[g as usize] = false;
            }
            if !next.child.is_empty() {
                next.child[g as usize] = NONE;
            }
            under.around.insert(next, x, g);
        }
    }
    let slot_of = |c: u32, s: u32| if c < CUT { 4 * c + s } else { CUT };
    for &h in &spokes {
        let c = level.child[h as usize];
        let (n, p) = (level.next(h), level.prev(h));
        let start = match level.twin[h as usize] {
            t if t < CUT => slot_of(level.child[level.next(t) as usize], 3),
            t => t,
        };
        let end = match level.twin[p as usize] {
            t if t < CUT => slot_of(level.child[t as usize], 0),
            t => t,
        };
        let twins = [start, slot_of(level.child[n as usize], 2), slot_of(level.child[p as usize], 1), end];
        for (k, t) in twins.into_iter().enumerate() {
            let g = 4 * c + k as u32;
            next.twin[g as usize] = t;
            if t < CUT {
                next.twin[t as usize] = g;
            }
        }
    }
}

/// Takes away the children of all half-edges around vertex `v` of level `l`; they have no children themselves.
pub(super) fn shrink(refinement: &mut Refinement, index: &mut [LevelIndex], l: usize, v: u32, changes: &mut Changes) {
    let (coarse, fine) = refinement.levels.split_at_mut(l + 1);
    let (level, next) = (&mut coarse[l], &mut fine[0]);
    let (above, below) = index.split_at_mut(l + 1);
    let (own, under) = (&above[l], &mut below[0]);
    for &h in own.around.of(v) {
        let c = std::mem::replace(&mut level.child[h as usize], NONE);
        changes.went += 1;
        for g in 4 * c..4 * c + 4 {
            if let Some(t) = next.across(g) {
                next.twin[t as usize] = CUT;
            }
            let (x, tint) = (next.origin[g as usize], next.tint[g as usize]);
            under.around.remove(x, g);
            let left = under.around.of(x);
            if tint != x && left.iter().all(|&h| next.tint[h as usize] != tint) {
                under.free_values.push(tint);
            }
            if left.is_empty() {
                under.free_values.push(x);
            } else {
                changes.dirty(l + 1).corners.push(x);
            }
        }
        for f in (4 * c..4 * c + 4).filter_map(|g| next.across(g)) {
            changes.dirty(l + 1).faces.push(f >> 2);
        }
        next.face[c as usize] = u64::MAX;
        next.inside[c as usize] = false;
        refinement.fates[l + 1][c as usize] = 0;
        under.asked[c as usize] = 0;
        if under.drawn[c as usize] != NONE {
            changes.gone.push((l as u32 + 1, c));
        }
        under.free_faces.push(c);
    }
}
