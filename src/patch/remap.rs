//! Transition faces in one piece: the rival of the five constellations.
//!
//! [`super::transition`] cuts a face with finer neighbours into parts. Here it stays whole, as in OpenSubdiv: a split edge
//! has as many segments as both finer neighbours give their edges together, and the vertices on it are dealt out to the two
//! halves, which need not have equally many. One pipeline draws all transition faces of a kind, whatever their edges. A
//! split edge may have the segments of two edges, so no level may exceed half of what a device has ([`MOST`]).
//!
//! OpenSubdiv evaluates these vertices on the face itself, at the mapped parameter, which gives the neighbours' points up to
//! rounding. Here they are evaluated on the neighbours' own four control points, which gives the same bits; its way is there
//! too, for comparison ([`remapped_own`]).
//!
//! A patch has 32 points: those of the face (16 or 20) and, for each of its edges, the five points by which both finer
//! edges are known: two inner points of the first half, the middle, two inner points of the second half. As points they
//! would be 40, more than every device takes. So their 4 x 5 x 6 numbers (x, y, r, g, b, a) fill all channels of the last
//! 12 points and what is free, z and w, in the first 12; see [`pack`]. Points are not shared with other patches.
//!
//! Twin of `glsl/inc/remap.glsl`.

use super::eval::{self, FACE_EDGES};
use super::transition::{constellation, parts_of, Side, EXTRA_POINTS, PARTS};
use super::{ControlPoint, DrawRange, Kind, PatchTable};

/// How transition faces are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Transitions {
    /// As parts of the five constellations ([`super::transition`]).
    #[default]
    Constellations,
    /// In one piece.
    Remap,
    /// In one piece, split edges along the face's own curve: what rounding and Gregory patches leave of a seam then.
    RemapOwn,
}

impl Transitions {
    /// The table to draw, from one with constellations.
    pub fn of(self, table: PatchTable) -> PatchTable {
        match self {
            Transitions::Constellations => table,
            Transitions::Remap => remapped(table),
            Transitions::RemapOwn => remapped_own(table),
        }
    }

    /// Greatest tessellation level.
    pub fn greatest(self) -> f32 {
        match self {
            Transitions::Constellations => super::tess::MAX_LEVEL,
            Transitions::Remap | Transitions::RemapOwn => MOST,
        }
    }
}

/// Control points of a patch.
pub const POINTS: usize = 32;

/// Greatest tessellation level of a table that has such patches.
pub const MOST: f32 = 32.0;

/// Numbers packed for one edge.
const EDGE: usize = 30;

/// Point and channel that say which edges are split: bit e, edge e.
const MASK: (usize, usize) = (12, 2);

/// Added to that number where split edges follow the face's own curve.
const OWN: f64 = 16.0;

/// Points of a split edge: inner points of the first half, the middle, inner points of the second half.
pub type Split = [ControlPoint; 5];

/// Point and channel of number `n` of the 120.
fn place(n: usize) -> (usize, usize) {
    match n.checked_sub(96) {
        None => (20 + n / 8, n % 8),
        Some(n) => (n / 2, 2 + n % 2),
    }
}

/// The 32 points of a patch: `face` are the 16 or 20 of its face, `splits[e]` says how edge e is split, if it is.
pub fn pack(face: &[ControlPoint], splits: &[Option<Split>; 4]) -> [ControlPoint; POINTS] {
    let mut points = [[0.0; 8]; POINTS];
    for (point, own) in points.iter_mut().zip(face) {
        *point = *own;
        (point[2], point[3]) = (0.0, 0.0);
    }
    let mut mask = 0u32;
    for (e, split) in splits.iter().enumerate() {
        let Some(split) = split else { continue };
        mask |= 1 << e;
        for (i, p) in split.iter().enumerate() {
            for (c, number) in [p[0], p[1], p[4], p[5], p[6], p[7]].into_iter().enumerate() {
                let (point, channel) = place(EDGE * e + 6 * i + c);
                points[point][channel] = number;
            }
        }
    }
    points[MASK.0][MASK.1] = f64::from(mask);
    points
}

/// Which edges of a patch are split: bit e, edge e.
pub fn mask(points: &[ControlPoint]) -> u8 {
    points[MASK.0][MASK.1] as u8 & 15
}

