//! Two run folders side by side: what differs about the circumstances, and the ratio of the times.

use super::pair::{unpaired, Ratio};
use super::run::{Document, Run};
use serde::Serialize;
use std::collections::BTreeMap;

/// A run folder as read back.
#[derive(Clone, Debug)]
pub struct Folder {
    /// `run.json`.
    pub document: Document,
    /// Timed frames of `frames.csv`.
    pub times: Times,
}

/// Timed frames by run_id and column, a list for each repeat.
pub type Times = BTreeMap<String, BTreeMap<String, Vec<Vec<f64>>>>;

/// One configuration that both folders have.
#[derive(Clone, Debug, Serialize)]
pub struct Compared {
    /// Its label.
    pub label: String,
    /// Ratio B over A of the medians, by scope.
    pub ratios: BTreeMap<String, Ratio>,
}

/// Scopes that are compared, and their columns.
const SCOPES: [(&str, &str); 2] = [("cpu_frame", "cpu_frame_ms"), ("gpu_frame", "gpu_frame_ms")];

/// Reads the timed frames of a `frames.csv`.
///
/// # Errors
/// The line, and what is wrong with it.
pub fn read_frames(text: &str) -> Result<Times, String> {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let column =
        |name: &str| header.iter().position(|h| *h == name).ok_or_else(|| format!("line 1: there is no column {name}"));
    let [id, repeat, phase] = [column("run_id")?, column("repeat")?, column("phase")?];
    let wanted: Vec<(usize, &str)> =
        SCOPES.iter().map(|(_, name)| Ok((column(name)?, *name))).collect::<Result<_, String>>()?;
    let mut by_repeat: BTreeMap<(String, String), BTreeMap<u32, Vec<f64>>> = BTreeMap::new();
    for (number, line) in lines.enumerate() {
        let cells: Vec<&str> = line.split(',').collect();
        if cells.len() != header.len() {
            return Err(format!("line {}: {} cells under {} columns", number + 2, cells.len(), header.len()));
        }
        if cells[phase] != "measure" {
            continue;
        }
        let repeat: u32 = cells[repeat].parse().map_err(|_| format!("line {}: repeat is no number", number + 2))?;
        for &(place, name) in &wanted {
            if cells[place] == "NA" {
                continue;
            }
            let ms: f64 = cells[place].parse().map_err(|_| format!("line {}: {name} is no number", number + 2))?;
            let key = (cells[id].to_owned(), name.to_owned());
            by_repeat.entry(key).or_default().entry(repeat).or_default().push(ms);
        }
    }
    let mut times = Times::new();
    for ((id, name), repeats) in by_repeat {
        times.entry(id).or_default().insert(name, repeats.into_values().collect());
    }
    Ok(times)
}

/// What differs so that times cannot be compared, one line each.
pub fn warnings(a: &Document, b: &Document) -> Vec<String> {
    let mut found = Vec::new();
    let mut differ = |what: &str, a: String, b: String| {
        if a != b {
            found.push(format!("{what} differs: {a} / {b}"));
        }
    };
    let text = |x: &Option<String>| x.clone().unwrap_or_else(|| "unknown".to_owned());
    let device = |d: &Document| format!("{} ({:#x}:{:#x})", d.device.name, d.device.vendor_id, d.device.device_id);
    differ("device", device(a), device(b));
    let driver =
        |d: &Document| format!("{} {} ({})", d.device.driver_name, d.device.driver_info, d.device.driver_version);
    differ("driver", driver(a), driver(b));
    let host = |d: &Document| {
        let h = &d.host;
        let count = |n: Option<u64>| n.map_or("unknown".to_owned(), |n| n.to_string());
        format!(
            "{}, {} cores, {} bytes, {}, kernel {}",
            text(&h.cpu),
            count(h.cores.map(|n| n as u64)),
            count(h.memory),
            text(&h.os),
            text(&h.kernel)
        )
    };
    differ("host", host(a), host(b));
    let clocks = |d: &Document| {
        let requested = d.clocks.requested_mhz.map_or(String::new(), |mhz| format!(" at {mhz} MHz"));
        format!("{}{requested}, {}", if d.clocks.locked { "locked" } else { "not locked" }, d.clocks.method)
    };
    differ("clocks", clocks(a), clocks(b));
    let build = |d: &Document| format!("{} build", d.tool.profile);
    differ("build", build(a), build(b));
    let validation = |d: &Document| if d.settings.validation { "on".to_owned() } else { "off".to_owned() };
    differ("validation", validation(a), validation(b));
    for (d, name) in [(a, "first"), (b, "second")] {
        if !d.clocks.locked {
            found.push(format!("clocks of the {name} run were not locked"));
        }
    }
    // Clocks far apart are different clocks, whatever was locked.
    if let (Some(x), Some(y)) = (a.clocks.observed_max_mhz, b.clocks.observed_max_mhz) {
        if (x / y - 1.0).abs() > 0.05 {
            found.push(format!("observed clocks differ: {x:.0} / {y:.0} MHz"));
        }
    }
    found
}

/// Ratios of all runs of the same label, and what differs about those of other settings.
pub fn compare(a: &Folder, b: &Folder, seed: u64) -> (Vec<Compared>, Vec<String>) {
    let mut notes = Vec::new();
    let mut compared = Vec::new();
    for run in &a.document.runs {
        // One run each is one pair, whatever the two are called.
        let single = a.document.runs.len() == 1 && b.document.runs.len() == 1;
        let Some(other) = b.document.runs.iter().find(|other| single || other.label == run.label) else {
            notes.push(format!("{} is in the first folder only", run.label));
            continue;
        };
        if run.label != other.label {
            notes.push(format!("{} is compared with {}", run.label, other.label));
        }
        if run.scene.sha256 != other.scene.sha256 {
            notes.push(format!("{}: the scene files differ", run.label));
        }
        if run.settings != other.settings {
            notes.push(format!("{}: settings differ", run.label));
        }
        let times = |folder: &Folder, id: &str, column: &str| {
            folder.times.get(id).and_then(|columns| columns.get(column)).cloned().unwrap_or_default()
        };
        let ratios = SCOPES
            .iter()
            .filter_map(|(scope, column)| {
                let ratio = unpaired(&times(a, &run.run_id, column), &times(b, &other.run_id, column), seed)?;
                Some(((*scope).to_owned(), ratio))
            })
            .collect();
        compared.push(Compared { label: run.label.clone(), ratios });
    }
    let alone = |run: &&Run| {
        compared.len() < b.document.runs.len() && a.document.runs.iter().all(|other| other.label != run.label)
    };
    for run in b.document.runs.iter().filter(alone) {
        notes.push(format!("{} is in the second folder only", run.label));
    }
    (compared, notes)
}
