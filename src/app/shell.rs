//! Between the window system and the editor.
//!
//! egui-ash owns the window's event loop and one set of widgets, which here only carries input in and finished meshes
//! out. The editor's own widgets run in a context of their own, so that a script can be their mouse, keyboard and clock
//! while nothing else changes: same queue, same frames, same picture.

mod replay;

pub use replay::Replay;

use super::dialog::Then;
use super::editor::{Dragged, Editor};
use super::script::{self, Action};
use super::timing;
use crate::gpu::{CloseButton, GpuError, Outcome};
use egui::{ClippedPrimitive, Context, RawInput, TextureId};
use egui_ash::{event, winit, EguiCommand, ExitSignal, HandleRedraw};
use serde::Serialize;
use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::rc::Rc;
use std::sync::mpsc::{channel, Receiver, Sender};
use std::time::{Duration, Instant};

/// Frames that widgets take to find their places.
const SETTLING: u32 = 3;

/// Vertices and indices that egui-ash's buffers of 4 MiB hold.
const MOST_VERTICES: usize = (4 << 20) / size_of::<egui::epaint::Vertex>();
const MOST_INDICES: usize = (4 << 20) / size_of::<u32>();

/// How the session ended.
#[derive(Default)]
pub struct End {
    /// What went wrong.
    pub error: Option<String>,
    /// The window was closed with unsaved work: its journal.
    pub journal: Option<PathBuf>,
    /// What happened.
    pub report: Option<Report>,
}

/// What a session came to.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// `gradtess.edit/1`.
    pub schema: &'static str,
    /// The scene's file.
    pub file: Option<PathBuf>,
    /// Whether changes were left unsaved.
    pub unsaved: bool,
    /// Steps that can be undone.
    pub steps: usize,
    /// The status line at the end.
    pub message: Option<String>,
    /// Handles dragged and where to, in order.
    pub dragged: Vec<Dragged>,
    /// Frames that showed an edit.
    pub edit_frames: usize,
    /// Median from the input of an edit to the end of the frame that shows it, ms; fold tests included.
    pub edit_to_frame_ms: Option<f64>,
    /// Median share of refinement and patches in that.
    pub refine_share: Option<f64>,
    /// Where that time goes: medians of the stages of the frames that showed an edit, ms.
    pub stages_ms: BTreeMap<&'static str, f64>,
}

/// A recording.
pub struct Record {
    /// Where it goes.
    pub file: std::fs::File,
    /// Modifiers as of the last line.
    pub held: egui::Modifiers,
    /// Size of the window as of the last line, points.
    pub size: [f32; 2],
}

/// The application that egui-ash runs.
pub struct Shell {
    /// The editor.
    pub editor: Editor,
    inner: Context,
    textures: HashMap<TextureId, TextureId>,
    painted: Vec<ClippedPrimitive>,
    begun: Instant,
    idle_since: Instant,
    repaint: bool,
    title: String,
    replay: Option<Replay>,
    record: Option<Record>,
    frames: (Sender<Ready>, Receiver<Ready>),
    exit: ExitSignal,
    end: Rc<RefCell<End>>,
    ending: bool,
    close: Option<CloseButton>,
    native_scale: f32,
    edited: Option<Edited>,
    edits: Vec<[f64; STAGES.len()]>,
    /// Time of the last frame's presentation, ms.
    shown_ms: f64,
}

/// Stages of a frame that shows an edit, as the report names them. `widgets` is the panels, the overlay's geometry and
/// all else that runs on the host; `window` is drawing them, the scene's texture included, and presenting.
const STAGES: [&str; 8] = ["whole", "folds", "refine", "patches", "upload", "scene", "widgets", "window"];

/// A frame that shows an edit, until it is on the screen.
struct Edited {
    begun: Instant,
    stages: [f64; STAGES.len()],
}

/// Widgets ready to be shown in a window of a size.
type Ready = (winit::dpi::PhysicalSize<u32>, EguiCommand);

impl Shell {
    /// An editor in a window.
    pub fn new(
        editor: Editor,
        replay: Option<Replay>,
        record: Option<Record>,
        exit: ExitSignal,
        end: Rc<RefCell<End>>,
        close: Option<CloseButton>,
        native_scale: f32,
    ) -> Shell {
        let inner = Context::default();
        inner.set_visuals(egui::Visuals::light());
        if replay.is_some() {
            // Nothing moves by itself.
            inner.style_mut(|style| style.animation_time = 0.0);
        }
        Shell {
            editor,
            inner,
            textures: HashMap::new(),
            painted: Vec::new(),
            begun: Instant::now(),
            idle_since: Instant::now(),
            repaint: true,
            title: String::new(),
            replay,
            record,
            frames: channel(),
            exit,
            end,
            ending: false,
            close,
            native_scale,
            edited: None,
            edits: Vec::new(),
            shown_ms: 0.0,
        }
    }

