//! `gradtess check` of a surface: cracks in random views.

use super::flags::{level, SurfaceFlags};
use super::open::Surface;
use super::render::{make, make_patches, Look, MadePatches, LEVEL};
use crate::check::solid_cracks::{look_around, triangles_of};
use crate::command::picture::PictureFlags;
use crate::command::{print, print_json, silent, Failure, Global};
use crate::gpu::{Gpu, SolidShow};
use crate::surface::accuracy::measure;
use crate::surface::drawing::tessellated;
use serde::Serialize;

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    scene: String,
    technique: &'static str,
    level: u32,
    triangles: usize,
    views: u32,
    pixels: u64,
    suspicious_pixels: u64,
    crack_pixels: u64,
    /// View and pixel of the first.
    first_crack: Option<(u32, [u32; 2])>,
    /// Of patches; regular, then Gregory.
    #[serde(skip_serializing_if = "Option::is_none")]
    patches: Option<PatchReport>,
}

/// Patches against the limit at 9 x 9 parameters each: distances over the diagonal of the box, angles in degrees.
#[derive(Serialize)]
struct PatchReport {
    count: [usize; 2],
    /// Regular ones with finer neighbours.
    transition: usize,
    /// Vertices that subdivision computed, over all levels.
    computed_vertices: usize,
    /// Greatest distance of the two sides of an edge.
    gap_max: f64,
    distance_max: [f64; 2],
    distance_mean: [f64; 2],
    /// Along the limit's normal.
    off_max: [f64; 2],
    normal_angle_max: [f64; 2],
    /// Of N_B, across edges that are not sharp.
    blended_normal_jump_max: f64,
}

/// Looks around and reports; the number of crack pixels.
pub fn run(
    surface: &Surface,
    flags: &SurfaceFlags,
    picture: &PictureFlags,
    views: u32,
    seed: u64,
    global: &Global,
) -> Result<u64, Failure> {
    picture.refuse_flat()?;
    picture.camera.refuse_any()?;
    let [width, height] = picture.size.unwrap_or([512, 512]);
    if width != height {
        return Err(Failure::input("cracks are looked for in square pictures; give --size NxN"));
    }
    let segments = picture.segments()?;
    let mut accuracy = None;
    let (made, triangles) = match segments {
        None => {
            let made = make(
                surface,
                flags,
                level(&picture.refining)?.unwrap_or(LEVEL),
                Look::Surface(SolidShow::Sides),
                global,
            )?;
            let triangles = triangles_of(&made.table);
            (made, triangles)
        }
        Some(n) => {
            let made = make_patches(surface, flags, &picture.refining, global)?;
            let computed = made.computed();
            let MadePatches { made, patches, parts, .. } = made;
            accuracy = Some((measure(&parts, &patches, 3, flags.settings()?.power), patches.transitions(), computed));
            (made, tessellated(&patches, n))
        }
    };
    let gpu = Gpu::new(&global.gpu())?;
    let tessellation = flags.tessellation(segments)?;
    let cracks = look_around(&gpu, &made.table, &triangles, tessellation, [views, width], seed)?;
    silent(&gpu)?;
    let report = Report {
        schema: "gradtess.surface_check/1",
        scene: surface.scene.name.clone(),
        technique: "surface",
        level: made.level,
        triangles: triangles.len(),
        views,
        pixels: cracks.covered,
        suspicious_pixels: cracks.suspicious,
        crack_pixels: cracks.cracks,
        first_crack: cracks.first,
        patches: accuracy.map(|(a, transition, computed_vertices)| PatchReport {
            count: a.patches,
            transition,
            computed_vertices,
            gap_max: a.gap,
            distance_max: a.distance,
            distance_mean: a.mean_distance,
            off_max: a.off,
            normal_angle_max: a.angle,
            blended_normal_jump_max: a.jump,
        }),
    };
    if global.json {
        print_json(&report)?;
    } else if !global.quiet {
        print(&format!(
            "{}: level {}, {} triangles, {} views: {} crack pixels of {} ({} looked at closely)\n",
            report.scene,
            report.level,
            report.triangles,
            report.views,
            report.crack_pixels,
            report.pixels,
            report.suspicious_pixels
        ));
        if let Some(p) = &report.patches {
            for (k, name) in ["regular", "Gregory"].into_iter().enumerate() {
                print(&format!(
                    "  {} {name} patches: at most {:.3e} of the size from the limit (mean {:.3e}), {:.3e} off its surface, N_L within {:.3e} degrees\n",
                    p.count[k], p.distance_max[k], p.distance_mean[k], p.off_max[k], p.normal_angle_max[k]
                ));
            }
            print(&format!(
                "  N_B turns by at most {:.3e} degrees across smooth edges; {} transition patches, {} vertices computed\n",
                p.blended_normal_jump_max, p.transition, p.computed_vertices
            ));
        }
    }
    Ok(cracks.cracks)
}
