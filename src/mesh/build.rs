//! From polygons to half-edges, naming every way in which they can fail to be a manifold.

use super::{HalfEdgeMesh, NONE};
use crate::scene::InputMesh;
use thiserror::Error;

/// Why polygons do not form a mesh. Face and vertex numbers in the text count from 1, as OBJ files do.
#[derive(Debug, Error, Clone, PartialEq, Eq)]
pub enum MeshError {
    /// No face at all.
    #[error("the mesh has no face; add at least one polygon")]
    Empty,
    /// A face of one or two corners.
    #[error("face {face} has {corners} corners; a face needs at least three")]
    TooFewCorners {
        /// Face, from 1.
        face: u32,
        /// Its corners.
        corners: u32,
    },
    /// A corner names a vertex that is not there.
    #[error("face {face} names vertex {vertex}, but there are {vertices}; correct the number")]
    NoSuchVertex {
        /// Face, from 1.
        face: u32,
        /// Vertex, from 1.
        vertex: u64,
        /// Vertices in the mesh.
        vertices: u32,
    },
    /// The same vertex twice in one face.
    #[error("face {face} uses vertex {vertex} twice; split the face or remove one of them")]
    RepeatedVertex {
        /// Face, from 1.
        face: u32,
        /// Vertex, from 1.
        vertex: u32,
    },
    /// A vertex in no face.
    #[error("vertex {vertex} belongs to no face; remove it or use it")]
    UnusedVertex {
        /// Vertex, from 1.
        vertex: u32,
    },
    /// Three or more faces at one edge.
    #[error("edge {a}-{b} belongs to {faces} faces (face {face} is one); an edge of a manifold has at most two")]
    NonManifoldEdge {
        /// One end, from 1.
        a: u32,
        /// Other end, from 1.
        b: u32,
        /// Faces at the edge.
        faces: u32,
        /// The last of them, from 1.
        face: u32,
    },
    /// Two faces run along an edge in the same direction.
    #[error("faces {face} and {other} both run from vertex {a} to {b}; reverse the corners of one of them")]
    Orientation {
        /// Later face, from 1.
        face: u32,
        /// Earlier face, from 1.
        other: u32,
        /// Origin, from 1.
        a: u32,
        /// Target, from 1.
        b: u32,
    },
    /// Faces that meet in a vertex without forming one fan.
    #[error("vertex {vertex} joins {fans} separate fans of faces (face {face} is in one); duplicate the vertex")]
    NonManifoldVertex {
        /// Vertex, from 1.
        vertex: u32,
        /// Fans around it.
        fans: u32,
        /// A face at it, from 1.
        face: u32,
    },
    /// More half-edges than 32-bit numbers leave room for.
    #[error("the mesh has {corners} face corners; at most {limit} are possible")]
    TooLarge {
        /// Sum of the face valences.
        corners: u64,
        /// The limit.
        limit: u64,
    },
}

/// Largest sum of face valences: level 0 has nine half-edges a corner, numbered in 32 bits.
pub const MAX_CORNERS: u64 = 100_000_000;

impl MeshError {
    /// The face (from 0) that the error is about, where there is one: callers turn it into a line.
    pub fn face(&self) -> Option<u32> {
        match *self {
            MeshError::TooFewCorners { face, .. }
            | MeshError::NoSuchVertex { face, .. }
            | MeshError::RepeatedVertex { face, .. }
            | MeshError::NonManifoldEdge { face, .. }
            | MeshError::Orientation { face, .. }
            | MeshError::NonManifoldVertex { face, .. } => Some(face - 1),
            MeshError::Empty | MeshError::UnusedVertex { .. } | MeshError::TooLarge { .. } => None,
        }
    }
}

