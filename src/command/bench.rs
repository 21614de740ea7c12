//! `gradtess bench`: frame timings, written as a run folder.
//!
//! Every repeat of a scene warms up, draws the timed frames and then a few under statistics queries. When two
//! configurations are measured they take turns frame by frame. After each repeat all three files are written anew, so
//! that an interrupted run keeps the repeats it has finished.

mod config;
mod drags;
mod ferguson;
mod report;
mod source;
mod subdivision;
mod subject;

use super::open::Subject as Opened;
use super::picture::{bounds, fit, size, view};
use super::surface::flags::SurfaceFlags;
use super::surface::open::Surface;
use super::{print, print_json, silent, Failure, Global};
use crate::gpu::{Format, Frame, Gpu, Show};
use crate::patch::tess::TessRule;
use crate::patch::PatchTable;
use crate::scene::{read_bounded, technique, Technique};
use crate::timing::protocol::Protocol;
use crate::timing::random::Random;
use crate::timing::record::{header, FrameRecord, Phase};
use crate::timing::trace::Trace;
use clap::Args;
use config::{BenchMode, Config};
use indicatif::{ProgressBar, ProgressStyle};
use report::Writer;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use subject::{Clock, Subject};

/// Arguments of `bench`.
#[derive(Args)]
pub struct Bench {
    /// Scene files
    #[arg(required_unless_present_any = ["compare", "grid"])]
    scenes: Vec<String>,
    /// Folder for frames.csv, run.json and trace.json
    #[arg(short, long, value_name = "DIR", required_unless_present = "compare")]
    output: Option<PathBuf>,
    #[command(flatten)]
    config: Config,
    /// A second configuration: the first with these flags changed. Both take turns, and the ratio of their times is
    /// reported with its interval
    #[arg(long, value_name = "FLAGS", allow_hyphen_values = true)]
    pair: Option<String>,
    /// Tessellate adaptive patches so that they have the triangles of uniform subdivision or just exceed them; --tess is then that of
    /// uniform subdivision
    #[arg(long)]
    match_triangles: bool,
    /// Pixels across and down [default: 1920x1080]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Model rectangle X0,Y0,X1,Y1 that fills the picture; the whole scene and two pixels unless given
    #[arg(long, value_parser = view, allow_hyphen_values = true)]
    view: Option<[f64; 4]>,
    /// Samples a pixel: 1 or 4
    #[arg(long, default_value_t = 1)]
    samples: u32,
    /// Timed frames of a repeat [default: 512]
    #[arg(long, value_name = "N")]
    frames: Option<u32>,
    /// Least frames before them [default: 64]
    #[arg(long, value_name = "N")]
    warmup: Option<u32>,
    /// Least seconds before them [default: 1]
    #[arg(long, value_name = "S")]
    warmup_seconds: Option<f64>,
    /// Frames under statistics queries after them [default: 8]
    #[arg(long, value_name = "N")]
    stats_frames: Option<u32>,
    /// Repeats of all that [default: 5]
    #[arg(long, value_name = "N")]
    repeats: Option<u32>,
    /// Seed of the order and of the bootstrap
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Few frames of a small picture: shows that all works, measures nothing
    #[arg(long)]
    short: bool,
    /// Measure a figure's grid instead of scenes: fig7 of BS05, with fig7.csv and fig7.json in the folder. --frames are
    /// those of each method in a repeat [default there: 3]
    #[arg(long, value_enum, conflicts_with_all = ["scenes", "compare", "pair", "match_triangles", "view"])]
    grid: Option<GridFlag>,
    /// Measure instead of frames what one edit costs against the size of the mesh: in sheets of 1, 4, 16, ... up to --copies
    /// copies [default there: 1024], with drag.csv and drag.json in the folder. --frames are the steps of each drag
    #[arg(long, conflicts_with_all = ["grid", "compare", "pair", "match_triangles", "view"])]
    drag: bool,
    #[command(flatten)]
    surface: SurfaceFlags,
    /// Compare two run folders instead of measuring: ratio B over A
    #[arg(long, num_args = 2, value_names = ["A", "B"], conflicts_with_all = ["scenes", "output", "pair"])]
    compare: Option<Vec<PathBuf>>,
}

