//! `gradtess convert`: between the native JSON and the authors' model format.

use super::{open, print_json, Failure, Global};
use crate::subdiv::index_map::IndexMap;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// Arguments of `convert`.
#[derive(Args)]
pub struct Convert {
    /// Scene to read
    input: String,
    /// Scene to write: .json (everything) or .obj (the authors' format)
    output: PathBuf,
}

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    scene: String,
    output: String,
    /// What the written format cannot hold, one sentence each.
    losses: Vec<String>,
}

impl Convert {
    /// Reads, checks and writes.
    pub fn run(&self, global: &Global) -> Result<(), Failure> {
        let mut loaded = open::load(&self.input, global)?;
        // Edits that do not fit the mesh are an error here, not in whatever reads the result.
        loaded.refine_check()?;
        let map = IndexMap::new(&loaded.mesh);
        for e in loaded.scene.geometry.iter_mut().filter(|e| e.vertex.is_none()) {
            e.vertex = vertex_of(&map, e);
        }
        let losses = match self.output.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("json") => loaded.scene.save(&self.output).map(|()| Vec::new())?,
            Some("obj") => loaded.scene.save_authors(&self.output)?,
            _ => {
                let what = self.output.display();
                return Err(Failure::input(format_args!("{what}: unknown format; name the file *.json or *.obj")));
            }
        };
        let output = self.output.display().to_string();
        for loss in &losses {
            global.warn(format_args!("{output}: {loss}"));
        }
        if global.json {
            print_json(&Report { schema: "gradtess.convert/1", scene: loaded.scene.name, output, losses })?;
        }
        Ok(())
    }
}

/// Number of the vertex that an edit moves.
fn vertex_of(map: &IndexMap, e: &crate::scene::GeometryEdit) -> Option<u64> {
    let beyond = map.boundary_twin_app_a(e.level, e.half_edge);
    let slot = map.from_app_a(e.level, beyond.unwrap_or(e.half_edge))?;
    let leaves = beyond.is_none() && e.frame == crate::scene::Frame::Sector;
    Some(map.vertex(e.level, if leaves { slot } else { map.next(e.level, slot) }))
}
