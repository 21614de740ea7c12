//! Hierarchical edits of one level (ZHHK22 3.3, Fig. 3; VK18 4.2), by the rules of the authors' tool.
//!
//! All geometry edits of a level read the positions that Catmull-Clark gave and are added at once, so their
//! order does not matter. Colour edits come in three passes: all colours are written, every sector of every
//! edited vertex spreads its own colour over its quad (so that the limit interpolates it), and the two spokes
//! of an edited sector become sharp where the colour across differs.

use super::level::Level;
use crate::mesh::NONE;
use crate::threads;
use glam::{DVec2, DVec4};
use std::ops::Range;

/// How a geometry edit finds its vertex and frame from a local half-edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The half-edge leaves the vertex and is e1; e2 is the next spoke.
    Sector,
    /// The half-edge's boundary twin is e1: the vertex is the half-edge's target, e2 the boundary edge that leaves it.
    SectorBeyond,
    /// As [`Anchor::SectorBeyond`], with angle and length (eq. 2).
    Boundary,
}

/// A geometry edit on this level's half-edges.
#[derive(Clone, Copy, Debug)]
pub struct LocalMove {
    /// Half-edge of the level.
    pub half_edge: u32,
    /// What it stands for.
    pub anchor: Anchor,
    /// First coordinate.
    pub a: f64,
    /// Second coordinate.
    pub b: f64,
}

/// Adds all geometry edits of a level.
pub fn move_vertices(level: &mut Level, moves: &[LocalMove]) {
    let of_run = |run: Range<usize>| moves[run].iter().map(|m| displacement(level, m)).collect::<Vec<_>>();
    let steps = threads::each(threads::pieces_worth(moves.len(), 16), of_run);
    for (spoke, step) in steps.into_iter().flatten() {
        level.shift(spoke, step);
    }
}

/// A half-edge that leaves the moved vertex, and the step.
fn displacement(level: &Level, m: &LocalMove) -> (u32, DVec2) {
    let at = |v: u32| level.value[v as usize].p;
    let (spoke, end1, end2) = frame(level, m);
    let v = level.origin[spoke as usize];
    (spoke, step(m, at(end1) - at(v), at(end2) - at(v)))
}

/// A half-edge that leaves the moved vertex, and the vertices that its local frame points to.
pub fn frame(level: &Level, m: &LocalMove) -> (u32, u32, u32) {
    let h = m.half_edge;
    match m.anchor {
        Anchor::Sector => (h, level.target(h), level.origin[level.prev(h) as usize]),
        Anchor::SectorBeyond | Anchor::Boundary => {
            let spoke = level.next(h);
            let first = level.fan_start(spoke, |_| false);
            (spoke, level.origin[h as usize], level.target(first))
        }
    }
}

/// The step of a geometry edit in the frame `e1`, `e2`.
pub fn step(m: &LocalMove, e1: DVec2, e2: DVec2) -> DVec2 {
    match m.anchor {
        Anchor::Boundary => {
            let start = e1.y.atan2(e1.x);
            let mut angle = e2.y.atan2(e2.x) - start;
            if angle < 0.0 {
                angle += std::f64::consts::TAU;
            }
            let length = (m.b * e1.length() * e2.length()).max(0.0).sqrt();
            DVec2::from_angle(start + angle * m.a) * length
        }
        _ => e1 * m.a + e2 * m.b,
    }
}

/// The inverse of a sector edit: the `(a, b)` that moves the origin of `h` by `step`; `None` if the frame is flat.
pub fn sector_coordinates(level: &Level, h: u32, step: DVec2) -> Option<(f64, f64)> {
    let at = |v: u32| level.value[v as usize].p;
    let v = at(level.origin[h as usize]);
    let e1 = at(level.target(h)) - v;
    let e2 = at(level.origin[level.prev(h) as usize]) - v;
    let det = e1.perp_dot(e2);
    (det != 0.0).then(|| (step.perp_dot(e2) / det, e1.perp_dot(step) / det))
}

