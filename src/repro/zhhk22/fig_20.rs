//! Fig. 20: frame times of a hexagon at equal triangles, and of the cherry at just more triangles than global.

use super::timing::{faster, measure, ratio_text, Case};
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
    let cases = |flag: &str, edits: &'static str| -> Vec<Case> {
        let suffix = if flag == "none" { " rendering" } else { "" };
        let of_hexagon = (1..=6u32).map(|level| {
            // All patches of the hexagon lie on level 1.
            let tess = 1 << (level - 1);
            Case {
                name: format!("hexagon {level}{suffix}"),
                scene: hexagon.clone(),
                flags: format!("--edits {flag} --tess {tess} --pair '--mode global --level {level} --tess 1'"),
                edits,
            }
        });
        let of_cherry = [5, 6].into_iter().map(|level| Case {
            name: format!("cherry {level}{suffix}"),
            scene: cherry.clone(),
            flags: format!("--mode both --match-triangles --level {level} --edits {flag}"),
            edits,
        });
        of_hexagon.chain(of_cherry).collect()
    };
    let rebuilding = cases("rebuild", "refinement, patches and drawing, as after an edit");
    sheet.caption(
        "Median frame. Numbers after the names are the levels of uniform subdivision. The hexagon has the same number of triangles \
         either way; for the cherry adaptive tessellation just exceeds the triangles of uniform subdivision. First the paper's \
         way, where every frame makes the whole scene anew on the CPU; then drawing alone, where nothing is edited.",
    );
    let ratios = measure(sheet, "times", &rebuilding)?;
    let drawing = cases("none", "drawing alone");
    let drawn = measure(sheet, "rendering", &drawing)?;
    let mut rows = Vec::new();
    for ((case, ratio), drawn) in rebuilding.iter().zip(&ratios).zip(&drawn) {
        let counts = !case.name.ends_with(" 1");
        let claim = match (counts, faster(ratio)) {
            (false, _) => "below level 2",
            (true, "adaptive") => "met",
            _ => "not met",
        };
        rows.push(vec![
            case.name.clone(),
            ratio_text(ratio),
            claim.to_owned(),
            ratio_text(drawn),
            faster(drawn).to_owned(),
        ]);
    }
    let columns = ["case", "global_over_adaptive", "claim", "drawing_alone", "faster_in_drawing"];
    sheet.table(
        "claims.csv",
        &columns,
        rows,
        "The claim: adaptive refinement is faster from level 2 on, the whole 95 % interval of the ratio above 1",
    )
}
