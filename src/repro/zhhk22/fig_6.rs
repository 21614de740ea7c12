//! Fig. 6: the regions that edits affect.

use super::show;
use crate::repro::sheet::number;
use crate::repro::{Figure, ReproError, Sheet};
use serde_json::json;

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-fig6",
    paper: "ZHHK22",
    place: "Fig. 6",
    title: "What a geometry edit and a colour edit affect",
    make,
};

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    // 108: leaves an inner vertex of M^1 that is a colour vertex too.
    let geometry = json!({"level": 1, "half_edge": 108, "a": 0.4, "b": 0.4});
    let colour = json!({"level": 1, "half_edge": 108, "colour": [0.85, 0.1, 0.6]});
    let colours: Vec<[f64; 3]> = (0..9).map(|i| [0.95 - 0.05 * f64::from(i), 0.9, 0.6 + 0.04 * f64::from(i)]).collect();
    let mut rows = Vec::new();
    for (list, edit, rings) in [("geometry", geometry, 2u32), ("colour", colour, 3)] {
        let scene = json!({"gradtess": 1, "builtin": "grid:2x2", "vertex_colours": colours, list: [edit]});
        let file = sheet.write(&format!("{list}.json"), &format!("{scene}\n"))?;
        let stats = sheet.run(&format!("stats {file}"))?;
        show::wire(sheet, &file, &format!("{list}_wire"), "", &format!("{list} edit: two triangles a patch"))?;
        let levels = format!("{list} edit: levels 0 and 1, four segments a side");
        show::picture(sheet, &file, &format!("{list}_levels"), "--show levels --tess 4", &levels)?;
        show::picture(sheet, &file, &format!("{list}_surface"), "", &format!("{list} edit: the surface"))?;
        let affected = number(&stats, "/levels/0/affected");
        let ring = (2 * rings).pow(2);
        rows.push(vec![
            list.to_owned(),
            rings.to_string(),
            ring.to_string(),
            (4.0 * affected).to_string(),
            number(&stats, "/total").to_string(),
            number(&stats, "/global").to_string(),
        ]);
    }
    sheet.caption(
        "One vertex of M^1 is edited. A geometry edit affects its two-ring, a colour edit its three-ring; only those faces are \
         refined, and the patches around them pass from one level to the other. All faces are regular: the surface is exact.",
    );
    let columns = ["edit", "rings", "faces_in_rings", "faces_refined_to_M1", "patches", "global"];
    sheet.table("affected.csv", &columns, rows, "Faces that the edit affects")
}