/// Point `i` of split edge `e`.
fn split_point(points: &[ControlPoint], e: usize, i: usize) -> ControlPoint {
    let number = |c: usize| {
        let (point, channel) = place(EDGE * e + 6 * i + c);
        points[point][channel]
    };
    [number(0), number(1), 0.0, 0.0, number(2), number(3), number(4), number(5)]
}

/// Control point of the face without what is packed into it.
fn face_point(points: &[ControlPoint], i: usize) -> ControlPoint {
    let p = points[i];
    [p[0], p[1], 0.0, 0.0, p[4], p[5], p[6], p[7]]
}

/// The cubic along half `h` (0, 1) of split edge `e`, in the edge's direction.
pub fn half(points: &[ControlPoint], e: usize, h: usize) -> [ControlPoint; 4] {
    let middle = split_point(points, e, 2);
    let inner = [split_point(points, e, 3 * h), split_point(points, e, 3 * h + 1)];
    match h {
        0 => [face_point(points, FACE_EDGES[e][0]), inner[0], inner[1], middle],
        _ => [middle, inner[0], inner[1], face_point(points, FACE_EDGES[e][3])],
    }
}

/// A vertex as the evaluation shader makes it. `kind` is [`Kind::RemappedBicubic`] or [`Kind::RemappedGregory`], `outer` the
/// levels of the four sides, `first` the segments of the first half of each split one, `coord` the tessellator's u and v.
///
/// # Panics
/// When there are fewer than 32 points.
pub fn vertex(kind: Kind, points: &[ControlPoint], outer: [f64; 4], first: [f64; 4], coord: [f64; 3]) -> ControlPoint {
    let Some((side, along)) = eval::side_of(None, coord) else {
        let face = if kind == Kind::RemappedGregory { Kind::Gregory } else { Kind::Bicubic };
        let mut value = eval::face(face, points, coord[0], coord[1]);
        (value[2], value[3]) = (0.0, 0.0);
        return value;
    };
    let level = outer[side];
    let k = (along * level + 0.5).floor();
    let own = FACE_EDGES[side].map(|i| face_point(points, i));
    if mask(points) >> side & 1 == 0 {
        return on_cubic(own, k, level);
    }
    if points[MASK.0][MASK.1] >= OWN {
        let n = first[side];
        let t = if k <= n { 0.5 * (k / n) } else { 0.5 + 0.5 * ((k - n) / (level - n)) };
        return on_cubic(own, t * level, level);
    }
    match k <= first[side] {
        true => on_cubic(half(points, side, 0), k, first[side]),
        false => on_cubic(half(points, side, 1), k - first[side], level - first[side]),
    }
}

/// Vertex k of n along a cubic.
fn on_cubic(q: [ControlPoint; 4], k: f64, n: f64) -> ControlPoint {
    if k <= 0.0 {
        return q[0];
    }
    if k >= n {
        return q[3];
    }
    eval::cubic(eval::bernstein((n - k) / n, k / n), [&q[0], &q[1], &q[2], &q[3]])
}

/// First index of each part of each transition face, by the face's number. Parts stand in their ranges in the order of the
/// faces.
pub fn part_positions(table: &PatchTable) -> Vec<(u32, [u32; 4])> {
    const KINDS: [Kind; 2] = [Kind::Bicubic, Kind::Gregory];
    const NONE: u32 = u32::MAX;
    let mut at: [[u32; PARTS.len()]; 2] = [[NONE; PARTS.len()]; 2];
    for range in &table.ranges {
        if let (Some(part), Some(kind)) = (range.part, KINDS.iter().position(|&k| k == range.kind)) {
            let first = &mut at[kind][part as usize];
            // The levels of a part follow each other.
            *first = (*first).min(range.first);
        }
    }
    let mut found = Vec::new();
    for (i, face) in table.faces.iter().enumerate().filter(|(_, f)| f.transition != 0) {
        let kind = usize::from(face.kind == Kind::Gregory);
        let mut firsts = [NONE; 4];
        for (first, part) in firsts.iter_mut().zip(parts_of(constellation(face.transition))) {
            *first = at[kind][part];
            at[kind][part] += (face.kind.points() + EXTRA_POINTS) as u32;
        }
        found.push((i as u32, firsts));
    }
    found
}

/// The same patches with every transition face in one piece. `table` is as [`super::build::build`] makes it: parts follow
/// whole patches. Time linear in the transition faces.
pub fn remapped(table: PatchTable) -> PatchTable {
    in_one_piece(table, false)
}

