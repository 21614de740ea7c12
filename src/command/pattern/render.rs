//! `gradtess render` of a pattern scene, by any of the draw methods.

use super::flags::{evaluator_name, method_name};
use super::open::controls;
use crate::camera;
use crate::command::open::milliseconds;
use crate::command::picture::{deliver, PictureFlags};
use crate::command::{print, print_json, Failure, Global};
use crate::gpu::{Gpu, GpuTimes, PatternFrame, PatternMethod, PatternScene as Drawn, PatternShow};
use crate::pattern::detail::{self, Scope, View};
use crate::pattern::{CoarseMesh, Control, Detail, NormalField, RefinementPattern};
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
    /// Levels of detail.
    pub detail: Option<Detail>,
    /// What the device makes coefficients of.
    pub coarse: Option<(&'a CoarseMesh, NormalField)>,
}

/// Levels of detail of a picture.
#[derive(Serialize)]
struct LodReport {
    scope: &'static str,
    segment: f64,
    morph: bool,
    /// Coarse triangles drawn by the pattern of 1, 2, 4, ... segments.
    triangles_by_pattern: Vec<usize>,
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
    #[serde(skip_serializing_if = "Option::is_none")]
    lod: Option<LodReport>,
    record_ms: f64,
    wait_ms: f64,
    gpu: GpuTimes,
}

impl LodReport {
    fn new(detail: &Detail, controls: &[Control], frame: &PatternFrame) -> LodReport {
        let mut triangles_by_pattern = vec![0; detail.most as usize + 1];
        for levels in detail::all(controls, frame.bounds, detail, &View::new(&frame.camera, frame.height)) {
            triangles_by_pattern[levels.pattern() as usize] += 1;
        }
        let scope = match detail.scope {
            Scope::Mesh => "mesh",
            Scope::Triangle => "triangle",
        };
        LodReport { scope, segment: detail.segment, morph: detail.morph, triangles_by_pattern }
    }
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
        detail: canvas.detail,
        background: canvas.background,
        samples: canvas.samples,
    };
    let drawn = Drawn {
        controls: &controls,
        evaluator: scene.evaluator,
        displacement: &scene.displacement,
        pattern: &pattern,
        coarse: canvas.coarse,
    };
    let gpu = Gpu::new(&global.gpu())?;
    let prepared = gpu.prepare_pattern(&drawn, &frame)?;
    let times = prepared.run(true)?;
    let picture = prepared.pixels()?.into_picture(width, height);
    deliver(&picture, canvas.output, &gpu)?;
    let lod = canvas.detail.map(|detail| LodReport::new(&detail, &controls, &frame));
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
            _ if canvas.detail.is_some() => Detail::vertices(canvas.detail.map_or(0, |d| d.most)),
            PatternMethod::Hardware => controls.len(),
            _ => each * pattern.weights.len(),
        },
        triangles: match &lod {
            Some(lod) => lod.triangles_by_pattern.iter().enumerate().map(|(up, n)| n << (2 * up)).sum(),
            None => controls.len() * pattern.triangles(),
        },
        device_bytes: prepared.bytes(),
        lod,
        record_ms: milliseconds(times.record_ns.into()),
        wait_ms: milliseconds(times.wait_ns.into()),
        gpu: times.gpu,
    };
    if global.json {
        return print_json(&result);
    }
    if !global.quiet {
        let r = &result;
        let level = match r.lod {
            Some(_) => format!("levels of detail to {}", 1 << canvas.detail.map_or(0, |d| d.most)),
            None => format!("level {}", r.level),
        };
        print(&format!(
            "{}: {} coarse triangles at {level}, method {}, {} vertices stored, {} bytes on the device, {} x {} on {}\n",
            r.output, r.coarse_triangles, r.method, r.vertices_stored, r.device_bytes, width, height, r.device
        ));
    }
    Ok(())
}
