//! The editor's window. The only room that knows egui; what edits mean is in [`mod@crate::edit`].
//!
//! ```text
//!  window, or script --Shell--> Editor: panels, canvas, keys, dialogs --> crate::edit
//!                                  |
//!                               Renderer --> crate::gpu: the scene as a texture, the swapchain
//! ```

mod canvas;
#[cfg(test)]
mod clicks;
mod colour;
mod dialog;
mod editor;
mod files;
mod gradient;
#[cfg(test)]
mod gradient_habits;
mod gradient_panel;
#[cfg(test)]
mod habits;
mod keys;
mod overlay;
mod panel;
mod reference;
mod render;
pub mod script;
mod shaping;
mod shell;
mod surface;
mod surface_canvas;
#[cfg(test)]
mod surface_habits;
mod surface_journal;
mod surface_picture;
mod timing;
mod view;

use crate::gpu::{CloseButton, Gpu, GpuError, GpuOptions, SharedAllocator};
pub use editor::Dragged;
use editor::Editor;
use egui_ash::{AppCreator, AshRenderState, CreationContext, RunOption};
use render::Renderer;
pub use shell::Report;
use shell::{End, Record, Replay, Shell};
use std::any::Any;
use std::cell::RefCell;
use std::panic::{catch_unwind, resume_unwind, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use thiserror::Error;

/// What to run.
#[derive(Clone, Debug, Default)]
pub struct Launch {
    /// Scene to open.
    pub scene: Option<PathBuf>,
    /// Script to replay.
    pub script: Option<PathBuf>,
    /// Real seconds a second of the script.
    pub pace: f64,
    /// Whether the window stays when the script ends.
    pub stay: bool,
    /// Where the script's screenshots go.
    pub screenshots: PathBuf,
    /// File for a recording.
    pub record: Option<PathBuf>,
    /// Width and height of the window, points.
    pub size: [f32; 2],
    /// The device.
    pub gpu: GpuOptions,
    /// Whether the window's surface has to be one that converts colours to sRGB.
    pub converting: bool,
}

/// Why the editor ended without being asked to.
#[derive(Debug, Error)]
pub enum AppError {
    /// There is no display, or no window on it.
    #[error("{0}")]
    Window(String),
    /// The device.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A script or recording.
    #[error("{0}")]
    Script(String),
    /// What the validation layer reported.
    #[error("the validation layer reports: {0}")]
    Validation(String),
}

/// How the editor ended.
#[derive(Debug, Default)]
pub struct Ended {
    /// The window was closed over unsaved work, which this journal holds.
    pub journal: Option<PathBuf>,
    /// What happened.
    pub report: Option<Report>,
}

struct Creator {
    launch: Launch,
    end: Rc<RefCell<End>>,
    parts: RefCell<Option<(Option<Replay>, Option<Record>)>>,
    messages: Rc<RefCell<Option<String>>>,
}

impl AppCreator<SharedAllocator> for Creator {
    type App = Watched;

    fn create(&self, cc: CreationContext) -> (Watched, AshRenderState<SharedAllocator>) {
        let opened =
            Gpu::for_window(&self.launch.gpu, &cc.required_instance_extensions, cc.main_window, self.launch.converting);
        let (gpu, screen) = match opened {
            Ok(opened) => opened,
            // egui-ash has no way to say no here; `run` catches this.
            Err(e) => resume_unwind(Box::new(AppError::Gpu(e))),
        };
        let state = screen.render_state();
        let mut editor = Editor::new(files::state_folder());
        editor.renderer = Some(Renderer::new(gpu, screen, cc.image_registry));
        begin(&mut editor, &self.launch);
        let (replay, record) = self.parts.borrow_mut().take().unwrap_or_default();
        let scale = cc.main_window.scale_factor() as f32;
        // egui-ash takes the zoom for the whole scale, so the carrier's stays 1; Ctrl and + are for the editor's own.
        cc.context.options_mut(|o| o.zoom_with_keyboard = false);
        let close = CloseButton::take(cc.main_window);
        let shell = Shell::new(editor, replay, record, cc.exit_signal, Rc::clone(&self.end), close, scale);
        (Watched { shell, messages: Rc::clone(&self.messages) }, state)
    }
}

/// Opens what was asked for.
fn begin(editor: &mut Editor, launch: &Launch) {
    match &launch.scene {
        Some(scene) => editor.open(scene),
        None => editor.offer_left_behind(None),
    }
}

/// The shell, and what the validation layer has said by the time it goes.
struct Watched {
    shell: Shell,
    messages: Rc<RefCell<Option<String>>>,
}

impl egui_ash::App for Watched {
    fn ui(&mut self, ctx: &egui::Context) {
        self.shell.ui(ctx);
    }

    fn handle_event(&mut self, event: egui_ash::event::Event) {
        self.shell.handle_event(event);
        if let Some(renderer) = &self.shell.editor.renderer {
            if let Some(m) = renderer.gpu.messages().first() {
                self.messages.borrow_mut().get_or_insert_with(|| format!("{}: {m}", m.id));
            }
        }
    }

    fn request_redraw(&mut self, id: egui::ViewportId) -> egui_ash::HandleRedraw {
        self.shell.request_redraw(id)
    }
}

/// Opens the window and runs until it closes.
///
/// # Errors
/// There is no display; the device, the script or the recording.
pub fn run(launch: Launch) -> Result<Ended, AppError> {
    let replay = match &launch.script {
        Some(file) => {
            let script = script::load(file).map_err(AppError::Script)?;
            Some(Replay::new(script, launch.pace, launch.screenshots.clone(), !launch.stay))
        }
        None => None,
    };
    let record = match &launch.record {
        Some(file) => Some(new_record(file)?),
        None => None,
    };
    let set = |name: &str| std::env::var_os(name).is_some_and(|v| !v.is_empty());
    if !set("DISPLAY") && cfg!(all(unix, not(target_os = "macos"))) {
        return Err(AppError::Window(
            "there is no display; set DISPLAY, or run it under `xvfb-run` (`gradtess render` needs none)".to_owned(),
        ));
    }
    let end: Rc<RefCell<End>> = Rc::default();
    let messages: Rc<RefCell<Option<String>>> = Rc::default();
    let viewport = egui::ViewportBuilder::default()
        .with_title("gradtess")
        .with_inner_size(launch.size)
        .with_min_inner_size([480.0, 320.0]);
    let option = RunOption { viewport_builder: Some(viewport), follow_system_theme: false, ..RunOption::default() };
    let creator = Creator {
        launch,
        end: Rc::clone(&end),
        parts: RefCell::new(Some((replay, record))),
        messages: Rc::clone(&messages),
    };
    // egui-ash and winit panic where no window can be made; that is an answer, not a crash.
    let hook = std::panic::take_hook();
    let said: std::sync::Arc<std::sync::Mutex<String>> = Default::default();
    let keep = std::sync::Arc::clone(&said);
    std::panic::set_hook(Box::new(move |info| {
        if let Ok(mut text) = keep.lock() {
            *text = info.to_string();
        }
    }));
    let ran = catch_unwind(AssertUnwindSafe(|| egui_ash::run("gradtess", creator, option)));
    std::panic::set_hook(hook);
    if let Err(panic) = ran {
        let text = said.lock().map(|t| t.clone()).unwrap_or_default();
        return Err(fault(panic, &text));
    }
    let end = std::mem::take(&mut *end.borrow_mut());
    if let Some(e) = end.error {
        return Err(AppError::Window(e));
    }
    if let Some(message) = messages.borrow_mut().take() {
        return Err(AppError::Validation(message));
    }
    Ok(Ended { journal: end.journal, report: end.report })
}

fn new_record(file: &Path) -> Result<Record, AppError> {
    let made = std::fs::File::create(file);
    let file = made.map_err(|e| AppError::Script(format!("{}: cannot be written ({e})", file.display())))?;
    Ok(Record { file, held: egui::Modifiers::NONE, size: [0.0; 2] })
}

fn fault(panic: Box<dyn Any + Send>, text: &str) -> AppError {
    match panic.downcast::<AppError>() {
        Ok(e) => *e,
        Err(_) => {
            let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
            AppError::Window(format!("the window system failed ({line}); the journal keeps what was not saved"))
        }
    }
}
