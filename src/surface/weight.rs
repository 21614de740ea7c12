//! Blend weights b: control weights, their subdivision, and their limit (ZBK23 2.3, 3.1 to 3.3).

use super::level::{Level, Scheme};
use super::limit::{limit_value, own_limit_weight, shape, Shape};
use super::stencil::refine_values;
use crate::threads;
use std::collections::BTreeMap;

/// Which control weights are set at extraordinary vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Initial {
    /// 1 at the vertex and at all vertices of its faces (the paper's choice).
    #[default]
    Ring,
    /// What makes the limit 1: the inverse of the vertex's weight in its own limit.
    Inverse,
    /// 1 at the vertex alone.
    Vertex,
}

/// What sharp vertices get.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Variant {
    /// As smooth ones.
    A,
    /// 0, and they set no ring (recommended by the paper).
    #[default]
    B,
}

/// How darts count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Darts {
    /// As smooth vertices; an extraordinary one as extraordinary (recommended by the paper).
    #[default]
    Smooth,
    /// As sharp vertices.
    Sharp,
}

/// The choices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rules {
    /// Control weights.
    pub initial: Initial,
    /// Sharp vertices.
    pub variant: Variant,
    /// Darts.
    pub darts: Darts,
}

/// What a vertex is for the weights of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Role {
    /// Another number of edges than regular vertices have.
    pub extraordinary: bool,
    /// Sharp where the level is drawn: at least two borders meet, or a dart that counts as sharp.
    pub sharp: bool,
    /// On the boundary.
    pub boundary: bool,
}

/// The roles of all vertices.
pub fn roles(level: &Level, darts: Darts) -> Vec<Role> {
    let role = |v: usize| {
        let boundary = level.on_boundary(v as u32);
        let regular = match (level.scheme, boundary) {
            (Scheme::CatmullClark, false) => 4,
            (Scheme::Loop, false) => 6,
            // Faces, one fewer than edges.
            (Scheme::CatmullClark, true) => 2,
            (Scheme::Loop, true) => 3,
        };
        // At the edge of a part, where faces are left out, borders may be missing.
        let inner = level.border_edges[v].saturating_sub(if boundary { 2 } else { 0 });
        let sharp = level.corner_sharpness(v as u32) > 0.0
            || match (boundary, darts) {
                (true, _) => inner > 0,
                (false, Darts::Smooth) => inner > 1,
                (false, Darts::Sharp) => inner > 0,
            };
        Role { extraordinary: level.faces_at[v] != regular, sharp, boundary }
    };
    threads::collect(level.vertices(), role)
}

/// Sets the control weights of extraordinary vertices, and in variant B those of sharp ones, in `weight` (one a vertex).
/// At the start all else is 0; on later levels this makes vertices count whose crease has decayed (Fig. 4). With a ring,
/// vertices that were set before get what they have.
pub fn set(level: &Level, rules: Rules, roles: &[Role], fresh: impl Fn(usize) -> bool, weight: &mut [f64]) {
    for (v, &role) in roles.iter().enumerate() {
        let skip = rules.variant == Variant::B && role.sharp;
        if role.boundary && !skip {
            // The limit on a boundary weighs its vertex by 2/3.
            if fresh(v) {
                weight[v] = if role.extraordinary { 1.5 } else { 0.0 };
            }
            continue;
        }
        if !role.extraordinary || skip {
            continue;
        }
        match rules.initial {
            Initial::Vertex if fresh(v) => weight[v] = 1.0,
            Initial::Inverse if fresh(v) => {
                let n = level.fan(v as u32).count() as f64;
                weight[v] = 1.0 / own_limit_weight(level.scheme, n);
            }
            Initial::Vertex | Initial::Inverse => {}
            Initial::Ring => {
                weight[v] = 1.0;
                for h in level.fan(v as u32) {
                    let end = level.prev(h);
                    let mut g = level.next(h);
                    loop {
                        let u = level.origin[g as usize] as usize;
                        if !roles[u].boundary {
                            weight[u] = 1.0;
                        }
                        if g == end {
                            break;
                        }
                        g = level.next(g);
                    }
                }
            }
        }
    }
    if rules.variant == Variant::B {
        for (w, role) in weight.iter_mut().zip(roles) {
            if role.sharp {
                *w = 0.0;
            }
        }
    }
}

/// Control weights of the last of `levels`, first set at level `start`.
pub fn control_weights(levels: &[Level], start: usize, rules: Rules) -> Vec<f64> {
    let start = start.min(levels.len() - 1);
    let mut before = roles(&levels[start], rules.darts);
    let mut weight = vec![0.0; levels[start].vertices()];
    set(&levels[start], rules, &before, |_| true, &mut weight);
    for pair in levels[start..].windows(2) {
        weight = refine_values(&pair[0], &weight, None);
        let now = roles(&pair[1], rules.darts);
        // Set again where a sharp vertex has become smooth. A ring is set every time: n-gons become extraordinary
        // vertices at level 1, and a ring of ones reproduces itself.
        let fresh = |v: usize| before.get(v).is_some_and(|was| was.sharp && !now[v].sharp);
        set(&pair[1], rules, &now, fresh, &mut weight);
        before = now;
    }
    weight
}

/// Limits of `weight` (one a vertex), within [0, 1]. Borders count as sharp, so that a crease of zeros stays zero.
pub fn limit_weights(level: &Level, weight: &[f64]) -> Vec<f64> {
    let at = |h: u32| weight[level.origin[h as usize] as usize];
    let limit = |v: usize| {
        let h = level.spoke[v];
        let shape = match shape(level.border_edges[v], level.corner_sharpness(v as u32) > 0.0) {
            // The mask of quads does not hold at polygons.
            Shape::Smooth if level.scheme == Scheme::CatmullClark && level.sides != 4 => return weight[v].min(1.0),
            shape => shape,
        };
        // Where a fan begins inside a region, any region of a crease has the same two ends.
        limit_value(level, h, shape, |g| level.is_border(g), at).clamp(0.0, 1.0)
    };
    threads::collect(level.vertices(), limit)
}

/// Extraordinary vertices of `level` by number of edges and whether they are on the boundary.
pub fn extraordinary(level: &Level, darts: Darts) -> BTreeMap<(u32, bool), usize> {
    let mut counts = BTreeMap::new();
    for (v, role) in roles(level, darts).iter().enumerate() {
        if role.extraordinary {
            *counts.entry((level.valence(v as u32), role.boundary)).or_insert(0) += 1;
        }
    }
    counts
}

/// Vertices with a weight above 0 when blending starts at `level`, for the sake of all extraordinary vertices or of those
/// with so many edges, inside (`false`) or on the boundary (ZBK23 section 5).
pub fn needing(level: &Level, rules: Rules, only: Option<(u32, bool)>) -> usize {
    let mut roles = roles(level, rules.darts);
    if let Some((edges, boundary)) = only {
        for (v, role) in roles.iter_mut().enumerate() {
            role.extraordinary &= role.boundary == boundary && level.valence(v as u32) == edges;
        }
    }
    let mut weight = vec![0.0; level.vertices()];
    set(level, rules, &roles, |_| true, &mut weight);
    limit_weights(level, &weight).into_iter().filter(|&w| w > 0.0).count()
}
