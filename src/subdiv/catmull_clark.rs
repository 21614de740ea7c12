//! C, one Catmull-Clark step, on the part of a level that is wanted (ZHHK22 3.3, App. A; DKT98 for creases).
//!
//! The child of half-edge `h` (the quad at its origin) is made exactly where the origin touches a face to be
//! refined. So every wanted face gets its four children and a full ring of quads around them: what
//! ZHHK22 4.2 calls padding, without its outer half. Every vertex of a child that lies inside is then
//! computed from a complete neighbourhood.
//!
//! Positions: interior rules of Catmull and Clark with new face points, boundary curve `(a + 6 v + b) / 8`,
//! boundary corners kept or treated as the curve ([`CornerRule`]). Colours use the same connectivity; along
//! sharp edges every sector follows the boundary rules on its own, a dart is smooth.

mod connect;
mod numbering;

use super::level::{vertex_bits, Level, Value, CUT};
use crate::mesh::NONE;
use crate::scene::CornerRule;
use crate::threads;
use connect::connect;
use numbering::{number, touched_vertices, Points};
use std::ops::Range;
use std::sync::atomic::Ordering::Relaxed;
use vertex_bits::{BOUNDARY, CORNER, DART, EXTRAORDINARY, SECTORS};

/// Refines the faces marked in `wanted` (one flag a face) and fills `level.child`.
///
/// Time linear in the level's half-edges; children keep the slot order. Several cores take runs of faces; every sum has
/// the terms of the faces in their order all the same.
pub fn refine(level: &mut Level, wanted: &[bool], corners: CornerRule) -> Level {
    let runs = runs(level);
    let touched = touched_vertices(level, wanted, &runs);
    let points = number(level, &touched, &runs);
    let mut next = Level { level: level.level + 1, ..Level::default() };
    rules(level, &points, &runs, corners, &mut next);
    let sectors = sector_colours(level, &points, corners, &mut next);
    connect(level, wanted, &points, &sectors, &runs, &mut next);
    next
}

/// A run of faces and its half-edges.
struct Run {
    faces: Range<u32>,
    half_edges: Range<u32>,
}

fn runs(level: &Level) -> Vec<Run> {
    let run = |faces: Range<usize>| {
        let faces = faces.start as u32..faces.end as u32;
        Run { half_edges: level.first(faces.start)..level.first(faces.end), faces }
    };
    threads::pieces(level.faces()).into_iter().map(run).collect()
}

/// Cuts `all` into pieces of these lengths.
fn split<T>(mut all: &mut [T], lengths: impl Iterator<Item = usize>) -> Vec<&mut [T]> {
    let cut = |n: usize| {
        let (piece, rest) = std::mem::take(&mut all).split_at_mut(n);
        all = rest;
        piece
    };
    lengths.map(cut).collect()
}

