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
    /// What every frame does, in words.
    pub edits: &'static str,
}

/// Timed frames of each of the two repeats by the short protocol.
const FRAMES: u32 = 12;

/// The same where frames are short: a dozen of them would show what else the machine does.
const SHORT_FRAMES: u32 = 144;

/// Frames are short up to here, ms.
const SHORT_MS: f64 = 5.0;

/// Flags of the protocol: the whole one, or one that takes seconds on a software rasteriser, of `frames` a repeat.
fn protocol_of(sheet: &Sheet, frames: u32) -> String {
    if sheet.full() {
        sheet.frames().map(|n| format!(" --frames {n}")).unwrap_or_default()
    } else {
        let frames = sheet.frames().unwrap_or(frames);
        format!(" --size {} --warmup 2 --warmup-seconds 0 --stats-frames 1 --repeats 2 --frames {frames}", size(sheet))
    }
}

/// The protocol for frames that may be long.
pub fn protocol(sheet: &Sheet) -> String {
    protocol_of(sheet, FRAMES)
}

/// Pixels across and down of what is timed.
pub fn size(sheet: &Sheet) -> &'static str {
    if sheet.full() {
        "1920x1080"
    } else {
        "640x360"
    }
}

/// Runs a pair; what `bench` prints. Caveats become notes.
pub fn pair(sheet: &mut Sheet, case: &Case) -> Result<Value, ReproError> {
    let folder = sheet.file(&case.name.replace(' ', "_"));
    let command = |sheet: &Sheet, frames| {
        format!("bench {} -o {folder} {}{}", case.scene, case.flags, protocol_of(sheet, frames))
    };
    let few = command(sheet, FRAMES);
    let many = command(sheet, SHORT_FRAMES);
    let mut done = sheet.run(&few)?;
    if many != few && median(&done, 0).value.max(median(&done, 1).value) < SHORT_MS {
        done = sheet.run(&many)?;
    }
    for caveat in done["caveats"].as_array().into_iter().flatten().filter_map(Value::as_str) {
        // How busy is another number each time.
        let caveat = if caveat.starts_with("busy machine") { "busy machine, as run.json says" } else { caveat };
        sheet.note(format!("Caveat of the timings: {caveat}."));
    }
    Ok(done)
}

/// Median frame of run `i` of what [`pair`] returns, with its interval.
pub fn median(done: &Value, i: usize) -> Bar {
    let at = |what: &str| number(done, &format!("/runs/{i}/results/cpu_frame/{what}"));
    Bar { value: at("p50"), interval: Some([at("median_ci95/0"), at("median_ci95/1")]) }
}

/// Median ratio of frame times, global over adaptive, with its interval.
pub fn ratio(done: &Value) -> Bar {
    let at = |what: &str| number(done, &format!("/pairs/0/ratios/cpu_frame/median/{what}"));
    Bar { value: at("ratio"), interval: Some([at("ci95/0"), at("ci95/1")]) }
}

/// Columns of [`cells`].
pub const COLUMNS: [&str; 14] = [
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
    "faster",
];

/// What is said of a ratio: who is faster.
pub fn faster(ratio: &Bar) -> &'static str {
    match ratio.interval {
        Some([low, _]) if low > 1.0 => "adaptive",
        Some([_, high]) if high < 1.0 => "global",
        _ => "neither",
    }
}

/// Times and ratio of a pair as cells.
pub fn cells(done: &Value) -> Vec<String> {
    let mut row = Vec::new();
    for i in [0, 1] {
        row.push(cell(done, &format!("/runs/{i}/triangles")));
        for what in ["mean", "p50", "median_ci95/0", "median_ci95/1"] {
            row.push(cell(done, &format!("/runs/{i}/results/cpu_frame/{what}")));
        }
    }
    for what in ["ratio", "ci95/0", "ci95/1"] {
        row.push(cell(done, &format!("/pairs/0/ratios/cpu_frame/median/{what}")));
    }
    row.push(faster(&ratio(done)).to_owned());
    row
}

/// A ratio with its interval, for people.
pub fn ratio_text(ratio: &Bar) -> String {
    let [low, high] = ratio.interval.unwrap_or([f64::NAN; 2]);
    format!("{:.3} [{low:.3}, {high:.3}]", ratio.value)
}

/// Measures the cases and fills the sheet with their table and bars, `NAME.csv` and `NAME.svg`; returns the ratios.
pub fn measure(sheet: &mut Sheet, name: &str, cases: &[Case]) -> Result<Vec<Bar>, ReproError> {
    let mut rows = Vec::new();
    let mut groups = Vec::new();
    let mut ratios = Vec::new();
    for case in cases {
        let done = pair(sheet, case)?;
        groups.push((case.name.replace(' ', "\n"), vec![Some(median(&done, 0)), Some(median(&done, 1))]));
        rows.push([case.name.clone(), case.edits.to_owned()].into_iter().chain(cells(&done)).collect());
        ratios.push(ratio(&done));
    }
    let columns = [&["case", "edits"][..], &COLUMNS].concat();
    let bars = Bars {
        axis: "median frame, ms".to_owned(),
        series: vec!["adaptive".to_owned(), "global".to_owned()],
        groups,
        logarithmic: true,
    };
    let edits = cases.first().map_or("", |case| case.edits);
    let caption = format!("Every frame: {edits}. Median time of a frame with its 95 % interval, logarithmic");
    sheet.plot(&format!("{name}.svg"), &bars.svg(), caption)?;
    sheet.table(
        &format!("{name}.csv"),
        &columns,
        rows,
        "Frame times, and the ratio of frames measured in turns: above 1, adaptive refinement is faster",
    )?;
    Ok(ratios)
}
