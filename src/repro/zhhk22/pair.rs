//! Beside Figs. 20 and 21: are verdicts to be believed? The program measured against itself, and against itself made slower.

use crate::repro::sheet::cell;
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-pair",
    paper: "ZHHK22",
    place: "beside Fig. 21",
    title: "Whether pairs are called equal where they are, and different where one is 5 % slower",
    make,
};

/// Runs of each sort.
const RUNS: u64 = 10;

/// Runs of ten that have to be called as they are.
const WANTED: usize = 9;

/// What the second configuration of the pair is, its flags, and the verdict that is right.
const SORTS: [(&str, &str, &str); 2] = [("itself", "", "equal"), ("5 % slower", "--slowdown 5", "different")];

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let scene = sheet.scene("unit/geometry_level_2.json")?;
    let protocol = match (sheet.full(), sheet.frames()) {
        (true, None) => String::new(),
        (true, Some(n)) => format!(" --frames {n}"),
        (false, n) => format!(
            " --size 320x180 --warmup 8 --warmup-seconds 0.2 --stats-frames 0 --repeats 2 --frames {}",
            n.unwrap_or(0).max(300)
        ),
    };
    let mut rows = Vec::new();
    let mut found = Vec::new();
    for (what, flags, right) in SORTS {
        let mut called = 0;
        for seed in 1..=RUNS {
            let folder = sheet.file(&format!("{}_{seed}", what.replace([' ', '%'], "_")));
            let done = sheet.run(&format!(
                "bench {scene} -o {folder} --edits rebuild --tess 8{protocol} --seed {seed} --pair '{flags}'"
            ))?;
            let at = |what: &str| cell(&done, &format!("/pairs/0/ratios/cpu_frame/median/{what}"));
            let verdict = at("verdict");
            called += usize::from(verdict == right);
            rows.push(vec![
                what.to_owned(),
                seed.to_string(),
                cell(&done, "/pairs/0/ratios/cpu_frame/n"),
                at("ratio"),
                at("ci95/0"),
                at("ci95/1"),
                verdict,
            ]);
        }
        let met = if called >= WANTED { "met" } else { "not met" };
        found.push(format!("{what}: called {right} in {called} of {RUNS} runs (at least {WANTED} wanted: {met})"));
    }
    sheet.caption(format!(
        "One configuration of the program twice in turns, refinement, patches and drawing in every frame; then the second one with \
         every frame stretched by 5 % (--slowdown 5, a busy wait at its end). {}.",
        found.join("; ")
    ));
    let columns = ["second", "run", "pairs_of_frames", "ratio", "ratio_low", "ratio_high", "verdict"];
    sheet.table("pairs.csv", &columns, rows, "Median ratio of frame times, second over first, and its 95 % interval")
}
