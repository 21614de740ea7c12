//! A gradient mesh on the canvas: the pointer, its keys, its panel, and what is drawn over it.

use super::canvas::{released_at, REACH};
use super::editor::Editor;
use super::ferguson::{Gradient, Op, Pick};
use super::overlay::colour32;
use crate::ferguson::inherit::Continuity;
use crate::ferguson::split::Axis;
use crate::scene::{self, ferguson, read_bounded};
use egui::{Color32, Key, PointerButton, Response, Stroke, Ui};
use glam::DVec4;
use std::path::Path;

impl Editor {
    /// Opens a scene of technique `ferguson`; `false`: the file is of another.
    pub fn open_gradient(&mut self, file: &Path) -> bool {
        let Ok(bytes) = read_bounded(file) else { return false };
        if scene::technique(&bytes) != scene::Technique::Ferguson {
            return false;
        }
        match ferguson::parse(&bytes, &file.display().to_string()) {
            Ok((mesh, notes)) => {
                self.message = None;
                if self.take(Editor::fresh("quad"), Some(file.to_path_buf())) {
                    self.gradient = Some(Gradient::new(mesh));
                    self.look.show = crate::gpu::Show::Surface;
                    self.forget_drawn();
                    match notes.first() {
                        Some(note) => self.fail(format_args!("{}: {note}", file.display())),
                        None => self.say(format_args!("opened {}", file.display())),
                    }
                }
            }
            Err(e) => self.fail(e),
        }
        true
    }

    /// Draws anew whatever is shown next.
    pub fn forget_drawn(&mut self) {
        if let Some(renderer) = &mut self.renderer {
            renderer.forget();
        }
    }

