//! Fig. 21: frame times of edited models.

use super::equal_error::{error, least, Error, Known, TOLERANCE};
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

/// The authors' edited models by name and finest edit level.
const MODELS: [(&str, &str); 13] = [
    ("quad 2", "Quad_edits.obj"),
    ("pin 2", "bolling/bolling_Subd2.obj"),
    ("pin 3", "bolling/bolling_Subd3.obj"),
    ("sunglasses 2", "glass/1/glass2.obj"),
    ("sunglasses 3", "glass/1/glass3.obj"),
    ("tulip 4", "Edited/Tulip.obj"),
    ("butterfly 2", "butterfly/butterfly_Subdi2.obj"),
    ("butterfly 3", "butterfly/butterfly_Subdi3.obj"),
    ("butterfly 4", "butterfly/butterfly_Subdi4.obj"),
    ("cherry 2", "cherry/cherry_editAtSubd2.obj"),
    ("cherry 3", "cherry/cherry_editAtSubd3.obj"),
    ("cherry 4", "cherry/cherry_editAtSubd4.obj"),
    ("cherry 5", "cherry/cherry_editAtSubd5.obj"),
];

/// Factors T of T / 2^l that are tried for equal error.
const FACTORS: [u32; 16] = [1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64];

/// What every frame does: flag, and in words.
const EDITS: [(&str, &str); 3] = [("geometry", "geometry edit"), ("colour", "colour edit"), ("none", "drawing alone")];

/// Two pictures are equal in this.
const BASES: [&str; 2] = ["triangles", "error"];

/// How adaptive refinement draws transition faces: the paper's constellations, and whole faces with a level for every edge.
const TRANSITIONS: [(&str, &str); 2] = [("constellations", "constellations"), ("whole faces", "remap")];

/// Flags of adaptive refinement that errs as little as `goal`, the error of uniform subdivision; and in words. Irregular faces
/// are refined further where no tessellation is enough.
fn equal_error(
    sheet: &mut Sheet,
    scene: &str,
    transitions: &str,
    goal: Error,
) -> Result<Option<(String, String)>, ReproError> {
    for isolate in 0..=3 {
        let flags = format!("--transitions {transitions} --isolate {isolate} --tess-base");
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
    for (name, file) in MODELS {
        models.extend(sheet.model(file).map(|file| (name, file)));
    }
    let mut rows = Vec::new();
    let mut claims = Vec::new();
    let mut groups = [Vec::new(), Vec::new()];
    for (name, scene) in &models {
        let level = number(&sheet.run(&format!("stats {scene}"))?, "/global_level") as u32;
        let global = format!("--mode global --level {level} --tess 1");
        let goal = error(sheet, scene, &global)?;
        for (i, basis) in BASES.into_iter().enumerate() {
            let mut bars: Vec<Option<Bar>> = Vec::new();
            for (transitions, flag) in TRANSITIONS {
                let way = match i {
                    0 => Some((format!("--mode both --match-triangles --level {level}"), "as global".to_owned())),
                    _ => equal_error(sheet, scene, flag, goal)?
                        .map(|(flags, words)| (format!("{flags} --pair '{global}'"), words)),
                };
                let head = [*name, basis, transitions].map(str::to_owned);
                let Some((flags, words)) = way else {
                    let none = ["NA", "NA", "not met: no factor errs as little", "NA", "NA"].map(str::to_owned);
                    claims.push(head.into_iter().chain(none).collect());
                    bars.extend([None, None, None]);
                    continue;
                };
                let mut ratios: Vec<Bar> = Vec::new();
                for (edits, what) in EDITS {
                    let case = Case {
                        name: format!("{name} {basis} {flag} {edits}"),
                        scene: scene.clone(),
                        flags: format!("{flags} --transitions {flag} --edits {edits}"),
                        edits: what,
                    };
                    let done = pair(sheet, &case)?;
                    let row = head.iter().cloned().chain([words.clone(), what.to_owned()]);
                    rows.push(row.chain(cells(&done)).collect());
                    ratios.push(ratio(&done));
                }
                let met = ratios[..2].iter().all(|ratio| faster(ratio) == "adaptive");
                let mut claim: Vec<String> = head.into();
                claim.extend(ratios[..2].iter().map(ratio_text));
                claim.push(if met { "met" } else { "not met" }.to_owned());
                claim.extend([ratio_text(&ratios[2]), faster(&ratios[2]).to_owned()]);
                claims.push(claim);
                bars.extend(ratios.into_iter().map(Some));
            }
            groups[i].push((name.replace(' ', "\n"), bars));
        }
    }
    let met = |basis: &str, transitions: &str| {
        let of: Vec<_> = claims.iter().filter(|claim| claim[1] == basis && claim[2] == transitions).collect();
        format!("{} of {}", of.iter().filter(|claim| claim[5] == "met").count(), of.len())
    };
    let [paper, ours] = TRANSITIONS.map(|(transitions, _)| BASES.map(|basis| met(basis, transitions)));
    sheet.caption(format!(
        "Frames with an edit of the geometry or of a colour in each, and drawing alone beside them; uniform subdivision to the finest \
         level of edits, a patch as two triangles. At equal triangles adaptive tessellation has those of uniform \
         subdivision or just exceeds them; at equal error its greatest and mean errors are no more than {:.0} % above. Transition \
         faces are drawn by the paper's constellations, and whole with a level for every edge. The paper's pear is not published. \
         The claim, that adaptive refinement is faster while either is edited, is met at equal triangles on {} models by \
         constellations and on {} by whole faces, at equal error on {} and on {}.",
        100.0 * (TOLERANCE - 1.0),
        paper[0],
        ours[0],
        paper[1],
        ours[1],
    ));
    for (basis, groups) in BASES.into_iter().zip(groups) {
        let bars = Bars {
            axis: "time of global over adaptive".to_owned(),
            series: TRANSITIONS
                .iter()
                .flat_map(|(transitions, _)| EDITS.map(|(_, what)| format!("{what}, {transitions}")))
                .collect(),
            groups,
            logarithmic: true,
        };
        let caption = format!(
            "Equal {basis}: ratio of frame times with its 95 % interval, logarithmic; above 1 adaptive is faster"
        );
        sheet.plot(&format!("{basis}.svg"), &bars.svg(), caption)?;
    }
    let columns = [
        "model",
        "equal",
        "transitions",
        "geometry_edit",
        "colour_edit",
        "claim",
        "drawing_alone",
        "faster_in_drawing",
    ];
    sheet.table(
        "claims.csv",
        &columns,
        claims,
        "Time of global over adaptive with its 95 % interval. The claim is met where both intervals with edits lie above 1",
    )?;
    let columns = [&["model", "equal", "transitions", "adaptive_tessellation", "every_frame"][..], &COLUMNS].concat();
    sheet.table("times.csv", &columns, rows, "Frame times, ms")
}
