//! Fig. 20: frame times of a hexagon at equal triangles, and of the cherry at just more triangles than global.

use super::timing::{measure, Case};
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-fig20",
    paper: "ZHHK22",
    place: "Fig. 20",
    title: "Frame times of the hexagon and the cherry, adaptive against global",
    make,
};

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let hexagon = sheet.scene("hexagon.json")?;
    let cherry = match sheet.model("cherry/cherry_editAtSubd5.obj") {
        Some(model) => model,
        None => sheet.scene("cherry.json")?,
    };
    let mut cases = Vec::new();
    for level in 1..=6u32 {
        // All patches of the hexagon lie on level 1.
        let tess = 1 << (level - 1);
        cases.push(Case {
            name: format!("hexagon {level}"),
            scene: hexagon.clone(),
            flags: format!("--edits rebuild --tess {tess} --pair '--mode global --level {level} --tess 1'"),
            edits: "rebuild",
        });
    }
    for level in [5, 6] {
        cases.push(Case {
            name: format!("cherry {level}"),
            scene: cherry.clone(),
            flags: format!("--mode both --match-triangles --level {level} --edits rebuild"),
            edits: "rebuild",
        });
    }
    sheet.caption(
        "Median frame, refinement and patches on the CPU included: every frame makes the whole scene anew, as after an edit. \
         Numbers after the names are the levels of uniform subdivision. The hexagon has the same number of triangles either \
         way; for the cherry adaptive tessellation just exceeds the triangles of uniform subdivision.",
    );
    measure(sheet, &cases)
}
