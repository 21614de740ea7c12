//! Fig. 21: frame times of edited models.

use super::equal_error::{error, least, Known, TOLERANCE};
use super::timing::{cells, faster, pair, ratio, ratio_text, Case, COLUMNS};
use crate::repro::plot::{Bar, Bars};
use crate::repro::sheet::number;
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-fig21",
    paper: "ZHHK22",
    place: "Fig. 21",
    title: "Frame times while geometry and colour are edited",
    make,
};

/// The authors' edited models by name and finest edit level, and whether they are measured by the short protocol too.
const MODELS: [(&str, &str, bool); 13] = [
    ("quad 2", "Quad_edits.obj", true),
    ("pin 2", "bolling/bolling_Subd2.obj", false),
    ("pin 3", "bolling/bolling_Subd3.obj", true),
    ("sunglasses 2", "glass/1/glass2.obj", false),
    ("sunglasses 3", "glass/1/glass3.obj", true),
    ("tulip 4", "Edited/Tulip.obj", true),
    ("butterfly 2", "butterfly/butterfly_Subdi2.obj", false),
    ("butterfly 3", "butterfly/butterfly_Subdi3.obj", false),
    ("butterfly 4", "butterfly/butterfly_Subdi4.obj", true),
    ("cherry 2", "cherry/cherry_editAtSubd2.obj", false),
    ("cherry 3", "cherry/cherry_editAtSubd3.obj", false),
    ("cherry 4", "cherry/cherry_editAtSubd4.obj", false),
    ("cherry 5", "cherry/cherry_editAtSubd5.obj", true),
];

/// Factors T of T / 2^l that are tried for equal error.
const FACTORS: [u32; 16] = [1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64];

/// What every frame does: flag, and in words.
const EDITS: [(&str, &str); 3] = [("geometry", "geometry edit"), ("colour", "colour edit"), ("none", "drawing alone")];

/// Two pictures are equal in this.
const BASES: [&str; 2] = ["triangles", "error"];

/// Flags of adaptive refinement that errs as little as uniform subdivision to `level`, its patches as two triangles; and
/// in words. Irregular faces are refined further where no tessellation is enough.
fn equal_error(sheet: &mut Sheet, scene: &str, level: u32) -> Result<Option<(String, String)>, ReproError> {
    let goal = error(sheet, scene, &format!("--mode global --level {level} --tess 1"))?;
    for isolate in 0..=3 {
        let flags = format!("--isolate {isolate} --tess-base");
        if let Some((factor, reached)) = least(sheet, scene, &flags, &FACTORS, goal, &mut Known::new())? {
            let words = format!(
                "T = {factor}, --isolate {isolate}: {:.4} %, mean {:.5} %; global {:.4} %, mean {:.5} %",
                reached[0], reached[1], goal[0], goal[1]
            );
            return Ok(Some((format!("--isolate-level {isolate} --tess-base {factor}"), words)));
        }
    }
    Ok(None)
}

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let mut models = vec![("our cherry 5", sheet.scene("cherry.json")?)];
    for (name, file, always) in MODELS {
        if always || sheet.full() {
            models.extend(sheet.model(file).map(|file| (name, file)));
        }
    }
    let mut rows = Vec::new();
    let mut claims = Vec::new();
    let mut groups = [Vec::new(), Vec::new()];
    for (name, scene) in &models {
        let level = number(&sheet.run(&format!("stats {scene}"))?, "/global_level") as u32;
        let equal = equal_error(sheet, scene, level)?;
        let ways = [
            Some((format!("--mode both --match-triangles --level {level}"), "as global".to_owned())),
            equal.map(|(flags, words)| (format!("{flags} --pair '--mode global --level {level} --tess 1'"), words)),
        ];
        for ((basis, way), group) in BASES.into_iter().zip(ways).zip(&mut groups) {
            let Some((flags, words)) = way else {
                claims.push(
                    [*name, basis, "NA", "NA", "not met: no factor errs as little", "NA", "NA"]
                        .map(str::to_owned)
                        .to_vec(),
                );
                continue;
            };
            let mut ratios: Vec<Bar> = Vec::new();
            for (edits, what) in EDITS {
                let case = Case {
                    name: format!("{name} {basis} {edits}"),
                    scene: scene.clone(),
                    flags: format!("{flags} --edits {edits}"),
                    edits: what,
                };
                let done = pair(sheet, &case)?;
                let head = [(*name).to_owned(), basis.to_owned(), words.clone(), what.to_owned()];
                rows.push(head.into_iter().chain(cells(&done)).collect());
                ratios.push(ratio(&done));
            }
            let met = ratios[..2].iter().all(|ratio| faster(ratio) == "adaptive");
            let mut claim = vec![(*name).to_owned(), basis.to_owned()];
            claim.extend(ratios[..2].iter().map(ratio_text));
            claim.push(if met { "met" } else { "not met" }.to_owned());
            claim.extend([ratio_text(&ratios[2]), faster(&ratios[2]).to_owned()]);
            claims.push(claim);
            group.push((name.replace(' ', "\n"), ratios.into_iter().map(Some).collect()));
        }
    }
    let met = |basis: &str| {
        let of: Vec<_> = claims.iter().filter(|claim| claim[1] == basis).collect();
        format!("{} of {}", of.iter().filter(|claim| claim[4] == "met").count(), of.len())
    };
    sheet.caption(format!(
        "Frames with an edit of the geometry or of a colour in each, and drawing alone beside them; uniform subdivision to the finest \
         level of edits, a patch as two triangles. At equal triangles adaptive tessellation just exceeds those of uniform \
         subdivision; at equal error its greatest and mean errors are no more than {:.0} % above. The paper's pear is not \
         published. The claim, that adaptive refinement is faster while either is edited, is met on {} models at equal triangles and on {} at \
         equal error.",
        100.0 * (TOLERANCE - 1.0),
        met("triangles"),
        met("error"),
    ));
    for (basis, groups) in BASES.into_iter().zip(groups) {
        let bars = Bars {
            axis: "time of global over adaptive".to_owned(),
            series: EDITS.map(|(_, what)| what.to_owned()).to_vec(),
            groups,
            logarithmic: true,
        };
        let caption = format!(
            "Equal {basis}: ratio of frame times with its 95 % interval, logarithmic; above 1 adaptive is faster"
        );
        sheet.plot(&format!("{basis}.svg"), &bars.svg(), caption)?;
    }
    let columns = ["model", "equal", "geometry_edit", "colour_edit", "claim", "drawing_alone", "faster_in_drawing"];
    sheet.table(
        "claims.csv",
        &columns,
        claims,
        "Time of global over adaptive with its 95 % interval. The claim is met where both intervals with edits lie above 1",
    )?;
    let columns = [&["model", "equal", "adaptive_tessellation", "every_frame"][..], &COLUMNS].concat();
    sheet.table("times.csv", &columns, rows, "Frame times, ms")
}