/// Positions, colours (as if no edge were sharp; those at sharp edges are replaced later) and bits.
///
/// One pass over the faces: each adds its share to its corners and edges, so that a value is loaded once. The sums
/// run in the order of the faces, which is that of the slots. Where several cores work, a corner may lie in the faces of
/// two of them: then vertices gather their sums afterwards.
fn rules(level: &Level, points: &Points, runs: &[Run], corners: CornerRule, next: &mut Level) {
    // Edits of the next level add tints; a copy of everything for the first of them would be a waste.
    next.value.reserve_exact(points.count as usize + points.count as usize / 4 + 64);
    threads::append(&mut next.value, points.count as usize, |_| Value::default());
    next.bits.resize(points.count as usize, 0);
    let (vertices, values) = next.value.split_at_mut(points.first_edge as usize);
    let (edges, faces) = values.split_at_mut((points.first_face - points.first_edge) as usize);
    let (vertex_bits, bits) = next.bits.split_at_mut(points.first_edge as usize);
    let (edge_bits, face_bits) = bits.split_at_mut((points.first_face - points.first_edge) as usize);

    if let [run] = runs {
        // Faces around each extraordinary vertex; all others have four.
        let mut spokes = vec![0u32; if points.extraordinary { level.vertices() } else { 0 }];
        let own = Own { edge: points.first_edge, face: points.first_face, edges, edge_bits, faces, face_bits };
        face_shares(level, points, run, own, |h, to, ahead, behind, centre| {
            let v = level.origin[h as usize] as usize;
            let bits = level.bits[v];
            let ring = &mut vertices[to as usize];
            *ring = if bits & (BOUNDARY | DART | EXTRAORDINARY) == 0 {
                *ring + (ahead + centre)
            } else {
                if bits & EXTRAORDINARY != 0 {
                    spokes[v] += 1;
                }
                ring_share(level, h, *ring, ahead, behind, centre)
            };
        });
        for (v, &to) in points.vertex.iter().enumerate() {
            if to != NONE {
                let bits = level.bits[v];
                let n = if bits & EXTRAORDINARY == 0 { 4 } else { spokes[v] };
                vertex_bits[to as usize] = bits;
                let ring = &mut vertices[to as usize];
                *ring = vertex_point(level.value[v], *ring, bits, n, corners);
            }
        }
    } else {
        let counts = |k: usize| points.of_run.iter().map(move |n| n[k] as usize);
        let edges_of = split(edges, counts(1)).into_iter().zip(split(edge_bits, counts(1)));
        let faces_of = split(faces, counts(2)).into_iter().zip(split(face_bits, counts(2)));
        let (mut edge, mut face) = (points.first_edge, points.first_face);
        let work = edges_of.zip(faces_of).zip(runs).map(|(((edges, edge_bits), (faces, face_bits)), run)| {
            let own = Own { edge, face, edges, edge_bits, faces, face_bits };
            (edge, face) = (edge + own.edges.len() as u32, face + own.faces.len() as u32);
            (run, own)
        });
        let seams =
            threads::each(work.collect(), |(run, own)| face_shares(level, points, run, own, |_, _, _, _, _| {}));
        for (to, share) in seams.into_iter().flatten() {
            let edge = &mut edges[(to - points.first_edge) as usize];
            *edge = *edge + share;
        }
        let pieces = threads::pieces(level.vertices());
        let kept = |range: &Range<usize>| points.vertex[range.clone()].iter().filter(|&&v| v != NONE).count();
        let lengths = threads::each(pieces.iter().collect(), kept);
        let lists = split(vertices, lengths.iter().copied()).into_iter();
        let lists = lists.zip(split(vertex_bits, lengths.iter().copied()));
        threads::each(pieces.into_iter().zip(lists).collect(), |(range, (values, bits))| {
            let mut spokes = Vec::with_capacity(8);
            let kept = range.filter(|&v| points.vertex[v] != NONE);
            for ((v, value), to_bits) in kept.zip(values).zip(bits) {
                *to_bits = level.bits[v];
                *value = gathered(level, points, faces, v, corners, &mut spokes);
            }
        });
    }
    let pieces = threads::pieces(edges.len());
    let lists = split(edges, pieces.iter().map(Range::len)).into_iter();
    threads::each(lists.zip(split(edge_bits, pieces.iter().map(Range::len))).collect(), |(values, bits)| {
        for (value, bits) in values.iter_mut().zip(bits) {
            if *bits & BOUNDARY == 0 {
                *value = *value * 0.25;
            }
        }
    });
}

/// What a run of faces writes: its edge points, the first of them `edge`, and its face points.
struct Own<'a> {
    edge: u32,
    face: u32,
    edges: &'a mut [Value],
    edge_bits: &'a mut [u8],
    faces: &'a mut [Value],
    face_bits: &'a mut [u8],
}

