//! One step of uniform subdivision: half-edges, sharpness, positions.
//!
//! Half-edge `h` has children `4 h` to `4 h + 3` under Catmull-Clark: the quad at its origin. Under Loop, corner `k` of
//! face `f` becomes face `4 f + k`, and the middle is `4 f + 3`. Under both, the children of edge `e` are `2 e` (at the
//! origin of its lower half-edge) and `2 e + 1`, and half-edge `h` makes the inner edge `2 E + h` (DV21).

use super::level::{Level, Scheme};
use super::stencil::{refine_values, Value};
use super::SurfaceError;
use crate::mesh::{HalfEdgeMesh, NONE};
use crate::scene::surface::SurfaceScene;
use glam::DVec3;

/// Most half-edges of a level.
pub const MAX_HALF_EDGES: u64 = 64_000_000;

/// Levels 0 to `depth` of a surface.
///
/// # Errors
/// As [`Level::new`], or the last level is too large.
pub fn levels(
    scene: &SurfaceScene,
    mesh: &HalfEdgeMesh,
    scheme: Scheme,
    depth: u32,
) -> Result<Vec<Level>, SurfaceError> {
    let half_edges = u64::from(mesh.half_edges()).saturating_mul(4u64.saturating_pow(depth));
    if half_edges > MAX_HALF_EDGES {
        return Err(SurfaceError::TooLarge { level: depth, limit: MAX_HALF_EDGES });
    }
    let mut levels = vec![Level::new(scene, mesh, scheme)?];
    for k in 0..depth as usize {
        levels.push(refine(&levels[k]));
    }
    Ok(levels)
}

/// The level after `level`.
pub fn refine(level: &Level) -> Level {
    refine_some(level, |_| Vec::new()).0
}

/// The level after `level`, with right positions at least where `wanted`, which is given the level without positions, says
/// so (one a vertex; empty: everywhere), and what it said.
pub fn refine_some(level: &Level, wanted: impl FnOnce(&Level) -> Vec<bool>) -> (Level, Vec<bool>) {
    let mut next = match level.scheme {
        Scheme::CatmullClark => quads(level),
        Scheme::Loop => triangles(level),
    };
    next.scheme = level.scheme;
    next.depth = level.depth + 1;
    let inner = next.half_edges() / 4;
    next.sharpness = Vec::with_capacity(2 * level.edges() + inner);
    next.border = Vec::with_capacity(2 * level.edges() + inner);
    for &s in &level.sharpness {
        next.sharpness.extend([(s - 1.0).max(0.0); 2]);
        next.border.extend([s > 0.0; 2]);
    }
    next.sharpness.resize(2 * level.edges() + inner, 0.0);
    next.border.resize(2 * level.edges() + inner, false);
    let faces = if level.scheme == Scheme::CatmullClark { level.faces() } else { 0 };
    next.position = vec![DVec3::ZERO; level.vertices() + faces + level.edges()];
    let wanted = wanted(&next);
    next.position = refine_values(
        level,
        None,
        |h| level.position[level.origin[h as usize] as usize],
        |v| wanted.get(v).copied().unwrap_or(true),
    );
    if level.corner.iter().any(|&s| s > 1.0) {
        next.corner = level.corner.iter().map(|&s| (s - 1.0).max(0.0)).collect();
        next.corner.resize(next.vertices(), 0.0);
    }
    next.make_spokes();
    next.count_sharp_edges();
    (next, wanted)
}

/// Whether `h` is the lower half-edge of its edge, where the edge's numbers begin.
pub(super) fn is_lower(level: &Level, h: u32) -> bool {
    let t = level.twin[h as usize];
    t == NONE || h < t
}

/// The child edge of the edge of `h` at the origin of `h` (0) or at its end (1).
fn half(level: &Level, h: u32, end: u32) -> u32 {
    2 * level.edge[h as usize] + (end ^ u32::from(!is_lower(level, h)))
}

fn quads(level: &Level) -> Level {
    let n = level.half_edges();
    let (old, faces) = (level.vertices() as u32, level.faces() as u32);
    let edge_point = |h: u32| old + faces + level.edge[h as usize];
    let mut next = Level { sides: 4, ..Level::default() };
    next.origin.reserve(4 * n);
    next.twin.reserve(4 * n);
    next.edge.reserve(4 * n);
    let inner = 2 * level.edges() as u32;
    for h in 0..n as u32 {
        let (p, t) = (level.prev(h), level.twin[h as usize]);
        next.origin.extend([level.origin[h as usize], edge_point(h), old + level.face_of(h) as u32, edge_point(p)]);
        let across = |t: u32, f: fn(&Level, u32) -> u32| if t == NONE { NONE } else { f(level, t) };
        next.twin.extend([
            across(t, |level, t| 4 * level.next(t) + 3),
            4 * level.next(h) + 2,
            4 * p + 1,
            across(level.twin[p as usize], |_, t| 4 * t),
        ]);
        next.edge.extend([half(level, h, 0), inner + h, inner + p, half(level, p, 1)]);
    }
    next
}

fn triangles(level: &Level) -> Level {
    let n = level.half_edges();
    let old = level.vertices() as u32;
    let edge_point = |h: u32| old + level.edge[h as usize];
    let mut next = Level { sides: 3, ..Level::default() };
    next.origin.reserve(4 * n);
    next.twin.reserve(4 * n);
    next.edge.reserve(4 * n);
    let inner = 2 * level.edges() as u32;
    // Where corner triangle `h` begins.
    let corner = |h: u32| 3 * (4 * (h / 3) + h % 3);
    for f in 0..level.faces() as u32 {
        let middle = 3 * (4 * f + 3);
        for k in 0..3 {
            let h = 3 * f + k;
            let p = level.prev(h);
            next.origin.extend([level.origin[h as usize], edge_point(h), edge_point(p)]);
            let (t, u) = (level.twin[h as usize], level.twin[p as usize]);
            next.twin.extend([
                if t == NONE { NONE } else { corner(level.next(t)) + 2 },
                middle + (k + 2) % 3,
                if u == NONE { NONE } else { corner(u) },
            ]);
            next.edge.extend([half(level, h, 0), inner + h, half(level, p, 1)]);
        }
        // From edge point k to edge point k + 1 past corner k + 1.
        for k in 0..3 {
            let h = 3 * f + (k + 1) % 3;
            next.origin.push(edge_point(3 * f + k));
            next.twin.push(corner(h) + 1);
            next.edge.push(inner + h);
        }
    }
    next
}

/// Half-edge of the next level that has the corner (origin and face) of `h` inside.
pub fn child_corner(level: &Level, h: u32) -> u32 {
    match level.scheme {
        Scheme::CatmullClark => 4 * h,
        Scheme::Loop => 3 * child_face(level, h),
    }
}

/// Face of the next level that has the corner of `h`.
pub fn child_face(level: &Level, h: u32) -> u32 {
    match level.scheme {
        Scheme::CatmullClark => h,
        Scheme::Loop => 4 * (h / 3) + h % 3,
    }
}

/// One value a vertex, refined to the next level.
pub fn refine_vertex_values<T: Value>(level: &Level, of: &[T]) -> Vec<T> {
    refine_values(level, None, |h| of[level.origin[h as usize] as usize], |_| true)
}
