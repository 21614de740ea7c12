//! From the bytes of an OBJ surface to half-edges.

use crate::command::open::at_line;
use crate::command::{Failure, Global};
use crate::mesh::{self, HalfEdgeMesh, MeshError};
use crate::scene::surface::SurfaceScene;

/// A surface whose polygons are a manifold.
pub struct Surface {
    /// As the user named it.
    pub file: String,
    /// The scene.
    pub scene: SurfaceScene,
    /// Its half-edges.
    pub mesh: HalfEdgeMesh,
}

impl Surface {
    /// Reads a surface from the `bytes` of `file` and builds its half-edges; repairs are warned of.
    pub fn load(file: &str, bytes: &[u8], global: &Global) -> Result<Surface, Failure> {
        let scene = SurfaceScene::parse(bytes, file)?;
        let notes: Vec<String> = scene.notes.iter().map(|note| format!("{file}: {note}")).collect();
        warn_once(&notes, global);
        let mesh = polygons(file, &scene)?;
        Ok(Surface { file: file.to_owned(), scene, mesh })
    }
}

/// Warns of the first of `notes` and says how many more there are.
pub fn warn_once(notes: &[String], global: &Global) {
    match notes {
        [] => {}
        [note] => global.warn(note),
        [note, rest @ ..] => global.warn(format_args!("{note} (and {} more lines of this kind)", rest.len())),
    }
}

/// The half-edges of `scene`.
pub fn polygons(file: &str, scene: &SurfaceScene) -> Result<HalfEdgeMesh, Failure> {
    mesh::build(&scene.polygons()).map_err(|e| {
        let line = match &e {
            MeshError::UnusedVertex { vertex } => scene.vertex_line.get(*vertex as usize - 1),
            e => e.face().and_then(|f| scene.face_line.get(f as usize)),
        };
        at_line(file, line.copied().unwrap_or(1), &e, "correct the polygons")
    })
}
