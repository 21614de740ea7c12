//! Evaluates patches on the CPU in f64: the reference for the tests, for picking and for error maps.
//! Twin of `glsl/inc/bezier.glsl`, `face.glsl`, `part.glsl` and `glsl/patch.tese`; the two change together.
//!
//! The order of every sum is fixed and symmetric: walking an edge from the other end (`s` and `t` swapped, points
//! reversed) gives the same bits, and at `u` or `v` of exactly 0 or 1 a face is its edge cubic bit for bit.

use super::transition::{Side, PARTS};
use super::{ControlPoint, Kind};

/// A vertex nearer than this to a side of the tessellator's domain lies on it: interior vertices are at least
/// 1/100 away, rounding at most 1e-6. The same number as in `glsl/patch.tese`.
pub const ON_SIDE: f64 = 1.0 / 512.0;

/// A point of a face with its first derivatives, all eight channels alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The point.
    pub value: ControlPoint,
    /// Derivative along u, per unit of the face's domain.
    pub du: ControlPoint,
    /// Derivative along v.
    pub dv: ControlPoint,
}

/// Weights of the four points of a cubic at `t`, where `s` is `1 - t`.
pub fn bernstein(s: f64, t: f64) -> [f64; 4] {
    let ss = s * s;
    let tt = t * t;
    [ss * s, (3.0 * ss) * t, (3.0 * tt) * s, tt * t]
}

/// Derivatives of [`bernstein`] with respect to `t`.
pub fn bernstein_slope(s: f64, t: f64) -> [f64; 4] {
    let st = 6.0 * s * t;
    [-3.0 * s * s, 3.0 * s * s - st, st - 3.0 * t * t, 3.0 * t * t]
}

/// Weighted sum of four points in the symmetric order.
pub fn cubic(w: [f64; 4], p: [&ControlPoint; 4]) -> ControlPoint {
    std::array::from_fn(|c| (w[0] * p[0][c] + w[1] * p[1][c]) + (w[2] * p[2][c] + w[3] * p[3][c]))
}

/// Inner point of a Gregory corner, `(x f+ + y f-) / (x + y)`: `x` and `y` are the distances from the corner along
/// the edge that leaves it and the one that ends in it. At the corner itself, where the weight is 0 anyway, `f+`.
pub fn gregory_inner(x: f64, y: f64, plus: &ControlPoint, minus: &ControlPoint) -> ControlPoint {
    let d = x + y;
    let (wx, wy) = if d > 0.0 { (x / d, y / d) } else { (1.0, 0.0) };
    std::array::from_fn(|c| wx * plus[c] + wy * minus[c])
}

/// For corners A to D: control points f+ (the inner one) and f-.
const GREGORY_CORNERS: [(usize, usize); 4] = [(5, 16), (6, 17), (10, 18), (9, 19)];

/// Distances (x, y) of [`gregory_inner`] for corner i, and their derivatives along u and v.
fn corner_distances(i: usize, u: f64, v: f64) -> [(f64, f64, f64); 2] {
    let (su, sv) = (1.0 - u, 1.0 - v);
    match i {
        0 => [(u, 1.0, 0.0), (v, 0.0, 1.0)],
        1 => [(v, 0.0, 1.0), (su, -1.0, 0.0)],
        2 => [(su, -1.0, 0.0), (sv, 0.0, -1.0)],
        _ => [(sv, 0.0, -1.0), (u, 1.0, 0.0)],
    }
}

/// The 16 points of the bicubic that a face is at (u, v).
fn net(kind: Kind, points: &[ControlPoint], u: f64, v: f64) -> [ControlPoint; 16] {
    let mut net: [ControlPoint; 16] = std::array::from_fn(|i| points[i]);
    if kind == Kind::Gregory {
        for (i, (plus, minus)) in GREGORY_CORNERS.into_iter().enumerate() {
            let [(x, ..), (y, ..)] = corner_distances(i, u, v);
            net[plus] = gregory_inner(x, y, &points[plus], &points[minus]);
        }
    }
    net
}

