//! The keyboard: one table, for the keys themselves and for the list under `?`.

use super::dialog::Dialog;
use super::editor::{Editor, Tool};
use crate::edit::handle::{Kind, Stage};
use crate::scene::surface::INFINITE;
use egui::{Context, Key, Modifiers};
use glam::DVec2;

/// What a key does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// A window for a new scene.
    New,
    /// A window to open a file.
    Open,
    /// Writes the file.
    Save,
    /// Writes another file.
    SaveAs,
    /// Closes the editor.
    Quit,
    /// A step back.
    Undo,
    /// A step again.
    Redo,
    /// Tools.
    Take(Tool),
    /// Makes a face of the polygon that is drawn.
    ClosePolygon,
    /// Takes its last corner back.
    TakeCornerBack,
    /// Which mesh.
    To(Stage),
    /// A level finer (true) or coarser.
    Finer(bool),
    /// Everything in the canvas.
    Fit,
    /// One scene unit of the file a pixel.
    OneToOne,
    /// Closer (true) or farther.
    Zoom(bool),
    /// All handles.
    SelectAll,
    /// The next handle.
    SelectNext,
    /// Nothing, and what goes on is given up.
    Escape,
    /// Takes edits away.
    Reset,
    /// By pixels right and up; by ten with Shift.
    Nudge(i8, i8),
    /// The selected colour.
    CopyColour,
    /// Gives it to the selected handles.
    PasteColour,
    /// Shows or hides.
    Toggle(Shows),
    /// Writes frame timings.
    Capture,
    /// This list.
    Help,
}

/// What can be shown or hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shows {
    /// The control mesh.
    Mesh,
    /// Handles.
    Handles,
    /// Control points in place of limit points.
    Control,
    /// Times.
    Timing,
    /// Prevention of folds.
    Folds,
}

/// A line of the keyboard list.
pub struct Binding {
    /// With Ctrl, with Shift.
    pub with: (bool, bool),
    /// The key.
    pub key: Key,
    /// Its name in the list.
    pub name: &'static str,
    /// What it does.
    pub command: Command,
    /// In words; empty: in the line above.
    pub what: &'static str,
}

const fn bind(ctrl: bool, shift: bool, key: Key, name: &'static str, command: Command, what: &'static str) -> Binding {
    Binding { with: (ctrl, shift), key, name, command, what }
}

