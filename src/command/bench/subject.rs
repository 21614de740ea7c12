//! A scene in one configuration, drawn frame by frame.

use super::config::{Config, EditsFlag};
use crate::command::open::{self, Loaded};
use crate::command::{Failure, Global, PatchesFlag};
use crate::gpu::{Calibration, Canvas, DeviceTable, Frame, Gpu, GpuSpan};
use crate::patch::build::{build, rebuild};
use crate::patch::points::Irregular;
use crate::patch::tess::TessRule;
use crate::patch::{Kind, PatchTable};
use crate::refine::{fate, Options, Refinement};
use crate::scene::{ColourEdit, GeometryEdit};
use crate::subdiv::index_map::IndexMap;
use crate::timing::record::{Fields, FrameRecord, Phase};
use crate::timing::trace::Span;
use crate::timing::triangles;
use std::collections::BTreeMap;
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

/// Counts of what is drawn.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    /// Faces refined on all levels.
    pub affected: u64,
    /// Deepest level drawn.
    pub max_level: u64,
    /// Bicubic faces, transition faces among them, Gregory faces, transition faces among them.
    pub patches: [u64; 4],
    /// Control points.
    pub control_points: u64,
}

impl Counts {
    fn of(refinement: &Refinement, table: &PatchTable) -> Counts {
        let mut patches = [0; 4];
        for face in &table.faces {
            let first = if face.kind == Kind::Bicubic { 0 } else { 2 };
            patches[first] += 1;
            patches[first + 1] += u64::from(face.transition != 0);
        }
        Counts {
            affected: refinement.fates.iter().flatten().filter(|&f| f & fate::AFFECTED != 0).count() as u64,
            max_level: table.faces.iter().map(|face| u64::from(face.level)).max().unwrap_or(0),
            patches,
            control_points: table.control.len() as u64,
        }
    }
}

/// The edits that frames apply anew, one a frame.
struct Replay {
    kind: EditsFlag,
    geometry: Vec<GeometryEdit>,
    colours: Vec<ColourEdit>,
    // Colour edits by vertex: a vertex changes as a whole, or its sectors would drift apart and become sharp.
    vertices: Vec<Vec<usize>>,
}

impl Replay {
    fn new(loaded: &Loaded, kind: EditsFlag) -> Result<Replay, Failure> {
        let scene = &loaded.scene;
        let none = |what: &str| {
            Err(Failure::input(format_args!("{}: no {what} edits to replay; use --edits rebuild", loaded.file)))
        };
        if kind == EditsFlag::Geometry && scene.geometry.is_empty() {
            return none("geometry");
        }
        if kind == EditsFlag::Colour && scene.colours.is_empty() {
            return none("colour");
        }
        let map = IndexMap::new(&loaded.mesh);
        let mut vertices: BTreeMap<_, Vec<usize>> = BTreeMap::new();
        if kind == EditsFlag::Colour {
            for (i, edit) in scene.colours.iter().enumerate() {
                // Refinement has already found every half-edge.
                if let Some(slot) = map.from_app_a(edit.level, edit.half_edge) {
                    vertices.entry((edit.level, map.birth(edit.level, slot))).or_default().push(i);
                }
            }
        }
        Ok(Replay {
            kind,
            geometry: scene.geometry.clone(),
            colours: scene.colours.clone(),
            vertices: vertices.into_values().collect(),
        })
    }

