//! C, one Catmull-Clark step, on the part of a level that is wanted ([ZHHK22] 3.3, App. A; [DKT98] for creases).
//!
//! The child of half-edge `h` (the quad at its origin) is made exactly where the origin touches a face to be
//! refined. So every wanted face gets its four children and a full ring of quads around them: what
//! [ZHHK22] 4.2 calls padding, without its outer half. Every vertex of a child that lies inside is then
//! computed from a complete neighbourhood.
//!
//! Positions: interior rules of Catmull and Clark with new face points, boundary curve `(a + 6 v + b) / 8`,
//! boundary corners kept or treated as the curve ([`CornerRule`]). Colours use the same connectivity; along
//! sharp edges every sector follows the boundary rules on its own, a dart is smooth.

use super::level::{vertex_bits, Level, CUT};
use crate::mesh::NONE;
use crate::scene::CornerRule;
use glam::{DVec2, DVec4};
use vertex_bits::{BOUNDARY, CORNER, DART, SECTORS};

/// Refines the faces marked in `wanted` (one flag a face) and fills `level.child`.
///
/// Time linear in the level's half-edges; children keep the slot order.
pub fn refine(level: &mut Level, wanted: &[bool], corners: CornerRule) -> Level {
    let touched = touched_vertices(level, wanted);
    number_children(level, &touched);
    let points = number_points(level, &touched);
    let mut next = Level { level: level.level + 1, ..Level::default() };
    rules(level, &points, corners, &mut next);
    let sectors = sector_colours(level, &points, corners, &mut next);
    connect(level, wanted, &points, &sectors, &mut next);
    next
}

fn touched_vertices(level: &Level, wanted: &[bool]) -> Vec<bool> {
    let mut touched = vec![false; level.position.len()];
    for f in 0..level.faces() as u32 {
        if wanted[f as usize] {
            for h in level.of_face(f) {
                touched[level.origin[h as usize] as usize] = true;
            }
        }
    }
    touched
}

fn number_children(level: &mut Level, touched: &[bool]) {
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
}

/// Numbers of the next level's vertices.
struct Points {
    /// Old vertices in the next level, [`NONE`] where they are not needed.
    vertex: Vec<u32>,
    /// Edge point of each half-edge's edge.
    edge: Vec<u32>,
    /// Face points.
    face: Vec<u32>,
    count: u32,
}

fn number_points(level: &Level, touched: &[bool]) -> Points {
    let mut count = 0;
    let mut take = |wanted: bool| {
        if wanted {
            count += 1;
            count - 1
        } else {
            NONE
        }
    };
    let vertex: Vec<u32> = touched.iter().map(|&t| take(t)).collect();
    let mut edge = vec![NONE; level.half_edges()];
    for h in 0..level.half_edges() as u32 {
        let t = level.twin[h as usize];
        if t < h {
            edge[h as usize] = edge[t as usize];
        } else {
            let ends = touched[level.origin[h as usize] as usize] || touched[level.target(h) as usize];
            edge[h as usize] = take(ends);
        }
    }
    let face = (0..level.faces() as u32)
        .map(|f| take(level.of_face(f).any(|h| touched[level.origin[h as usize] as usize])))
        .collect();
    Points { vertex, edge, face, count }
}