/// The keyboard.
pub const KEYS: &[Binding] = &[
    bind(true, false, Key::N, "Ctrl+N", Command::New, "new scene"),
    bind(true, false, Key::O, "Ctrl+O", Command::Open, "open"),
    bind(true, false, Key::S, "Ctrl+S", Command::Save, "save"),
    bind(true, true, Key::S, "Ctrl+Shift+S", Command::SaveAs, "save as"),
    bind(true, false, Key::Q, "Ctrl+Q", Command::Quit, "quit"),
    bind(true, false, Key::Z, "Ctrl+Z", Command::Undo, "undo"),
    bind(true, true, Key::Z, "Ctrl+Shift+Z, Ctrl+Y", Command::Redo, "redo"),
    bind(true, false, Key::Y, "", Command::Redo, ""),
    bind(false, false, Key::V, "V", Command::Take(Tool::Move), "select and move"),
    bind(false, false, Key::B, "B", Command::Take(Tool::Brush), "brush"),
    bind(false, false, Key::E, "E", Command::Take(Tool::Sharp), "sharp edges"),
    bind(false, false, Key::I, "I", Command::Take(Tool::Pick), "eyedropper"),
    bind(false, false, Key::D, "D", Command::Take(Tool::Draw), "draw a polygon click by click"),
    bind(false, false, Key::Enter, "Enter", Command::ClosePolygon, "close the polygon that is drawn"),
    bind(false, false, Key::Backspace, "Backspace", Command::TakeCornerBack, "take its last corner back"),
    bind(false, false, Key::M, "M", Command::To(Stage::Input), "edit the input mesh M"),
    bind(false, false, Key::Num0, "0 to 6", Command::To(Stage::Level(0)), "edit level 0 to 6"),
    bind(false, false, Key::Num1, "", Command::To(Stage::Level(1)), ""),
    bind(false, false, Key::Num2, "", Command::To(Stage::Level(2)), ""),
    bind(false, false, Key::Num3, "", Command::To(Stage::Level(3)), ""),
    bind(false, false, Key::Num4, "", Command::To(Stage::Level(4)), ""),
    bind(false, false, Key::Num5, "", Command::To(Stage::Level(5)), ""),
    bind(false, false, Key::Num6, "", Command::To(Stage::Level(6)), ""),
    bind(false, false, Key::PageUp, "Page Up, Page Down", Command::Finer(true), "finer, coarser level"),
    bind(false, false, Key::PageDown, "", Command::Finer(false), ""),
    bind(false, false, Key::F, "F", Command::Fit, "fit the scene to the window"),
    bind(false, true, Key::F, "Shift+F", Command::OneToOne, "one unit a pixel"),
    bind(false, false, Key::Plus, "+, -", Command::Zoom(true), "zoom"),
    bind(false, false, Key::Equals, "", Command::Zoom(true), ""),
    bind(false, false, Key::Minus, "", Command::Zoom(false), ""),
    bind(true, false, Key::A, "Ctrl+A", Command::SelectAll, "select all handles in view"),
    bind(false, false, Key::Tab, "Tab", Command::SelectNext, "select the next handle"),
    bind(false, false, Key::Escape, "Esc", Command::Escape, "give up, select nothing"),
    bind(false, false, Key::Delete, "Delete", Command::Reset, "take the selected handles' edits away"),
    bind(false, false, Key::ArrowLeft, "arrows", Command::Nudge(-1, 0), "move by a pixel, with Shift by ten"),
    bind(false, false, Key::ArrowRight, "", Command::Nudge(1, 0), ""),
    bind(false, false, Key::ArrowUp, "", Command::Nudge(0, 1), ""),
    bind(false, false, Key::ArrowDown, "", Command::Nudge(0, -1), ""),
    bind(true, false, Key::C, "Ctrl+C, Ctrl+V", Command::CopyColour, "copy and paste a colour"),
    bind(true, false, Key::V, "", Command::PasteColour, ""),
    bind(false, false, Key::G, "G", Command::Toggle(Shows::Mesh), "show the control mesh"),
    bind(false, false, Key::H, "H", Command::Toggle(Shows::Handles), "show handles"),
    bind(false, false, Key::C, "C", Command::Toggle(Shows::Control), "control points in place of limit points"),
    bind(false, false, Key::P, "P", Command::Toggle(Shows::Folds), "prevent folds"),
    bind(false, false, Key::T, "T", Command::Toggle(Shows::Timing), "times"),
    bind(false, true, Key::T, "Shift+T", Command::Capture, "capture frame timings"),
    bind(false, false, Key::F1, "?, F1", Command::Help, "this list"),
];

/// The pointer, for the same list.
pub const POINTER: &[(&str, &str)] = &[
    ("click, Shift+click", "select, add to the selection; click again for the next handle at that place"),
    ("drag", "move a handle; on nothing: select with a box"),
    ("wheel", "zoom at the pointer"),
    ("Alt+wheel", "radius of the brush"),
    ("middle drag, Space+drag", "pan"),
];

/// What is otherwise with gradient meshes, for the same list.
pub const GRADIENT: &[(&str, &str)] = &[
    ("U, V", "split the patch under the pointer along u, v"),
    ("Delete", "remove the split whose curve is selected"),
    ("C", "handles mirror each other (C1), or are free (C0)"),
    ("W", "show twists"),
    ("click", "select a point and its sectors, a handle, a twist or a curve"),
    ("drag", "move a point, a handle or a twist"),
];

/// The lines of the keyboard list, for gradient meshes or for subdivision meshes.
pub fn listed(gradient: bool) -> Vec<(&'static str, &'static str)> {
    let keys = KEYS.iter().filter(|b| !b.name.is_empty() && (!gradient || serves_gradients(b.command)));
    let mut all: Vec<_> = keys.map(|b| (b.name, b.what)).collect();
    if gradient {
        all.splice(0..0, GRADIENT.iter().copied());
    }
    all.extend(POINTER.iter().copied().filter(|(name, _)| !gradient || !GRADIENT_POINTER.contains(name)));
    all
}

/// Uses of the pointer that gradient meshes have not, or have otherwise.
const GRADIENT_POINTER: &[&str] = &["click, Shift+click", "drag", "Alt+wheel"];

