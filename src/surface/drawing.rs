//! What is drawn of a level: triangles with a normal a wedge, or the mesh itself.

use super::level::Level;
use super::patch_eval::point;
use super::patches::Patches;
use super::shade::Shaded;
use crate::camera::bounds;
use crate::mesh::NONE;
use crate::patch::solid::{Primitive, Segments, SolidTable};
use crate::threads;
use glam::DVec3;

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

/// The triangles that the tessellator makes of `patches`, but for how it joins a side's vertices to the inner ones: for
/// intersections on the CPU.
pub fn tessellated(patches: &Patches, segments: Segments) -> Vec<[DVec3; 3]> {
    let mut out = Vec::new();
    for patch in patches.iter() {
        let own = segments.at(patch.place.level);
        let finer = 2 * segments.at(patch.place.level + 1);
        let outer: [u32; 4] = std::array::from_fn(|i| if patch.sides >> i & 1 == 1 { finer } else { own });
        let n = if own == 1 && outer != [1; 4] { 2 } else { own };
        let at = |u: f64, v: f64| point(patch.form, &patch.control, u, v, 1.0).position;
        if patch.form.sides() == 3 {
            triangle(own, [outer[0], outer[1], outer[2]], &at, &mut out);
            continue;
        }
        if n == 1 {
            let [a, b, c, d] = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
            out.extend([[a, b, c], [a, c, d]]);
            continue;
        }
        let step = |i: u32| f64::from(i) / f64::from(n);
        let grid: Vec<DVec3> =
            (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))).map(|(i, j)| at(step(i), step(j))).collect();
        let p = |i: u32, j: u32| grid[(j * (n + 1) + i) as usize];
        for (j, i) in (1..n - 1).flat_map(|j| (1..n - 1).map(move |i| (j, i))) {
            out.push([p(i, j), p(i + 1, j), p(i + 1, j + 1)]);
            out.push([p(i, j), p(i + 1, j + 1), p(i, j + 1)]);
        }
        for (side, &outer) in outer.iter().enumerate() {
            // (t, s): along the side from its corner, and inwards.
            let from = |t: f64, s: f64| match side {
                0 => [t, s],
                1 => [1.0 - s, t],
                2 => [1.0 - t, 1.0 - s],
                _ => [s, 1.0 - t],
            };
            let point = |t: f64, s: f64| {
                let [u, v] = from(t, s);
                at(u, v)
            };
            // Both rows, and each step along the one that is behind.
            let (mut i, mut j) = (0, 1);
            let outside = |i: u32| point(f64::from(i) / f64::from(outer), 0.0);
            let inside = |j: u32| point(step(j), step(1));
            while i < outer || j < n - 1 {
                let outer_next = j == n - 1 || (i < outer && (i + 1) * n <= j * outer + outer / 2);
                if outer_next {
                    out.push([outside(i), outside(i + 1), inside(j)]);
                    i += 1;
                } else {
                    out.push([outside(i), inside(j + 1), inside(j)]);
                    j += 1;
                }
            }
        }
    }
    out
}

/// A tessellated triangle, ring by ring inwards: ring r is `2 r / 3 n` from the sides and has `n - 2 r` segments a side, the
/// outermost those of `outer`.
fn triangle(n: u32, outer: [u32; 3], at: &impl Fn(f64, f64) -> DVec3, out: &mut Vec<[DVec3; 3]>) {
    // The tessellator raises an inner level of 1 when an outer one is greater.
    let n = if outer == [1; 3] { n } else { n.max(2) };
    let ring = |r: u32, segments: u32, side: usize, k: u32| {
        let away = 2.0 * f64::from(r) / (3.0 * f64::from(n));
        let along = if segments == 0 { 0.0 } else { (1.0 - 3.0 * away) * f64::from(k) / f64::from(segments) };
        let far = 1.0 - 2.0 * away;
        match side {
            0 => at(away + along, away),
            1 => at(far - along, away + along),
            _ => at(away, far - along),
        }
    };
    let mut segments = outer;
    for r in 0.. {
        let left = n.saturating_sub(2 * r);
        if left == 1 {
            // One triangle is left; its sides have one segment each, unless it is the whole.
            out.push([ring(r, 1, 0, 0), ring(r, 1, 1, 0), ring(r, 1, 2, 0)]);
        }
        if left < 2 {
            return;
        }
        let m = left - 2;
        for (side, &segments) in segments.iter().enumerate() {
            // Each step along the row that is behind.
            let (mut i, mut j) = (0, 0);
            while i < segments || j < m {
                if j == m || (i < segments && (2 * i + 1) * left <= (2 * j + 3) * segments) {
                    out.push([ring(r, segments, side, i), ring(r, segments, side, i + 1), ring(r + 1, m, side, j)]);
                    i += 1;
                } else {
                    out.push([ring(r, segments, side, i), ring(r + 1, m, side, j + 1), ring(r + 1, m, side, j)]);
                    j += 1;
                }
            }
        }
        segments = [m; 3];
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timing::triangles;

    #[test]
    fn tessellated_triangles_cover_the_domain_once_and_are_as_many_as_the_formula_has() {
        for n in 1..=9 {
            for outer in [[n; 3], [2 * n, n, n], [n, 3, 2 * n], [2, 1, 1]] {
                let mut out = Vec::new();
                triangle(n, outer, &|u, v| DVec3::new(u, v, 0.0), &mut out);
                let [a, b, c] = outer.map(u64::from);
                assert_eq!(out.len() as u64, triangles::triangle([a, b, c], n.into()), "{n} {outer:?}");
                let areas: Vec<f64> = out.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a).z).collect();
                assert!(areas.iter().all(|&area| area > 1e-9), "{n} {outer:?}: {areas:?}");
                assert!((areas.iter().sum::<f64>() - 0.5).abs() < 1e-12, "{n} {outer:?}");
            }
        }
    }
}
