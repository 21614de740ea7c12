//! Times of every stage, live, and captures by the protocol of `bench`.

use super::editor::Editor;
use super::render::Drawn;
use crate::gpu::Show;
use crate::patch::points::Irregular;
use crate::patch::tess::TessRule;
use crate::patch::Kind;
use crate::refine::Mode;
use egui::{Color32, Ui};
use std::collections::VecDeque;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Frames in the plot.
const PLOTTED: usize = 240;

/// Live times.
#[derive(Default)]
pub struct Timing {
    /// Of each frame: its stages, and what the window took besides, ms.
    frames: VecDeque<[f64; 2]>,
    /// From the pointer's event to the end of the frame that shows what it did, ms.
    pub input_to_frame: Option<f64>,
    /// Share of the last edit's frame that went into refinement and patches.
    pub refine_share: Option<f64>,
    capture: Option<Capture>,
}

/// A capture that runs, or has run.
struct Capture {
    child: Option<Child>,
    folder: PathBuf,
    scene: PathBuf,
    said: Result<String, String>,
}

impl Drop for Capture {
    fn drop(&mut self) {
        if let Some(child) = &mut self.child {
            // Its files are whole after every repeat; the one that runs is not counted.
            let _ = child.kill();
            let _ = child.wait();
        }
        let _ = std::fs::remove_file(&self.scene);
    }
}

impl Timing {
    /// Adds a frame: time of the scene's stages, and of all else, ms.
    pub fn add(&mut self, stages: f64, rest: f64) {
        if self.frames.len() == PLOTTED {
            self.frames.pop_front();
        }
        self.frames.push_back([stages, rest]);
    }

    /// Looks whether the capture has ended.
    fn poll(&mut self) {
        let Some(capture) = &mut self.capture else { return };
        let Some(child) = &mut capture.child else { return };
        if let Ok(Some(status)) = child.try_wait() {
            let mut said = String::new();
            if let Some(mut out) = child.stderr.take() {
                let _ = std::io::Read::read_to_string(&mut out, &mut said);
            }
            capture.child = None;
            capture.said = match status.success() {
                true => Ok(format!("written to {}", capture.folder.display())),
                false => Err(said.lines().last().unwrap_or("the capture failed").to_owned()),
            };
        }
    }

    /// Whether a capture runs.
    pub fn capturing(&self) -> bool {
        self.capture.as_ref().is_some_and(|c| c.child.is_some())
    }
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Host time of the scene's stages in a frame, ms.
pub fn stages(model: [Duration; 2], drawn: &Drawn, edited: bool) -> f64 {
    let edit = if edited { ms(model[0]) + ms(model[1]) + drawn.upload.map_or(0.0, ms) } else { 0.0 };
    let frame = &drawn.frame;
    edit + ms(drawn.prepare) + (frame.record_ns + frame.submit_ns + frame.wait_ns) as f64 * 1e-6
}

impl Editor {
    /// The panel of times.
    pub fn timing_panel(&mut self, ui: &mut Ui) {
        self.timing.poll();
        ui.heading("Times");
        let drawn = self.renderer.as_ref().map(|r| r.last).unwrap_or_default();
        let gpu = drawn.frame.gpu;
        let [refine, patches] = self.model.times;
        let host = |time: Option<Duration>| time.map_or("NA".to_owned(), |t| format!("{:.3}", ms(t)));
        let device = |ns: Option<u64>| ns.map_or("NA".to_owned(), |ns| format!("{:.3}", ns as f64 * 1e-6));
        let both = |a: Option<u64>, b: Option<u64>| match (a, b) {
            (None, None) => None,
            (a, b) => Some(a.unwrap_or(0) + b.unwrap_or(0)),
        };
        let transition = both(gpu.bicubic_transition_ns, gpu.gregory_transition_ns);
        let ns = |ns: u64| Some(Duration::from_nanos(ns));
        let rows = [
            ("refine", host(Some(refine)), String::new()),
            ("patches", host(Some(patches)), String::new()),
            ("upload", host(drawn.upload), device(gpu.upload_ns)),
            ("record", host(ns(drawn.frame.record_ns + drawn.prepare.as_nanos() as u64)), String::new()),
            ("submit, wait", host(ns(drawn.frame.submit_ns + drawn.frame.wait_ns)), String::new()),
            ("regular", String::new(), device(gpu.bicubic_ns)),
            ("transition", String::new(), device(transition)),
            ("Gregory", String::new(), device(gpu.gregory_ns)),
            ("overlay", String::new(), device(gpu.overlay_ns)),
            ("frame", String::new(), device(gpu.frame_ns)),
        ];
        egui::Grid::new("times").num_columns(3).striped(true).show(ui, |ui| {
            ui.weak("ms");
            ui.weak("CPU");
            ui.weak("GPU");
            ui.end_row();
            for (name, cpu, gpu) in rows {
                ui.label(name);
                ui.monospace(cpu);
                ui.monospace(gpu);
                ui.end_row();
            }
        });
        ui.separator();
        if self.prevent_folds {
            let cost = self.fold_cost;
            ui.label(format!(
                "fold test {:.3} ms, {} tries, {} patches moved; not part of the frame",
                ms(cost.time),
                cost.tries,
                cost.patches
            ));
        }
        if let Some(t) = self.timing.input_to_frame {
            let share =
                self.timing.refine_share.map_or(String::new(), |s| format!(", {:.0} % of it refinement", s * 100.0));
            ui.label(format!("edit to frame {t:.2} ms{share}"));
        }
        self.plot(ui);
        ui.separator();
        self.counts(ui);
        ui.separator();
        self.switches(ui);
        ui.separator();
        self.capture(ui);
    }

