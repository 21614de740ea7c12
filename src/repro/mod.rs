//! Every table and figure of the papers, made anew: `gradtess repro`.
//!
//! ```text
//!   FIGURES --plan--> a unit fills its Sheet --> figures/ID/{figure.json, *.csv, *.png, *.svg} --report--> report.html
//!                       |        ^
//!                       +-> gradtess render, stats, check, bench ... : the very commands that the report prints
//! ```
//!
//! A unit is one small file: a [`Figure`] in [`FIGURES`] and the function that fills its [`Sheet`]. What it shows comes
//! from the program's own commands, run in the output folder, so a reader can run each of them again and see the same.
//! `figure.json` is written last: a folder that has none is half made, and made anew by the next run.

mod blhk18;
mod bs05;
mod error;
mod folder;
pub mod plot;
pub mod record;
mod report;
mod scenes;
mod sheet;
mod zbk23;
mod zhhk22;

pub use error::ReproError;
pub use folder::{merge, plan, run, Outcome, Request, Shard};
pub use sheet::Sheet;

/// A table or figure of a paper.
#[derive(Clone, Copy)]
pub struct Figure {
    /// Paper and place in lower case: `zhhk22-fig20`. Names its folder.
    pub id: &'static str,
    /// Key of the paper.
    pub paper: &'static str,
    /// Where in the paper.
    pub place: &'static str,
    /// What it shows, in a few words.
    pub title: &'static str,
    /// Fills the sheet.
    pub make: fn(&mut Sheet) -> Result<(), ReproError>,
}

/// All figures, in the order of the report.
pub const FIGURES: &[Figure] = &[
    zhhk22::table_1::FIGURE,
    zhhk22::fig_4::FIGURE,
    zhhk22::fig_5::FIGURE,
    zhhk22::fig_6::FIGURE,
    zhhk22::fig_7::FIGURE,
    zhhk22::fig_8::FIGURE,
    zhhk22::fig_9::FIGURE,
    zhhk22::fig_11::FIGURE,
    zhhk22::fig_13::FIG_13,
    zhhk22::fig_13::FIG_14,
    zhhk22::fig_13::FIG_15,
    zhhk22::fig_13::FIG_16,
    zhhk22::fig_18::FIGURE,
    zhhk22::fig_19::FIGURE,
    zhhk22::fig_20::FIGURE,
    zhhk22::fig_21::FIGURE,
    zhhk22::fig_22::FIGURE,
    zhhk22::pair::FIGURE,
    zhhk22::drag::FIGURE,
    zhhk22::accuracy::FIGURE,
    zhhk22::isolate::FIGURE,
    zhhk22::pixels::FIGURE,
    zhhk22::remap::FIGURE,
    blhk18::table_1::FIGURE,
    blhk18::fig_4::FIGURE,
    blhk18::fig_6::FIGURE,
    blhk18::fig_9::FIGURE,
    blhk18::fig_13::FIGURE,
    blhk18::fig_15::FIGURE,
    blhk18::fig_18::FIGURE,
    zbk23::FIGURES[0],
    zbk23::FIGURES[1],
    zbk23::FIGURES[2],
    zbk23::FIGURES[3],
    zbk23::FIGURES[4],
    zbk23::FIGURES[5],
    zbk23::FIGURES[6],
    zbk23::FIGURES[7],
    zbk23::FIGURES[8],
    zbk23::FIGURES[9],
    zbk23::FIGURES[10],
    zbk23::FIGURES[11],
    bs05::fig_3::FIGURE,
    bs05::fig_4::FIGURE,
    bs05::fig_5::FIGURE,
    bs05::fig_6::FIGURE,
    bs05::fig_7::FIGURE,
];
