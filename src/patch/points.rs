//! Control points of one level: corners and edge points, made once and shared by index.
//!
//! A corner of the surface is one control point whatever the levels of the faces that meet there: it is made by
//! the coarsest face drawn and handed down. An edge's two inner points are shared by the two faces of a level,
//! and lent to a coarser transition face across it. So neighbours hold the very same numbers along their common
//! edge, and the seam is watertight without any care in the shaders but a symmetric evaluation.
//!
//! Regular geometry and colours are exact: bicubic B-splines in Bezier form, with boundaries (and sharp
//! edges, for colour) as their cubic boundary curves. In Bezier form no phantom points are needed: the inner
//! point depends on the face's own corners, an edge point on the two faces of the edge, a corner on its ring.

use super::ControlPoint;
use crate::mesh::NONE;
use crate::refine::Rules;
use crate::scene::CornerRule;
use crate::subdiv::fan::{colour_fan, position_fan, Fan, Linear};
use crate::subdiv::level::{vertex_bits, Level, CUT};
use crate::subdiv::limit;
use glam::{DVec2, DVec4};
use vertex_bits::{BOUNDARY, DART, EXTRAORDINARY, SECTORS};

/// What draws irregular faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Irregular {
    /// Gregory patches [LSNC09] ("ACC2").
    #[default]
    Gregory,
    /// Bicubics [LS08] ("ACC1"), for comparison: smooth inside, only continuous along edges at extraordinary vertices.
    Bicubic,
}

/// How control points are made.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// Corner rule of the scene.
    pub corners: CornerRule,
    /// Rule set; [`Rules::Authors`] also takes over their treatment of darts and extraordinary boundary vertices.
    pub rules: Rules,
    /// What draws irregular faces.
    pub irregular: Irregular,
}

/// Control points of one level, as far as they have been asked for.
pub struct Points<'a> {
    level: &'a Level,
    style: Style,
    /// Corner point of each tint.
    corner: Vec<u32>,
    /// A control point that has each vertex's limit position.
    place: Vec<u32>,
    /// Points near the origin and near the target of each half-edge, as its own face has them.
    edge: Vec<[u32; 2]>,
    positions: Fan<DVec2>,
    colours: Fan<DVec4>,
}

/// Control point from its channels.
pub(super) fn control(p: DVec2, c: DVec4) -> ControlPoint {
    [p.x, p.y, 0.0, 0.0, c.x, c.y, c.z, c.w]
}

/// Position of a control point.
pub(super) fn position_of(c: &ControlPoint) -> DVec2 {
    DVec2::new(c[0], c[1])
}

/// Colour of a control point.
pub(super) fn colour_of(c: &ControlPoint) -> DVec4 {
    DVec4::new(c[4], c[5], c[6], c[7])
}

/// `(8 v + 4 w + 2 (a + b) + (c + d)) / 18`: B-spline to Bezier next to `v` on the edge to `w`; `a`, `b` are
/// `v`'s neighbours on both sides, `c`, `d` those of `w`.
fn regular_edge<V: Linear>(v: V, w: V, beside_v: V, beside_w: V) -> V {
    (v * 8.0 + w * 4.0 + beside_v * 2.0 + beside_w) * (1.0 / 18.0)
}

/// The same with the weights of [LS08] for valence n, the mean of the two inner points beside the edge.
fn weighted_edge<V: Linear>(n: f64, v: V, w: V, beside_v: V, beside_w: V) -> V {
    (v * (2.0 * n) + w * 4.0 + beside_v * 2.0 + beside_w) * (1.0 / (2.0 * n + 10.0))
}

/// Two thirds along the way from `w` to `v`: the inner point of a cubic boundary curve.
fn border_edge<V: Linear>(v: V, w: V) -> V {
    (v * 2.0 + w) * (1.0 / 3.0)
}

