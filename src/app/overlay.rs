//! Painting what lies over the surface: control mesh, handles, influence, brush.

use super::canvas::cubic;
use super::editor::{Editor, Tool};
use crate::edit::handle::{Id, Kind};
use crate::edit::overlay::Edge;
use egui::{Color32, Mesh, Painter, Pos2, Rect, Shape, Stroke};
use glam::{DVec2, DVec4};

/// Colours of ZHHK22 Fig. 10: geometry green, colour vertices dark blue, their sectors light blue.
const GEOMETRY: Color32 = Color32::from_rgb(40, 150, 60);
const COLOUR: Color32 = Color32::from_rgb(30, 50, 150);
const SECTOR: Color32 = Color32::from_rgb(110, 170, 240);
const GRADIENT: Color32 = Color32::from_rgb(150, 190, 60);
const FACE_POINT: Color32 = Color32::from_rgb(90, 160, 150);
const LINE: Color32 = Color32::from_rgba_premultiplied(20, 22, 28, 110);
const SHARP: Color32 = Color32::from_rgb(200, 40, 120);
const SELECTED: Color32 = Color32::from_rgb(250, 150, 20);
const HOVERED: Color32 = Color32::from_rgb(255, 235, 120);

/// A colour as the widgets have it.
pub fn colour32(c: DVec4) -> Color32 {
    let byte = |x: f64| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
    Color32::from_rgba_unmultiplied(byte(c.x), byte(c.y), byte(c.z), byte(c.w))
}

fn handle_colour(kind: Kind) -> Color32 {
    match kind {
        Kind::Vertex | Kind::Input => GEOMETRY,
        Kind::Gradient => GRADIENT,
        Kind::FacePoint => FACE_POINT,
        Kind::Colour => COLOUR,
        Kind::Sector => SECTOR,
    }
}

/// Radius of a handle's disc, points.
fn radius(kind: Kind) -> f32 {
    match kind {
        Kind::Vertex | Kind::Input => 4.0,
        Kind::Gradient | Kind::FacePoint => 3.0,
        // A ring around the point of its vertex, so that both are seen.
        Kind::Colour => 6.5,
        Kind::Sector => 3.2,
    }
}

impl Editor {
    /// Paints everything over the surface.
    pub fn paint_over(&mut self, painter: &Painter, pointer: Option<Pos2>) {
        let view = self.view;
        if self.shown.grid > 0.0 {
            self.paint_grid(painter);
        }
        let shown = self.shown;
        let (hover, edge, selection) = (self.hand.hover, self.hand.edge, self.selection.clone());
        let mesh_of = self.model.mesh.clone();
        let overlay = self.overlay();
        let crowded = overlay.crowded;
        let mut lines = Mesh::default();
        let most = pieces(overlay.edges.len());
        if shown.mesh {
            for e in &overlay.edges {
                let hovered = e.input && edge.is_some() && same_edge(&mesh_of, e, edge);
                let (width, colour) = match (hovered, e.sharp, e.input) {
                    (true, ..) => (3.0, HOVERED),
                    (_, true, _) => (2.0, SHARP),
                    (_, _, true) => (1.4, LINE),
                    _ => (0.8, LINE),
                };
                curve(&mut lines, &e.curve, |p| view.to_window(p), most, (width, colour));
            }
        }
        painter.add(Shape::mesh(lines));
        if shown.influence && !selection.is_empty() {
            let mut outlines = Mesh::default();
            let both = self.influence().clone();
            let most = pieces(both.iter().map(|i| i.outline.len()).sum());
            for (influence, colour) in both.iter().zip([GEOMETRY, COLOUR]) {
                for c in &influence.outline {
                    curve(&mut outlines, c, |p| view.to_window(p), most, (2.2, colour));
                }
            }
            painter.add(Shape::mesh(outlines));
        }
        if shown.handles {
            let mut discs = Mesh::default();
            for handle in &self.overlay().handles {
                let id = handle.id;
                let at = view.to_window(handle.shown);
                let r = radius(id.kind);
                let mark = if Some(id) == hover {
                    Some(HOVERED)
                } else if selection.contains(&id) {
                    Some(SELECTED)
                } else {
                    None
                };
                if id.kind == Kind::Sector {
                    segment(&mut discs, view.to_window(centre_of(handle)), at, 1.0, SECTOR);
                }
                if let Some(mark) = mark {
                    disc(&mut discs, at, r + 2.5, mark);
                }
                match id.kind {
                    Kind::Colour => ring(&mut discs, at, r, 2.0, mark.unwrap_or(COLOUR)),
                    Kind::Sector => {
                        disc(&mut discs, at, r + 1.0, SECTOR);
                        disc(&mut discs, at, r - 0.6, colour32(handle.colour.with_w(1.0)));
                    }
                    kind => {
                        disc(&mut discs, at, r, Color32::WHITE);
                        disc(&mut discs, at, r - 1.0, handle_colour(kind));
                    }
                }
            }
            painter.add(Shape::mesh(discs));
        }
        if crowded {
            notice(painter, view.rect, "zoom in to see the handles of this level");
        }
        self.paint_pointer(painter, pointer);
    }

