//! Fig. 9: a dart.

use super::show::{self, ERROR_COLUMNS};
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-fig9",
    paper: "ZHHK22",
    place: "Fig. 9",
    title: "A sharp colour transition that ends in a dart",
    make,
};

/// Rule sets and refinement that a sharp feature is drawn by.
pub const WAYS: [(&str, &str); 3] = [
    ("rules authors", "--rules authors"),
    ("rules gradtess", ""),
    ("rules gradtess, isolated to level 3", "--isolate 3"),
];

/// Columns of [`compare`]'s rows.
pub fn columns() -> Vec<&'static str> {
    [&["scene", "drawn_by"][..], &ERROR_COLUMNS].concat()
}

/// A scene's surface, and its error by each of [`WAYS`].
pub fn compare(sheet: &mut Sheet, name: &str, scene: &str) -> Result<Vec<Vec<String>>, ReproError> {
    let words = name.replace('_', " ");
    show::picture(sheet, scene, name, "", &words)?;
    let mut rows = Vec::new();
    for (i, (way, flags)) in WAYS.iter().enumerate() {
        let cells = show::error(sheet, scene, &format!("{name}_error_{i}"), flags, &format!("{words}, {way}"))?;
        rows.push([words.clone(), (*way).to_owned()].into_iter().chain(cells).collect());
    }
    Ok(rows)
}

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let scene = sheet.scene("unit/sharp_dart.json")?;
    let mut rows = compare(sheet, "dart", &scene)?;
    if let Some(model) = sheet.model("Quad_edits.obj") {
        rows.extend(compare(sheet, "the_authors_quad", &model)?);
    }
    sheet.caption(
        "Colour does not blend across the sharp edge, and does so again past its end, the dart. The paper reports at most 0.067 % of \
         sqrt 3 for its example. The authors' rules draw the faces at a dart by one-sided bicubics, rules gradtess by Gregory patches where \
         the colours follow no bicubic. Rows that repeat say that isolation finds no irregular vertex.",
    );
    sheet.table("errors.csv", &columns(), rows, "Distance of the colour from the limit, per cent of sqrt 3")
}
