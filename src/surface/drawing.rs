//! What is drawn of a level: triangles with a normal a wedge, or the mesh itself.

use super::level::Level;
use super::patch_eval::point;
use super::patches::Patches;
use super::shade::Shaded;
use crate::camera::bounds;
use crate::mesh::NONE;
use crate::patch::solid::{Primitive, SolidTable};
use glam::DVec3;

/// Indexed triangles of `level`: a vertex a wedge, so that vertices are repeated where they have several normals and
/// nowhere else (ZBK23 section 5). `positions` are one a vertex, `normals` one a wedge.
pub fn triangles(level: &Level, shaded: &Shaded, positions: &[DVec3], normals: &[DVec3]) -> SolidTable {
    let mut table = SolidTable::new(bounds(positions.iter().copied()).unwrap_or_default());
    for (&first, &normal) in shaded.wedges.first.iter().zip(normals) {
        let v = level.origin[first as usize] as usize;
        table.vertex(positions[v], shaded.weight[v], normal);
    }
    for f in 0..level.faces() {
        let face = level.of_face(f);
        let wedge = |h: u32| shaded.wedges.of[h as usize];
        for h in face.start + 1..face.end - 1 {
            table.indices.extend([wedge(face.start), wedge(h), wedge(h + 1)]);
        }
    }
    table.part(Primitive::Triangles);
    table
}

/// Patches within `bounds`, those of one kind together.
pub fn patches(patches: &Patches, bounds: [DVec3; 2]) -> SolidTable {
    let mut table = SolidTable::new(bounds);
    for &[x, y, z, b, nx, ny, nz, _] in &patches.control {
        table.vertex(DVec3::new(x, y, z), b, DVec3::new(nx, ny, nz));
    }
    table.indices.extend(patches.bicubic.iter().flat_map(|(ids, _)| ids));
    table.part(Primitive::Bicubic);
    table.indices.extend(patches.gregory.iter().flat_map(|(ids, _)| ids));
    table.part(Primitive::Gregory);
    table
}

/// The triangles that the tessellator makes of `patches` with `n` segments an edge, for intersections on the CPU.
pub fn tessellated(patches: &Patches, n: u32) -> Vec<[DVec3; 3]> {
    let mut out = Vec::new();
    for (kind, control, _) in patches.iter() {
        let at = |i: u32, j: u32| point(kind, &control, f64::from(i) / f64::from(n), f64::from(j) / f64::from(n), 1.0);
        let grid: Vec<DVec3> =
            (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))).map(|(i, j)| at(i, j).position).collect();
        let p = |i: u32, j: u32| grid[(j * (n + 1) + i) as usize];
        for j in 0..n {
            for i in 0..n {
                out.push([p(i, j), p(i + 1, j), p(i + 1, j + 1)]);
                out.push([p(i, j), p(i + 1, j + 1), p(i, j + 1)]);
            }
        }
    }
    out
}

/// Colour of an edge: grey when smooth, blue on the boundary, from orange (just sharp) to red (3 and more), dark red when
/// sharp for ever.
pub fn edge_colour(sharpness: f64, boundary: bool) -> DVec3 {
    match sharpness {
        _ if boundary => DVec3::new(0.1, 0.25, 0.8),
        s if s <= 0.0 => DVec3::splat(0.25),
        s if s.is_infinite() => DVec3::new(0.5, 0.0, 0.05),
        s => DVec3::new(1.0, 0.6, 0.1).lerp(DVec3::new(0.95, 0.1, 0.1), (s / 3.0).min(1.0)),
    }
}

/// The edges of `level` over its faces, in plain colours.
pub fn mesh(level: &Level, positions: &[DVec3]) -> SolidTable {
    let mut table = SolidTable::new(bounds(positions.iter().copied()).unwrap_or_default());
    let p = |h: u32| positions[level.origin[h as usize] as usize];
    for f in 0..level.faces() {
        let face = level.of_face(f);
        let corner = |h: u32| (p(level.next(h)) - p(h)).cross(p(level.prev(h)) - p(h));
        let normal = face.clone().map(corner).sum::<DVec3>().normalize_or_zero();
        let light = 0.82 + 0.1 * normal.dot(DVec3::new(0.4, 0.8, 0.45));
        let first = table.vertices.len() as u32;
        let n = face.end - face.start;
        for h in face {
            table.vertex(p(h), 0.0, DVec3::splat(light));
        }
        table.indices.extend((1..n - 1).flat_map(|k| [first, first + k, first + k + 1]));
    }
    table.part(Primitive::Triangles);
    for h in 0..level.half_edges() as u32 {
        let t = level.twin[h as usize];
        if t == NONE || h < t {
            let colour = edge_colour(level.sharpness[level.edge[h as usize] as usize], t == NONE);
            let ends = [p(h), p(level.next(h))].map(|q| table.vertex(q, 0.0, colour));
            table.indices.extend(ends);
        }
    }
    table.part(Primitive::Lines);
    table
}
