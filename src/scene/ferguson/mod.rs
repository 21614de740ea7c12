//! Scenes of technique `ferguson`: the native JSON form of a [`Mesh`], and SVG mesh gradients.
//!
//! The JSON form has two faces that one reader knows. What people write lists quads by their points, with straight curves
//! between them unless handles are given, and then `operations`, done in order, such as splits. What the program writes
//! lists every curve, side and derivative, and reads back bit for bit.

mod document;
mod operations;
mod read;
mod write;

pub use write::write;

use crate::ferguson::Mesh;
use crate::scene::SceneError;
use std::path::Path;

/// Reads the scene in `bytes`, JSON or SVG; `file` is what messages call them. The second value are notes on what was
/// repaired or left out, one sentence each.
///
/// # Errors
/// The first fault found, with file, line, column and what to do.
pub fn parse(bytes: &[u8], file: &str) -> Result<(Mesh, Vec<String>), SceneError> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let svg = bytes.iter().copied().find(|b| !b.is_ascii_whitespace()) == Some(b'<');
    let read = if svg { crate::scene::svg::read(bytes) } else { read::read(bytes).map(|mesh| (mesh, Vec::new())) };
    let (mut mesh, notes) = read.map_err(|fault| fault.in_file(file))?;
    if mesh.name.is_empty() {
        mesh.name = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    }
    Ok((mesh, notes))
}