/// Makes the face points of a run, and adds what each face has to say to its edges and, by `corner`, to its corners:
/// half-edge, the next level's vertex, neighbours ahead and behind, face point. Returns what goes to edges of an earlier run.
fn face_shares(
    level: &Level,
    points: &Points,
    run: &Run,
    own: Own,
    mut corner_share: impl FnMut(u32, u32, Value, Value, Value),
) -> Vec<(u32, Value)> {
    let mut seams = Vec::new();
    for f in run.faces.start..run.faces.end.min(level.quads) {
        let to = points.face[f as usize];
        if to == NONE {
            continue;
        }
        let corner = level.quad_values(f);
        let centre = ((corner[0] + corner[1]) + (corner[2] + corner[3])) * 0.25;
        own.faces[(to - own.face) as usize] = centre;
        let edges = Level::quad(&points.edge, f);
        let twins = Level::quad(&level.twin, f);
        let origin = Level::quad(&level.origin, f);
        for i in 0..4 {
            let (ahead, behind) = (corner[(i + 1) & 3], corner[(i + 3) & 3]);
            let (to_edge, to_vertex) = (edges[i], points.vertex[origin[i] as usize]);
            if to_edge != NONE {
                let half = (corner[i] + ahead) * 0.5;
                if to_edge < own.edge {
                    seams.push((to_edge, half + centre));
                } else if twins[i] == NONE {
                    own.edges[(to_edge - own.edge) as usize] = half;
                    own.edge_bits[(to_edge - own.edge) as usize] = BOUNDARY;
                } else {
                    let edge = &mut own.edges[(to_edge - own.edge) as usize];
                    *edge = *edge + (half + centre);
                }
            }
            if to_vertex != NONE {
                corner_share(4 * f + i as u32, to_vertex, ahead, behind, centre);
            }
        }
    }
    for f in run.faces.start.max(level.quads)..run.faces.end {
        let to = points.face[f as usize];
        if to == NONE {
            continue;
        }
        let n = level.valence(f);
        let sum = level.of_face(f).fold(Value::default(), |sum, h| sum + level.at(h));
        let centre = sum * (1.0 / f64::from(n));
        own.faces[(to - own.face) as usize] = centre;
        if n != 4 {
            own.face_bits[(to - own.face) as usize] = EXTRAORDINARY;
        }
        for h in level.of_face(f) {
            let (ahead, behind) = (level.at(level.next(h)), level.at(level.prev(h)));
            let (to_edge, to_vertex) = (points.edge[h as usize], points.vertex[level.origin[h as usize] as usize]);
            if to_edge != NONE {
                // Every edge of a shrunk face is an inner one.
                let share = (level.at(h) + ahead) * 0.5 + centre;
                if to_edge < own.edge {
                    seams.push((to_edge, share));
                } else {
                    let edge = &mut own.edges[(to_edge - own.edge) as usize];
                    *edge = *edge + share;
                }
            }
            if to_vertex != NONE {
                corner_share(h, to_vertex, ahead, behind, centre);
            }
        }
    }
    seams
}

/// The vertex `v` in the next level, from the faces around it in their order; all of them are there, since it is the
/// corner of a wanted one.
fn gathered(
    level: &Level,
    points: &Points,
    face_points: &[Value],
    v: usize,
    corners: CornerRule,
    spokes: &mut Vec<u32>,
) -> Value {
    let bits = level.bits[v];
    let spoke = points.spoke[v].load(Relaxed);
    let mut ring = Value::default();
    if bits & (BOUNDARY | DART | EXTRAORDINARY) == 0 && level.level > 0 {
        // Four quads around it, as around nearly all.
        let after = |h: u32| level.twin[(h & !3 | (h + 3) & 3) as usize];
        let [a, b, c] = [after(spoke), after(after(spoke)), after(after(after(spoke)))];
        let (low, high) = ([spoke.min(a), b.min(c)], [spoke.max(a), b.max(c)]);
        let middle = [low[0].max(low[1]), high[0].min(high[1])];
        let four = [low[0].min(low[1]), middle[0].min(middle[1]), middle[0].max(middle[1]), high[0].max(high[1])];
        for h in four {
            let centre = face_points[(points.face[h as usize >> 2] - points.first_face) as usize];
            ring = ring + (level.at(h & !3 | (h + 1) & 3) + centre);
        }
        return vertex_point(level.value[v], ring, bits, 4, corners);
    }
    spokes.clear();
    level.around(spoke, |h| spokes.push(h));
    spokes.sort_unstable();
    for &h in &*spokes {
        let ahead = level.at(level.next(h));
        let centre = face_points[(points.face[level.face_of(h) as usize] - points.first_face) as usize];
        ring = if bits & (BOUNDARY | DART) == 0 {
            ring + (ahead + centre)
        } else {
            ring_share(level, h, ring, ahead, level.at(level.prev(h)), centre)
        };
    }
    let n = if bits & EXTRAORDINARY == 0 { 4 } else { spokes.len() as u32 };
    vertex_point(level.value[v], ring, bits, n, corners)
}