impl Editor {
    /// Does what the keys of this frame say, unless a text field has them.
    pub fn keys(&mut self, ctx: &Context) {
        let typing = ctx.wants_keyboard_input();
        let (events, shift) = ctx.input(|i| (i.events.clone(), i.modifiers.shift));
        for event in events {
            match event {
                egui::Event::Key { key, pressed: true, modifiers, .. } => {
                    if let Some(command) = bound(key, modifiers) {
                        let always = matches!(command, Command::Save | Command::SaveAs | Command::Escape);
                        if !typing || always {
                            self.obey(command, modifiers.shift || shift);
                        }
                    }
                }
                egui::Event::Text(text) if text == "?" && !typing => self.obey(Command::Help, false),
                egui::Event::Copy if !typing => self.obey(Command::CopyColour, false),
                egui::Event::Paste(text) if !typing => {
                    match super::colour::from_hex(&text) {
                        Some(colour) => self.copied = Some(colour),
                        None if self.copied.is_none() => self.say("the clipboard holds no colour such as #e8695c"),
                        None => {}
                    }
                    self.obey(Command::PasteColour, false);
                }
                _ => {}
            }
        }
    }

    /// What a key does to a surface in space; `false`: what it does to all scenes.
    fn surface_obeys(&mut self, command: Command) -> bool {
        let Some(solid) = &mut self.solid else { return false };
        let level = &mut solid.options.level;
        match command {
            Command::To(Stage::Level(l)) => *level = l,
            Command::To(Stage::Input) => *level = 0,
            Command::Finer(true) => *level = (*level + 1).min(6),
            Command::Finer(false) => *level = level.saturating_sub(1),
            Command::Take(Tool::Sharp) => self.sharpen_selected(|s| if s.is_finite() { INFINITE } else { 0.0 }),
            Command::Reset => self.sharpen_selected(|_| 0.0),
            Command::Nudge(0, up) => self.sharpen_selected(|s| s.min(INFINITE) + 0.5 * f64::from(up)),
            Command::SelectAll => solid.selected = solid.edges().collect(),
            Command::Escape if self.dialog.is_none() => solid.selected.clear(),
            Command::Zoom(closer) => {
                let by = if closer { 1.0 / 1.25 } else { 1.25 };
                solid.orbit.distance = (solid.orbit.distance * by).clamp(0.02, 50.0);
            }
            Command::New
            | Command::Open
            | Command::Quit
            | Command::Save
            | Command::SaveAs
            | Command::Undo
            | Command::Redo
            | Command::Fit
            | Command::Escape
            | Command::Help
            | Command::Toggle(Shows::Mesh | Shows::Timing) => return false,
            // The others are for meshes in the plane.
            _ => {}
        }
        true
    }

