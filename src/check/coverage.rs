//! What rasterising triangles shows at a pixel, and what it may show.
//!
//! A device moves corners before it rasterises: single precision rounds their places in the picture, fixed point snaps
//! them to 1/256 of a pixel. So it may show something else than these triangles at a pixel, but not just anything. Let no
//! corner move farther than the margin. Take the triangles within the margin of the pixel's middle that hang together by
//! edges within the margin. If every such edge has its two triangles (no border of the surface is near), the number of
//! fronts minus that of backs over the middle cannot change, however the corners move: where it is not zero, the middle
//! stays covered. Where it is zero, a contour is near, and nothing, or both a front and a back may be there. Of what may
//! be there, any may be seen that is not behind all of a part that stays, depths being moved with the corners.

use super::sheet::Sheet;
use crate::camera::Camera;
use crate::mesh::NONE;
use glam::{DMat4, DVec2, DVec3, DVec4};
use std::collections::HashMap;

/// What a pixel sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// Background.
    Nothing,
    /// A side whose triangles are counter-clockwise.
    Front,
    /// The other side.
    Back,
}

/// A part of a fixed-point pixel that corners are snapped to.
const SNAP: f64 = 1.0 / 256.0;
/// Half a unit in the last place of single precision.
const ULP: f64 = 1.0 / (1u64 << 24) as f64;
/// Roundings on the way from control points to a corner's place in the model, and from there to clip space.
const ROUNDINGS: [f64; 2] = [16.0, 8.0];

/// A triangle in the picture, or what the near plane leaves of it.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// x, y in pixels (y down), depth 0 to 1. Of a triangle, the fourth is the first.
    corners: [DVec3; 4],
    /// The sheet's edge that each side lies on; `[v, v]`: none.
    edges: [[u32; 2]; 4],
}

/// A side that the near plane made.
const CUT: [u32; 2] = [NONE, NONE - 1];

impl Piece {
    /// Twice the area vector; z is positive seen from the back, y being down.
    fn area(&self) -> DVec3 {
        let [a, b, c, d] = self.corners;
        (c - a).cross(d - b)
    }

    fn bounds(&self) -> [DVec3; 2] {
        let [a, b, c, d] = self.corners;
        [a.min(b).min(c.min(d)), a.max(b).max(c.max(d))]
    }

    fn sides(&self) -> impl Iterator<Item = (DVec2, DVec2, [u32; 2])> + '_ {
        (0..4).map(|i| (self.corners[i].truncate(), self.corners[(i + 1) % 4].truncate(), self.edges[i]))
    }

    fn covers(&self, at: DVec2) -> bool {
        let sign = self.area().z;
        sign != 0.0 && self.sides().all(|(p, q, _)| (q - p).perp_dot(at - p) * sign >= 0.0)
    }

    fn depth(&self, at: DVec2) -> f64 {
        let n = self.area();
        let middle = self.corners.iter().sum::<DVec3>() * 0.25;
        middle.z - (n.truncate() / n.z).dot(at - middle.truncate())
    }

    fn side(&self) -> Seen {
        if self.area().z < 0.0 {
            Seen::Front
        } else {
            Seen::Back
        }
    }

    /// Whether moving corners by `margin` may turn it over.
    fn may_turn(&self, margin: f64) -> bool {
        // Of corners that move by m, twice the area changes by m times the way around and a little of second order.
        let around: f64 = self.sides().map(|(p, q, _)| p.distance(q)).sum();
        self.area().z.abs() <= margin * (around + 4.0 * margin)
    }

    /// Least and greatest depth at points of it within `margin` of `at`; `error` is that of a corner's depth.
    fn depths(&self, at: DVec2, margin: f64, error: f64, size: f64) -> [f64; 2] {
        let [low, high] = self.bounds().map(|c| c.z);
        let n = self.area();
        let slope = (n.x.abs() + n.y.abs()) / n.z.abs();
        if !slope.is_finite() {
            return [low - error, high + error];
        }
        let (here, reach) = (self.depth(at), slope * margin);
        // The device's plane through depths starts at a corner of the picture.
        let error = error + 4.0 * ULP * slope * size;
        [(here - reach).clamp(low, high) - error, (here + reach).clamp(low, high) + error]
    }
}