/// Along u in every row, then along v.
fn tensor(net: &[ControlPoint; 16], wu: [f64; 4], wv: [f64; 4]) -> ControlPoint {
    let rows: [ControlPoint; 4] =
        std::array::from_fn(|r| cubic(wu, [&net[4 * r], &net[4 * r + 1], &net[4 * r + 2], &net[4 * r + 3]]));
    cubic(wv, [&rows[0], &rows[1], &rows[2], &rows[3]])
}

/// Point of a face at (u, v), each in [0, 1]. `points` are the face's 16 or 20 control points, or more.
///
/// # Panics
/// When there are fewer points than [`Kind::points`].
pub fn face(kind: Kind, points: &[ControlPoint], u: f64, v: f64) -> ControlPoint {
    tensor(&net(kind, points, u, v), bernstein(1.0 - u, u), bernstein(1.0 - v, v))
}

/// Point and first derivatives of a face at (u, v). At a corner of a Gregory face the derivatives are the limits.
///
/// # Panics
/// When there are fewer points than [`Kind::points`].
pub fn face_sample(kind: Kind, points: &[ControlPoint], u: f64, v: f64) -> Sample {
    let net = net(kind, points, u, v);
    let (wu, wv) = (bernstein(1.0 - u, u), bernstein(1.0 - v, v));
    let mut sample = Sample {
        value: tensor(&net, wu, wv),
        du: tensor(&net, bernstein_slope(1.0 - u, u), wv),
        dv: tensor(&net, wu, bernstein_slope(1.0 - v, v)),
    };
    if kind == Kind::Gregory {
        // The inner points move with (u, v): d/dz of x/(x+y) is (x' y - x y') / (x+y)^2.
        for (i, (plus, minus)) in GREGORY_CORNERS.into_iter().enumerate() {
            let [(x, xu, xv), (y, yu, yv)] = corner_distances(i, u, v);
            let d = x + y;
            if d <= 0.0 {
                continue;
            }
            let weight = wu[plus % 4] * wv[plus / 4] / (d * d);
            let (along_u, along_v) = (weight * (xu * y - x * yu), weight * (xv * y - x * yv));
            for (c, (f_plus, f_minus)) in points[plus].iter().zip(points[minus]).enumerate() {
                sample.du[c] += along_u * (f_plus - f_minus);
                sample.dv[c] += along_v * (f_plus - f_minus);
            }
        }
    }
    sample
}

/// Control points of the cubic along edge e of a face, from its corner e on.
pub const FACE_EDGES: [[usize; 4]; 4] = [[0, 1, 2, 3], [3, 7, 11, 15], [15, 14, 13, 12], [12, 8, 4, 0]];

/// Control point of corner `i` of a drawn patch: of the face, or of part `part` of [`PARTS`].
pub fn corner_point(kind: Kind, part: Option<u8>, i: usize) -> usize {
    match part {
        None => FACE_EDGES[i][0],
        Some(_) => kind.points() + i,
    }
}

/// Control points of the cubic along side `i` of a drawn patch, from its corner i to the next; `None` for an inner
/// side, which is a line on the face's surface.
pub fn side_points(kind: Kind, part: Option<u8>, i: usize) -> Option<[usize; 4]> {
    let Some(number) = part else {
        return Some(FACE_EDGES[i]);
    };
    match PARTS[number as usize].sides[i] {
        Side::Inner => None,
        Side::Full(e) => Some(FACE_EDGES[e as usize]),
        Side::Half(pair) => {
            let first = kind.points() + 4 + 2 * pair as usize;
            let next = (i + 1) % sides(part);
            Some([corner_point(kind, part, i), first, first + 1, corner_point(kind, part, next)])
        }
    }
}

/// Sides of a drawn patch: 3 for a triangle part, else 4.
pub fn sides(part: Option<u8>) -> usize {
    match part {
        Some(number) if PARTS[number as usize].triangle => 3,
        _ => 4,
    }
}

