//! `gradtess stats` of a surface: its control mesh.

use super::open::Surface;
use crate::command::{print, print_json, Failure, Global};
use serde::Serialize;

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    scene: String,
    technique: &'static str,
    vertices: usize,
    faces: usize,
    edges: u32,
    boundary_edges: u32,
}

/// Counts and prints.
pub fn run(surface: &Surface, global: &Global) -> Result<(), Failure> {
    let mesh = &surface.mesh;
    let report = Report {
        schema: "gradtess.stats/1",
        scene: surface.scene.name.clone(),
        technique: "surface",
        vertices: surface.scene.positions.len(),
        faces: surface.scene.faces(),
        edges: mesh.edges_before.last().copied().unwrap_or(0),
        boundary_edges: mesh.boundary_edges(),
    };
    if global.json {
        return print_json(&report);
    }
    print(&format!(
        "{}: {} vertices, {} faces, {} edges of which {} on the boundary\n",
        report.scene, report.vertices, report.faces, report.edges, report.boundary_edges
    ));
    Ok(())
}
