//! `run.json`: everything about a run but the single frames.
//!
//! A run folder holds one or more configurations (a scene and settings each), told apart by `run_id`, which every row of
//! `frames.csv` carries. The top level describes the first of them; `runs` lists all, `pairs` what measuring two of them
//! in turns found.

use super::host::{Clocks, Host};
use super::pair::PairRatios;
use super::protocol::Protocol;
use super::record::{Fields, FrameRecord, Phase, SCOPES};
use super::statistics::{summary, Summary};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// Version of `run.json`.
pub const SCHEMA: &str = "gradtess.run/1";

/// The program that measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tool {
    /// Version of the package.
    pub version: String,
    /// Commit it was compiled from.
    pub git_commit: Option<String>,
    /// Whether sources were changed since.
    pub dirty: Option<bool>,
    /// Compiler.
    pub rustc: Option<String>,
    /// `release` or `debug`.
    pub profile: String,
    /// Cargo features.
    pub features: Vec<String>,
    /// SHA-256 of `spv/manifest.json`, which has those of all shaders.
    pub spv_manifest_sha256: String,
}

/// What was drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneFacts {
    /// Name.
    pub name: String,
    /// File, relative.
    pub file: String,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Technique.
    pub technique: String,
    /// Row of Table 1: bicubic, bicubic_transition, gregory, gregory_transition, total, global.
    pub counts: BTreeMap<String, u64>,
    /// SHA-256 of the edit list, without the mesh.
    pub edits_sha256: String,
}

/// How it was drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples a pixel.
    pub samples: u32,
    /// Format of the target.
    pub format: String,
    /// Spacing of the tessellator.
    pub spacing: String,
    /// Rule of the tessellation level: `fixed`, `base` (T / 2^l at level l) or `pixels`.
    pub tess_rule: String,
    /// Its T, or pixels a segment.
    pub tess_factor: f64,
    /// `adaptive` or `global`.
    pub mode: String,
    /// Rule set of refinement.
    pub rules: String,
    /// `gregory` or `bicubic` for irregular faces.
    pub patches: String,
    /// `constellations`, `remap` or `remap-own` for transition faces.
    pub transitions: String,
    /// Deepest level drawn.
    pub max_level: u64,
    /// Triangles of a frame before clipping, by formula; `null` for rule `pixels`.
    pub triangles: Option<u64>,
    /// What every frame does before it draws: `none`, `rebuild`, `geometry` or `colour`.
    pub edits: String,
    /// Kinds of patches are kept apart by passes and full barriers.
    pub isolate: bool,
    /// Every frame is stretched by this many per cent, on purpose.
    pub slowdown_percent: f64,
    /// How pictures are presented.
    pub present_mode: String,
    /// Frames in flight.
    pub frames_in_flight: u32,
    /// Whether the validation layer was loaded.
    pub validation: bool,
}

/// What it was drawn on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Device {
    /// Name.
    pub name: String,
    /// `discrete`, `integrated`, `virtual`, `cpu` or `other`.
    #[serde(rename = "type")]
    pub kind: String,
    /// PCI vendor.
    pub vendor_id: u32,
    /// PCI device.
    pub device_id: u32,
    /// Driver.
    pub driver_name: String,
    /// What the driver says of itself.
    pub driver_info: String,
    /// The driver's version number, undecoded.
    pub driver_version: u32,
    /// Vulkan version.
    pub api: String,
    /// Limits.
    pub limits: Value,
    /// Optional features that were there.
    pub features: Vec<String>,
    /// Layers.
    pub layers: Vec<String>,
    /// Device-local memory, bytes.
    pub heap_bytes: u64,
}

/// How GPU times were taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timestamps {
    /// Nanoseconds a tick.
    pub period_ns: f64,
    /// Valid bits; 0: no GPU times.
    pub valid_bits: u32,
    /// Whether they are on the host's clock.
    pub calibrated: bool,
    /// Time domain that was read for it.
    pub domain: Option<String>,
    /// How far off the calibration may be, ns.
    pub max_deviation_ns: Option<u64>,
}

/// Statistics of one scope.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScopeResult {
    /// Unit of all times.
    pub unit: String,
    /// All timed frames.
    pub pooled: Summary,
    /// Those of each finished repeat.
    pub repeats: Vec<Summary>,
}

/// One configuration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Names its rows in `frames.csv`.
    pub run_id: String,
    /// Scene and configuration in a few words, unique in the folder.
    pub label: String,
    /// What was drawn.
    pub scene: SceneFacts,
    /// How.
    pub settings: Settings,
    /// Statistics by scope.
    pub results: BTreeMap<String, ScopeResult>,
}

/// Two configurations that took turns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// Label of A.
    pub a: String,
    /// Label of B.
    pub b: String,
    /// Ratios B over A by scope: `cpu_frame`, and `gpu_frame` where it was taken.
    pub ratios: BTreeMap<String, PairRatios>,
}

/// The document.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Document {
    /// [`SCHEMA`].
    pub schema: String,
    /// Of the first run.
    pub run_id: String,
    /// When it began, ISO 8601.
    pub utc: String,
    /// Arguments, with relative paths.
    pub command: Vec<String>,
    /// The program.
    pub tool: Tool,
    /// Of the first run.
    pub scene: SceneFacts,
    /// Of the first run.
    pub settings: Settings,
    /// How it was measured.
    pub protocol: Protocol,
    /// The device.
    pub device: Device,
    /// The machine.
    pub host: Host,
    /// Clocks.
    pub clocks: Clocks,
    /// GPU times.
    pub timestamps: Timestamps,
    /// Of the first run.
    pub results: BTreeMap<String, ScopeResult>,
    /// What to know before believing the numbers.
    pub caveats: Vec<String>,
    /// All runs in this folder.
    pub runs: Vec<Run>,
    /// Pairs among them.
    pub pairs: Vec<Pair>,
}

/// Values of one scope over the timed frames, a list for each finished repeat; NaN where it was not taken.
pub fn values(records: &[FrameRecord], get: fn(&Fields) -> Option<f64>) -> Vec<Vec<f64>> {
    let mut repeats: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for record in records.iter().filter(|record| record.phase == Phase::Measure) {
        repeats.entry(record.repeat).or_default().push(get(&record.fields).unwrap_or(f64::NAN));
    }
    repeats.into_values().collect()
}

/// Statistics of all scopes that were taken at all.
pub fn results(records: &[FrameRecord], seed: u64) -> BTreeMap<String, ScopeResult> {
    let mut results = BTreeMap::new();
    for &(name, get) in SCOPES {
        let taken = |list: &[f64]| list.iter().copied().filter(|x| !x.is_nan()).collect::<Vec<f64>>();
        let repeats: Vec<Vec<f64>> = values(records, get).iter().map(|list| taken(list)).collect();
        let Some(pooled) = summary(&repeats.concat(), seed) else {
            continue;
        };
        let repeats = repeats.iter().filter_map(|list| summary(list, seed)).collect();
        results.insert(name.to_owned(), ScopeResult { unit: "ms".to_owned(), pooled, repeats });
    }
    results
}