/// Corner `i` of a drawn patch in the face's domain.
pub fn corner_uv(part: Option<u8>, i: usize) -> [f64; 2] {
    match part {
        None => [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][i],
        Some(number) => PARTS[number as usize].corners[i].map(|half| 0.5 * f64::from(half)),
    }
}

/// Point (s, t) of the straight domain line from corner i to the next. Symmetric in its two ends.
fn inner_uv(part: Option<u8>, i: usize, s: f64, t: f64) -> [f64; 2] {
    let a = corner_uv(part, i);
    let b = corner_uv(part, (i + 1) % sides(part));
    [s * a[0] + t * b[0], s * a[1] + t * b[1]]
}

/// Whether `coord` lies on side `side` of the tessellator's domain, and the parameter along it from its corner; `None`
/// where there is no such side. A corner lies on two sides.
pub fn along_side(part: Option<u8>, coord: [f64; 3], side: usize) -> Option<(bool, f64)> {
    let [x, y, z] = coord;
    let (distance, along) = if sides(part) == 3 {
        *[(z, y), (x, z), (y, x)].get(side)?
    } else {
        *[(y, x), (1.0 - x, y), (1.0 - y, 1.0 - x), (x, 1.0 - y)].get(side)?
    };
    Some((distance < ON_SIDE, along))
}

/// The side of the tessellator's domain that `coord` lies on and the parameter along it from its corner, if any.
pub(super) fn side_of(part: Option<u8>, coord: [f64; 3]) -> Option<(usize, f64)> {
    (0..sides(part)).find_map(|side| match along_side(part, coord, side) {
        Some((true, along)) => Some((side, along)),
        _ => None,
    })
}

/// Where a tessellated vertex of a drawn patch lies in the face's domain. `coord` is the tessellator's coordinate
/// (quads: u, v, 0; triangles: barycentric), `outer[i]` the integer level of side i.
pub fn vertex_uv(part: Option<u8>, outer: [f64; 4], coord: [f64; 3]) -> [f64; 2] {
    if let Some((side, along)) = side_of(part, coord) {
        let level = outer[side];
        let k = (along * level + 0.5).floor().clamp(0.0, level);
        return inner_uv(part, side, (level - k) / level, k / level);
    }
    let [x, y, z] = coord;
    let weights =
        if sides(part) == 3 { [x, y, z, 0.0] } else { [(1.0 - x) * (1.0 - y), x * (1.0 - y), x * y, (1.0 - x) * y] };
    let mut uv = [0.0; 2];
    for (i, weight) in weights.into_iter().enumerate() {
        let corner = corner_uv(part, i);
        uv[0] += weight * corner[0];
        uv[1] += weight * corner[1];
    }
    uv
}

/// A tessellated vertex exactly as the evaluation shader makes it. `points` are the patch's control points in the
/// order of its range ([`super::DrawRange::stride`] of them); `outer` and `coord` as in [`vertex_uv`].
///
/// # Panics
/// When there are too few points or the part number is out of range.
pub fn vertex(kind: Kind, part: Option<u8>, points: &[ControlPoint], outer: [f64; 4], coord: [f64; 3]) -> ControlPoint {
    if let Some((side, along)) = side_of(part, coord) {
        let level = outer[side];
        let k = (along * level + 0.5).floor();
        if k <= 0.0 {
            return points[corner_point(kind, part, side)];
        }
        if k >= level {
            return points[corner_point(kind, part, (side + 1) % sides(part))];
        }
        if let Some(q) = side_points(kind, part, side) {
            return cubic(bernstein((level - k) / level, k / level), q.map(|i| &points[i]));
        }
    }
    let [u, v] = vertex_uv(part, outer, coord);
    face(kind, points, u, v)
}

