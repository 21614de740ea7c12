//! `gradtess check` of a pattern scene: the device's positions against the CPU's, and cracks between coarse triangles.
//!
//! Cracks are looked for in the bits: wherever two coarse triangles share an edge, the vertices along it must be the same
//! on the device, and then no rasteriser can part them. For closed meshes pictures from random sides are searched too:
//! drawn without a ground, every pixel within the outline has to be covered, so a transparent pixel between covered ones of
//! all its eight neighbours is a crack.

use super::open::controls;
use super::render::{bounds, pattern};
use crate::camera::{Camera, Projection};
use crate::command::{print, print_json, Failure, Global};
use crate::gpu::{Gpu, PatternFrame, PatternMethod, PatternScene as Drawn, PatternShow};
use crate::pattern::evaluate::evaluate;
use crate::scene::pattern::PatternScene;
use crate::timing::random::Random;
use glam::Vec3;
use serde::Serialize;
use std::collections::HashMap;

/// Greatest distance of a device position from the CPU's, over the scene's diagonal, that is let pass.
const LIMIT: f64 = 1e-5;

#[derive(Serialize)]
struct Report<'a> {
    schema: &'static str,
    scene: &'a str,
    technique: &'static str,
    level: u32,
    vertices: usize,
    /// Greatest distance from the CPU, over the diagonal of the scene.
    max_error: f64,
    edges_shared: usize,
    /// Vertices on shared edges whose bits differ.
    parted: usize,
    views: u32,
    crack_pixels: usize,
}

/// What is looked at.
pub struct Request {
    /// Level of the pattern.
    pub level: u32,
    /// Random views.
    pub views: u32,
    /// Seed of the views.
    pub seed: u64,
    /// Pixels.
    pub size: [u32; 2],
    /// How the views are drawn.
    pub method: PatternMethod,
}

/// Measures and judges.
pub fn run(scene: &PatternScene, request: &Request, global: &Global) -> Result<(), Failure> {
    let controls = controls(scene);
    let bounds = bounds(&controls, scene.displacement.reach());
    let pattern = pattern(request.level, false)?;
    let drawn =
        Drawn { controls: &controls, evaluator: scene.evaluator, displacement: &scene.displacement, pattern: &pattern };
    let aspect = f64::from(request.size[0]) / f64::from(request.size[1]);
    let projection = Projection::Perspective { fov: 30.0 };
    let mut frame = PatternFrame {
        width: request.size[0],
        height: request.size[1],
        camera: Camera::orbit(bounds, 30.0, 20.0, projection, aspect),
        bounds,
        show: PatternShow::Shaded,
        method: request.method,
        background: None,
        samples: 1,
    };
    let gpu = Gpu::new(&global.gpu())?;
    let records = gpu.evaluate_pattern(&drawn, &frame)?;
    let diagonal = (bounds[1] - bounds[0]).length().max(f64::MIN_POSITIVE);
    let each = pattern.weights.len();
    let mut worst: f64 = 0.0;
    for (t, control) in controls.iter().enumerate() {
        for (k, w) in pattern.weights.iter().enumerate() {
            let point = evaluate(control, scene.evaluator, &scene.displacement, w.map(f64::from));
            let found = Vec3::from(records[t * each + k][0]).as_dvec3();
            worst = worst.max((found - point.position).length() / diagonal);
        }
    }
    let (edges_shared, parted) = seams(scene, request.level, &records, each);

    let mut random = Random::new(request.seed);
    let mut prepared = gpu.prepare_pattern(&drawn, &frame)?;
    let mut crack_pixels = 0;
    for _ in 0..request.views {
        let (yaw, pitch) = (360.0 * random.unit(), 180.0 * random.unit() - 90.0);
        let fitted = Camera::orbit(bounds, yaw, pitch, projection, aspect);
        let distance = (fitted.eye - fitted.target).length() * (1.0 + random.unit());
        frame.camera = fitted.at_distance(distance);
        prepared.look(frame.camera, &drawn);
        prepared.run(true)?;
        let picture = prepared.pixels()?.into_picture(frame.width, frame.height);
        crack_pixels += holes(&picture);
    }
    if let Some(m) = gpu.messages().first() {
        return Err(Failure::machine(format_args!("the validation layer reports: {}: {}", m.id, m.text)));
    }
    let report = Report {
        schema: "gradtess.pattern_check/1",
        scene: &scene.name,
        technique: "pattern",
        level: request.level,
        vertices: records.len(),
        max_error: worst,
        edges_shared,
        parted,
        views: request.views,
        crack_pixels,
    };
    if global.json {
        print_json(&report)?;
    } else if !global.quiet {
        print(&format!(
            "{}: {} vertices, at most {:.3e} of the diagonal from the CPU's; {} shared edges, {} vertices parted; {} crack pixels in {} views\n",
            report.scene, report.vertices, worst, edges_shared, parted, crack_pixels, report.views
        ));
    }
    if worst.is_nan() || worst > LIMIT {
        return Err(Failure::short(format_args!(
            "{}: the device's positions are {worst:.3e} of the diagonal off; at most {LIMIT:e} is let pass",
            scene.name
        )));
    }
    if parted + crack_pixels > 0 {
        return Err(Failure::short(format_args!(
            "{}: {parted} vertices on shared edges differ, and {crack_pixels} pixels are cracks; none are let pass",
            scene.name
        )));
    }
    Ok(())
}

/// Edges that two coarse triangles share, and the vertices along them that have other bits on one side.
fn seams(scene: &PatternScene, n: u32, records: &[[[f32; 3]; 2]], each: usize) -> (usize, usize) {
    let at = |i: u32, j: u32| (i * (i + 1) / 2 + j) as usize;
    // Along edge e from its first corner.
    let along = |e: usize, k: u32| match e {
        0 => at(k, 0),
        1 => at(n, k),
        _ => at(n - k, n - k),
    };
    let mut seen: HashMap<[u32; 2], (usize, usize)> = HashMap::new();
    let (mut shared, mut parted) = (0, 0);
    for (t, v) in scene.mesh.triangles.iter().enumerate() {
        for e in 0..3 {
            let (a, b) = (v[e], v[(e + 1) % 3]);
            let Some((other, f)) = seen.insert([a.min(b), a.max(b)], (t, e)) else { continue };
            shared += 1;
            let same_way = scene.mesh.triangles[other][f] == a;
            for k in 0..=n {
                let here = records[t * each + along(e, k)][0];
                let there = records[other * each + along(f, if same_way { k } else { n - k })][0];
                parted += usize::from(here.map(f32::to_bits) != there.map(f32::to_bits));
            }
        }
    }
    (shared, parted)
}

/// Transparent pixels among eight covered neighbours.
fn holes(picture: &crate::image::Picture) -> usize {
    let (w, h) = (picture.width as usize, picture.height as usize);
    let covered = |x: usize, y: usize| picture.rgba[4 * (y * w + x) + 3] > 0;
    let mut found = 0;
    for y in 1..h.saturating_sub(1) {
        for x in 1..w.saturating_sub(1) {
            if !covered(x, y) {
                let around = (0..9).filter(|&k| k != 4 && covered(x + k % 3 - 1, y + k / 3 - 1)).count();
                found += usize::from(around == 8);
            }
        }
    }
    found
}
