//! Fig. 6: a mesh of two by three patches, as this program draws it.

use super::{difference, variant};
use crate::repro::{Figure, ReproError, Sheet};
use serde_json::json;

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "blhk18-fig6",
    paper: "BLHK18",
    place: "Fig. 6",
    title: "The same 2 x 3 mesh by different blending: ours, and bilinear as SVG and PDF have it",
    make,
};

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let mut rows = Vec::new();
    for (name, words) in [("g1", "the paper's function"), ("linear", "bilinear, as in Inkscape, SVG and PDF")] {
        let file = variant(sheet, "ferguson/colour_spaces.json", &format!("{name}.json"), &[("blend", json!(name))])?;
        let picture = format!("{name}.png");
        let out = sheet.file(&picture);
        sheet.run(&format!("render {file} -o {out} --size 480x320 --pixels 1"))?;
        sheet.picture(&picture, words);
    }
    let (most, differ) = difference(&sheet.read_picture("g1.png")?, &sheet.read_picture("linear.png")?);
    rows.push(vec!["g1".to_owned(), "linear".to_owned(), most.to_string(), differ.to_string()]);
    sheet.caption(
        "The paper sets other programs beside its own; only our side can be drawn here. Bilinear colour stands for the \
         packages that blend linearly. Handles are where they are by default, so all patches are squares.",
    );
    let columns = ["a", "b", "greatest_difference_255", "pixels_that_differ"];
    sheet.table("difference.csv", &columns, rows, "How far the two kinds of blending are apart")
}