    /// Makes the scene that of frame `i`: all edits as in the file but one. The number of edits changed is returned.
    fn apply(&self, scene: &mut crate::scene::Scene, i: u32, before: Option<u32>) -> u64 {
        // The golden angle visits all phases evenly.
        let wave = (f64::from(i) * 2.399_963).sin();
        match self.kind {
            EditsFlag::None | EditsFlag::Rebuild => 0,
            EditsFlag::Geometry => {
                let at = |i: u32| i as usize % self.geometry.len();
                if let Some(before) = before {
                    scene.geometry[at(before)] = self.geometry[at(before)];
                }
                // A hundredth of an edge in sectors; of the angle and length beyond the boundary.
                let edit = &mut scene.geometry[at(i)];
                edit.a += 0.01 * wave;
                edit.b *= 1.0 + 0.01 * wave;
                1
            }
            EditsFlag::Colour => {
                let at = |i: u32| &self.vertices[i as usize % self.vertices.len()];
                for &k in before.map(at).into_iter().flatten() {
                    scene.colours[k] = self.colours[k];
                }
                // Towards grey, so that equal colours stay equal and all stay in range.
                for &k in at(i) {
                    let c = &mut scene.colours[k].colour;
                    *c += (glam::DVec4::new(0.5, 0.5, 0.5, c.w) - *c) * 0.02 * (1.0 + wave);
                }
                1
            }
        }
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
    /// The scene.
    pub loaded: Loaded,
    /// What is drawn.
    pub frame: Frame,
    /// Counts of the scene as in its file.
    pub counts: Counts,
    /// Triangles of a frame before clipping.
    pub triangles: Option<u64>,
    /// Frames of finished repeats.
    pub records: Vec<FrameRecord>,
    options: Options,
    irregular: Irregular,
    replay: Replay,
    replayed: Option<u32>,
    latest: Counts,
    table: DeviceTable,
    /// The last frame's table: memory for the next one.
    spare: PatchTable,
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
        let loaded = open::load(file, global)?;
        let refining = config.refining();
        let options = loaded.options(&refining)?;
        let irregular = match refining.patches {
            PatchesFlag::Gregory => Irregular::Gregory,
            PatchesFlag::Bicubic => Irregular::Bicubic,
        };
        let refinement = loaded.refine(options)?;
        let table = build(&refinement, irregular);
        let mut frame = frame(&table)?;
        frame.tess = match (matched, config.tess()) {
            (false, given) => given.unwrap_or(TessRule::Fixed(16.0)),
            (true, given) if config.is_global() => given.unwrap_or(TessRule::Fixed(1.0)),
            (true, given) => matching(&loaded, &table, config, given.unwrap_or(TessRule::Fixed(1.0)))?,
        };
        let replay = Replay::new(&loaded, config.edits())?;
        let counts = Counts::of(&refinement, &table);
        let triangles = triangles::count(&table, frame.tess);
        let table = gpu.upload(&table)?;
        let prepared =
            if config.isolate() { gpu.prepare_isolated(&table, &frame) } else { gpu.prepare(&table, &frame) }?;
        Ok(Subject {
            label: String::new(),
            run_id: String::new(),
            canvas: Some(prepared.into_canvas()),
            config: config.clone(),
            loaded,
            frame,
            counts,
            triangles,
            records: Vec::new(),
            options,
            irregular,
            replay,
            replayed: None,
            latest: counts,
            table,
            spare: PatchTable::default(),
        })
    }

    /// Draws one frame, with its edit before it.
    pub fn draw(&mut self, gpu: &Gpu, clock: &Clock, phase: Phase, repeat: u32, frame: u32) -> Result<Drawn, Failure> {
        let rebuilds = self.replay.kind != EditsFlag::None;
        let begun = Instant::now();
        let mut fields = Fields { cpu_start_ns: Some(clock.ns(begun)), ..Fields::default() };
        let mut stage = begun;
        let mut lap = || {
            let now = Instant::now();
            let ms = (now - stage).as_secs_f64() * 1e3;
            stage = now;
            Some(ms)
        };
        let mut made = None;
        if rebuilds {
            fields.edits = Some(self.replay.apply(&mut self.loaded.scene, frame, self.replayed));
            self.replayed = Some(frame);
            fields.cpu_edit_ms = lap();
            let refinement = self.loaded.refine(self.options)?;
            fields.cpu_refine_ms = lap();
            let table = rebuild(&refinement, self.irregular, std::mem::take(&mut self.spare));
            fields.cpu_patch_ms = lap();
            gpu.update(&mut self.table, &table)?;
            fields.cpu_upload_ms = lap();
            made = Some((refinement, table));
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
        if let Some((refinement, table)) = &made {
            self.latest = Counts::of(refinement, table);
        }
        let counted = counting.elapsed();
        if let Some((refinement, table)) = made {
            drop(refinement);
            self.spare = table;
        }
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
        fields.upload_bytes = Some(if rebuilds { self.table.bytes() } else { 0 });
        fields.gpu_bytes = Some(self.table.bytes());
        Ok(Drawn { record: FrameRecord { repeat, frame, phase, fields }, spans })
    }
}

/// The base level at which adaptive refinement just exceeds the triangles of uniform subdivision drawn by `rule`.
fn matching(loaded: &Loaded, table: &PatchTable, config: &Config, rule: TessRule) -> Result<TessRule, Failure> {
    rule.check().map_err(Failure::input)?;
    let level = config.level().unwrap_or_else(|| loaded.global_level());
    let faces = IndexMap::new(&loaded.mesh).faces(level.min(crate::refine::edits::MAX_LEVEL));
    let wanted = triangles::uniform(faces, level, rule).ok_or_else(|| {
        Failure::input("--match-triangles needs a tessellation that can be counted; use --tess or --tess-base")
    })?;
    let base = triangles::matching_base(table, wanted).ok_or_else(|| {
        Failure::input(format_args!(
            "{}: no tessellation of the adaptive patches makes more than {wanted} triangles; give uniform subdivision a lower --tess or --level",
            loaded.file
        ))
    })?;
    Ok(TessRule::Base(base as f32))
}
