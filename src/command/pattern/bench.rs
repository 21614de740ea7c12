//! `gradtess bench --grid fig7`: frame rates and stored vertices of all draw methods, as BS05 Fig. 7.
//!
//! Every repeat draws each method for a while, the methods in an order of its own, so that what else the machine does meets
//! all of them. Rates are frames over wall time, from recording to the fence; ratios are of one repeat, and of them
//! the median counts.

use super::flags::method_name;
use super::render::bounds;
use crate::camera::{Camera, Projection};
use crate::command::{print, print_json, silent, Failure, Global};
use crate::gpu::{Gpu, PatternFrame, PatternMethod, PatternScene as Drawn, PatternShow, PreparedPattern};
use crate::pattern::{CoarseMesh, Control, Displacement, Evaluator, NormalField, RefinementPattern};
use crate::scene::write_atomically;
use crate::timing::random::Random;
use glam::DVec3;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;
use std::time::{Duration, Instant};

const METHODS: [PatternMethod; 4] =
    [PatternMethod::Static, PatternMethod::Draws, PatternMethod::Instanced, PatternMethod::Hardware];

/// Most bytes of a static buffer that is built; beyond, its row is NA.
const MOST_STATIC: usize = 3 << 29;

/// What is measured.
pub struct Request<'a> {
    /// Folder of `fig7.csv` and `fig7.json`.
    pub folder: &'a Path,
    /// Interleaved repeats.
    pub repeats: u32,
    /// Frames of each method in a repeat, at least.
    pub frames: u32,
    /// How long a repeat draws each method at least: a few short frames would measure what else goes on.
    pub least: Duration,
    /// Pixels.
    pub size: [u32; 2],
    /// Numbers of coarse triangles.
    pub counts: &'a [u32],
    /// Levels of the grid pattern.
    pub levels: &'a [u32],
    /// Seed of the order.
    pub seed: u64,
}

#[derive(Serialize)]
struct Row {
    level: u32,
    coarse_triangles: u32,
    method: &'static str,
    vertices_stored: usize,
    device_bytes: Option<u64>,
    /// Of each repeat; empty where the method cannot be measured.
    fps: Vec<f64>,
    median_fps: Option<f64>,
    /// Median over the repeats of the frame rate over that of the static buffer.
    over_static: Option<f64>,
    /// Why not.
    missing: Option<String>,
}

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    device: String,
    debug_build: bool,
    width: u32,
    height: u32,
    repeats: u32,
    /// Of each method in a repeat, at least.
    frames: u32,
    /// Time of each method in a repeat, at least.
    least_s: f64,
    rows: Vec<Row>,
}

/// A bumpy sheet of `count` triangles, two to a square.
fn coarse(count: u32) -> CoarseMesh {
    let columns = (f64::from(count) / 2.0).sqrt().ceil() as u32;
    let rows = count.div_ceil(2 * columns);
    let mut mesh = CoarseMesh::default();
    for j in 0..=rows {
        for i in 0..=columns {
            let (x, y) = (f64::from(i) / f64::from(columns), f64::from(j) / f64::from(columns));
            mesh.positions.push(DVec3::new(x, y, 0.05 * (7.0 * x).sin() * (5.0 * y).cos()));
        }
    }
    let all = (0..rows).flat_map(|j| (0..columns).map(move |i| j * (columns + 1) + i));
    let pair = |a: u32| [[a, a + 1, a + columns + 2], [a, a + columns + 2, a + columns + 1]];
    mesh.triangles = all.flat_map(pair).take(count as usize).collect();
    mesh.complete_normals();
    mesh
}

fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    (n > 0).then(|| 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]))
}

/// Measures, prints and writes.
pub fn run(request: &Request, global: &Global) -> Result<(), Failure> {
    let gpu = Gpu::new(&global.gpu())?;
    std::fs::create_dir_all(request.folder)
        .map_err(|e| Failure::machine(format_args!("{}: {e}", request.folder.display())))?;
    let mut report = Report {
        schema: "gradtess.fig7/1",
        device: gpu.device().name.clone(),
        debug_build: cfg!(debug_assertions),
        width: request.size[0],
        height: request.size[1],
        repeats: request.repeats,
        frames: request.frames,
        least_s: request.least.as_secs_f64(),
        rows: Vec::new(),
    };
    for &level in request.levels {
        for &count in request.counts {
            report.rows.extend(cell(&gpu, request, level, count)?);
            // What is done stays, should the rest be interrupted.
            write(request.folder, &report)?;
        }
    }
    silent(&gpu)?;
    if global.json {
        return print_json(&report);
    }
    if !global.quiet {
        print(&text(&report));
    }
    Ok(())
}