/// The same with vertices of split edges on the face's own curve, at the mapped parameter, as OpenSubdiv has them. The
/// neighbours' points only say how many segments there are.
pub fn remapped_own(table: PatchTable) -> PatchTable {
    in_one_piece(table, true)
}

fn in_one_piece(mut table: PatchTable, own_curves: bool) -> PatchTable {
    let Some(cut) = table.ranges.iter().filter(|range| range.part.is_some()).map(|range| range.first).min() else {
        return table;
    };
    let mut faces = Vec::new();
    for (number, firsts) in part_positions(&table) {
        let face = &table.faces[number as usize];
        let points = face.kind.points();
        let mut splits: [Option<Split>; 4] = [None; 4];
        for (first, part) in firsts.into_iter().zip(parts_of(constellation(face.transition))) {
            let at = |slot: usize| table.control[table.indices[first as usize + slot] as usize];
            let part = &PARTS[part];
            let sides = if part.triangle { 3 } else { 4 };
            for i in 0..sides {
                let Side::Half(pair) = part.sides[i] else { continue };
                let next = (i + 1) % sides;
                let (from, to) = (part.corners[i], part.corners[next]);
                let inner = points + 4 + 2 * pair as usize;
                // The half that begins in the middle is the second.
                let (edge, second) = match from.contains(&1) {
                    true => ((face_corner(to) + 3) & 3, 1),
                    false => (face_corner(from), 0),
                };
                let split = splits[edge].get_or_insert([[0.0; 8]; 5]);
                (split[3 * second], split[3 * second + 1]) = (at(inner), at(inner + 1));
                split[2] = at(points + if second == 1 { i } else { next });
            }
        }
        let own: Vec<ControlPoint> =
            (0..points).map(|slot| table.control[table.indices[firsts[0] as usize + slot] as usize]).collect();
        let mut packed = pack(&own, &splits);
        if own_curves {
            packed[MASK.0][MASK.1] += OWN;
        }
        faces.push((face.kind, face.level, number, packed));
    }
    table.ranges.retain(|range| range.part.is_none());
    table.indices.truncate(cut as usize);
    for kind in [Kind::Bicubic, Kind::Gregory] {
        let remapped = if kind == Kind::Gregory { Kind::RemappedGregory } else { Kind::RemappedBicubic };
        for (_, level, number, points) in faces.iter().filter(|face| face.0 == kind) {
            let first = table.indices.len() as u32;
            match table.ranges.last_mut() {
                Some(range) if (range.kind, range.level) == (remapped, *level) => range.count += 1,
                _ => table.ranges.push(DrawRange { kind: remapped, part: None, level: *level, first, count: 1 }),
            }
            table.faces[*number as usize].first = first;
            let point = table.control.len() as u32;
            table.indices.extend(point..point + POINTS as u32);
            table.control.extend_from_slice(points);
        }
    }
    table
}

/// Which corner of the face a point in halves of its domain is.
fn face_corner(at: [u8; 2]) -> usize {
    match at {
        [0, 0] => 0,
        [2, 0] => 1,
        [2, 2] => 2,
        _ => 3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_has_a_place_of_its_own() {
        let mut places: Vec<_> = (0..4 * EDGE).map(place).collect();
        places.push(MASK);
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), 121);
        // None is where a face has its own numbers.
        assert!(places.iter().all(|&(point, channel)| point >= 20 || matches!(channel, 2 | 3)));
    }

    #[test]
    fn what_is_packed_comes_back() {
        let point = |k: usize| -> ControlPoint {
            std::array::from_fn(|c| if c == 2 || c == 3 { 0.0 } else { (10 * k + c) as f64 })
        };
        for n in [16, 20] {
            let face: Vec<_> = (0..n).map(point).collect();
            for bits in 0..16u8 {
                let split = |e: usize| std::array::from_fn(|i| point(100 + 5 * e + i));
                let splits: [Option<Split>; 4] = std::array::from_fn(|e| (bits >> e & 1 == 1).then(|| split(e)));
                let points = pack(&face, &splits);
                assert_eq!(mask(&points), bits);
                for e in (0..4).filter(|e| bits >> e & 1 == 1) {
                    let [a, b, m, c, d] = split(e);
                    assert_eq!(half(&points, e, 0), [face[FACE_EDGES[e][0]], a, b, m]);
                    assert_eq!(half(&points, e, 1), [m, c, d, face[FACE_EDGES[e][3]]]);
                }
            }
        }
    }
}
