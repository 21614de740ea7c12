//! `gradtess bench` of surfaces: uniform levels against adaptive patches, at their errors.
//!
//! Pictures of both are compared with one of patches isolated far beyond what a pixel shows: which pixels only one of
//! them covers, and the angle between N_L where both do. N_L is that of the limit surface for all, so that the angle is
//! the error of what is drawn between vertices, not of another definition. Times are medians over repeats, the rows in
//! turns.
//!
//! *Computed* are all vertices and control points that the CPU works out for drawing: of uniform levels the vertices of the
//! last one (those before are not counted); of patches the vertices that subdivision makes, on all levels and padding included,
//! and the few control points that the scene's box needs. *Vertices* are what lies on the device: of patches their control
//! points, which the device makes itself by stencils; the CPU chooses the weights, which is part of its time. The share that
//! is printed last is of what is computed.

use super::flags::SurfaceFlags;
use super::open::Surface;
use crate::camera::{Camera, Projection};
use crate::command::{print, print_json, silent, Failure, Global};
use crate::gpu::{Gpu, SolidFrame, SolidNormals, SolidShow, Tessellation};
use crate::patch::solid::{Part, Primitive, Segments, SolidTable};
use crate::scene::surface::SurfaceScene;
use crate::scene::write_atomically;
use crate::surface::adaptive::{subdivide, Depth};
use crate::surface::drawing;
use crate::surface::level::Level;
use crate::surface::patches::{first_level, of_parts};
use crate::surface::refine::refine;
use crate::surface::shade::{limit_positions, shade, Settings};
use crate::threads;
use crate::timing::triangles::triangle;
use glam::DVec3;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

/// What is measured.
pub struct Request<'a> {
    /// Folder of `surface.csv` and `surface.json`.
    pub folder: &'a Path,
    /// Repeats of the times.
    pub repeats: u32,
    /// Pixels across and down.
    pub size: u32,
    /// Deepest uniform level.
    pub level: u32,
}

/// Levels of patches after the first, and segments on level 0.
const ADAPTIVE: [(u32, u32); 6] = [(0, 16), (0, 32), (1, 16), (1, 32), (2, 32), (3, 32)];

/// Sides to look from: yaw and pitch.
const VIEWS: [[f64; 2]; 4] = [[30.0, 20.0], [120.0, -10.0], [210.0, 35.0], [300.0, 5.0]];

/// CPU time that the authors' tool takes for Spot at level 4 with normals and weights, ms, one core (of a machine like
/// those that this is developed on).
const TOOL_MS: f64 = 260.0;

#[derive(Clone, Serialize)]
struct Row {
    scene: String,
    /// Whether it is of patches.
    adaptive: bool,
    level: u32,
    /// Patches: segments on level 0, halved on each further level.
    segments: Option<u32>,
    /// Uniform levels: whether vertices are moved to the limit.
    limit: bool,
    /// Vertices that subdivision computed: of patches over all levels, of uniform ones on the last.
    computed_vertices: usize,
    /// Control points that the CPU computed; the device makes all of them.
    computed_points: usize,
    /// Vertices or control points on the device.
    device_vertices: usize,
    device_bytes: u64,
    /// Weights of control points.
    stencil_terms: usize,
    /// Bytes that stencils and what they weigh take on the device until control points are made.
    stencil_bytes: u64,
    patches: usize,
    triangles: u64,
    /// From the control mesh to the arrays of the device, medians.
    subdivide_ms: f64,
    shade_ms: f64,
    total_ms: f64,
    /// Wall time of a frame, median.
    frame_ms: f64,
    /// Pixels that only one picture covers, per thousand of those of the limit.
    silhouette_permille: f64,
    normal_mean_degrees: f64,
    /// Share of pixels off by more than a degree, per cent.
    normal_over_1_percent: f64,
}

/// The patches that have no more error than the deepest uniform level and the fewest vertices computed.
#[derive(Clone, Serialize)]
struct Match {
    scene: String,
    uniform_level: u32,
    level: u32,
    segments: u32,
    /// Vertices and control points computed on the CPU, per cent of the uniform level's.
    computed_percent: f64,
}

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    device: String,
    debug_build: bool,
    size: u32,
    views: usize,
    repeats: u32,
    rows: Vec<Row>,
    matches: Vec<Match>,
}

impl Row {
    /// Vertices and control points that the CPU computed.
    fn computed(&self) -> usize {
        self.computed_vertices + self.computed_points
    }
}

