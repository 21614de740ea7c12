//! The stencils of both schemes, for whatever can be added and scaled.
//!
//! A stencil asks for the value at the origin of a half-edge *as seen from its face* (`at`): for positions that is the
//! vertex, for normals the region of the face. So one rule does for all channels, and at a sharp edge each side gets its own
//! result.

use super::level::{Level, Scheme};
use super::refine::{child_corner, is_lower};
use super::region::Wedges;
use crate::mesh::NONE;
use glam::DVec3;
use std::ops::{Add, Mul};

/// What stencils combine.
pub trait Value: Copy + Default + Add<Output = Self> + Mul<f64, Output = Self> {}

impl Value for f64 {}
impl Value for DVec3 {}

/// What a vertex does in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Fewer than two sharp edges.
    Smooth,
    /// Two sharp edges.
    Crease,
    /// More, or sharp itself.
    Corner,
}

impl Rule {
    fn of(sharp_edges: u32, corner: bool) -> Rule {
        match sharp_edges {
            _ if corner => Rule::Corner,
            0 | 1 => Rule::Smooth,
            2 => Rule::Crease,
            _ => Rule::Corner,
        }
    }
}

/// The rule of `v` in the step from `level`, the rule once its sharpness has decayed, and the part of the first.
pub fn rules(level: &Level, v: u32) -> (Rule, Rule, f64) {
    let (edges, corner) = (u32::from(level.sharp_edges[v as usize]), level.corner_sharpness(v));
    let now = Rule::of(edges, corner > 0.0);
    if now == Rule::Smooth {
        return (now, now, 1.0);
    }
    // DKT98 blends by the mean of the sharpness that runs out in this step; where none does, there is one rule.
    let (mut ending, mut sum, mut later) = (0, 0.0, 0);
    let mut count = |s: f64| {
        if s > 1.0 {
            later += 1;
        } else if s > 0.0 {
            ending += 1;
            sum += s;
        }
    };
    for h in level.fan(v) {
        count(level.sharpness[level.edge[h as usize] as usize]);
        let p = level.prev(h);
        if level.twin[p as usize] == NONE {
            count(f64::INFINITY);
        }
    }
    if corner > 0.0 && corner <= 1.0 {
        ending += 1;
        sum += corner;
    }
    let then = Rule::of(later, corner > 1.0);
    if then == now || ending == 0 {
        return (now, now, 1.0);
    }
    (now, then, (sum / f64::from(ending)).min(1.0))
}

/// Weight of each neighbour of a smooth vertex of valence `n` in Loop's scheme.
pub fn loop_weight(n: f64) -> f64 {
    let c = 0.375 + 0.25 * (std::f64::consts::TAU / n).cos();
    (0.625 - c * c) / n
}

/// The first half-edge clockwise from `h` whose edge `stops`, and the last counter-clockwise whose edge *before it* in the
/// face stops: the region around the corner of `h`. `None` when no edge stops.
pub fn region_ends(level: &Level, h: u32, stops: impl Fn(u32) -> bool) -> Option<[u32; 2]> {
    let mut first = h;
    while !stops(first) {
        first = level.spoke_before(first)?;
        if first == h {
            return None;
        }
    }
    let mut last = h;
    while !stops(level.prev(last)) {
        last = level.spoke_after(last)?;
    }
    Some([first, last])
}

/// The value across the edge of `h` from its origin: the mean of what both faces see at the far end.
fn far<T: Value>(level: &Level, h: u32, at: &impl Fn(u32) -> T) -> T {
    let here = at(level.next(h));
    match level.twin[h as usize] {
        NONE => here,
        t => (here + at(t)) * 0.5,
    }
}

fn face_point<T: Value>(level: &Level, f: usize, at: &impl Fn(u32) -> T) -> T {
    let face = level.of_face(f);
    let n = f64::from(face.end - face.start);
    face.fold(T::default(), |sum, h| sum + at(h)) * (1.0 / n)
}

