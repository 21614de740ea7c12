//! Limits of vertices: values, and the surface's normal from tangent masks.
//!
//! The masks hold on levels whose faces are all quads (Catmull-Clark) or triangles (Loop), for edges that stay as sharp
//! or as smooth as `stops` says. At a dart they are those of a smooth vertex, as in OpenSubdiv.

use super::level::{Level, Scheme};
use super::stencil::{loop_weight, region_ends, Value};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

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

fn smooth_tangents(level: &Level, h: u32, p: impl Fn(u32) -> DVec3) -> [DVec3; 2] {
    let v = level.origin[h as usize];
    let n = level.fan(v).count() as f64;
    let step = TAU / n;
    let edge = match level.scheme {
        Scheme::Loop => 1.0,
        Scheme::CatmullClark => {
            let c = step.cos();
            1.0 + c + (PI / n).cos() * (2.0 * (9.0 + c)).sqrt()
        }
    };
    let mut tangents = [DVec3::ZERO; 2];
    for (i, g) in level.fan(v).enumerate() {
        let (here, next) = (step * i as f64, step * (i + 1) as f64);
        let e = p(level.next(g));
        tangents[0] += e * (edge * here.cos());
        tangents[1] += e * (edge * here.sin());
        if level.scheme == Scheme::CatmullClark {
            let f = p(level.next(level.next(g)));
            tangents[0] += f * (here.cos() + next.cos());
            tangents[1] += f * (here.sin() + next.sin());
        }
    }
    tangents
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
    // The left eigenvector of the step that vanishes with sin(i theta) towards both ends; inside the region it is that of
    // a smooth vertex with 2 k faces. The entries of vertex and ends follow from their two columns. (The masks of Hoppe
    // et al. 1994 and Biermann et al. 2000 belong to their own, modified rules.)
    let theta = PI / k as f64;
    let (sin, cos) = theta.sin_cos();
    let sum = 1.0 / (0.5 * theta).tan();
    let (edge, face, lambda, of_end, of_vertex) = match level.scheme {
        Scheme::CatmullClark => {
            let root = (0.5 * theta).cos() * (2.0 * (9.0 + cos)).sqrt();
            let edge = 1.0 + cos + root;
            let lambda = (5.0 + cos + root) / 16.0;
            (edge, 1.0, lambda, sin * (edge / 16.0 + 0.25), sum * (0.375 * edge + 0.5))
        }
        Scheme::Loop => (1.0, 0.0, 0.375 + 0.25 * cos, 0.125 * sin, 0.375 * sum),
    };
    // (lambda - 1/2) end - vertex / 8 = of_end;  (lambda - 3/4) vertex - end = of_vertex.
    let (a, d) = (lambda - 0.5, lambda - 0.75);
    let determinant = a * d - 0.125;
    let end = (of_end * d + 0.125 * of_vertex) / determinant;
    let vertex = (a * of_vertex + of_end) / determinant;
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
