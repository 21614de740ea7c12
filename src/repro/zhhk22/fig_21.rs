//! Fig. 21: frame times of an edited model.

use super::timing::{measure, Case};
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-fig21",
    paper: "ZHHK22",
    place: "Fig. 21",
    title: "Frame times while geometry and colour are edited",
    make,
};

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let own = sheet.scene("cherry.json")?;
    let butterfly = sheet.model("butterfly/butterfly_Subdi4.obj").map(|file| ("butterfly", file, 4));
    let mut cases = Vec::new();
    for (name, scene, level) in butterfly.into_iter().chain([("our cherry", own, 4)]) {
        for (what, edits) in [("geometry", "geometry"), ("colour", "colour"), ("rendering", "none")] {
            cases.push(Case {
                name: format!("{name} {what}"),
                scene: scene.clone(),
                flags: format!("--mode both --match-triangles --level {level} --edits {edits}"),
                edits,
            });
        }
    }
    sheet.caption(
        "Median frame with an edit of the geometry or of a colour in each, and pure rendering without any edit beside it. \
         Adaptive tessellation just exceeds the triangles of uniform subdivision. The paper's pear is not published.",
    );
    measure(sheet, &cases)
}
