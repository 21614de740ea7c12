//! Windows in front of the canvas: files, questions, the keyboard list.

use super::editor::Editor;
use super::files;
use super::surface_journal;
use crate::edit::{gradient, journal};
use egui::{Context, Ui};
use std::path::{Path, PathBuf};

/// What goes on once nothing unsaved is in the way.
#[derive(Clone, Debug, PartialEq)]
pub enum Then {
    /// A new scene.
    New,
    /// A window to open a file.
    Browse,
    /// A file.
    Open(PathBuf),
    /// The end.
    Quit,
}

/// What a file is wanted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// A scene to read.
    Open,
    /// A place to write the scene to.
    Save,
    /// A picture to put under the mesh.
    Reference,
}

/// The window in front.
pub enum Dialog {
    /// Shapes to begin with.
    New {
        /// Corners of a polygon, or squares, or quads of a ring.
        count: [u32; 2],
    },
    /// Files of a folder.
    Browse {
        /// For what.
        wanted: Wanted,
        /// The folder.
        folder: PathBuf,
        /// Name in it, or a whole path.
        name: String,
        /// What goes on after saving.
        then: Option<Then>,
    },
    /// There are changes that are not saved.
    Unsaved(Then),
    /// A session that crashed has left something.
    Restore(Option<LeftBehind>),
    /// The file to be written exists.
    Overwrite(PathBuf, Option<Then>),
    /// The keyboard list.
    Keys,
}

/// What a session that crashed has left.
pub enum LeftBehind {
    /// A subdivision scene.
    Scene(Box<journal::Restored>),
    /// A gradient mesh.
    Gradient(Box<gradient::journal::Restored>),
    /// A surface in space.
    Surface(Box<surface_journal::Restored>),
}

impl LeftBehind {
    /// Reads a journal.
    ///
    /// # Errors
    /// What is wrong, in one line.
    pub fn read(path: &Path) -> Result<LeftBehind, String> {
        if gradient::journal::is_one(path) {
            return gradient::journal::restore(path).map(Box::new).map(LeftBehind::Gradient);
        }
        if surface_journal::is_one(path) {
            return surface_journal::restore(path).map(Box::new).map(LeftBehind::Surface);
        }
        journal::restore(path).map(Box::new).map(LeftBehind::Scene)
    }

    /// The journal, the scene's file, and the steps read.
    pub fn about(&self) -> (&Path, Option<&Path>, usize) {
        match self {
            LeftBehind::Scene(r) => (&r.path, r.file.as_deref(), r.steps),
            LeftBehind::Gradient(r) => (&r.path, r.file.as_deref(), r.steps),
            LeftBehind::Surface(r) => (&r.path, r.file.as_deref(), r.steps),
        }
    }
}

impl Dialog {
    /// A window that asks where to save.
    pub fn save(editor: &Editor) -> Dialog {
        let mut name = editor.title();
        // Drawings are read, not written: their meshes go beside them.
        if editor.file.is_none() {
            name += ".json";
        } else if editor.file_to_write().is_none() {
            name = Path::new(&name).with_extension("json").to_string_lossy().into_owned();
        }
        Dialog::Browse { wanted: Wanted::Save, folder: start_folder(editor), name, then: None }
    }

    /// A window that asks for a file to read.
    pub fn open(editor: &Editor, wanted: Wanted) -> Dialog {
        Dialog::Browse { wanted, folder: start_folder(editor), name: String::new(), then: None }
    }
}

fn start_folder(editor: &Editor) -> PathBuf {
    let beside = editor.file.as_deref().and_then(Path::parent).filter(|p| *p != Path::new(""));
    let here = || std::env::current_dir().unwrap_or_else(|_| PathBuf::from("."));
    beside.map_or_else(here, Path::to_path_buf)
}

impl Editor {
    /// Goes on, after asking about changes that are not saved.
    pub fn ask_first(&mut self, then: Then) {
        self.commit();
        if self.unsaved() {
            self.dialog = Some(Dialog::Unsaved(then));
        } else {
            self.go_on(then);
        }
    }

    fn go_on(&mut self, then: Then) {
        match then {
            Then::New => self.dialog = Some(Dialog::New { count: [5, 3] }),
            Then::Browse => self.dialog = Some(Dialog::open(self, Wanted::Open)),
            Then::Open(file) => self.open(&file),
            Then::Quit => self.quit = true,
        }
    }

    /// Writes the file, or asks for its name.
    pub fn save_or_ask(&mut self) {
        match self.file_to_write() {
            Some(file) => drop(self.save(&file)),
            None => self.dialog = Some(Dialog::save(self)),
        }
    }

    /// The scene's file, if the scene can be written to it.
    fn file_to_write(&self) -> Option<PathBuf> {
        self.file.clone().filter(|file| self.gradient.is_none() || super::gradient::is_json(file))
    }

    /// A file was dropped on the window.
    pub fn dropped(&mut self, file: &Path) {
        let picture = file.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
        if picture {
            self.set_reference(file);
        } else {
            self.ask_first(Then::Open(file.to_path_buf()));
        }
    }

