//! Fig. 15: the control net of a radial gradient mesh.

use super::net;
use crate::repro::sheet::cell;
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "blhk18-fig15",
    paper: "BLHK18",
    place: "Fig. 15",
    title: "A genuine radial mesh with local refinement, branches and several colours a point",
    make,
};

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let mut rows = Vec::new();
    for name in ["radial", "sections", "branching", "still_life"] {
        let scene = sheet.scene(&format!("ferguson/{name}.json"))?;
        let picture = format!("{name}.png");
        let out = sheet.file(&picture);
        sheet.run(&format!("render {scene} -o {out} --size 640x560 --pixels 2 --samples 4"))?;
        let words = name.replace('_', " ");
        let patches = sheet.run(&format!("patches {scene}"))?;
        sheet.plot(&format!("{name}.svg"), &net::svg(&patches), format!("{words}: control net, colours by sector"))?;
        sheet.picture(&picture, words.clone());
        let stats = sheet.run(&format!("stats {scene}"))?;
        rows.push(
            [words]
                .into_iter()
                .chain(["/patches", "/roots", "/points", "/sections", "/components"].map(|k| cell(&stats, k)))
                .collect(),
        );
    }
    sheet.caption(
        "The rings of the radial mesh close on themselves; no control points lie on one another as in a rectangular mesh bent \
         into a ring. Discs are control points, parted into sectors where patches give them different colours; small discs \
         are T-sections, which take their data from their curve. Beside it the project's other meshes with T-sections and branches.",
    );
    let columns = ["scene", "patches", "patches_of_level_0", "points", "t_sections", "components"];
    sheet.table("nets.csv", &columns, rows, "What the nets consist of")
}