    fn report(&self) -> Report {
        let middle = |mut all: Vec<f64>| {
            all.sort_by(f64::total_cmp);
            all.get(all.len() / 2).copied()
        };
        let median = |k: usize| middle(self.edits.iter().map(|e| e[k]).collect());
        Report {
            schema: "gradtess.edit/1",
            file: self.editor.file.clone(),
            unsaved: self.editor.unsaved(),
            steps: match (&self.editor.gradient, &self.editor.solid) {
                (Some(gradient), _) => gradient.steps(),
                (_, Some(solid)) => solid.steps(),
                _ => self.editor.history.labels().0.len(),
            },
            message: self.editor.message.as_ref().map(|m| m.text.clone()),
            dragged: self.editor.dragged.clone(),
            edit_frames: self.edits.len(),
            edit_to_frame_ms: median(0),
            refine_share: middle(self.edits.iter().map(|e| (e[2] + e[3]) / e[0].max(1e-9)).collect()),
            stages_ms: (0..STAGES.len()).filter_map(|k| Some((STAGES[k], median(k)?))).collect(),
        }
    }

    fn finish(&mut self, error: Option<String>) {
        if self.ending {
            return;
        }
        self.ending = true;
        let failed = error.is_some();
        self.end.borrow_mut().error = error;
        let _ = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            self.exit.send(if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS });
        }));
    }

    /// Shows the frames of widgets that are ready.
    fn present(&mut self) {
        while let Ok((size, widgets)) = self.frames.1.try_recv() {
            let shooting = self.replay.as_mut().is_some_and(|r| std::mem::take(&mut r.shooting));
            let Some(renderer) = &mut self.editor.renderer else { continue };
            let begun = Instant::now();
            let shown = renderer.screen.show([size.width, size.height], widgets, shooting);
            self.shown_ms = begun.elapsed().as_secs_f64() * 1e3;
            match shown {
                Ok(Outcome::Shown(picture)) => {
                    let name = if shooting { self.replay.as_mut().and_then(|r| r.shot.take()) } else { None };
                    if let (Some(name), Some(picture)) = (name, picture) {
                        self.write_shot(&name, &picture);
                    }
                }
                Ok(Outcome::Later) => {
                    if let Some(replay) = &mut self.replay {
                        replay.shooting = shooting;
                    }
                }
                Err(e) => self.lost(e),
            }
        }
    }

    fn write_shot(&mut self, name: &str, picture: &crate::image::Picture) {
        let folder = self.replay.as_ref().map(|r| r.folder.clone()).unwrap_or_default();
        let file = folder.join(format!("{name}.png"));
        if let Err(e) = picture.write_png(&file, &[]) {
            self.finish(Some(e.to_string()));
        }
    }

    fn lost(&mut self, e: GpuError) {
        self.finish(Some(format!("{e}; the journal keeps what was not saved")));
    }

    /// The input of the next frame: what the window has, or what the script says.
    fn input(&mut self, outer: &Context) -> Option<RawInput> {
        let mut raw = outer.input(|i| i.raw.clone());
        let outer_scale = outer.pixels_per_point();
        let native = raw.viewports.get(&raw.viewport_id).and_then(|v| v.native_pixels_per_point);
        self.native_scale = native.unwrap_or(self.native_scale);
        // From the carrier's points to the editor's.
        let to_inner = outer_scale / (self.native_scale * self.inner.zoom_factor());
        let screen = outer.input(|i| i.screen_rect());
        raw.screen_rect = Some(egui::Rect::from_min_size(egui::Pos2::ZERO, screen.size() * to_inner));
        if let Some(info) = raw.viewports.get_mut(&raw.viewport_id) {
            info.native_pixels_per_point = Some(self.native_scale);
        }
        if (to_inner - 1.0).abs() > 1e-6 {
            for event in &mut raw.events {
                match event {
                    egui::Event::PointerMoved(p) => *p = (p.to_vec2() * to_inner).to_pos2(),
                    egui::Event::PointerButton { pos, .. } => *pos = (pos.to_vec2() * to_inner).to_pos2(),
                    _ => {}
                }
            }
        }
        if self.replay.is_some() {
            return self.scripted(outer, raw);
        }
        raw.time = Some(self.begun.elapsed().as_secs_f64());
        self.write_record(&raw);
        let busy = !raw.events.is_empty() || !raw.dropped_files.is_empty() || self.repaint;
        if busy {
            self.idle_since = Instant::now();
        }
        Some(raw)
    }

    fn suspend(&mut self, on: bool) {
        if let Some(renderer) = &mut self.editor.renderer {
            renderer.screen.suspend(on);
        }
    }

    /// The window's close button: a question, where something is not saved.
    fn close_button(&mut self) {
        if !self.close.as_ref().is_some_and(CloseButton::pressed) {
            return;
        }
        let at = self.begun.elapsed().as_secs_f64();
        if let Some(record) = &mut self.record {
            let _ = record.file.write_all(script::line(at, &Action::Close(true)).as_bytes());
        }
        // Nobody answers a script's questions.
        if self.replay.as_ref().is_some_and(|r| r.ends) {
            self.closed_by_window();
        } else {
            self.editor.ask_first(Then::Quit);
            (self.repaint, self.idle_since) = (true, Instant::now());
        }
    }

    /// The window goes whatever the editor wants: nothing that is not saved is lost with it.
    fn closed_by_window(&mut self) {
        let report = self.report();
        let journal = self.editor.close(false);
        let mut end = self.end.borrow_mut();
        end.report.get_or_insert(report);
        end.journal = end.journal.take().or(journal);
        drop(end);
        self.finish(None);
    }

    fn write_record(&mut self, raw: &RawInput) {
        let Some(record) = &mut self.record else { return };
        let at = raw.time.unwrap_or(0.0);
        let mut text = String::new();
        let size = raw.screen_rect.map_or([0.0; 2], |r| [r.width(), r.height()]);
        if size != record.size {
            record.size = size;
            text += &script::line(at, &Action::Resize(size));
        }
        for action in script::actions(&raw.events, &mut record.held) {
            text += &script::line(at, &action);
        }
        for file in raw.dropped_files.iter().filter_map(|f| f.path.as_ref()) {
            text += &script::line(at, &Action::Drop(file.display().to_string()));
        }
        if record.file.write_all(text.as_bytes()).is_err() {
            self.record = None;
            self.editor.fail("the recording cannot be written; it ends here");
        }
    }

    /// Runs the editor's widgets and keeps what they paint.
    fn run_inner(&mut self, outer: &Context, raw: RawInput) {
        let before = self.editor.model.revision;
        let begun = Instant::now();
        let inner = self.inner.clone();
        let editor = &mut self.editor;
        let output = inner.run(raw, |ctx| editor.ui(ctx));
        self.repaint = output.viewport_output.values().any(|v| v.repaint_delay < Duration::from_millis(100));
        self.painted = inner.tessellate(output.shapes, output.pixels_per_point);
        let scale = output.pixels_per_point;
        let manager = outer.tex_manager();
        for (id, delta) in output.textures_delta.set {
            let mut manager = manager.write();
            match self.textures.get(&id) {
                Some(&known) => manager.set(known, delta),
                None => {
                    let known = manager.alloc("editor".to_owned(), delta.image, delta.options);
                    self.textures.insert(id, known);
                }
            }
        }
        for id in output.textures_delta.free {
            if let Some(known) = self.textures.remove(&id) {
                manager.write().free(known);
            }
        }
        // The carrier draws pixels.
        for primitive in &mut self.painted {
            let r = primitive.clip_rect;
            primitive.clip_rect =
                egui::Rect::from_min_max((r.min.to_vec2() * scale).to_pos2(), (r.max.to_vec2() * scale).to_pos2());
            if let egui::epaint::Primitive::Mesh(mesh) = &mut primitive.primitive {
                mesh.vertices.iter_mut().for_each(|v| v.pos = (v.pos.to_vec2() * scale).to_pos2());
                if let Some(&known) = self.textures.get(&mesh.texture_id) {
                    mesh.texture_id = known;
                }
            }
        }
        if self.replay.is_none() {
            outer.output_mut(|o| o.append(output.platform_output));
        }
        self.account(before, begun);
    }

    /// Times of this frame.
    fn account(&mut self, before: u64, begun: Instant) {
        let editor = &mut self.editor;
        let edited = editor.model.revision != before;
        let drawn = editor.renderer.as_ref().map(|r| r.last).unwrap_or_default();
        let stages = timing::stages(editor.model.times, &drawn, edited);
        let whole = begun.elapsed().as_secs_f64() * 1e3;
        // Fold tests come beside the frame, as in ZHHK22 5.2.
        let folds = if edited { editor.fold_cost.time.as_secs_f64() * 1e3 } else { 0.0 };
        editor.timing.add(stages, (whole - stages - folds).max(0.0));
        if edited {
            let ms = |t: Duration| t.as_secs_f64() * 1e3;
            let [refine, patches] = editor.model.times.map(ms);
            let upload = drawn.upload.map_or(0.0, ms);
            let scene = stages - refine - patches - upload;
            let widgets = (whole - stages - folds).max(0.0);
            self.edited = Some(Edited { begun, stages: [0.0, folds, refine, patches, upload, scene, widgets, 0.0] });
        }
    }

    fn set_title(&mut self, outer: &Context) {
        let star = if self.editor.unsaved() { "* " } else { "" };
        let title = format!("{star}{} - gradtess", self.editor.title());
        if title != self.title {
            outer.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

impl egui_ash::App for Shell {
    fn ui(&mut self, outer: &Context) {
        if self.ending {
            return;
        }
        match self.input(outer) {
            Some(raw) => self.run_inner(outer, raw),
            None => self.editor.tick(),
        }
        self.set_title(outer);
        // Meshes go out as they are, one layer, in order.
        // Not the layer's own painter: that one clips at the window's size in points, and these are pixels.
        let painter = egui::Painter::new(outer.clone(), egui::LayerId::background(), egui::Rect::EVERYTHING);
        let (mut vertices, mut indices) = (0, 0);
        for primitive in &self.painted {
            if let egui::epaint::Primitive::Mesh(mesh) = &primitive.primitive {
                // egui-ash panics when its buffers are full; a frame without some of its lines is better.
                if vertices + mesh.vertices.len() >= MOST_VERTICES || indices + mesh.indices.len() >= MOST_INDICES {
                    continue;
                }
                (vertices, indices) = (vertices + mesh.vertices.len(), indices + mesh.indices.len());
                painter.with_clip_rect(primitive.clip_rect).add(egui::Shape::mesh(mesh.clone()));
            }
        }
        if self.editor.quit {
            let report = self.report();
            self.end.borrow_mut().report.get_or_insert(report);
            self.editor.close(true);
            self.finish(None);
        }
    }

    fn handle_event(&mut self, event: event::Event) {
        match event {
            event::Event::ViewportEvent { event: winit::event::WindowEvent::Resized(_), .. } => {
                if let Some(renderer) = &mut self.editor.renderer {
                    renderer.screen.resized();
                }
            }
            event::Event::ViewportEvent { event: winit::event::WindowEvent::CloseRequested, .. } => {
                self.closed_by_window();
            }
            event::Event::AppEvent { event: event::AppEvent::Suspended } => self.suspend(true),
            event::Event::AppEvent { event: event::AppEvent::Resumed } => self.suspend(false),
            event::Event::AppEvent { event: event::AppEvent::LoopExiting } => {
                // However the loop ends: what is unsaved stays in the journal.
                let report = self.report();
                let journal = self.editor.close(false);
                let mut end = self.end.borrow_mut();
                end.report.get_or_insert(report);
                end.journal = end.journal.take().or(journal);
            }
            event::Event::AppEvent { event: event::AppEvent::NewEvents(_) } => {
                self.close_button();
                self.present();
                self.rest();
            }
            _ => {}
        }
    }

    fn request_redraw(&mut self, _: egui::ViewportId) -> HandleRedraw {
        self.present();
        let sender = self.frames.0.clone();
        HandleRedraw::Handle(Box::new(move |size, widgets| {
            // The frame is shown at the next event: the swapchain stays on its own thread.
            let _ = sender.send((size, widgets));
        }))
    }
}

impl Shell {
    /// Sleeps a little while nothing happens, for egui-ash asks for frames without end.
    fn rest(&mut self) {
        if let Some(edited) = self.edited.take() {
            let whole = edited.begun.elapsed().as_secs_f64() * 1e3;
            let mut stages = edited.stages;
            (stages[0], stages[7]) = (whole, self.shown_ms);
            self.editor.timing.input_to_frame = Some(whole);
            self.editor.timing.refine_share = Some((stages[2] + stages[3]) / whole.max(1e-9));
            if self.edits.len() < 1 << 16 {
                self.edits.push(stages);
            }
        }
        match &self.replay {
            Some(replay) => {
                if replay.wait_until.is_some() || replay.pace > 0.0 {
                    std::thread::sleep(Duration::from_millis(2));
                }
            }
            None => {
                let idle = self.idle_since.elapsed();
                if idle > Duration::from_secs(1) {
                    self.editor.rest();
                }
                if idle > Duration::from_millis(300) {
                    std::thread::sleep(Duration::from_millis(if idle > Duration::from_secs(5) { 60 } else { 25 }));
                }
            }
        }
    }
}
