//! `gradtess mesh` of a surface: a level with its normals and blend weights.

use super::flags::SurfaceFlags;
use super::open::Surface;
use crate::command::{print, print_json, Failure, Global};
use crate::scene::write_atomically;
use crate::surface::level::{Level, Scheme};
use crate::surface::shade::{limit_positions, shade};
use glam::DVec3;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// A level. Numbers count from 0. A wedge is a vertex in one of its regions between sharp edges; normals are one a wedge.
#[derive(Serialize)]
struct Report<'a> {
    schema: &'static str,
    scene: &'a str,
    scheme: &'static str,
    level: u32,
    positions: &'a [DVec3],
    limit_positions: Vec<DVec3>,
    /// Vertices of each face.
    faces: Vec<&'a [u32]>,
    /// Wedges at the corners of each face.
    face_wedges: Vec<&'a [u32]>,
    wedge_vertex: Vec<u32>,
    /// N_L, unit.
    normal_geometric: &'a [DVec3],
    /// N_S, unit; zero where the weight is 0.
    normal_subdivided: &'a [DVec3],
    /// N_B, unit.
    normal_blended: &'a [DVec3],
    control_weight: &'a [f64],
    /// b, one a vertex.
    weight: &'a [f64],
    /// Pairs of vertices and the sharpness that is left; `null`: endless.
    sharp_edges: Vec<(u32, u32, f64)>,
}

/// Subdivides and prints or writes.
pub fn run(
    surface: &Surface,
    flags: &SurfaceFlags,
    depth: u32,
    output: Option<&Path>,
    global: &Global,
) -> Result<(), Failure> {
    let made = flags.subdivide(surface, depth, global)?;
    let shaded = shade(&made.levels, &made.scene.normals, &flags.settings()?);
    let level = &made.levels[depth as usize];
    let limits = limit_positions(level);
    let faces = |of: &'_ [u32]| -> Vec<Vec<u32>> {
        (0..level.faces()).map(|f| level.of_face(f).map(|h| of[h as usize]).collect()).collect()
    };
    if let Some(path) = output {
        let positions = if flags.limit { &limits } else { &level.position };
        let text = obj(&made.scene.name, level, positions, &shaded.wedges.of, &shaded.blended);
        write_atomically(path, text.as_bytes())?;
    }
    if global.json {
        let (vertices, wedges) = (faces(&level.origin), faces(&shaded.wedges.of));
        let lower = |h: &u32| {
            let t = level.twin[*h as usize];
            t != crate::mesh::NONE && *h < t && level.is_sharp(*h)
        };
        let sharp = |h: u32| {
            let s = level.sharpness[level.edge[h as usize] as usize];
            (level.origin[h as usize], level.target(h), s)
        };
        return print_json(&Report {
            schema: "gradtess.surface_mesh/1",
            scene: &made.scene.name,
            scheme: name(level.scheme),
            level: depth,
            positions: &level.position,
            limit_positions: limits,
            faces: vertices.iter().map(Vec::as_slice).collect(),
            face_wedges: wedges.iter().map(Vec::as_slice).collect(),
            wedge_vertex: shaded.wedges.first.iter().map(|&h| level.origin[h as usize]).collect(),
            normal_geometric: &shaded.geometric,
            normal_subdivided: &shaded.subdivided,
            normal_blended: &shaded.blended,
            control_weight: &shaded.control_weight,
            weight: &shaded.weight,
            sharp_edges: (0..level.half_edges() as u32).filter(lower).map(sharp).collect(),
        });
    }
    if !global.quiet {
        print(&format!(
            "{} level {depth} ({}): {} vertices, {} faces, {} edges, {} normals, {} vertices blended\n",
            made.scene.name,
            name(level.scheme),
            level.vertices(),
            level.faces(),
            level.edges(),
            shaded.wedges.len(),
            shaded.blended_vertices()
        ));
    }
    Ok(())
}

/// The scheme as the command line calls it.
pub fn name(scheme: Scheme) -> &'static str {
    match scheme {
        Scheme::CatmullClark => "catmull-clark",
        Scheme::Loop => "loop",
    }
}

/// OBJ with a normal a wedge and, where any is left, the sharpness of every face's edges (`fs`, ZBK23 3.5).
fn obj(title: &str, level: &Level, positions: &[DVec3], wedges: &[u32], normals: &[DVec3]) -> String {
    let mut out = format!("# {title} level {}\n", level.depth);
    for p in positions {
        let _ = writeln!(out, "v {} {} {}", p.x, p.y, p.z);
    }
    for n in normals {
        let _ = writeln!(out, "vn {} {} {}", n.x, n.y, n.z);
    }
    let inside = |h: u32| level.twin[h as usize] != crate::mesh::NONE && level.is_sharp(h);
    let sharp = (0..level.half_edges() as u32).any(inside);
    for f in 0..level.faces() {
        out += "f";
        let face = level.of_face(f);
        for h in face.clone() {
            let _ = write!(out, " {}//{}", level.origin[h as usize] + 1, wedges[h as usize] + 1);
        }
        if sharp {
            out += "\nfs";
            // The first digit is the edge into the last corner: it leaves the one before.
            let n = face.end - face.start;
            for k in 0..n {
                let h = face.start + (k + n - 2) % n;
                let s = if inside(h) { level.sharpness[level.edge[h as usize] as usize] } else { 0.0 };
                let _ = write!(out, " {s}");
            }
        }
        out += "\n";
    }
    out
}
