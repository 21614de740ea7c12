//! Limits of vertices: values, and the surface's normal from tangent masks.
//!
//! The masks hold on levels whose faces are all quads (Catmull-Clark) or triangles (Loop), for edges that stay as sharp
//! or as smooth as `stops` says. At a dart they are those of a smooth vertex, as in OpenSubdiv.

use super::level::{Level, Scheme};
use super::stencil::{loop_weight, region_ends, Value};
use crate::subdiv::limit::across_weights;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

/// How a vertex behaves from a level on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Inside a smooth part.
    Smooth,
    /// On a crease or the boundary.
    Crease,
    /// Fixed.
    Corner,
}

/// The shape of a vertex with so many sharp edges.
pub fn shape(sharp_edges: u8, corner: bool) -> Shape {
    match sharp_edges {
        _ if corner => Shape::Corner,
        0 | 1 => Shape::Smooth,
        2 => Shape::Crease,
        _ => Shape::Corner,
    }
}

/// Limit of the value at the origin of `h`, in the region of `h`; `at` as in [`super::stencil`].
#[inline]
pub fn limit_value<T: Value>(
    level: &Level,
    h: u32,
    shape: Shape,
    stops: impl Fn(u32) -> bool,
    at: impl Fn(u32) -> T,
) -> T {
    match shape {
        Shape::Corner => at(h),
        Shape::Crease => match region_ends(level, h, stops) {
            Some([a, b]) => (at(h) * 4.0 + at(level.next(a)) + at(level.prev(b))) * (1.0 / 6.0),
            None => at(h),
        },
        Shape::Smooth => {
            if let (Scheme::CatmullClark, Some([a, b, c, d])) = (level.scheme, level.cross(level.origin[h as usize])) {
                let end = |g: u32| at(g & !3 | (g + 1) & 3);
                let ring = end(a) + end(b) + end(c) + end(d);
                let inner = at(a ^ 2) + at(b ^ 2) + at(c ^ 2) + at(d ^ 2);
                return (at(h) * 16.0 + ring * 4.0 + inner) * (1.0 / 36.0);
            }
            let (mut n, mut ring, mut inner) = (0.0, T::default(), T::default());
            for g in level.fan(level.origin[h as usize]) {
                n += 1.0;
                let next = level.next(g);
                ring = ring + at(next);
                if level.scheme == Scheme::CatmullClark {
                    inner = inner + at(level.next(next));
                }
            }
            match level.scheme {
                Scheme::CatmullClark => (at(h) * (n * n) + ring * 4.0 + inner) * (1.0 / (n * (n + 5.0))),
                Scheme::Loop => {
                    let w = 1.0 / (0.375 / loop_weight(n) + n);
                    at(h) * (1.0 - n * w) + ring * w
                }
            }
        }
    }
}

/// Weight of a vertex itself in its limit, inside a smooth part; valence `n`.
pub fn own_limit_weight(scheme: Scheme, n: f64) -> f64 {
    match scheme {
        Scheme::CatmullClark => n / (n + 5.0),
        Scheme::Loop => 1.0 - n / (0.375 / loop_weight(n) + n),
    }
}

/// Unit normal of the limit surface at the origin of `h`, in the region of `h`; zero where the tangents are parallel.
#[inline]
pub fn limit_normal(level: &Level, h: u32, shape: Shape, stops: impl Fn(u32) -> bool) -> DVec3 {
    let p = |g: u32| level.position[level.origin[g as usize] as usize];
    let [u, v] = match shape {
        Shape::Smooth => smooth_tangents(level, h, p),
        Shape::Crease => match region_ends(level, h, stops) {
            Some(ends) => crease_tangents(level, ends, p),
            None => [DVec3::ZERO; 2],
        },
        Shape::Corner => {
            let Some([a, b]) = region_ends(level, h, stops) else {
                return sector_normal(level, level.fan(level.origin[h as usize]), p);
            };
            return sector_normal(level, between(level, a, b), p);
        }
    };
    u.cross(v).normalize_or_zero()
}

/// Half-edges from `a` counter-clockwise to `b`, both included.
fn between(level: &Level, a: u32, b: u32) -> impl Iterator<Item = u32> + '_ {
    std::iter::successors(Some(a), move |&h| if h == b { None } else { level.spoke_after(h) })
}

fn sector_normal(level: &Level, fan: impl Iterator<Item = u32>, p: impl Fn(u32) -> DVec3) -> DVec3 {
    let sum: DVec3 = fan.map(|g| (p(level.next(g)) - p(g)).cross(p(level.prev(g)) - p(g))).sum();
    sum.normalize_or_zero()
}

