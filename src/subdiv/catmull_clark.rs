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

use super::level::{vertex_bits, Level, Value, CUT};
use crate::mesh::NONE;
use crate::scene::CornerRule;
use vertex_bits::{BOUNDARY, CORNER, DART, EXTRAORDINARY, SECTORS};

/// Refines the faces marked in `wanted` (one flag a face) and fills `level.child`.
///
/// Time linear in the level's half-edges; children keep the slot order.
pub fn refine(level: &mut Level, wanted: &[bool], corners: CornerRule) -> Level {
    let touched = touched_vertices(level, wanted);
    let children = number_children(level, &touched);
    let points = number_points(level, &touched);
    let mut next = Level { level: level.level + 1, ..Level::default() };
    rules(level, &points, corners, &mut next);
    let sectors = sector_colours(level, &points, corners, &mut next);
    connect(level, wanted, &points, &sectors, children, &mut next);
    next
}

fn touched_vertices(level: &Level, wanted: &[bool]) -> Vec<bool> {
    let mut touched = vec![false; level.vertices()];
    for (corners, &wanted) in level.origin.chunks_exact(4).zip(&wanted[..level.quads as usize]) {
        if wanted {
            corners.iter().for_each(|&v| touched[v as usize] = true);
        }
    }
    for f in level.quads..level.faces() as u32 {
        if wanted[f as usize] {
            level.of_face(f).for_each(|h| touched[level.origin[h as usize] as usize] = true);
        }
    }
    touched
}

fn number_children(level: &mut Level, touched: &[bool]) -> usize {
    let mut children = 0;
    level.child.clear();
    level.child.extend(level.origin.iter().map(|&v| {
        if touched[v as usize] {
            children += 1;
            children - 1
        } else {
            NONE
        }
    }));
    children as usize
}

/// Numbers of the next level's vertices: old ones, edge points, face points.
struct Points {
    /// Old vertices in the next level, [`NONE`] where they are not needed.
    vertex: Vec<u32>,
    /// Edge point of each half-edge's edge.
    edge: Vec<u32>,
    /// Face points.
    face: Vec<u32>,
    first_edge: u32,
    first_face: u32,
    count: u32,
    /// Whether a vertex that is kept is extraordinary.
    extraordinary: bool,
}

fn number_points(level: &Level, touched: &[bool]) -> Points {
    let mut count = 0;
    let mut extraordinary = 0;
    let mut vertex = vec![NONE; level.vertices()];
    for (v, &t) in touched.iter().enumerate() {
        if t {
            vertex[v] = count;
            count += 1;
            extraordinary |= level.bits[v] & EXTRAORDINARY;
        }
    }
    let first_edge = count;
    let mut edge = vec![NONE; level.half_edges()];
    let mut face = vec![NONE; level.faces()];
    // An edge needs its point if one of its ends is touched, which its half-edges' children tell; a face if any corner is.
    for f in 0..level.quads {
        let child = Level::quad(&level.child, f);
        if child == [NONE; 4] {
            continue;
        }
        face[f as usize] = 0;
        let twin = Level::quad(&level.twin, f);
        for i in 0..4 {
            let h = 4 * f + i as u32;
            edge[h as usize] = if twin[i] < h {
                edge[twin[i] as usize]
            } else if child[i] != NONE || child[(i + 1) & 3] != NONE {
                count += 1;
                count - 1
            } else {
                NONE
            };
        }
    }
    for f in level.quads..level.faces() as u32 {
        for h in level.of_face(f) {
            let own = level.child[h as usize] != NONE;
            if own {
                face[f as usize] = 0;
            }
            let t = level.twin[h as usize];
            edge[h as usize] = if t < h {
                edge[t as usize]
            } else if own || level.child[level.next(h) as usize] != NONE {
                count += 1;
                count - 1
            } else {
                NONE
            };
        }
    }
    let first_face = count;
    for number in face.iter_mut().filter(|f| **f == 0) {
        *number = count;
        count += 1;
    }
    Points { vertex, edge, face, first_edge, first_face, count, extraordinary: extraordinary != 0 }
}

