//! Cracks in pictures of surfaces in space.
//!
//! Every pixel shows nothing, a front or a back. One that differs from two opposite neighbours that agree is suspicious;
//! it is a crack when rays through and around its middle, intersected with the surface on the CPU, all see something
//! else. Thin gaps of the model itself are therefore none, and neither is a back seen through an opening. On a contour a
//! front and a back are as near as each other, and rasterisation, which moves corners by up to 1/256 of a pixel, may take
//! either.

use crate::camera::{Camera, Projection};
use crate::gpu::{Gpu, GpuError, Pixels, SolidFrame, SolidShow, Tessellation};
use crate::patch::solid::{Primitive, SolidTable};
use crate::timing::random::Random;
use glam::DVec3;

/// What was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cracks {
    /// Views looked at.
    pub views: u32,
    /// Pixels that showed the surface, all views.
    pub covered: u64,
    /// Suspicious pixels.
    pub suspicious: u64,
    /// Cracks.
    pub cracks: u64,
    /// View and pixel of the first crack.
    pub first: Option<(u32, [u32; 2])>,
}

/// What a pixel or a ray sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Seen {
    Nothing,
    Front,
    Back,
}

/// Looks at `table` from `views` random sides, some of them near, `size` pixels across and down. `triangles` stand for
/// the surface on the CPU: three corners each, model units. `tessellation` is for patches.
///
/// # Errors
/// Drawing failed.
pub fn look_around(
    gpu: &Gpu,
    table: &SolidTable,
    triangles: &[[DVec3; 3]],
    tessellation: Tessellation,
    [views, size]: [u32; 2],
    seed: u64,
) -> Result<Cracks, GpuError> {
    let mut random = Random::new(seed);
    let mut unit = move || random.unit();
    let mut found = Cracks { views, ..Cracks::default() };
    let mut camera = || {
        let projection = Projection::Perspective { fov: 30.0 };
        let yaw = 360.0 * unit();
        let pitch = (2.0 * unit() - 1.0).asin().to_degrees();
        let mut camera = Camera::orbit(table.bounds, yaw, pitch, projection, 1.0);
        // Every third view goes near a corner of some triangle.
        if unit() < 1.0 / 3.0 && !triangles.is_empty() {
            let at = triangles[(unit() * triangles.len() as f64) as usize % triangles.len()][0];
            let back = camera.eye - camera.target;
            // Outside the box, lest the near plane cut a hole.
            let [low, high] = table.bounds;
            let mut away = 0.05 + 0.3 * unit();
            while (at + back * away).clamp(low, high) == at + back * away {
                away += 0.05;
            }
            camera = Camera { eye: at + back * away, target: at, ..camera };
        }
        camera
    };
    let frame = |camera| SolidFrame {
        width: size,
        height: size,
        camera,
        show: SolidShow::Sides,
        stripes: 1.0,
        background: Some([0.0, 0.0, 0.0, 1.0]),
        samples: 1,
        tessellation,
    };
    let mut prepared = None;
    for view in 0..views {
        let camera = camera();
        let prepared = match &mut prepared {
            None => prepared.insert(gpu.prepare_solid(table, &frame(camera))?),
            Some(prepared) => {
                prepared.look(camera, table);
                prepared
            }
        };
        prepared.run(true)?;
        let Pixels::Rgba8(pixels) = prepared.pixels()? else { continue };
        let seen: Vec<Seen> = pixels
            .chunks_exact(4)
            .map(|p| match (p[0], p[1]) {
                (0, _) => Seen::Nothing,
                (_, 0) => Seen::Back,
                _ => Seen::Front,
            })
            .collect();
        found.covered += seen.iter().filter(|&&s| s != Seen::Nothing).count() as u64;
        let suspects = suspicious(&seen, size as usize);
        found.suspicious += suspects.len() as u64;
        for [x, y] in suspects {
            let here = seen[y as usize * size as usize + x as usize];
            let offsets = [[0.0, 0.0], [0.3, 0.0], [-0.3, 0.0], [0.0, 0.3], [0.0, -0.3]];
            let mut other = None;
            let sure = offsets.iter().all(|[dx, dy]| {
                let there = cast(&camera, [f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy], size, triangles);
                there != here && *other.get_or_insert(there) == there
            });
            if sure && !grazed(&camera, [f64::from(x) + 0.5, f64::from(y) + 0.5], size, triangles, here) {
                found.cracks += 1;
                found.first.get_or_insert((view, [x, y]));
            }
        }
    }
    Ok(found)
}

/// Pixels unlike two opposite neighbours that are alike.
fn suspicious(seen: &[Seen], size: usize) -> Vec<[u32; 2]> {
    let mut out = Vec::new();
    for y in 1..size.saturating_sub(1) {
        for x in 1..size - 1 {
            let at = y * size + x;
            let odd = |step: usize| seen[at - step] == seen[at + step] && seen[at] != seen[at + step];
            if odd(1) || odd(size) || odd(size + 1) || odd(size - 1) {
                out.push([x as u32, y as u32]);
            }
        }
    }
    out
}