/// The rule for a vertex of `n` faces.
fn vertex_point(old: Value, ring: Value, bits: u8, n: u32, corners: CornerRule) -> Value {
    if bits & BOUNDARY == 0 {
        let n = f64::from(n);
        old * ((n - 2.0) / n) + ring * (1.0 / (n * n))
    } else if bits & CORNER != 0 && corners == CornerRule::Sharp {
        old
    } else {
        curve(old, ring)
    }
}

/// `ring` and what the face of `h` adds to it, around the origin of `h`: its neighbour ahead and the face point, or on the
/// boundary the boundary neighbours.
fn ring_share(level: &Level, h: u32, mut ring: Value, ahead: Value, behind: Value, centre: Value) -> Value {
    let twin = level.twin[h as usize];
    let bits = level.bits[level.origin[h as usize] as usize];
    if bits & BOUNDARY != 0 {
        // One boundary neighbour is seen from the half-edge that leaves, one from that which arrives.
        if twin == NONE {
            ring = ring + ahead;
        }
        if level.twin[level.prev(h) as usize] == NONE {
            ring = ring + behind;
        }
        return ring;
    }
    let mut far = ahead;
    if bits & DART != 0 && twin < CUT {
        // The far end of the sharp spoke has two colours there; seen from a dart it has their mean.
        far.c = (far.c + level.corner_colour(twin)) * 0.5;
    }
    ring + (far + centre)
}

/// `(a + 6 v + b) / 8`, with `ends = a + b`.
fn curve<V: std::ops::Mul<f64, Output = V> + std::ops::Add<Output = V>>(v: V, ends: V) -> V {
    v * 0.75 + ends * 0.125
}

/// Tints of the next level where sharp edges make them differ from the vertex's own.
#[derive(Default)]
struct SectorColours {
    /// For each half-edge that leaves a parted vertex: the tint of its corner. Empty without sharp edges.
    corner: Vec<u32>,
    /// For each sharp half-edge: the tint of its side of the edge point.
    side: Vec<u32>,
}

fn sector_colours(level: &Level, points: &Points, corners: CornerRule, next: &mut Level) -> SectorColours {
    if level.sharp.is_empty() {
        return SectorColours::default();
    }
    let mut corner = vec![NONE; level.half_edges()];
    let mut side = points.edge.clone();
    // Few half-edges matter: those along sharp edges, and the boundary ones that start a sector.
    let among = |half_edges: Range<usize>| {
        let is_border = |&h: &usize| level.sharp[h] || level.twin[h] == NONE;
        half_edges.filter(is_border).map(|h| h as u32).collect()
    };
    let borders: Vec<Vec<u32>> = threads::each(threads::pieces(level.half_edges()), among);
    let borders = borders.concat();
    for &h in borders.iter().filter(|&&h| level.sharp[h as usize]) {
        let to = points.edge[h as usize];
        if to != NONE {
            let middle = (level.corner_colour(h) + level.corner_colour(level.next(h))) * 0.5;
            next.bits[to as usize] |= SECTORS;
            if level.twin[h as usize] < h {
                side[h as usize] = next.new_tint(to, middle);
            } else {
                next.value[to as usize].c = middle;
            }
        }
    }
    let mut taken = vec![false; level.vertices()];
    for h in borders {
        let v = level.origin[h as usize] as usize;
        let to = points.vertex[v];
        if to == NONE || level.bits[v] & SECTORS == 0 {
            continue;
        }
        // `h` is the first spoke of a sector.
        let c = level.corner_colour(h);
        let a = level.corner_colour(level.next(h));
        let mut last = h;
        while let Some(s) = level.spoke_after(last) {
            if level.colour_border(s) {
                break;
            }
            last = s;
        }
        let colour = if last == h && corners == CornerRule::Sharp {
            c
        } else {
            curve(c, a + level.corner_colour(level.prev(last)))
        };
        let tint = if taken[v] {
            next.new_tint(to, colour)
        } else {
            taken[v] = true;
            next.value[to as usize].c = colour;
            to
        };
        let mut spoke = h;
        corner[spoke as usize] = tint;
        while spoke != last {
            spoke = level.spoke_after(spoke).expect("a sector ends where it was seen to end");
            corner[spoke as usize] = tint;
        }
    }
    SectorColours { corner, side }
}