/// Positions, colours (as if no edge were sharp; those at sharp edges are replaced later) and bits.
///
/// One pass over the faces: each adds its share to its corners and edges, so that a value is loaded once. The sums
/// run in the order of the faces, which is that of the slots.
fn rules(level: &Level, points: &Points, corners: CornerRule, next: &mut Level) {
    // Edits of the next level add tints; a copy of everything for the first of them would be a waste.
    next.value.reserve_exact(points.count as usize + points.count as usize / 4 + 64);
    next.value.resize(points.count as usize, Value::default());
    next.bits.resize(points.count as usize, 0);
    // Faces around each extraordinary vertex; all others have four.
    let mut spokes = vec![0u32; if points.extraordinary { level.vertices() } else { 0 }];

    for f in 0..level.faces() as u32 {
        let to = points.face[f as usize];
        if to == NONE {
            continue;
        }
        let first = level.first(f);
        if f < level.quads {
            let corner = level.quad_values(f);
            let centre = ((corner[0] + corner[1]) + (corner[2] + corner[3])) * 0.25;
            next.value[to as usize] = centre;
            let edges = Level::quad(&points.edge, f);
            let twins = Level::quad(&level.twin, f);
            let origin = Level::quad(&level.origin, f);
            for i in 0..4 {
                let (ahead, behind) = (corner[(i + 1) & 3], corner[(i + 3) & 3]);
                let v = origin[i] as usize;
                let (to_edge, to_vertex) = (edges[i] as usize, points.vertex[v] as usize);
                if to_edge != NONE as usize {
                    let half = (corner[i] + ahead) * 0.5;
                    if twins[i] == NONE {
                        next.value[to_edge] = half;
                        next.bits[to_edge] = BOUNDARY;
                    } else {
                        next.value[to_edge] = next.value[to_edge] + (half + centre);
                    }
                }
                if to_vertex != NONE as usize {
                    if level.bits[v] & (BOUNDARY | DART | EXTRAORDINARY) == 0 {
                        next.value[to_vertex] = next.value[to_vertex] + (ahead + centre);
                    } else {
                        ring_share(level, first + i as u32, to_vertex, ahead, behind, centre, next, &mut spokes);
                    }
                }
            }
        } else {
            let n = level.valence(f);
            let sum = level.of_face(f).fold(Value::default(), |sum, h| sum + level.at(h));
            let centre = sum * (1.0 / f64::from(n));
            next.value[to as usize] = centre;
            if n != 4 {
                next.bits[to as usize] = EXTRAORDINARY;
            }
            for h in level.of_face(f) {
                let (ahead, behind) = (level.at(level.next(h)), level.at(level.prev(h)));
                let (to_edge, to_vertex) = (points.edge[h as usize], points.vertex[level.origin[h as usize] as usize]);
                if to_edge != NONE {
                    // Every edge of a shrunk face is an inner one.
                    let half = (level.at(h) + ahead) * 0.5;
                    next.value[to_edge as usize] = next.value[to_edge as usize] + (half + centre);
                }
                if to_vertex != NONE {
                    ring_share(level, h, to_vertex as usize, ahead, behind, centre, next, &mut spokes);
                }
            }
        }
    }

    for e in points.first_edge..points.first_face {
        if next.bits[e as usize] & BOUNDARY == 0 {
            next.value[e as usize] = next.value[e as usize] * 0.25;
        }
    }
    for (v, &to) in points.vertex.iter().enumerate() {
        if to == NONE {
            continue;
        }
        let bits = level.bits[v];
        let (old, ring) = (level.value[v], next.value[to as usize]);
        next.bits[to as usize] = bits;
        next.value[to as usize] = if bits & BOUNDARY == 0 {
            let n = if bits & EXTRAORDINARY == 0 { 4.0 } else { f64::from(spokes[v]) };
            old * ((n - 2.0) / n) + ring * (1.0 / (n * n))
        } else if bits & CORNER != 0 && corners == CornerRule::Sharp {
            old
        } else {
            curve(old, ring)
        };
    }
}

