//! Polygons as half-edges.
//!
//! Interior half-edges are numbered face by face in file order; the k-th half-edge of a face ENDS in the
//! face's k-th vertex, so its origin is the vertex before (the authors' convention, kept because edits name
//! half-edges). A half-edge on the boundary has no twin; where a boundary half-edge itself needs a number, it
//! is `interior + rank`, the rank being that of its interior twin among all boundary edges (ZHHK22 App. A:
//! boundary half-edges have the greatest indices).

mod build;
mod shape;

pub use build::{build, MeshError};
pub use shape::{shape_notes, ShapeNote};

use glam::DVec2;

/// "No half-edge": the twin of an interior half-edge on the boundary.
pub const NONE: u32 = u32::MAX;

/// A manifold polygon mesh, any orientation, with or without boundary, any number of components.
#[derive(Clone, Debug, Default)]
pub struct HalfEdgeMesh {
    /// One position a vertex.
    pub positions: Vec<DVec2>,
    /// Vertex that each interior half-edge leaves.
    pub origin: Vec<u32>,
    /// Opposite half-edge, or [`NONE`] on the boundary.
    pub twin: Vec<u32>,
    /// Face of each interior half-edge.
    pub face: Vec<u32>,
    /// Face `f` has half-edges `face_start[f]..face_start[f + 1]`; `faces + 1` entries.
    pub face_start: Vec<u32>,
    /// For half-edge h: how many half-edges before h are on the boundary; `half_edges + 1` entries.
    pub boundary_before: Vec<u32>,
    /// For half-edge h: how many half-edges before h come before their twin (boundary ones do); the rank
    /// of h's edge where h itself is such a one. `half_edges + 1` entries.
    pub edges_before: Vec<u32>,
}

impl HalfEdgeMesh {
    /// Interior half-edges: the sum of the face valences, S.
    pub fn half_edges(&self) -> u32 {
        self.origin.len() as u32
    }

    /// Faces.
    pub fn faces(&self) -> u32 {
        self.face_start.len() as u32 - 1
    }

    /// Vertices.
    pub fn vertices(&self) -> u32 {
        self.positions.len() as u32
    }

    /// Boundary edges.
    pub fn boundary_edges(&self) -> u32 {
        *self.boundary_before.last().unwrap_or(&0)
    }

    /// Half-edge after `h` in its face.
    pub fn next(&self, h: u32) -> u32 {
        let f = self.face[h as usize] as usize;
        if h + 1 == self.face_start[f + 1] {
            self.face_start[f]
        } else {
            h + 1
        }
    }

    /// Half-edge before `h` in its face.
    pub fn prev(&self, h: u32) -> u32 {
        let f = self.face[h as usize] as usize;
        if h == self.face_start[f] {
            self.face_start[f + 1] - 1
        } else {
            h - 1
        }
    }

    /// Vertex that `h` ends in.
    pub fn target(&self, h: u32) -> u32 {
        self.origin[self.next(h) as usize]
    }

    /// Half-edges (and corners) of face `f`.
    pub fn valence(&self, f: u32) -> u32 {
        self.face_start[f as usize + 1] - self.face_start[f as usize]
    }

    /// Number of the half-edge opposite `h`, boundary half-edges included (`half_edges() + rank`).
    pub fn twin_number(&self, h: u32) -> u32 {
        match self.twin[h as usize] {
            NONE => self.half_edges() + self.boundary_before[h as usize],
            t => t,
        }
    }

    /// The interior half-edge whose boundary twin has this rank.
    ///
    /// # Panics
    /// If `rank >= boundary_edges()`.
    pub fn boundary_twin(&self, rank: u32) -> u32 {
        // First index with `boundary_before > rank`, less one: that half-edge raised the count.
        self.boundary_before.partition_point(|&n| n <= rank) as u32 - 1
    }
}
