//! The picture of the limit surface itself.
//!
//! Coverage must follow the rule that the patches' picture follows, or every outline pixel would count as an error. So the
//! limit is sampled on a grid of about two pixels and drawn by the same rasteriser as flat quads, whose colour channels
//! say which face and which parameters a pixel sees. What colour belongs there is then computed in f64: the exact limit at
//! these parameters, carried to the pixel's centre by its derivatives. The grid is so fine only that this last step is
//! short; its error is of second order in the distance of a chord from its curve, a hundredth of a pixel or so.

use super::exact::ExactFace;
use super::folds::{base_of_name, orientations};
use crate::patch::{ControlPoint, DrawRange, Kind, PatchTable};
use crate::refine::{fate, Refinement};
use glam::{DVec2, DVec4};

/// Cells of a picture at most; beyond, they are larger than two pixels.
const MOST_CELLS: u64 = 1_500_000;

/// Pixels a cell's side is to have.
const CELL: f64 = 2.0;

/// The limit in a model rectangle, ready to be drawn at tessellation level 1.
pub struct LimitPicture {
    faces: Vec<(u32, u32, ExactFace)>,
    /// Cells along a face of level 0; half as many at each further level.
    cells: u64,
    /// One flat quad a cell: r is the face, g and b are u and v.
    pub table: PatchTable,
    /// Corners in order around of the cells that are turned over: where they lie, the surface folds and more than one of its
    /// layers covers a point.
    pub turned: Vec<[DVec2; 4]>,
}

/// What the limit is at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitPoint {
    /// Level and number of the face of the refinement.
    pub level: u32,
    /// Number of the face in its level.
    pub face: u32,
    /// Its parameters.
    pub uv: [f64; 2],
    /// Colour, straight alpha, not clamped.
    pub colour: DVec4,
}

impl LimitPicture {
    /// Samples the drawn faces of `refinement` that come near `view` (x0, y0, x1, y1), of which a picture `scale` pixels a
    /// model unit will be drawn. `refinement` must follow [`crate::refine::Rules::Gradtess`], by which no finer edit reaches a drawn face.
    pub fn new(refinement: &Refinement, view: [f64; 4], scale: [f64; 2]) -> LimitPicture {
        let scale = DVec2::from(scale);
        let mut faces = Vec::new();
        // Cells that a face of level 0 would need.
        let mut needed = 1.0f64;
        for (l, (level, fates)) in refinement.levels.iter().zip(&refinement.fates).enumerate() {
            for f in
                (0..level.faces() as u32).filter(|&f| fates[f as usize] & fate::DRAWN != 0 && level.valence(f) == 4)
            {
                let mut exact = ExactFace::new(refinement, l, f);
                let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
                let mut rows = [[DVec2::ZERO; 5]; 5];
                for (j, row) in rows.iter_mut().enumerate() {
                    for (i, p) in row.iter_mut().enumerate() {
                        *p = exact.at(i as f64 / 4.0, j as f64 / 4.0).p;
                        (low, high) = (low.min(*p), high.max(*p));
                    }
                }
                // What bulges between the samples stays within a fraction of the whole.
                let margin = (high - low) * 0.25;
                let [x0, y0, x1, y1] = view;
                let seen = low.cmple(DVec2::new(x1, y1) + margin) & high.cmpge(DVec2::new(x0, y0) - margin);
                if !seen.all() {
                    continue;
                }
                let along = rows.iter().flat_map(|row| row.windows(2).map(|p| p[1] - p[0]));
                let across = rows.windows(2).flat_map(|pair| (0..5).map(|k| pair[1][k] - pair[0][k]));
                let longest = along.chain(across).map(|d| (d * scale).length()).fold(0.0, f64::max);
                needed = needed.max(4.0 * longest / CELL * 2f64.powi(l as i32));
                faces.push((l as u32, f, exact));
            }
        }
        let deepest = faces.iter().map(|f| f.0).max().unwrap_or(0);
        // A power of two, so that the grids of neighbouring levels meet, and at least one cell on the deepest.
        let mut cells = (needed.min(1e6) as u64).next_power_of_two().max(1 << deepest);
        let count = |cells: u64| faces.iter().map(|f| (cells >> f.0).pow(2)).sum::<u64>();
        while count(cells) > MOST_CELLS && cells > 1 << deepest {
            cells /= 2;
        }
        let mut picture = LimitPicture { faces, cells, table: PatchTable::default(), turned: Vec::new() };
        picture.sample();
        picture.find_turned(refinement);
        picture
    }