/// A grid of measurements.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum GridFlag {
    /// 10, 100 and 1000 coarse triangles at 64 x 64 and 128 x 128, by every draw method
    Fig7,
}

/// A scene in its one or two configurations.
type Group = Vec<Subject>;

impl Bench {
    /// Measures, or compares.
    pub fn run(&self, global: &Global) -> Result<(), Failure> {
        if let Some([a, b]) = self.compare.as_deref() {
            return report::compare(a, b, self.seed, global);
        }
        let Some(folder) = &self.output else {
            return Err(Failure::input("give a folder with -o DIR"));
        };
        if self.grid.is_some() {
            let request = super::pattern::bench::Request {
                folder,
                repeats: self.repeats.unwrap_or(if self.short { 5 } else { 9 }).max(1),
                frames: self.frames.unwrap_or(3).max(1),
                least: Duration::from_secs(if self.short { 0 } else { 1 }),
                size: self.size.unwrap_or([640, 480]),
                counts: if self.short { &[10] } else { &[10, 100, 1000] },
                levels: if self.short { &[64] } else { &[64, 128] },
                seed: self.seed,
            };
            return super::pattern::bench::run(&request, global);
        }
        if self.drag {
            return self.drags(folder, global);
        }
        if let Some(surfaces) = self.surfaces(global)? {
            let short = self.short;
            let [width, height] = self.size.unwrap_or(if short { [128, 128] } else { [512, 512] });
            if width != height {
                return Err(Failure::input("surfaces in space are compared in square pictures; give --size NxN"));
            }
            let request = super::surface::bench::Request {
                folder,
                repeats: self.repeats.unwrap_or(if short { 1 } else { 15 }).max(1),
                size: width,
                level: self.config.level().unwrap_or(if short { 3 } else { 4 }).clamp(2, 6),
            };
            return super::surface::bench::run(&surfaces, &self.surface, &request, global);
        }
        self.surface.refuse()?;
        let protocol = self.protocol();
        protocol.check().map_err(Failure::input)?;
        let configs = self.configs()?;
        if global.quiet || global.json {
            // The caveats are in run.json.
        } else if cfg!(debug_assertions) && !self.short {
            global.warn("this is a debug build; its times mean little");
        }
        let gpu = Gpu::new(&global.gpu())?;
        let mut groups = Vec::new();
        for file in &self.scenes {
            groups.push(self.group(file, &configs, &gpu, global)?);
        }
        name(&mut groups);
        std::fs::create_dir_all(folder).map_err(|e| Failure::machine(format_args!("{}: {e}", folder.display())))?;
        let mut writer = Writer::new(folder, protocol.clone(), &gpu, global, &groups)?;
        self.measure(&mut groups, &protocol, &gpu, global, &mut writer)?;
        silent(&gpu)?;
        let document = writer.document(&groups);
        if global.json {
            return print_json(&report::result(folder, &document, &groups));
        }
        if !global.quiet {
            print(&report::text(folder, &document));
        }
        Ok(())
    }

    /// The scenes, where they are surfaces in space, which are measured in another way.
    fn surfaces(&self, global: &Global) -> Result<Option<Vec<(String, Surface)>>, Failure> {
        let mut surfaces = Vec::new();
        for file in &self.scenes {
            match technique(&read_bounded(Path::new(file))?) {
                Technique::Surface => match Opened::open(file, global)? {
                    Opened::Surface(surface) => surfaces.push((file.clone(), *surface)),
                    other => return Err(other.refused(file)),
                },
                _ if surfaces.is_empty() => return Ok(None),
                _ => return Err(Failure::input("surfaces in space are measured apart from other scenes")),
            }
        }
        match surfaces.is_empty() {
            true => Ok(None),
            false if self.pair.is_some() || self.match_triangles || self.view.is_some() => Err(Failure::input(
                "--pair, --match-triangles and --view do not go with surfaces in space, which have levels and patches compared",
            )),
            false => Ok(Some(surfaces)),
        }
    }