    /// Writes the gradient mesh; `true`: it is on the disk.
    pub fn save_gradient(&mut self, file: &Path) -> bool {
        let Some(gradient) = &mut self.gradient else { return false };
        gradient.commit();
        if !file.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
            self.fail(
                "a gradient mesh is saved as .json; choose such a name by save as, and `gradtess convert` for others",
            );
            return false;
        }
        match scene::write_atomically(file, ferguson::write(&gradient.mesh).as_bytes()) {
            Ok(()) => {
                gradient.saved();
                self.file = Some(file.to_path_buf());
                self.say(format_args!("saved {}", file.display()));
                true
            }
            Err(e) => {
                self.fail(e);
                false
            }
        }
    }

    fn gradient_act(&mut self, op: Op) {
        if let Some(Err(e)) = self.gradient.as_mut().map(|g| g.act(op)) {
            self.fail(e);
        }
    }

    /// A step of the gradient mesh back, or again.
    pub fn gradient_step(&mut self, forward: bool) {
        let Some(gradient) = &mut self.gradient else { return };
        match (gradient.step(forward), forward) {
            (Some(label), true) => self.say(format_args!("redone: {label}")),
            (Some(label), false) => self.say(format_args!("undone: {label}")),
            (None, true) => self.say("nothing to redo"),
            (None, false) => self.say("nothing to undo"),
        }
    }

    /// Removes the split that is selected.
    pub fn remove_selected_split(&mut self) {
        match self.gradient.as_ref().and_then(|g| g.selected) {
            Some(Pick::Curve(c)) => {
                if let Some(gradient) = &mut self.gradient {
                    gradient.selected = None;
                }
                self.gradient_act(Op::Remove(c));
            }
            _ => self.say("select the curve of a split first"),
        }
    }

    /// Colours the point or the sector that is selected; sRGB, straight alpha.
    pub fn colour_selected(&mut self, colour: DVec4) {
        let Some(gradient) = &self.gradient else { return };
        let encoded = gradient.mesh.colour.space.encode(colour, gradient.mesh.colour.premultiplied);
        match gradient.selected {
            Some(Pick::Point(p)) => self.gradient_act(Op::Colour(p, encoded)),
            Some(Pick::Sector(h)) => self.gradient_act(Op::Sector(h, encoded)),
            _ => self.say("select a point or one of its sectors first"),
        }
    }

    /// The pointer and the keys that only gradient meshes have.
    pub fn gradient_pointer(&mut self, ui: &Ui, canvas: &Response) {
        let typing = ui.ctx().wants_keyboard_input();
        let (pos, down, pressed, released, middle, space, delta, turns) = ui.input(|i| {
            let wheel = |e: &egui::Event| match e {
                egui::Event::MouseWheel { unit, delta, .. } if *unit == egui::MouseWheelUnit::Point => delta.y / 50.0,
                egui::Event::MouseWheel { delta, .. } => delta.y,
                _ => 0.0,
            };
            (
                i.pointer.interact_pos(),
                i.pointer.primary_down(),
                i.pointer.button_pressed(PointerButton::Primary),
                released_at(i),
                i.pointer.button_down(PointerButton::Middle),
                i.key_down(Key::Space),
                i.pointer.delta(),
                i.events.iter().map(wheel).sum::<f32>(),
            )
        });
        let key = |key: Key| !typing && ui.input(|i| i.key_pressed(key) && i.modifiers.is_none());
        let (u, v, c, w) = (key(Key::U), key(Key::V), key(Key::C), key(Key::W));
        let Some(gradient) = &mut self.gradient else { return };
        if c {
            gradient.continuity = other(gradient.continuity);
        }
        gradient.twists ^= w;
        let Some(pos) = pos else { return };
        let at = self.view.to_model(pos);
        let over = canvas.hovered() || canvas.dragged();
        if turns != 0.0 && canvas.hovered() {
            let size = gradient.bounds().map_or(1.0, |b| (b[2] - b[0]).max(b[3] - b[1]));
            self.view.zoom(1.2f64.powf(f64::from(turns)), pos, size);
        }
        if over && (middle || (space && down)) {
            self.view.pan(delta);
            return;
        }
        if (u || v) && over && gradient.held.is_none() {
            match gradient.patch_at(at) {
                Some((p, s, _)) if u => self.gradient_act(Op::Split(p, Axis::U, s)),
                Some((p, _, t)) => self.gradient_act(Op::Split(p, Axis::V, t)),
                None => self.say("no patch is under the pointer"),
            }
        }
        let Some(gradient) = &mut self.gradient else { return };
        if pressed && canvas.hovered() {
            gradient.selected = gradient.at(at, f64::from(REACH) * self.view.per_point());
            gradient.held = gradient.selected.map(|pick| (pick, gradient.place(pick) - at));
        }
        let mut failed = None;
        if let (true, Some((pick, offset))) = (down || released.is_some(), gradient.held) {
            let to = released.map_or(at, |pos| self.view.to_model(pos)) + offset;
            let far = self.view.to_window(gradient.place(pick)).distance(self.view.to_window(to));
            // A click is no drag.
            if far >= 0.5 {
                failed = gradient.drag(pick, to).err();
            }
        }
        if released.is_some() {
            gradient.held = None;
            gradient.commit();
        }
        if let Some(e) = failed {
            self.fail(e);
        }
    }

    /// The panel in place of the tools.
    pub fn gradient_panel(&mut self, ui: &mut Ui) {
        let Some(gradient) = &mut self.gradient else { return };
        ui.strong("Gradient mesh");
        ui.label(format!("{} patches", gradient.mesh.live().count()));
        ui.separator();
        ui.label("Handles");
        ui.horizontal(|ui| {
            ui.selectable_value(&mut gradient.continuity, Continuity::C1, "C1");
            ui.selectable_value(&mut gradient.continuity, Continuity::C0, "C0");
        });
        ui.checkbox(&mut gradient.twists, "Twists (W)");
        ui.separator();
        ui.label("U, V: split at the pointer");
        let curve = matches!(gradient.selected, Some(Pick::Curve(_)));
        let remove = ui.add_enabled(curve, egui::Button::new("Remove split")).clicked();
        ui.separator();
        let (mesh, space) = (&gradient.mesh, gradient.mesh.colour);
        let all: Vec<(Pick, DVec4)> = gradient
            .sectors()
            .into_iter()
            .map(|h| (Pick::Sector(h), space.decode(mesh.corner(h).colour.value)))
            .collect();
        let mut chosen = None;
        if !all.is_empty() {
            ui.label("Sectors of the point");
        }
        for (i, (pick, colour)) in all.into_iter().enumerate() {
            ui.horizontal(|ui| {
                let (rect, _) = ui.allocate_exact_size(egui::vec2(28.0, 16.0), egui::Sense::hover());
                ui.painter().rect_filled(rect, 2.0, colour32(colour));
                if ui.selectable_label(gradient.selected == Some(pick), format!("sector {}", i + 1)).clicked() {
                    chosen = Some(pick);
                }
            });
        }
        if chosen.is_some() {
            gradient.selected = chosen;
        }
        ui.label("Colour (Ctrl+V pastes one)");
        let mut painted = None;
        ui.horizontal_wrapped(|ui| {
            for &swatch in &self.swatches {
                let button = egui::Button::new("").fill(colour32(swatch)).min_size(egui::vec2(22.0, 18.0));
                if ui.add(button).clicked() {
                    painted = Some(swatch);
                }
            }
        });
        if remove {
            self.remove_selected_split();
        }
        if let Some(colour) = painted {
            self.colour_selected(colour);
        }
    }

    /// Curves, points and handles over the surface.
    pub fn paint_gradient(&self, painter: &egui::Painter) {
        let Some(gradient) = &self.gradient else { return };
        let (mesh, view) = (&gradient.mesh, self.view);
        let line = Stroke::new(1.0, Color32::from_rgba_unmultiplied(30, 30, 40, 150));
        let strong = Stroke::new(2.5, Color32::from_rgb(30, 110, 230));
        for c in gradient.curves() {
            let points = mesh.bezier(c).map(|p| view.to_window(p));
            let stroke = if gradient.selected == Some(Pick::Curve(c)) { strong } else { line };
            if self.shown.mesh || stroke == strong {
                let shape =
                    egui::epaint::CubicBezierShape::from_points_stroke(points, false, Color32::TRANSPARENT, stroke);
                painter.add(shape);
            }
            if self.shown.handles {
                painter.line_segment([points[0], points[1]], line);
                painter.line_segment([points[3], points[2]], line);
            }
        }
        if !self.shown.handles {
            return;
        }
        for pick in gradient.picks() {
            let at = view.to_window(gradient.place(pick));
            let chosen = gradient.selected == Some(pick);
            let (radius, fill) = match pick {
                Pick::Point(p) if mesh.points[p as usize].on.is_some() => (3.0, Color32::from_gray(150)),
                Pick::Point(_) => (4.5, Color32::WHITE),
                Pick::Handle(..) => (3.0, Color32::from_rgb(240, 170, 40)),
                Pick::Twist(_) => (3.0, Color32::from_rgb(160, 90, 200)),
                Pick::Sector(h) => (5.5, colour32(mesh.colour.decode(mesh.corner(h).colour.value))),
                Pick::Curve(_) => continue,
            };
            painter.circle(at, radius, fill, if chosen { strong } else { line });
        }
    }
}

fn other(continuity: Continuity) -> Continuity {
    match continuity {
        Continuity::C1 => Continuity::C0,
        Continuity::C0 => Continuity::C1,
    }
}
