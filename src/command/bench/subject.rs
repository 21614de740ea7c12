//! A scene in one configuration, drawn frame by frame.

use super::config::{Config, EditsFlag};
use super::ferguson::FergusonSource;
use super::source::{Counts, Source};
use super::subdivision::SubdivisionSource;
use crate::command::open::Subject as Opened;
use crate::command::{Failure, Global};
use crate::gpu::{Calibration, Canvas, DeviceTable, Frame, Gpu, GpuSpan};
use crate::patch::tess::TessRule;
use crate::patch::PatchTable;
use crate::timing::record::{Fields, FrameRecord, Phase};
use crate::timing::trace::Span;
use crate::timing::triangles;
use std::time::{Duration, Instant};

/// The clock all frames of a run are on.
#[derive(Clone, Copy)]
pub struct Clock {
    /// Zero.
    pub start: Instant,
    /// The device's clock on the host's.
    pub calibration: Option<Calibration>,
}

impl Clock {
    fn ns(&self, at: Instant) -> u64 {
        u64::try_from(at.saturating_duration_since(self.start).as_nanos()).unwrap_or(u64::MAX)
    }
}

/// One configuration of a scene, ready to be drawn.
pub struct Subject {
    /// Scene and configuration, unique in the run.
    pub label: String,
    /// Names the rows of `frames.csv`.
    pub run_id: String,
    /// The flags.
    pub config: Config,
    /// What makes its patches.
    pub source: Box<dyn Source>,
    /// What is drawn.
    pub frame: Frame,
    /// Counts of the scene as in its file.
    pub counts: Counts,
    /// Triangles of a frame before clipping.
    pub triangles: Option<u64>,
    /// Frames of finished repeats.
    pub records: Vec<FrameRecord>,
    latest: Counts,
    table: DeviceTable,
    canvas: Option<Canvas>,
}

/// What a frame left beside its record.
pub struct Drawn {
    /// The record.
    pub record: FrameRecord,
    /// GPU work on the host's clock.
    pub spans: Vec<Span>,
}

impl Subject {
    /// Loads and uploads a scene; `frame` gets its tessellation from the configuration. `matched`: tessellation by the
    /// number of triangles of uniform subdivision.
    pub fn new(
        file: &str,
        config: &Config,
        frame: impl Fn(&PatchTable) -> Result<Frame, Failure>,
        matched: bool,
        gpu: &Gpu,
        global: &Global,
    ) -> Result<Subject, Failure> {
        let (source, table, frame): (Box<dyn Source>, PatchTable, Frame) = match Opened::open(file, global)? {
            Opened::Subdivision(loaded) => {
                let (source, table) = SubdivisionSource::new(*loaded, config)?;
                let mut frame = frame(&table)?;
                frame.tess = source.tess(&table, config, matched)?;
                (Box::new(source), table, frame)
            }
            Opened::Ferguson(_) if matched => {
                return Err(Failure::input("--match-triangles goes with subdivision scenes; use --tess for both"));
            }
            Opened::Ferguson(mesh) => {
                let (source, table, frame) = FergusonSource::new(file, *mesh, config, frame)?;
                (Box::new(source), table, frame)
            }
            other => return Err(other.refused(file)),
        };
        let counts = source.counts();
        let triangles = triangles::count(&table, frame.tess);
        let table = gpu.upload(&table)?;
        let prepared =
            if config.isolate() { gpu.prepare_isolated(&table, &frame) } else { gpu.prepare(&table, &frame) }?;
        Ok(Subject {
            label: String::new(),
            run_id: String::new(),
            canvas: Some(prepared.into_canvas()),
            config: config.clone(),
            source,
            frame,
            counts,
            triangles,
            records: Vec::new(),
            latest: counts,
            table,
        })
    }

