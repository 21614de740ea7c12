//! Frame times of feature-adaptive against uniform subdivision, as Figs. 20 and 21 have them.

use crate::repro::plot::{Bar, Bars};
use crate::repro::sheet::{cell, number};
use crate::repro::{ReproError, Sheet};
use serde_json::Value;

/// A pair of configurations that is measured.
pub struct Case {
    /// Name in the plot, and of its run folder.
    pub name: String,
    /// Scene, as commands call it.
    pub scene: String,
    /// Flags of the pair, without those of the protocol.
    pub flags: String,
    /// What every frame does first, in words.
    pub edits: &'static str,
}

/// Flags of the protocol: the whole one, or one that takes seconds on a software rasteriser.
pub fn protocol(sheet: &Sheet) -> &'static str {
    if sheet.full() {
        ""
    } else {
        " --size 640x360 --warmup 2 --warmup-seconds 0 --frames 12 --stats-frames 1 --repeats 2"
    }
}

/// Pixels across and down of what is timed.
pub fn size(sheet: &Sheet) -> &'static str {
    if sheet.full() {
        "1920x1080"
    } else {
        "640x360"
    }
}

/// Measures the cases and fills the sheet with their table and bars.
pub fn measure(sheet: &mut Sheet, cases: &[Case]) -> Result<(), ReproError> {
    let mut rows = Vec::new();
    let mut groups = Vec::new();
    for case in cases {
        let folder = sheet.file(&case.name.replace(' ', "_"));
        let command = format!("bench {} -o {folder} {}{}", case.scene, case.flags, protocol(sheet));
        let done = sheet.run(&command)?;
        for caveat in done["caveats"].as_array().into_iter().flatten().filter_map(Value::as_str) {
            sheet.note(format!("Caveat of the timings: {caveat}."));
        }
        let run = |i: usize, what: &str| format!("/runs/{i}/{what}");
        let time = |i: usize| Bar {
            value: number(&done, &run(i, "results/cpu_frame/p50")),
            interval: Some([0, 1].map(|end| number(&done, &run(i, &format!("results/cpu_frame/median_ci95/{end}"))))),
        };
        groups.push((case.name.replace(' ', "\n"), vec![Some(time(0)), Some(time(1))]));
        let mut row = vec![case.name.clone(), case.edits.to_owned()];
        for i in [0, 1] {
            row.push(cell(&done, &run(i, "triangles")));
            for what in ["mean", "p50", "median_ci95/0", "median_ci95/1"] {
                row.push(cell(&done, &run(i, &format!("results/cpu_frame/{what}"))));
            }
        }
        for what in ["median/ratio", "median/ci95/0", "median/ci95/1", "median/verdict"] {
            row.push(cell(&done, &format!("/pairs/0/ratios/cpu_frame/{what}")));
        }
        rows.push(row);
    }
    let columns = [
        "case",
        "edits",
        "adaptive_triangles",
        "adaptive_mean_ms",
        "adaptive_median_ms",
        "adaptive_low_ms",
        "adaptive_high_ms",
        "global_triangles",
        "global_mean_ms",
        "global_median_ms",
        "global_low_ms",
        "global_high_ms",
        "global_over_adaptive",
        "ratio_low",
        "ratio_high",
        "verdict",
    ];
    let bars = Bars {
        axis: "median frame, ms".to_owned(),
        series: vec!["adaptive".to_owned(), "global".to_owned()],
        groups,
        logarithmic: true,
    };
    sheet.plot("times.svg", &bars.svg(), "Median time of a frame with its 95 % interval, logarithmic")?;
    sheet.table(
        "times.csv",
        &columns,
        rows,
        "Frame times, and the ratio of frames measured in turns: above 1, adaptive refinement is faster",
    )
}