fn cell(gpu: &Gpu, request: &Request, level: u32, count: u32) -> Result<Vec<Row>, Failure> {
    let mesh = coarse(count);
    let evaluator = Evaluator::Linear;
    let controls: Vec<Control> =
        (0..mesh.triangles.len()).map(|t| Control::new(&mesh, t, evaluator, NormalField::Linear)).collect();
    let pattern = RefinementPattern::quad(level).map_err(Failure::input)?;
    let scene =
        Drawn { controls: &controls, evaluator, displacement: &Displacement::None, pattern: &pattern, coarse: None };
    let bounds = bounds(&controls, 0.0);
    let aspect = f64::from(request.size[0]) / f64::from(request.size[1]);
    let frame = |method| PatternFrame {
        width: request.size[0],
        height: request.size[1],
        camera: Camera::orbit(bounds, 20.0, 10.0, Projection::Perspective { fov: 30.0 }, aspect),
        bounds,
        show: PatternShow::Shaded,
        method,
        detail: None,
        background: Some([1.0; 4]),
        samples: 1,
    };
    let whole = controls.len() * pattern.weights.len();
    let mut ready: Vec<(usize, PreparedPattern)> = Vec::new();
    let mut rows = Vec::new();
    for (m, method) in METHODS.into_iter().enumerate() {
        let bytes = 48 * whole + 4 * controls.len() * pattern.indices.len();
        let made = if method == PatternMethod::Static && bytes > MOST_STATIC {
            Err(format!("its {bytes} bytes are too many"))
        } else {
            gpu.prepare_pattern(&scene, &frame(method)).map_err(|e| e.to_string())
        };
        let mut row = Row {
            level,
            coarse_triangles: count,
            method: method_name(method),
            vertices_stored: match method {
                PatternMethod::Static => whole,
                PatternMethod::Hardware => controls.len(),
                _ => pattern.weights.len(),
            },
            device_bytes: None,
            fps: Vec::new(),
            median_fps: None,
            over_static: None,
            missing: None,
        };
        match made {
            Ok(prepared) => {
                row.device_bytes = Some(prepared.bytes());
                prepared.run(false)?;
                ready.push((m, prepared));
            }
            Err(why) => row.missing = Some(why),
        }
        rows.push(row);
    }
    let mut random = Random::new(request.seed);
    for _ in 0..request.repeats {
        let mut order: Vec<usize> = (0..ready.len()).collect();
        random.shuffle(&mut order);
        for k in order {
            let (m, prepared) = &ready[k];
            let start = Instant::now();
            let mut frames = 0;
            while frames < request.frames || start.elapsed() < request.least {
                prepared.run(false)?;
                frames += 1;
            }
            rows[*m].fps.push(f64::from(frames) / start.elapsed().as_secs_f64());
        }
    }
    let baseline = rows[0].fps.clone();
    for row in &mut rows {
        row.median_fps = median(&row.fps);
        let ratios: Vec<f64> = row.fps.iter().zip(&baseline).map(|(a, b)| a / b).collect();
        row.over_static = median(&ratios);
    }
    Ok(rows)
}

fn write(folder: &Path, report: &Report) -> Result<(), Failure> {
    let json = serde_json::to_string_pretty(report).map_err(Failure::machine)?;
    write_atomically(&folder.join("fig7.json"), json.as_bytes())?;
    let mut csv = String::from("level,coarse_triangles,method,vertices_stored,device_bytes,median_fps,over_static\n");
    for r in &report.rows {
        let or_na = |x: Option<String>| x.unwrap_or("NA".to_owned());
        let _ = writeln!(
            csv,
            "{},{},{},{},{},{},{}",
            r.level,
            r.coarse_triangles,
            r.method,
            r.vertices_stored,
            or_na(r.device_bytes.map(|x| x.to_string())),
            or_na(r.median_fps.map(|x| x.to_string())),
            or_na(r.over_static.map(|x| x.to_string()))
        );
    }
    write_atomically(&folder.join("fig7.csv"), csv.as_bytes())?;
    Ok(())
}

fn text(report: &Report) -> String {
    let mut out = format!(
        "{}, {} x {}, {} interleaved repeats of {} frames and {} s at least\n{:>9} {:>9} {:>10} {:>10} {:>12} {:>10} {:>12}\n",
        report.device,
        report.width,
        report.height,
        report.repeats,
        report.frames,
        report.least_s,
        "grid",
        "triangles",
        "method",
        "vertices",
        "bytes",
        "fps",
        "over static"
    );
    for r in &report.rows {
        let fixed = |x: Option<f64>| x.map_or("NA".to_owned(), |x| format!("{x:.3}"));
        out += &format!(
            "{:>9} {:>9} {:>10} {:>10} {:>12} {:>10} {:>12}\n",
            format!("{0}x{0}", r.level),
            r.coarse_triangles,
            r.method,
            r.vertices_stored,
            r.device_bytes.map_or("NA".to_owned(), |x| x.to_string()),
            fixed(r.median_fps),
            fixed(r.over_static)
        );
        if let Some(why) = &r.missing {
            out += &format!("{:>9}   {why}\n", "");
        }
    }
    out
}
