//! `gradtess render` of a pattern scene, by any of the draw methods.

use super::flags::{evaluator_name, method_name};
use super::open::controls;
use crate::camera;
use crate::command::open::milliseconds;
use crate::command::picture::PictureFlags;
use crate::command::{print, print_json, Failure, Global};
use crate::gpu::{Gpu, GpuTimes, PatternFrame, PatternMethod, PatternScene as Drawn, PatternShow};
use crate::pattern::{Control, RefinementPattern};
use crate::scene::pattern::PatternScene;
use glam::DVec3;
use serde::Serialize;
use std::path::Path;

/// How the picture is made.
pub struct Canvas<'a> {
    /// Flags of size and camera.
    pub picture: &'a PictureFlags,
    /// File.
    pub output: &'a Path,
    /// What is shown.
    pub show: PatternShow,
    /// How it is drawn.
    pub method: PatternMethod,
    /// The grid instead of the triangular pattern.
    pub grid: bool,
    /// Level.
    pub level: u32,
    /// Colour under the surface, or nothing.
    pub background: Option<[f32; 4]>,
    /// Samples a pixel.
    pub samples: u32,
}

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    scene: String,
    technique: &'static str,
    output: String,
    width: u32,
    height: u32,
    method: &'static str,
    evaluator: &'static str,
    level: u32,
    device: String,
    coarse_triangles: usize,
    vertices_stored: usize,
    triangles: usize,
    device_bytes: u64,
    record_ms: f64,
    wait_ms: f64,
    gpu: GpuTimes,
}

/// Least and greatest corner of all that the coefficients can reach.
pub fn bounds(controls: &[Control], reach: f64) -> [DVec3; 2] {
    let points = controls.iter().flat_map(|c| c.points);
    let [low, high] = camera::bounds(points).unwrap_or([DVec3::ZERO, DVec3::ONE]);
    let reach = DVec3::splat(reach);
    [low - reach, high + reach]
}

/// The pattern of a level.
pub fn pattern(level: u32, grid: bool) -> Result<RefinementPattern, Failure> {
    let made = if grid { RefinementPattern::quad(level) } else { RefinementPattern::triangle(level) };
    made.map_err(Failure::input)
}

/// Draws and writes the picture.
pub fn run(scene: &PatternScene, canvas: &Canvas, global: &Global) -> Result<(), Failure> {
    let controls = controls(scene);
    let bounds = bounds(&controls, scene.displacement.reach());
    let pattern = pattern(canvas.level, canvas.grid)?;
    let [width, height] = canvas.picture.size.unwrap_or([1024, 1024]);
    let frame = PatternFrame {
        width,
        height,
        camera: canvas.picture.camera.camera(bounds, [width, height])?,
        bounds,
        show: canvas.show,
        method: canvas.method,
        background: canvas.background,
        samples: canvas.samples,
    };
    let drawn =
        Drawn { controls: &controls, evaluator: scene.evaluator, displacement: &scene.displacement, pattern: &pattern };
    let gpu = Gpu::new(&global.gpu())?;
    let prepared = gpu.prepare_pattern(&drawn, &frame)?;
    let times = prepared.run(true)?;
    let picture = prepared.pixels()?.into_picture(width, height);
    if let Some(m) = gpu.messages().first() {
        return Err(Failure::machine(format_args!("the validation layer reports: {}: {}", m.id, m.text)));
    }
    let software = concat!("gradtess ", env!("CARGO_PKG_VERSION"));
    picture.write_png(canvas.output, &[("Software", software), ("Comment", &gpu.device().driver)])?;
    let each = if canvas.method == PatternMethod::Static { controls.len() } else { 1 };
    let result = Report {
        schema: "gradtess.pattern_render/1",
        scene: scene.name.clone(),
        technique: "pattern",
        output: canvas.output.display().to_string(),
        width,
        height,
        method: method_name(canvas.method),
        evaluator: evaluator_name(scene.evaluator),
        level: canvas.level,
        device: gpu.device().name.clone(),
        coarse_triangles: controls.len(),
        vertices_stored: match canvas.method {
            PatternMethod::Hardware => controls.len(),
            _ => each * pattern.weights.len(),
        },
        triangles: controls.len() * pattern.triangles(),
        device_bytes: prepared.bytes(),
        record_ms: milliseconds(times.record_ns.into()),
        wait_ms: milliseconds(times.wait_ns.into()),
        gpu: times.gpu,
    };
    if global.json {
        return print_json(&result);
    }
    if !global.quiet {
        let r = &result;
        print(&format!(
            "{}: {} coarse triangles at level {}, method {}, {} vertices stored, {} bytes on the device, {} x {} on {}\n",
            r.output, r.coarse_triangles, r.level, r.method, r.vertices_stored, r.device_bytes, width, height, r.device
        ));
    }
    Ok(())
}
