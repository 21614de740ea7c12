//! One step of uniform subdivision: half-edges, sharpness, positions.
//!
//! Half-edge `h` has children `4 h` to `4 h + 3` under Catmull-Clark: the quad at its origin. Under Loop, corner `k` of
//! face `f` becomes face `4 f + k`, and the middle is `4 f + 3`. Under both, the children of edge `e` are `2 e` (at the
//! origin of its lower half-edge) and `2 e + 1`, and half-edge `h` makes the inner edge `2 E + h` (DV21).

use super::level::{Level, Scheme};
use super::stencil::refine_values;
use super::SurfaceError;
use crate::mesh::{HalfEdgeMesh, NONE};
use crate::scene::surface::SurfaceScene;
use crate::threads;
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
    threads::crew(half_edges as usize, || (0..depth as usize).for_each(|k| levels.push(refine(&levels[k]))));
    Ok(levels)
}

/// The level after `level`.
pub fn refine(level: &Level) -> Level {
    threads::crew(level.half_edges(), || {
        let mut next = connect(level);
        next.position = refine_values(level, &level.position, None);
        next
    })
}

/// The level after `level`, with right positions at least where `wanted`, which is given the level without positions, says
/// so (one a vertex), and what it said.
pub fn refine_some(level: &Level, wanted: impl FnOnce(&Level) -> Vec<bool>) -> (Level, Vec<bool>) {
    let mut next = connect(level);
    next.position = vec![DVec3::ZERO; next.spoke.len()];
    let wanted = wanted(&next);
    next.position = refine_values(level, &level.position, Some(&wanted));
    (next, wanted)
}

/// The level after `level` but for positions.
fn connect(level: &Level) -> Level {
    let lower = level.lower();
    let mut next = match level.scheme {
        Scheme::CatmullClark => quads(level),
        Scheme::Loop => triangles(level),
    };
    next.scheme = level.scheme;
    next.depth = level.depth + 1;
    let (edges, inner) = (level.edges(), next.half_edges() / 4);
    next.sharpness = vec![0.0; 2 * edges + inner];
    next.border = vec![false; 2 * edges + inner];
    for (e, &s) in level.sharpness.iter().enumerate().filter(|(_, &s)| s > 0.0) {
        next.sharpness[2 * e..2 * e + 2].fill((s - 1.0).max(0.0));
        next.border[2 * e..2 * e + 2].fill(true);
    }
    around_vertices(level, &lower, &mut next);
    if level.corner.iter().any(|&s| s > 1.0) {
        next.corner = level.corner.iter().map(|&s| (s - 1.0).max(0.0)).collect();
        next.corner.resize(next.spoke.len(), 0.0);
    }
    next
}

/// Spokes and counts at the vertices of the next level, by those of this.
fn around_vertices(level: &Level, lower: &[u32], next: &mut Level) {
    let old = level.vertices();
    let faces = if level.scheme == Scheme::CatmullClark { level.faces() } else { 0 };
    let n = old + faces + level.edges();
    // The lowest half-edge, or the one on the boundary, keeps being it.
    next.spoke = Vec::with_capacity(n);
    next.spoke.extend(level.spoke.iter().map(|&h| child_corner(level, h)));
    next.spoke.extend((0..faces).map(|f| 4 * level.of_face(f).start + 2));
    threads::append(&mut next.spoke, lower.len(), |e| {
        let h = lower[e];
        let t = level.twin[h as usize];
        let side = |h: u32| match level.scheme {
            Scheme::CatmullClark => [4 * h + 1, 4 * level.next(h) + 3],
            Scheme::Loop => [child_corner(level, h) + 1, child_corner(level, level.next(h)) + 2],
        };
        let [a, b] = side(h);
        if t == NONE {
            return b;
        }
        let [c, d] = side(t);
        let all = a.min(b).min(c).min(d);
        match level.scheme {
            Scheme::CatmullClark => all,
            Scheme::Loop => all.min(middle_corner(h)).min(middle_corner(t)),
        }
    });

    next.faces_at = Vec::with_capacity(n);
    next.faces_at.extend_from_slice(&level.faces_at);
    next.faces_at.extend((0..faces).map(|f| level.of_face(f).len().min(255) as u8));
    let whole = if level.scheme == Scheme::CatmullClark { 4 } else { 6 };
    next.faces_at.extend(lower.iter().map(|&h| if level.twin[h as usize] == NONE { whole / 2 } else { whole }));

    next.border_edges = Vec::with_capacity(n);
    next.border_edges.extend_from_slice(&level.sharp_edges);
    next.border_edges.resize(n, 0);
    next.sharp_edges = vec![0; n];
    for (e, &s) in level.sharpness.iter().enumerate().filter(|(_, &s)| s > 0.0) {
        next.border_edges[old + faces + e] = 2;
        if s > 1.0 {
            next.sharp_edges[old + faces + e] = 2;
            for v in [level.origin[lower[e] as usize], level.target(lower[e])] {
                let count = &mut next.sharp_edges[v as usize];
                *count = count.saturating_add(1);
            }
        }
    }
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
    let inner = 2 * level.edges() as u32;
    let across = |t: u32, child: fn(&Level, u32) -> u32| if t == NONE { NONE } else { child(level, t) };
    let origin = |h: usize| {
        let h = h as u32;
        [level.origin[h as usize], edge_point(h), old + level.face_of(h) as u32, edge_point(level.prev(h))]
    };
    let twin = |h: usize| {
        let (p, t) = (level.prev(h as u32), level.twin[h]);
        [
            across(t, |level, t| 4 * level.next(t) + 3),
            4 * level.next(h as u32) + 2,
            4 * p + 1,
            across(level.twin[p as usize], |_, t| 4 * t),
        ]
    };
    let edge = |h: usize| {
        let (h, p) = (h as u32, level.prev(h as u32));
        [half(level, h, 0), inner + h, inner + p, half(level, p, 1)]
    };
    Level {
        sides: 4,
        origin: threads::collect(n, origin).into_flattened(),
        twin: threads::collect(n, twin).into_flattened(),
        edge: threads::collect(n, edge).into_flattened(),
        ..Level::default()
    }
}

