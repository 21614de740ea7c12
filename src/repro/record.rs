//! `figure.json`: what a finished figure consists of.

use serde::{Deserialize, Serialize};

/// Version of `figure.json`.
pub const SCHEMA: &str = "gradtess.figure/1";

/// What a figure was made by and with. A figure is kept only as long as this is the same.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// Version of the program, its commit, and `+` if sources were changed since.
    pub program: String,
    /// `release` or `debug`.
    pub profile: String,
    /// Device.
    pub device: String,
    /// Its driver.
    pub driver: String,
    /// The processor of the machine.
    pub host: Option<String>,
    /// The whole protocol of timings, or a short one.
    pub full: bool,
    /// Timed frames of a repeat, where they are not those of the protocol.
    #[serde(default)]
    pub frames: Option<u32>,
    /// Whether the authors' models were given.
    pub models: bool,
}

/// A part of a figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", tag = "kind")]
pub enum Item {
    /// A PNG.
    Picture {
        /// File in the figure's folder.
        file: String,
        /// What it shows.
        caption: String,
    },
    /// An SVG.
    Plot {
        /// File in the figure's folder.
        file: String,
        /// What it shows.
        caption: String,
    },
    /// Numbers, also a CSV file.
    Table {
        /// File in the figure's folder.
        file: String,
        /// What it holds.
        caption: String,
        /// Names of the columns.
        columns: Vec<String>,
        /// Cells, as they stand in the CSV file.
        rows: Vec<Vec<String>>,
    },
}

impl Item {
    /// Its file.
    pub fn file(&self) -> &str {
        let (Item::Picture { file, .. } | Item::Plot { file, .. } | Item::Table { file, .. }) = self;
        file
    }
}

/// A finished figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// [`SCHEMA`].
    pub schema: String,
    /// Name of the figure.
    pub id: String,
    /// Key of the paper.
    pub paper: String,
    /// Where in the paper.
    pub place: String,
    /// What it shows.
    pub title: String,
    /// Caption: what is seen, and what the paper says of it.
    pub caption: String,
    /// What to know before believing the numbers.
    pub notes: Vec<String>,
    /// The commands that made it, run in the output folder.
    pub commands: Vec<String>,
    /// Pictures, plots and tables in order.
    pub items: Vec<Item>,
    /// What made it.
    pub origin: Origin,
    /// When it was finished, ISO 8601.
    pub utc: String,
    /// How long it took.
    pub seconds: f64,
}
