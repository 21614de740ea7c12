//! What is drawn of a level: triangles with a normal a wedge, or the mesh itself.

use super::level::Level;
use super::patch_eval::point;
use super::patches::Patches;
use super::shade::Shaded;
use crate::camera::bounds;
use crate::mesh::NONE;
use crate::patch::solid::{Primitive, Segments, SolidTable};
use crate::patch::tessellator::{self, Domain};
use crate::threads;
use glam::DVec3;
use std::collections::HashMap;

/// Indexed triangles of `level`: a vertex a wedge, so that vertices are repeated where they have several normals and
/// nowhere else (ZBK23 section 5). `positions` are one a vertex, `normals` one a wedge.
pub fn triangles(level: &Level, shaded: &Shaded, positions: &[DVec3], normals: &[DVec3]) -> SolidTable {
    threads::crew(positions.len(), || triangles_of(level, shaded, positions, normals))
}

fn triangles_of(level: &Level, shaded: &Shaded, positions: &[DVec3], normals: &[DVec3]) -> SolidTable {
    let mut table = SolidTable::new(bounds(positions.iter().copied()).unwrap_or_default());
    let centre = table.centre;
    table.vertices = threads::collect(normals.len(), |w| {
        let v = level.origin[shaded.wedges.first[w] as usize] as usize;
        SolidTable::packed(centre, positions[v], shaded.weight[v], normals[w])
    });
    let of = &shaded.wedges.of;
    table.indices = match level.sides {
        3 => of.clone(),
        4 => {
            let cut = |f: usize| match of[4 * f..4 * f + 4] {
                [a, b, c, d] => [a, b, c, a, c, d],
                _ => unreachable!("four"),
            };
            threads::collect(level.faces(), cut).into_flattened()
        }
        _ => {
            let fan = |f: usize| {
                let face = level.of_face(f);
                (face.start + 1..face.end - 1).flat_map(move |h| [face.start, h, h + 1].map(|h| of[h as usize]))
            };
            (0..level.faces()).flat_map(fan).collect()
        }
    };
    table.part(Primitive::Triangles);
    table
}

/// Patches within `bounds`, those of one kind and level together. Their control points are left to the device.
pub fn patches(patches: &Patches, bounds: [DVec3; 2]) -> SolidTable {
    let mut table = SolidTable::new(bounds);
    for &[x, y, z, b, nx, ny, nz, _] in &patches.sources {
        table.vertex(DVec3::new(x, y, z), b, DVec3::new(nx, ny, nz));
    }
    let mut stencils = patches.stencils.packed();
    for run in patches.bicubic.chunk_by(|a, b| a.1.level == b.1.level) {
        table.indices.extend(run.iter().flat_map(|(ids, _)| ids));
        table.part_of_level(Primitive::Bicubic, run[0].1.level);
    }
    // What tells the shader which sides have finer neighbours: a control point for each set of sides.
    let mut masks = [None; 16];
    let mut mask_of = |table: &mut SolidTable, sides: u8| {
        *masks[sides as usize].get_or_insert_with(|| {
            table.vertices.push([f32::from(sides), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            stencils.alone(table.vertices.len() as u32 - 1)
        })
    };
    for run in patches.transition.chunk_by(|a, b| a.place.level == b.place.level) {
        for t in run {
            let mask = mask_of(&mut table, t.sides);
            table.indices.extend(t.points.iter().chain(&t.halves).chain([&mask]));
        }
        table.part_of_level(Primitive::Transition, run[0].place.level);
    }
    for run in patches.gregory.chunk_by(|a, b| a.1.level == b.1.level) {
        table.indices.extend(run.iter().flat_map(|(ids, _)| ids));
        table.part_of_level(Primitive::Gregory, run[0].1.level);
    }
    for run in patches.quartic.chunk_by(|a, b| a.1.level == b.1.level) {
        table.indices.extend(run.iter().flat_map(|(ids, _)| ids));
        table.part_of_level(Primitive::Quartic, run[0].1.level);
    }
    for run in patches.quartic_transition.chunk_by(|a, b| a.place.level == b.place.level) {
        for t in run {
            let mask = mask_of(&mut table, t.sides);
            table.indices.extend(t.points.iter().chain(&t.halves).chain([&mask]));
        }
        table.part_of_level(Primitive::QuarticTransition, run[0].place.level);
    }
    for run in patches.quartic_gregory.chunk_by(|a, b| a.1.level == b.1.level) {
        table.indices.extend(run.iter().flat_map(|(ids, _)| ids));
        table.part_of_level(Primitive::QuarticGregory, run[0].1.level);
    }
    table.stencils = Some(stencils);
    table
}

/// The triangles that the tessellator makes of `patches`, corner by corner, counter-clockwise from the front.
pub fn tessellated(patches: &Patches, segments: Segments) -> Vec<[DVec3; 3]> {
    // Few kinds of domains: by corners, level and which sides have finer neighbours.
    let mut domains: HashMap<(usize, u32, u8), Domain> = HashMap::new();
    let mut out = Vec::new();
    for patch in patches.iter() {
        let (corners, level) = (patch.form.sides(), patch.place.level);
        let domain = domains.entry((corners, level, patch.sides)).or_insert_with(|| {
            let own = segments.at(level);
            let finer = 2 * segments.at(level + 1);
            let outer: [u32; 4] = std::array::from_fn(|i| if patch.sides >> i & 1 == 1 { finer } else { own });
            match corners {
                3 => tessellator::triangle([outer[0], outer[1], outer[2]], own),
                _ => tessellator::quad(outer, own),
            }
        });
        let points: Vec<DVec3> =
            domain.points.iter().map(|&[u, v]| point(patch.form, &patch.control, u, v, 1.0).position).collect();
        out.extend(domain.triangles.iter().map(|t| t.map(|i| points[i as usize])));
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
