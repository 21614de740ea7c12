//! `gradtess convert`: between scene formats, and to drawings of patches (SVG, PDF).

use super::ferguson::convert::{self, drawing, page};
use super::open::{Loaded, Subject};
use super::{print_json, Failure, Global};
use crate::patch::build::build;
use crate::patch::points::Irregular;
use crate::refine::Options;
use crate::subdiv::index_map::IndexMap;
use crate::vector::layers::components;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// Arguments of `convert`.
#[derive(Args)]
pub struct Convert {
    /// Scene to read
    input: String,
    /// File to write: .json (everything), .obj (the authors' format), .svg or .pdf (patches as a drawing)
    output: PathBuf,
    /// PDF: compose transparency onto white paper, so that the page has none (PDF/X-1a, PDF/A-1)
    #[arg(long)]
    flatten: bool,
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
        let pdf = self.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("pdf"));
        if self.flatten && !pdf {
            let what = self.output.display();
            return Err(Failure::input(format_args!("{what}: --flatten is for PDF pages; name the file *.pdf")));
        }
        let (scene, losses) = match Subject::open(&self.input, global)? {
            Subject::Subdivision(loaded) => (loaded.scene.name.clone(), self.subdivision(*loaded, global)?),
            Subject::Ferguson(mesh) => {
                (mesh.mesh.name.clone(), convert::run(&mesh, &self.output, self.flatten, global)?)
            }
            other => return Err(other.refused(&self.input)),
        };
        let output = self.output.display().to_string();
        for loss in &losses {
            global.warn(format_args!("{output}: {loss}"));
        }
        if global.json {
            print_json(&Report { schema: "gradtess.convert/1", scene, output, losses })?;
        }
        Ok(())
    }

    /// Writes a subdivision gradient mesh; what is lost, one sentence each.
    fn subdivision(&self, mut loaded: Loaded, global: &Global) -> Result<Vec<String>, Failure> {
        // Edits that do not fit the mesh are an error here, not in whatever reads the result.
        loaded.refine_check()?;
        let map = IndexMap::new(&loaded.mesh);
        for e in loaded.scene.geometry.iter_mut().filter(|e| e.vertex.is_none()) {
            e.vertex = vertex_of(&map, e);
        }
        let table = |loaded: &Loaded| -> Result<_, Failure> {
            Ok(build(&loaded.refine(Options::default())?, Irregular::Gregory))
        };
        match self.output.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("json") => Ok(loaded.scene.save(&self.output).map(|()| Vec::new())?),
            Some("obj") => Ok(loaded.scene.save_authors(&self.output)?),
            Some("svg") => drawing(&table(&loaded)?, None, &self.output, global),
            Some("pdf") => {
                let table = table(&loaded)?;
                page(&table, &components(&table), &loaded.scene.name, &self.output, self.flatten, global)
            }
            _ => {
                let what = self.output.display();
                Err(Failure::input(format_args!("{what}: unknown format; name the file *.json, *.obj, *.svg or *.pdf")))
            }
        }
    }
}

/// Number of the vertex that an edit moves.
fn vertex_of(map: &IndexMap, e: &crate::scene::GeometryEdit) -> Option<u64> {
    let beyond = map.boundary_twin_app_a(e.level, e.half_edge);
    let slot = map.from_app_a(e.level, beyond.unwrap_or(e.half_edge))?;
    let leaves = beyond.is_none() && e.frame == crate::scene::Frame::Sector;
    Some(map.vertex(e.level, if leaves { slot } else { map.next(e.level, slot) }))
}
