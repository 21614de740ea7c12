//! How many half-edges each level has, and which input half-edges are twins (ZHHK22 App. A numbering).
//!
//! An edit names a half-edge of M^level. Its range follows from two numbers of the input mesh alone, so a reader can
//! refuse a wrong edit without building any mesh.

use super::{ColourEdit, Frame, GeometryEdit, InputMesh};

/// Finest level an edit may name. Level 20 of a single quad has 4e13 faces, far past any use and still inside `u64`.
pub const FINEST_LEVEL: u32 = 20;

/// Numbers of half-edges of one level: interior ones come first, boundary ones follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HalfEdges {
    /// Half-edges that belong to a face.
    pub interior: u64,
    /// Half-edges along the boundary, outside every face.
    pub boundary: u64,
}

impl HalfEdges {
    /// Half-edges of the input mesh itself: `interior` is the sum of the face valences, `boundary` counts those
    /// without a twin.
    pub fn of_input(mesh: &InputMesh) -> HalfEdges {
        let boundary = twins(mesh).iter().filter(|twin| twin.is_none()).count() as u64;
        HalfEdges { interior: mesh.corners.len() as u64, boundary }
    }

    /// Half-edges of M^level. `self` counts those of the input mesh. The ternary step makes 9 of an interior one and
    /// 3 of a boundary one, each Catmull-Clark step 4 and 2.
    pub fn at_level(self, level: u32) -> HalfEdges {
        HalfEdges {
            interior: self.interior.saturating_mul(9).saturating_mul(4u64.saturating_pow(level)),
            boundary: self.boundary.saturating_mul(3).saturating_mul(2u64.saturating_pow(level)),
        }
    }

    /// Why `edit` cannot belong to a mesh whose input has `self` half-edges, as (what, fix); `None` when it can.
    pub fn refuse_geometry(self, edit: &GeometryEdit) -> Option<(String, String)> {
        let level = self.at_level(edit.level);
        let (end, kind) = match edit.frame {
            Frame::Sector => (level.interior.saturating_add(level.boundary), "half-edges"),
            Frame::Boundary => (level.interior, "half-edges inside faces"),
        };
        refuse(edit.level, edit.half_edge, end, kind)
    }

    /// The same for a colour edit, whose half-edge must lie in a face.
    pub fn refuse_colour(self, edit: &ColourEdit) -> Option<(String, String)> {
        refuse(edit.level, edit.half_edge, self.at_level(edit.level).interior, "half-edges inside faces")
    }
}

fn refuse(level: u32, half_edge: u64, end: u64, kind: &str) -> Option<(String, String)> {
    (half_edge >= end).then(|| {
        (
            format!("half-edge {half_edge} does not exist at level {level}"),
            format!("level {level} of this mesh has {end} {kind}, 0 to {}", end.saturating_sub(1)),
        )
    })
}

/// For each half-edge of the input mesh (face by face, in file order) the origin and target vertex.
pub fn ends(mesh: &InputMesh) -> Vec<(u32, u32)> {
    let mut ends = Vec::with_capacity(mesh.corners.len());
    for face in mesh.face_start.windows(2) {
        let corners = &mesh.corners[face[0] as usize..face[1] as usize];
        for (k, &target) in corners.iter().enumerate() {
            ends.push((corners[(k + corners.len() - 1) % corners.len()], target));
        }
    }
    ends
}

/// For each half-edge of the input mesh the half-edge that runs the other way along the same edge, if any. In a
/// mesh that is no manifold (found out in `crate::mesh`) the first one counts.
pub fn twins(mesh: &InputMesh) -> Vec<Option<u32>> {
    let ends = ends(mesh);
    let mut by_ends: Vec<(u32, u32, u32)> = ends.iter().enumerate().map(|(h, &(a, b))| (a, b, h as u32)).collect();
    by_ends.sort_unstable();
    ends.iter()
        .map(|&(a, b)| {
            let first = by_ends.partition_point(|&(x, y, _)| (x, y) < (b, a));
            by_ends.get(first).filter(|&&(x, y, _)| (x, y) == (b, a)).map(|&(_, _, h)| h)
        })
        .collect()
}

/// For each half-edge of the input mesh the next one around its face.
pub fn nexts(mesh: &InputMesh) -> Vec<u32> {
    let mut nexts = Vec::with_capacity(mesh.corners.len());
    for face in mesh.face_start.windows(2) {
        nexts.extend((face[0]..face[1]).map(|h| if h + 1 == face[1] { face[0] } else { h + 1 }));
    }
    nexts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes;

    #[test]
    fn two_quads_share_one_edge() {
        let mesh = shapes::builtin("strip:2").unwrap();
        let counts = HalfEdges::of_input(&mesh);
        assert_eq!(counts, HalfEdges { interior: 8, boundary: 6 });
        assert_eq!(counts.at_level(0), HalfEdges { interior: 72, boundary: 18 });
        assert_eq!(counts.at_level(3), HalfEdges { interior: 72 * 64, boundary: 18 * 8 });
    }

    #[test]
    fn twin_of_twin_is_itself() {
        let mesh = shapes::builtin("fan:5").unwrap();
        let (twins, ends, nexts) = (twins(&mesh), ends(&mesh), nexts(&mesh));
        for h in 0..twins.len() {
            assert_eq!(ends[h].1, ends[nexts[h] as usize].0);
            if let Some(t) = twins[h] {
                assert_eq!(twins[t as usize], Some(h as u32));
                assert_eq!(ends[t as usize], (ends[h].1, ends[h].0));
            }
        }
        assert_eq!(twins.iter().filter(|t| t.is_some()).count(), 10);
    }

    #[test]
    fn boundary_half_edge_only_in_a_sector_frame() {
        let counts = HalfEdges { interior: 4, boundary: 4 };
        let mut edit = GeometryEdit { level: 0, half_edge: 40, vertex: None, a: 0.1, b: 0.1, frame: Frame::Sector };
        assert_eq!(counts.refuse_geometry(&edit), None);
        edit.frame = Frame::Boundary;
        assert!(counts.refuse_geometry(&edit).unwrap().1.contains("0 to 35"));
        edit.frame = Frame::Sector;
        edit.half_edge = 48;
        assert!(counts.refuse_geometry(&edit).is_some());
    }
}