/// Distance of a point from a line segment.
fn distance(at: DVec2, p: DVec2, q: DVec2) -> f64 {
    let along = q - p;
    let t = ((at - p).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    at.distance(p + along * t)
}

/// A sheet as a camera sees it.
pub struct Coverage {
    pieces: Vec<Piece>,
    /// Pixels across and down.
    pub size: u32,
    /// How far a device may move corners, pixels.
    pub margin: f64,
    /// How far it may move depths.
    depth_error: f64,
}

impl Coverage {
    /// In a square picture of `size`; `bounds` as the device's depths were made of.
    pub fn new(sheet: &Sheet, camera: &Camera, bounds: [DVec3; 2], size: u32) -> Coverage {
        let centre = (bounds[0] + bounds[1]) * 0.5;
        let clip = camera.matrix(1.0, bounds) * DMat4::from_translation(centre);
        let local: Vec<DVec3> = sheet.positions.iter().map(|&p| p - centre).collect();
        let radius = local.iter().fold(0.0f64, |r, p| r.max(p.abs().max_element()));
        let at: Vec<DVec4> = local.iter().map(|p| clip * p.extend(1.0)).collect();
        let pixels = 0.5 * f64::from(size);
        let mut seen = Coverage { pieces: Vec::new(), size, margin: 0.0, depth_error: 0.0 };
        // Rounding of a row of the product, from the position's rounding and its own.
        let row = |i: usize, p: DVec3| {
            let m = clip.row(i).abs();
            ULP * (ROUNDINGS[0] * radius * m.truncate().element_sum() + ROUNDINGS[1] * m.dot(p.abs().extend(1.0)))
        };
        let place = |c: DVec4| {
            let p = c.truncate() / c.w;
            DVec3::new(pixels * (p.x + 1.0), pixels * (p.y + 1.0), p.z)
        };
        let mut used = vec![false; at.len()];
        for t in &sheet.triangles {
            let Some(piece) = clipped(*t, t.map(|i| at[i as usize]), place) else { continue };
            let [low, high] = piece.bounds();
            let far = f64::from(size) + 1.0;
            if low.x < far && low.y < far && high.x > -1.0 && high.y > -1.0 {
                seen.pieces.push(piece);
                t.iter().for_each(|&i| used[i as usize] = true);
            }
        }
        for i in (0..at.len()).filter(|&i| used[i] && at[i].z >= 0.0) {
            // Of a triangle that reaches beyond the picture, what is within matters.
            let ([x, y, w], p) = ([at[i].x, at[i].y, at[i].w], local[i]);
            let [x, y] = [x, y].map(|x| (x / w).abs().min(1.0));
            let error = row(3, p);
            let moved = (row(0, p) + x * error).max(row(1, p) + y * error) / w;
            seen.margin = seen.margin.max(pixels * moved);
            seen.depth_error = seen.depth_error.max((row(2, p) + at[i].z / w * error) / w);
        }
        // Both coordinates, and those of the picture are rounded too.
        seen.margin = 2f64.sqrt() * (seen.margin + SNAP + 4.0 * ULP * f64::from(size));
        seen.depth_error += 4.0 * ULP;
        seen
    }

    /// What each pixel shows, row by row.
    pub fn picture(&self) -> Vec<Seen> {
        let n = self.size as usize;
        let mut picture = vec![Seen::Nothing; n * n];
        let mut nearest = vec![f64::INFINITY; n * n];
        for piece in &self.pieces {
            // Pixels whose middles are within.
            let [low, high] = piece.bounds().map(|c| c - 0.5);
            let range = |low: f64, high: f64| (low.ceil().max(0.0) as usize)..((high.floor() + 1.0) as usize).min(n);
            let columns = range(low.x, high.x);
            for y in range(low.y, high.y) {
                for x in columns.clone() {
                    let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                    let i = y * n + x;
                    if piece.covers(at) && piece.depth(at) < nearest[i] {
                        nearest[i] = piece.depth(at);
                        picture[i] = piece.side();
                    }
                }
            }
        }
        picture
    }

    /// Whether a device that moves corners by the margin may show `what` at `pixel`.
    pub fn may_show(&self, [x, y]: [u32; 2], what: Seen) -> bool {
        let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let is_near = |p: DVec2, q: DVec2| distance(at, p, q) <= self.margin;
        let beside = |p: &Piece| {
            let [low, high] = p.bounds().map(|c| c.truncate());
            low.cmpgt(at + self.margin).any() || high.cmplt(at - self.margin).any()
        };
        let touches = |p: &Piece| !beside(p) && (p.covers(at) || p.sides().any(|(p, q, _)| is_near(p, q)));
        let near: Vec<&Piece> = self.pieces.iter().filter(|p| touches(p)).collect();
        // Which pieces each near edge has, and how often it runs up rather than down.
        let mut edges: HashMap<[u32; 2], (Vec<usize>, i32)> = HashMap::new();
        for (i, piece) in near.iter().enumerate() {
            for (p, q, [a, b]) in piece.sides().filter(|&(.., [a, b])| a != b) {
                if is_near(p, q) {
                    let edge = edges.entry([a.min(b), a.max(b)]).or_default();
                    edge.0.push(i);
                    edge.1 += if a < b { 1 } else { -1 };
                }
            }
        }
        let mut part: Vec<usize> = (0..near.len()).collect();
        for (pieces, _) in edges.values() {
            for &i in pieces {
                let (from, to) = (part[i], part[pieces[0]]);
                part.iter_mut().filter(|p| **p == from).for_each(|p| *p = to);
            }
        }
        let mut degree = vec![0; near.len()];
        for (i, piece) in near.iter().enumerate().filter(|(_, p)| p.covers(at)) {
            degree[part[i]] += if piece.side() == Seen::Front { 1 } else { -1 };
        }
        for (pieces, _) in edges.values().filter(|e| e.1 != 0) {
            degree[part[pieces[0]]] = 0;
        }
        // The farthest that each part which stays may be; what is behind the nearest of these is hidden.
        let depths = |p: &Piece| p.depths(at, self.margin, self.depth_error, f64::from(self.size));
        let mut farthest = vec![f64::NEG_INFINITY; near.len()];
        for (i, piece) in near.iter().enumerate() {
            farthest[part[i]] = farthest[part[i]].max(depths(piece)[1]);
        }
        let stays = (0..near.len()).filter(|&p| degree[p] != 0).map(|p| farthest[p]);
        let hidden = stays.fold(f64::INFINITY, f64::min);
        match what {
            Seen::Nothing => hidden == f64::INFINITY,
            side => near.iter().any(|p| (p.side() == side || p.may_turn(self.margin)) && depths(p)[0] <= hidden),
        }
    }
}

/// A triangle in the picture; `None` if it is before the near plane.
fn clipped(t: [u32; 3], at: [DVec4; 3], place: impl Fn(DVec4) -> DVec3) -> Option<Piece> {
    // Depth in front of the plane: z is 0 on it.
    if at.iter().all(|c| c.z >= 0.0 && c.w > 0.0) {
        let [a, b, c] = at.map(place);
        let edges = [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]], [t[0], t[0]]];
        return Some(Piece { corners: [a, b, c, a], edges });
    }
    let mut corners = Vec::new();
    for i in 0..3 {
        let (p, q, edge) = (at[i], at[(i + 1) % 3], [t[i], t[(i + 1) % 3]]);
        let cut = || p + (q - p) * (p.z / (p.z - q.z));
        if p.z >= 0.0 {
            corners.push((p, edge));
            if q.z < 0.0 {
                corners.push((cut(), CUT));
            }
        } else if q.z >= 0.0 {
            corners.push((cut(), edge));
        }
    }
    let &(first, _) = corners.first()?;
    corners.resize(4, (first, [0, 0]));
    Some(Piece { corners: std::array::from_fn(|i| place(corners[i].0)), edges: std::array::from_fn(|i| corners[i].1) })
}