    /// Puts a picture under the mesh.
    pub fn set_reference(&mut self, file: &Path) {
        if self.gradient.is_some() {
            return self.fail("a gradient mesh has no reference picture; open a subdivision scene for one");
        }
        if self.solid.is_some() {
            return self.fail("a surface in space has no reference picture; open a subdivision scene for one");
        }
        let picture = match crate::image::Picture::read_png(file) {
            Ok(picture) => picture,
            Err(e) => return self.fail(e),
        };
        let folder = self.folder();
        let whole = std::path::absolute(file).unwrap_or_else(|_| file.to_path_buf());
        let base = std::path::absolute(&folder).unwrap_or_else(|_| folder.clone());
        let name = whole.strip_prefix(&base).map_or_else(|_| whole.clone(), Path::to_path_buf);
        let bounds = self.model.bounds().unwrap_or([0.0, 0.0, 1.0, 1.0]);
        let placed = super::reference::placed(name.to_string_lossy().into_owned(), &picture, bounds);
        self.change("reference picture", |scene, _| {
            scene.reference = Some(placed);
            Ok(())
        });
        let lost = self.reference.follow(&self.model.scene, &folder);
        match lost {
            Some(lost) => self.fail(lost),
            None => self.say("the reference picture lies under the mesh; lower the surface's opacity to see it"),
        }
    }

    /// Shows the window in front, if any.
    pub fn dialogs(&mut self, ctx: &Context) {
        let Some(mut dialog) = self.dialog.take() else { return };
        let mut open = true;
        let title = match &dialog {
            Dialog::New { .. } => "New scene",
            Dialog::Browse { wanted: Wanted::Open, .. } => "Open",
            Dialog::Browse { wanted: Wanted::Save, .. } => "Save as",
            Dialog::Browse { wanted: Wanted::Reference, .. } => "Reference picture",
            Dialog::Unsaved(_) => "Unsaved changes",
            Dialog::Restore(_) => "Restore",
            Dialog::Overwrite(..) => "Replace the file?",
            Dialog::Keys => "Keyboard",
        };
        let mut stays = true;
        egui::Window::new(title)
            .open(&mut open)
            .collapsible(false)
            .resizable(false)
            .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
            .show(ctx, |ui| stays = self.dialog_content(ui, &mut dialog));
        // What the content opened in its place comes first.
        if self.dialog.is_none() && open && stays {
            self.dialog = Some(dialog);
        }
    }

    /// The content of a window; `false` closes it.
    fn dialog_content(&mut self, ui: &mut Ui, dialog: &mut Dialog) -> bool {
        match dialog {
            Dialog::New { count } => self.new_scene(ui, count),
            Dialog::Browse { wanted, folder, name, then } => self.browse(ui, *wanted, folder, name, then),
            Dialog::Unsaved(then) => self.ask_unsaved(ui, then),
            Dialog::Overwrite(file, then) => {
                ui.label(format!("{} exists.", file.display()));
                let mut stays = true;
                ui.horizontal(|ui| {
                    if ui.button("Replace").clicked() {
                        stays = false;
                        if self.save(file) {
                            if let Some(then) = then.take() {
                                self.go_on(then);
                            }
                        }
                    }
                    stays &= !ui.button("Cancel").clicked();
                });
                stays
            }
            Dialog::Restore(left) => {
                let Some(restored) = left else { return false };
                let (path, file, steps) = restored.about();
                let what = file.map_or("an unsaved scene".into(), |f| f.display().to_string());
                ui.label(format!("A session of {what} ended without saving."));
                ui.label(format!("Its journal holds {steps} steps."));
                let (mut restore, mut discard, mut later) = (false, false, false);
                ui.horizontal(|ui| {
                    restore = ui.button("Restore").clicked() || ui.input(|i| i.key_pressed(egui::Key::Enter));
                    discard = ui.button("Discard").clicked();
                    later = ui.button("Later").clicked();
                });
                if discard {
                    let _ = std::fs::remove_file(path);
                }
                if restore {
                    if let Some(restored) = left.take() {
                        self.resume(restored);
                    }
                }
                !(restore || discard || later)
            }
            Dialog::Keys => {
                egui::Grid::new("keys").num_columns(2).spacing([24.0, 3.0]).show(ui, |ui| {
                    for (name, what) in super::keys::listed(self.gradient.is_some()) {
                        ui.strong(name);
                        ui.label(what);
                        ui.end_row();
                    }
                });
                true
            }
        }
    }