struct Made {
    table: SolidTable,
    computed: usize,
    computed_points: usize,
    patches: usize,
    triangles: u64,
    subdivide_ms: f64,
    shade_ms: f64,
}

fn since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

fn uniform(control: &Level, scene: &SurfaceScene, settings: &Settings, level: u32, limit: bool) -> Made {
    // The cores are called once for all steps.
    threads::crew(control.vertices() << (2 * level), || uniform_level(control, scene, settings, level, limit))
}

fn uniform_level(control: &Level, scene: &SurfaceScene, settings: &Settings, level: u32, limit: bool) -> Made {
    let start = Instant::now();
    let mut levels = vec![control.clone()];
    for k in 0..level as usize {
        levels.push(refine(&levels[k]));
    }
    let subdivide_ms = since(start);
    let start = Instant::now();
    let shaded = shade(&levels, &scene.normals, settings);
    let last = &levels[level as usize];
    let limits = limit.then(|| limit_positions(last));
    let positions = limits.as_ref().unwrap_or(&last.position);
    let table = drawing::triangles(last, &shaded, positions, &shaded.blended);
    let shade_ms = since(start);
    // Pictures show N_L.
    drop(table);
    let table = drawing::triangles(last, &shaded, positions, &shaded.geometric);
    let triangles = table.parts.iter().map(|p| u64::from(p.count)).sum();
    Made { table, computed: last.vertices(), computed_points: 0, patches: 0, triangles, subdivide_ms, shade_ms }
}

fn adaptive(control: &Level, scene: &SurfaceScene, settings: &Settings, last: u32, segments: Segments) -> Made {
    let start = Instant::now();
    let parts = subdivide(control, &scene.normals, settings, Depth::adaptive(last, settings));
    let subdivide_ms = since(start);
    let start = Instant::now();
    let patches = of_parts(&parts);
    let (around, computed_points) = patches.bounds();
    let table = drawing::patches(&patches, around);
    let shade_ms = since(start);
    let of_part = |p: &Part| {
        let n = u64::from(segments.at(p.level));
        // Beside finer patches a few more.
        let of_one = match p.primitive {
            Primitive::Quartic | Primitive::QuarticGregory | Primitive::QuarticTransition => triangle([n; 3], n),
            _ => 2 * n * n,
        };
        of_one * u64::from(p.count)
    };
    Made {
        triangles: table.parts.iter().map(of_part).sum(),
        computed: parts.iter().map(|p| p.computed).sum(),
        computed_points,
        patches: patches.len(),
        table,
        subdivide_ms,
        shade_ms,
    }
}

/// N_L in every pixel, zero on background; one picture a view.
fn pictures(
    gpu: &Gpu,
    table: &SolidTable,
    segments: Segments,
    request: &Request,
    around: [DVec3; 2],
) -> Result<(Vec<Vec<DVec3>>, f64), Failure> {
    let camera = |[yaw, pitch]: [f64; 2]| Camera::orbit(around, yaw, pitch, Projection::Perspective { fov: 30.0 }, 1.0);
    let frame = SolidFrame {
        width: request.size,
        height: request.size,
        camera: camera(VIEWS[0]),
        show: SolidShow::Normals,
        stripes: 1.0,
        background: None,
        samples: 1,
        tessellation: Tessellation { segments, normals: SolidNormals::Geometric, power: 1.0 },
    };
    let mut prepared = gpu.prepare_solid(table, &frame)?;
    let mut out = Vec::new();
    let mut times = Vec::new();
    for view in VIEWS {
        prepared.look(camera(view), table);
        prepared.run(true)?;
        let floats = prepared.floats()?;
        out.push(
            floats
                .chunks_exact(4)
                .map(|p| match p[3] > 0.0 {
                    true => DVec3::new(p[0].into(), p[1].into(), p[2].into()) * 2.0 - 1.0,
                    false => DVec3::ZERO,
                })
                .collect(),
        );
        for _ in 0..request.repeats.min(5) {
            let start = Instant::now();
            prepared.run(false)?;
            times.push(since(start));
        }
    }
    Ok((out, median(&mut times)))
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n == 0 {
        return f64::NAN;
    }
    0.5 * (values[(n - 1) / 2] + values[n / 2])
}

