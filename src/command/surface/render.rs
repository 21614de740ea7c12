//! `gradtess render` of a surface: uniform levels as triangles, the papers' way, or patches.

use super::flags::{level, patch_level, NormalsFlag, SurfaceFlags};
use super::open::Surface;
use crate::command::open::milliseconds;
use crate::command::picture::{deliver, PictureFlags};
use crate::command::{print, print_json, Failure, Global, Refining};
use crate::gpu::{Gpu, GpuTimes, SolidFrame, SolidShow};
use crate::patch::solid::{Primitive, SolidTable};
use crate::scene::surface::SurfaceScene;
use crate::surface::adaptive::{subdivide, Depth, Part};
use crate::surface::drawing::{self, mesh, triangles};
use crate::surface::patches::{first_level, of_parts, Patches};
use crate::surface::refine::MAX_HALF_EDGES;
use crate::surface::shade::{limit_positions, shade};
use crate::surface::SurfaceError;
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// What of a surface is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// The surface, coloured so.
    Surface(SolidShow),
    /// The mesh of the level.
    Mesh,
    /// The control mesh.
    Control,
}

/// How the picture is made, apart from what it shows.
pub struct Canvas<'a> {
    /// Flags of size and camera.
    pub picture: &'a PictureFlags,
    /// File.
    pub output: &'a Path,
    /// Colour under the surface, or nothing.
    pub background: Option<[f32; 4]>,
    /// Samples a pixel.
    pub samples: u32,
}

/// Level that is drawn unless `--level` says otherwise.
pub const LEVEL: u32 = 4;

/// Deepest level of patches.
const MOST_LEVELS: u32 = 24;

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    scene: String,
    technique: &'static str,
    output: String,
    width: u32,
    height: u32,
    eye: [f64; 3],
    target: [f64; 3],
    level: u32,
    device: String,
    vertices: usize,
    triangles: usize,
    /// Patches.
    bicubic: usize,
    bicubic_transition: usize,
    gregory: usize,
    quartic: usize,
    quartic_transition: usize,
    quartic_gregory: usize,
    /// Vertices that subdivision computed for them.
    #[serde(skip_serializing_if = "Option::is_none")]
    computed_vertices: Option<usize>,
    device_bytes: u64,
    subdivide_ms: f64,
    shade_ms: f64,
    record_ms: f64,
    wait_ms: f64,
    gpu: GpuTimes,
}

/// A surface ready to be drawn, and the times that took.
pub struct Made {
    /// Triangles and lines.
    pub table: SolidTable,
    /// Level drawn.
    pub level: u32,
    /// Wall time of subdivision, ms.
    pub subdivide_ms: f64,
    /// Wall time of normals, weights and the table, ms.
    pub shade_ms: f64,
}

/// Subdivides, shades and collects triangles.
pub fn make(surface: &Surface, flags: &SurfaceFlags, depth: u32, look: Look, global: &Global) -> Result<Made, Failure> {
    let start = Instant::now();
    let depth = if look == Look::Control { 0 } else { depth };
    let made = flags.subdivide(surface, depth, global)?;
    let subdivided = Instant::now();
    let last = &made.levels[depth as usize];
    let limits = (flags.limit && look != Look::Control).then(|| limit_positions(last));
    let positions = limits.as_ref().unwrap_or(&last.position);
    let table = match look {
        Look::Mesh | Look::Control => mesh(last, positions),
        Look::Surface(_) => {
            let mut settings = flags.settings()?;
            let normals = flags.normals();
            settings.everywhere = normals == NormalsFlag::Subdivided;
            let shaded = shade(&made.levels, &made.scene.normals, &settings);
            let normals = match normals {
                NormalsFlag::Blended => &shaded.blended,
                NormalsFlag::Geometric => &shaded.geometric,
                NormalsFlag::Subdivided => &shaded.subdivided,
            };
            triangles(last, &shaded, positions, normals)
        }
    };
    Ok(Made {
        table,
        level: depth,
        subdivide_ms: milliseconds((subdivided - start).as_nanos()),
        shade_ms: milliseconds(subdivided.elapsed().as_nanos()),
    })
}

/// Patches of a surface.
pub struct MadePatches {
    /// Table and times; its level is the last.
    pub made: Made,
    /// The scene, cut into triangles if that was asked for.
    pub scene: SurfaceScene,
    /// The patches themselves.
    pub patches: Patches,
    /// Their levels.
    pub parts: Vec<Part>,
}

impl MadePatches {
    /// Vertices that subdivision computed, over all levels.
    pub fn computed(&self) -> usize {
        self.parts.iter().map(|part| part.computed).sum()
    }
}