    fn ask_unsaved(&mut self, ui: &mut Ui, then: &Then) -> bool {
        ui.label(format!("{} has changes that are not saved.", self.title()));
        let mut stays = true;
        ui.horizontal(|ui| {
            let enter = ui.input(|i| i.key_pressed(egui::Key::Enter));
            if ui.button("Save").on_hover_text("Enter").clicked() || enter {
                match self.file_to_write() {
                    Some(file) => {
                        if self.save(&file) {
                            self.go_on(then.clone());
                        }
                    }
                    None => {
                        let mut save = Dialog::save(self);
                        if let Dialog::Browse { then: after, .. } = &mut save {
                            *after = Some(then.clone());
                        }
                        self.dialog = Some(save);
                    }
                }
                stays = false;
            }
            if ui.button("Discard").clicked() {
                self.close(true);
                self.go_on(then.clone());
                stays = false;
            }
            stays &= !ui.button("Cancel").clicked();
        });
        stays
    }

    fn new_scene(&mut self, ui: &mut Ui, count: &mut [u32; 2]) -> bool {
        let (mut chosen, mut patches) = (None, false);
        ui.horizontal(|ui| {
            for name in ["triangle", "quad", "pentagon", "hexagon"] {
                if ui.button(name).clicked() {
                    chosen = Some(name.to_owned());
                }
            }
        });
        let drawn = ui.button("draw a polygon").on_hover_text("click its corners").clicked();
        if drawn {
            self.hand.corners.clear();
            (self.hand.anew, self.tool) = (true, super::editor::Tool::Draw);
            self.say("click the corners of the polygon; the first one again, or Enter, closes it");
            return false;
        }
        ui.horizontal(|ui| {
            ui.add(egui::DragValue::new(&mut count[0]).clamp_range(1..=200));
            ui.label("by");
            ui.add(egui::DragValue::new(&mut count[1]).clamp_range(1..=200));
            let [w, h] = *count;
            if ui.button("grid").clicked() {
                chosen = Some(format!("grid:{w}x{h}"));
            }
            if ui.button("strip").clicked() {
                chosen = Some(format!("strip:{w}"));
            }
            if ui.button("ring").clicked() {
                chosen = Some(format!("ring:{}", w.max(3)));
            }
            if ui.button("fan").clicked() {
                chosen = Some(format!("fan:{}", w.max(3)));
            }
            patches = ui.button("patches").on_hover_text("a gradient mesh of bicubic patches (BLHK18)").clicked();
        });
        if patches {
            self.new_gradient(*count);
            return false;
        }
        match chosen {
            Some(name) => {
                self.take(Editor::fresh(&name), None);
                false
            }
            None => true,
        }
    }

    fn browse(
        &mut self,
        ui: &mut Ui,
        wanted: Wanted,
        folder: &mut PathBuf,
        name: &mut String,
        then: &mut Option<Then>,
    ) -> bool {
        let extensions: &[&str] = if wanted == Wanted::Reference { &["png"] } else { &["json", "obj", "svg"] };
        let (folders, names) = files::list(folder, extensions);
        ui.label(folder.display().to_string());
        let mut enter = None;
        let mut chosen = false;
        egui::ScrollArea::vertical().max_height(260.0).min_scrolled_height(260.0).show(ui, |ui| {
            ui.set_min_width(420.0);
            for entry in &folders {
                if ui.selectable_label(false, format!("{entry}/")).clicked() {
                    enter = Some(entry.clone());
                }
            }
            for entry in &names {
                let row = ui.selectable_label(entry == name, entry);
                if row.clicked() {
                    name.clone_from(entry);
                }
                chosen |= row.double_clicked();
            }
        });
        if let Some(entry) = enter {
            let next = if entry == ".." { folder.parent().map(Path::to_path_buf) } else { Some(folder.join(entry)) };
            *folder = next.unwrap_or_else(|| folder.clone());
        }
        let field = ui.add(egui::TextEdit::singleline(name).desired_width(420.0).hint_text("file name or path"));
        if !field.has_focus() && !field.lost_focus() {
            field.request_focus();
        }
        chosen |= field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
        let mut cancelled = false;
        ui.horizontal(|ui| {
            chosen |= ui.button(if wanted == Wanted::Save { "Save" } else { "Open" }).clicked();
            cancelled = ui.button("Cancel").clicked();
        });
        if !chosen || name.trim().is_empty() {
            return !cancelled;
        }
        let mut file = folder.join(name.trim());
        if file.is_dir() {
            *folder = file;
            name.clear();
            return true;
        }
        match wanted {
            Wanted::Open => self.open(&file),
            Wanted::Reference => self.set_reference(&file),
            Wanted::Save => {
                if file.extension().is_none() {
                    file.set_extension(if self.solid.is_some() { "obj" } else { "json" });
                }
                if file.exists() && Some(&file) != self.file.as_ref() {
                    self.dialog = Some(Dialog::Overwrite(file, then.take()));
                } else if self.save(&file) {
                    if let Some(then) = then.take() {
                        self.go_on(then);
                    }
                }
            }
        }
        false
    }

    /// Name for the window and for questions.
    pub fn title(&self) -> String {
        let file = self.file.as_deref().and_then(Path::file_name).map(|n| n.to_string_lossy().into_owned());
        file.unwrap_or_else(|| match &self.gradient {
            Some(gradient) => gradient.mesh.name.clone(),
            None => self.model.scene.name.clone(),
        })
    }
}