/// Writes, spreads and sharpens all colour edits of a level: `(half-edge of the sector, colour)`, each sector once.
pub fn paint(level: &mut Level, edits: &[(u32, DVec4)]) {
    for &(h, colour) in edits {
        level.tint[h as usize] = level.new_tint(level.origin[h as usize], colour);
    }
    // One spoke for each edited vertex, whichever of its sectors were edited.
    let edited: Vec<u32> = edits.iter().map(|e| e.0).collect();
    let spokes = each_vertex_once(level, &edited);

    let mut settle = Vec::new();
    let mut sectors = Vec::new();
    for spoke in spokes {
        settle.push(spoke);
        sectors.clear();
        level.around(spoke, |h| sectors.push(h));
        for &h in &sectors {
            spread(level, h, &mut settle);
        }
    }
    for &(h, _) in edits {
        let own = level.corner_colour(h);
        if let Some(t) = level.across(h) {
            if level.corner_colour(level.next(t)) != own {
                sharpen(level, h, &mut settle);
            }
        }
        if let Some(t) = level.spoke_after(h) {
            if level.corner_colour(t) != own {
                sharpen(level, t, &mut settle);
            }
        }
    }
    let mut spokes = Vec::new();
    for h in each_vertex_once(level, &settle) {
        level.settle_colours(h, &mut spokes);
    }
}

/// Of half-edges that leave the same vertex the least, in the order of the vertices.
fn each_vertex_once(level: &Level, half_edges: &[u32]) -> Vec<u32> {
    if half_edges.len() < level.vertices() / 8 {
        let mut named: Vec<u64> =
            half_edges.iter().map(|&h| u64::from(level.origin[h as usize]) << 32 | u64::from(h)).collect();
        named.sort_unstable();
        named.dedup_by_key(|n| *n >> 32);
        return named.into_iter().map(|n| n as u32).collect();
    }
    // So many that a look at every vertex costs less than sorting.
    let mut least = vec![NONE; level.vertices()];
    for &h in half_edges {
        let least = &mut least[level.origin[h as usize] as usize];
        *least = h.min(*least);
    }
    least.retain(|&h| h != NONE);
    least
}

/// The sector's colour goes over its quad `v, a, c, d`: to the corners of `a` and `d` on this side of the
/// spokes, and to all corners of `c`.
fn spread(level: &mut Level, h: u32, settle: &mut Vec<u32>) {
    let colour = level.corner_colour(h);
    let tint = level.new_tint(level.origin[h as usize], colour);
    let a = level.next(h);
    let c = level.next(a);
    let d = level.prev(h);
    for corner in [a, d] {
        level.tint[corner as usize] = tint;
    }
    if let Some(t) = level.across(a) {
        let beyond = level.next(t);
        level.tint[beyond as usize] = tint;
    }
    if let Some(t) = level.across(c) {
        level.tint[t as usize] = tint;
    }
    // No edge at `c` is ever sharp: it lies inside a face of C^l of the input, sharp edges along its sides.
    let v = level.origin[c as usize];
    level.value[v as usize].c = colour;
    settle.extend([a, d]);
}

/// Marks the spoke `h` and the next two edges straight on.
fn sharpen(level: &mut Level, h: u32, settle: &mut Vec<u32>) {
    let mut e = h;
    for step in 0..3 {
        level.set_sharp(e);
        settle.push(e);
        let g = level.next(e);
        if step == 2 {
            settle.push(g);
        } else {
            match level.across(g) {
                Some(t) => e = level.next(t),
                None => {
                    settle.push(g);
                    return;
                }
            }
        }
    }
}

/// Marks the three edges of M^0 along an input edge as sharp for colour; `h` is the input half-edge. A boundary edge
/// is a border for colours anyway.
pub fn tag_sharp(level: &mut Level, h: u32) {
    debug_assert_eq!(level.level, 0);
    // Slot 8 h leaves the input vertex along the edge.
    if level.across(8 * h).is_none() {
        return;
    }
    let mut settle = Vec::new();
    sharpen(level, 8 * h, &mut settle);
    let mut spokes = Vec::new();
    for h in settle {
        level.settle_colours(h, &mut spokes);
    }
}
