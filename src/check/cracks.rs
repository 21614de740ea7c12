//! Cracks: background pixels inside the surface.
//!
//! Inside is decided without the GPU: a pixel lies inside where the boundary of the mesh, with the segments that the
//! tessellator makes of it, winds round the pixel's centre. So a crack is found wherever the surface ought to cover,
//! holes in the mesh notwithstanding. The boundary comes from the half-edges ([`boundary`]), not from the patches:
//! those of a cracked surface have edges without a partner along the cracks too ([`outline`]).

use crate::mesh::HalfEdgeMesh;
use crate::patch::build::face_control;
use crate::patch::eval;
use crate::patch::tess::TessRule;
use crate::patch::transition::{Side, PARTS};
use crate::patch::{ControlPoint, DrawRange, PatchTable};
use crate::refine::forest::first_slot;
use crate::subdiv::index_map::IndexMap;
use glam::DVec2;
use std::collections::HashMap;

/// A pixel whose centre is nearer than this to the outline may be drawn or not: device coordinates are snapped to
/// 1/16 to 1/256 of a pixel.
pub const AMBIGUOUS: f64 = 0.08;

/// One edge of the outline.
#[derive(Clone, Copy, Debug)]
pub struct OutlineEdge {
    /// Its four Bezier points.
    pub points: [DVec2; 4],
    /// Level whose tessellation the edge has: that of its face, or one finer for half of a transition edge.
    pub level: u32,
}

/// Edges that belong to one patch only, in the direction of that patch. A table without cracks has the boundary of
/// the mesh here and nothing else.
pub fn outline(table: &PatchTable) -> Vec<OutlineEdge> {
    let mut open: HashMap<[[u64; 2]; 4], Vec<(OutlineEdge, i32)>> = HashMap::new();
    for range in &table.ranges {
        let stride = range.stride();
        for patch in 0..range.count as usize {
            let first = range.first as usize + patch * stride;
            let ids = &table.indices[first..first + stride];
            for (slots, finer) in sides(range) {
                let points = slots.map(|s| position(&table.control[ids[s] as usize]));
                let edge = OutlineEdge { points, level: range.level + finer };
                let bits = points.map(|p| [p.x.to_bits(), p.y.to_bits()]);
                let mut back = bits;
                back.reverse();
                if bits == back {
                    // There and back on the same line: it bounds nothing, and has no direction to pair it by.
                    continue;
                }
                let (key, sign) = if bits <= back { (bits, 1) } else { (back, -1) };
                open.entry(key).or_default().push((edge, sign));
            }
        }
    }
    let mut edges: Vec<OutlineEdge> = Vec::new();
    for seen in open.into_values() {
        let sum: i32 = seen.iter().map(|s| s.1).sum();
        if let Some((edge, _)) = seen.iter().find(|s| s.1 == sum.signum()) {
            edges.extend(std::iter::repeat_n(*edge, sum.unsigned_abs() as usize));
        }
    }
    edges
}

/// Edges of the drawn faces that lie on the boundary of the mesh, in the direction of their faces: closed curves.
pub fn boundary(table: &PatchTable, mesh: &HalfEdgeMesh) -> Vec<OutlineEdge> {
    let map = IndexMap::new(mesh);
    let mut edges = Vec::new();
    for face in &table.faces {
        let mut slot = first_slot(&map, face.level, face.name);
        for _ in 0..face.turn {
            slot = map.next(face.level, slot);
        }
        let mut control = Vec::new();
        for slots in eval::FACE_EDGES {
            if map.twin(face.level, slot).is_none() {
                if control.is_empty() {
                    control = face_control(table, face);
                }
                edges.push(OutlineEdge { points: slots.map(|s| position(&control[s])), level: face.level });
            }
            slot = map.next(face.level, slot);
        }
    }
    edges
}

fn position(c: &ControlPoint) -> DVec2 {
    DVec2::new(c[0], c[1])
}

/// Control point slots of the outer sides of a patch, and 1 for those that have the next level's tessellation.
fn sides(range: &DrawRange) -> impl Iterator<Item = ([usize; 4], u32)> {
    let (kind, part) = (range.kind, range.part);
    (0..eval::sides(part)).filter_map(move |i| {
        let half = part.is_some_and(|p| matches!(PARTS[p as usize].sides[i], Side::Half(_)));
        eval::side_points(kind, part, i).map(|points| (points, u32::from(half)))
    })
}