impl<'a> Points<'a> {
    /// Nothing made yet.
    pub fn new(level: &'a Level, style: Style) -> Self {
        Points {
            level,
            style,
            corner: vec![NONE; level.colour.len()],
            place: vec![NONE; level.position.len()],
            edge: vec![[NONE; 2]; level.half_edges()],
            positions: Fan::default(),
            colours: Fan::default(),
        }
    }

    /// Takes over the corners that coarser faces made.
    pub fn inherit(&mut self, coarse: &Points) {
        for h in 0..coarse.level.half_edges() {
            let child = coarse.level.child[h];
            if child >= CUT {
                continue;
            }
            let first = 4 * child as usize;
            let place = coarse.place[coarse.level.origin[h] as usize];
            if place != NONE {
                self.place[self.level.origin[first] as usize] = place;
            }
            let corner = coarse.corner[coarse.level.tint[h] as usize];
            if corner != NONE {
                self.corner[self.level.tint[first] as usize] = corner;
            }
        }
    }

    fn bits(&self, h: u32) -> u8 {
        self.level.bits[self.level.origin[h as usize] as usize]
    }

    /// Whether colours at the origin of `h` need the fan rules on spokes that are no border.
    fn colour_is_extraordinary(&self, h: u32) -> bool {
        let bits = self.bits(h);
        if bits & EXTRAORDINARY != 0 {
            return true;
        }
        if bits & DART != 0 {
            return self.style.rules == Rules::Gradtess;
        }
        bits & SECTORS != 0 && {
            let start = self.level.fan_start(h, |s| self.level.colour_border(s));
            let mut spoke = start;
            let mut faces = 1;
            while let Some(s) = self.level.spoke_after(spoke).filter(|&s| !self.level.colour_border(s)) {
                (spoke, faces) = (s, faces + 1);
            }
            faces > 2 || (faces == 1 && self.style.corners == CornerRule::Smooth)
        }
    }

    /// The corner of the surface at the origin of `h`, in the colour of the corner's sector.
    pub fn corner(&mut self, h: u32, control_points: &mut Vec<ControlPoint>) -> u32 {
        let level = self.level;
        let (v, tint) = (level.origin[h as usize] as usize, level.tint[h as usize] as usize);
        if self.corner[tint] != NONE {
            return self.corner[tint];
        }
        let known = self.place[v];
        let point = if level.bits[v] == 0 {
            // A regular inner vertex. Opposite spokes are added first, so that the sums do not depend on `h`.
            let mut p = [DVec2::ZERO; 8];
            let mut c = [DVec4::ZERO; 8];
            let mut spoke = h;
            for i in 0..4 {
                let a = level.next(spoke);
                let b = level.next(a);
                p[i] = level.position[level.origin[a as usize] as usize];
                c[i] = level.corner_colour(a);
                p[4 + i] = level.position[level.origin[b as usize] as usize];
                c[4 + i] = level.corner_colour(b);
                spoke = level.twin[level.prev(spoke) as usize];
            }
            let ring = |x: [DVec2; 8], v: DVec2| {
                (v * 16.0 + ((x[0] + x[2]) + (x[1] + x[3])) * 4.0 + ((x[4] + x[6]) + (x[5] + x[7]))) * (1.0 / 36.0)
            };
            let ring4 = |x: [DVec4; 8], v: DVec4| {
                (v * 16.0 + ((x[0] + x[2]) + (x[1] + x[3])) * 4.0 + ((x[4] + x[6]) + (x[5] + x[7]))) * (1.0 / 36.0)
            };
            control(ring(p, level.position[v]), ring4(c, level.corner_colour(h)))
        } else {
            colour_fan(level, h, &mut self.colours);
            let colour = limit::limit(&self.colours, self.style.corners);
            let position = if known != NONE {
                position_of(&control_points[known as usize])
            } else {
                position_fan(level, h, &mut self.positions);
                limit::limit(&self.positions, self.style.corners)
            };
            control(position, colour)
        };
        let index = control_points.len() as u32;
        control_points.push(point);
        self.corner[tint] = index;
        if known == NONE {
            self.place[v] = index;
        }
        index
    }

