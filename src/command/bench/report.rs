//! The three files of a run folder, and what is printed of them.

use super::subject::Subject;
use super::Group;
use crate::command::{print, print_json, Failure, Global};
use crate::gpu::{Calibration, Format, Gpu};
use crate::patch::remap::Transitions;
use crate::patch::tess::TessRule;
use crate::scene::write_atomically;
use crate::timing::compare::{self, Folder};
use crate::timing::host::{iso8601, sha256, Clocks, Host};
use crate::timing::pair::{ratios, Ratio};
use crate::timing::protocol::Protocol;
use crate::timing::record::{Fields, Phase, SCOPES};
use crate::timing::run::{self, Device, Document, Pair, Run, SceneFacts, ScopeResult, Settings, Timestamps, Tool};
use crate::timing::trace::Trace;
use serde::Serialize;
use serde_json::{json, Value};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Writes a run folder, again after every repeat.
pub struct Writer {
    folder: PathBuf,
    utc: String,
    protocol: Protocol,
    device: Device,
    host: Host,
    clocks: Clocks,
    timestamps: Timestamps,
    statistics: bool,
    validation: bool,
    scenes: Vec<SceneFacts>,
}

impl Writer {
    /// Gathers what does not change during the run.
    pub fn new(
        folder: &Path,
        protocol: Protocol,
        gpu: &Gpu,
        global: &Global,
        groups: &[Group],
    ) -> Result<Writer, Failure> {
        let info = gpu.device();
        let lacks = |what: &str| info.without.iter().any(|line| line.starts_with(what));
        let optional = [
            "fillModeNonSolid",
            "pipelineStatisticsQuery",
            "vertexPipelineStoresAndAtomics",
            "VK_EXT_calibrated_timestamps",
        ];
        let features = std::iter::once("tessellationShader").chain(optional.into_iter().filter(|what| !lacks(what)));
        let host = Host::here();
        let mut clocks = Clocks::new(info.kind == "cpu", &host);
        clocks.observe();
        Ok(Writer {
            folder: folder.to_owned(),
            utc: iso8601(SystemTime::now()),
            protocol,
            device: Device {
                name: info.name.clone(),
                kind: info.kind.to_owned(),
                vendor_id: info.vendor_id,
                device_id: info.device_id,
                driver_name: info.driver_name.clone(),
                driver_info: info.driver_info.clone(),
                driver_version: info.driver_version,
                api: info.api.clone(),
                limits: serde_json::to_value(&info.limits).map_err(Failure::machine)?,
                features: features.map(str::to_owned).collect(),
                layers: if global.validate { vec!["VK_LAYER_KHRONOS_validation".to_owned()] } else { Vec::new() },
                heap_bytes: info.device_local_bytes,
            },
            host,
            clocks,
            timestamps: Timestamps {
                period_ns: f64::from(info.limits.timestamp_period_ns),
                valid_bits: info.limits.timestamp_valid_bits,
                calibrated: false,
                domain: None,
                max_deviation_ns: None,
            },
            statistics: !lacks("pipelineStatisticsQuery"),
            validation: global.validate,
            scenes: groups.iter().flatten().map(scene_facts).collect::<Result<_, _>>()?,
        })
    }

    /// Notes a calibration; the worst deviation of all is kept.
    pub fn calibrated(&mut self, calibration: Option<Calibration>) {
        if let Some(c) = calibration {
            let t = &mut self.timestamps;
            t.calibrated = true;
            t.domain = Some("device, read between two readings of the host's monotonic clock".to_owned());
            t.max_deviation_ns = Some(t.max_deviation_ns.unwrap_or(0).max(c.deviation_ns));
        }
    }

    /// Notes how many repeats every scene has behind it.
    pub fn repeats_done(&mut self, done: &[(usize, u32)], scenes: usize) {
        let of = |scene| done.iter().filter(|(s, _)| *s == scene).count() as u32;
        self.protocol.repeats_done = (0..scenes).map(of).min().unwrap_or(0);
    }

    /// Puts all three files into the folder, each at once.
    pub fn write(&mut self, groups: &[Group], csv: &str, trace: &Trace) -> Result<(), Failure> {
        self.clocks.observe();
        let document = self.document(groups);
        let trace = trace.document(&document.run_id, &document.device.name);
        let put = |name: &str, bytes: &[u8]| write_atomically(&self.folder.join(name), bytes).map_err(Failure::from);
        put("frames.csv", csv.as_bytes())?;
        put("trace.json", serde_json::to_string(&trace).map_err(Failure::machine)?.as_bytes())?;
        put("run.json", (serde_json::to_string_pretty(&document).map_err(Failure::machine)? + "\n").as_bytes())
    }