    fn drags(&self, folder: &Path, global: &Global) -> Result<(), Failure> {
        let [file] = &self.scenes[..] else {
            return Err(Failure::input("--drag measures one scene; name one"));
        };
        let loaded = match Opened::open(file, global)? {
            Opened::Subdivision(loaded) => loaded,
            other => return Err(other.refused(file)),
        };
        let most = self.config.copies_given().unwrap_or(if self.short { 4 } else { 1024 });
        let steps = self.frames.unwrap_or(if self.short { 8 } else { 101 }).max(1);
        drags::run(*loaded, &drags::Request { folder, most, steps }, global)
    }

    fn protocol(&self) -> Protocol {
        let base = if self.short { Protocol::short() } else { Protocol::default() };
        Protocol {
            warmup_frames: self.warmup.unwrap_or(base.warmup_frames),
            warmup_s: self.warmup_seconds.unwrap_or(base.warmup_s),
            measure_frames: self.frames.unwrap_or(base.measure_frames),
            stats_frames: self.stats_frames.unwrap_or(base.stats_frames),
            repeats: self.repeats.unwrap_or(base.repeats),
            seed: self.seed,
            ..base
        }
    }

    /// One configuration, or two that take turns.
    fn configs(&self) -> Result<Vec<Config>, Failure> {
        let first = self.config.with_mode(self.config.mode.unwrap_or(BenchMode::Adaptive));
        let both = first.mode == Some(BenchMode::Both);
        let configs = match (&self.pair, both) {
            (None, false) => vec![first],
            (None, true) => vec![first.with_mode(BenchMode::Adaptive), first.with_mode(BenchMode::Global)],
            (Some(flags), false) => {
                let second = Config::parse(flags).map_err(Failure::input)?.over(&first);
                if second.mode == Some(BenchMode::Both) {
                    return Err(Failure::input("--pair: --mode both is two configurations; name one"));
                }
                vec![first, second]
            }
            (Some(_), true) => return Err(Failure::input("--mode both is a pair already; leave out --pair")),
        };
        for config in &configs {
            if !(config.slowdown().is_finite() && config.slowdown() >= 0.0) {
                return Err(Failure::input("--slowdown is a percentage from 0"));
            }
        }
        if configs.iter().all(|c| !c.is_global())
            && configs.iter().any(|c| c.level().is_some())
            && !self.match_triangles
        {
            return Err(Failure::input("--level goes with --mode global; adaptive refinement ends where the edits do"));
        }
        Ok(configs)
    }

    /// Both configurations see the same part of the scene.
    fn group(&self, file: &str, configs: &[Config], gpu: &Gpu, global: &Global) -> Result<Group, Failure> {
        let mut seen = self.view;
        let mut group: Group = Vec::new();
        for config in configs {
            let frame = |table: &PatchTable| {
                let size = self.size.unwrap_or(if self.short { [192, 108] } else { [1920, 1080] });
                Ok(Frame {
                    width: size[0],
                    height: size[1],
                    view: match seen {
                        Some(view) => view,
                        None => fit(bounds(table).unwrap_or([0.0, 0.0, 1.0, 1.0]), size)?,
                    },
                    tess: TessRule::Fixed(1.0),
                    show: Show::Surface,
                    background: Some([1.0; 4]),
                    samples: self.samples,
                    format: Format::Rgba8,
                    statistics: false,
                })
            };
            let subject = Subject::new(file, config, frame, self.match_triangles, gpu, global)?;
            seen = Some(subject.frame.view);
            group.push(subject);
        }
        Ok(group)
    }