    /// Patch counts as `stats` has them.
    fn counts(&mut self, ui: &mut Ui) {
        let mut counts = [0usize; 4];
        for face in &self.model.table.faces {
            let first = if face.kind == Kind::Bicubic { 0 } else { 2 };
            counts[first] += 1;
            counts[first + 1] += usize::from(face.transition != 0);
        }
        let [b, bt, g, gt] = counts;
        ui.label(format!("bicubic {b} ({bt}), Gregory {g} ({gt})"));
        ui.label(format!("total {}, control points {}", b + g, self.model.table.control.len()));
    }

    /// How the scene is drawn.
    fn switches(&mut self, ui: &mut Ui) {
        let mut drawing = self.model.drawing;
        ui.horizontal(|ui| {
            let adaptive = matches!(drawing.mode, Mode::Adaptive { .. });
            if ui.selectable_label(adaptive, "adaptive").clicked() {
                drawing.mode = Mode::Adaptive { isolate: 0 };
            }
            let deepest = crate::edit::place::deepest_edit(&self.model.scene);
            let colours = self.model.scene.colours.iter().map(|e| e.level).max().unwrap_or(0);
            let level = deepest.max(colours).max(1);
            if ui.selectable_label(!adaptive, format!("global, level {level}")).clicked() {
                drawing.mode = Mode::Global(level);
            }
        });
        ui.horizontal(|ui| {
            for (kind, name) in [(Irregular::Gregory, "Gregory"), (Irregular::Bicubic, "bicubic")] {
                if ui.selectable_label(drawing.irregular == kind, name).clicked() {
                    drawing.irregular = kind;
                }
            }
            ui.weak("irregular faces");
        });
        if drawing != self.model.drawing {
            self.draw(drawing);
        }
        let (mut number, which) = match self.look.tess {
            TessRule::Fixed(t) => (t, 0),
            TessRule::Base(t) => (t, 1),
            TessRule::Pixels(p) => (p, 2),
        };
        let mut chosen = which;
        ui.horizontal(|ui| {
            for (i, name) in ["factor", "base", "pixels"].into_iter().enumerate() {
                if ui.selectable_label(which == i, name).clicked() {
                    chosen = i;
                    number = [16.0, 32.0, 6.0][i];
                }
            }
            let most = if chosen == 1 { 256.0 } else { 64.0 };
            ui.add(egui::DragValue::new(&mut number).clamp_range(1.0..=most).speed(0.2));
        });
        self.look.tess = match chosen {
            0 => TessRule::Fixed(number.clamp(1.0, 64.0)),
            1 => TessRule::Base(number),
            _ => TessRule::Pixels(number),
        };
    }

