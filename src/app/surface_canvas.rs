//! A surface in space on the canvas: the pointer, its panel, and the control mesh over it.

use super::canvas::{released_at, REACH};
use super::editor::Editor;
use super::surface::{Orbit, Shown, Solid};
use crate::gpu::{SolidNormals, SolidShow};
use crate::scene::surface::{write, SurfaceScene, INFINITE};
use crate::scene::{self, read_bounded};
use crate::surface::drawing::edge_colour;
use crate::surface::level::Scheme;
use crate::surface::shade::Geometric;
use crate::surface::weight::{Darts, Initial, Variant};
use egui::{Color32, ComboBox, Key, PointerButton, Pos2, Response, Slider, Stroke, Ui};
use std::path::{Path, PathBuf};

/// Points that the pointer may move while it is held and still click.
const STILL: f32 = 3.0;

/// What can be shown, with its name.
const SHOWN: [(Shown, &str); 7] = [
    (Shown::Surface(SolidShow::Shaded), "shaded"),
    (Shown::Surface(SolidShow::Highlight), "highlight lines"),
    (Shown::Surface(SolidShow::Reflection), "reflection lines"),
    (Shown::Surface(SolidShow::Normals), "normals"),
    (Shown::Surface(SolidShow::Weights), "blend weights"),
    (Shown::Surface(SolidShow::Sides), "sides"),
    (Shown::Mesh, "mesh of the level"),
];

impl Editor {
    /// Opens a surface in space; `false`: the file is of another technique.
    pub fn open_surface(&mut self, file: &Path) -> bool {
        let Ok(bytes) = read_bounded(file) else { return false };
        if scene::technique(&bytes) != scene::Technique::Surface {
            return false;
        }
        let name = file.display().to_string();
        let read = SurfaceScene::parse(&bytes, &name).map_err(|e| e.to_string());
        let made = read.and_then(|scene| {
            let notes = scene.notes.clone();
            Solid::new(scene).map(|solid| (solid, notes)).map_err(|e| format!("{name}: {e}"))
        });
        match made {
            Ok((solid, notes)) => {
                self.message = None;
                if self.take_surface(solid, Some(file.to_path_buf())) {
                    match notes.first() {
                        Some(note) => self.fail(format_args!("{name}: {note}")),
                        None => self.say(format_args!("opened {name}")),
                    }
                }
            }
            Err(e) => self.fail(e),
        }
        true
    }

    /// Takes a surface in place of the scene at hand.
    pub fn take_surface(&mut self, solid: Solid, file: Option<PathBuf>) -> bool {
        let done = self.take(Editor::fresh("quad"), file);
        if done {
            self.solid = Some(solid);
        }
        done
    }