    fn paint_pointer(&mut self, painter: &Painter, pointer: Option<Pos2>) {
        let Some(pos) = pointer else { return };
        if let Some(from) = self.hand.from {
            let rect = Rect::from_two_pos(self.view.to_window(from), pos);
            painter.rect(rect, 0.0, Color32::from_rgba_unmultiplied(250, 150, 20, 30), Stroke::new(1.0, SELECTED));
        }
        if self.tool == Tool::Draw && !self.hand.corners.is_empty() {
            let mut lines = Mesh::default();
            let mut at: Vec<Pos2> = self.hand.corners.iter().map(|&p| self.view.to_window(p)).collect();
            let placed = at.len();
            at.push(pos);
            at.windows(2).for_each(|w| segment(&mut lines, w[0], w[1], 1.6, SELECTED));
            segment(&mut lines, pos, at[0], 1.0, LINE);
            at.iter().take(placed).for_each(|&p| disc(&mut lines, p, 4.0, GEOMETRY));
            painter.add(Shape::mesh(lines));
        }
        if self.tool == Tool::Brush {
            let colour = if self.brush.moves { GEOMETRY } else { colour32(self.brush.colour.with_w(1.0)) };
            painter.circle_stroke(pos, self.brush.radius, Stroke::new(3.0, Color32::from_black_alpha(120)));
            painter.circle_stroke(pos, self.brush.radius, Stroke::new(1.5, colour));
        }
    }

    fn paint_grid(&self, painter: &Painter) {
        let view = self.view;
        let [x0, y0, x1, y1] = view.seen();
        let step = self.shown.grid;
        // Lines closer than this are no help.
        if step / view.per_point() < 5.0 {
            return;
        }
        let mut lines = Mesh::default();
        let colour = Color32::from_black_alpha(28);
        for i in (x0 / step).ceil() as i64..=(x1 / step).floor() as i64 {
            let x = i as f64 * step;
            let ends = [DVec2::new(x, y0), DVec2::new(x, y1)].map(|p| view.to_window(p));
            segment(&mut lines, ends[0], ends[1], 1.0, colour);
        }
        for i in (y0 / step).ceil() as i64..=(y1 / step).floor() as i64 {
            let y = i as f64 * step;
            let ends = [DVec2::new(x0, y), DVec2::new(x1, y)].map(|p| view.to_window(p));
            segment(&mut lines, ends[0], ends[1], 1.0, colour);
        }
        painter.add(Shape::mesh(lines));
    }
}

/// A line of text at the top of the canvas.
pub(super) fn notice(painter: &Painter, canvas: Rect, text: &str) {
    let at = canvas.center_top() + egui::vec2(0.0, 14.0);
    let font = egui::FontId::proportional(15.0);
    let rect = painter.text(at, egui::Align2::CENTER_TOP, text, font.clone(), Color32::TRANSPARENT);
    painter.rect_filled(rect.expand(5.0), 4.0, Color32::from_black_alpha(170));
    painter.text(at, egui::Align2::CENTER_TOP, text, font, Color32::WHITE);
}