    /// `run.json` as it stands.
    pub fn document(&self, groups: &[Group]) -> Document {
        let seed = self.protocol.seed;
        let runs: Vec<Run> = groups
            .iter()
            .flatten()
            .zip(&self.scenes)
            .map(|(subject, scene)| Run {
                run_id: subject.run_id.clone(),
                label: subject.label.clone(),
                scene: scene.clone(),
                settings: settings(subject, self.validation),
                results: run::results(&subject.records, seed),
            })
            .collect();
        let first = runs[0].clone();
        Document {
            schema: run::SCHEMA.to_owned(),
            run_id: first.run_id,
            utc: self.utc.clone(),
            command: command_line(),
            tool: tool(),
            scene: first.scene,
            settings: first.settings,
            protocol: self.protocol.clone(),
            device: self.device.clone(),
            host: self.host.clone(),
            clocks: self.clocks.clone(),
            timestamps: self.timestamps.clone(),
            results: first.results,
            caveats: self.caveats(&runs),
            pairs: groups.iter().filter_map(|group| pair(group, seed)).collect(),
            runs,
        }
    }

    fn caveats(&self, runs: &[Run]) -> Vec<String> {
        let mut caveats = Vec::new();
        let mut say = |when: bool, what: String| {
            if when {
                caveats.push(what);
            }
        };
        let software = self.device.kind == "cpu";
        say(software, "software rasteriser: GPU times are those of the processor, kinds hold the vertex work only unless isolated".to_owned());
        say(cfg!(debug_assertions), "debug build".to_owned());
        say(self.validation, "validation on".to_owned());
        say(!self.clocks.locked, "clocks not locked".to_owned());
        say(self.timestamps.valid_bits == 0, "no GPU timestamps".to_owned());
        say(!self.timestamps.calibrated, "timestamps not calibrated".to_owned());
        say(!self.statistics, "no pipeline statistics".to_owned());
        say(
            runs.iter().any(|run| run.settings.isolate),
            "kinds isolated by full barriers: frames are slower than they need be".to_owned(),
        );
        say(runs.iter().any(|run| run.settings.slowdown_percent > 0.0), "frames slowed down on purpose".to_owned());
        let standard = Protocol::default();
        let p = &self.protocol;
        let shorter = p.warmup_frames < standard.warmup_frames
            || p.warmup_s < standard.warmup_s
            || p.measure_frames < standard.measure_frames
            || p.repeats < standard.repeats;
        say(shorter, "shorter than the protocol asks for".to_owned());
        say(p.repeats_done < p.repeats, format!("unfinished: {} of {} repeats", p.repeats_done, p.repeats));
        say(self.host.virtual_machine == Some(true), "virtual machine".to_owned());
        if let (Some(load), Some(cores)) = (self.host.load, self.host.cores) {
            say(load > 0.5 * cores as f64, format!("busy machine: load {load:.1} on {cores} processors at the start"));
        }
        caveats
    }
}

fn command_line() -> Vec<String> {
    let here = std::env::current_dir().unwrap_or_default();
    let relative = |argument: String| {
        let path = Path::new(&argument);
        if !path.is_absolute() {
            return argument;
        }
        match path.strip_prefix(&here) {
            Ok(inside) => inside.display().to_string(),
            // Where else things lie on this machine is nobody's business.
            Err(_) => path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        }
    };
    std::iter::once("gradtess".to_owned()).chain(std::env::args().skip(1).map(relative)).collect()
}

fn relative_file(file: &str) -> String {
    let here = std::env::current_dir().unwrap_or_default();
    let path = Path::new(file);
    match (path.is_absolute(), path.strip_prefix(&here)) {
        (false, _) => file.to_owned(),
        (true, Ok(inside)) => inside.display().to_string(),
        (true, Err(_)) => path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
    }
}

