//! Scenes of technique `pattern` (BS05): a coarse mesh of triangles, how it is evaluated, and its displacement.
//!
//! Read from the native JSON, which may name an OBJ for its mesh, or from an OBJ with `st` lines, which tag vertices:
//!
//! ```text
//! st VERTEX TENSION SHARPNESS BIAS DX DY DZ
//! ```
//!
//! The vertex counts as in `f` lines; DX DY DZ is the deviation vector, 0 0 0 where no crease passes.

mod document;
mod height;
mod obj;
mod read;

use super::error::Fault;
use super::SceneError;
use crate::pattern::{CoarseMesh, Displacement, Evaluator, NormalField};
use std::path::Path;

/// A whole scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatternScene {
    /// Short name for tables and pictures.
    pub name: String,
    /// The coarse mesh; its normals are unit.
    pub mesh: CoarseMesh,
    /// What a triangle becomes.
    pub evaluator: Evaluator,
    /// Its normals.
    pub normal_field: NormalField,
    /// Displacement.
    pub displacement: Displacement,
    /// Level of the refinement pattern unless the command says otherwise.
    pub level: u32,
    /// Repairs made while reading, one line each.
    pub notes: Vec<String>,
}

/// Level of scenes that do not name one.
const LEVEL: u32 = 16;

impl PatternScene {
    /// Reads a scene from `bytes`; `file` is what messages call them, and where the files that it names are looked for.
    ///
    /// # Errors
    /// The first fault found, with file, line, column and what to do.
    pub fn parse(bytes: &[u8], file: &str) -> Result<PatternScene, SceneError> {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        let json = bytes.iter().find(|b| !b.is_ascii_whitespace()) == Some(&b'{');
        let stem = || Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let folder = Path::new(file).parent().unwrap_or(Path::new(""));
        let mut scene = if json {
            read::read(bytes, file, folder)?
        } else {
            let raw = obj::read(bytes).map_err(|fault| fault.in_file(file))?;
            let evaluator = if raw.mesh.tags.is_empty() { Evaluator::Pn } else { Evaluator::St };
            let place = raw.clone_places();
            let mut scene = PatternScene { evaluator, level: LEVEL, ..PatternScene::default() };
            raw.into_scene(&mut scene);
            complete(&mut scene, |triangle| place.triangle(triangle)).map_err(|fault| fault.in_file(file))?;
            scene
        };
        if scene.name.is_empty() {
            scene.name = stem();
        }
        Ok(scene)
    }
}

/// Completes normals, looks for what is wrong and says what was mended. `place`: line and column of a triangle.
fn complete(scene: &mut PatternScene, place: impl Fn(u32) -> (usize, usize)) -> Result<(), Fault> {
    let vertices = scene.mesh.positions.len();
    let (computed, lost) = scene.mesh.complete_normals();
    if computed > 0 {
        scene.notes.push(format!(
            "{computed} of {vertices} vertices have no normal; it was computed from the triangles around them"
        ));
    }
    if let Some(v) = lost.first() {
        scene.notes.push(format!(
            "{} vertices, the first is vertex {v}, have no triangle with an area; their normal is +z",
            lost.len()
        ));
    }
    let flat = scene.mesh.flat_triangles();
    if let Some(&t) = flat.first() {
        let (line, _) = place(t);
        scene.notes.push(format!("{} triangles have no area, the first is triangle {t} (line {line})", flat.len()));
    }
    let split = scene.mesh.split_positions();
    if split > 0 && scene.evaluator != Evaluator::Linear {
        scene.notes.push(format!("{split} positions have more than one normal; curved triangles part there"));
    }
    scene.mesh.check_tags().map_err(|e| {
        use crate::pattern::PatternError::{Tag, ThreeDeviations};
        let at = match &e {
            ThreeDeviations { triangle, .. } => place(*triangle),
            Tag { vertex, .. } => {
                let first = scene.mesh.triangles.iter().position(|t| t.contains(vertex));
                first.map_or((1, 1), |t| place(t as u32))
            }
            _ => (1, 1),
        };
        let text = e.to_string();
        let (what, fix) = text.split_once("; ").unwrap_or((&text, "correct the tag"));
        Fault::new(at, what, fix)
    })
}

/// Fans a polygon into triangles.
fn fan(corners: &[u32], mut add: impl FnMut([u32; 3])) {
    for k in 1..corners.len().saturating_sub(1) {
        add([corners[0], corners[k], corners[k + 1]]);
    }
}
