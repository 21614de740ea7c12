//! T, the ternary step: input mesh to M^0 (ZHHK22 3.2, LKSD17).
//!
//! Every n-gon becomes n corner quads, n quads of the middle thirds and one smaller n-gon.
//! Edge points lie at one third. A face point is bilinear in its corner, the two edge MIDPOINTS and the
//! centroid: `(3 v0 + v1 + v2 + 4 C) / 9`; the text of ZHHK22 3.2 says neighbours, its formula's source does not.

use super::index_map::IndexMap;
use super::level::{vertex_bits, Level, Value};
use crate::mesh::{HalfEdgeMesh, NONE};
use crate::scene::{CornerRule, Handle};
use crate::threads;
use glam::{DVec2, DVec4};
use std::ops::Range;

/// Makes M^0, white all over, without any edit. Time linear in the input's corners.
///
/// `handles` and `face_points` replace edge and face points (by input half-edge); their numbers must be in range.
pub fn ternary(mesh: &HalfEdgeMesh, corners: CornerRule, handles: &[Handle], face_points: &[Handle]) -> Level {
    let map = IndexMap::new(mesh);
    let s = mesh.half_edges();
    let all = s + mesh.boundary_edges();
    let n = 9 * s as usize;

    let origin = threads::collect(n, |d| map.vertex(0, d as u64) as u32);
    let twin = threads::collect(n, |d| map.twin(0, d as u64).map_or(NONE, |t| t as u32));

    let (position, bits) = points(mesh, corners, handles, face_points);
    debug_assert_eq!(position.len() as u64, map.vertices(0));
    debug_assert_eq!(position.len() as u32, mesh.vertices() + all + s);
    Level {
        level: 0,
        face: (0..map.faces(0)).collect(),
        inside: vec![true; map.faces(0) as usize],
        quads: 2 * s,
        polygon_start: mesh.face_start.iter().map(|h| 8 * s + h).collect(),
        polygon_face: mesh.face.iter().map(|f| 2 * s + f).collect(),
        tint: origin.clone(),
        origin,
        twin,
        sharp: Vec::new(),
        value: threads::collect(position.len(), |v| Value { p: position[v], c: DVec4::ONE }),
        bits,
        child: Vec::new(),
    }
}

fn points(
    mesh: &HalfEdgeMesh,
    corners: CornerRule,
    handles: &[Handle],
    face_points: &[Handle],
) -> (Vec<DVec2>, Vec<u8>) {
    use vertex_bits::{BOUNDARY, CORNER, EXTRAORDINARY};
    let s = mesh.half_edges();
    let v = mesh.vertices() as usize;
    let at = |v: u32| mesh.positions[v as usize];
    let mut position = mesh.positions.clone();
    let mut bits = Vec::with_capacity(v + 2 * s as usize + mesh.boundary_edges() as usize);

    let (mut faces, mut boundary) = (vec![0u32; v], vec![false; v]);
    for h in 0..s {
        faces[mesh.origin[h as usize] as usize] += 1;
        if mesh.twin[h as usize] == NONE {
            boundary[mesh.origin[h as usize] as usize] = true;
            boundary[mesh.target(h) as usize] = true;
        }
    }
    for v in 0..v {
        bits.push(match (boundary[v], faces[v]) {
            (false, 4) => 0,
            (false, _) => EXTRAORDINARY,
            // A smooth corner is a boundary curve running through one face: no bicubic has that.
            (true, 1) if corners == CornerRule::Smooth => BOUNDARY | CORNER | EXTRAORDINARY,
            (true, 1) => BOUNDARY | CORNER,
            (true, 2) => BOUNDARY,
            (true, _) => BOUNDARY | EXTRAORDINARY,
        });
    }

    let third = |a: u32, b: u32| (2.0 * at(a) + at(b)) / 3.0;
    position.extend(threads::collect(s as usize, |h| third(mesh.origin[h], mesh.target(h as u32))));
    bits.extend(mesh.twin.iter().map(|&t| if t == NONE { BOUNDARY } else { 0 }));
    for rank in 0..mesh.boundary_edges() {
        let h = mesh.boundary_twin(rank);
        position.push(third(mesh.target(h), mesh.origin[h as usize]));
        bits.push(BOUNDARY);
    }
    let face_points_of = |faces: Range<usize>| {
        let mut points = Vec::with_capacity((mesh.face_start[faces.end] - mesh.face_start[faces.start]) as usize);
        for f in faces {
            let (a, b) = (mesh.face_start[f], mesh.face_start[f + 1]);
            let centre = (a..b).map(|h| at(mesh.origin[h as usize])).sum::<DVec2>() / f64::from(b - a);
            for h in a..b {
                let (v0, v1, v2) =
                    (at(mesh.origin[h as usize]), at(mesh.target(h)), at(mesh.origin[mesh.prev(h) as usize]));
                points.push((3.0 * v0 + v1 + v2 + 4.0 * centre) / 9.0);
            }
        }
        points
    };
    for points in threads::each(threads::pieces(mesh.faces() as usize), face_points_of) {
        position.extend_from_slice(&points);
    }
    bits.resize(position.len(), 0);
    let face_point = v + (s + mesh.boundary_edges()) as usize;
    for handle in handles {
        position[v + handle.half_edge as usize] = handle.at;
    }
    for handle in face_points {
        position[face_point + handle.half_edge as usize] = handle.at;
    }
    (position, bits)
}