/// Segments of the outline in pixels (x right, y down, pixel centres at halves) under a tessellation rule, where no level
/// exceeds `most` ([`crate::patch::tess::greatest`]).
pub fn segments(
    edges: &[OutlineEdge],
    tess: TessRule,
    most: f32,
    view: [f64; 4],
    [width, height]: [u32; 2],
) -> Vec<[DVec2; 2]> {
    let scale = DVec2::new(f64::from(width) / (view[2] - view[0]), f64::from(height) / (view[3] - view[1]));
    let pixel = |p: DVec2| DVec2::new((p.x - view[0]) * scale.x, (view[3] - p.y) * scale.y);
    let mut out = Vec::new();
    for e in edges {
        let q = e.points.map(pixel);
        let n = match tess {
            // The control polygon's length over the pixels asked for, as `eval::pixel_level`.
            TessRule::Pixels(pixels) => {
                let length: f64 = q.windows(2).map(|p| (p[1] - p[0]).length()).sum();
                (length / f64::from(pixels)).ceil().clamp(1.0, f64::from(most)) as u32
            }
            _ => tess.levels_to(e.level, most).full as u32,
        };
        let mut from = q[0];
        for k in 1..=n {
            let t = f64::from(k) / f64::from(n);
            let s = 1.0 - t;
            let to = if k == n {
                q[3]
            } else {
                q[0] * (s * s * s) + q[1] * (3.0 * s * s * t) + q[2] * (3.0 * s * t * t) + q[3] * (t * t * t)
            };
            out.push([from, to]);
            from = to;
        }
    }
    out
}

/// Winding number of closed `segments` about every pixel centre, rows from the top.
pub fn winding(segments: &[[DVec2; 2]], width: u32, height: u32) -> Vec<i32> {
    let (w, h) = (width as usize, height as usize);
    let mut turns = vec![0i32; (w + 1) * h];
    for &[a, b] in segments {
        let (top, bottom, sign) = if a.y < b.y { (a, b, 1) } else { (b, a, -1) };
        let first = (top.y - 0.5).ceil().max(0.0);
        let last = (bottom.y - 0.5).ceil().min(h as f64);
        let mut row = first;
        while row < last {
            let x = top.x + (row + 0.5 - top.y) / (bottom.y - top.y) * (bottom.x - top.x);
            let column = (x - 0.5).ceil().clamp(0.0, w as f64) as usize;
            turns[row as usize * (w + 1) + column] += sign;
            row += 1.0;
        }
    }
    let mut out = Vec::with_capacity(w * h);
    for row in turns.chunks(w + 1) {
        let mut sum = 0;
        out.extend(row[..w].iter().map(|t| {
            sum += t;
            sum
        }));
    }
    out
}

/// Pixels (column, row) inside the outline that are background; `covered[row * width + column]` says what was drawn.
pub fn find(segments: &[[DVec2; 2]], covered: &[bool], width: u32, height: u32) -> Vec<[u32; 2]> {
    find_beyond(segments, covered, width, height, AMBIGUOUS)
}

/// As [`find`], where pixels nearer than `margin` to the outline do not count: for outlines that are not the very segments
/// that the tessellator makes.
pub fn find_beyond(segments: &[[DVec2; 2]], covered: &[bool], width: u32, height: u32, margin: f64) -> Vec<[u32; 2]> {
    let winding = winding(segments, width, height);
    let candidates = winding.iter().zip(covered).enumerate().filter(|(_, (&w, &c))| w != 0 && !c);
    candidates
        .map(|(i, _)| [i as u32 % width, i as u32 / width])
        .filter(|&[x, y]| {
            let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            segments.iter().all(|&[a, b]| distance(centre, a, b) > margin)
        })
        .collect()
}

/// Distance of `p` from the segment from `a` to `b`.
pub fn distance(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let d = b - a;
    let t = if d == DVec2::ZERO { 0.0 } else { ((p - a).dot(d) / d.length_squared()).clamp(0.0, 1.0) };
    (p - (a + d * t)).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_with_a_hole_winds_once_and_not_at_all() {
        let ring = |x: f64, r: f64| {
            let c = [
                DVec2::new(x - r, x - r),
                DVec2::new(x + r, x - r),
                DVec2::new(x + r, x + r),
                DVec2::new(x - r, x + r),
            ];
            (0..4).map(move |i| [c[i], c[(i + 1) % 4]])
        };
        let mut segments: Vec<_> = ring(4.0, 3.0).collect();
        segments.extend(ring(4.0, 1.0).map(|[a, b]| [b, a]));
        let w = winding(&segments, 8, 8);
        assert_eq!(w.iter().filter(|&&x| x != 0).count(), 36 - 4);
        let all = vec![true; 64];
        assert!(find(&segments, &all, 8, 8).is_empty());
        let mut torn = all;
        torn[8 * 2 + 3] = false; // inside
        torn[8 * 4 + 4] = false; // in the hole
        torn[0] = false; // outside
        assert_eq!(find(&segments, &torn, 8, 8), [[3, 2]]);
    }
}
