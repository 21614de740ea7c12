//! The stencils of both schemes, for whatever can be added and scaled.
//!
//! A stencil asks for the value at the origin of a half-edge *as seen from its face* (`at`): for positions that is the
//! vertex, for normals the region of the face. So one rule does for all channels, and at a sharp edge each side gets its own
//! result.

use super::level::{Level, Scheme};
use super::refine::{parent, Parent};
use super::region::Wedges;
use crate::mesh::NONE;
use crate::threads;
use glam::DVec3;
use std::ops::{Add, Mul};
use std::sync::LazyLock;

/// What stencils combine.
pub trait Value: Copy + Default + Send + Sync + Add<Output = Self> + Mul<f64, Output = Self> {}

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
    // What meshes have many of, computed once.
    static FEW: LazyLock<[f64; 16]> = LazyLock::new(|| std::array::from_fn(|n| weight(n as f64)));
    fn weight(n: f64) -> f64 {
        let c = 0.375 + 0.25 * (std::f64::consts::TAU / n).cos();
        (0.625 - c * c) / n
    }
    if n < 16.0 {
        FEW[n as usize]
    } else {
        weight(n)
    }
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

/// What stencils see of a level. `PLAIN`: all faces at a vertex see the same there.
struct Seen<'a, T, F, const PLAIN: bool> {
    level: &'a Level,
    /// Face points; none under Loop.
    faces: &'a [T],
    /// At the origin of a half-edge, from its face.
    at: F,
}

impl<T: Value, F: Fn(u32) -> T, const PLAIN: bool> Seen<'_, T, F, PLAIN> {
    #[inline(always)]
    fn at(&self, h: u32) -> T {
        (self.at)(h)
    }

    /// The value across the edge of `h` from its origin: the mean of what both faces see at the far end.
    #[inline(always)]
    fn far(&self, h: u32) -> T {
        let here = self.at(self.level.next(h));
        match self.level.twin[h as usize] {
            _ if PLAIN => here,
            NONE => here,
            t => (here + self.at(t)) * 0.5,
        }
    }

    /// Edge point on the side of `h`.
    #[inline]
    fn edge_point(&self, h: u32) -> T {
        let level = self.level;
        let along = || self.at(h) + self.at(level.next(h));
        let s = level.sharpness[level.edge[h as usize] as usize];
        let t = level.twin[h as usize];
        if s >= 1.0 || t == NONE {
            return along() * 0.5;
        }
        let ends = if PLAIN { along() } else { (along() + self.at(t) + self.at(level.next(t))) * 0.5 };
        let smooth = match level.scheme {
            Scheme::CatmullClark => (ends + self.faces[level.face_of(h)] + self.faces[level.face_of(t)]) * 0.25,
            Scheme::Loop => ends * 0.375 + (self.at(level.prev(h)) + self.at(level.prev(t))) * 0.125,
        };
        if s > 0.0 {
            smooth * (1.0 - s) + along() * (0.5 * s)
        } else {
            smooth
        }
    }

    /// What a rule makes of the vertex at the origin of `h`, in the region of `h`.
    fn vertex_by(&self, h: u32, rule: Rule, stops: impl Fn(u32) -> bool) -> T {
        let level = self.level;
        match rule {
            Rule::Corner => self.at(h),
            Rule::Crease => match region_ends(level, h, stops) {
                Some([a, b]) => self.at(h) * 0.75 + (self.at(level.next(a)) + self.at(level.prev(b))) * 0.125,
                None => self.at(h),
            },
            Rule::Smooth => self.smooth(h),
        }
    }

    #[inline(always)]
    fn smooth(&self, h: u32) -> T {
        let level = self.level;
        let v = level.origin[h as usize];
        if PLAIN && level.scheme == Scheme::CatmullClark {
            if let Some([a, b, c, d]) = level.cross(v) {
                let ring = self.far(a) + self.far(b) + self.far(c) + self.far(d);
                let face = |g: u32| self.faces[(g / 4) as usize];
                let inner = face(a) + face(b) + face(c) + face(d);
                return self.at(h) * 0.5 + (ring + inner) * 0.0625;
            }
        }
        let (mut n, mut own, mut ring, mut inner) = (0.0, T::default(), T::default(), T::default());
        for g in level.fan(v) {
            n += 1.0;
            if !PLAIN {
                own = own + self.at(g);
            }
            ring = ring + self.far(g);
            if level.scheme == Scheme::CatmullClark {
                inner = inner + self.faces[level.face_of(g)];
            }
        }
        let own = if PLAIN { self.at(h) } else { own * (1.0 / n) };
        match level.scheme {
            Scheme::CatmullClark => own * ((n - 2.0) / n) + (ring + inner) * (1.0 / (n * n)),
            Scheme::Loop => {
                let w = loop_weight(n);
                own * (1.0 - n * w) + ring * w
            }
        }
    }

    /// Vertex point in the region of `h`.
    #[inline]
    fn vertex_point(&self, h: u32) -> T {
        let level = self.level;
        let v = level.origin[h as usize];
        if level.sharp_edges[v as usize] < 2 && level.corner.is_empty() {
            return self.smooth(h);
        }
        let (now, then, part) = rules(level, v);
        let first = self.vertex_by(h, now, |g| level.is_sharp(g));
        if part == 1.0 {
            return first;
        }
        let later = |g: u32| level.sharpness[level.edge[g as usize] as usize] > 1.0;
        first * part + self.vertex_by(h, then, later) * (1.0 - part)
    }
}

