//! `gradtess stats` of a pattern scene: what is stored and drawn, by the pattern and as a whole refined mesh (BS05 Fig. 7).

use super::flags::evaluator_name;
use super::open::controls;
use crate::command::open::milliseconds;
use crate::command::{print, print_json, Failure, Global};
use crate::pattern::RefinementPattern;
use crate::scene::pattern::PatternScene;
use serde::Serialize;
use std::time::Instant;

/// Bytes of a triangle's coefficients on the device: 32 vectors of four floats.
pub const TRIANGLE_BYTES: usize = 512;
/// Bytes of a vertex of the refined mesh: position, normal and colour, each of four floats.
pub const VERTEX_BYTES: usize = 48;

#[derive(Serialize)]
struct Stored {
    /// What is drawn.
    way: &'static str,
    /// Vertices on the device, whatever they are drawn for.
    vertices_stored: usize,
    /// Vertices and indices.
    pattern_bytes: usize,
    /// Coefficients of the coarse triangles.
    attribute_bytes: usize,
    device_bytes: usize,
}

#[derive(Serialize)]
struct Report<'a> {
    schema: &'static str,
    scene: &'a str,
    technique: &'static str,
    evaluator: &'static str,
    level: u32,
    vertices: usize,
    triangles: usize,
    creases: usize,
    vertices_drawn: usize,
    triangles_drawn: usize,
    /// Misses of a vertex cache of 32 entries, over triangles.
    cache_misses: f64,
    stored: [Stored; 3],
    control_ms: f64,
}

/// Counts and prints.
pub fn run(scene: &PatternScene, level: u32, global: &Global) -> Result<(), Failure> {
    let start = Instant::now();
    let triangles = controls(scene).len();
    let control_ms = milliseconds(start.elapsed().as_nanos());
    let pattern = RefinementPattern::triangle(level).map_err(Failure::input)?;
    let grid = RefinementPattern::quad(level).map_err(Failure::input)?;
    let with = |way, pattern: &RefinementPattern| Stored {
        way,
        vertices_stored: pattern.weights.len(),
        pattern_bytes: pattern.bytes(),
        attribute_bytes: TRIANGLE_BYTES * triangles,
        device_bytes: pattern.bytes() + TRIANGLE_BYTES * triangles,
    };
    let whole = triangles * pattern.weights.len();
    let static_bytes = VERTEX_BYTES * whole + 4 * triangles * pattern.indices.len();
    let report = Report {
        schema: "gradtess.pattern_stats/1",
        scene: &scene.name,
        technique: "pattern",
        evaluator: evaluator_name(scene.evaluator),
        level,
        vertices: scene.mesh.positions.len(),
        triangles,
        creases: scene.mesh.tags.iter().filter(|tag| tag.is_crease()).count(),
        vertices_drawn: whole,
        triangles_drawn: triangles * pattern.triangles(),
        cache_misses: pattern.cache_misses(32),
        stored: [
            with("triangle pattern", &pattern),
            with("grid pattern", &grid),
            Stored {
                way: "static mesh",
                vertices_stored: whole,
                pattern_bytes: static_bytes,
                attribute_bytes: 0,
                device_bytes: static_bytes,
            },
        ],
        control_ms,
    };
    if global.json {
        return print_json(&report);
    }
    let r = &report;
    let mut out = format!(
        "{}: {} vertices, {} triangles, evaluator {}, {} vertices on creases, coefficients {:.3} ms\n    level {}: {} vertices and {} triangles drawn, {:.3} cache misses a triangle\n",
        r.scene,
        r.vertices,
        r.triangles,
        r.evaluator,
        r.creases,
        r.control_ms,
        r.level,
        r.vertices_drawn,
        r.triangles_drawn,
        r.cache_misses
    );
    for s in &r.stored {
        out += &format!(
            "    {:<17} {:>10} vertices stored, {:>12} bytes on the device\n",
            s.way, s.vertices_stored, s.device_bytes
        );
    }
    print(&out);
    Ok(())
}