/// Silhouette per thousand, mean angle, per cent of pixels over a degree.
fn compare(drawn: &[Vec<DVec3>], limit: &[Vec<DVec3>]) -> [f64; 3] {
    let (mut covered, mut both, mut odd, mut sum, mut over) = (0u64, 0u64, 0u64, 0.0, 0u64);
    for (a, b) in drawn.iter().flatten().zip(limit.iter().flatten()) {
        let here = [*a != DVec3::ZERO, *b != DVec3::ZERO];
        covered += u64::from(here[1]);
        odd += u64::from(here[0] != here[1]);
        if here == [true; 2] {
            let angle = a.angle_between(*b).to_degrees();
            both += 1;
            sum += angle;
            over += u64::from(angle > 1.0);
        }
    }
    let part = |n: u64, of: u64| n as f64 / of.max(1) as f64;
    [1000.0 * part(odd, covered), sum / both.max(1) as f64, 100.0 * part(over, both)]
}

/// Measures, prints and writes.
pub fn run(
    scenes: &[(String, Surface)],
    flags: &SurfaceFlags,
    request: &Request,
    global: &Global,
) -> Result<(), Failure> {
    let settings = flags.settings()?;
    let gpu = Gpu::new(&global.gpu())?;
    std::fs::create_dir_all(request.folder)
        .map_err(|e| Failure::machine(format_args!("{}: {e}", request.folder.display())))?;
    let mut report = Report {
        schema: "gradtess.surface_bench/1",
        device: gpu.device().name.clone(),
        debug_build: cfg!(debug_assertions),
        size: request.size,
        views: VIEWS.len(),
        repeats: request.repeats,
        rows: Vec::new(),
        matches: Vec::new(),
    };
    for (file, surface) in scenes {
        let made = flags.subdivide(surface, 0, global)?;
        let control = &made.levels[0];
        let first = first_level(control);
        let last = (first + 6).max(8);
        let limit = adaptive(control, &made.scene, &settings, last, Segments::Fixed(16));
        let around = limit.table.bounds;
        let (wanted, _) = pictures(&gpu, &limit.table, Segments::Fixed(16), request, around)?;
        let mut configs: Vec<(bool, u32, Option<u32>, bool)> =
            (2..=request.level).map(|level| (false, level, None, false)).collect();
        configs.push((false, request.level, None, true));
        configs.extend(ADAPTIVE.map(|(more, n)| (true, first + more, Some(n), false)));
        let mut times: Vec<[Vec<f64>; 3]> = configs.iter().map(|_| Default::default()).collect();
        let mut rows: Vec<Row> = Vec::new();
        for repeat in 0..request.repeats.max(1) {
            for (k, &(patches, level, segments, limit)) in configs.iter().enumerate() {
                let segments_rule = Segments::Base(segments.unwrap_or(1));
                let made = match patches {
                    true => adaptive(control, &made.scene, &settings, level, segments_rule),
                    false => uniform(control, &made.scene, &settings, level, limit),
                };
                times[k][0].push(made.subdivide_ms);
                times[k][1].push(made.shade_ms);
                times[k][2].push(made.subdivide_ms + made.shade_ms);
                if repeat > 0 {
                    continue;
                }
                let (drawn, frame_ms) = pictures(&gpu, &made.table, segments_rule, request, around)?;
                let [silhouette_permille, normal_mean_degrees, normal_over_1_percent] = compare(&drawn, &wanted);
                rows.push(Row {
                    scene: surface.scene.name.clone(),
                    adaptive: patches,
                    level,
                    segments,
                    limit,
                    computed_vertices: made.computed,
                    computed_points: made.computed_points,
                    device_vertices: made.table.points(),
                    device_bytes: made.table.bytes(),
                    stencil_terms: made.table.stencils.as_ref().map_or(0, |s| s.terms.len()),
                    stencil_bytes: made
                        .table
                        .stencils
                        .as_ref()
                        .map_or(0, |s| s.bytes() + size_of_val(made.table.vertices.as_slice()) as u64),
                    patches: made.patches,
                    triangles: made.triangles,
                    subdivide_ms: 0.0,
                    shade_ms: 0.0,
                    total_ms: 0.0,
                    frame_ms,
                    silhouette_permille,
                    normal_mean_degrees,
                    normal_over_1_percent,
                });
            }
        }
        for (row, times) in rows.iter_mut().zip(&mut times) {
            [row.subdivide_ms, row.shade_ms, row.total_ms] = times.each_mut().map(|t| median(t));
        }
        let found = matching(&rows, request);
        if !global.json && !global.quiet {
            print(&text(file, &rows, found.as_ref(), request));
        }
        report.rows.extend(rows);
        report.matches.extend(found);
        // What is done stays, should the rest be interrupted.
        write(request.folder, &report)?;
    }
    silent(&gpu)?;
    if global.json {
        return print_json(&report);
    }
    Ok(())
}

