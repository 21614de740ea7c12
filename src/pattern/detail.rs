//! Levels of detail (BS05 3.3), for the whole mesh or triangle by triangle, and geomorphing between them, which the paper
//! leaves to the future.
//!
//! A level is a real number l from 0 to 7: an edge of level l has 2^l segments where l is whole. In between, the finer
//! lattice is drawn and its odd vertices slide, as l falls, along the surface into an even one, on edges towards the nearer
//! end:
//!
//! ```text
//!   l = 2      0 ------- 1 ------- 2 ------- 3 ------- 4
//!   l = 1.5    0 --- 1 ----------- 2 ----------- 3 --- 4
//!   l = 1     0=1 ---------------- 2 --------------- 3=4
//! ```
//!
//! A triangle is drawn by the pattern of 2^ceil(l) segments, l the greatest level of its edges. The vertices on an edge
//! are gathered into those that the edge's own level has, counted in a direction that both triangles agree on, so seams
//! between levels have the same vertices on either side, bit for bit. Where vertices meet, triangles have no area. No
//! vertex leaves the surface, and nothing jumps, whatever level changes. The border of a triangle stays its border, so the
//! pattern covers all of it.

use super::control::{Control, TANGENT_ENDS};
use crate::camera::{Camera, Projection};
use glam::{DVec3, Vec3};

/// Greatest level: 2^7 = 128 segments.
pub const MOST: u32 = 7;

/// What a level is chosen for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scope {
    /// All of the mesh: the paper's way.
    Mesh,
    /// Each edge, and with them each triangle.
    #[default]
    Triangle,
}

/// How levels are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// What for.
    pub scope: Scope,
    /// Pixels that a segment of an edge should have, above 0.
    pub segment: f64,
    /// Greatest level, 0 to [`MOST`].
    pub most: u32,
    /// Levels between whole ones; without, they are rounded up and pop.
    pub morph: bool,
}

impl Default for Detail {
    fn default() -> Detail {
        Detail { scope: Scope::Triangle, segment: 8.0, most: MOST, morph: true }
    }
}

impl Detail {
    /// Vertices of all patterns up to level `most`.
    pub fn vertices(most: u32) -> usize {
        (0..=most).map(|up| ((1 << up) + 1) * ((1 << up) + 2) / 2).sum()
    }
}

/// From where lengths are judged. Twin of `View` in `glsl/pattern_detail.comp`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Eye.
    pub eye: Vec3,
    /// Pixels a model unit: at distance 1, or everywhere in an orthographic view.
    pub scale: f32,
    /// Whether distance does not matter.
    pub orthographic: bool,
}

impl View {
    /// The view of a camera on a picture of `height` pixels.
    pub fn new(camera: &Camera, height: u32) -> View {
        let height = f64::from(height);
        let (scale, orthographic) = match camera.projection {
            Projection::Perspective { fov } => (0.5 * height / (0.5 * fov.to_radians()).tan(), false),
            Projection::Orthographic { height: units } => (height / units, true),
        };
        View { eye: camera.eye.as_vec3(), scale: scale as f32, orthographic }
    }

    /// Pixels of a length around a point: as if it were seen from its nearest possible place.
    fn pixels(&self, length: f32, middle: Vec3) -> f32 {
        if self.orthographic {
            return length * self.scale;
        }
        let distance = (middle - self.eye).length() - 0.5 * length;
        length * self.scale / distance.max(0.05 * length)
    }
}

/// Levels of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// Of edges 01, 12, 20.
    pub edges: [f32; 3],
    /// Of the inside: the greatest of the edges.
    pub inner: f32,
    /// Bit e: edge e is counted from its second corner.
    pub turned: u32,
}

impl Levels {
    /// Exponent of the pattern that the triangle is drawn by.
    pub fn pattern(&self) -> u32 {
        self.inner.ceil() as u32
    }
}

/// The way from a to b is counted backwards: both triangles of an edge say the same of the edge.
fn turned(a: Vec3, b: Vec3) -> bool {
    (a.x, a.y, a.z) > (b.x, b.y, b.z)
}

fn level(detail: &Detail, pixels: f32) -> f32 {
    let level = (pixels / detail.segment as f32).log2();
    let level = if detail.morph { level } else { level.ceil() };
    // NaN is 0.
    level.max(0.0).min(detail.most as f32)
}

/// Length of the control polygon of edge e, the middle of its ends, and whether it is turned. The same bits from both
/// triangles.
fn polygon(c: &Control, e: usize) -> (f32, Vec3, bool) {
    // TANGENT_ENDS and the points after the corners run edge by edge: near the first corner, near the second.
    let [i, j] = TANGENT_ENDS[2 * e];
    let mut p = [c.points[i], c.points[3 + 2 * e], c.points[4 + 2 * e], c.points[j]].map(|p| p.as_vec3());
    let turned = turned(p[0], p[3]);
    if turned {
        p.reverse();
    }
    let length = ((p[1] - p[0]).length() + (p[2] - p[1]).length()) + (p[3] - p[2]).length();
    (length, (p[0] + p[3]) * 0.5, turned)
}