    /// Draws one frame, with its edit before it.
    pub fn draw(&mut self, gpu: &Gpu, clock: &Clock, phase: Phase, repeat: u32, frame: u32) -> Result<Drawn, Failure> {
        let rebuilds = self.config.edits() != EditsFlag::None;
        let begun = Instant::now();
        let mut fields = Fields { cpu_start_ns: Some(clock.ns(begun)), ..Fields::default() };
        let mut stage = begun;
        let mut lap = || {
            let now = Instant::now();
            let ms = (now - stage).as_secs_f64() * 1e3;
            stage = now;
            Some(ms)
        };
        if rebuilds {
            self.source.edit(frame, gpu, &mut self.table, &mut fields, &mut lap)?;
        }
        let canvas = self.canvas.take().ok_or_else(|| Failure::machine("an earlier frame failed"))?;
        let prepared = gpu.prepare_again(canvas, &self.table)?;
        let preparing = lap();
        let mut spans = Vec::new();
        let ms = |ns: u64| ns as f64 * 1e-6;
        if phase == Phase::Stats {
            let s = prepared.statistics()?;
            let none = Fields { cpu_start_ns: None, ..Fields::default() };
            fields = Fields {
                edits: fields.edits,
                ia_primitives: Some(s.ia_primitives),
                vs_invocations: Some(s.vs_invocations),
                tcs_patches: Some(s.tcs_patches),
                tes_invocations: Some(s.tes_invocations),
                clip_invocations: Some(s.clip_invocations),
                clip_primitives: Some(s.clip_primitives),
                fs_invocations: Some(s.fs_invocations),
                ..none
            };
        } else {
            let times = prepared.run(false)?;
            fields.cpu_record_ms = preparing.map(|t| t + ms(times.record_ns));
            fields.cpu_submit_ms = Some(ms(times.submit_ns));
            fields.cpu_wait_ms = Some(ms(times.wait_ns));
            let gpu = times.gpu;
            fields.gpu_frame_ms = gpu.frame_ns.map(ms);
            fields.gpu_upload_ms = gpu.upload_ns.filter(|_| rebuilds).map(ms);
            fields.gpu_regular_ms = gpu.bicubic_ns.map(ms);
            fields.gpu_gregory_ms = gpu.gregory_ns.map(ms);
            fields.gpu_transition_ms = match (gpu.bicubic_transition_ns, gpu.gregory_transition_ns) {
                (None, None) => None,
                (a, b) => Some(ms(a.unwrap_or(0) + b.unwrap_or(0))),
            };
            fields.gpu_overlay_ms = gpu.overlay_ns.map(ms);
        }
        // Letting go of what the frame made belongs to it; counting it does not.
        let counting = Instant::now();
        if rebuilds {
            self.latest = self.source.counts();
        }
        let counted = counting.elapsed();
        self.source.let_go();
        let mut taken = begun.elapsed().saturating_sub(counted);
        let slowdown = self.config.slowdown();
        if slowdown > 0.0 {
            let wanted = taken + taken.mul_f64(slowdown / 100.0);
            while taken < wanted {
                std::hint::spin_loop();
                taken = begun.elapsed().saturating_sub(counted);
            }
        }
        if phase != Phase::Stats {
            fields.cpu_frame_ms = Some(taken.as_secs_f64() * 1e3);
            if let Some(calibration) = clock.calibration {
                let on_host = |span: &GpuSpan| clock.ns(calibration.host_time(span.begin_ticks));
                let all = prepared.spans()?;
                fields.gpu_start_ns = all.iter().find(|span| span.label == "frame").map(on_host);
                fields.gpu_latency_ms = fields
                    .gpu_start_ns
                    .map(|ns| Duration::from_nanos(ns.saturating_sub(clock.ns(begun))).as_secs_f64() * 1e3);
                spans =
                    all.iter().map(|span| Span { label: span.label, start_ns: on_host(span), ns: span.ns }).collect();
            }
        }
        self.canvas = Some(prepared.into_canvas());
        let c = &self.latest;
        fields.edits = fields.edits.or(Some(0));
        fields.faces_affected = Some(c.affected);
        fields.max_level = Some(c.max_level);
        [
            fields.patches_bicubic,
            fields.patches_transition,
            fields.patches_gregory,
            fields.patches_gregory_transition,
        ] = c.patches.map(Some);
        let (TessRule::Fixed(t) | TessRule::Base(t) | TessRule::Pixels(t)) = self.frame.tess;
        fields.tess_factor = Some(f64::from(t));
        fields.control_points = Some(c.control_points);
        fields.upload_bytes = fields.upload_bytes.or(Some(if rebuilds { self.table.bytes() } else { 0 }));
        fields.gpu_bytes = Some(self.table.bytes());
        Ok(Drawn { record: FrameRecord { repeat, frame, phase, fields }, spans })
    }
}
