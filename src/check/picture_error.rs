//! How far a picture is from the limit: colour by pixel, position by point.

use super::cracks::{self, OutlineEdge};
use super::exact::ExactFace;
use super::limit_picture::LimitPicture;
use super::locate::{locate, to_base, turned, Drawn, DrawnPoint};
use crate::patch::build::face_control;
use crate::patch::tess::{TessRule, MAX_LEVEL};
use crate::patch::{eval, Face, Kind, PatchTable};
use crate::refine::Refinement;
use glam::DVec2;
use std::collections::HashMap;

/// Pixels nearer than this to a silhouette or a sharp edge, of the patches or of the limit, are those edges' own: which
/// side of the edge such a pixel shows is not a matter of colour.
pub const EDGE_PIXELS: f64 = 1.0;

/// Cells of the limit that are turned over make pixels nearer than this a fold's: which of its layers such a pixel shows
/// is a matter of the order of drawing.
pub const FOLD_PIXELS: f64 = 1.0;

/// What was drawn, and the limit beside it.
pub struct Compared<'a> {
    /// Levels that the patches were made from.
    pub drawn: &'a Refinement,
    /// The patches.
    pub table: &'a PatchTable,
    /// The same scene by [`crate::refine::Rules::Gradtess`], adaptive.
    pub limit: &'a Refinement,
    /// Model rectangle of the picture, x0, y0, x1, y1.
    pub view: [f64; 4],
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Tessellation of the picture.
    pub tess: TessRule,
}

/// Greatest and mean distance of a set of pixels, in per cent of the RGB cube's diagonal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distances {
    /// Pixels.
    pub pixels: usize,
    /// Greatest.
    pub max: f64,
    /// Mean; 0 of no pixels.
    pub mean: f64,
}

impl Distances {
    fn add(&mut self, percent: f64) {
        self.pixels += 1;
        self.max = self.max.max(percent);
        self.mean += (percent - self.mean) / self.pixels as f64;
    }
}

/// Where something is greatest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// In the model.
    pub position: [f64; 2],
    /// Number of the drawn face in [`PatchTable::faces`]; `None` where a limit face has no drawn one.
    pub face: Option<usize>,
    /// Parameters in that face's own domain.
    pub uv: [f64; 2],
}

/// The error of a picture.
#[derive(Clone, Debug)]
pub struct PictureError {
    /// Over all pixels compared.
    pub all: Distances,
    /// Over those in bicubic and in Gregory faces.
    pub by_kind: [Distances; 2],
    /// Pixel (column, row) of the greatest distance, and what is there.
    pub worst: Option<([u32; 2], Place)>,
    /// Over those where the limit folds over ([`FOLD_PIXELS`]), which are not among the others.
    pub folds: Distances,
    /// Pixels left out as edges' own ([`EDGE_PIXELS`]).
    pub edges: usize,
    /// Pixels away from edges that only one of the two pictures covers.
    pub coverage: usize,
    /// Greatest distance of a patch's point from the limit point of the same parameters, in pixels: an upper bound of the
    /// distance between the surfaces at the points sampled.
    pub shift: f64,
    /// Where that is.
    pub shift_at: Option<Place>,
    /// Distance of every pixel, in per cent; [`BACKGROUND`] or [`EDGE`] where none was taken. Rows from the top.
    pub map: Vec<f32>,
}

/// In [`PictureError::map`]: neither picture covers the pixel, or only one does.
pub const BACKGROUND: f32 = -1.0;
/// In [`PictureError::map`]: an edge's own pixel.
pub const EDGE: f32 = -2.0;

