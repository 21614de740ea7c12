//! `gradtess check` of a surface: cracks in random views.

use super::flags::{level, SurfaceFlags};
use super::open::Surface;
use super::render::{make, make_patches, Look, MadePatches, LEVEL};
use crate::check::solid_cracks::{look_around, triangles_of};
use crate::command::picture::PictureFlags;
use crate::command::{print, print_json, Failure, Global};
use crate::gpu::{Gpu, SolidShow};
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
    picture.refuse_plane()?;
    picture.camera.refuse_any()?;
    let depth = level(&picture.refining)?;
    let [width, height] = picture.size.unwrap_or([512, 512]);
    if width != height {
        return Err(Failure::input("cracks are looked for in square pictures; give --size NxN"));
    }
    let segments = picture.segments()?;
    let (made, triangles) = match segments {
        None => {
            let made = make(surface, flags, depth.unwrap_or(LEVEL), Look::Surface(SolidShow::Sides), global)?;
            let triangles = triangles_of(&made.table);
            (made, triangles)
        }
        Some(n) => {
            let MadePatches { made, patches } = make_patches(surface, flags, depth, global)?;
            (made, tessellated(&patches, n))
        }
    };
    let gpu = Gpu::new(&global.gpu())?;
    let tessellation = flags.tessellation(segments)?;
    let cracks = look_around(&gpu, &made.table, &triangles, tessellation, [views, width], seed)?;
    if let Some(m) = gpu.messages().first() {
        return Err(Failure::machine(format_args!("the validation layer reports: {}: {}", m.id, m.text)));
    }
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
    }
    Ok(cracks.cracks)
}