/// Makes patches: regular ones from the first level that has them, the others on the level asked for or, unless given,
/// the first that patches can draw.
pub fn make_patches(
    surface: &Surface,
    flags: &SurfaceFlags,
    refining: &Refining,
    global: &Global,
) -> Result<MadePatches, Failure> {
    let (depth, uniform) = patch_level(refining)?;
    if flags.limit {
        return Err(Failure::input("patches are the limit surface; leave out --limit"));
    }
    let settings = flags.settings()?;
    let start = Instant::now();
    let control = flags.subdivide(surface, 0, global)?;
    let first = first_level(&control.levels[0]);
    let level = depth.unwrap_or(first);
    if level < first {
        return Err(Failure::input(format_args!(
            "level {level} has polygons or sharpness left, which no patch draws; use --level {first} or more"
        )));
    }
    if level > MOST_LEVELS {
        return Err(Failure::input(format_args!("level {level} of patches is too deep; at most {MOST_LEVELS}")));
    }
    let depth = match uniform {
        true => Depth::uniform(level),
        false => Depth::adaptive(level, &settings),
    };
    let half_edges = (control.levels[0].half_edges() as u64).saturating_mul(4u64.saturating_pow(depth.first));
    if half_edges > MAX_HALF_EDGES {
        return Err(Failure::input(SurfaceError::TooLarge { level: depth.first, limit: MAX_HALF_EDGES }));
    }
    let parts = subdivide(&control.levels[0], &control.scene.normals, &settings, depth);
    let subdivided = Instant::now();
    let patches = of_parts(&parts);
    let (around, _) = patches.bounds();
    let table = drawing::patches(&patches, around);
    Ok(MadePatches {
        made: Made {
            table,
            level,
            subdivide_ms: milliseconds((subdivided - start).as_nanos()),
            shade_ms: milliseconds(subdivided.elapsed().as_nanos()),
        },
        scene: control.scene,
        patches,
        parts,
    })
}

/// Draws and writes the picture.
pub fn run(
    surface: &Surface,
    flags: &SurfaceFlags,
    look: Look,
    canvas: &Canvas,
    global: &Global,
) -> Result<(), Failure> {
    canvas.picture.refuse_flat()?;
    let refining = &canvas.picture.refining;
    let tess = canvas.picture.segments()?;
    let mut computed = None;
    let made = match (tess, look) {
        (Some(_), Look::Surface(_)) => {
            let made = make_patches(surface, flags, refining, global)?;
            computed = Some(made.computed());
            made.made
        }
        (Some(_), _) => return Err(Failure::input("--tess draws surfaces; --show wire and control draw meshes")),
        (None, _) => make(surface, flags, level(refining)?.unwrap_or(LEVEL), look, global)?,
    };
    let [width, height] = canvas.picture.size.unwrap_or([1024, 1024]);
    let camera = canvas.picture.camera.camera(made.table.bounds, [width, height])?;
    let frame = SolidFrame {
        width,
        height,
        camera,
        show: match look {
            Look::Surface(show) => show,
            Look::Mesh | Look::Control => SolidShow::Plain,
        },
        stripes: flags.stripes()?,
        background: canvas.background,
        samples: canvas.samples,
        tessellation: flags.tessellation(tess)?,
    };
    let gpu = Gpu::new(&global.gpu())?;
    let prepared = gpu.prepare_solid(&made.table, &frame)?;
    let times = prepared.run(true)?;
    let picture = prepared.pixels()?.into_picture(width, height);
    deliver(&picture, canvas.output, &gpu)?;
    let count = |kind| made.table.parts.iter().filter(|p| p.primitive == kind).map(|p| p.count as usize).sum::<usize>();
    let result = Report {
        schema: "gradtess.surface_render/1",
        scene: surface.scene.name.clone(),
        technique: "surface",
        output: canvas.output.display().to_string(),
        width,
        height,
        eye: camera.eye.to_array(),
        target: camera.target.to_array(),
        level: made.level,
        device: gpu.device().name.clone(),
        vertices: made.table.points(),
        triangles: count(Primitive::Triangles),
        bicubic: count(Primitive::Bicubic),
        bicubic_transition: count(Primitive::Transition),
        gregory: count(Primitive::Gregory),
        quartic: count(Primitive::Quartic),
        quartic_transition: count(Primitive::QuarticTransition),
        quartic_gregory: count(Primitive::QuarticGregory),
        computed_vertices: computed,
        device_bytes: made.table.bytes(),
        subdivide_ms: made.subdivide_ms,
        shade_ms: made.shade_ms,
        record_ms: milliseconds(times.record_ns.into()),
        wait_ms: milliseconds(times.wait_ns.into()),
        gpu: times.gpu,
    };
    if global.json {
        return print_json(&result);
    }
    if !global.quiet {
        print(&format!(
            "{}: level {}, {} vertices, {} triangles, {} patches, {} x {}, subdivision {:.3} ms, shading {:.3} ms on {}\n",
            result.output,
            result.level,
            result.vertices,
            result.triangles,
            made.table.parts.iter().filter(|p| p.primitive.is_patch()).map(|p| p.count).sum::<u32>(),
            width,
            height,
            result.subdivide_ms,
            result.shade_ms,
            result.device
        ));
    }
    Ok(())
}
