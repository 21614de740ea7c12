//! Fig. 13: adaptive tessellation without cracks.

use crate::repro::sheet::cell;
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "blhk18-fig13",
    paper: "BLHK18",
    place: "Fig. 13",
    title: "Adaptive tessellation: even levels along T-sections, fractional ones elsewhere",
    make,
};

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let mut rows = Vec::new();
    for name in ["sections", "local_refinement"] {
        let scene = sheet.scene(&format!("ferguson/{name}.json"))?;
        for pixels in [40, 12] {
            let picture = format!("{name}_{pixels}.png");
            let out = sheet.file(&picture);
            let drawn = sheet
                .run(&format!("render {scene} -o {out} --show wire --pixels {pixels} --size 640x480 --samples 4"))?;
            sheet.picture(&picture, format!("{}, {pixels} pixels a segment", name.replace('_', " ")));
            rows.push(vec![
                name.to_owned(),
                pixels.to_string(),
                cell(&drawn, "/patches"),
                "1".into(),
                "NA".into(),
                "NA".into(),
            ]);
        }
        let checked = sheet.run(&format!("check {scene} --zooms 40 --pixels 6 --size 256x256"))?;
        let counts = ["/views", "/pixels_inside", "/crack_pixels"].map(|k| cell(&checked, k));
        rows.push(vec![
            name.to_owned(),
            "6".into(),
            "NA".into(),
            counts[0].clone(),
            counts[1].clone(),
            counts[2].clone(),
        ]);
    }
    sheet.caption(
        "Along a curve with T-sections all patches divide it in the same places: a whole and even number of segments in \
         the shortest part, multiples of it in longer ones. Other sides take the level that their length asks for, \
         fractions included.",
    );
    let columns = ["scene", "pixels_a_segment", "patches", "views", "pixels_inside", "background_pixels_inside"];
    sheet.table("cracks.csv", &columns, rows, "Background that shows inside, at the whole view and at zooms up to 1000")
}