    /// The two inner points of the edge of `h`: near its origin, near its target, in the colours of its face.
    pub fn edge(&mut self, h: u32, control_points: &mut Vec<ControlPoint>) -> [u32; 2] {
        let level = self.level;
        if self.edge[h as usize][0] != NONE {
            return self.edge[h as usize];
        }
        let next = level.next(h);
        let twin = level.across(h);
        let (p, c) = match twin {
            // Everything regular: one gather serves positions and colours.
            Some(t) if (self.bits(h) | self.bits(next)) & !BOUNDARY == 0 => {
                let g = self.beside(h, t);
                (
                    [regular_edge(g.v.0, g.w.0, g.beside_v.0, g.beside_w.0), regular_edge(g.w.0, g.v.0, g.beside_w.0, g.beside_v.0)],
                    [regular_edge(g.v.1, g.w.1, g.beside_v.1, g.beside_w.1), regular_edge(g.w.1, g.v.1, g.beside_w.1, g.beside_v.1)],
                )
            }
            _ => (self.edge_positions(h, twin, control_points), self.edge_colours(h, twin)),
        };
        let first = control_points.len() as u32;
        control_points.push(control(p[0], c[0]));
        control_points.push(control(p[1], c[1]));
        self.edge[h as usize] = [first, first + 1];
        if let Some(t) = twin {
            if !level.colour_border(h) {
                self.edge[t as usize] = [first + 1, first];
            }
        }
        [first, first + 1]
    }

    /// The six values that a regular edge depends on.
    fn beside(&self, h: u32, t: u32) -> Beside {
        let level = self.level;
        let at = |g: u32| (level.position[level.origin[g as usize] as usize], level.corner_colour(g));
        let add = |a: (DVec2, DVec4), b: (DVec2, DVec4)| (a.0 + b.0, a.1 + b.1);
        let next = level.next(h);
        let beyond = level.next(level.next(t));
        Beside {
            v: at(h),
            w: at(next),
            beside_v: add(at(level.prev(h)), at(beyond)),
            beside_w: add(at(level.next(next)), at(level.prev(t))),
        }
    }

    fn edge_positions(&mut self, h: u32, twin: Option<u32>, control_points: &[ControlPoint]) -> [DVec2; 2] {
        if let Some(t) = twin {
            let [near, far] = self.edge[t as usize];
            if near != NONE {
                return [far, near].map(|i| position_of(&control_points[i as usize]));
            }
        }
        let level = self.level;
        [h, level.next(h)].map(|end| {
            let ends = |g: u32| level.position[level.origin[g as usize] as usize];
            let (v, w) = if end == h { (ends(h), ends(level.next(h))) } else { (ends(level.next(h)), ends(h)) };
            let extraordinary = self.bits(end) & EXTRAORDINARY != 0;
            // The exact boundary is a cubic whatever the valence; the authors' tool bends it with the fan's tangent.
            if twin.is_none() && (!extraordinary || self.style.rules == Rules::Gradtess) {
                return border_edge(v, w);
            }
            if let (false, Some(t)) = (extraordinary, twin) {
                let g = self.beside(h, t);
                return if end == h {
                    regular_edge(v, w, g.beside_v.0, g.beside_w.0)
                } else {
                    regular_edge(v, w, g.beside_w.0, g.beside_v.0)
                };
            }
            position_fan(level, end, &mut self.positions);
            let n = fan_valence(&self.positions);
            if let (Irregular::Bicubic, Some(t)) = (self.style.irregular, twin) {
                let g = self.beside(h, t);
                return if end == h {
                    weighted_edge(n, v, w, g.beside_v.0, g.beside_w.0)
                } else {
                    weighted_edge(n, v, w, g.beside_w.0, g.beside_v.0)
                };
            }
            let j = spoke_index(level, &self.positions, h, end);
            limit::edge_point(&self.positions, j, self.style.corners)
        })
    }