/// What the face of `h` adds to the ring of the origin of `h`, the next level's vertex `to`: its neighbour ahead and
/// the face point, or on the boundary the boundary neighbours.
#[allow(clippy::too_many_arguments)]
fn ring_share(
    level: &Level,
    h: u32,
    to: usize,
    ahead: Value,
    behind: Value,
    centre: Value,
    next: &mut Level,
    spokes: &mut [u32],
) {
    let v = level.origin[h as usize] as usize;
    let twin = level.twin[h as usize];
    let bits = level.bits[v];
    if bits & BOUNDARY != 0 {
        // One boundary neighbour is seen from the half-edge that leaves, one from that which arrives.
        if twin == NONE {
            next.value[to] = next.value[to] + ahead;
        }
        if level.twin[level.prev(h) as usize] == NONE {
            next.value[to] = next.value[to] + behind;
        }
        return;
    }
    let mut far = ahead;
    if bits & DART != 0 && twin < CUT {
        // The far end of the sharp spoke has two colours there; seen from a dart it has their mean.
        far.c = (far.c + level.corner_colour(twin)) * 0.5;
    }
    if bits & EXTRAORDINARY != 0 {
        spokes[v] += 1;
    }
    next.value[to] = next.value[to] + (far + centre);
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
    let borders: Vec<u32> = (0..level.half_edges() as u32)
        .zip(level.sharp.iter().zip(&level.twin))
        .filter(|&(_, (&sharp, &twin))| sharp || twin == NONE)
        .map(|(h, _)| h)
        .collect();
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

fn connect(
    level: &Level,
    wanted: &[bool],
    points: &Points,
    sectors: &SectorColours,
    children: usize,
    next: &mut Level,
) {
    next.quads = children as u32;
    next.face.reserve_exact(children);
    next.inside.reserve_exact(children);
    next.origin.reserve_exact(4 * children);
    next.twin.reserve_exact(4 * children);
    next.tint.reserve_exact(4 * children);
    let sharp = !level.sharp.is_empty();
    if sharp {
        next.sharp.reserve_exact(4 * children);
    }
    // Slot `s` of child face `c`, if there is one.
    let slot_of = |c: u32, s: u32| if c == NONE { CUT } else { 4 * c + s };
    // Across an edge whose twin is `t`: the child at the start of the edge, which is the end of `t`; that at its end.
    let across_start = |t: u32| if t < CUT { slot_of(level.child[level.next(t) as usize], 3) } else { t };
    let across_end = |t: u32| if t < CUT { slot_of(level.child[t as usize], 0) } else { t };
    let tints = |h: usize, p: usize, at: [u32; 4]| {
        let corner = sectors.corner[h];
        [if corner == NONE { at[0] } else { corner }, sectors.side[h], at[2], sectors.side[p]]
    };
    for f in 0..level.quads {
        let centre = points.face[f as usize];
        if centre == NONE {
            continue;
        }
        let first = 4 * f;
        // Slots and local half-edges are the same numbers at level 0.
        let slot = if level.level == 0 { u64::from(first) } else { 4 * level.face[f as usize] };
        let child = Level::quad(&level.child, f);
        let edge = Level::quad(&points.edge, f);
        let origin = Level::quad(&level.origin, f);
        let twin = Level::quad(&level.twin, f);
        for i in 0..4 {
            if child[i] == NONE {
                continue;
            }
            let (n, p) = ((i + 1) & 3, (i + 3) & 3);
            let at = [points.vertex[origin[i] as usize], edge[i], centre, edge[p]];
            let twins = [across_start(twin[i]), slot_of(child[n], 2), slot_of(child[p], 1), across_end(twin[p])];
            let (h, p) = (first as usize + i, first as usize + p);
            let tint = if sharp { tints(h, p, at) } else { at };
            add_child(next, slot + i as u64, wanted[f as usize], at, tint, twins);
            if sharp {
                next.sharp.extend_from_slice(&[level.sharp[h], false, false, level.sharp[p]]);
            }
        }
    }
    for f in level.quads..level.faces() as u32 {
        for h in level.of_face(f).filter(|&h| level.child[h as usize] != NONE) {
            let (n, p) = (level.next(h) as usize, level.prev(h) as usize);
            let (vertex, edge) = (level.origin[h as usize] as usize, points.edge[h as usize]);
            let at = [points.vertex[vertex], edge, points.face[f as usize], points.edge[p]];
            let twins = [
                across_start(level.twin[h as usize]),
                slot_of(level.child[n], 2),
                slot_of(level.child[p], 1),
                across_end(level.twin[p]),
            ];
            let tint = if sharp { tints(h as usize, p, at) } else { at };
            add_child(next, u64::from(h), wanted[f as usize], at, tint, twins);
            if sharp {
                next.sharp.extend_from_slice(&[level.sharp[h as usize], false, false, level.sharp[p]]);
            }
        }
    }
}

// A call for each child would cost as much as its body.
#[inline(always)]
fn add_child(next: &mut Level, slot: u64, inside: bool, at: [u32; 4], tint: [u32; 4], twins: [u32; 4]) {
    next.face.push(slot);
    next.inside.push(inside);
    next.origin.extend_from_slice(&at);
    next.tint.extend_from_slice(&tint);
    next.twin.extend_from_slice(&twins);
}
