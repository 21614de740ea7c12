//! Cracks in pictures of surfaces in space.
//!
//! Every pixel shows nothing, a front or a back. The triangles that the device draws are rasterised on the CPU as well,
//! exactly; where the device shows something else, no movement of corners by its snapping and rounding may explain it
//! ([`Coverage::may_show`]), or the surface is torn there. Thin gaps of the model itself are therefore no cracks, and
//! neither is a back seen through an opening; but a contour does not hide one.

use super::coverage::{Coverage, Seen};
use super::sheet::Sheet;
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
    /// Pixels that show something else than the CPU's picture.
    pub suspicious: u64,
    /// Those of them that snapping and rounding explain.
    pub snapped: u64,
    /// Cracks: the others, which the next three are.
    pub cracks: u64,
    /// Background inside the silhouette.
    pub background: u64,
    /// A back where the front should be, or a front where the back should be.
    pub swapped: u64,
    /// Surface outside the silhouette.
    pub outside: u64,
    /// View and pixel of the first crack.
    pub first: Option<(u32, [u32; 2])>,
    /// Farthest that snapping and rounding were taken to move a corner, pixels.
    pub margin: f64,
}

/// Looks at `table` from `views` random sides, some of them near, `size` pixels across and down. `sheet` has the triangles
/// that the device makes of the table, model units. `tessellation` is for patches.
///
/// # Errors
/// Drawing failed.
pub fn look_around(
    gpu: &Gpu,
    table: &SolidTable,
    sheet: &Sheet,
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
        if unit() < 1.0 / 3.0 && !sheet.triangles.is_empty() {
            let n = sheet.triangles.len();
            let at = sheet.positions[sheet.triangles[(unit() * n as f64) as usize % n][0] as usize];
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
        let coverage = Coverage::new(sheet, &camera, table.bounds, size);
        found.margin = found.margin.max(coverage.margin);
        judge(&coverage, &seen, view, &mut found);
    }
    Ok(found)
}