    /// Does what a key stands for.
    pub fn obey(&mut self, command: Command, shift: bool) {
        if self.dialog.is_some() && !matches!(command, Command::Escape | Command::Help) {
            return;
        }
        if let Some(gradient) = &mut self.gradient {
            match command {
                Command::Reset => return self.remove_selected_split(),
                Command::CopyColour => {
                    let colour = self.selected_colour().unwrap_or(self.brush.colour);
                    self.copied = Some(colour);
                    return self.say(format_args!("copied {}", super::colour::to_hex(colour)));
                }
                Command::PasteColour => {
                    return match self.copied {
                        Some(colour) => self.colour_selected(colour, false),
                        None => self.say("no colour was copied"),
                    };
                }
                Command::Nudge(x, y) => {
                    let by = if shift { 10.0 } else { 1.0 };
                    return self.nudge_gradient(DVec2::new(f64::from(x), f64::from(y)) * by);
                }
                Command::Escape if self.dialog.is_none() => {
                    gradient.cancel();
                    gradient.selected = None;
                    self.hand.gradient = None;
                    return;
                }
                _ if !serves_gradients(command) => return,
                _ => {}
            }
        }
        if self.solid.is_some() && self.surface_obeys(command) {
            return;
        }
        match command {
            Command::New => self.ask_first(super::dialog::Then::New),
            Command::Open => self.ask_first(super::dialog::Then::Browse),
            Command::Quit => self.ask_first(super::dialog::Then::Quit),
            Command::Save => self.save_or_ask(),
            Command::SaveAs => self.dialog = Some(Dialog::save(self)),
            Command::Undo => self.step(false),
            Command::Redo => self.step(true),
            Command::Take(tool) => self.tool = tool,
            Command::ClosePolygon => self.close_polygon(),
            Command::TakeCornerBack => drop(self.hand.corners.pop()),
            Command::To(stage) => self.set_stage(stage),
            Command::Finer(finer) => {
                let next = match (self.stage, finer) {
                    (Stage::Input, true) => Stage::Level(0),
                    (Stage::Input | Stage::Level(0), false) => Stage::Input,
                    (Stage::Level(l), true) => Stage::Level((l + 1).min(6)),
                    (Stage::Level(l), false) => Stage::Level(l - 1),
                };
                self.set_stage(next);
            }
            Command::Fit => self.fit(),
            Command::OneToOne => self.view.unit = 1.0,
            Command::Zoom(closer) => {
                let size = crate::edit::drag::size_of(&self.model.scene);
                let about = self.view.rect.center();
                self.view.zoom(if closer { 1.25 } else { 0.8 }, about, size);
            }
            Command::SelectAll => self.select_all(),
            Command::SelectNext => self.select_next(),
            Command::Escape => {
                if self.dialog.take().is_none() {
                    if !self.hand.corners.is_empty() {
                        self.hand.corners.clear();
                    } else if self.in_gesture() {
                        self.cancel();
                        self.hand = Default::default();
                    } else {
                        self.selection.clear();
                    }
                }
            }
            Command::Reset => self.reset_selected(),
            Command::Nudge(x, y) => {
                let by = if shift { 10.0 } else { 1.0 };
                self.nudge(DVec2::new(f64::from(x), f64::from(y)) * by);
            }
            Command::CopyColour => self.copy_colour(),
            Command::PasteColour => {
                if let Some(colour) = self.copied {
                    self.brush.colour = colour;
                    self.paint_selected(colour);
                }
            }
            Command::Toggle(what) => {
                let flag = match what {
                    Shows::Mesh => &mut self.shown.mesh,
                    Shows::Handles => &mut self.shown.handles,
                    Shows::Control => &mut self.shown.control,
                    Shows::Timing => &mut self.timing_open,
                    Shows::Folds => &mut self.prevent_folds,
                };
                *flag = !*flag;
            }
            Command::Capture => self.start_capture(),
            Command::Help => {
                let open = matches!(self.dialog, Some(Dialog::Keys));
                self.dialog = if open { None } else { Some(Dialog::Keys) };
            }
        }
    }

    fn copy_colour(&mut self) {
        let id = self.selection.iter().find(|id| matches!(id.kind, Kind::Colour | Kind::Sector)).copied();
        let found = id.and_then(|id| self.overlay().handles.iter().find(|h| h.id == id).map(|h| h.colour));
        let colour = found.unwrap_or(self.brush.colour);
        self.copied = Some(colour);
        self.say(format_args!("copied {}", super::colour::to_hex(colour)));
    }
}

/// Whether a command is for gradient meshes, too; the others are for subdivision meshes.
pub fn serves_gradients(command: Command) -> bool {
    matches!(
        command,
        Command::Zoom(_)
            | Command::New
            | Command::Open
            | Command::Quit
            | Command::Save
            | Command::SaveAs
            | Command::Undo
            | Command::Redo
            | Command::Fit
            | Command::OneToOne
            | Command::Escape
            | Command::Help
            | Command::Nudge(..)
            | Command::CopyColour
            | Command::PasteColour
            | Command::Toggle(Shows::Mesh | Shows::Handles | Shows::Timing | Shows::Folds)
    )
}

fn bound(key: Key, modifiers: Modifiers) -> Option<Command> {
    let ctrl = modifiers.ctrl || modifiers.command;
    let exact = KEYS.iter().find(|b| b.key == key && b.with == (ctrl, modifiers.shift));
    // Shift makes the arrows' steps ten times as long.
    let nudge = || KEYS.iter().find(|b| b.key == key && !ctrl && matches!(b.command, Command::Nudge(..)));
    exact.or_else(nudge).map(|b| b.command)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_readme_has_the_same_list() {
        let readme = include_str!("../../README.md");
        for (name, what) in listed(false).into_iter().chain(listed(true)) {
            let row = format!("| {name} | {what} |");
            assert!(readme.contains(&row), "{row}");
        }
    }

    #[test]
    fn no_key_means_two_things_and_every_command_has_words() {
        for (i, a) in KEYS.iter().enumerate() {
            assert!(KEYS[..i].iter().all(|b| (b.key, b.with) != (a.key, a.with)), "{:?}", a.key);
            assert_eq!(a.name.is_empty(), a.what.is_empty());
            assert!(a.name.is_empty() || a.what.len() > 2);
        }
    }
}