/// Edge point on the side of `h`.
fn edge_point<T: Value>(level: &Level, faces: &[T], h: u32, at: &impl Fn(u32) -> T) -> T {
    let sharp = || (at(h) + at(level.next(h))) * 0.5;
    let s = level.sharpness[level.edge[h as usize] as usize];
    let t = level.twin[h as usize];
    if s >= 1.0 || t == NONE {
        return sharp();
    }
    let ends = (at(h) + at(level.next(h)) + at(t) + at(level.next(t))) * 0.5;
    let smooth = match level.scheme {
        Scheme::CatmullClark => (ends + faces[level.face_of(h)] + faces[level.face_of(t)]) * 0.25,
        Scheme::Loop => ends * 0.375 + (at(level.prev(h)) + at(level.prev(t))) * 0.125,
    };
    if s > 0.0 {
        smooth * (1.0 - s) + sharp() * s
    } else {
        smooth
    }
}

/// What a rule makes of the vertex at the origin of `h`, in the region of `h`.
fn vertex_by<T: Value>(
    level: &Level,
    faces: &[T],
    h: u32,
    rule: Rule,
    stops: impl Fn(u32) -> bool,
    at: &impl Fn(u32) -> T,
) -> T {
    match rule {
        Rule::Corner => at(h),
        Rule::Crease => match region_ends(level, h, stops) {
            Some([a, b]) => at(h) * 0.75 + (at(level.next(a)) + at(level.prev(b))) * 0.125,
            None => at(h),
        },
        Rule::Smooth => {
            let v = level.origin[h as usize];
            let (mut n, mut own, mut ring, mut inner) = (0.0, T::default(), T::default(), T::default());
            for g in level.fan(v) {
                n += 1.0;
                own = own + at(g);
                ring = ring + far(level, g, at);
                if level.scheme == Scheme::CatmullClark {
                    inner = inner + faces[level.face_of(g)];
                }
            }
            let own = own * (1.0 / n);
            match level.scheme {
                Scheme::CatmullClark => own * ((n - 2.0) / n) + (ring + inner) * (1.0 / (n * n)),
                Scheme::Loop => {
                    let w = loop_weight(n);
                    own * (1.0 - n * w) + ring * w
                }
            }
        }
    }
}

/// Vertex point in the region of `h`.
fn vertex_point<T: Value>(level: &Level, faces: &[T], h: u32, at: &impl Fn(u32) -> T) -> T {
    let (now, then, part) = rules(level, level.origin[h as usize]);
    let first = vertex_by(level, faces, h, now, |g| level.is_sharp(g), at);
    if part == 1.0 {
        return first;
    }
    let later = |g: u32| level.sharpness[level.edge[g as usize] as usize] > 1.0;
    first * part + vertex_by(level, faces, h, then, later, at) * (1.0 - part)
}

