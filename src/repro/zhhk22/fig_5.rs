//! Fig. 5: a mesh refined globally and locally.

use super::show;
use crate::repro::sheet::{cell, number};
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure =
    Figure { id: "zhhk22-fig5", paper: "ZHHK22", place: "Fig. 5", title: "Global against local refinement", make };

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let own = sheet.scene("cherry.json")?;
    let tulip = sheet.model("Edited/Tulip.obj").map(|file| ("tulip", file));
    let mut rows = Vec::new();
    for (name, scene) in tulip.into_iter().chain([("our_cherry", own)]) {
        let words = name.replace('_', " ");
        let stats = sheet.run(&format!("stats {scene}"))?;
        let level = cell(&stats, "/global_level");
        show::base_mesh(sheet, &scene, &format!("{name}_base"), &format!("{words}: M^0"))?;
        let whole = format!("{words}: uniform subdivision, {} faces", cell(&stats, "/global"));
        show::wire(sheet, &scene, &format!("{name}_global"), "--mode global", &whole)?;
        let local = format!("{words}: adaptive, {} patches", cell(&stats, "/total"));
        show::wire(sheet, &scene, &format!("{name}_adaptive"), "", &local)?;
        show::picture(sheet, &scene, &format!("{name}_surface"), "", &format!("{words}: the surface"))?;
        let fewer = number(&stats, "/global") / number(&stats, "/total");
        rows.push(vec![words, level, cell(&stats, "/global"), cell(&stats, "/total"), fewer.to_string()]);
    }
    sheet.caption(
        "Uniform subdivision makes every face as fine as the finest edit; adaptive refinement only those that an edit or an \
         irregular vertex asks for. The paper's tulip has 5472 faces of level 3 against 699 \
         patches; the level here is that of the finest edit in the file.",
    );
    let columns = ["scene", "level", "global_faces", "patches", "global_over_adaptive"];
    sheet.table("meshes.csv", &columns, rows, "Faces of uniform subdivision and patches of adaptive refinement")
}
