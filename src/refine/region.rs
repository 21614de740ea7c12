//! Whole meshes M^0 to M^l, but only where somebody looks: what an editor needs of a level that adaptive refinement
//! leaves coarse.

use super::edits::{self, Edits};
use super::{Cursors, RefineError, MAX_FACES};
use crate::mesh::HalfEdgeMesh;
use crate::scene::Scene;
use crate::subdiv::edit;
use crate::subdiv::index_map::{IndexMap, Slot};
use crate::subdiv::level::Level;
use crate::subdiv::{catmull_clark, ternary};
use std::collections::HashSet;

/// Rings of faces that are refined around the ones asked for. An edit reaches three rings (ZHHK22 4.2), so what lies
/// within two rings of a face asked for has the positions and colours of the whole M^l.
const MARGIN: usize = 4;

/// Part of M^0, ..., M^l.
#[derive(Clone, Debug, Default)]
pub struct Region {
    /// M^0 to M^l after the edits of each level; each holds the wanted faces and some rings around them.
    pub levels: Vec<Level>,
    /// M^l before its own edits: the frames of its geometry edits read these positions.
    pub plain: Level,
    /// Local half-edge in M^l of each slot that was asked for, in the order given; `None`: it was not refined.
    pub followed: Vec<Option<u32>>,
}

impl Region {
    /// M^l with its edits.
    ///
    /// # Panics
    /// Never for a region that [`region`] made: it has at least M^0.
    pub fn last(&self) -> &Level {
        self.levels.last().expect("a region has M^0")
    }
}

/// The part of M^0 to M^`to` whose faces `wanted` accepts, level by level (`wanted` sees a level after its edits, and
/// a face of it), with what they need to be right. `follow` are slots of M^`to` whose local half-edges come back.
/// Costs what is wanted, and one ternary step.
///
/// # Errors
/// An edit that does not fit the mesh; a level too deep, or more than [`MAX_FACES`] faces in one.
pub fn region(
    scene: &Scene,
    mesh: &HalfEdgeMesh,
    to: u32,
    follow: &[Slot],
    mut wanted: impl FnMut(&Level, u32) -> bool,
) -> Result<Region, RefineError> {
    if to > edits::MAX_LEVEL {
        return Err(RefineError::TooDeep { level: to });
    }
    let map = IndexMap::new(mesh);
    let edits = edits::resolve(scene, &map)?;
    let names = edited_faces(&map, &edits, to);
    let mut cursors = Cursors::new(&edits);
    let mut level = ternary::ternary(mesh, scene.corners, &scene.handles, &scene.face_points);
    let mut followed: Vec<Option<u32>> = follow.iter().map(|d| u32::try_from(d >> (2 * to)).ok()).collect();
    let mut levels = Vec::new();
    loop {
        let now = level.level;
        let plain = (now == to).then(|| level.clone());
        cursors.apply(&mut level);
        if now == 0 {
            for &h in &scene.sharp {
                edit::tag_sharp(&mut level, h);
            }
        }
        if let Some(plain) = plain {
            levels.push(level);
            return Ok(Region { levels, plain, followed });
        }
        let core: Vec<bool> = (0..level.faces() as u32)
            .map(|f| {
                level.inside[f as usize] && (names[now as usize].contains(&level.face[f as usize]) || wanted(&level, f))
            })
            .collect();
        let asked = grow(&level, core);
        let next = catmull_clark::refine(&mut level, &asked, scene.corners);
        if next.faces() as u64 > MAX_FACES {
            return Err(RefineError::TooLarge { level: now + 1, faces: next.faces() as u64, limit: MAX_FACES });
        }
        cursors.descend(&level);
        for (place, slot) in followed.iter_mut().zip(follow) {
            *place = place.and_then(|h| {
                let child = level.child[h as usize];
                let digit = (slot >> (2 * (to - now - 1))) & 3;
                (child < crate::subdiv::level::CUT).then_some(4 * child + digit as u32)
            });
        }
        levels.push(level);
        level = next;
    }
}

/// For each level below `to`: names of the faces under which a geometry edit lies. Such an edit may have carried its
/// vertex far from the face.
fn edited_faces(map: &IndexMap, edits: &Edits, to: u32) -> Vec<HashSet<u64>> {
    let mut names = vec![HashSet::new(); to as usize];
    for m in &edits.moves {
        for l in 0..m.level.min(to) {
            let slot = m.vertex >> (2 * (m.level - l));
            names[l as usize].insert(map.face(l, slot));
        }
    }
    names
}

/// The faces given and [`MARGIN`] rings around them.
fn grow(level: &Level, mut faces: Vec<bool>) -> Vec<bool> {
    for _ in 0..MARGIN {
        let mut near = vec![false; level.vertices()];
        for f in (0..level.faces() as u32).filter(|&f| faces[f as usize]) {
            level.of_face(f).for_each(|h| near[level.origin[h as usize] as usize] = true);
        }
        for f in (0..level.faces() as u32).filter(|&f| level.inside[f as usize]) {
            faces[f as usize] |= level.of_face(f).any(|h| near[level.origin[h as usize] as usize]);
        }
    }
    faces
}