fn write(folder: &Path, report: &Report) -> Result<(), Failure> {
    let json = serde_json::to_string_pretty(report).map_err(Failure::machine)?;
    write_atomically(&folder.join("surface.json"), json.as_bytes())?;
    let mut csv = String::from(
        "scene,adaptive,level,segments,limit,computed_vertices,computed_points,device_vertices,device_bytes,stencil_terms,stencil_bytes,patches,triangles,subdivide_ms,shade_ms,total_ms,frame_ms,silhouette_permille,normal_mean_degrees,normal_over_1_percent\n",
    );
    for r in &report.rows {
        let _ = writeln!(
            csv,
            "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
            r.scene,
            r.adaptive,
            r.level,
            r.segments.map_or("NA".to_owned(), |n| n.to_string()),
            r.limit,
            r.computed_vertices,
            r.computed_points,
            r.device_vertices,
            r.device_bytes,
            r.stencil_terms,
            r.stencil_bytes,
            r.patches,
            r.triangles,
            r.subdivide_ms,
            r.shade_ms,
            r.total_ms,
            r.frame_ms,
            r.silhouette_permille,
            r.normal_mean_degrees,
            r.normal_over_1_percent
        );
    }
    write_atomically(&folder.join("surface.csv"), csv.as_bytes())?;
    Ok(())
}

fn name(r: &Row) -> String {
    match (r.adaptive, r.limit) {
        (true, _) => format!("patches to level {}, {} segments", r.level, r.segments.unwrap_or(0)),
        (false, true) => format!("level {}, at the limit", r.level),
        (false, false) => format!("level {}", r.level),
    }
}

fn uniform_of<'a>(rows: &'a [Row], request: &Request) -> Option<&'a Row> {
    rows.iter().find(|r| !r.adaptive && !r.limit && r.level == request.level)
}

fn matching(rows: &[Row], request: &Request) -> Option<Match> {
    let uniform = uniform_of(rows, request)?;
    let good = |r: &&Row| {
        r.adaptive
            && r.silhouette_permille <= uniform.silhouette_permille
            && r.normal_mean_degrees <= uniform.normal_mean_degrees
    };
    let fewest = rows.iter().filter(good).min_by_key(|r| r.computed())?;
    Some(Match {
        scene: fewest.scene.clone(),
        uniform_level: uniform.level,
        level: fewest.level,
        segments: fewest.segments.unwrap_or(0),
        computed_percent: 100.0 * fewest.computed() as f64 / uniform.computed().max(1) as f64,
    })
}

fn text(file: &str, rows: &[Row], found: Option<&Match>, request: &Request) -> String {
    let mut out = format!(
        "{file}: pictures of {0} x {0} from {1} sides against the limit's; {2} repeats\n{3:<34} {4:>9} {5:>9} {6:>9} {7:>8} {8:>8} {9:>8} {10:>11} {11:>8} {12:>6}\n",
        request.size,
        VIEWS.len(),
        request.repeats,
        "",
        "computed",
        "vertices",
        "triangles",
        "CPU ms",
        "shading",
        "frame",
        "silhouette",
        "normal",
        "> 1"
    );
    for r in rows {
        let _ = writeln!(
            out,
            "{:<34} {:>9} {:>9} {:>9} {:>8.3} {:>8.3} {:>8.1} {:>8.3} ‰ {:>7.4}° {:>5.2}%",
            name(r),
            r.computed(),
            r.device_vertices,
            r.triangles,
            r.total_ms,
            r.shade_ms,
            r.frame_ms,
            r.silhouette_permille,
            r.normal_mean_degrees,
            r.normal_over_1_percent
        );
    }
    let Some(uniform) = uniform_of(rows, request) else { return out };
    match found {
        Some(m) => {
            let _ = writeln!(
                out,
                "  patches to level {}, {} segments have no more error than {}, with {:.1} % of its vertices computed on the CPU",
                m.level,
                m.segments,
                name(uniform),
                m.computed_percent
            );
        }
        None => out += "  no patches have as little error as the last level\n",
    }
    if uniform.computed_vertices == 46_850 {
        let _ = writeln!(
            out,
            "  {} with normals and weights in {:.3} ms: {:.1} times as fast as the authors' tool ({TOOL_MS} ms)",
            name(uniform),
            uniform.total_ms,
            TOOL_MS / uniform.total_ms
        );
    }
    out
}