/// The one level of a mesh whose corners lie within `bounds`: by the mean length of its edges as seen in the middle.
pub fn mesh_level(controls: &[Control], bounds: [DVec3; 2], detail: &Detail, view: &View) -> f32 {
    let lengths = controls.iter().flat_map(|c| (0..3).map(|e| f64::from(polygon(c, e).0)));
    let mean = lengths.sum::<f64>() / (3 * controls.len()).max(1) as f64;
    level(detail, view.pixels(mean as f32, ((bounds[0] + bounds[1]) * 0.5).as_vec3()))
}

/// Levels of one triangle; `all`: the level of the mesh, where there is one for all.
pub fn levels(c: &Control, detail: &Detail, view: &View, all: Option<f32>) -> Levels {
    let mut edges = [0.0; 3];
    let mut bits = 0;
    for (e, edge) in edges.iter_mut().enumerate() {
        let (length, middle, turned) = polygon(c, e);
        bits |= u32::from(turned) << e;
        *edge = all.unwrap_or_else(|| level(detail, view.pixels(length, middle)));
    }
    Levels { edges, inner: edges[0].max(edges[1]).max(edges[2]), turned: bits }
}

/// Levels of all triangles of a mesh whose corners lie within `bounds`.
pub fn all(controls: &[Control], bounds: [DVec3; 2], detail: &Detail, view: &View) -> Vec<Levels> {
    let whole = (detail.scope == Scope::Mesh).then(|| mesh_level(controls, bounds, detail, view));
    controls.iter().map(|c| levels(c, detail, view, whole)).collect()
}

/// Part of the way that is left, and that is gone, of vertex k of n on an edge of level l. Vertices are gathered towards
/// the nearer end, the middle one to the first: away from both edges at a corner, the cell there would cover all. Twin of
/// `along` in `glsl/inc/detail.glsl`.
fn along(k: u32, n: u32, level: f32) -> [f32; 2] {
    let far = 2 * k > n;
    let up = level.ceil();
    let m = (1 << up as u32).min(n);
    let j = if far { n - k } else { k } / (n / m);
    let x = if m > 1 && j % 2 == 1 { (j - 1) as f32 + (level - up + 1.0) } else { j as f32 };
    let [left, gone] = [(m as f32 - x) / m as f32, x / m as f32];
    if far {
        [gone, left]
    } else {
        [left, gone]
    }
}

/// Weights of a vertex on the border; `c` counts n-ths.
fn border(c: [u32; 3], n: u32, levels: &Levels) -> [f32; 3] {
    // The edge across from a corner of weight 0.
    let e = (0..3).find(|&e| c[(e + 2) % 3] == 0).unwrap_or(0);
    let (mut from, mut to) = (e, (e + 1) % 3);
    if levels.turned >> e & 1 == 1 {
        std::mem::swap(&mut from, &mut to);
    }
    let [left, gone] = along(c[to], n, levels.edges[e]);
    let mut weights = [0.0; 3];
    (weights[from], weights[to]) = (left, gone);
    weights
}

/// Where a vertex of the triangular pattern of level n (a power of two, that of [`Levels::pattern`]) goes: its weights.
/// Twin of `place` in `glsl/inc/detail.glsl`.
pub fn place(weights: [f32; 3], n: u32, levels: &Levels) -> [f32; 3] {
    let c = weights.map(|w| (w * n as f32 + 0.5) as u32);
    if c.contains(&0) {
        return border(c, n, levels);
    }
    let here = c.map(|c| c as f32 / n as f32);
    // Of an odd vertex two weights are odd: i and the next.
    let Some(i) = (0..3).find(|&i| c[i] % 2 == 1 && c[(i + 1) % 3] % 2 == 1) else { return here };
    let neighbour = |up: usize, down: usize| {
        let mut to = c;
        to[up] += 1;
        to[down] -= 1;
        to
    };
    let (next, mut to) = ((i + 1) % 3, neighbour(i, (i + 1) % 3));
    if to.contains(&0) && !neighbour(next, i).contains(&0) {
        // Rather inwards: those on the border may have been gathered far away.
        to = neighbour(next, i);
    }
    let there = if to.contains(&0) { border(to, n, levels) } else { to.map(|c| c as f32 / n as f32) };
    let g = levels.inner - levels.inner.ceil() + 1.0;
    std::array::from_fn(|k| there[k] * (1.0 - g) + here[k] * g)
}

#[cfg(test)]
mod tests {
    use super::super::lattice::RefinementPattern;
    use super::*;

    fn some_levels() -> Vec<Levels> {
        let mut all = Vec::new();
        for turned in 0..8 {
            for edges in [
                [0.0, 0.0, 0.0],
                [3.0, 2.3, 0.4],
                [0.01, 1.99, 4.2],
                [5.0, 5.0, 4.99],
                [0.0, 0.0, 2.5],
                [2.7, 2.3, 2.1],
                [4.4, 4.0, 3.5],
                [3.0, 0.0, 1.0],
                [0.0, 0.0, 4.0],
                [2.0, 5.0, 0.0],
            ] {
                let inner = edges.into_iter().fold(0.0, f32::max);
                all.push(Levels { edges, inner, turned });
            }
        }
        all
    }