/// Cosine and sine of `i` of `n` parts of the full turn, `i` less than `n`.
fn turn(i: usize, n: usize) -> [f64; 2] {
    // What meshes have many of, computed once.
    static FEW: LazyLock<[[[f64; 2]; 12]; 12]> =
        LazyLock::new(|| std::array::from_fn(|n| std::array::from_fn(|i| part(i, n))));
    fn part(i: usize, n: usize) -> [f64; 2] {
        let (sin, cos) = (TAU * i as f64 / n as f64).sin_cos();
        [cos, sin]
    }
    if n < 12 {
        FEW[n][i]
    } else {
        part(i, n)
    }
}

#[inline]
fn smooth_tangents(level: &Level, h: u32, p: impl Fn(u32) -> DVec3) -> [DVec3; 2] {
    let v = level.origin[h as usize];
    let spoke = |g: u32| p(level.next(g));
    let opposite = |g: u32| p(level.next(level.next(g)));
    if let (Scheme::CatmullClark, Some(fan)) = (level.scheme, level.cross(v)) {
        // cos and sin are 0 and 1, the weight of spokes 4.
        let end = |g: u32| p(g & !3 | (g + 1) & 3);
        let (a, b, c, d) = (end(fan[0]), end(fan[1]), end(fan[2]), end(fan[3]));
        let (ab, bc, cd, da) = (p(fan[0] ^ 2), p(fan[1] ^ 2), p(fan[2] ^ 2), p(fan[3] ^ 2));
        return [(a - c) * 4.0 + (ab - bc - cd + da), (b - d) * 4.0 + (ab + bc - cd - da)];
    }
    let n = level.fan(v).count();
    let mut tangents = [DVec3::ZERO; 2];
    let turn = |i: usize| turn(i % n, n);
    let edge = match level.scheme {
        Scheme::Loop => 1.0,
        Scheme::CatmullClark => {
            let c = turn(1)[0];
            1.0 + c + (PI / n as f64).cos() * (2.0 * (9.0 + c)).sqrt()
        }
    };
    let mut here = turn(0);
    for (i, g) in level.fan(v).enumerate() {
        let next = turn(i + 1);
        let e = spoke(g);
        tangents[0] += e * (edge * here[0]);
        tangents[1] += e * (edge * here[1]);
        if level.scheme == Scheme::CatmullClark {
            let f = opposite(g);
            tangents[0] += f * (here[0] + next[0]);
            tangents[1] += f * (here[1] + next[1]);
        }
        here = next;
    }
    tangents
}

/// As [`across_weights`], which explains it, with the columns of Loop's step; there are no corners opposite.
pub(super) fn loop_across_weights(k: usize) -> [f64; 3] {
    let theta = PI / k as f64;
    let (sin, cos) = theta.sin_cos();
    let lambda = 0.375 + 0.25 * cos;
    let (of_end, of_vertex) = (0.125 * sin, 0.375 / (0.5 * theta).tan());
    let (a, d) = (lambda - 0.5, lambda - 0.75);
    let determinant = a * d - 0.125;
    [(a * of_vertex + of_end) / determinant, (of_end * d + 0.125 * of_vertex) / determinant, 1.0]
}

/// Along the crease and across it into the region from `first` to `last`.
fn crease_tangents(level: &Level, [first, last]: [u32; 2], p: impl Fn(u32) -> DVec3) -> [DVec3; 2] {
    let k = between(level, first, last).count();
    let (v, from, to) = (p(first), p(level.next(first)), p(level.prev(last)));
    let along = from - to;
    if k == 1 {
        // The curve turns round the only face: both directions lie in the plane of its ends.
        return [along, from + to - v * 2.0];
    }
    // The left eigenvector of the step that vanishes with sin(i theta) towards both ends. (The masks of Hoppe et al. 1994
    // and Biermann et al. 2000 belong to their own, modified rules.)
    let theta = PI / k as f64;
    let ([vertex, end, edge], face) = match level.scheme {
        Scheme::CatmullClark => (across_weights(k), 1.0),
        Scheme::Loop => (loop_across_weights(k), 0.0),
    };
    let mut across = v * vertex + (from + to) * end;
    for (i, g) in between(level, first, last).enumerate() {
        let (here, next) = ((i as f64 * theta).sin(), ((i + 1) as f64 * theta).sin());
        if i > 0 {
            across += p(level.next(g)) * (edge * here);
        }
        if face > 0.0 {
            across += p(level.next(level.next(g))) * (face * (here + next));
        }
    }
    [along, across]
}
