//! The bars and panels around the canvas.

use super::colour;
use super::dialog::{Dialog, Then, Wanted};
use super::editor::{Editor, Tool};
use super::keys::Command;
use super::overlay::{colour32, describe};
use crate::edit::handle::{Kind, Stage};
use crate::patch::tess::TessRule;
use egui::{Context, Rect, Sense, Ui};
use glam::{DVec3, DVec4};

impl Editor {
    /// One frame of the whole window.
    pub fn ui(&mut self, ctx: &Context) {
        self.keys(ctx);
        for file in ctx.input(|i| i.raw.dropped_files.clone()) {
            if let Some(path) = file.path {
                self.dropped(&path);
            }
        }
        egui::TopBottomPanel::top("menu").show(ctx, |ui| self.menu(ui));
        egui::TopBottomPanel::bottom("status").show(ctx, |ui| self.status(ui));
        egui::SidePanel::left("tools").resizable(false).exact_width(214.0).show(ctx, |ui| {
            egui::ScrollArea::vertical().show(ui, |ui| {
                if self.gradient.is_some() {
                    self.gradient_panel(ui)
                } else if self.solid.is_some() {
                    self.surface_panel(ui)
                } else {
                    self.tools(ui)
                }
            });
        });
        if self.timing_open {
            egui::SidePanel::right("timing").resizable(false).exact_width(264.0).show(ctx, |ui| {
                egui::ScrollArea::vertical().show(ui, |ui| self.timing_panel(ui));
            });
        }
        let frame = egui::Frame::none().fill(egui::Color32::from_gray(219));
        egui::CentralPanel::default().frame(frame).show(ctx, |ui| self.canvas(ui));
        self.dialogs(ctx);
        // A widget's own gesture (a slider, a colour) ends when nothing is held any more.
        if (self.in_gesture() || self.solid.is_some()) && !ctx.input(|i| i.pointer.any_down()) {
            self.commit();
        }
        let widget = self.hand.gradient.is_none() && self.gradient.as_ref().is_some_and(|g| g.in_gesture());
        if widget && !ctx.input(|i| i.pointer.any_down()) {
            self.commit();
        }
        self.tick();
        let lost = {
            let folder = self.folder();
            self.reference.follow(&self.model.scene, &folder)
        };
        if let Some(lost) = lost {
            self.fail(lost);
        }
    }

    fn menu(&mut self, ui: &mut Ui) {
        egui::menu::bar(ui, |ui| {
            ui.menu_button("File", |ui| {
                let mut chosen = None;
                let mut item = |ui: &mut Ui, name: &str, keys: &str, command: Command| {
                    if ui.add(egui::Button::new(name).shortcut_text(keys)).clicked() {
                        chosen = Some(command);
                        ui.close_menu();
                    }
                };
                item(ui, "New", "Ctrl+N", Command::New);
                item(ui, "Open", "Ctrl+O", Command::Open);
                item(ui, "Save", "Ctrl+S", Command::Save);
                item(ui, "Save as", "Ctrl+Shift+S", Command::SaveAs);
                item(ui, "Quit", "Ctrl+Q", Command::Quit);
                if let Some(command) = chosen {
                    self.obey(command, false);
                }
                if !self.recent.is_empty() {
                    ui.separator();
                }
                for file in self.recent.clone() {
                    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
                    if ui.button(name).on_hover_text(file.display().to_string()).clicked() {
                        self.ask_first(Then::Open(file));
                        ui.close_menu();
                    }
                }
            });
            ui.menu_button("Edit", |ui| {
                for (name, keys, command) in [
                    ("Undo", "Ctrl+Z", Command::Undo),
                    ("Redo", "Ctrl+Shift+Z", Command::Redo),
                    ("Select all", "Ctrl+A", Command::SelectAll),
                    ("Reset selected", "Delete", Command::Reset),
                ] {
                    if ui.add(egui::Button::new(name).shortcut_text(keys)).clicked() {
                        self.obey(command, false);
                        ui.close_menu();
                    }
                }
            });
            ui.menu_button("View", |ui| {
                for (name, keys, command) in [("Fit", "F", Command::Fit), ("1:1", "Shift+F", Command::OneToOne)] {
                    if ui.add(egui::Button::new(name).shortcut_text(keys)).clicked() {
                        self.obey(command, false);
                        ui.close_menu();
                    }
                }
                ui.checkbox(&mut self.timing_open, "Times (T)");
            });
            if ui.button("?").on_hover_text("keyboard list").clicked() {
                self.obey(Command::Help, false);
            }
            ui.separator();
            let star = if self.unsaved() { " *" } else { "" };
            ui.label(format!("{}{star}", self.title()));
        });
    }