/// Positions, colours (as if no edge were sharp; those at sharp edges are replaced later) and bits.
fn rules(level: &Level, points: &Points, corners: CornerRule, next: &mut Level) {
    let n = points.count as usize;
    next.position.resize(n, DVec2::ZERO);
    next.colour.resize(n, DVec4::ZERO);
    next.bits.resize(n, 0);

    // Face points first: the other rules read them.
    for f in 0..level.faces() as u32 {
        let to = points.face[f as usize];
        if to == NONE {
            continue;
        }
        let (mut p, mut c) = (DVec2::ZERO, DVec4::ZERO);
        for h in level.of_face(f) {
            p += level.position[level.origin[h as usize] as usize];
            c += level.corner_colour(h);
        }
        let inv = 1.0 / f64::from(level.valence(f));
        next.position[to as usize] = p * inv;
        next.colour[to as usize] = c * inv;
        if level.valence(f) != 4 {
            next.bits[to as usize] = vertex_bits::EXTRAORDINARY;
        }
    }

    // Around each vertex: sum of neighbours and new face points. `spokes` counts the faces.
    let old = level.position.len();
    let mut spokes = vec![0u32; old];
    let mut ring_p = vec![DVec2::ZERO; old];
    let mut ring_c = vec![DVec4::ZERO; old];
    for h in 0..level.half_edges() as u32 {
        let hi = h as usize;
        let v = level.origin[hi] as usize;
        let g = level.next(h);
        let w = level.origin[g as usize] as usize;
        let t = level.twin[hi];
        let to = points.edge[hi];
        if to != NONE && (t >= CUT || h < t) {
            let ends_p = level.position[v] + level.position[w];
            let ends_c = level.corner_colour(h) + level.corner_colour(g);
            let to = to as usize;
            if t < CUT {
                let a = points.face[level.face_of(h) as usize] as usize;
                let b = points.face[level.face_of(t) as usize] as usize;
                next.position[to] = (ends_p + (next.position[a] + next.position[b])) * 0.25;
                next.colour[to] = (ends_c + (next.colour[a] + next.colour[b])) * 0.25;
            } else {
                next.position[to] = ends_p * 0.5;
                next.colour[to] = ends_c * 0.5;
                next.bits[to] = BOUNDARY;
            }
        }
        if points.vertex[v] == NONE {
            continue;
        }
        spokes[v] += 1;
        if level.bits[v] & BOUNDARY != 0 {
            // Only the two boundary neighbours count. An edge is seen from the half-edge that leaves ...
            if t == NONE {
                ring_p[v] += level.position[w];
                ring_c[v] += level.corner_colour(g);
            }
            // ... and from the one that arrives.
            let p = level.prev(h);
            if level.twin[p as usize] == NONE {
                ring_p[v] += level.position[level.origin[p as usize] as usize];
                ring_c[v] += level.corner_colour(p);
            }
        } else {
            let f = points.face[level.face_of(h) as usize] as usize;
            let mut far = level.corner_colour(g);
            if level.bits[v] & DART != 0 && t < CUT {
                // The far end of the sharp spoke has two colours there; seen from a dart it has their mean.
                far = (far + level.corner_colour(t)) * 0.5;
            }
            ring_p[v] += level.position[w] + next.position[f];
            ring_c[v] += far + next.colour[f];
        }
    }

    for v in 0..old {
        let to = points.vertex[v];
        if to == NONE {
            continue;
        }
        let to = to as usize;
        next.bits[to] = level.bits[v];
        let (p, c) = (level.position[v], level.colour[v]);
        (next.position[to], next.colour[to]) = if level.bits[v] & BOUNDARY == 0 {
            let n = f64::from(spokes[v]);
            let (keep, ring) = ((n - 2.0) / n, 1.0 / (n * n));
            (p * keep + ring_p[v] * ring, c * keep + ring_c[v] * ring)
        } else if level.bits[v] & CORNER != 0 && corners == CornerRule::Sharp {
            (p, c)
        } else {
            (curve(p, ring_p[v]), curve(c, ring_c[v]))
        };
    }
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
    for h in 0..level.half_edges() as u32 {
        let to = points.edge[h as usize];
        if level.sharp[h as usize] && to != NONE {
            let middle = (level.corner_colour(h) + level.corner_colour(level.next(h))) * 0.5;
            next.bits[to as usize] |= SECTORS;
            if level.twin[h as usize] < h {
                side[h as usize] = next.colour.len() as u32;
                next.colour.push(middle);
            } else {
                next.colour[to as usize] = middle;
            }
        }
    }
    let mut taken = vec![false; level.position.len()];
    for h in 0..level.half_edges() as u32 {
        let v = level.origin[h as usize] as usize;
        let to = points.vertex[v];
        if to == NONE || level.bits[v] & SECTORS == 0 || !level.colour_border(h) {
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
            next.colour.push(colour);
            next.colour.len() as u32 - 1
        } else {
            taken[v] = true;
            next.colour[to as usize] = colour;
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

fn connect(level: &Level, wanted: &[bool], points: &Points, sectors: &SectorColours, next: &mut Level) {
    let children = level.child.iter().filter(|&&c| c != NONE).count();
    next.quads = children as u32;
    next.face.reserve(children);
    next.inside.reserve(children);
    next.origin.reserve(4 * children);
    next.twin.reserve(4 * children);
    next.tint.reserve(4 * children);
    let sharp = !level.sharp.is_empty();
    if sharp {
        next.sharp.reserve(4 * children);
    }
    let slot_of_first = |f: u32| -> u64 {
        if level.level == 0 {
            // Slots and local half-edges are the same numbers at level 0.
            u64::from(level.first(f))
        } else {
            4 * level.face[f as usize]
        }
    };
    for f in 0..level.faces() as u32 {
        let first = level.first(f);
        let slot = slot_of_first(f);
        for h in level.of_face(f) {
            if level.child[h as usize] == NONE {
                continue;
            }
            let p = level.prev(h);
            let (hi, pi) = (h as usize, p as usize);
            next.face.push(slot + u64::from(h - first));
            next.inside.push(wanted[f as usize]);

            let v = points.vertex[level.origin[hi] as usize];
            let at = [v, points.edge[hi], points.face[f as usize], points.edge[pi]];
            next.origin.extend_from_slice(&at);
            if sharp {
                let c = sectors.corner[hi];
                next.tint.extend_from_slice(&[if c == NONE { v } else { c }, sectors.side[hi], at[2], sectors.side[pi]]);
                next.sharp.extend_from_slice(&[level.sharp[hi], false, false, level.sharp[pi]]);
            } else {
                next.tint.extend_from_slice(&at);
            }

            let child = |h: u32, s: u32| match level.child[h as usize] {
                NONE => CUT,
                c => 4 * c + s,
            };
            let beyond = |t: u32, to: &dyn Fn(u32) -> u32| if t < CUT { to(t) } else { t };
            next.twin.extend_from_slice(&[
                beyond(level.twin[hi], &|t| child(level.next(t), 3)),
                child(level.next(h), 2),
                child(p, 1),
                beyond(level.twin[pi], &|t| child(t, 0)),
            ]);
        }
    }
}
