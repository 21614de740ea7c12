//! `gradtess stats` of a surface: its levels, and at how many vertices subdivided normals are needed.

use super::flags::SurfaceFlags;
use super::mesh::name;
use super::open::Surface;
use crate::command::open::milliseconds;
use crate::command::{print, print_json, Failure, Global};
use crate::surface::shade::shade;
use crate::surface::weight::{extraordinary, needing, Initial};
use serde::Serialize;
use std::time::Instant;

#[derive(Serialize)]
struct LevelCounts {
    level: u32,
    vertices: usize,
    faces: usize,
    edges: usize,
    sharp_edges: usize,
}

/// Extraordinary vertices of one valence on the last level, and how many vertices need N_S for their sake when blending
/// starts there (ZBK23 section 5).
#[derive(Serialize)]
struct Valence {
    edges: u32,
    boundary: bool,
    vertices: usize,
    needing_ring: usize,
    needing_inverse: usize,
}

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    scene: String,
    technique: &'static str,
    scheme: &'static str,
    vertices: usize,
    faces: usize,
    edges: usize,
    boundary_edges: u32,
    levels: Vec<LevelCounts>,
    /// Vertex and region pairs of the last level: its normals.
    wedges: usize,
    extraordinary: Vec<Valence>,
    /// Vertices of the last level whose N_S matters when blending starts there.
    needing_ring: usize,
    needing_inverse: usize,
    /// Vertices of the last level whose blend weight is not 0, by the flags.
    blended: usize,
    /// Subdivided normals computed for them, on all levels.
    normals_computed: usize,
    subdivide_ms: f64,
    shade_ms: f64,
}

/// Counts and prints.
pub fn run(surface: &Surface, flags: &SurfaceFlags, depth: u32, global: &Global) -> Result<(), Failure> {
    let start = Instant::now();
    let made = flags.subdivide(surface, depth, global)?;
    let subdivided = Instant::now();
    let settings = flags.settings()?;
    let shaded = shade(&made.levels, &made.scene.normals, &settings);
    let done = Instant::now();
    let last = &made.levels[depth as usize];
    let rules = |initial| crate::surface::weight::Rules { initial, ..settings.rules };
    let needing = |initial, of| needing(last, rules(initial), of);
    let valences = extraordinary(last, settings.rules.darts);
    let report = Report {
        schema: "gradtess.stats/1",
        scene: made.scene.name.clone(),
        technique: "surface",
        scheme: name(last.scheme),
        vertices: made.levels[0].vertices(),
        faces: made.levels[0].faces(),
        edges: made.levels[0].edges(),
        boundary_edges: surface.mesh.boundary_edges(),
        levels: made
            .levels
            .iter()
            .map(|level| LevelCounts {
                level: level.depth,
                vertices: level.vertices(),
                faces: level.faces(),
                edges: level.edges(),
                sharp_edges: level.sharpness.iter().filter(|s| **s > 0.0).count(),
            })
            .collect(),
        wedges: shaded.wedges.len(),
        extraordinary: valences
            .iter()
            .map(|(&(edges, boundary), &vertices)| Valence {
                edges,
                boundary,
                vertices,
                needing_ring: needing(Initial::Ring, Some((edges, boundary))),
                needing_inverse: needing(Initial::Inverse, Some((edges, boundary))),
            })
            .collect(),
        needing_ring: needing(Initial::Ring, None),
        needing_inverse: needing(Initial::Inverse, None),
        blended: shaded.blended_vertices(),
        normals_computed: shaded.normals_computed,
        subdivide_ms: milliseconds((subdivided - start).as_nanos()),
        shade_ms: milliseconds((done - subdivided).as_nanos()),
    };
    if global.json {
        return print_json(&report);
    }
    print(&text(&report));
    Ok(())
}

fn text(r: &Report) -> String {
    let mut out = format!(
        "{}: {} vertices, {} faces, {} edges of which {} on the boundary; {}\n",
        r.scene, r.vertices, r.faces, r.edges, r.boundary_edges, r.scheme
    );
    for l in &r.levels[1..] {
        out += &format!(
            "  level {}: {} vertices, {} faces, {} edges of which {} sharp\n",
            l.level, l.vertices, l.faces, l.edges, l.sharp_edges
        );
    }
    out += &format!(
        "  {} normals; {} vertices blended, {} subdivided normals computed; {:.3} ms subdivision, {:.3} ms shading\n",
        r.wedges, r.blended, r.normals_computed, r.subdivide_ms, r.shade_ms
    );
    out += &format!(
        "  blending from this level on needs N_S at {} vertices (ring) or {} (inverse limit):\n",
        r.needing_ring, r.needing_inverse
    );
    for v in &r.extraordinary {
        out += &format!(
            "    {} of valence {}{}: {} or {}\n",
            v.vertices,
            v.edges,
            if v.boundary { " on the boundary" } else { "" },
            v.needing_ring,
            v.needing_inverse
        );
    }
    out
}