    fn edge_colours(&mut self, h: u32, twin: Option<u32>) -> [DVec4; 2] {
        let level = self.level;
        let next = level.next(h);
        let border = level.colour_border(h);
        [h, next].map(|end| {
            let (v, w) = if end == h { (h, next) } else { (next, h) };
            let (cv, cw) = (level.corner_colour(v), level.corner_colour(w));
            let t = match twin {
                Some(t) if !border => t,
                _ => return border_edge(cv, cw),
            };
            let g = self.beside(h, t);
            let (beside_v, beside_w) = if end == h { (g.beside_v.1, g.beside_w.1) } else { (g.beside_w.1, g.beside_v.1) };
            if !self.colour_is_extraordinary(end) {
                return regular_edge(cv, cw, beside_v, beside_w);
            }
            colour_fan(level, end, &mut self.colours);
            if self.style.irregular == Irregular::Bicubic {
                return weighted_edge(fan_valence(&self.colours), cv, cw, beside_v, beside_w);
            }
            let j = spoke_index(level, &self.colours, h, end);
            limit::edge_point(&self.colours, j, self.style.corners)
        })
    }

    /// The inner point of the corner at the origin of `h` in a bicubic patch.
    pub fn inner(&mut self, h: u32) -> ControlPoint {
        let level = self.level;
        let n = level.next(h);
        let (c, d) = (level.next(n), level.prev(h));
        let at = |g: u32| level.position[level.origin[g as usize] as usize];
        let (mut np, mut nc) = (4.0, 4.0);
        if self.style.irregular == Irregular::Bicubic {
            if self.bits(h) & EXTRAORDINARY != 0 {
                position_fan(level, h, &mut self.positions);
                np = fan_valence(&self.positions);
            }
            if self.colour_is_extraordinary(h) {
                colour_fan(level, h, &mut self.colours);
                nc = fan_valence(&self.colours);
            }
        }
        let p = (at(h) * np + (at(n) + at(d)) * 2.0 + at(c)) * (1.0 / (np + 5.0));
        let colour = |g: u32| level.corner_colour(g);
        let q = (colour(h) * nc + (colour(n) + colour(d)) * 2.0 + colour(c)) * (1.0 / (nc + 5.0));
        control(p, q)
    }

    /// How these points are made.
    pub fn style(&self) -> Style {
        self.style
    }

    /// The level these points belong to.
    pub fn level(&self) -> &'a Level {
        self.level
    }

    /// Valence that Gregory points count with at the origin of `h`, for positions and for colours: edges inside,
    /// `2 k` for k faces on a border, 4 at a corner.
    pub fn gregory_valence(&mut self, h: u32) -> [f64; 2] {
        if self.bits(h) & !BOUNDARY == 0 {
            return [4.0; 2];
        }
        position_fan(self.level, h, &mut self.positions);
        colour_fan(self.level, h, &mut self.colours);
        [fan_valence(&self.positions), fan_valence(&self.colours)]
    }
}

/// Values around an edge from `v` to `w`: position and colour each.
struct Beside {
    v: (DVec2, DVec4),
    w: (DVec2, DVec4),
    beside_v: (DVec2, DVec4),
    beside_w: (DVec2, DVec4),
}

/// n for a closed fan, 2 k for an open one of k faces, 4 for one face.
fn fan_valence<V: Linear>(fan: &Fan<V>) -> f64 {
    match (fan.closed, fan.faces()) {
        (true, n) => n as f64,
        (false, 1) => 4.0,
        (false, k) => 2.0 * k as f64,
    }
}

/// Spoke of the fan around the origin of `end` that the edge of `h` is; `end` is `h` or the half-edge after.
fn spoke_index<V: Linear>(level: &Level, fan: &Fan<V>, h: u32, end: u32) -> usize {
    if end == h {
        return fan.spoke_of(h);
    }
    // The edge arrives at its target as the spoke after `end`.
    let j = fan.spoke_of(end) + 1;
    if fan.closed {
        debug_assert_eq!(level.across(h).map(|t| level.origin[t as usize]), Some(level.origin[end as usize]));
        j % fan.faces()
    } else {
        j
    }
}