fn tool() -> Tool {
    let known = |text: &str| (!text.is_empty()).then(|| text.to_owned());
    Tool {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        git_commit: known(env!("GRADTESS_COMMIT")),
        dirty: env!("GRADTESS_DIRTY").parse().ok(),
        rustc: known(env!("GRADTESS_RUSTC")),
        profile: if cfg!(debug_assertions) { "debug" } else { "release" }.to_owned(),
        features: env!("GRADTESS_FEATURES").split(',').filter(|f| !f.is_empty()).map(str::to_owned).collect(),
        spv_manifest_sha256: sha256(include_bytes!("../../../spv/manifest.json")),
    }
}

fn scene_facts(subject: &Subject) -> Result<SceneFacts, Failure> {
    let facts = subject.source.facts();
    let bytes = crate::scene::read_bounded(Path::new(&facts.file))?;
    Ok(SceneFacts {
        name: facts.name,
        file: relative_file(&facts.file),
        sha256: sha256(&bytes),
        technique: facts.technique.to_owned(),
        counts: facts.counts,
        edits_sha256: sha256(facts.edits.as_bytes()),
    })
}

fn settings(subject: &Subject, validation: bool) -> Settings {
    let (frame, config) = (&subject.frame, &subject.config);
    let facts = subject.source.facts();
    let (rule, t) = match frame.tess {
        TessRule::Fixed(t) => ("fixed", t),
        TessRule::Base(t) => ("base", t),
        TessRule::Pixels(p) => ("pixels", p),
    };
    Settings {
        width: frame.width,
        height: frame.height,
        samples: frame.samples,
        format: match frame.format {
            Format::Rgba8 => "rgba8",
            Format::Rgba32f => "rgba32f",
        }
        .to_owned(),
        spacing: facts.spacing.to_owned(),
        tess_rule: rule.to_owned(),
        tess_factor: f64::from(t),
        mode: if config.is_global() { "global" } else { "adaptive" }.to_owned(),
        rules: facts.rules.to_owned(),
        patches: facts.patches.to_owned(),
        transitions: match config.transitions() {
            Transitions::Constellations => "constellations",
            Transitions::Remap => "remap",
            Transitions::RemapOwn => "remap-own",
        }
        .to_owned(),
        max_level: subject.counts.max_level,
        triangles: subject.triangles,
        edits: format!("{:?}", config.edits()).to_lowercase(),
        isolate: config.isolate(),
        slowdown_percent: config.slowdown(),
        present_mode: "offscreen".to_owned(),
        frames_in_flight: 1,
        validation,
    }
}

fn pair(group: &Group, seed: u64) -> Option<Pair> {
    let [a, b] = group.as_slice() else {
        return None;
    };
    let of = |subject: &Subject, get: fn(&Fields) -> Option<f64>| run::values(&subject.records, get).concat();
    let ratios = SCOPES
        .iter()
        .filter(|(name, _)| matches!(*name, "cpu_frame" | "gpu_frame"))
        .filter_map(|&(name, get)| Some((name.to_owned(), ratios(&of(a, get), &of(b, get), seed)?)))
        .collect();
    Some(Pair { a: a.label.clone(), b: b.label.clone(), ratios })
}

/// The result for `--json`.
pub fn result(folder: &Path, document: &Document, groups: &[Group]) -> Value {
    // What the device counted in the last frame under a statistics query.
    let counted = |i: usize, get: fn(&Fields) -> Option<u64>| {
        let subject = groups.iter().flatten().nth(i)?;
        subject.records.iter().rev().find(|record| record.phase == Phase::Stats).and_then(|record| get(&record.fields))
    };
    json!({
        "schema": "gradtess.bench/1",
        "output": folder.display().to_string(),
        "device": document.device.name,
        "runs": document.runs.iter().enumerate().map(|(i, run)| json!({
            "label": run.label,
            "run_id": run.run_id,
            "triangles": run.settings.triangles,
            "counted_triangles": counted(i, |f| f.clip_invocations),
            "counted_vertices": counted(i, |f| f.tes_invocations),
            "tess_rule": run.settings.tess_rule,
            "tess_factor": run.settings.tess_factor,
            "results": run.results.iter().map(|(name, r)| (name.clone(), json!(r.pooled))).collect::<BTreeMap<_, _>>(),
        })).collect::<Vec<_>>(),
        "pairs": document.pairs,
        "caveats": document.caveats,
    })
}

fn verdict(ratio: &Ratio) -> String {
    let [low, high] = ratio.ci95;
    format!("{:.4} [{low:.4}, {high:.4}] {}", ratio.ratio, format!("{:?}", ratio.verdict).to_lowercase())
}

