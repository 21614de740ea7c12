//! `gradtess check` of a surface: cracks in random views.

use super::flags::{level, SurfaceFlags};
use super::open::Surface;
use super::render::{make, make_patches, Look, MadePatches, LEVEL};
use crate::check::sheet::Sheet;
use crate::check::solid_cracks::{look_around, triangles_of, Cracks};
use crate::command::picture::PictureFlags;
use crate::command::{print, print_json, silent, Failure, Global};
use crate::gpu::{Gpu, SolidShow};
use crate::mesh::NONE;
use crate::surface::accuracy::measure;
use crate::surface::drawing::tessellated;
use crate::surface::patches::Place;
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
    /// That differ from what the CPU rasterises.
    suspicious_pixels: u64,
    /// Of those, what snapping and rounding of at most `snap_pixels` explain.
    snapped_pixels: u64,
    snap_pixels: f64,
    /// The others: background inside the silhouette, fronts and backs swapped, surface outside the silhouette.
    crack_pixels: u64,
    background_pixels: u64,
    swapped_pixels: u64,
    outside_pixels: u64,
    /// View and pixel of the first.
    first_crack: Option<(u32, [u32; 2])>,
    /// Edges of triangles that are on one side only, though the boundary of the mesh is not there.
    torn_edges: usize,
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

/// Looks around and reports; what was found, and how many edges are torn.
pub fn run(
    surface: &Surface,
    flags: &SurfaceFlags,
    picture: &PictureFlags,
    views: u32,
    seed: u64,
    global: &Global,
) -> Result<(Cracks, usize), Failure> {
    picture.refuse_flat()?;
    picture.camera.refuse_any()?;
    let [width, height] = picture.size.unwrap_or([512, 512]);
    if width != height {
        return Err(Failure::input("cracks are looked for in square pictures; give --size NxN"));
    }
    let segments = picture.segments()?;
    let mut accuracy = None;
    let (made, triangles, boundary) = match segments {
        None => {
            let made = make(
                surface,
                flags,
                level(&picture.refining)?.unwrap_or(LEVEL),
                Look::Surface(SolidShow::Sides),
                global,
            )?;
            let triangles = triangles_of(&made.table);
            let edges = surface.mesh.twin.iter().filter(|&&t| t == NONE).count();
            let boundary = edges << made.level;
            (made, triangles, boundary)
        }
        Some(n) => {
            let made = make_patches(surface, flags, &picture.refining, global)?;
            let computed = made.computed();
            let MadePatches { made, patches, parts, .. } = made;
            accuracy = Some((measure(&parts, &patches, 3, flags.settings()?.power), patches.transitions(), computed));
            // Beside the boundary nothing is finer.
            let ends = |place: Place| {
                let level = &parts[place.level as usize].level;
                level.of_face(place.face as usize).filter(|&h| level.twin[h as usize] == NONE).count()
            };
            let boundary = patches.iter().map(|p| ends(p.place) * n.at(p.place.level) as usize).sum();
            (made, tessellated(&patches, n), boundary)
        }
    };
    let gpu = Gpu::new(&global.gpu())?;
    let tessellation = flags.tessellation(segments)?;
    let sheet = Sheet::weld(&triangles);
    let torn_edges = sheet.open_edges().saturating_sub(boundary);
    let cracks = look_around(&gpu, &made.table, &sheet, tessellation, [views, width], seed)?;
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
        snapped_pixels: cracks.snapped,
        snap_pixels: cracks.margin,
        crack_pixels: cracks.cracks,
        background_pixels: cracks.background,
        swapped_pixels: cracks.swapped,
        outside_pixels: cracks.outside,
        first_crack: cracks.first,
        torn_edges,
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
            "{}: level {}, {} triangles, {torn_edges} torn edges; {} pixels in {} views, {} of them background inside the silhouette, {} a wrong side, {} beyond it ({} differ within snapping)\n",
            report.scene,
            report.level,
            report.triangles,
            report.pixels,
            report.views,
            report.background_pixels,
            report.swapped_pixels,
            report.outside_pixels,
            report.snapped_pixels
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
    Ok((cracks, torn_edges))
}
