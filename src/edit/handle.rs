//! What can be taken hold of (ZHHK22 5.1).

use crate::mesh::{HalfEdgeMesh, NONE};
use crate::subdiv::index_map::{IndexMap, Slot};
use serde::{Deserialize, Serialize};

/// Which mesh is edited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Stage {
    /// The input mesh M with its gradient handles and face points: absolute positions.
    #[default]
    Input,
    /// M^l: hierarchical edits in local frames.
    Level(u32),
}

impl Stage {
    /// Level of the mesh whose vertices the handles are: M^0 holds those of the input mesh.
    pub fn level(self) -> u32 {
        match self {
            Stage::Input => 0,
            Stage::Level(l) => l,
        }
    }
}

/// What a handle moves or colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Kind {
    /// A control vertex of M^l, by a local edit.
    Vertex,
    /// A vertex of the input mesh, with the gradient handles and face points that hang on it.
    Input,
    /// A gradient handle: the edge point of T at one third of an input edge.
    Gradient,
    /// A face point of T.
    FacePoint,
    /// The colour of a colour vertex, in all its sectors.
    Colour,
    /// The colour of one sector of a colour vertex.
    Sector,
}

impl Kind {
    /// Whether it is dragged (true) or painted.
    pub fn is_geometry(self) -> bool {
        !matches!(self, Kind::Colour | Kind::Sector)
    }
}

/// Names a handle whatever is built of the scene at the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Id {
    /// What it is.
    pub kind: Kind,
    /// Level of the mesh that has its vertex.
    pub level: u32,
    /// Slot that leaves the vertex: the least one, or for [`Kind::Sector`] the sector's own.
    pub slot: Slot,
}

/// The least slot that leaves the vertex of `slot`.
pub fn least_slot(map: &IndexMap, level: u32, slot: Slot) -> Slot {
    let mut least = slot;
    map.around(level, slot, |s| least = least.min(s));
    least
}

/// What a vertex of M^0 is to the ternary step, by a slot that leaves it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A vertex of the input mesh.
    Vertex(u32),
    /// The edge point of an input half-edge; boundary ones are numbered after the interior ones.
    EdgePoint(u32),
    /// The face point of an input half-edge.
    FacePoint(u32),
}

/// What the vertex of M^0 that `slot` leaves came from.
pub fn origin_of(mesh: &HalfEdgeMesh, slot: Slot) -> Origin {
    let s = u64::from(mesh.half_edges());
    if slot >= 8 * s {
        return Origin::FacePoint((slot - 8 * s) as u32);
    }
    let h = (slot >> 3) as u32;
    match slot & 7 {
        0 => Origin::Vertex(mesh.origin[h as usize]),
        1 | 4 => Origin::EdgePoint(h),
        2 | 7 => Origin::FacePoint(h),
        3 => Origin::EdgePoint(mesh.twin_number(mesh.prev(h))),
        5 => Origin::EdgePoint(mesh.twin_number(h)),
        _ => Origin::FacePoint(mesh.next(h)),
    }
}

/// A slot of M^0 that leaves the edge point of input half-edge `h`, boundary ones included.
pub fn edge_point_slot(mesh: &HalfEdgeMesh, h: u32) -> Slot {
    if h < mesh.half_edges() {
        return 8 * u64::from(h) + 4;
    }
    8 * u64::from(mesh.boundary_twin(h - mesh.half_edges())) + 5
}

/// Input half-edges around the origin of `h`, in the order of their numbers.
pub fn input_spokes(mesh: &HalfEdgeMesh, vertex: u32) -> Vec<u32> {
    (0..mesh.half_edges()).filter(|&h| mesh.origin[h as usize] == vertex).collect()
}

/// Numbers of the edge points that lie at one third from input vertex `v`: those of the half-edges that leave it,
/// a boundary half-edge among them.
pub fn edge_points_of(mesh: &HalfEdgeMesh, v: u32) -> Vec<u32> {
    let mut points = input_spokes(mesh, v);
    for h in 0..mesh.half_edges() {
        if mesh.twin[h as usize] == NONE && mesh.target(h) == v {
            points.push(mesh.twin_number(h));
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes::builtin;

    #[test]
    fn origins_agree_with_the_vertex_numbers_of_the_index_map() {
        for name in ["triangle", "fan:5", "ring:4", "grid:2x2"] {
            let mesh = crate::mesh::build(&builtin(name).unwrap()).unwrap();
            let map = IndexMap::new(&mesh);
            let v = u64::from(mesh.vertices());
            let all = u64::from(mesh.half_edges() + mesh.boundary_edges());
            for slot in 0..map.half_edges(0) {
                let number = match origin_of(&mesh, slot) {
                    Origin::Vertex(i) => u64::from(i),
                    Origin::EdgePoint(h) => v + u64::from(h),
                    Origin::FacePoint(h) => v + all + u64::from(h),
                };
                assert_eq!(number, map.vertex(0, slot), "{name} slot {slot}");
            }
            for h in 0..all as u32 {
                assert_eq!(origin_of(&mesh, edge_point_slot(&mesh, h)), Origin::EdgePoint(h), "{name}");
            }
        }
    }
}
