//! Points of the surface by their place in M^0, whatever refines or draws them: so that two refinements of one scene
//! can be compared point by point.

use super::exact::{from_child, into_child, quarter};
use crate::patch::PatchTable;
use crate::refine::{fate, Refinement};
use crate::subdiv::level::CUT;
use std::collections::HashMap;

/// A point of M^0: over a quad, or over the quad at one corner of a face that is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BasePoint {
    /// Face of M^0.
    pub face: u32,
    /// Corner, when the face is no quad.
    pub corner: Option<u32>,
    /// Where, each in [0, 1].
    pub uv: [f64; 2],
}

/// A point of a face that is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnPoint {
    /// Level of the face.
    pub level: u32,
    /// Its number among the faces of the level.
    pub face: u32,
    /// Where in the face's own domain, whose first edge is that of its first half-edge.
    pub uv: [f64; 2],
}

/// From (u, v) of a face of level `level`, which goes by `name` there, to M^0.
pub fn to_base(refinement: &Refinement, level: u32, name: u64, uv: [f64; 2]) -> BasePoint {
    let zero = &refinement.levels[0];
    let ([mut u, mut v], mut name) = (uv, name);
    for l in (1..=level).rev() {
        // The name is the slot one level up: the corner in its last two bits, except at level 0.
        if l == 1 {
            let h = name as u32;
            let face = zero.face_of(h);
            let corner = h - zero.first(face);
            if zero.valence(face) != 4 {
                return BasePoint { face, corner: Some(corner), uv: [u, v] };
            }
            [u, v] = from_child(corner, u, v);
            return BasePoint { face, corner: None, uv: [u, v] };
        }
        [u, v] = from_child((name & 3) as u32, u, v);
        name >>= 2;
    }
    BasePoint { face: name as u32, corner: None, uv }
}

/// The drawn face that holds a point of M^0.
///
/// # Panics
/// When the refinement has not made what it draws, which does not happen.
pub fn locate(refinement: &Refinement, at: BasePoint) -> DrawnPoint {
    let ([mut u, mut v], mut face, mut level) = (at.uv, at.face, 0usize);
    let mut child = at.corner;
    while refinement.fates[level][face as usize] & fate::AFFECTED != 0 {
        let s = child.take().unwrap_or_else(|| {
            let s = quarter(u, v);
            [u, v] = into_child(s, u, v);
            s
        });
        let h = refinement.levels[level].first(face) + s;
        face = refinement.levels[level].child[h as usize];
        assert!(face < CUT, "a refined face has children");
        level += 1;
    }
    DrawnPoint { level: level as u32, face, uv: [u, v] }
}

/// From a face's own domain to that of its patch, which starts `turn` edges on.
pub fn turned(turn: u8, [u, v]: [f64; 2]) -> [f64; 2] {
    match turn {
        0 => [u, v],
        1 => [v, 1.0 - u],
        2 => [1.0 - u, 1.0 - v],
        _ => [1.0 - v, u],
    }
}

/// Numbers in [`PatchTable::faces`] by level and name.
pub struct Drawn(HashMap<(u32, u64), usize>);

impl Drawn {
    /// Of all faces of a table.
    pub fn new(table: &PatchTable) -> Drawn {
        Drawn(table.faces.iter().enumerate().map(|(i, f)| ((f.level, f.name), i)).collect())
    }

    /// The drawn face at a point of a refinement; `None` where a face of a global mesh has no patch.
    pub fn at(&self, refinement: &Refinement, point: DrawnPoint) -> Option<usize> {
        let name = refinement.levels[point.level as usize].face[point.face as usize];
        self.0.get(&(point.level, name)).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refine::{refine, Options};
    use crate::scene::Scene;

    #[test]
    fn every_drawn_face_is_found_again_from_its_place_in_the_base() {
        for scene in [
            &include_bytes!("../../scenes/unit/geometry_level_2.json")[..],
            include_bytes!("../../scenes/pentagon.json"),
            include_bytes!("../../scenes/unit/mixed_polygons.json"),
        ] {
            let scene = Scene::parse(scene, "test").unwrap();
            let mesh = crate::mesh::build(&scene.mesh).unwrap();
            let r = refine(&scene, &mesh, Options::default()).unwrap();
            let mut deep = 0;
            for (l, (level, fates)) in r.levels.iter().zip(&r.fates).enumerate() {
                for f in (0..level.faces() as u32).filter(|&f| fates[f as usize] & fate::DRAWN != 0) {
                    let uv = [0.25, 0.625];
                    let base = to_base(&r, l as u32, level.face[f as usize], uv);
                    assert_eq!(locate(&r, base), DrawnPoint { level: l as u32, face: f, uv });
                    deep = deep.max(l);
                }
            }
            assert!(deep > 0);
        }
    }
}