/// Builds the half-edges of `input`; time linear in its corners.
///
/// # Errors
/// The first fault found, see [`MeshError`].
pub fn build(input: &InputMesh) -> Result<HalfEdgeMesh, MeshError> {
    let vertices = input.positions.len() as u32;
    let faces = input.face_start.len().saturating_sub(1);
    if faces == 0 {
        return Err(MeshError::Empty);
    }
    let corners = input.corners.len();
    if corners as u64 > MAX_CORNERS {
        return Err(MeshError::TooLarge { corners: corners as u64, limit: MAX_CORNERS });
    }
    check_faces(input, vertices)?;

    let mut origin = vec![0u32; corners];
    let mut face = vec![0u32; corners];
    for f in 0..faces {
        let (start, end) = (input.face_start[f] as usize, input.face_start[f + 1] as usize);
        for k in start..end {
            let before = if k == start { end - 1 } else { k - 1 };
            origin[k] = input.corners[before];
            face[k] = f as u32;
        }
    }
    let target = &input.corners;
    let twin = pair(&origin, target, &face, vertices)?;

    let mut boundary_before = Vec::with_capacity(corners + 1);
    let mut edges_before = Vec::with_capacity(corners + 1);
    let (mut boundary, mut edges) = (0, 0);
    for (h, &t) in twin.iter().enumerate() {
        boundary_before.push(boundary);
        edges_before.push(edges);
        boundary += u32::from(t == NONE);
        edges += u32::from(t == NONE || h < t as usize);
    }
    boundary_before.push(boundary);
    edges_before.push(edges);

    let mesh = HalfEdgeMesh {
        positions: input.positions.clone(),
        origin,
        twin,
        face,
        face_start: input.face_start.clone(),
        boundary_before,
        edges_before,
    };
    check_fans(&mesh)?;
    Ok(mesh)
}

fn check_faces(input: &InputMesh, vertices: u32) -> Result<(), MeshError> {
    let mut last_face = vec![0u32; vertices as usize];
    for (f, ends) in input.face_start.windows(2).enumerate() {
        let face = f as u32 + 1;
        if ends[1] - ends[0] < 3 {
            return Err(MeshError::TooFewCorners { face, corners: ends[1] - ends[0] });
        }
        for &v in &input.corners[ends[0] as usize..ends[1] as usize] {
            if v >= vertices {
                return Err(MeshError::NoSuchVertex { face, vertex: u64::from(v) + 1, vertices });
            }
            if last_face[v as usize] == face {
                return Err(MeshError::RepeatedVertex { face, vertex: v + 1 });
            }
            last_face[v as usize] = face;
        }
    }
    match last_face.iter().position(|&f| f == 0) {
        Some(v) => Err(MeshError::UnusedVertex { vertex: v as u32 + 1 }),
        None => Ok(()),
    }
}

/// Twins by a counting sort over the lesser end of each edge.
fn pair(origin: &[u32], target: &[u32], face: &[u32], vertices: u32) -> Result<Vec<u32>, MeshError> {
    let low = |h: usize| origin[h].min(target[h]);
    let high = |h: usize| origin[h].max(target[h]);
    let mut start = vec![0u32; vertices as usize + 1];
    for h in 0..origin.len() {
        start[low(h) as usize + 1] += 1;
    }
    for v in 0..vertices as usize {
        start[v + 1] += start[v];
    }
    let mut fill = start.clone();
    let mut sorted = vec![0u32; origin.len()];
    for h in 0..origin.len() {
        let slot = &mut fill[low(h) as usize];
        sorted[*slot as usize] = h as u32;
        *slot += 1;
    }
    let mut twin = vec![NONE; origin.len()];
    for v in 0..vertices as usize {
        let bucket = &mut sorted[start[v] as usize..start[v + 1] as usize];
        // A vertex of great valence would make pairwise search quadratic.
        bucket.sort_unstable_by_key(|&h| (high(h as usize), h));
        for edge in bucket.chunk_by(|&g, &h| high(g as usize) == high(h as usize)) {
            match *edge {
                [_] => {}
                [g, h] => {
                    let (g, h) = (g as usize, h as usize);
                    if origin[g] == origin[h] {
                        return Err(MeshError::Orientation {
                            face: face[h] + 1,
                            other: face[g] + 1,
                            a: origin[h] + 1,
                            b: target[h] + 1,
                        });
                    }
                    twin[g] = h as u32;
                    twin[h] = g as u32;
                }
                _ => {
                    let h = edge[edge.len() - 1] as usize;
                    return Err(MeshError::NonManifoldEdge {
                        a: low(h) + 1,
                        b: high(h) + 1,
                        faces: edge.len() as u32,
                        face: face[h] + 1,
                    });
                }
            }
        }
    }
    Ok(twin)
}