    fn status(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            match &self.message {
                Some(m) if m.error => ui.colored_label(ui.visuals().error_fg_color, &m.text),
                Some(m) => ui.label(&m.text),
                None => ui.weak("press ? for the keyboard list"),
            };
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let what = match (self.hand.hover, self.selection.len()) {
                    (Some(id), _) => describe(id),
                    (None, 0) => String::new(),
                    (None, 1) => self.selection.first().map(|id| describe(*id)).unwrap_or_default(),
                    (None, n) => format!("{n} selected"),
                };
                ui.weak(what);
                if let Some(note) = self.model.notes.first().filter(|_| self.gradient.is_none() && self.solid.is_none())
                {
                    let more = self.model.notes.len() - 1;
                    let rest = if more > 0 { format!(" (and {more} more)") } else { String::new() };
                    ui.colored_label(ui.visuals().warn_fg_color, format!("{note}{rest}"));
                }
            });
        });
    }

    fn tools(&mut self, ui: &mut Ui) {
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            for (tool, name, keys) in [
                (Tool::Move, "Move", "V"),
                (Tool::Brush, "Brush", "B"),
                (Tool::Sharp, "Sharp", "E"),
                (Tool::Pick, "Pick", "I"),
                (Tool::Draw, "Draw", "D"),
            ] {
                ui.selectable_value(&mut self.tool, tool, name).on_hover_text(keys);
            }
        });
        ui.separator();
        ui.horizontal(|ui| {
            ui.label("Edit");
            let mut stage = self.stage;
            ui.selectable_value(&mut stage, Stage::Input, "M").on_hover_text("the input mesh (M)");
            for l in 0..=6 {
                ui.selectable_value(&mut stage, Stage::Level(l), l.to_string())
                    .on_hover_text(format!("level {l} ({l})"));
            }
            self.set_stage(stage);
        });
        ui.checkbox(&mut self.shown.mesh, "control mesh (G)");
        ui.checkbox(&mut self.shown.handles, "handles (H)");
        ui.checkbox(&mut self.shown.control, "control points, not limits (C)");
        ui.checkbox(&mut self.shown.influence, "region of influence");
        egui::ComboBox::from_label("shown")
            .selected_text(Editor::shows().into_iter().find(|s| s.0 == self.look.show).map_or("", |s| s.1))
            .show_ui(ui, |ui| {
                for (show, name) in Editor::shows() {
                    ui.selectable_value(&mut self.look.show, show, name);
                }
            });
        let mut smooth = self.look.samples == 4;
        if ui.checkbox(&mut smooth, "smooth edges (4 samples)").changed() {
            self.look.samples = if smooth { 4 } else { 1 };
        }
        ui.separator();
        ui.checkbox(&mut self.prevent_folds, "prevent folds (P)");
        ui.horizontal(|ui| {
            let mut on = self.shown.grid > 0.0;
            if ui.checkbox(&mut on, "grid").changed() {
                let size = crate::edit::drag::size_of(&self.model.scene);
                self.shown.grid = if on { 10f64.powf((size / 20.0).log10().round()) } else { 0.0 };
            }
            if on {
                ui.add(egui::DragValue::new(&mut self.shown.grid).clamp_range(1e-6..=1e6).speed(0.01));
            }
            ui.checkbox(&mut self.shown.snap_points, "snap to points");
        });
        ui.separator();
        self.brush_panel(ui);
        ui.separator();
        self.reference_panel(ui);
        ui.separator();
        self.model_panel(ui);
    }

    fn brush_panel(&mut self, ui: &mut Ui) {
        ui.strong("Colour and brush");
        let before = self.brush.colour;
        let c = picker(ui, before);
        if c != before {
            self.brush.colour = c;
            let ids: Vec<_> = self.selection.iter().filter(|id| !id.kind.is_geometry()).map(|&id| (id, c)).collect();
            if !ids.is_empty() {
                self.begin("paint");
                self.during(|scene, mesh| crate::edit::paint::paint(scene, mesh, &ids));
            }
        }
        if let Some(colour) = self.swatch_row(ui) {
            self.brush.colour = colour;
            self.paint_selected(colour);
        }
        ui.add(egui::Slider::new(&mut self.brush.radius, 3.0..=300.0).logarithmic(true).text("radius"));
        ui.horizontal(|ui| {
            ui.selectable_value(&mut self.brush.moves, false, "paints");
            ui.selectable_value(&mut self.brush.moves, true, "moves");
        });
        let sectors = self.selection.iter().any(|id| matches!(id.kind, Kind::Colour | Kind::Sector));
        if sectors && ui.button("Paint selected").clicked() {
            self.paint_selected(self.brush.colour);
        }
    }

    /// The colours at hand; the one that was clicked.
    pub(super) fn swatch_row(&mut self, ui: &mut Ui) -> Option<DVec4> {
        let mut taken = None;
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = egui::vec2(3.0, 3.0);
            let mut chosen = None;
            for (i, &swatch) in self.swatches.iter().enumerate() {
                let (rect, click) = ui.allocate_exact_size(egui::vec2(18.0, 18.0), Sense::click());
                ui.painter().rect(rect, 2.0, colour32(swatch), ui.visuals().widgets.inactive.bg_stroke);
                if click.clicked() {
                    chosen = Some(swatch);
                }
                if click.secondary_clicked() {
                    chosen = Some(DVec4::splat(-1.0 - i as f64));
                }
            }
            if ui.small_button("+").on_hover_text("keep this colour; right click removes one").clicked() {
                self.swatches.push(self.brush.colour);
            }
            match chosen {
                Some(c) if c.x < 0.0 => drop(self.swatches.remove((-1.0 - c.x) as usize)),
                c => taken = c,
            }
        });
        taken
    }

    fn reference_panel(&mut self, ui: &mut Ui) {
        ui.strong("Reference picture");
        let Some(mut r) = self.model.scene.reference.clone() else {
            if ui.button("Choose").clicked() {
                self.dialog = Some(Dialog::open(self, Wanted::Reference));
            }
            return;
        };
        let before = r.clone();
        ui.weak(&r.file);
        ui.add(egui::Slider::new(&mut r.opacity, 0.0..=1.0).text("opacity"));
        ui.add(egui::Slider::new(&mut self.shown.opacity, 0.0..=1.0).text("surface"))
            .on_hover_text("opacity of the surface over the picture");
        ui.horizontal(|ui| {
            ui.checkbox(&mut r.locked, "locked");
            if ui.button("Remove").clicked() {
                self.change("remove reference picture", |scene, _| {
                    scene.reference = None;
                    Ok(())
                });
                r = before.clone();
            }
        });
        if !r.locked {
            ui.horizontal(|ui| {
                let [x0, y0, x1, y1] = r.rect;
                let (mut x, mut y, mut w) = (x0, y0, x1 - x0);
                let speed = 0.01 * crate::edit::drag::size_of(&self.model.scene);
                let value = |ui: &mut Ui, v: &mut f64| ui.add(egui::DragValue::new(v).speed(speed)).changed();
                let changed = value(ui, &mut x) | value(ui, &mut y) | value(ui, &mut w);
                if changed && w > 0.0 {
                    r.rect = [x, y, x + w, y + w * (y1 - y0) / (x1 - x0)];
                }
            });
        }
        if r != before && self.model.scene.reference.is_some() {
            self.begin("reference picture");
            self.during(|scene, _| {
                scene.reference = Some(r);
                Ok(())
            });
        }
        if ui.button("Pick colours under handles").clicked() {
            self.pick_under_all();
        }
    }

    /// The canvas: the scene, and what lies over it.
    fn canvas(&mut self, ui: &mut Ui) {
        let scale = ui.ctx().pixels_per_point();
        let all = ui.available_rect_before_wrap();
        // Whole pixels, so that the scene's picture and the window's pixels are the same.
        let whole = |p: egui::Pos2| egui::pos2((p.x * scale).round() / scale, (p.y * scale).round() / scale);
        let rect = Rect::from_min_max(whole(all.min), whole(all.max));
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        (self.view.rect, self.view.scale) = (rect, scale);
        if self.fit_next && rect.width() > 1.0 && rect.height() > 1.0 {
            self.fit();
            self.fit_next = false;
        }
        if self.dialog.is_none() {
            if self.gradient.is_some() {
                self.gradient_pointer(ui, &response);
            } else if self.solid.is_some() {
                self.surface_pointer(ui, &response);
            } else {
                self.pointer(ui, &response);
            }
        }
        let painter = ui.painter_at(rect);
        if self.solid.is_some() {
            if let Some(texture) = self.surface_picture(ui.ctx()) {
                let uv = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
                painter.image(texture, rect, uv, egui::Color32::WHITE);
            }
            return self.paint_surface(&painter, response.hover_pos());
        }
        let under = self.reference_shown(ui.ctx(), &painter);
        self.look.background = if under { None } else { Some([0.86, 0.86, 0.88, 1.0]) };
        let (mut look, view) = (self.look, self.view);
        if let (true, TessRule::Pixels(p)) = (self.in_gesture(), look.tess) {
            // Half as fine while something is held: drawing is most of a drag's time on a software rasteriser, and pieces
            // of twice the length are a fraction of a pixel off the curve.
            look.tess = TessRule::Pixels(2.0 * p);
        }
        if let Some(gradient) = &mut self.gradient {
            gradient.look(look.tess, view.unit, view.seen());
        }
        let drawn = match (&mut self.renderer, &self.gradient) {
            (Some(renderer), Some(g)) => renderer.draw(g.table(), g.revision, |r| g.changed_since(r), &view, &look),
            (Some(renderer), None) => {
                let m = &self.model;
                renderer.draw(&m.table, m.revision, |r| m.changed_since(r), &view, &look)
            }
            (None, _) => Ok(None),
        };
        match drawn {
            Ok(Some(texture)) => {
                let uv = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
                // A picture to draw after shows through.
                let opacity = if under { self.shown.opacity } else { 1.0 };
                painter.image(texture, rect, uv, egui::Color32::WHITE.gamma_multiply(opacity));
            }
            Ok(None) => {}
            Err(e) => self.fail(e),
        }
        let pointer = response.hover_pos().or_else(|| response.interact_pointer_pos());
        match &self.gradient {
            Some(_) => self.paint_gradient(&painter),
            None => self.paint_over(&painter, pointer),
        }
    }

    fn reference_shown(&mut self, ctx: &Context, painter: &egui::Painter) -> bool {
        let Some(r) = &self.model.scene.reference else { return false };
        let (rect, opacity) = (r.rect, r.opacity);
        let Some(texture) = self.reference.texture(ctx) else { return false };
        if opacity <= 0.0 {
            return false;
        }
        let corner = |x: f64, y: f64| self.view.to_window(glam::DVec2::new(x, y));
        let place = Rect::from_min_max(corner(rect[0], rect[3]), corner(rect[2], rect[1]));
        let uv = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
        painter.image(texture, place, uv, egui::Color32::WHITE.gamma_multiply(opacity as f32));
        true
    }
}