/// Face points of the next level, all of them: they are cheap and serve others.
fn face_points<T: Value>(level: &Level, at: impl Fn(u32) -> T + Sync + Send) -> Vec<T> {
    match (level.scheme, level.sides) {
        (Scheme::Loop, _) => Vec::new(),
        (_, 4) => threads::collect(level.faces(), |f| {
            let h = 4 * f as u32;
            (at(h) + at(h + 1) + at(h + 2) + at(h + 3)) * 0.25
        }),
        _ => threads::collect(level.faces(), |f| {
            let face = level.of_face(f);
            let n = f64::from(face.end - face.start);
            face.fold(T::default(), |sum, h| sum + at(h)) * (1.0 / n)
        }),
    }
}

/// Values of the level after `level`, one a vertex, from one a vertex. Only vertices that are `wanted` are right (none
/// given: all); the others get the default.
pub fn refine_values<T: Value>(level: &Level, of: &[T], wanted: Option<&[bool]>) -> Vec<T> {
    let at = |h: u32| of[level.origin[h as usize] as usize];
    let faces = face_points(level, at);
    let seen: Seen<T, _, true> = Seen { level, faces: &faces, at };
    let wanted = |v: usize| wanted.is_none_or(|w| w[v]);
    let (old, edge_points) = (level.vertices(), level.vertices() + faces.len());
    let lower = level.lower();
    let mut out = Vec::with_capacity(edge_points + lower.len());
    threads::append(&mut out, old, |v| if wanted(v) { seen.vertex_point(level.spoke[v]) } else { T::default() });
    out.extend_from_slice(&faces);
    let edge = |e: usize| if wanted(edge_points + e) { seen.edge_point(lower[e]) } else { T::default() };
    threads::append(&mut out, lower.len(), edge);
    out
}

/// The same with one value a wedge of the next level. `at(h)` is the value at the origin of `h` in the region of its face.
pub fn refine_wedge_values<T: Value>(
    level: &Level,
    wedges: &Wedges,
    at: impl Fn(u32) -> T + Sync + Send,
    wanted: Option<&[bool]>,
) -> Vec<T> {
    let faces = face_points(level, &at);
    let seen: Seen<T, _, false> = Seen { level, faces: &faces, at };
    let wanted = |v: usize| wanted.is_none_or(|w| w[v]);
    let edge_points = level.vertices() + faces.len();
    threads::collect(wedges.len(), |w| match parent(level, wedges.first[w]) {
        Parent::Vertex(h) if wanted(level.origin[h as usize] as usize) => seen.vertex_point(h),
        Parent::Face(f) => faces[f],
        Parent::Edge(h) if wanted(edge_points + level.edge[h as usize] as usize) => seen.edge_point(h),
        _ => T::default(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh;
    use crate::scene::surface::SurfaceScene;
    use crate::surface::limit::{limit_normal, limit_value, shape, Shape};
    use crate::surface::refine::{child_corner, levels};
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
