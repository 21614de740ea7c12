//! What a user hands in: an input mesh, its colours, handles and hierarchical edits.
//!
//! A [`Scene`] is plain data. The readers in this room check grammar, index ranges and number
//! ranges and report file, line and column; whether the polygons form a manifold is found out in
//! `crate::mesh`.
//!
//! A file's technique is told by its content ([`technique()`]). For `subdivision`, two formats are read: the native JSON
//! ([`native`]) and the model format of the authors of ZHHK22 ([`authors`]); for `surface`, OBJ ([`surface`]).

pub mod authors;
pub mod copies;
mod error;
pub mod ferguson;
mod file;
mod json_document;
mod json_position;
pub mod native;
pub mod numbering;
pub mod pattern;
pub mod shapes;
pub mod surface;
pub mod svg;
mod technique;

pub use error::SceneError;
pub use file::{read_bounded, write_atomically, LARGEST_FILE};
pub use technique::{technique, Technique};

use glam::{DVec2, DVec4};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What happens at a boundary vertex with one face (valence 2), and at any one-face colour sector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum CornerRule {
    /// The vertex is interpolated (a sharp corner). The authors' tool does this.
    #[default]
    Sharp,
    /// The vertex is a crease vertex like its neighbours: `(a + 6 v + b) / 8`, limit `(a + 4 v + b) / 6`.
    Smooth,
}

/// Polygons as the user wrote them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InputMesh {
    /// One position a vertex, scene units, y up.
    pub positions: Vec<DVec2>,
    /// Corner lists of all faces, one after another: vertex numbers from 0.
    pub corners: Vec<u32>,
    /// `corners[face_start[f]..face_start[f + 1]]` are the corners of face `f`; `faces + 1` entries.
    pub face_start: Vec<u32>,
    /// Source line of each face (from 1), or empty when there is no file. For error messages only.
    pub face_line: Vec<u32>,
}

/// How a geometry edit writes its displacement (ZHHK22 3.3, Fig. 3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Frame {
    /// `dV = a e1 + b e2`, `e1` along the half-edge from the moved vertex, `e2` along the next spoke.
    Sector,
    /// Beyond the boundary: `a` is the angle over the boundary's angle, `b` is `|dV|^2 / (|e1| |e2|)` (eq. 2).
    Boundary,
}

/// One geometry edit: moves a control vertex of M^level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GeometryEdit {
    /// Level of the mesh the edit belongs to; 0 is the mesh after the ternary step.
    pub level: u32,
    /// Half-edge of M^level in the numbering of ZHHK22 App. A. It leaves the moved vertex
    /// ([`Frame::Sector`]), or is the interior twin of the boundary half-edge that leaves it ([`Frame::Boundary`]).
    pub half_edge: u64,
    /// Number of the moved vertex in M^level, when the file gives it. Only a key: the half-edge decides which vertex moves.
    pub vertex: Option<u64>,
    /// First local coordinate.
    pub a: f64,
    /// Second local coordinate.
    pub b: f64,
    /// Which local frame.
    pub frame: Frame,
}

/// One colour edit: sets the colour of one sector (half-edge) of a colour vertex of M^level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColourEdit {
    /// Level of the mesh the edit belongs to.
    pub level: u32,
    /// Half-edge of M^level (ZHHK22 App. A numbering); its origin is the vertex, its face the sector.
    pub half_edge: u64,
    /// Red, green, blue, alpha; sRGB, straight alpha, 0 to 1.
    pub colour: DVec4,
}

/// An absolute position that replaces one point made by the ternary step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Handle {
    /// Half-edge of the input mesh (file order; half-edge `k` of a face ends in the face's vertex `k`). For an edge
    /// point it may also be a boundary half-edge: those follow the interior ones in the order of their twins.
    pub half_edge: u32,
    /// Where the point goes, scene units.
    pub at: DVec2,
}

