//! `gradtess check` of a pattern scene: the device's positions against the CPU's, and cracks between coarse triangles.
//!
//! Cracks are looked for in the bits: wherever two coarse triangles share an edge, the vertices along it must be the same
//! on the device, whatever levels of detail meet there, and then no rasteriser can part them. For closed meshes pictures from random sides are searched too:
//! drawn without a ground, every pixel within the outline has to be covered, so a transparent pixel between covered ones of
//! all its eight neighbours is a crack.

use super::flight::{fly, zoom, Flight, Zoom, CHANGE};
use super::open::controls;
use super::render::{bounds, pattern};
use super::twin::{compare, Twin};
use crate::camera::{Camera, Projection};
use crate::check::flight::background_inside;
use crate::command::{print, print_json, silent, Failure, Global};
use crate::gpu::{Gpu, PatternFrame, PatternMethod, PatternScene as Drawn, PatternShow};
use crate::pattern::{CoarseMesh, Detail, NormalField};
use crate::scene::pattern::PatternScene;
use crate::timing::random::Random;
use serde::Serialize;

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
    #[serde(skip_serializing_if = "Option::is_none")]
    flight: Option<Flight>,
    #[serde(skip_serializing_if = "Option::is_none")]
    zoom: Option<Zoom>,
}

/// What is looked at.
pub struct Request<'a> {
    /// Level of the pattern.
    pub level: u32,
    /// Random views.
    pub views: u32,
    /// Seed of the views.
    pub seed: u64,
    /// Pixels.
    pub size: [u32; 2],
    /// Frames of a flight.
    pub fly: Option<u32>,
    /// Frames of a slow zoom.
    pub slow_zoom: Option<u32>,
    /// How the views are drawn.
    pub method: PatternMethod,
    /// Levels of detail of the views.
    pub detail: Option<Detail>,
    /// What the device makes coefficients of.
    pub coarse: Option<(&'a CoarseMesh, NormalField)>,
}

/// Measures and judges.
pub fn run(scene: &PatternScene, request: &Request, global: &Global) -> Result<(), Failure> {
    let controls = controls(scene);
    let bounds = bounds(&controls, scene.displacement.reach());
    let pattern = pattern(request.level, false)?;
    let drawn = Drawn {
        controls: &controls,
        evaluator: scene.evaluator,
        displacement: &scene.displacement,
        pattern: &pattern,
        coarse: request.coarse,
    };
    let aspect = f64::from(request.size[0]) / f64::from(request.size[1]);
    let projection = Projection::Perspective { fov: 30.0 };
    let mut frame = PatternFrame {
        width: request.size[0],
        height: request.size[1],
        camera: Camera::orbit(bounds, 30.0, 20.0, projection, aspect),
        bounds,
        show: PatternShow::Shaded,
        method: request.method,
        detail: request.detail,
        background: None,
        samples: 1,
    };
    let gpu = Gpu::new(&global.gpu())?;
    let diagonal = (bounds[1] - bounds[0]).length().max(f64::MIN_POSITIVE);
    // Levels of detail from near, from the side, and from afar.
    let looks = if request.detail.is_some() {
        &[(30.0, 20.0, 1.0), (120.0, -10.0, 0.5), (-75.0, 50.0, 4.0)][..]
    } else {
        &[(30.0, 20.0, 1.0)]
    };
    let mut twin = Twin::default();
    for &(yaw, pitch, far) in looks {
        let fitted = Camera::orbit(bounds, yaw, pitch, projection, aspect);
        frame.camera = fitted.at_distance((fitted.eye - fitted.target).length() * far);
        twin = twin.and(compare(&gpu, &drawn, &scene.mesh.triangles, &frame)?);
    }
    let worst = twin.worst / diagonal;

    let mut random = Random::new(request.seed);
    let mut prepared = gpu.prepare_pattern(&drawn, &frame)?;
    let mut crack_pixels = 0;
    for _ in 0..request.views {
        let (yaw, pitch) = (360.0 * random.unit(), 180.0 * random.unit() - 90.0);
        let fitted = Camera::orbit(bounds, yaw, pitch, projection, aspect);
        let distance = (fitted.eye - fitted.target).length() * (1.0 + random.unit());
        frame.camera = fitted.at_distance(distance);
        prepared.look(frame.camera, &drawn)?;
        prepared.run(true)?;
        let picture = prepared.pixels()?.into_picture(frame.width, frame.height);
        crack_pixels += background_inside(&picture, None, 1);
    }
    let flight = request.fly.map(|frames| fly(&gpu, &drawn, &frame, frames)).transpose()?;
    let zoom = request.slow_zoom.map(|frames| zoom(&gpu, &drawn, &frame, frames)).transpose()?;
    silent(&gpu)?;
    let report = Report {
        schema: "gradtess.pattern_check/1",
        scene: &scene.name,
        technique: "pattern",
        level: request.level,
        vertices: twin.vertices,
        max_error: worst,
        edges_shared: twin.shared,
        parted: twin.parted,
        views: request.views,
        crack_pixels,
        flight,
        zoom,
    };
    if global.json {
        print_json(&report)?;
    } else if !global.quiet {
        print(&format!(
            "{}: {} vertices, at most {:.3e} of the diagonal from the CPU's; {} shared edges, {} vertices parted; {} crack pixels in {} views\n",
            report.scene, report.vertices, worst, report.edges_shared, report.parted, crack_pixels, report.views
        ));
        if let Some(f) = &report.flight {
            print(&format!("    flight: {}\n", f.text()));
        }
        if let Some(z) = &report.zoom {
            print(&format!("    slow zoom: {}\n", z.text()));
        }
    }
    if worst.is_nan() || worst > LIMIT {
        return Err(Failure::short(format_args!(
            "{}: the device's positions are {worst:.3e} of the diagonal off; at most {LIMIT:e} is let pass",
            scene.name
        )));
    }
    let (parted, name) = (report.parted, &scene.name);
    let flown = report.flight.as_ref().map_or(0, |f| f.background_inside);
    if parted + crack_pixels + flown > 0 {
        return Err(Failure::short(format_args!(
            "{name}: {parted} vertices on shared edges differ, and {} pixels are cracks; none are let pass",
            crack_pixels + flown
        )));
    }
    match &report.zoom {
        Some(zoom) if zoom.change > CHANGE.max(zoom.change_at_one_level) => Err(Failure::short(format_args!(
            "{name}: a pixel jumps by {} of 255 in the slow zoom; at most {} is let pass",
            zoom.change,
            CHANGE.max(zoom.change_at_one_level)
        ))),
        _ => Ok(()),
    }
}
