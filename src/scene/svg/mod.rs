//! SVG 2 mesh gradients: import of every spelling that occurs (`meshgradient`, `meshGradient`, `mesh`), and export.
//!
//! Rules of the working draft of 2018 (w3c/svgwg, pservers): edges run clockwise, each stop has the edge's path and the
//! colour of the corner where it begins, what a neighbour has said already is left out. Departures that drawings have are
//! read too: Inkscape's `tensor` points and `gradientTransform`, closing points left out, colours in `style` attributes and
//! style sheets.
//!
//! SVG's y axis points down and a scene's up, so y changes its sign on the way in and out.

mod gradient;
mod outline;
mod paint;
mod patches;
mod shape;
mod style;
mod write;
mod xml;

pub use write::{grids, write};

use crate::ferguson::Mesh;
use crate::scene::error::Fault;

/// All mesh gradients of a drawing as one mesh, each where the shapes that it fills put it. Notes say what was left out.
pub(super) fn read(bytes: &[u8]) -> Result<(Mesh, Vec<String>), Fault> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let valid = String::from_utf8_lossy(&bytes[..error.valid_up_to()]);
        Fault::new(
            crate::scene::json_position::line_column(&valid, valid.len()),
            "this is not UTF-8",
            "save the drawing as UTF-8",
        )
    })?;
    let mut root = xml::parse(text)?;
    let note = style::cascade(text, &mut root)?;
    let (mesh, mut notes) = gradient::read(text, &root)?;
    notes.extend(note);
    Ok((mesh, notes))
}