    fn measure(
        &self,
        groups: &mut [Group],
        protocol: &Protocol,
        gpu: &Gpu,
        global: &Global,
        writer: &mut Writer,
    ) -> Result<(), Failure> {
        let mut random = Random::new(protocol.seed);
        let schedule = protocol.schedule(groups.len(), &mut random);
        let turn = u64::from(protocol.warmup_frames + protocol.measure_frames + protocol.stats_frames);
        let configs = groups.first().map_or(0, Vec::len) as u64;
        let bar = if global.quiet || global.json {
            ProgressBar::hidden()
        } else {
            ProgressBar::new(turn * configs * schedule.len() as u64)
        };
        bar.set_style(
            ProgressStyle::with_template("{bar:30} {pos}/{len} frames, {eta} left, {msg}")
                .unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        let start = Instant::now();
        let mut csv = header();
        let mut trace = Trace::default();
        for (done, &(scene, repeat)) in schedule.iter().enumerate() {
            let group = &mut groups[scene];
            bar.set_message(format!("{} repeat {}", group[0].source.name(), repeat + 1));
            let clock = Clock { start, calibration: gpu.calibrate()? };
            writer.calibrated(clock.calibration);
            let rows = one_repeat(group, protocol, gpu, &clock, repeat, &mut random, &mut trace, &bar)?;
            for (subject, records) in group.iter_mut().zip(rows) {
                for record in &records {
                    record.write(&subject.run_id, &mut csv);
                }
                subject.records.extend(records);
            }
            writer.repeats_done(&schedule[..=done], groups.len());
            writer.write(groups, &csv, &trace)?;
        }
        bar.finish_and_clear();
        Ok(())
    }
}

/// Warm-up, timed frames and statistics pass of all configurations of a scene, in turns.
#[allow(clippy::too_many_arguments)] // one call, and every argument is another thing
fn one_repeat(
    group: &mut Group,
    protocol: &Protocol,
    gpu: &Gpu,
    clock: &Clock,
    repeat: u32,
    random: &mut Random,
    trace: &mut Trace,
    bar: &ProgressBar,
) -> Result<Vec<Vec<FrameRecord>>, Failure> {
    let configs = group.len() as u64;
    let mut rows: Vec<Vec<FrameRecord>> = vec![Vec::new(); group.len()];
    let mut turn = |phase, frame, random: &mut Random, trace: &mut Trace| -> Result<(), Failure> {
        let mut order: Vec<usize> = (0..group.len()).collect();
        random.shuffle(&mut order);
        for k in order {
            let drawn = group[k].draw(gpu, clock, phase, repeat, frame)?;
            if phase == Phase::Measure {
                trace.add(&group[k].label, &drawn.record, &drawn.spans);
            }
            rows[k].push(drawn.record);
        }
        Ok(())
    };
    let warm = Instant::now();
    let mut frame = 0;
    while frame < protocol.warmup_frames || warm.elapsed() < Duration::from_secs_f64(protocol.warmup_s) {
        turn(Phase::Warmup, frame, random, trace)?;
        if frame < protocol.warmup_frames {
            bar.inc(configs);
        }
        frame += 1;
    }
    for frame in 0..protocol.measure_frames {
        turn(Phase::Measure, frame, random, trace)?;
        bar.inc(configs);
    }
    if gpu.device().without.iter().all(|what| !what.starts_with("pipelineStatisticsQuery")) {
        for frame in 0..protocol.stats_frames {
            turn(Phase::Stats, frame, random, trace)?;
            bar.inc(configs);
        }
    }
    Ok(rows)
}

/// Gives every subject a run id and a label: the scene, and the configuration where there are two.
fn name(groups: &mut [Group]) {
    let mut labels: Vec<String> = Vec::new();
    for group in groups.iter_mut() {
        let two = group.len() > 1;
        let modes_differ = two && group[0].config.is_global() != group[1].config.is_global();
        for (k, subject) in group.iter_mut().enumerate() {
            let suffix = match (two, modes_differ, subject.config.is_global()) {
                (false, _, _) => String::new(),
                (true, true, false) => " adaptive".to_owned(),
                (true, true, true) => " global".to_owned(),
                (true, false, _) => [" A", " B"][k.min(1)].to_owned(),
            };
            let name = format!("{}{suffix}", subject.source.name());
            let mut label = name.clone();
            let mut n = 1;
            while labels.contains(&label) {
                n += 1;
                label = format!("{name} ({n})");
            }
            subject.run_id = crate::timing::host::run_id(labels.len() as u64);
            subject.label.clone_from(&label);
            labels.push(label);
        }
    }
}