    fn placed(levels: &Levels) -> (RefinementPattern, Vec<[f32; 3]>) {
        let n = 1 << levels.pattern();
        let pattern = RefinementPattern::triangle(n).unwrap();
        let at = pattern.weights.iter().map(|&w| place(w, n, levels)).collect();
        (pattern, at)
    }

    #[test]
    fn whole_levels_leave_the_pattern_alone() {
        for up in 0..=5 {
            let l = up as f32;
            for turned in 0..8 {
                let (pattern, at) = placed(&Levels { edges: [l; 3], inner: l, turned });
                assert_eq!(pattern.weights, at);
            }
        }
    }

    #[test]
    fn placed_patterns_cover_the_triangle_and_hardly_turn_over() {
        for levels in some_levels() {
            let (pattern, at) = placed(&levels);
            let least = levels.edges.into_iter().fold(f32::MAX, f32::min);
            // Where levels of edges are octaves apart, what slides towards a gathered edge overlaps a little.
            let whole = levels.edges.iter().all(|l| l.fract() == 0.0);
            let let_pass = if levels.inner - least > 1.0 && !whole { 0.05 } else { 1e-6 };
            let mut turned_over = 0.0;
            let mut area = 0.0;
            for t in pattern.indices.chunks(3) {
                let [a, b, c] = [0, 1, 2].map(|k| at[t[k] as usize].map(f64::from));
                let twice = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
                turned_over -= twice.min(0.0);
                area += twice;
            }
            assert!((area - 1.0).abs() < 1e-5, "{levels:?}: {area}");
            assert!(turned_over <= let_pass, "{levels:?}: {turned_over}");
            assert!(at.iter().all(|w| (w[0] + w[1] + w[2] - 1.0).abs() < 3e-7 && w.iter().all(|&x| x >= 0.0)));
        }
    }

    /// Different weights of the far end along an edge from its first corner, in order.
    fn edge(levels: &Levels, e: usize) -> Vec<[u32; 2]> {
        let (pattern, at) = placed(levels);
        let on = pattern.weights.iter().zip(at).filter(|(w, _)| w[(e + 2) % 3] == 0.0);
        let mut ends: Vec<[f32; 2]> = on.map(|(_, w)| [w[e], w[(e + 1) % 3]]).collect();
        ends.sort_by(|a, b| a[1].total_cmp(&b[1]));
        ends.dedup();
        ends.into_iter().map(|w| w.map(f32::to_bits)).collect()
    }

    #[test]
    fn both_sides_of_an_edge_have_the_same_vertices_whatever_is_beyond() {
        for l in [0.0, 0.3, 1.0, 1.7, 3.0, 4.4] {
            let sides = [[l, 0.0, 0.0], [l, 5.0, 0.2], [l, 2.0, 6.0]];
            let seen: Vec<_> = sides
                .iter()
                .map(|&edges| edge(&Levels { edges, inner: edges.into_iter().fold(0.0, f32::max), turned: 0 }, 0))
                .collect();
            assert!(seen.iter().all(|s| *s == seen[0]), "{l}");
            assert_eq!(seen[0].len(), (1 << l.ceil() as u32) + 1);
            // The neighbour runs the other way, and counts from its second corner.
            let other = edge(&Levels { edges: [1.0, 1.0, l], inner: l.max(1.0), turned: 4 }, 2);
            let back: Vec<[u32; 2]> = other.into_iter().rev().map(|[a, b]| [b, a]).collect();
            assert_eq!(back, seen[0], "{l}");
        }
    }

    #[test]
    fn nothing_jumps_where_a_level_becomes_whole() {
        // Corners of the triangles that are left, just above a whole level and on it.
        let shape = |levels: &Levels| {
            let (pattern, at) = placed(levels);
            let mut all: Vec<[[i32; 2]; 3]> = Vec::new();
            for t in pattern.indices.chunks(3) {
                let p = [0, 1, 2].map(|k| at[t[k] as usize].map(|x| (x * 1e3).round() as i32)).map(|w| [w[1], w[2]]);
                if p[0] != p[1] && p[1] != p[2] && p[2] != p[0] {
                    let least = (0..3).min_by_key(|&i| p[i]).unwrap();
                    all.push([p[least], p[(least + 1) % 3], p[(least + 2) % 3]]);
                }
            }
            all.sort();
            all
        };
        for (edges, e) in [([2.0, 2.0, 2.0], 3), ([2.0, 3.5, 1.2], 0), ([3.0, 2.2, 0.7], 0), ([1.0, 4.0, 4.0], 0)] {
            for turned in [0, 5] {
                let at = |extra: f32| {
                    let edges: [f32; 3] =
                        std::array::from_fn(|k| edges[k] + if k == e || e == 3 { extra } else { 0.0 });
                    Levels { edges, inner: edges.into_iter().fold(0.0, f32::max), turned }
                };
                assert_eq!(shape(&at(0.0)), shape(&at(1e-4)), "{edges:?} {e}");
            }
        }
    }
}
