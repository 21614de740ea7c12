//! A gradient mesh in the editor: files, the pointer, the keys that only it has.

use super::canvas::{released_at, REACH};
use super::editor::Editor;
use crate::edit::gradient::pick::Pick;
use crate::edit::gradient::{Gradient, Op};
use crate::ferguson::inherit::Continuity;
use crate::ferguson::split::Axis;
use crate::ferguson::{FergusonError, Mesh};
use crate::scene::{self, ferguson, read_bounded};
use egui::{Key, PointerButton, Response, Ui};
use glam::{DVec2, DVec4};
use std::path::{Path, PathBuf};

impl Editor {
    /// Opens a scene of technique `ferguson`; `false`: the file is of another.
    pub fn open_gradient(&mut self, file: &Path) -> bool {
        let Ok(bytes) = read_bounded(file) else { return false };
        if scene::technique(&bytes) != scene::Technique::Ferguson {
            return false;
        }
        match Gradient::read(bytes, file.display().to_string()) {
            Ok((gradient, notes)) => {
                self.message = None;
                if self.take_gradient(gradient, Some(file.to_path_buf())) {
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

    /// Takes a gradient mesh in place of what is open.
    pub fn take_gradient(&mut self, gradient: Gradient, file: Option<PathBuf>) -> bool {
        let taken = self.take(Editor::fresh("quad"), file);
        if taken {
            self.gradient = Some(gradient);
            self.look.show = crate::gpu::Show::Surface;
            self.forget_drawn();
        }
        taken
    }

    /// A gradient mesh of columns by rows of patches with mild colours.
    pub fn new_gradient(&mut self, [columns, rows]: [u32; 2]) {
        let corner = [0.0, 0.0, f64::from(columns), f64::from(rows)];
        let shade = |i: u32, j: u32| Editor::shade(i + 2 * j);
        match Mesh::grid(columns, rows, corner, shade) {
            Ok(mut mesh) => {
                mesh.name = "untitled".to_owned();
                self.take_gradient(Gradient::new(mesh), None);
            }
            Err(e) => self.fail(e),
        }
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
        if !is_json(file) {
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

    /// Does something to the gradient mesh, and says why not.
    fn with_gradient(&mut self, act: impl FnOnce(&mut Gradient) -> Result<(), FergusonError>) {
        if let Some(Err(e)) = self.gradient.as_mut().map(act) {
            self.fail(e);
        }
    }

    /// A step of the gradient mesh back, or again.
    pub fn gradient_step(&mut self, forward: bool) {
        let Some(gradient) = &mut self.gradient else { return };
        self.hand.gradient = None;
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
            Some(Pick::Curve(c)) => self.with_gradient(|gradient| {
                gradient.selected = None;
                gradient.act(Op::Remove(c))
            }),
            _ => self.say("select the curve of a split first"),
        }
    }

    /// The colour of the point or the sector that is selected; sRGB, straight alpha.
    pub fn selected_colour(&self) -> Option<DVec4> {
        let gradient = self.gradient.as_ref()?;
        let corner = match gradient.selected? {
            Pick::Point(p) => *gradient.mesh.points[p as usize].corners.first()?,
            Pick::Sector(h) => h,
            _ => return None,
        };
        Some(gradient.mesh.colour.decode(gradient.mesh.corner(corner).colour.value))
    }

    /// Colours the point or the sector that is selected; sRGB, straight alpha. `gesture`: as part of one.
    pub fn colour_selected(&mut self, colour: DVec4, gesture: bool) {
        let Some(gradient) = &self.gradient else { return };
        let encoded = gradient.mesh.colour.space.encode(colour, gradient.mesh.colour.premultiplied);
        let op = match gradient.selected {
            Some(Pick::Point(p)) => Op::Colour(p, encoded),
            Some(Pick::Sector(h)) => Op::Sector(h, encoded),
            _ => return self.say("select a point or one of its sectors first"),
        };
        self.with_gradient(|gradient| if gesture { gradient.during(op) } else { gradient.act(op) });
    }

    /// Moves what is selected by pixels right and up.
    pub fn nudge_gradient(&mut self, by: DVec2) {
        let Some(pick) = self.gradient.as_ref().and_then(|g| g.selected) else {
            return self.say("select a point, a handle or a twist first");
        };
        let by = by * self.view.unit;
        self.drag_gradient(pick, |at| at + by);
        self.with_gradient(|gradient| {
            gradient.commit();
            Ok(())
        });
    }

    fn drag_gradient(&mut self, pick: Pick, to: impl Fn(DVec2) -> DVec2) {
        // A hundredth of a pixel.
        let tolerance = self.prevent_folds.then_some(0.01 * self.view.unit);
        let Some(gradient) = &mut self.gradient else { return };
        let to = to(gradient.place(pick));
        match gradient.drag(pick, to, tolerance) {
            Ok(true) => self.say("stopped: a patch would fold over"),
            Ok(false) => self.message = self.message.take().filter(|m| !m.text.starts_with("stopped")),
            Err(e) => self.fail(e),
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
        if (u || v) && over && self.hand.gradient.is_none() {
            match gradient.patch_at(at) {
                Some((p, s, t)) => {
                    let op = if u { Op::Split(p, Axis::U, s) } else { Op::Split(p, Axis::V, t) };
                    self.with_gradient(|gradient| gradient.act(op));
                }
                None => self.say("no patch is under the pointer"),
            }
        }
        let Some(gradient) = &mut self.gradient else { return };
        if pressed && canvas.hovered() {
            gradient.selected = gradient.at(at, f64::from(REACH) * self.view.per_point());
            self.hand.gradient = gradient.selected.map(|pick| (pick, gradient.place(pick) - at));
            if let Some(colour) = self.selected_colour() {
                self.brush.colour = colour;
            }
        }
        if let (true, Some((pick, offset))) = (down || released.is_some(), self.hand.gradient) {
            let to = released.map_or(at, |pos| self.view.to_model(pos)) + offset;
            let view = self.view;
            let shown = self.gradient.as_ref().map_or(to, |g| g.place(pick));
            // A click is no drag.
            if view.to_window(shown).distance(view.to_window(to)) >= 0.5 {
                self.drag_gradient(pick, |_| to);
            }
        }
        if released.is_some() && self.hand.gradient.take().is_some() {
            self.commit();
        }
    }
}

/// Whether a file is one that gradient meshes are saved to.
pub fn is_json(file: &Path) -> bool {
    file.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"))
}

fn other(continuity: Continuity) -> Continuity {
    match continuity {
        Continuity::C1 => Continuity::C0,
        Continuity::C0 => Continuity::C1,
    }
}