/// What the ray through a point of the picture (pixels, square of `size`) sees first.
fn cast(camera: &Camera, at: [f64; 2], size: u32, triangles: &[[DVec3; 3]]) -> Seen {
    let nearest = hits(camera, at, size, triangles).into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map_or(Seen::Nothing, |(_, seen)| seen)
}

/// Depth and side of everything on the ray through a point of the picture.
fn hits(camera: &Camera, [x, y]: [f64; 2], size: u32, triangles: &[[DVec3; 3]]) -> Vec<(f64, Seen)> {
    let mut found = Vec::new();
    let Projection::Perspective { fov } = camera.projection else { return found };
    let [right, up, back] = camera.axes();
    let tan = (0.5 * fov.to_radians()).tan();
    let across = |pixel: f64| (2.0 * pixel / f64::from(size) - 1.0) * tan;
    let ray = right * across(x) - up * across(y) - back;
    for [a, b, c] in triangles {
        let (u, v, w) = (*b - *a, *c - *a, camera.eye - *a);
        // Moeller, Trumbore: w + t ray = beta u + gamma v.
        let p = ray.cross(v);
        let determinant = u.dot(p);
        if determinant == 0.0 {
            continue;
        }
        let beta = w.dot(p) / determinant;
        if !(0.0..=1.0).contains(&beta) {
            continue;
        }
        let q = w.cross(u);
        let gamma = ray.dot(q) / determinant;
        let depth = v.dot(q) / determinant;
        if gamma >= 0.0 && beta + gamma <= 1.0 && depth > 0.0 {
            found.push((depth, if determinant > 0.0 { Seen::Front } else { Seen::Back }));
        }
    }
    found
}

/// Whether a triangle of the side `side` passes within 1/8 of a pixel of a point of the picture, no more than ten pixels
/// behind what is seen there: a contour, where both sides are as near.
fn grazed(camera: &Camera, [x, y]: [f64; 2], size: u32, triangles: &[[DVec3; 3]], side: Seen) -> bool {
    let near = |i: i32, j: i32| [x + f64::from(i) / 16.0, y + f64::from(j) / 16.0];
    (-2..=2).flat_map(|i| (-2..=2).map(move |j| near(i, j))).any(|at| {
        let mut hits = hits(camera, at, size, triangles);
        hits.sort_by(|a, b| a.0.total_cmp(&b.0));
        let Projection::Perspective { fov } = camera.projection else { return false };
        let pixel = 2.0 * (0.5 * fov.to_radians()).tan() / f64::from(size);
        hits.first().is_some_and(|&(first, _)| {
            hits.iter().any(|&(depth, seen)| seen == side && depth <= first * (1.0 + 10.0 * pixel))
        })
    })
}

/// The triangles of a table, model units.
pub fn triangles_of(table: &SolidTable) -> Vec<[DVec3; 3]> {
    let mut out = Vec::new();
    for part in table.parts.iter().filter(|part| part.primitive == Primitive::Triangles) {
        let indices = &table.indices[part.first as usize..][..3 * part.count as usize];
        out.extend(indices.chunks_exact(3).map(|t| {
            [t[0], t[1], t[2]].map(|i| {
                let [x, y, z, ..] = table.vertices[i as usize];
                DVec3::new(x.into(), y.into(), z.into()) + table.centre
            })
        }));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_see_the_nearest_side() {
        let [a, b, c] = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let box_ = [DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0)];
        let camera = Camera::orbit(box_, 0.0, 0.0, Projection::Perspective { fov: 30.0 }, 1.0);
        assert_eq!(cast(&camera, [40.0, 60.0], 100, &[[a, b, c]]), Seen::Front);
        assert_eq!(cast(&camera, [40.0, 60.0], 100, &[[a, c, b]]), Seen::Back);
        assert_eq!(cast(&camera, [60.0, 40.0], 100, &[[a, b, c]]), Seen::Nothing);
        let behind = DVec3::Z * 1.0;
        assert_eq!(cast(&camera, [40.0, 60.0], 100, &[[a, c, b], [a - behind, b - behind, c - behind]]), Seen::Back);
    }

    #[test]
    fn a_line_of_background_is_suspicious_and_an_edge_is_not() {
        let mut seen = vec![Seen::Front; 25];
        seen[12] = Seen::Nothing;
        assert_eq!(suspicious(&seen, 5), [[2, 2]]);
        for y in 0..5 {
            for x in 0..5 {
                seen[5 * y + x] = if x < 3 { Seen::Front } else { Seen::Nothing };
            }
        }
        assert!(suspicious(&seen, 5).is_empty());
    }
}
