//! Modelling: the panel that changes the input mesh's polygons.

use super::editor::{Editor, Tool};
use crate::edit::handle::{origin_of, Kind, Origin, Stage};
use crate::edit::{shape, EditError};
use crate::scene::{InputMesh, Scene};
use egui::Ui;
use glam::DVec2;

impl Editor {
    /// Selected vertices of the input mesh.
    fn chosen_vertices(&self) -> Vec<u32> {
        let origin = |slot| match origin_of(&self.model.mesh, slot) {
            Origin::Vertex(v) => Some(v),
            _ => None,
        };
        let ids = self.selection.iter().filter(|id| id.level == 0 && matches!(id.kind, Kind::Input | Kind::Vertex));
        ids.filter_map(|id| origin(id.slot)).collect()
    }

    /// Adds a corner to the polygon that is drawn. A click on its first or last corner closes it.
    pub fn add_corner(&mut self, at: DVec2) {
        let reach = f64::from(super::canvas::REACH) * self.view.per_point();
        let near = |p: Option<&DVec2>| p.is_some_and(|p| p.distance(at) <= reach);
        let corners = &self.hand.corners;
        if near(corners.first()) || near(corners.last()) {
            if corners.len() > 2 {
                self.close_polygon();
            }
            return;
        }
        let at = self.snapped(at);
        if !self.hand.corners.contains(&at) {
            self.hand.corners.push(at);
        }
    }

    /// Makes a face of the polygon that is drawn, in the scene or as one of its own.
    pub fn close_polygon(&mut self) {
        if self.hand.corners.is_empty() {
            return;
        }
        let corners = std::mem::take(&mut self.hand.corners);
        let anew = std::mem::take(&mut self.hand.anew);
        let done = if anew && corners.len() > 2 {
            let count = corners.len() as u32;
            let (all, face_start) = ((0..count).collect(), vec![0, count]);
            let mesh = InputMesh { positions: corners, corners: all, face_start, face_line: Vec::new() };
            self.take(Editor::coloured(mesh), None)
        } else {
            self.change("draw polygon", |scene, _| shape::add_polygon(scene, &corners))
        };
        if done {
            self.set_stage(Stage::Input);
            self.tool = Tool::Move;
        }
    }

    /// The panel.
    pub fn model_panel(&mut self, ui: &mut Ui) {
        ui.strong("Model");
        if self.stage != Stage::Input {
            ui.weak("polygons are changed in the input mesh (M)");
            return;
        }
        let chosen = self.chosen_vertices();
        let two = <[u32; 2]>::try_from(chosen.clone()).ok();
        ui.horizontal_wrapped(|ui| {
            let mut pair =
                |ui: &mut Ui, name: &str, what: &str, act: fn(&mut Scene, u32, u32) -> Result<(), EditError>| {
                    let button = ui.add_enabled(two.is_some(), egui::Button::new(name)).on_hover_text(what);
                    if let (true, Some([a, b])) = (button.clicked(), two) {
                        self.change(name, |scene, _| act(scene, a, b));
                    }
                };
            pair(ui, "Split edge", "select both ends", shape::split_edge);
            pair(ui, "Split face", "select two of its corners", shape::split_face);
            pair(ui, "Extrude", "select both ends of an edge of the boundary", shape::extrude);
            pair(ui, "Weld", "select two vertices", shape::weld);
            let enough =
                ui.add_enabled(chosen.len() > 2, egui::Button::new("Add face")).on_hover_text("select its corners");
            if enough.clicked() {
                self.change("add face", |scene, _| shape::add_face(scene, &chosen));
            }
            let any =
                ui.add_enabled(!chosen.is_empty(), egui::Button::new("Delete")).on_hover_text("the selected vertices");
            if any.clicked() {
                self.change("delete", |scene, _| shape::delete(scene, &chosen));
            }
        });
        ui.horizontal(|ui| {
            let id = ui.id().with("corners");
            let mut n = ui.data(|d| d.get_temp::<u32>(id)).unwrap_or(4);
            let add = ui.button("Add polygon").on_hover_text("a regular one in the middle of the view").clicked();
            ui.add(egui::DragValue::new(&mut n).clamp_range(3..=64));
            ui.data_mut(|d| d.insert_temp(id, n));
            if add {
                let radius = 60.0 * self.view.per_point();
                let on = |k: u32| DVec2::from_angle(std::f64::consts::TAU * (f64::from(k) + 0.5) / f64::from(n));
                let points: Vec<DVec2> = (0..n).map(|k| self.view.centre + on(k) * radius).collect();
                self.change("add polygon", |scene, _| shape::add_polygon(scene, &points));
            }
        });
        for note in self.model.notes.iter().take(4) {
            ui.colored_label(ui.visuals().warn_fg_color, note.to_string());
        }
    }
}