fn centre_of(handle: &crate::edit::overlay::Handle) -> DVec2 {
    handle.at
}

fn same_edge(mesh: &crate::mesh::HalfEdgeMesh, e: &Edge, wanted: Option<u32>) -> bool {
    let found = crate::edit::overlay::input_edge(mesh, e.slot);
    let (Some(a), Some(b)) = (found, wanted) else { return false };
    a == b || mesh.twin[a as usize] == b
}

/// Which handle a name is, for people.
pub fn describe(id: Id) -> String {
    let what = match id.kind {
        Kind::Vertex => "vertex",
        Kind::Input => "vertex of the input mesh",
        Kind::Gradient => "gradient handle",
        Kind::FacePoint => "face point",
        Kind::Colour => "colour",
        Kind::Sector => "colour of a sector",
    };
    format!("{what}, level {}", id.level)
}

// Plain meshes, four vertices a line and nine a disc: thousands of handles have to fit into the widgets' buffers.

/// Most straight pieces of a curve where there are `curves` of them.
pub(super) fn pieces(curves: usize) -> u32 {
    (12_000 / curves.max(1)).clamp(1, 24) as u32
}

pub(super) fn curve(
    mesh: &mut Mesh,
    c: &[DVec2; 4],
    to_window: impl Fn(DVec2) -> Pos2,
    most: u32,
    (width, colour): (f32, Color32),
) {
    let ends = [to_window(c[0]), to_window(c[3])];
    // How far the curve is from its chord decides how many pieces it takes.
    let bend = (0..4).map(|i| to_window(c[i]).distance(lerp(ends, i as f32 / 3.0))).fold(0.0f32, f32::max);
    let pieces = ((bend * 4.0).sqrt().ceil() as u32).clamp(1, most);
    let mut before = ends[0];
    for i in 1..=pieces {
        let at = to_window(cubic(c, f64::from(i) / f64::from(pieces)));
        segment(mesh, before, at, width, colour);
        before = at;
    }
}

fn lerp([a, b]: [Pos2; 2], t: f32) -> Pos2 {
    a + (b - a) * t
}

pub(super) fn segment(mesh: &mut Mesh, a: Pos2, b: Pos2, width: f32, colour: Color32) {
    let along = (b - a).normalized();
    let across = along.rot90() * (0.5 * width);
    let first = mesh.vertices.len() as u32;
    for p in [a + across, a - across, b - across, b + across] {
        mesh.colored_vertex(p, colour);
    }
    mesh.add_triangle(first, first + 1, first + 2);
    mesh.add_triangle(first, first + 2, first + 3);
}

pub(super) fn disc(mesh: &mut Mesh, at: Pos2, radius: f32, colour: Color32) {
    const CORNERS: u32 = 10;
    let first = mesh.vertices.len() as u32;
    mesh.colored_vertex(at, colour);
    for i in 0..CORNERS {
        let turn = std::f32::consts::TAU * i as f32 / CORNERS as f32;
        mesh.colored_vertex(at + egui::Vec2::angled(turn) * radius, colour);
        mesh.add_triangle(first, first + 1 + i, first + 1 + (i + 1) % CORNERS);
    }
}

fn ring(mesh: &mut Mesh, at: Pos2, radius: f32, width: f32, colour: Color32) {
    const CORNERS: u32 = 12;
    let on =
        |i: u32, r: f32| at + egui::Vec2::angled(std::f32::consts::TAU * (i % CORNERS) as f32 / CORNERS as f32) * r;
    let first = mesh.vertices.len() as u32;
    for i in 0..CORNERS {
        mesh.colored_vertex(on(i, radius - 0.5 * width), colour);
        mesh.colored_vertex(on(i, radius + 0.5 * width), colour);
        let (a, b) = (first + 2 * i, first + 2 * ((i + 1) % CORNERS));
        mesh.add_triangle(a, a + 1, b);
        mesh.add_triangle(b, a + 1, b + 1);
    }
}
