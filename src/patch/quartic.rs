//! Quartic Bezier triangles: what a regular face of Loop's scheme is, and a Gregory variant for the others.
//! Twin of `glsl/inc/quartic.glsl`; the two change together.
//!
//! ```text
//!            14 C                corner 0 = A, 1 = B, 2 = C; side 0 = A-B, 1 = B-C, 2 = C-A
//!          12  13                barycentric (x, y, z): weights of A, B, C
//!         9  10  11              inner point of corner A 6, B 7, C 10
//!       5   6   7   8
//!  A  0   1   2   3   4  B
//! ```
//!
//! A Gregory triangle has 18 points: 0 to 14 as drawn, where the inner point of corner i is `f_i+` (of side i, which
//! leaves the corner); 15 + i is `f_i-` (of the side that ends in the corner). With y and z the weights of B and C,
//! `F_A = (y f+ + z f-) / (y + z)`, and its two rotations: on each side the inner points are those of the side.
//!
//! A side evaluated from its other end (`s` and `t` swapped, points reversed) gives the same bits.

use super::eval::{gregory_inner, Sample};
use super::ControlPoint;

/// Points of sides, from their first corner on.
pub const SIDES: [[usize; 5]; 3] = [[0, 1, 2, 3, 4], [4, 8, 11, 13, 14], [14, 12, 9, 5, 0]];

/// Control points of corners.
pub const CORNERS: [usize; 3] = [0, 4, 14];

/// Inner points of corners.
pub const INNER: [usize; 3] = [6, 7, 10];

/// Point of a quartic curve at `t`, where `s` is `1 - t`.
pub fn curve(s: f64, t: f64, p: [&ControlPoint; 5]) -> ControlPoint {
    let (ss, tt, st) = (s * s, t * t, s * t);
    let w = [ss * ss, 4.0 * (ss * st), 6.0 * (ss * tt), 4.0 * (tt * st), tt * tt];
    std::array::from_fn(|c| ((w[0] * p[0][c] + w[4] * p[4][c]) + (w[1] * p[1][c] + w[3] * p[3][c])) + w[2] * p[2][c])
}

/// The triangle with these points (15, or 18 of a Gregory triangle) at weights (1 - u - v, u, v) of its corners; du and dv
/// are derivatives from A towards B and towards C.
///
/// On sides the value is that of [`curve`].
pub fn sample(points: &[ControlPoint], u: f64, v: f64) -> Sample {
    let gregory = points.len() > 15;
    let bary = [1.0 - u - v, u, v];
    let [x, y, z] = bary;
    let mut net: [ControlPoint; 15] = std::array::from_fn(|i| points[i]);
    // Of each corner, its distances from the two sides that meet there.
    let distances = [[y, z], [z, x], [x, y]];
    if gregory {
        for (i, [a, b]) in distances.into_iter().enumerate() {
            net[INNER[i]] = gregory_inner(a, b, &points[INNER[i]], &points[15 + i]);
        }
    }
    let side = if z == 0.0 {
        Some((0, x, y))
    } else if x == 0.0 {
        Some((1, y, z))
    } else if y == 0.0 {
        Some((2, z, x))
    } else {
        None
    };
    let on_side = side.map(|(i, s, t)| curve(s, t, SIDES[i].map(|k| &points[k])));
    for degree in (2..=4).rev() {
        // Rows of the old and the new net begin at `from` and `to`; every new point is before the old ones it needs.
        let (mut from, mut to) = (0, 0);
        for row in 0..degree {
            let above = from + degree - row + 1;
            for i in 0..degree - row {
                net[to] =
                    std::array::from_fn(|c| x * net[from + i][c] + y * net[from + i + 1][c] + z * net[above + i][c]);
                to += 1;
            }
            from = above;
        }
    }
    let mut found = Sample {
        value: on_side.unwrap_or(std::array::from_fn(|c| x * net[0][c] + y * net[1][c] + z * net[2][c])),
        du: std::array::from_fn(|c| 4.0 * (net[1][c] - net[0][c])),
        dv: std::array::from_fn(|c| 4.0 * (net[2][c] - net[0][c])),
    };
    if gregory {
        // The inner points move: d of y / (y + z) is (y' z - y z') / (y + z)^2.
        let along_u = [[1.0, 0.0], [0.0, -1.0], [-1.0, 1.0]];
        let along_v = [[0.0, 1.0], [1.0, -1.0], [-1.0, 0.0]];
        for i in 0..3 {
            let [a, b] = distances[i];
            if a + b > 0.0 {
                let w = 12.0 * x * y * z * bary[i] / ((a + b) * (a + b));
                let [turn_u, turn_v] = [along_u[i], along_v[i]].map(|[da, db]| da * b - a * db);
                let ends = points[INNER[i]].iter().zip(&points[15 + i]);
                for ((du, dv), (plus, minus)) in found.du.iter_mut().zip(&mut found.dv).zip(ends) {
                    let step = w * (plus - minus);
                    *du += turn_u * step;
                    *dv += turn_v * step;
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(n: usize) -> Vec<ControlPoint> {
        (0..n).map(|i| std::array::from_fn(|c| ((i * 8 + c) as f64 * 1.7).sin())).collect()
    }

    #[test]
    fn sides_are_their_curves_from_either_end() {
        let p = points(15);
        for k in 0..=7 {
            let (s, t) = (f64::from(7 - k) / 7.0, f64::from(k) / 7.0);
            for q in SIDES {
                let there = curve(s, t, q.map(|i| &p[i]));
                let mut back = q;
                back.reverse();
                assert_eq!(there, curve(t, s, back.map(|i| &p[i])));
            }
            let near = sample(&p, t, 1e-13).value;
            let on = curve(1.0 - t, t, SIDES[0].map(|i| &p[i]));
            assert!((0..8).all(|c| (near[c] - on[c]).abs() < 1e-11));
        }
    }

    #[test]
    fn derivatives_are_those_of_values() {
        for n in [15, 18] {
            let p = points(n);
            let h = 1e-6;
            for (u, v) in [(0.2, 0.3), (0.5, 0.1), (0.05, 0.9), (0.33, 0.33)] {
                let here = sample(&p, u, v);
                let apart = |a: Sample, b: Sample, c: usize| (a.value[c] - b.value[c]) / (2.0 * h);
                for c in 0..8 {
                    let du = apart(sample(&p, u + h, v), sample(&p, u - h, v), c);
                    let dv = apart(sample(&p, u, v + h), sample(&p, u, v - h), c);
                    assert!((du - here.du[c]).abs() < 1e-7 && (dv - here.dv[c]).abs() < 1e-7, "{n} {u} {v} {c}");
                }
            }
        }
    }

    #[test]
    fn equal_inner_points_make_a_gregory_triangle_plain() {
        let mut p = points(15);
        p.extend(INNER.map(|i| p[i]));
        let (a, b) = (sample(&p, 0.3, 0.25), sample(&p[..15], 0.3, 0.25));
        assert!((0..8).all(|c| (a.value[c] - b.value[c]).abs() < 1e-14 && (a.du[c] - b.du[c]).abs() < 1e-13));
    }
}
