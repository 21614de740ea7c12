//! Beside Sec. 6: tessellation by length on the screen against fixed factors that err as little.

use super::equal_error::{error, least, Known, TOLERANCE};
use super::timing::protocol;
use crate::repro::plot::Lines;
use crate::repro::sheet::{cell, number};
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-pixels",
    paper: "ZHHK22",
    place: "beside Sec. 6",
    title: "Screen-space tessellation against fixed factors at equal error",
    make,
};

/// Pixels a segment.
const PIXELS: [u32; 4] = [1, 2, 4, 8];

/// A family of fixed factors, and those of them that are tried.
struct Rival {
    name: &'static str,
    flag: &'static str,
    factors: &'static [u32],
}

const RIVALS: [Rival; 2] = [
    Rival {
        name: "T on every patch",
        flag: "--tess",
        factors: &[1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 56, 64],
    },
    Rival {
        name: "T / 2^l at level l",
        flag: "--tess-base",
        factors: &[2, 3, 4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64, 80, 96, 128, 160, 192, 256, 384, 512, 768, 1024],
    },
];

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let cherry = sheet.scene("cherry.json")?;
    let mut scenes =
        vec![("our cherry", cherry.clone()), ("our cherry × 6", format!("{cherry} --view 0.3,1.5,0.9,1.8375"))];
    scenes.extend(sheet.model("butterfly/butterfly_Subdi4.obj").map(|model| ("butterfly", model)));
    let mut rows = Vec::new();
    let mut plots = Vec::new();
    for (name, scene) in scenes {
        let mut series = vec![("--pixels".to_owned(), Vec::new())];
        series.extend(RIVALS.iter().map(|rival| (rival.flag.to_owned(), Vec::new())));
        let mut known = RIVALS.map(|_| Known::new());
        // Pixel by pixel a software rasteriser takes minutes.
        for &pixels in if sheet.full() { &PIXELS[..] } else { &PIXELS[1..] } {
            let rule = format!("--pixels {pixels}");
            let goal = error(sheet, &scene, &rule)?;
            for (i, rival) in RIVALS.iter().enumerate() {
                let mut row = vec![name.to_owned(), pixels.to_string(), rival.name.to_owned()];
                let Some((factor, reached)) = least(sheet, &scene, rival.flag, rival.factors, goal, &mut known[i])?
                else {
                    row.extend(std::iter::repeat_n("NA".to_owned(), 13));
                    rows.push(row);
                    continue;
                };
                let folder = sheet.file(&format!("{name} {pixels} {}", rival.flag).replace([' ', '-', '×'], "_"));
                let done = sheet.run(&format!(
                    "bench {scene} -o {folder} {rule}{} --pair '{} {factor}'",
                    protocol(sheet),
                    rival.flag
                ))?;
                let at = |i: usize, what: &str| format!("/runs/{i}/{what}");
                row.push(factor.to_string());
                for what in ["ratio", "ci95/0", "ci95/1", "verdict"] {
                    row.push(cell(&done, &format!("/pairs/0/ratios/cpu_frame/median/{what}")));
                }
                row.extend([goal[0], reached[0], goal[1], reached[1]].map(|x| x.to_string()));
                for what in ["results/cpu_frame/p50", "counted_triangles"] {
                    row.extend([0, 1].map(|i| cell(&done, &at(i, what))));
                }
                rows.push(row);
                let time = |i: usize| number(&done, &at(i, "results/cpu_frame/p50"));
                series[i + 1].1.push([time(1), reached[1]]);
                if i == 0 {
                    series[0].1.push([time(0), goal[1]]);
                }
            }
        }
        plots.push((name, series));
    }
    sheet.caption(format!(
        "For segments of {} to 8 pixels: the error of the picture, the least fixed factor whose greatest and mean error are no more than \
         {:.0} % above it, and frames of both without edits, measured in turns. Fixed factors are the same on every patch, or halved \
         from level to level as the paper has them; NA: none of those tried is as exact. Errors are in per cent of sqrt 3, those of \
         Gregory patches included, which no tessellation makes smaller.",
        if sheet.full() { 1 } else { 2 },
        100.0 * (TOLERANCE - 1.0)
    ));
    for (name, series) in plots {
        let axes = ["median frame, ms".to_owned(), "mean error, % of sqrt 3".to_owned()];
        let plot = Lines { axes, logarithmic: [true, true], series };
        let file = format!("{}.svg", name.replace([' ', '×'], "_"));
        sheet.plot(&file, &plot.svg(), format!("{name}: mean error against the time of a frame, both logarithmic"))?;
    }
    let columns = [
        "scene",
        "pixels",
        "fixed",
        "factor",
        "fixed_over_pixels",
        "ratio_low",
        "ratio_high",
        "verdict",
        "pixels_max_percent",
        "fixed_max_percent",
        "pixels_mean_percent",
        "fixed_mean_percent",
        "pixels_median_ms",
        "fixed_median_ms",
        "pixels_triangles",
        "fixed_triangles",
    ];
    sheet.table("pixels.csv", &columns, rows, "A ratio above 1: screen-space tessellation is faster at equal error")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_ascend() {
        assert!(RIVALS.iter().all(|rival| rival.factors.is_sorted()));
    }
}