/// A whole scene for technique `subdivision`.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Scene {
    /// Short name for tables and pictures.
    pub name: String,
    /// The input mesh M.
    pub mesh: InputMesh,
    /// Corner rule for positions and colours.
    pub corners: CornerRule,
    /// Initial colour of every corner of M^0, per half-edge of the input mesh (the corner at the half-edge's
    /// ORIGIN in its face). Empty: all white, as the authors' tool starts.
    pub corner_colours: Vec<DVec4>,
    /// Input half-edges tagged sharp for colour (either side of an edge will do).
    pub sharp: Vec<u32>,
    /// Gradient handles: positions of the edge point at one third from the half-edge's origin.
    pub handles: Vec<Handle>,
    /// Positions of the face point near the half-edge's origin.
    pub face_points: Vec<Handle>,
    /// Geometry edits, at most one for each (level, vertex).
    pub geometry: Vec<GeometryEdit>,
    /// Colour edits, at most one for each (level, half-edge).
    pub colours: Vec<ColourEdit>,
    /// A picture under the mesh, to draw after.
    pub reference: Option<Reference>,
    /// Where the edits stand in their file.
    pub edit_lines: EditLines,
}

/// A picture that an editor shows under the mesh. It is no part of what is drawn otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// PNG file; a relative name counts from the scene's folder.
    pub file: String,
    /// Model rectangle x0, y0, x1, y1 that it fills, y1 at the top.
    pub rect: [f64; 4],
    /// 0 (hidden) to 1.
    pub opacity: f64,
    /// Whether it stays where it is.
    pub locked: bool,
}

/// Source line (from 1) of each edit, or empty when there is no file. For error messages only: two scenes are equal
/// wherever their edits were written.
#[derive(Clone, Debug, Default)]
pub struct EditLines {
    /// Of [`Scene::geometry`].
    pub geometry: Vec<u32>,
    /// Of [`Scene::colours`].
    pub colours: Vec<u32>,
}

impl PartialEq for EditLines {
    fn eq(&self, _: &EditLines) -> bool {
        true
    }
}

impl Scene {
    /// Reads the scene file at `path`. Its name is the file's stem unless the file gives one.
    ///
    /// # Errors
    /// The file cannot be read, or what [`Scene::parse`] reports.
    pub fn load(path: impl AsRef<Path>) -> Result<Scene, SceneError> {
        let path = path.as_ref();
        Scene::parse(&read_bounded(path)?, &path.display().to_string())
    }

    /// Reads a scene from `bytes`; `file` is what messages call them. The format is told by content.
    ///
    /// # Errors
    /// The first fault found, with file, line, column and what to do.
    pub fn parse(bytes: &[u8], file: &str) -> Result<Scene, SceneError> {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        let at_start = |what, fix| Err(SceneError::content(file, 1, 1, what, fix));
        let first = bytes.iter().copied().find(|b| !b.is_ascii_whitespace());
        let mut scene = match first {
            None => return at_start("the file is empty", "give a scene (scenes/triangle.json is a small one)"),
            Some(b'{') => native::read(bytes).map_err(|fault| fault.in_file(file))?,
            Some(b'<') => {
                return at_start(
                    "this is a scene of technique ferguson (an SVG mesh gradient)",
                    "give a subdivision scene",
                );
            }
            Some(_) if bytes.contains(&0) => {
                return at_start("this is no scene but binary data", "give a JSON scene or an .obj model");
            }
            Some(_) => authors::read(bytes).map_err(|fault| fault.in_file(file))?,
        };
        if scene.name.is_empty() {
            scene.name = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        }
        Ok(scene)
    }

    /// Writes the scene to `path` as native JSON, which holds everything.
    ///
    /// # Errors
    /// [`SceneError::Write`]; an older file at `path` stays as it was.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), SceneError> {
        write_atomically(path.as_ref(), native::write(self).as_bytes())
    }

    /// Writes the scene to `path` in the authors' format and returns what that format could not hold, one line each.
    ///
    /// # Errors
    /// [`SceneError::Format`] when the scene cannot be written at all, see [`authors::write`]; [`SceneError::Write`].
    pub fn save_authors(&self, path: impl AsRef<Path>) -> Result<Vec<String>, SceneError> {
        let path = path.as_ref();
        let written = authors::write(self).map_err(|(what, fix)| SceneError::Format {
            file: path.display().to_string(),
            what,
            fix,
        })?;
        write_atomically(path, written.text.as_bytes())?;
        Ok(written.losses)
    }
}