/// The result for people.
pub fn text(folder: &Path, document: &Document) -> String {
    let width = document.runs.iter().map(|run| run.label.chars().count()).max().unwrap_or(0);
    let mut out = format!(
        "{:<width$}  {:>22}  {:>8}  {:>8}  {:>8}  {:>8}\n",
        "frame, ms", "median [95 %]", "mean", "p95", "p99", "GPU p50"
    );
    for run in &document.runs {
        let Some(ScopeResult { pooled: s, .. }) = run.results.get("cpu_frame") else {
            continue;
        };
        let [low, high] = s.median_ci95;
        let median = format!("{:.3} [{low:.3}, {high:.3}]", s.p50);
        let on_gpu = run.results.get("gpu_frame").map_or("NA".to_owned(), |r| format!("{:.3}", r.pooled.p50));
        let _ = writeln!(
            out,
            "{:<width$}  {median:>22}  {:>8.3}  {:>8.3}  {:>8.3}  {on_gpu:>8}",
            run.label, s.mean, s.p95, s.p99
        );
        let stages: Vec<String> = run
            .results
            .iter()
            .filter(|(name, _)| name.starts_with("cpu_") && *name != "cpu_frame")
            .map(|(name, r)| format!("{} {:.3}", &name[4..], r.pooled.p50))
            .collect();
        let triangles = run.settings.triangles.map_or(String::new(), |n| format!("{n} triangles, "));
        let _ = writeln!(
            out,
            "    {triangles}tessellation {} {}; {}",
            run.settings.tess_rule,
            run.settings.tess_factor,
            stages.join(", ")
        );
    }
    for pair in &document.pairs {
        for (scope, r) in &pair.ratios {
            let _ = writeln!(
                out,
                "{} over {}, {scope}: median {}; mean {}",
                pair.b,
                pair.a,
                verdict(&r.median),
                verdict(&r.mean)
            );
        }
    }
    let _ = writeln!(
        out,
        "{}: frames.csv, run.json, trace.json; {} on {}",
        folder.display(),
        document.device.name,
        document.device.api
    );
    if !document.caveats.is_empty() {
        let _ = writeln!(out, "caveats: {}", document.caveats.join("; "));
    }
    out
}

fn read(folder: &Path) -> Result<Folder, Failure> {
    let at = |name: &str, what: String| Failure::input(format_args!("{}: {what}", folder.join(name).display()));
    let text = |name: &str| {
        let bytes = crate::scene::read_bounded(&folder.join(name))?;
        String::from_utf8(bytes).map_err(|_| at(name, "this is no text; give a folder that bench wrote".to_owned()))
    };
    let document: Document = serde_json::from_str(&text("run.json")?)
        .map_err(|e| at("run.json", format!("{e}; give a folder that this version of bench wrote")))?;
    if document.schema != run::SCHEMA {
        return Err(at("run.json", format!("schema {} is not {}", document.schema, run::SCHEMA)));
    }
    let times = compare::read_frames(&text("frames.csv")?).map_err(|what| at("frames.csv", what))?;
    Ok(Folder { document, times })
}

#[derive(Serialize)]
struct Comparison {
    schema: &'static str,
    a: String,
    b: String,
    /// Ratios of medians, B over A.
    runs: Vec<compare::Compared>,
    /// Why they may mean nothing.
    warnings: Vec<String>,
}

/// `bench --compare A B`.
pub fn compare(a: &Path, b: &Path, seed: u64, global: &Global) -> Result<(), Failure> {
    let (first, second) = (read(a)?, read(b)?);
    let mut warnings = compare::warnings(&first.document, &second.document);
    let (runs, notes) = compare::compare(&first, &second, seed);
    warnings.extend(notes);
    for warning in &warnings {
        global.warn(warning);
    }
    if runs.is_empty() {
        return Err(Failure::input("the two folders have no scene and configuration in common"));
    }
    let result = Comparison {
        schema: "gradtess.compare/1",
        a: a.display().to_string(),
        b: b.display().to_string(),
        runs,
        warnings,
    };
    if global.json {
        return print_json(&result);
    }
    for run in &result.runs {
        for (scope, ratio) in &run.ratios {
            print(&format!("{}, {scope}: B over A {}\n", run.label, verdict(ratio)));
        }
    }
    Ok(())
}
