//! A gradient mesh in the editor: its panel, and what is drawn over it.

use super::editor::Editor;
use super::overlay::{colour32, curve, disc, notice, pieces, segment};
use crate::edit::gradient::pick::Pick;
use crate::ferguson::inherit::Continuity;
use egui::{Color32, Mesh, Shape, Ui};
use glam::DVec4;

/// Handles that are shown at most, for the widgets' buffers: nearer, there are fewer.
const MOST_HANDLES: usize = 5000;
/// Curves that are shown at most.
const MOST_CURVES: usize = 20_000;

const LINE: Color32 = Color32::from_rgba_premultiplied(18, 18, 24, 150);
const CHOSEN: Color32 = Color32::from_rgb(30, 110, 230);

impl Editor {
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
            ui.weak("(C)");
        });
        ui.checkbox(&mut gradient.twists, "twists (W)");
        ui.checkbox(&mut self.prevent_folds, "prevent folds (P)");
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
        if remove {
            self.remove_selected_split();
        }
        self.gradient_colours(ui);
    }

    /// The colour of what is selected: any, or a swatch.
    fn gradient_colours(&mut self, ui: &mut Ui) {
        let selected = self.selected_colour();
        ui.strong("Colour");
        let before = selected.unwrap_or(self.brush.colour);
        let colour = super::panel::picker(ui, before);
        if colour != before {
            self.brush.colour = colour;
            if selected.is_some() {
                self.colour_selected(colour, true);
            }
        }
        if let Some(colour) = self.swatch_row(ui) {
            self.brush.colour = colour;
            if selected.is_some() {
                self.colour_selected(colour, false);
            }
        }
        let alone = selected.is_some_and(|c| c != self.brush.colour);
        if ui.add_enabled(alone, egui::Button::new("Paint selected")).clicked() {
            self.colour_selected(self.brush.colour, false);
        }
    }

    /// Curves, points and handles over the surface.
    pub fn paint_gradient(&self, painter: &egui::Painter) {
        let Some(gradient) = &self.gradient else { return };
        let (mesh, view) = (&gradient.mesh, self.view);
        let picks = gradient.picks(view.seen());
        let curves = picks.iter().filter(|p| matches!(p, Pick::Curve(_))).count();
        let most = pieces(curves);
        let few = picks.len() - curves <= MOST_HANDLES;
        let mut lines = Mesh::default();
        for &pick in &picks {
            let Pick::Curve(c) = pick else { continue };
            let q = mesh.bezier(c);
            let chosen = gradient.selected == Some(pick);
            let look = if chosen { (2.5, CHOSEN) } else { (1.0, LINE) };
            if chosen || (self.shown.mesh && curves <= MOST_CURVES) {
                curve(&mut lines, &q, |p| view.to_window(p), most, look);
            }
            if self.shown.handles && few {
                for [a, b] in [[q[0], q[1]], [q[3], q[2]]] {
                    segment(&mut lines, view.to_window(a), view.to_window(b), 1.0, LINE);
                }
            }
        }
        painter.add(Shape::mesh(lines));
        if !self.shown.handles {
            return;
        }
        if !few {
            return notice(painter, view.rect, "zoom in to see the handles");
        }
        let mut discs = Mesh::default();
        for &pick in &picks {
            let (radius, fill) = match pick {
                Pick::Point(p) if mesh.points[p as usize].on.is_some() => (3.0, Color32::from_gray(150)),
                Pick::Point(_) => (4.5, Color32::WHITE),
                Pick::Handle(..) => (3.0, Color32::from_rgb(240, 170, 40)),
                Pick::Twist(_) => (3.0, Color32::from_rgb(160, 90, 200)),
                Pick::Sector(h) => (5.5, colour32(mesh.colour.decode(mesh.corner(h).colour.value).with_w(1.0))),
                Pick::Curve(_) => continue,
            };
            let at = view.to_window(gradient.place(pick));
            let rim = if gradient.selected == Some(pick) { (2.5, CHOSEN) } else { (0.8, Color32::from_gray(60)) };
            disc(&mut discs, at, radius + rim.0, rim.1);
            disc(&mut discs, at, radius, fill);
        }
        painter.add(Shape::mesh(discs));
    }
}
