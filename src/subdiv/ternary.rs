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

/// Makes M^0, white all over, without any edit. Time linear in the input's corners.
///
/// `handles` and `face_points` replace edge and face points (by input half-edge); their numbers must be in range.
pub fn ternary(mesh: &HalfEdgeMesh, corners: CornerRule, handles: &[Handle], face_points: &[Handle]) -> Level {
    let map = IndexMap::new(mesh);
    let s = mesh.half_edges();
    let slots = 9 * s as usize;

    // The slots of a corner's two quads, then those of the shrunk faces.
    let rows = |of: &(dyn Fn(u32) -> [u32; 8] + Sync), shrunk: &(dyn Fn(u32) -> u32 + Sync)| {
        let mut rows = Vec::with_capacity(slots.div_ceil(8));
        threads::append(&mut rows, s as usize, |h| of(h as u32));
        let mut all = rows.into_flattened();
        threads::append(&mut all, s as usize, |h| shrunk(h as u32));
        all
    };
    let face_point = mesh.vertices() + s + mesh.boundary_edges();
    let origin = rows(&|h| origins(mesh, h), &|h| face_point + h);
    let twin = rows(&|h| twins(mesh, h), &|h| 8 * h + 6);
    debug_assert!((0..slots as u64).all(|d| u64::from(origin[d as usize]) == map.vertex(0, d)));
    debug_assert!((0..slots as u64).all(|d| map.twin(0, d).map_or(NONE, |t| t as u32) == twin[d as usize]));

    let value = points(mesh, handles, face_points);
    debug_assert_eq!(value.len() as u64, map.vertices(0));
    let faces = map.faces(0) as usize;
    Level {
        level: 0,
        face: threads::collect(faces, |f| f as u64),
        inside: vec![true; faces],
        quads: 2 * s,
        polygon_start: threads::collect(mesh.face_start.len(), |f| 8 * s + mesh.face_start[f]),
        polygon_face: threads::collect(s as usize, |h| 2 * s + mesh.face[h]),
        tint: threads::collect(slots, |d| origin[d]),
        origin,
        twin,
        sharp: Vec::new(),
        bits: bits(mesh, corners, value.len()),
        value,
        child: Vec::new(),
    }
}

/// Vertices that the slots `8 h` to `8 h + 7` leave ([`IndexMap::vertex`]).
fn origins(mesh: &HalfEdgeMesh, h: u32) -> [u32; 8] {
    let v = mesh.vertices();
    let face_point = v + mesh.half_edges() + mesh.boundary_edges();
    let (own, next) = (face_point + h, face_point + mesh.next(h));
    let [back, twin] = [mesh.prev(h), h].map(|e| v + mesh.twin_number(e));
    [mesh.origin[h as usize], v + h, own, back, v + h, twin, next, own]
}

/// Their twins ([`IndexMap::twin`]).
fn twins(mesh: &HalfEdgeMesh, h: u32) -> [u32; 8] {
    let (next, prev) = (mesh.next(h), mesh.prev(h));
    let across = |h: u32, of: fn(&HalfEdgeMesh, u32) -> u32| match mesh.twin[h as usize] {
        NONE => NONE,
        t => of(mesh, t),
    };
    [
        across(h, |mesh, t| 8 * mesh.next(t) + 3),
        8 * h + 7,
        8 * prev + 5,
        across(prev, |_, t| 8 * t),
        across(h, |_, t| 8 * t + 4),
        8 * next + 2,
        8 * mesh.half_edges() + h,
        8 * h + 1,
    ]
}

/// Input vertices, edge points, those of boundary half-edges, face points; all white.
fn points(mesh: &HalfEdgeMesh, handles: &[Handle], face_points: &[Handle]) -> Vec<Value> {
    let (v, s) = (mesh.vertices() as usize, mesh.half_edges() as usize);
    let face_point = v + s + mesh.boundary_edges() as usize;
    let at = |v: u32| mesh.positions[v as usize];
    let third = |a: u32, b: u32| (2.0 * at(a) + at(b)) / 3.0;
    let centre = threads::collect(mesh.faces() as usize, |f| {
        let (a, b) = (mesh.face_start[f], mesh.face_start[f + 1]);
        (a..b).map(|h| at(mesh.origin[h as usize])).sum::<DVec2>() / f64::from(b - a)
    });
    let mut value = Vec::with_capacity(face_point + s);
    let white = |p: DVec2| Value { p, c: DVec4::ONE };
    threads::append(&mut value, v, |v| white(mesh.positions[v]));
    threads::append(&mut value, s, |h| white(third(mesh.origin[h], mesh.target(h as u32))));
    value.extend((0..mesh.boundary_edges()).map(|rank| {
        let h = mesh.boundary_twin(rank);
        white(third(mesh.target(h), mesh.origin[h as usize]))
    }));
    threads::append(&mut value, s, |h| {
        let [v0, v1, v2] = [h as u32, mesh.next(h as u32), mesh.prev(h as u32)].map(|h| at(mesh.origin[h as usize]));
        white((3.0 * v0 + v1 + v2 + 4.0 * centre[mesh.face[h] as usize]) / 9.0)
    });
    for (handles, first) in [(handles, v), (face_points, face_point)] {
        handles.iter().for_each(|handle| value[first + handle.half_edge as usize].p = handle.at);
    }
    value
}

/// [`vertex_bits`] of all `points`.
fn bits(mesh: &HalfEdgeMesh, corners: CornerRule, points: usize) -> Vec<u8> {
    use vertex_bits::{BOUNDARY, CORNER, EXTRAORDINARY};
    // Faces around each vertex, doubled, and whether it lies on the boundary.
    let mut around = vec![0u32; mesh.vertices() as usize];
    for h in 0..mesh.half_edges() {
        around[mesh.origin[h as usize] as usize] += 2;
        if mesh.twin[h as usize] == NONE {
            around[mesh.origin[h as usize] as usize] |= 1;
            around[mesh.target(h) as usize] |= 1;
        }
    }
    let mut bits = Vec::with_capacity(points);
    bits.extend(around.into_iter().map(|around| match (around & 1 == 1, around >> 1) {
        (false, 4) => 0,
        (false, _) => EXTRAORDINARY,
        // A smooth corner is a boundary curve running through one face: no bicubic has that.
        (true, 1) if corners == CornerRule::Smooth => BOUNDARY | CORNER | EXTRAORDINARY,
        (true, 1) => BOUNDARY | CORNER,
        (true, 2) => BOUNDARY,
        (true, _) => BOUNDARY | EXTRAORDINARY,
    }));
    bits.extend(mesh.twin.iter().map(|&t| if t == NONE { BOUNDARY } else { 0 }));
    bits.resize(bits.len() + mesh.boundary_edges() as usize, BOUNDARY);
    bits.resize(points, 0);
    bits
}