    /// Writes the surface; `true`: it is on the disk.
    pub fn save_surface(&mut self, file: &Path) -> bool {
        let Some(solid) = &mut self.solid else { return false };
        solid.commit();
        if !file.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj")) {
            self.fail("a surface in space is saved as .obj; choose such a name by save as");
            return false;
        }
        match scene::write_atomically(file, write(&solid.scene).as_bytes()) {
            Ok(()) => {
                solid.saved();
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

    /// A step of the surface back, or again.
    pub fn surface_step(&mut self, forward: bool) {
        let Some(solid) = &mut self.solid else { return };
        let done = solid.step(forward);
        self.say(match (done, forward) {
            (true, true) => "redone: sharpness",
            (true, false) => "undone: sharpness",
            (false, true) => "nothing to redo",
            (false, false) => "nothing to undo",
        });
    }

    /// Gives the selected edges a sharpness, in one step; `change` takes the one that the first of them has.
    pub fn sharpen_selected(&mut self, change: impl Fn(f64) -> f64) {
        let Some(solid) = &mut self.solid else { return };
        match solid.selected.first().copied() {
            Some(first) => {
                solid.sharpen(change(solid.sharpness(first)));
                solid.commit();
            }
            None => self.say("select edges first: click, and shift-click for more"),
        }
    }

    /// The pointer.
    pub fn surface_pointer(&mut self, ui: &Ui, canvas: &Response) {
        let rect = self.view.rect;
        let Some(solid) = &mut self.solid else { return };
        let (pos, down, pressed, released, shift, middle, space, delta, turns) = ui.input(|i| {
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
                i.modifiers.shift,
                i.pointer.button_down(PointerButton::Middle),
                i.key_down(Key::Space),
                i.pointer.delta(),
                i.events.iter().map(wheel).sum::<f32>(),
            )
        });
        let Some(pos) = pos else { return };
        if turns != 0.0 && canvas.hovered() {
            solid.orbit.distance = (solid.orbit.distance * 1.2f64.powf(-f64::from(turns))).clamp(0.02, 50.0);
        }
        if (canvas.hovered() || canvas.dragged()) && (middle || (space && down)) {
            let unit = solid.per_point(rect);
            solid.orbit.shift[0] -= f64::from(delta.x) * unit;
            solid.orbit.shift[1] += f64::from(delta.y) * unit;
            solid.pressed = None;
            return;
        }
        if pressed && canvas.hovered() {
            solid.pressed = Some(pos);
        } else if down && canvas.dragged() {
            if solid.pressed.is_some_and(|from| from.distance(pos) > STILL) {
                solid.pressed = None;
            }
            if solid.pressed.is_none() {
                turn(&mut solid.orbit, delta);
            }
        }
        if let Some(at) = released {
            // Without a move in between it was a click.
            if solid.pressed.take().is_some_and(|from| from.distance(at) <= STILL) {
                let edge = solid.edge_at(&solid.eye(rect), at, REACH);
                solid.pick(edge, shift);
            }
        }
    }

    /// The panel in place of the tools.
    pub fn surface_panel(&mut self, ui: &mut Ui) {
        let Some(solid) = &mut self.solid else { return };
        ui.strong("Surface in space");
        ui.label(format!("{} faces, {} vertices", solid.scene.faces(), solid.scene.positions.len()));
        ui.separator();
        sharpness(ui, solid);
        ui.separator();
        let level = solid.level();
        let o = &mut solid.options;
        choose(ui, "shown", &mut o.shown, &SHOWN);
        let normals = [
            (SolidNormals::Blended, "blended N_B"),
            (SolidNormals::Geometric, "geometric N_L"),
            (SolidNormals::Subdivided, "subdivided N_S"),
        ];
        choose(ui, "normals", &mut o.normals, &normals);
        ui.add(Slider::new(&mut o.stripes, 1.0..=200.0).logarithmic(true).text("stripes"));
        ui.separator();
        ui.horizontal(|ui| {
            ui.selectable_value(&mut o.scheme, Scheme::CatmullClark, "Catmull-Clark");
            ui.selectable_value(&mut o.scheme, Scheme::Loop, "Loop");
        });
        ui.checkbox(&mut o.patches, "patches of the limit");
        ui.add(Slider::new(&mut o.level, 0..=6).text("level (0 to 6)"));
        if level < o.level {
            ui.weak(format!("level {level} is the finest that is drawn of a mesh so large"));
        }
        ui.separator();
        let s = &mut o.settings;
        ui.add(Slider::new(&mut s.normals_from, 1..=6).text("normals from"));
        ui.add(Slider::new(&mut s.weights_from, 0..=6).text("weights from"));
        ui.add(Slider::new(&mut s.power, 0.1..=10.0).logarithmic(true).text("p"));
        choose(ui, "variant", &mut s.rules.variant, &[(Variant::A, "A"), (Variant::B, "B")]);
        choose(ui, "darts", &mut s.rules.darts, &[(Darts::Smooth, "smooth"), (Darts::Sharp, "sharp")]);
        let initial = [(Initial::Ring, "ring"), (Initial::Inverse, "inverse limit"), (Initial::Vertex, "vertex")];
        choose(ui, "weights", &mut s.rules.initial, &initial);
        choose(ui, "N_L", &mut s.geometric, &[(Geometric::Limit, "of the limit"), (Geometric::Mesh, "of the mesh")]);
        ui.separator();
        ui.checkbox(&mut self.shown.mesh, "control mesh (G)");
        let mut smooth = self.look.samples == 4;
        if ui.checkbox(&mut smooth, "smooth edges (4 samples)").changed() {
            self.look.samples = if smooth { 4 } else { 1 };
        }
        ui.separator();
        ui.weak("Drag turns, wheel zooms, middle drag moves. E: sharp for ever or smooth; arrows up, down: by 0.5; 0 to 6: level.");
    }

    /// Draws the surface; its texture goes over the canvas.
    pub fn surface_picture(&mut self, ctx: &egui::Context) -> Option<egui::TextureId> {
        let (Some(solid), Some(renderer)) = (&mut self.solid, &self.renderer) else { return None };
        match solid.draw(&renderer.gpu, ctx, self.view.size(), self.look.samples) {
            Ok(texture) => texture,
            Err(e) => {
                self.fail(e);
                None
            }
        }
    }

    /// The control mesh over the surface, sharp edges by sharpness.
    pub fn paint_surface(&self, painter: &egui::Painter, pointer: Option<Pos2>) {
        let Some(solid) = &self.solid else { return };
        let eye = solid.eye(self.view.rect);
        let over = pointer.and_then(|at| solid.edge_at(&eye, at, REACH));
        for h in solid.edges() {
            let chosen = solid.selected.contains(&h);
            let s = solid.sharpness(h);
            if !(self.shown.mesh || chosen || over == Some(h)) {
                continue;
            }
            let [Some((a, _)), Some((b, _))] = solid.ends(h).map(|p| eye.place(p)) else { continue };
            let c = edge_colour(s, solid.on_boundary(h)) * 255.0;
            let colour = Color32::from_rgb(c.x as u8, c.y as u8, c.z as u8);
            let width = if s > 0.0 { 2.0 } else { 1.0 };
            if chosen {
                painter.line_segment([a, b], Stroke::new(width + 4.0, Color32::from_rgb(255, 210, 0)));
            } else if over == Some(h) {
                painter.line_segment([a, b], Stroke::new(width + 3.0, Color32::from_rgb(150, 190, 255)));
            }
            painter.line_segment([a, b], Stroke::new(width, colour));
        }
    }
}

fn turn(orbit: &mut Orbit, by: egui::Vec2) {
    orbit.yaw = (orbit.yaw - 0.4 * f64::from(by.x)).rem_euclid(360.0);
    orbit.pitch = (orbit.pitch + 0.4 * f64::from(by.y)).clamp(-89.9, 89.9);
}

fn choose<T: Copy + PartialEq>(ui: &mut Ui, name: &str, value: &mut T, all: &[(T, &str)]) {
    let now = all.iter().find(|(v, _)| v == value).map_or("", |(_, name)| name);
    ComboBox::from_label(name).selected_text(now).show_ui(ui, |ui| {
        for (v, name) in all {
            ui.selectable_value(value, *v, *name);
        }
    });
}

/// Sharpness of the selected edges.
fn sharpness(ui: &mut Ui, solid: &mut Solid) {
    let n = solid.selected.len();
    ui.label(match n {
        0 => "Click an edge; shift-click adds one.".to_owned(),
        1 => "1 edge".to_owned(),
        n => format!("{n} edges"),
    });
    let mut value = solid.selected.first().map_or(0.0, |&h| solid.sharpness(h)).min(INFINITE);
    let slider = Slider::new(&mut value, 0.0..=INFINITE).text("sharpness").custom_formatter(|n, _| {
        if n >= INFINITE {
            "for ever".to_owned()
        } else {
            format!("{n:.2}")
        }
    });
    let changed = ui.add_enabled(n > 0, slider).changed();
    let (mut smooth, mut ever) = (false, false);
    ui.horizontal(|ui| {
        smooth = ui.add_enabled(n > 0, egui::Button::new("Smooth")).on_hover_text("Delete").clicked();
        ever = ui.add_enabled(n > 0, egui::Button::new("For ever")).on_hover_text("E").clicked();
    });
    if changed || smooth || ever {
        solid.sharpen(match (smooth, ever) {
            (true, _) => 0.0,
            (_, true) => INFINITE,
            _ => value,
        });
    }
}
