//! Scenes of technique `surface` (ZBK23): polygons in space with sharp edges and corners.
//!
//! Its reader takes OBJ with the authors' `fs` and `as` lines or Pixar's `t crease` and `t corner` tags; sharpness may
//! come from a `.sharp` file too ([`sharp`]).

mod obj;
mod sharp;
mod write;

pub use sharp::sharp;
pub use write::write;

use super::{CornerRule, InputMesh, SceneError};
use glam::{DVec2, DVec3};

/// Sharpness from which an edge or corner is sharp for ever, as in OpenSubdiv.
pub const INFINITE: f64 = 10.0;

/// A surface as the user wrote it.
#[derive(Clone, Debug, Default)]
pub struct SurfaceScene {
    /// Short name for tables and pictures.
    pub name: String,
    /// One position a vertex.
    pub positions: Vec<DVec3>,
    /// Corner lists of all faces, one after another: vertex numbers from 0.
    pub corners: Vec<u32>,
    /// `corners[face_start[f]..face_start[f + 1]]` are the corners of face `f`; `faces + 1` entries.
    pub face_start: Vec<u32>,
    /// Source line of each face, from 1.
    pub face_line: Vec<u32>,
    /// Source line of each vertex, from 1.
    pub vertex_line: Vec<u32>,
    /// Sharpness of the half-edge that ENDS in each corner (from the corner before); 0 smooth, [`INFINITE`] and more
    /// sharp for ever. The two halves of an edge may differ; the larger counts.
    pub edge_sharpness: Vec<f64>,
    /// Sharp edges given by their ends (Pixar's tags), with the line they stand in.
    pub creases: Vec<Crease>,
    /// Sharpness of each vertex; empty when none is sharp.
    pub corner_sharpness: Vec<f64>,
    /// Normal given at each corner, or zero; empty when the file has none.
    pub normals: Vec<DVec3>,
    /// What a boundary vertex with one face does; the authors' tool rounds it.
    pub boundary_corners: Option<CornerRule>,
    /// Repairs made while reading, one line each.
    pub notes: Vec<String>,
}

/// A sharp edge given by its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crease {
    /// Vertices from 0.
    pub ends: [u32; 2],
    /// Sharpness.
    pub sharpness: f64,
    /// Source line, from 1.
    pub line: u32,
}

impl SurfaceScene {
    /// Reads a surface from `bytes`; `file` is what messages call them.
    ///
    /// # Errors
    /// The first fault found, with file, line, column and what to do.
    pub fn parse(bytes: &[u8], file: &str) -> Result<SurfaceScene, SceneError> {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        let mut scene = obj::read(bytes).map_err(|fault| fault.in_file(file))?;
        scene.name = std::path::Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(scene)
    }

    /// Faces.
    pub fn faces(&self) -> usize {
        self.face_line.len()
    }

    /// The polygons alone, with places in the plane that mean nothing: half-edges do not ask where vertices are.
    pub fn polygons(&self) -> InputMesh {
        InputMesh {
            positions: self.positions.iter().map(|p| DVec2::new(p.x, p.y)).collect(),
            corners: self.corners.clone(),
            face_start: self.face_start.clone(),
            face_line: self.face_line.clone(),
        }
    }
}