/// Fields for a colour: a picker, hex, numbers; the colour that is chosen.
pub(super) fn picker(ui: &mut Ui, mut c: DVec4) -> DVec4 {
    let mut shown = colour32(c);
    ui.horizontal(|ui| {
        if egui::color_picker::color_edit_button_srgba(ui, &mut shown, egui::color_picker::Alpha::OnlyBlend).changed() {
            let [r, g, b, a] = shown.to_srgba_unmultiplied();
            c = DVec4::new(f64::from(r), f64::from(g), f64::from(b), f64::from(a)) / 255.0;
        }
        let id = ui.id().with("hex");
        let mut text = ui.data(|d| d.get_temp::<String>(id)).unwrap_or_else(|| colour::to_hex(c));
        let field = ui.add(egui::TextEdit::singleline(&mut text).desired_width(80.0));
        if field.changed() {
            if let Some(read) = colour::from_hex(&text) {
                c = read;
            }
        }
        // The field keeps what is typed; otherwise it shows the colour.
        let typing = field.has_focus();
        ui.data_mut(|d| match typing {
            true => d.insert_temp(id, text),
            false => d.remove::<String>(id),
        });
    });
    spaces(ui, c)
}

/// Between sRGB and a colour space.
type Space = fn(DVec3) -> DVec3;

