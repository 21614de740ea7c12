//! Normals of the control mesh and of levels, and the subdivided normals N_S.

use super::level::{Level, Scheme};
use super::limit::{limit_normal, shape};
use super::region::Wedges;
use super::stencil::{refine_values, refine_wedge_values};
use crate::threads;
use glam::DVec3;
use std::sync::OnceLock;

/// Where the normals come from that subdivision starts with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ControlNormals {
    /// The file's (`vn`), where it has any and subdivision starts from the control mesh; else the faces'.
    #[default]
    Given,
    /// The mean of the faces' normals in each region.
    Faces,
}

/// Unit normal of face `f`: of the sum of its corners' cross products; zero where it has no area.
fn face_normal(level: &Level, f: usize) -> DVec3 {
    let p = |h: u32| level.position[level.origin[h as usize] as usize];
    let corner = |h: u32| (p(level.next(h)) - p(h)).cross(p(level.prev(h)) - p(h));
    level.of_face(f).map(corner).sum::<DVec3>().normalize_or_zero()
}

/// Unit normals of wedges: the mean of the faces' unit normals in the region, weighted by the area of the
/// parallelogram at the corner as in the authors' tool. ("The average of the face normals", 3.4.)
pub fn mesh_normals(level: &Level, wedges: &Wedges) -> Vec<DVec3> {
    let p = |h: u32| level.position[level.origin[h as usize] as usize];
    let mut sum = vec![DVec3::ZERO; wedges.len()];
    for f in 0..level.faces() {
        let normal = face_normal(level, f);
        for h in level.of_face(f) {
            let area = (p(level.next(h)) - p(h)).cross(p(level.prev(h)) - p(h)).length();
            sum[wedges.of[h as usize] as usize] += normal * area;
        }
    }
    for n in &mut sum {
        *n = n.normalize_or_zero();
    }
    sum
}

/// Unit normals of the limit surface at wedges, N_L, with the drawn borders as edges that stay sharp. `finer` is the level
/// after `level` and is used at level 0 of Catmull-Clark, where faces may be polygons.
pub fn limit_normals(level: &Level, wedges: &Wedges, finer: Option<&Level>) -> Vec<DVec3> {
    let on = finer.unwrap_or(level);
    let fallback = OnceLock::new();
    let normal = |w: usize| {
        let first = wedges.first[w];
        let h = match finer {
            Some(_) => super::refine::child_corner(level, first),
            None => first,
        };
        let v = on.origin[h as usize];
        let corner = level.corner_sharpness(v) > 0.0;
        let normal = limit_normal(on, h, shape(on.border_edges[v as usize], corner), |g| on.is_border(g));
        // Folded or degenerate faces: whatever the mesh says.
        if normal == DVec3::ZERO {
            fallback.get_or_init(|| mesh_normals(level, wedges))[w]
        } else {
            normal
        }
    };
    threads::collect(wedges.len(), normal)
}

/// Control normals at the wedges of level 0: the mean of the normals `given` at the corners (one a half-edge, at its
/// *end*; zero: none) in each region, and `otherwise` where there is none.
pub fn given_normals(level: &Level, wedges: &Wedges, given: &[DVec3], otherwise: Vec<DVec3>) -> Vec<DVec3> {
    let mut sum = vec![DVec3::ZERO; wedges.len()];
    for (h, n) in given.iter().enumerate() {
        sum[wedges.of[level.next(h as u32) as usize] as usize] += n.normalize_or_zero();
    }
    sum.iter().zip(otherwise).map(|(n, other)| n.try_normalize().unwrap_or(other)).collect()
}

/// Normals at the regions that the next step keeps apart: where a crease has decayed, the mean of the regions' normals.
pub fn merged(drawn: &Wedges, live: &Wedges, normals: &[DVec3]) -> Vec<DVec3> {
    if drawn.len() == live.len() {
        // The same regions, perhaps begun at another: renumbered.
        let mut out = vec![DVec3::ZERO; live.len()];
        for (&d, &l) in drawn.of.iter().zip(&live.of) {
            out[l as usize] = normals[d as usize];
        }
        return out;
    }
    let mut into = vec![0u32; drawn.len()];
    for (&d, &l) in drawn.of.iter().zip(&live.of) {
        into[d as usize] = l;
    }
    let mut sum = vec![DVec3::ZERO; live.len()];
    let mut parts = vec![0u32; live.len()];
    let mut last = vec![DVec3::ZERO; live.len()];
    for (&l, &n) in into.iter().zip(normals) {
        sum[l as usize] += n;
        parts[l as usize] += 1;
        last[l as usize] = n;
    }
    // Opposite normals cancel; then any of them is as good.
    let mean = |((s, &n), &last): ((&DVec3, &u32), &DVec3)| if n == 1 { *s } else { s.try_normalize().unwrap_or(last) };
    sum.iter().zip(&parts).zip(&last).map(mean).collect()
}

/// N_S of the level after `level`, one a wedge of `next`, from `normals`, one a wedge of `drawn`; no wedges: one a vertex.
/// Linear stencils, normalised in every step (ZBK23 2.3). Only `wanted` vertices of the next level are computed; the others
/// are zero.
pub fn refine_normals(
    level: &Level,
    drawn: Option<&Wedges>,
    normals: &[DVec3],
    next: Option<&Wedges>,
    wanted: Option<&[bool]>,
) -> Vec<DVec3> {
    // Regions that the step keeps apart are regions of both levels.
    let live = drawn.map(|_| Wedges::live(level));
    let merged = drawn.zip(live.as_ref()).map(|(drawn, live)| merged(drawn, live, normals));
    let at = merged.as_deref().unwrap_or(normals);
    let out = match (next, &live) {
        (None, _) => refine_values(level, at, wanted),
        (Some(next), None) => refine_wedge_values(level, next, |h| at[level.origin[h as usize] as usize], wanted),
        (Some(next), Some(live)) => refine_wedge_values(level, next, |h| at[live.of[h as usize] as usize], wanted),
    };
    threads::collect(out.len(), |w| out[w].normalize_or_zero())
}

/// The vertices of `level` that the `wanted` ones of the next level need.
pub fn needed(level: &Level, wanted: &[bool]) -> Vec<bool> {
    let (old, quads) = (level.vertices(), level.scheme == Scheme::CatmullClark);
    let faces = if quads { level.faces() } else { 0 };
    let mut whole = vec![false; level.faces()];
    let mut need = vec![false; old];
    for (f, whole) in whole.iter_mut().enumerate().take(faces) {
        *whole = wanted[old + f];
    }
    for h in 0..level.half_edges() as u32 {
        // Under both schemes, stencils are unions of faces around the vertex or edge.
        let edge = old + faces + level.edge[h as usize] as usize;
        if wanted[edge] || wanted[level.origin[h as usize] as usize] {
            whole[level.face_of(h)] = true;
        }
    }
    for (f, whole) in whole.into_iter().enumerate() {
        if whole {
            for h in level.of_face(f) {
                need[level.origin[h as usize] as usize] = true;
            }
        }
    }
    need
}