/// Adds what a picture shows that it should not.
fn judge(coverage: &Coverage, seen: &[Seen], view: u32, found: &mut Cracks) {
    let expected = coverage.picture();
    for (i, (&seen, &expected)) in seen.iter().zip(&expected).enumerate().filter(|(_, (a, b))| a != b) {
        found.suspicious += 1;
        let pixel = [i as u32 % coverage.size, i as u32 / coverage.size];
        if coverage.may_show(pixel, seen) {
            found.snapped += 1;
            continue;
        }
        found.cracks += 1;
        found.first.get_or_insert((view, pixel));
        match (seen, expected) {
            (Seen::Nothing, _) => found.background += 1,
            (_, Seen::Nothing) => found.outside += 1,
            _ => found.swapped += 1,
        }
    }
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

    const SIZE: u32 = 64;

    /// A roof of two slopes, its ridge along the line of sight's right side, seen edge-on from the side: columns from
    /// `ridge` (pixels) on are background, those before show the front slope.
    fn roof(ridge: f64) -> Sheet {
        let x = (2.0 * ridge / f64::from(SIZE) - 1.0) * 0.5;
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        // The camera below looks along -z and shows x and y from -1/2 to 1/2.
        let [a, b] = [at(x, -1.0, 0.0), at(x, 1.0, 0.0)];
        let [c, d] = [at(-1.0, -1.0, 0.1), at(-1.0, 1.0, 0.1)];
        let [e, f] = [at(-1.0, -1.0, -0.1), at(-1.0, 1.0, -0.1)];
        Sheet::weld(&[[a, b, d], [a, d, c], [b, a, e], [b, e, f]])
    }

    fn coverage(sheet: &Sheet) -> Coverage {
        let projection = Projection::Orthographic { height: 1.0 };
        let camera = Camera { eye: DVec3::Z * 2.0, target: DVec3::ZERO, up: DVec3::Y, projection };
        Coverage::new(sheet, &camera, [DVec3::splat(-1.0), DVec3::splat(1.0)], SIZE)
    }

    /// What is found where a picture of `sheet` shows `what` at one pixel.
    fn found(sheet: &Sheet, pixel: [u32; 2], what: Seen) -> Cracks {
        let coverage = coverage(sheet);
        let mut seen = coverage.picture();
        seen[(pixel[1] * SIZE + pixel[0]) as usize] = what;
        let mut found = Cracks::default();
        judge(&coverage, &seen, 0, &mut found);
        found
    }

    #[test]
    fn the_nearest_side_is_seen() {
        let [a, b, c] = [DVec3::new(-0.5, -0.5, 0.0), DVec3::new(0.5, -0.5, 0.0), DVec3::new(-0.5, 0.5, 0.0)];
        let front = coverage(&Sheet::weld(&[[a, b, c]])).picture();
        let at = |x: usize, y: usize| y * SIZE as usize + x;
        // y is down: the triangle is the lower left half.
        assert_eq!((front[at(5, 60)], front[at(60, 5)]), (Seen::Front, Seen::Nothing));
        let behind = |p: DVec3| p - DVec3::Z * 0.5;
        let both = coverage(&Sheet::weld(&[[a, c, b], [behind(a), behind(b), behind(c)]])).picture();
        assert_eq!(both[at(5, 60)], Seen::Back);
    }

    #[test]
    fn a_contour_may_be_snapped_over_a_pixel_and_no_farther() {
        // The contour passes 1/1000 of a pixel from the middles of column 40, on either side.
        for ridge in [40.501, 40.499] {
            let roof = roof(ridge);
            for what in [Seen::Nothing, Seen::Front, Seen::Back] {
                let seen = found(&roof, [40, 20], what);
                assert!(seen.cracks == 0 && seen.suspicious <= 1, "{ridge} {what:?}: {seen:?}");
            }
        }
        // At 1/50 it cannot; nor can a neighbour be explained by it.
        assert_eq!(found(&roof(40.52), [40, 20], Seen::Nothing).background, 1);
        assert_eq!(found(&roof(40.52), [40, 20], Seen::Back).swapped, 1);
        assert_eq!(found(&roof(40.48), [40, 20], Seen::Front).outside, 1);
        assert_eq!(found(&roof(40.501), [39, 20], Seen::Nothing).background, 1);
    }

    #[test]
    fn a_crack_beside_a_contour_is_found_though_something_lies_behind() {
        // A front far behind: through a crack it would be seen, which is the same side; nothing never can be.
        let back_wall = |z: f64| [DVec3::new(-1.0, -1.0, z), DVec3::new(1.0, -1.0, z), DVec3::new(0.0, 3.0, z)];
        let sheet = |ridge: f64| {
            let roof = roof(ridge);
            let mut all: Vec<_> = roof.triangles.iter().map(|t| t.map(|i| roof.positions[i as usize])).collect();
            let [a, b, c] = back_wall(-0.5);
            all.push([a, c, b]);
            Sheet::weld(&all)
        };
        let seen = found(&sheet(40.501), [40, 20], Seen::Nothing);
        assert_eq!((seen.background, seen.cracks), (1, 1));
        // The wall's back may be seen beside the contour, but not a pixel farther in.
        assert_eq!(found(&sheet(40.501), [40, 20], Seen::Back).cracks, 0);
        assert_eq!(found(&sheet(40.501), [39, 20], Seen::Back).swapped, 1);
    }

    #[test]
    fn creases_and_inner_edges_excuse_nothing_and_borders_do() {
        // Two slopes that face the eye meet in a crease through the middles of column 32.
        let x = 0.5 / f64::from(SIZE);
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let [a, b] = [at(x, -1.0, 0.2), at(x, 1.0, 0.2)];
        let left = [[at(-1.0, -1.0, 0.0), a, b], [at(-1.0, -1.0, 0.0), b, at(-1.0, 1.0, 0.0)]];
        let right = [[a, at(1.0, -1.0, 0.0), b], [at(1.0, -1.0, 0.0), at(1.0, 1.0, 0.0), b]];
        let whole = Sheet::weld(&[left, right].concat());
        assert_eq!(found(&whole, [32, 10], Seen::Nothing).background, 1);
        assert_eq!(found(&whole, [32, 10], Seen::Back).swapped, 1);
        // The left slope alone ends there.
        let border = Sheet::weld(&left);
        assert_eq!(found(&border, [32, 10], Seen::Nothing).cracks, 0);
        assert_eq!(found(&border, [32, 10], Seen::Back).swapped, 1);
        assert_eq!(found(&border, [31, 10], Seen::Nothing).background, 1);
        // Sides that lie on each other but share no corners are borders too: open edges tell of them.
        let torn: Vec<_> = right.iter().map(|t| t.map(|p| p + DVec3::Y * 1e-3)).chain(left).collect();
        assert_eq!(Sheet::weld(&torn).open_edges(), whole.open_edges() + 2);
    }
}