/// Numbers of a colour in the space chosen.
fn spaces(ui: &mut Ui, c: DVec4) -> DVec4 {
    let id = ui.id().with("space");
    let mut space = ui.data(|d| d.get_temp::<usize>(id)).unwrap_or(0);
    ui.horizontal(|ui| {
        for (i, name) in ["RGB", "HSV", "Oklab"].into_iter().enumerate() {
            ui.selectable_value(&mut space, i, name);
        }
    });
    ui.data_mut(|d| d.insert_temp(id, space));
    let rgb = c.truncate();
    let (from, to): (Space, Space) = match space {
        0 => (|c| c, |c| c),
        1 => (colour::to_hsv, colour::from_hsv),
        _ => (colour::to_oklab, colour::from_oklab),
    };
    let mut v = from(rgb);
    let mut changed = false;
    let low = if space == 2 { -0.4 } else { 0.0 };
    ui.horizontal(|ui| {
        for (i, x) in [&mut v.x, &mut v.y, &mut v.z].into_iter().enumerate() {
            let range = if i == 0 { 0.0..=1.0 } else { low..=1.0 };
            changed |= ui.add(egui::DragValue::new(x).clamp_range(range).speed(0.003).fixed_decimals(3)).changed();
        }
    });
    if changed {
        to(v).clamp(DVec3::ZERO, DVec3::ONE).extend(c.w)
    } else {
        c
    }
}