/// Level of side `i` of a drawn patch by the screen-space rule: length of its control polygon in pixels (`scale`:
/// pixels a model unit along x and y) over `pixels`, rounded up, 1 to 64. An inner side takes the polygon through
/// the face's points at thirds.
pub fn pixel_level(
    kind: Kind,
    part: Option<u8>,
    points: &[ControlPoint],
    i: usize,
    scale: [f64; 2],
    pixels: f64,
) -> f64 {
    let p: [ControlPoint; 4] = match side_points(kind, part, i) {
        Some(q) => q.map(|j| points[j]),
        None => {
            let at = |s: f64, t: f64| {
                let [u, v] = inner_uv(part, i, s, t);
                face(kind, points, u, v)
            };
            let next = (i + 1) % sides(part);
            [
                points[corner_point(kind, part, i)],
                at(2.0 / 3.0, 1.0 / 3.0),
                at(1.0 / 3.0, 2.0 / 3.0),
                points[corner_point(kind, part, next)],
            ]
        }
    };
    let leg = |a: &ControlPoint, b: &ControlPoint| {
        let (x, y) = ((b[0] - a[0]) * scale[0], (b[1] - a[1]) * scale[1]);
        (x * x + y * y).sqrt()
    };
    let length = (leg(&p[0], &p[1]) + leg(&p[2], &p[3])) + leg(&p[1], &p[2]);
    let level = (length / pixels).ceil();
    if level <= 64.0 {
        level.max(1.0)
    } else {
        64.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Deterministic numbers in [-1, 1).
    fn random(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }
    }

    fn points(n: usize, seed: u64) -> Vec<ControlPoint> {
        let mut next = random(seed);
        (0..n).map(|_| std::array::from_fn(|_| next())).collect()
    }

    const KINDS: [Kind; 2] = [Kind::Bicubic, Kind::Gregory];

    #[test]
    fn weights_are_a_partition_of_unity() {
        let ones = vec![[1.0; 8]; 20];
        for kind in KINDS {
            for i in 0..=16 {
                for j in 0..=16 {
                    let sample = face_sample(kind, &ones, f64::from(i) / 16.0, f64::from(j) / 16.0);
                    for c in 0..8 {
                        assert!((sample.value[c] - 1.0).abs() < 1e-15);
                        assert!(sample.du[c].abs() < 1e-14 && sample.dv[c].abs() < 1e-14);
                    }
                }
            }
        }
    }

    #[test]
    fn borders_are_the_edge_cubics_bit_for_bit() {
        for kind in KINDS {
            let p = points(20, 3);
            for k in 0..=13 {
                let t = f64::from(k) / 13.0;
                let uv = [[t, 0.0], [1.0, t], [t, 1.0], [0.0, t]];
                for (e, [u, v]) in uv.into_iter().enumerate() {
                    // Edges 2 and 3 run against u and v; reversed, the cubic gives the same bits.
                    let q = FACE_EDGES[e].map(|i| &p[i]);
                    let edge = match e {
                        0 | 1 => cubic(bernstein(1.0 - t, t), q),
                        _ => cubic(bernstein(t, 1.0 - t), q),
                    };
                    assert_eq!(face(kind, &p, u, v), edge, "{kind:?} edge {e} at {t}");
                }
            }
        }
    }

    #[test]
    fn a_reversed_cubic_is_bit_identical() {
        let p = points(4, 5);
        for level in 1..=64 {
            for k in 0..=level {
                let (s, t) = (f64::from(level - k) / f64::from(level), f64::from(k) / f64::from(level));
                let forward = cubic(bernstein(s, t), [&p[0], &p[1], &p[2], &p[3]]);
                let backward = cubic(bernstein(t, s), [&p[3], &p[2], &p[1], &p[0]]);
                assert_eq!(forward.map(f64::to_bits), backward.map(f64::to_bits));
            }
        }
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let h = 1e-6;
        for kind in KINDS {
            let p = points(20, 7);
            for (u, v) in [(0.3, 0.6), (0.01, 0.02), (0.9, 0.1), (0.5, 0.5), (0.97, 0.93)] {
                let sample = face_sample(kind, &p, u, v);
                let (u0, u1) = (face(kind, &p, u - h, v), face(kind, &p, u + h, v));
                let (v0, v1) = (face(kind, &p, u, v - h), face(kind, &p, u, v + h));
                for c in 0..8 {
                    assert!((sample.du[c] - (u1[c] - u0[c]) / (2.0 * h)).abs() < 1e-7);
                    assert!((sample.dv[c] - (v1[c] - v0[c]) / (2.0 * h)).abs() < 1e-7);
                }
            }
        }
    }

    #[test]
    fn gregory_with_equal_inner_points_is_the_bicubic() {
        let mut p = points(20, 11);
        for (plus, minus) in GREGORY_CORNERS {
            p[minus] = p[plus];
        }
        for i in 0..=10 {
            for j in 0..=10 {
                let (u, v) = (f64::from(i) / 10.0, f64::from(j) / 10.0);
                let (a, b) = (face_sample(Kind::Gregory, &p, u, v), face_sample(Kind::Bicubic, &p, u, v));
                for c in 0..8 {
                    assert!((a.value[c] - b.value[c]).abs() < 1e-15);
                    assert!((a.du[c] - b.du[c]).abs() < 1e-14);
                    assert!((a.dv[c] - b.dv[c]).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn gregory_edges_belong_to_the_right_inner_points() {
        // Across edge i the derivative must see f_i+ and f_{i+1}- only, those of the edge itself.
        let p = points(20, 13);
        for e in 0..4 {
            let mut q = p.clone();
            // Everything that belongs to other edges moves.
            for (i, (plus, minus)) in GREGORY_CORNERS.into_iter().enumerate() {
                if i != e {
                    q[plus] = [9.0; 8];
                }
                if i != (e + 1) % 4 {
                    q[minus] = [-9.0; 8];
                }
            }
            let t = 0.3;
            let (u, v) = [(t, 0.0), (1.0, t), (t, 1.0), (0.0, t)][e];
            let (a, b) = (face_sample(Kind::Gregory, &p, u, v), face_sample(Kind::Gregory, &q, u, v));
            let (a, b) = if e % 2 == 0 { (a.dv, b.dv) } else { (a.du, b.du) };
            for c in 0..8 {
                assert!((a[c] - b[c]).abs() < 1e-13, "edge {e}");
            }
        }
    }

    #[test]
    fn parts_tile_the_face_and_inner_sides_come_in_pairs() {
        for constellation in 1..=5 {
            let mut area = 0.0;
            let mut inner: Vec<([u8; 2], [u8; 2])> = Vec::new();
            for number in super::super::transition::parts_of(constellation) {
                let part = &PARTS[number];
                let n = sides(Some(number as u8));
                for i in 0..n {
                    let (a, b) = (part.corners[i], part.corners[(i + 1) % n]);
                    area += (f64::from(a[0]) * f64::from(b[1]) - f64::from(a[1]) * f64::from(b[0])) / 8.0;
                    if part.sides[i] == Side::Inner {
                        inner.push((a, b));
                    }
                }
            }
            assert_eq!(area, 1.0, "constellation {constellation}");
            for (a, b) in &inner {
                assert!(inner.contains(&(*b, *a)), "constellation {constellation}: {a:?} to {b:?}");
            }
        }
    }

    #[test]
    fn vertices_on_inner_sides_are_the_same_bits_from_both_parts() {
        for kind in KINDS {
            for constellation in 1..=5 {
                let mut seen: Vec<([f64; 2], [u64; 8])> = Vec::new();
                let p = points(kind.points() + 8, 17);
                for number in super::super::transition::parts_of(constellation) {
                    let part = Some(number as u8);
                    for i in (0..sides(part)).filter(|&i| side_points(kind, part, i).is_none()) {
                        for k in 1..7 {
                            let uv = inner_uv(part, i, f64::from(7 - k) / 7.0, f64::from(k) / 7.0);
                            let bits = face(kind, &p, uv[0], uv[1]).map(f64::to_bits);
                            match seen.iter().find(|(at, _)| *at == uv) {
                                Some((_, other)) => assert_eq!(*other, bits),
                                None => seen.push((uv, bits)),
                            }
                        }
                    }
                }
                assert!(!seen.is_empty());
            }
        }
    }
}
