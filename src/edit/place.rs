//! Where things are: limit points of any vertex of any level, exactly, with all finer edits (ZHHK22 App. B).

use crate::mesh::HalfEdgeMesh;
use crate::refine::region::region;
use crate::refine::{fate, RefineError, Refinement};
use crate::scene::{CornerRule, Scene};
use crate::subdiv::fan::{position_fan, Fan};
use crate::subdiv::index_map::{IndexMap, Slot};
use crate::subdiv::level::Level;
use crate::subdiv::limit::limit;
use glam::DVec2;

/// Deepest level that has an edit.
pub fn deepest_edit(scene: &Scene) -> u32 {
    scene.geometry.iter().map(|e| e.level).max().unwrap_or(0)
}

/// Limit position of the vertex that slot `slot` of M^`level` leaves, with all edits of all levels. What the
/// surface has there (`gradtess sample --exact`).
///
/// # Errors
/// An edit that does not fit the mesh.
pub fn exact_limit(scene: &Scene, mesh: &HalfEdgeMesh, level: u32, slot: Slot) -> Result<DVec2, RefineError> {
    let to = level.max(deepest_edit(scene));
    let map = IndexMap::new(mesh);
    let deep = slot << (2 * (to - level));
    let around: Vec<Vec<u64>> = (0..to)
        .map(|l| {
            let mut faces = Vec::new();
            if l >= level {
                map.around(l, slot << (2 * (l - level)), |d| faces.push(map.face(l, d)));
            } else {
                map.around(level, slot, |d| faces.push(map.face(l, d >> (2 * (level - l)))));
            }
            faces
        })
        .collect();
    let made = region(scene, mesh, to, &[deep], |l, f| around[l.level as usize].contains(&l.face[f as usize]))?;
    let h = made.followed[0].expect("the faces around the vertex are refined");
    Ok(limit_in(made.last(), h, scene.corners))
}

/// Limit position of the vertex that local half-edge `h` leaves.
pub fn limit_in(level: &Level, h: u32, corners: CornerRule) -> DVec2 {
    let mut fan = Fan::default();
    position_fan(level, h, &mut fan);
    limit(&fan, corners)
}

/// Where the vertex of `slot` of M^`level` stands in an adaptive refinement that goes finer there: the deepest level
/// that has its faces, and a half-edge that leaves it. `None`: nothing finer than `level` there.
pub fn finest(refinement: &Refinement, level: u32, slot: Slot) -> Option<(usize, u32)> {
    let mut l = level as usize;
    let at = refinement.levels.get(l)?;
    let mut h = match level {
        0 => slot as u32,
        _ => 4 * refinement.find(level, slot >> 2)? + (slot & 3) as u32,
    };
    if refinement.fates[l][at.face_of(h) as usize] & fate::AFFECTED == 0 {
        return None;
    }
    while refinement.fates[l][refinement.levels[l].face_of(h) as usize] & fate::AFFECTED != 0 {
        h = 4 * refinement.levels[l].child[h as usize];
        l += 1;
    }
    Some((l, h))
}