/// Values of the level after `level`: one a vertex, or one a wedge if `wedges` (those of the next level) are given. `at(h)`
/// is the value at the origin of `h` in the region of its face. Only vertices that are `wanted` are computed; the others
/// get the default.
pub fn refine_values<T: Value>(
    level: &Level,
    wedges: Option<&Wedges>,
    at: impl Fn(u32) -> T,
    wanted: impl Fn(usize) -> bool,
) -> Vec<T> {
    let old = level.vertices();
    let faces = if level.scheme == Scheme::CatmullClark { level.faces() } else { 0 };
    let count = wedges.map_or(old + faces + level.edges(), Wedges::len);
    let mut out = vec![T::default(); count];
    // The wedge at the corner of child half-edge `c`, whose vertex is `v`.
    let slot = |c: u32, v: usize| wedges.map_or(v, |w| w.of[c as usize] as usize);
    // Face points are cheap and serve others: all of them.
    let inner: Vec<T> = (0..faces).map(|f| face_point(level, f, &at)).collect();
    out[old..old + faces].copy_from_slice(&inner);
    for h in 0..level.half_edges() as u32 {
        let e = level.edge[h as usize] as usize;
        // Both sides where there are two wedges.
        if is_lower(level, h) || (wedges.is_some() && level.is_sharp(h)) {
            let v = old + faces + e;
            if wanted(v) {
                let c = match level.scheme {
                    Scheme::CatmullClark => 4 * h + 1,
                    Scheme::Loop => child_corner(level, h) + 1,
                };
                out[slot(c, v)] = edge_point(level, &inner, h, &at);
            }
        }
    }
    for v in 0..old {
        if !wanted(v) {
            continue;
        }
        let spoke = level.spoke[v];
        let split = wedges.is_some_and(|_| level.sharp_edges[v] > 0);
        if !split {
            out[slot(child_corner(level, spoke), v)] = vertex_point(level, &inner, spoke, &at);
            continue;
        }
        for h in level.fan(v as u32) {
            // One corner of each region is enough: the one after its first sharp edge, or the first of the fan.
            if h == spoke || level.is_sharp(h) {
                out[slot(child_corner(level, h), v)] = vertex_point(level, &inner, h, &at);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh;
    use crate::scene::surface::SurfaceScene;
    use crate::surface::limit::{limit_normal, limit_value, shape, Shape};
    use crate::surface::refine::levels;
    use crate::surface::shade::limit_positions;

    fn subdivided(text: &str, scheme: Scheme, depth: u32) -> Vec<Level> {
        let scene = SurfaceScene::parse(text.as_bytes(), "test").unwrap();
        levels(&scene, &mesh::build(&scene.polygons()).unwrap(), scheme, depth).unwrap()
    }

    /// A cone of `n` quads or triangles around vertex 0, bumpy and open.
    fn cone(n: usize, quads: bool) -> String {
        let ring = if quads { 2 * n } else { n };
        let mut text = "v 0 0 1\n".to_string();
        for i in 0..ring {
            let a = std::f64::consts::TAU * i as f64 / ring as f64;
            text += &format!("v {} {} {}\n", a.cos(), 1.3 * a.sin(), 0.2 * (i as f64 * 1.7).sin());
        }
        for i in 0..n {
            let at = |k: usize| 2 + k % ring;
            text += &match quads {
                true => format!("f 1 {} {} {}\n", at(2 * i), at(2 * i + 1), at(2 * i + 2)),
                false => format!("f 1 {} {}\n", at(i), at(i + 1)),
            };
        }
        text
    }

    const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1.1 0\nv 0 1 0\nv 0 0 1\nv 1 0.2 1\nv 1 1 1.3\nv 0 1 1\n\
        f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.2 0.1 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

    #[test]
    fn limit_masks_are_what_steps_converge_to() {
        for n in 3..9 {
            for scheme in [Scheme::CatmullClark, Scheme::Loop] {
                let levels = subdivided(&cone(n, scheme == Scheme::CatmullClark), scheme, 1);
                // A vertex and its ring are a linear map of themselves: the limit does not change by a step.
                let limits: Vec<DVec3> = levels.iter().map(|l| limit_positions(l)[0]).collect();
                assert!((limits[0] - limits[1]).length() < 1e-14, "{scheme:?} {n}: {limits:?}");
                // Nor does the normal, nor do those of boundary vertices of any number of faces.
                for v in 0..levels[0].vertices() as u32 {
                    let normal = |l: &Level| {
                        let shape = shape(l.sharp_edges[v as usize], false);
                        limit_normal(l, l.spoke[v as usize], shape, |h| l.is_sharp(h))
                    };
                    let turn = normal(&levels[0]).angle_between(normal(&levels[1]));
                    assert!(turn < 1e-7 && normal(&levels[0]).is_normalized(), "{scheme:?} {n}, vertex {v}: {turn}");
                }
            }
        }
    }

    #[test]
    fn crease_normals_of_any_number_of_faces_do_not_change_by_a_step() {
        // Edges 0-1 and 0-k are sharp: k faces on one side, n - k on the other.
        for n in 3..8 {
            for scheme in [Scheme::CatmullClark, Scheme::Loop] {
                let quads = scheme == Scheme::CatmullClark;
                for k in 2..n - 1 {
                    let end = if quads { 2 * k + 1 } else { k + 1 };
                    let text = format!("{}t crease 2/1/0 0 1 99\nt crease 2/1/0 0 {end} 99\n", cone(n, quads));
                    let levels = subdivided(&text, scheme, 1);
                    assert_eq!(levels[0].sharp_edges[0], 2);
                    for h in levels[0].fan(0) {
                        let normal = |l: &Level, h| limit_normal(l, h, Shape::Crease, |h| l.is_sharp(h));
                        let (a, b) = (normal(&levels[0], h), normal(&levels[1], child_corner(&levels[0], h)));
                        assert!(a.angle_between(b) < 1e-7 && a.z > 0.3, "{scheme:?} {n} {k}: {a} {b}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_crease_is_a_cubic_b_spline() {
        // Around one face of a closed mesh: a closed curve, four or three control points.
        for (text, scheme, ends) in
            [(CUBE, Scheme::CatmullClark, vec![0, 1, 2, 3]), (TETRAHEDRON, Scheme::Loop, vec![0, 1, 2])]
        {
            let n = ends.len();
            let mut tagged = text.to_string();
            for i in 0..n {
                tagged += &format!("t crease 2/1/0 {} {} 10\n", ends[i], ends[(i + 1) % n]);
            }
            let levels = subdivided(&tagged, scheme, 2);
            let q = |i: usize| levels[0].position[ends[i % n]];
            let limits = limit_positions(&levels[2]);
            for (v, limit) in limits.iter().enumerate().filter(|(v, _)| levels[2].sharp_edges[*v] == 2) {
                // Its vertices are uniform parameters k / 4 of the spline: one of them has to fit.
                let fits = (0..4 * n).any(|k| {
                    let (i, t) = (k / 4, (k % 4) as f64 / 4.0);
                    let s = 1.0 - t;
                    let b = q(i) * (s * s * s)
                        + q(i + 1) * (3.0 * t * t * t - 6.0 * t * t + 4.0)
                        + q(i + 2) * (-3.0 * t * t * t + 3.0 * t * t + 3.0 * t + 1.0)
                        + q(i + 3) * (t * t * t);
                    (b / 6.0 - *limit).length() < 1e-12
                });
                assert!(fits, "{scheme:?}, vertex {v}");
            }
            assert_eq!(levels[2].sharp_edges.iter().filter(|&&s| s == 2).count(), 4 * n);
        }
    }

    #[test]
    fn sharpness_goes_from_smooth_to_endless() {
        let tagged = |s: f64| format!("{CUBE}t crease 4/1/0 0 1 2 6 {s}\nt corner 1/1/0 4 {s}\n");
        let at = |s: f64, depth| subdivided(&tagged(s), Scheme::CatmullClark, depth).pop().unwrap().position;
        let distance = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
        let plain = subdivided(CUBE, Scheme::CatmullClark, 3).pop().unwrap().position;
        assert!(distance(&at(0.0, 3), &plain) < 1e-15);
        assert!(distance(&at(3.0, 3), &at(99.0, 3)) < 1e-15, "above the level is endless");
        assert!(distance(&at(2.0, 3), &at(99.0, 3)) > 1e-3);
        // Continuous in between, through whole numbers.
        for s in [1e-9, 1.0 - 1e-9, 1.0, 2.0 - 1e-9, 2.0] {
            let step = distance(&at(s, 3), &at(s + 1e-9, 3));
            assert!(step > 0.0 && step < 1e-8, "{s}: {step}");
        }
        // Half way, DKT98 blends.
        let half: Vec<DVec3> = at(0.0, 1).iter().zip(at(1.0, 1)).map(|(a, b)| (*a + b) * 0.5).collect();
        assert!(distance(&at(0.5, 1), &half) < 1e-15);
    }

    #[test]
    fn smooth_limits_are_the_known_ones() {
        let levels = subdivided(CUBE, Scheme::CatmullClark, 0);
        let p = &levels[0].position;
        // n v^2 + 4 edges + faces over n (n + 5), n = 3.
        let expected = (p[0] * 9.0 + (p[1] + p[3] + p[4]) * 4.0 + p[2] + p[5] + p[7]) / 24.0;
        let limit = limit_value(
            &levels[0],
            levels[0].spoke[0],
            Shape::Smooth,
            |_| false,
            |h| p[levels[0].origin[h as usize] as usize],
        );
        assert!((limit - expected).length() < 1e-15);
        // Loop, n = 3: beta = 3/16.
        let levels = subdivided(TETRAHEDRON, Scheme::Loop, 0);
        let p = &levels[0].position;
        let expected = p[0] * 0.4 + (p[1] + p[2] + p[3]) * 0.2;
        assert!((limit_positions(&levels[0])[0] - expected).length() < 1e-15);
    }
}