    fn sample(&mut self) {
        let table = &mut self.table;
        for (number, (level, _, exact)) in self.faces.iter_mut().enumerate() {
            let n = (self.cells >> *level) as u32;
            let first = table.control.len() as u32;
            for (j, i) in (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))) {
                let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                let p = exact.at(u, v).p;
                table.control.push([p.x, p.y, 0.0, 0.0, number as f64, u, v, 1.0]);
            }
            for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
                let a = first + j * (n + 1) + i;
                // At level 1 nothing but the corners is evaluated.
                let mut ids = [a; 16];
                (ids[3], ids[12], ids[15]) = (a + 1, a + n + 1, a + n + 2);
                table.indices.extend(ids);
            }
        }
        let count = (table.indices.len() / 16) as u32;
        table.ranges.push(DrawRange { kind: Kind::Bicubic, part: None, level: 0, first: 0, count });
    }

    fn find_turned(&mut self, refinement: &Refinement) {
        let zero = &refinement.levels[0];
        let orientations = orientations(zero);
        let mut first = 0;
        for (level, f, _) in &self.faces {
            let n = (self.cells >> *level) as usize;
            let name = refinement.levels[*level as usize].face[*f as usize];
            let orientation = orientations[base_of_name(zero, *level, name) as usize];
            let at = |i: usize, j: usize| {
                let p = &self.table.control[first + j * (n + 1) + i];
                DVec2::new(p[0], p[1])
            };
            for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
                let cell = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                let turns = |k: usize| {
                    let [a, b, c] = [0, 1, 3].map(|s| cell[(k + s) % 4]);
                    orientation * (b - a).perp_dot(c - a) < 0.0
                };
                if (0..4).any(turns) {
                    self.turned.push(cell);
                }
            }
            first += (n + 1) * (n + 1);
        }
    }

    /// Visits short segments of the limit's silhouettes and sharp edges. `refinement` is the one of [`LimitPicture::new`].
    pub fn edges(&mut self, refinement: &Refinement, mut visit: impl FnMut(DVec2, DVec2)) {
        for (l, f, exact) in &mut self.faces {
            let level = &refinement.levels[*l as usize];
            let n = (self.cells >> *l).max(4);
            for i in (0..4).filter(|i| level.colour_border(level.first(*f) + i)) {
                let mut at = |k: u64| {
                    let t = k as f64 / n as f64;
                    let [u, v] = match i {
                        0 => [t, 0.0],
                        1 => [1.0, t],
                        2 => [1.0 - t, 1.0],
                        _ => [0.0, 1.0 - t],
                    };
                    exact.at(u, v).p
                };
                let mut from = at(0);
                for k in 1..=n {
                    let to = at(k);
                    visit(from, to);
                    from = to;
                }
            }
        }
    }

    /// The limit at a model position, from the four channels that a picture of [`LimitPicture::table`] has there; `None`
    /// on background.
    pub fn at(&mut self, channels: [f32; 4], position: [f64; 2]) -> Option<LimitPoint> {
        if channels[3] == 0.0 {
            return None;
        }
        let number = (channels[0].round() as usize).min(self.faces.len() - 1);
        let (level, face, exact) = &mut self.faces[number];
        let [u, v] = [f64::from(channels[1]), f64::from(channels[2])].map(|t| t.clamp(0.0, 1.0));
        let cell = 1.0 / (self.cells >> *level) as f64;
        // One-sided differences, inwards, a small part of a cell.
        let step = 1e-3 * cell;
        let (du, dv) = (if u < 0.5 { step } else { -step }, if v < 0.5 { step } else { -step });
        let (here, along_u, along_v) = (exact.at(u, v), exact.at(u + du, v), exact.at(u, v + dv));
        let (su, sv) = ((along_u - here) * (1.0 / du), (along_v - here) * (1.0 / dv));
        let missing = DVec2::from(position) - here.p;
        let determinant = su.p.perp_dot(sv.p);
        let (mut a, mut b) = (missing.perp_dot(sv.p) / determinant, su.p.perp_dot(missing) / determinant);
        // Where the derivatives fail (a fold, an extraordinary vertex) the point stays in its cell.
        if !(a.abs() <= cell && b.abs() <= cell) {
            (a, b) = (0.0, 0.0);
        }
        let colour = here.c + su.c * a + sv.c * b;
        Some(LimitPoint { level: *level, face: *face, uv: [u + a, v + b].map(|t| t.clamp(0.0, 1.0)), colour })
    }
}

/// A copy of a table with every alpha 1: colours are then measured as they are, not through their own transparency.
pub fn opaque(table: &PatchTable) -> PatchTable {
    let solid = |c: &ControlPoint| [c[0], c[1], c[2], c[3], c[4], c[5], c[6], 1.0];
    PatchTable { control: table.control.iter().map(solid).collect(), ..table.clone() }
}