impl Compared<'_> {
    fn scale(&self) -> DVec2 {
        let [x0, y0, x1, y1] = self.view;
        DVec2::new(f64::from(self.size[0]) / (x1 - x0), f64::from(self.size[1]) / (y1 - y0))
    }

    fn pixel(&self, p: DVec2) -> DVec2 {
        let scale = self.scale();
        DVec2::new((p.x - self.view[0]) * scale.x, (self.view[3] - p.y) * scale.y)
    }

    /// Compares the two pictures, four f32 a pixel: that of the patches and that of `limit`'s table.
    pub fn pictures(&self, limit: &mut LimitPicture, drawn: &[f32], limit_channels: &[f32]) -> PictureError {
        let [width, height] = self.size;
        let scale = self.scale();
        let edges = self.edge_pixels(limit);
        let folds = self.fold_pixels(limit);
        let names = Drawn::new(self.table);
        let mut error = PictureError {
            all: Distances::default(),
            by_kind: [Distances::default(); 2],
            worst: None,
            folds: Distances::default(),
            edges: 0,
            coverage: 0,
            shift: 0.0,
            shift_at: None,
            map: vec![BACKGROUND; (width * height) as usize],
        };
        for (i, (a, b)) in drawn.chunks_exact(4).zip(limit_channels.chunks_exact(4)).enumerate() {
            let (x, y) = (i as u32 % width, i as u32 / width);
            let centre =
                DVec2::new(self.view[0], self.view[3]) + DVec2::new(f64::from(x) + 0.5, -f64::from(y) - 0.5) / scale;
            let exact = limit.at([b[0], b[1], b[2], b[3]], centre.to_array());
            if edges[i] {
                error.edges += usize::from(exact.is_some());
                error.map[i] = EDGE;
                continue;
            }
            let Some(exact) = exact.filter(|_| a[3] > 0.0) else {
                error.coverage += usize::from(a[3] > 0.0 || b[3] > 0.0);
                continue;
            };
            // As shown: both clamped to the unit cube.
            let shown = |c: f64| c.clamp(0.0, 1.0);
            let square: f64 = (0..3).map(|k| (shown(f64::from(a[k])) - shown(exact.colour[k])).powi(2)).sum();
            let percent = 100.0 * (square / 3.0).sqrt();
            error.map[i] = percent as f32;
            if folds[i] {
                error.folds.add(percent);
                continue;
            }
            let name = self.limit.levels[exact.level as usize].face[exact.face as usize];
            let there = locate(self.drawn, to_base(self.limit, exact.level, name, exact.uv));
            let face = names.at(self.drawn, there);
            let kind = face.map_or(Kind::Bicubic, |f| self.table.faces[f].kind);
            if percent > error.all.max || error.worst.is_none() {
                error.worst = Some(([x, y], Place { position: centre.to_array(), face, uv: there.uv }));
            }
            error.all.add(percent);
            error.by_kind[usize::from(kind == Kind::Gregory)].add(percent);
        }
        (error.shift, error.shift_at) = self.shift();
        error
    }

    /// Points of every drawn face, patch against limit.
    fn shift(&self) -> (f64, Option<Place>) {
        let mut exact: HashMap<(u32, u32), ExactFace> = HashMap::new();
        let (mut most, mut place) = (0.0, None);
        let [x0, y0, x1, y1] = self.view;
        for (i, face) in self.table.faces.iter().enumerate() {
            let points = face_control(self.table, face);
            let n = if face.irregular { 12 } else { 3 };
            for (k, j) in (0..=n).flat_map(|k| (0..=n).map(move |j| (k, j))) {
                let uv = [f64::from(j) / f64::from(n), f64::from(k) / f64::from(n)];
                let p = eval::face(face.kind, &points, uv[0], uv[1]);
                if !(p[0] >= x0 && p[0] <= x1 && p[1] >= y0 && p[1] <= y1) {
                    continue;
                }
                let own = turned((4 - face.turn) & 3, uv);
                let DrawnPoint { level, face: f, uv: [u, v] } =
                    locate(self.limit, to_base(self.drawn, face.level, face.name, own));
                let there =
                    exact.entry((level, f)).or_insert_with(|| ExactFace::new(self.limit, level as usize, f)).at(u, v);
                let off = ((DVec2::new(p[0], p[1]) - there.p) * self.scale()).length();
                if off > most {
                    (most, place) = (off, Some(Place { position: [p[0], p[1]], face: Some(i), uv: own }));
                }
            }
            exact.clear();
        }
        (most, place)
    }

    /// Pixels that silhouettes and sharp edges pass through or by.
    fn edge_pixels(&self, limit: &mut LimitPicture) -> Vec<bool> {
        let mut lines = cracks::segments(&self.drawn_edges(), self.tess, MAX_LEVEL, self.view, self.size);
        limit.edges(self.limit, |a, b| lines.push([self.pixel(a), self.pixel(b)]));
        let (width, height) = (f64::from(self.size[0]), f64::from(self.size[1]));
        let mut near = vec![false; (self.size[0] * self.size[1]) as usize];
        for [a, b] in lines {
            // Long segments in pieces, so that the boxes around them stay small.
            let pieces = ((b - a).length() / 8.0).ceil().clamp(1.0, 1e4) as u32;
            for piece in 0..pieces {
                let at = |k: u32| a + (b - a) * (f64::from(k) / f64::from(pieces));
                let (from, to) = (at(piece), at(piece + 1));
                let low = (from.min(to) - EDGE_PIXELS - 0.5).ceil().max(DVec2::ZERO);
                let high = (from.max(to) + EDGE_PIXELS - 0.5).floor().min(DVec2::new(width - 1.0, height - 1.0));
                for y in low.y as i64..=high.y as i64 {
                    for x in low.x as i64..=high.x as i64 {
                        let centre = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                        if cracks::distance(centre, from, to) <= EDGE_PIXELS {
                            near[y as usize * self.size[0] as usize + x as usize] = true;
                        }
                    }
                }
            }
        }
        near
    }

    /// Pixels where the limit folds over. A point inside the outline is covered once more by faces that run as their component
    /// does than by faces that are turned over, so several layers lie only where one of them is turned over.
    fn fold_pixels(&self, limit: &LimitPicture) -> Vec<bool> {
        let (width, height) = (f64::from(self.size[0]), f64::from(self.size[1]));
        let mut folded = vec![false; (self.size[0] * self.size[1]) as usize];
        for cell in &limit.turned {
            // Cells have a side of two pixels, so that their boxes say enough.
            let corners = cell.map(|p| self.pixel(p));
            let low = corners.into_iter().fold(DVec2::INFINITY, DVec2::min) - FOLD_PIXELS - 0.5;
            let high = corners.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max) + FOLD_PIXELS - 0.5;
            let (low, high) = (low.ceil().max(DVec2::ZERO), high.floor().min(DVec2::new(width - 1.0, height - 1.0)));
            for y in low.y as i64..=high.y as i64 {
                for x in low.x as i64..=high.x as i64 {
                    folded[y as usize * self.size[0] as usize + x as usize] = true;
                }
            }
        }
        folded
    }

    /// Edges of drawn faces on the boundary of the mesh or along sharp edges.
    fn drawn_edges(&self) -> Vec<OutlineEdge> {
        let mut edges = Vec::new();
        for face in &self.table.faces {
            let Some(first) = half_edge(self.drawn, face) else { continue };
            let level = &self.drawn.levels[face.level as usize];
            let borders = [0u8, 1, 2, 3].map(|i| level.colour_border(first + u32::from((i + face.turn) & 3)));
            if borders.contains(&true) {
                let control = face_control(self.table, face);
                for (i, slots) in eval::FACE_EDGES.into_iter().enumerate().filter(|(i, _)| borders[*i]) {
                    let finer = u32::from(face.transition >> i & 1);
                    let points = slots.map(|s| DVec2::new(control[s][0], control[s][1]));
                    edges.push(OutlineEdge { points, level: face.level + finer });
                }
            }
        }
        edges
    }
}

/// First half-edge of a drawn face in its level.
fn half_edge(refinement: &Refinement, face: &Face) -> Option<u32> {
    let level = &refinement.levels[face.level as usize];
    // Faces stand in the order of their names.
    level.face.binary_search(&face.name).ok().map(|f| level.first(f as u32))
}