/// Every vertex must be the centre of exactly one fan (open or closed).
fn check_fans(mesh: &HalfEdgeMesh) -> Result<(), MeshError> {
    let mut fans = vec![0u32; mesh.positions.len()];
    let mut seen = vec![false; mesh.origin.len()];
    // Open fans start at the half-edge on the boundary; what is left afterwards is closed.
    for pass in 0..2 {
        for h in 0..mesh.half_edges() {
            if seen[h as usize] || (pass == 0 && mesh.twin[h as usize] != NONE) {
                continue;
            }
            fans[mesh.origin[h as usize] as usize] += 1;
            let mut spoke = h;
            loop {
                seen[spoke as usize] = true;
                spoke = mesh.twin[mesh.prev(spoke) as usize];
                if spoke == NONE || spoke == h {
                    break;
                }
            }
        }
    }
    for (v, &n) in fans.iter().enumerate() {
        if n > 1 {
            let h = mesh.origin.iter().position(|&o| o as usize == v).unwrap_or(0);
            return Err(MeshError::NonManifoldVertex { vertex: v as u32 + 1, fans: n, face: mesh.face[h] + 1 });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn mesh(vertices: usize, faces: &[&[u32]]) -> Result<HalfEdgeMesh, MeshError> {
        let mut input = InputMesh { positions: vec![DVec2::ZERO; vertices], face_start: vec![0], ..Default::default() };
        for f in faces {
            input.corners.extend(f.iter().map(|v| v - 1));
            input.face_start.push(input.corners.len() as u32);
        }
        build(&input)
    }

    #[test]
    fn two_quads_share_one_edge() {
        let m = mesh(6, &[&[1, 2, 3, 4], &[2, 5, 6, 3]]).unwrap();
        assert_eq!((m.half_edges(), m.boundary_edges()), (8, 6));
        assert_eq!(m.edges_before[8], 7);
        // Half-edge 2 of face 0 ends in vertex 3 and leaves vertex 2; its twin runs back in face 1.
        assert_eq!((m.origin[2], m.target(2)), (1, 2));
        assert_eq!(m.twin[2], 4);
        for rank in 0..6 {
            assert_eq!(m.twin_number(m.boundary_twin(rank)), 8 + rank);
        }
    }

    #[test]
    fn every_fault_has_its_name() {
        assert_eq!(mesh(0, &[]).unwrap_err(), MeshError::Empty);
        assert!(matches!(mesh(2, &[&[1, 2]]).unwrap_err(), MeshError::TooFewCorners { face: 1, corners: 2 }));
        assert!(matches!(mesh(3, &[&[1, 2, 4]]).unwrap_err(), MeshError::NoSuchVertex { vertex: 4, .. }));
        assert!(matches!(mesh(3, &[&[1, 2, 3, 2]]).unwrap_err(), MeshError::RepeatedVertex { vertex: 2, .. }));
        assert!(matches!(mesh(4, &[&[1, 2, 3]]).unwrap_err(), MeshError::UnusedVertex { vertex: 4 }));
        assert!(matches!(
            mesh(4, &[&[1, 2, 3], &[1, 2, 4]]).unwrap_err(),
            MeshError::Orientation { face: 2, other: 1, a: 1, b: 2 }
        ));
        assert!(matches!(
            mesh(5, &[&[1, 2, 3], &[2, 1, 4], &[1, 2, 5]]).unwrap_err(),
            MeshError::NonManifoldEdge { a: 1, b: 2, faces: 3, .. }
        ));
        assert!(matches!(
            mesh(5, &[&[1, 2, 3], &[1, 4, 5]]).unwrap_err(),
            MeshError::NonManifoldVertex { vertex: 1, fans: 2, .. }
        ));
    }
}
