//! `gradtess mesh`: the whole M^L after edits, in the numbering of the paper's Appendix A.

use super::open::Subject;
use super::surface::flags::SurfaceFlags;
use super::{print, print_json, surface, Failure, Global};
use crate::refine::{Mode, Options, Rules};
use crate::scene::write_atomically;
use crate::subdiv::index_map::IndexMap;
use clap::Args;
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

/// Arguments of `mesh`.
#[derive(Args)]
pub struct Mesh {
    /// Scene file
    scene: String,
    /// Subdivision level; 0 is the mesh after the ternary step
    #[arg(long, value_name = "L")]
    level: u32,
    /// OBJ file to write: positions with the colour of one corner each, faces
    #[arg(short, long, value_name = "OUT.obj")]
    output: Option<PathBuf>,
    #[command(flatten)]
    surface: SurfaceFlags,
}

/// M^L. Half-edge arrays hold the interior half-edges, then (targets, next, twin, sharp) the boundary ones.
#[derive(Serialize)]
struct Report {
    schema: &'static str,
    scene: String,
    level: u32,
    vertices: Vec<[f64; 2]>,
    /// Vertices of each face; the k-th half-edge of a face ends in its k-th vertex.
    faces: Vec<Vec<u64>>,
    face_first_half_edge: Vec<u64>,
    half_edge_target: Vec<u64>,
    half_edge_next: Vec<u64>,
    half_edge_twin: Vec<u64>,
    half_edge_face: Vec<u64>,
    half_edge_sharp: Vec<bool>,
    /// Colour of the corner at each interior half-edge's origin: r, g, b, a.
    half_edge_colour: Vec<[f64; 4]>,
}

impl Mesh {
    /// Builds the level and writes it.
    pub fn run(&self, global: &Global) -> Result<(), Failure> {
        self.check_output()?;
        let loaded = match Subject::open(&self.scene, global)? {
            Subject::Subdivision(loaded) => loaded,
            Subject::Surface(surface) => {
                return surface::mesh::run(&surface, &self.surface, self.level, self.output.as_deref(), global)
            }
            other => return Err(other.refused(&self.scene)),
        };
        self.surface.refuse()?;
        let refinement = loaded.refine(Options { rules: Rules::Gradtess, mode: Mode::Global(self.level) })?;
        let level = refinement.levels.last().ok_or_else(|| Failure::machine("no level was made"))?;
        let map = IndexMap::new(&loaded.mesh);
        let l = self.level;
        let (interior, boundary) = (map.half_edges(l), map.boundary_half_edges(l));
        let (n, all) = (interior as usize, (interior + boundary) as usize);
        let mut r = Report {
            schema: "gradtess.mesh/1",
            scene: loaded.scene.name.clone(),
            level: l,
            vertices: vec![[0.0; 2]; level.vertices()],
            faces: vec![Vec::new(); level.faces()],
            face_first_half_edge: vec![0; level.faces()],
            half_edge_target: vec![0; all],
            half_edge_next: vec![0; all],
            half_edge_twin: vec![0; all],
            half_edge_face: vec![0; n],
            half_edge_sharp: vec![false; all],
            half_edge_colour: vec![[0.0; 4]; n],
        };
        let slot = |h: u32| match l {
            0 => u64::from(h),
            _ => 4 * level.face[level.face_of(h) as usize] + u64::from(h & 3),
        };
        // Local half-edges to App. A numbers, once: every array below is filled by them.
        let number: Vec<u64> = (0..level.half_edges() as u32).map(|h| map.to_app_a(l, slot(h))).collect();
        let vertex: Vec<u64> = {
            let mut vertex = vec![u64::MAX; level.vertices()];
            for h in 0..level.half_edges() as u32 {
                let v = &mut vertex[level.origin[h as usize] as usize];
                if *v == u64::MAX {
                    *v = map.vertex(l, slot(h));
                }
            }
            vertex
        };
        for h in 0..level.half_edges() as u32 {
            let (id, v) = (number[h as usize] as usize, level.origin[h as usize] as usize);
            let p = level.value[v].p;
            r.vertices[vertex[v] as usize] = [p.x, p.y];
            r.half_edge_target[id] = vertex[level.target(h) as usize];
            r.half_edge_next[id] = number[level.next(h) as usize];
            r.half_edge_face[id] = map.face_app_a(l, slot(h));
            r.half_edge_sharp[id] = level.colour_border(h);
            r.half_edge_colour[id] = level.corner_colour(h).to_array();
            match level.across(h) {
                Some(t) => r.half_edge_twin[id] = number[t as usize],
                None => {
                    let b = map.boundary_app_a(l, slot(h));
                    r.half_edge_twin[id] = b;
                    let b = b as usize;
                    r.half_edge_twin[b] = id as u64;
                    r.half_edge_target[b] = vertex[v];
                    r.half_edge_sharp[b] = true;
                    // The boundary goes on with the boundary half-edge that leaves the origin of h.
                    let mut spoke = h;
                    while let Some(s) = level.spoke_after(spoke) {
                        spoke = s;
                    }
                    r.half_edge_next[b] = map.boundary_app_a(l, slot(level.prev(spoke)));
                }
            }
        }
        for f in 0..level.faces() as u32 {
            let first = level.first(f);
            let id = map.face_app_a(l, slot(first)) as usize;
            r.face_first_half_edge[id] = number[first as usize];
            r.faces[id] = level.of_face(f).map(|h| vertex[level.target(h) as usize]).collect();
        }
        self.write(&r, global)
    }

    fn check_output(&self) -> Result<(), Failure> {
        match &self.output {
            Some(path) if path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("obj")) => {
                Err(Failure::input(format_args!("{}: only OBJ is written; name the file *.obj", path.display())))
            }
            _ => Ok(()),
        }
    }

    fn write(&self, r: &Report, global: &Global) -> Result<(), Failure> {
        if let Some(path) = &self.output {
            write_atomically(path, obj(r).as_bytes())?;
        }
        if global.json {
            return print_json(r);
        }
        if !global.quiet {
            print(&format!(
                "{} level {}: {} vertices, {} faces, {} half-edges of which {} on the boundary\n",
                r.scene,
                r.level,
                r.vertices.len(),
                r.faces.len(),
                r.half_edge_target.len(),
                r.half_edge_target.len() - r.half_edge_face.len()
            ));
        }
        Ok(())
    }
}

fn obj(r: &Report) -> String {
    let mut colour = vec![[1.0; 4]; r.vertices.len()];
    for id in 0..r.half_edge_colour.len() {
        // The half-edge before this one ends where this one starts.
        colour[r.half_edge_target[id] as usize] = r.half_edge_colour[r.half_edge_next[id] as usize];
    }
    let mut out = format!("# {} level {}\n", r.scene, r.level);
    for (v, c) in r.vertices.iter().zip(&colour) {
        let _ = writeln!(out, "v {} {} 0 {} {} {}", v[0], v[1], c[0], c[1], c[2]);
    }
    for f in &r.faces {
        out += "f";
        for v in f {
            let _ = write!(out, " {}", v + 1);
        }
        out += "\n";
    }
    out
}
