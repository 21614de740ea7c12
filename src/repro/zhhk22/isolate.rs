//! Beside section 7, which asks down to which level irregular faces should be refined: error against patches.

use super::show;
use crate::repro::plot::Lines;
use crate::repro::sheet::number;
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-isolate",
    paper: "ZHHK22",
    place: "beside Sec. 7",
    title: "Error against patches when irregular faces are refined further",
    make,
};

/// Deepest level of the curve.
const DEEPEST: u32 = 4;

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let mut rows = Vec::new();
    let mut by_level = Vec::new();
    let mut by_patches = Vec::new();
    for name in ["triangle", "pentagon", "hexagon", "unit/sharp_three_meet"] {
        let scene = sheet.scene(&format!("{name}.json"))?;
        let words = name.rsplit('/').next().unwrap_or(name).replace('_', " ");
        let (mut levels, mut patches) = (Vec::new(), Vec::new());
        for level in 0..=DEEPEST {
            let flags = format!("--isolate {level}");
            let stats = sheet.run(&format!("stats {scene} {flags}"))?;
            let file = format!("{}_{level}", words.replace(' ', "_"));
            let cells = show::error(sheet, &scene, &file, &flags, &format!("{words}, isolated to level {level}"))?;
            let max: f64 = cells[0].parse().unwrap_or(f64::NAN);
            let total = number(&stats, "/total");
            levels.push([f64::from(level), max]);
            patches.push([total, max]);
            rows.push(vec![words.clone(), level.to_string(), total.to_string(), cells[0].clone(), cells[1].clone()]);
        }
        by_level.push((words.clone(), levels));
        by_patches.push((words, patches));
    }
    sheet.caption(
        "What is not exact lies in the faces around extraordinary vertices. Each level of --isolate draws them half as large, and \
         the rest by bicubic patches that are exact: the price of accuracy in patches. Scenes with non-quads are on level 1 in any case.",
    );
    let max = || "maximum, % of sqrt 3".to_owned();
    let plot = Lines { axes: ["--isolate".to_owned(), max()], logarithmic: [false, true], series: by_level };
    sheet.plot("levels.svg", &plot.svg(), "Error against the level of isolation")?;
    let plot = Lines { axes: ["patches".to_owned(), max()], logarithmic: [true, true], series: by_patches };
    sheet.plot("patches.svg", &plot.svg(), "Error against patches")?;
    let columns = ["scene", "isolate", "patches", "max_percent", "mean_percent"];
    sheet.table(
        "errors.csv",
        &columns,
        rows,
        "Patches, and the distance of the colour from the limit in per cent of sqrt 3",
    )
}