fn triangles(level: &Level) -> Level {
    let n = level.faces();
    let old = level.vertices() as u32;
    let edge_point = |h: u32| old + level.edge[h as usize];
    let inner = 2 * level.edges() as u32;
    let corner = |h: u32| child_corner(level, h);
    // Three corner triangles and the middle: from edge point k to edge point k + 1 past corner k + 1.
    let origin = |f: usize| {
        let h = [0, 1, 2].map(|k| 3 * f as u32 + k);
        let [a, b, c] = h.map(edge_point);
        let [u, v, w] = h.map(|h| level.origin[h as usize]);
        [u, a, c, v, b, a, w, c, b, a, b, c]
    };
    let twin = |f: usize| {
        let h = [0, 1, 2].map(|k| 3 * f as u32 + k);
        let middle = 12 * f as u32 + 9;
        let t = h.map(|h| level.twin[h as usize]);
        let leaving = t.map(|t| if t == NONE { NONE } else { corner(level.next(t)) + 2 });
        let coming = t.map(|t| if t == NONE { NONE } else { corner(t) });
        let [a, b, c] = [leaving[0], middle + 2, coming[2]];
        let [d, e, g] = [leaving[1], middle, coming[0]];
        let [i, j, k] = [leaving[2], middle + 1, coming[1]];
        [a, b, c, d, e, g, i, j, k, corner(h[1]) + 1, corner(h[2]) + 1, corner(h[0]) + 1]
    };
    let edge = |f: usize| {
        let h = [0, 1, 2].map(|k| 3 * f as u32 + k);
        let first = h.map(|h| half(level, h, 0));
        let second = h.map(|h| half(level, h, 1));
        let cut = h.map(|h| inner + h);
        let [a, b, c] = [[first[0], cut[0], second[2]], [first[1], cut[1], second[0]], [first[2], cut[2], second[1]]];
        [a, b, c, [cut[1], cut[2], cut[0]]]
    };
    Level {
        sides: 3,
        origin: threads::collect(n, origin).into_flattened(),
        twin: threads::collect(n, twin).into_flattened(),
        edge: threads::collect(n, edge).into_flattened().into_flattened(),
        ..Level::default()
    }
}

/// The half-edge of the middle triangle that leaves the edge point of `h`.
fn middle_corner(h: u32) -> u32 {
    3 * (4 * (h / 3) + 3) + h % 3
}

/// What of a level makes a vertex of the next, on the side of one of its half-edges.
pub(super) enum Parent {
    /// The origin of a half-edge.
    Vertex(u32),
    /// A face.
    Face(usize),
    /// The edge of a half-edge.
    Edge(u32),
}

/// What of `level` makes the origin of the next level's half-edge `c`, in the face that `c` lies in.
#[inline]
pub(super) fn parent(level: &Level, c: u32) -> Parent {
    match level.scheme {
        Scheme::CatmullClark => match (c & 3, c >> 2) {
            (0, h) => Parent::Vertex(h),
            (1, h) => Parent::Edge(h),
            (2, h) => Parent::Face(level.face_of(h)),
            (_, h) => Parent::Edge(level.prev(h)),
        },
        Scheme::Loop => {
            let (triangle, k) = (c / 3, c % 3);
            let first = 3 * (triangle / 4);
            match (triangle % 4, k) {
                (3, k) => Parent::Edge(first + k),
                (corner, 0) => Parent::Vertex(first + corner),
                (corner, 1) => Parent::Edge(first + corner),
                (corner, _) => Parent::Edge(level.prev(first + corner)),
            }
        }
    }
}

/// Half-edge of the next level that has the corner (origin and face) of `h` inside.
#[inline]
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