    fn plot(&mut self, ui: &mut Ui) {
        let size = egui::vec2(ui.available_width(), 60.0);
        let (rect, _) = ui.allocate_exact_size(size, egui::Sense::hover());
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
        let frames = &self.timing.frames;
        let most = frames.iter().map(|f| f[0] + f[1]).fold(1.0f64, f64::max);
        let step = rect.width() / PLOTTED as f32;
        let mut mesh = egui::Mesh::default();
        for (i, [stages, rest]) in frames.iter().enumerate() {
            let x = rect.left() + step * i as f32;
            let high = |t: f64| (t / most) as f32 * rect.height();
            let (a, b) = (rect.bottom() - high(*stages), rect.bottom() - high(stages + rest));
            let bar =
                |top: f32, bottom: f32| egui::Rect::from_min_max(egui::pos2(x, top), egui::pos2(x + step, bottom));
            mesh.add_colored_rect(bar(a, rect.bottom()), Color32::from_rgb(90, 150, 220));
            mesh.add_colored_rect(bar(b, a), Color32::from_gray(120));
        }
        painter.add(egui::Shape::mesh(mesh));
        let last = frames.back().map_or(0.0, |f| f[0] + f[1]);
        ui.weak(format!("last {last:.1} ms, highest {most:.1} ms; blue: the scene's stages, grey: the window"));
    }

    fn capture(&mut self, ui: &mut Ui) {
        if self.timing.capturing() {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label("capturing frames");
                if ui.button("Stop").clicked() {
                    self.timing.capture = None;
                }
            });
            return;
        }
        if ui.button("Capture frames").on_hover_text("writes the files of `gradtess bench`").clicked() {
            self.start_capture();
        }
        if let Some(capture) = &self.timing.capture {
            match &capture.said {
                Ok(text) => ui.label(text),
                Err(text) => ui.colored_label(ui.visuals().error_fg_color, text),
            };
        }
    }

    /// Runs `gradtess bench` on the scene as it is, in a process of its own: its frames are not the window's.
    pub fn start_capture(&mut self) {
        let stem = self.file.as_deref().and_then(|f| f.file_stem()).map(|s| s.to_string_lossy().into_owned());
        let stem = stem.unwrap_or_else(|| "untitled".to_owned());
        let time = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default().as_secs();
        let folder = self.folder().join(format!("{stem}-capture-{time}"));
        let scene = std::env::temp_dir().join(format!("gradtess-capture-{}-{time}.json", std::process::id()));
        if let Err(e) = self.model.scene.save(&scene) {
            return self.fail(e);
        }
        let Ok(program) = std::env::current_exe() else { return self.fail("the program cannot find itself") };
        let [w, h] = self.view.size();
        let seen = self.view.seen().map(|x| x.to_string()).join(",");
        let (flag, value) = match self.look.tess {
            TessRule::Fixed(t) => ("--tess", t),
            TessRule::Base(t) => ("--tess-base", t),
            TessRule::Pixels(p) => ("--pixels", p),
        };
        let mut command = Command::new(program);
        command.arg("bench").arg(&scene).arg("-o").arg(&folder).arg("--quiet");
        command.arg("--size").arg(format!("{w}x{h}")).arg(format!("--view={seen}")).arg(flag).arg(value.to_string());
        if let Some(renderer) = &self.renderer {
            command.arg("--device").arg(renderer.gpu.device().index.to_string());
        }
        if let Mode::Global(level) = self.model.drawing.mode {
            command.args(["--mode", "global", "--level", &level.to_string()]);
        }
        if self.model.drawing.irregular == Irregular::Bicubic {
            command.args(["--patches", "bicubic"]);
        }
        let child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
        match child {
            Ok(child) => {
                let said = Ok(String::new());
                self.timing.capture = Some(Capture { child: Some(child), folder, scene, said });
            }
            Err(e) => self.fail(format_args!("the capture cannot be started: {e}")),
        }
    }

    /// Names of what can be shown.
    pub fn shows() -> [(Show, &'static str); 5] {
        [
            (Show::Surface, "surface"),
            (Show::SurfaceWire, "surface and wire"),
            (Show::Wire, "wire"),
            (Show::Patches, "kinds of patches"),
            (Show::Levels, "levels"),
        ]
    }
}
