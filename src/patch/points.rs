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

mod makers;

use super::pool::{Lent, Maker, Pool};
use super::ControlPoint;
use crate::mesh::NONE;
use crate::refine::Rules;
use crate::scene::CornerRule;
use crate::subdiv::fan::{colour_fan, position_fan, Fan, Linear};
use crate::subdiv::level::{vertex_bits, Level, Value, CUT};
use crate::subdiv::limit;
use glam::{DVec2, DVec4};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use vertex_bits::{BOUNDARY, DART, EXTRAORDINARY, SECTORS};

/// What draws irregular faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Irregular {
    /// Gregory patches LSNC09 ("ACC2").
    #[default]
    Gregory,
    /// Bicubics LS08 ("ACC1"), for comparison: smooth inside, only continuous along edges at extraordinary vertices.
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

/// Which control points of one level are there, by number. Runs of faces write here at the same time, each what it makes.
pub struct Account<'a> {
    pub(super) level: &'a Level,
    /// Fates of the level's faces.
    pub(super) fates: &'a [u8],
    pub(super) style: Style,
    /// Corner point of each tint.
    corner: Vec<AtomicU32>,
    /// A control point that has each vertex's limit position.
    place: Vec<AtomicU32>,
    /// The inner points of each half-edge's edge, as its own face has them, see [`pair`].
    edge: Vec<AtomicU32>,
}

/// Control points of one level as a run of faces makes them.
pub struct Points<'a> {
    pub(super) account: &'a Account<'a>,
    level: &'a Level,
    style: Style,
    own: Own,
    /// Corners of earlier runs: tint and lent number.
    lent: HashMap<u32, u32>,
    positions: Fan<DVec2>,
    colours: Fan<DVec4>,
    /// Vertex and tint that the fans were last gathered for.
    fan_vertex: u32,
    fan_tint: u32,
}

/// What belongs to a run of faces. Numbers of other runs' points may or may not be in the account yet, so nobody looks at
/// them before all are done.
#[derive(Clone, Debug)]
pub(super) struct Own {
    /// Half-edges of its faces; later ones up to `beyond` are those of other runs.
    pub half_edges: Range<u32>,
    pub beyond: u32,
    /// Points that were there before any run began have lower numbers than these.
    pub before: u32,
    /// Points of its own.
    pub points: Range<u32>,
}

/// Of a corner that is not there yet, but was counted.
const COUNTED: u32 = NONE - 1;

/// Says of an edge that its two points, which follow each other, run against its half-edge.
const REVERSED: u32 = 1 << 31;

/// Near and far point of an edge: the near one's index, less [`REVERSED`].
#[inline]
pub(super) fn pair(edge: u32) -> [u32; 2] {
    let near = edge & !REVERSED;
    [near, if edge & REVERSED == 0 { near + 1 } else { near - 1 }]
}

/// Control point from its channels.
#[inline]
pub(super) fn control(v: Value) -> ControlPoint {
    [v.p.x, v.p.y, 0.0, 0.0, v.c.x, v.c.y, v.c.z, v.c.w]
}

/// Position of a control point.
pub(super) fn position_of(c: &ControlPoint) -> DVec2 {
    DVec2::new(c[0], c[1])
}

/// Colour of a control point.
pub(super) fn colour_of(c: &ControlPoint) -> DVec4 {
    DVec4::new(c[4], c[5], c[6], c[7])
}

/// Slots of corner i, of the near and far point of edge i and of inner point i, in the order of [`super`].
pub(super) const CORNER: [usize; 4] = [0, 3, 15, 12];
pub(super) const NEAR: [usize; 4] = [1, 7, 14, 8];
pub(super) const FAR: [usize; 4] = [2, 11, 13, 4];
pub(super) const INNER: [usize; 4] = [5, 6, 10, 9];

/// `(16 v + 4 spokes + corners) / 36`: the limit at a vertex of valence 4, from the sums of its neighbours along edges
/// and across faces.
#[inline]
fn regular_vertex(v: Value, spokes: Value, corners: Value) -> Value {
    (v * 16.0 + spokes * 4.0 + corners) * (1.0 / 36.0)
}

/// `(8 v + 4 w + 2 (a + b) + (c + d)) / 18`: B-spline to Bezier next to `v` on the edge to `w`; `a`, `b` are
/// `v`'s neighbours on both sides, `c`, `d` those of `w`.
fn regular_edge<V: Linear>(v: V, w: V, beside_v: V, beside_w: V) -> V {
    (v * 8.0 + w * 4.0 + beside_v * 2.0 + beside_w) * (1.0 / 18.0)
}

/// The same with the weights of LS08 for valence n, the mean of the two inner points beside the edge.
fn weighted_edge<V: Linear>(n: f64, v: V, w: V, beside_v: V, beside_w: V) -> V {
    (v * (2.0 * n) + w * 4.0 + beside_v * 2.0 + beside_w) * (1.0 / (2.0 * n + 10.0))
}

/// Two thirds along the way from `w` to `v`: the inner point of a cubic boundary curve.
fn border_edge<V: Linear>(v: V, w: V) -> V {
    (v * 2.0 + w) * (1.0 / 3.0)
}

impl<'a> Points<'a> {
    /// Everything on the account is final, and so is what is made.
    pub fn new(account: &'a Account<'a>) -> Self {
        Points::of_run(account, Own { half_edges: 0..NONE, beyond: NONE, before: COUNTED, points: 0..0 })
    }

    pub(super) fn of_run(account: &'a Account<'a>, own: Own) -> Self {
        Points {
            account,
            level: account.level,
            style: account.style,
            own,
            lent: HashMap::new(),
            positions: Fan::default(),
            colours: Fan::default(),
            fan_vertex: NONE,
            fan_tint: NONE,
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
    pub fn corner(&mut self, h: u32, pool: &mut impl Pool) -> u32 {
        let made = self.corner_of(self.level.tint[h as usize]);
        if made != NONE {
            return made;
        }
        let lends = self.is_of_earlier(h);
        if lends {
            if let Some(&lent) = self.lent.get(&self.level.tint[h as usize]) {
                return lent;
            }
        }
        let known = self.place_of(self.level.origin[h as usize]);
        let known = (known != NONE).then(|| position_of(pool.at(known)));
        let point = self.corner_value(h, known);
        self.add_corner(h, point, lends, pool)
    }

    /// The new corner at the origin of `h`, which is lent if an earlier run makes it.
    #[inline(always)]
    fn add_corner(&mut self, h: u32, point: ControlPoint, lends: bool, pool: &mut impl Pool) -> u32 {
        if lends {
            let tint = self.level.tint[h as usize];
            let index = pool.lend(&[point], Lent(Maker::Corner(tint)));
            self.lent.insert(tint, index);
            return index;
        }
        let index = pool.push(point);
        self.account.note_corner(h, index);
        index
    }

    /// The corner itself; `known` is its place if another colour of it is there already.
    pub(super) fn corner_value(&mut self, h: u32, known: Option<DVec2>) -> ControlPoint {
        let bits = self.bits(h);
        let mut value = if bits == 0 {
            self.regular_corner(h)
        } else if bits == BOUNDARY {
            self.regular_boundary(h)
        } else {
            self.colour_fan(h);
            let c = limit::limit(&self.colours, self.style.corners);
            if known.is_some() {
                Value { p: DVec2::ZERO, c }
            } else {
                self.position_fan(h);
                Value { p: limit::limit(&self.positions, self.style.corners), c }
            }
        };
        if let Some(p) = known {
            value.p = p;
        }
        control(value)
    }

    /// Limit at an inner vertex of valence 4 among quads. Opposite neighbours are added first, so that the sum does
    /// not depend on which of the spokes `h` is.
    fn regular_corner(&self, h: u32) -> Value {
        let level = self.level;
        let (before, after) = (level.twin[h as usize], level.twin[level.prev(h) as usize]);
        let opposite = level.twin[level.prev(after) as usize];
        let across = |g: u32| level.at(level.next(level.next(g)));
        let spokes =
            (level.at(level.next(h)) + level.at(level.prev(after))) + (level.at(level.prev(h)) + across(before));
        let corners = (across(h) + across(opposite)) + (across(after) + level.at(level.prev(before)));
        regular_vertex(level.at(h), spokes, corners)
    }

    /// Limit at a boundary vertex of two faces without sharp edges: `(a + 4 v + b) / 6`.
    fn regular_boundary(&self, h: u32) -> Value {
        let level = self.level;
        let (first, last) = match level.spoke_before(h) {
            None => (h, level.spoke_after(h).unwrap_or(h)),
            Some(before) => (before, h),
        };
        (level.at(level.next(first)) + level.at(level.prev(last))) * (1.0 / 6.0) + level.at(h) * (4.0 / 6.0)
    }

    /// All control points of a plain face ([`Account::is_plain`]), in the order of [`super`], corner A at its first half-edge.
    // Inlined anywhere else, its closures become calls.
    #[inline(never)]
    pub fn plain_face<P: Pool>(&mut self, f: u32, pool: &mut P) -> [u32; 16] {
        // Above level 0 all faces are quads, four half-edges each, and stepping through a face is bit arithmetic.
        if self.level.level == 0 {
            self.plain_face_by(f, pool, |level, h| level.next(h), |level, h| level.prev(h))
        } else {
            self.plain_face_by(f, pool, |_, h| (h & !3) | ((h + 1) & 3), |_, h| (h & !3) | ((h + 3) & 3))
        }
    }

    #[inline(always)]
    fn plain_face_by<P: Pool>(
        &mut self,
        f: u32,
        pool: &mut P,
        next: impl Fn(&Level, u32) -> u32,
        prev: impl Fn(&Level, u32) -> u32,
    ) -> [u32; 16] {
        const BEFORE: [usize; 4] = [3, 0, 1, 2];
        let level = self.level;
        let opposite = |h: u32| next(level, next(level, h));
        let prev = |h: u32| prev(level, h);
        let first = level.first(f);
        let of_face =
            |array: &[u32]| -> [u32; 4] { array[first as usize..first as usize + 4].try_into().expect("four corners") };
        let (origin, twin) = (of_face(&level.origin), of_face(&level.twin));
        // A vertex without colour sectors has the tint of its own number.
        let at = |i: usize| level.value[origin[i] as usize];
        let q = [at(0), at(1), at(2), at(3)];
        // At most four inner points, four edges and four corners: one look at the capacity instead of ten.
        pool.reserve(16);

        let mid = [q[0] + q[2], q[1] + q[3]];
        let inner = |i: usize| control((q[i] * 4.0 + mid[(i + 1) & 1] * 2.0 + q[(i + 2) & 3]) * (1.0 / 9.0));
        let mut ids = [0; 16];
        for i in 0..4 {
            ids[INNER[i]] = pool.push(inner(i));
        }

        for i in 0..4 {
            let h = first + i as u32;
            let t = twin[i];
            let (v, ahead, across, behind) = (q[i], q[(i + 1) & 3], q[(i + 2) & 3], q[BEFORE[i]]);
            let mut edge = self.account.edge[h as usize].load(Relaxed);
            if edge == NONE {
                let points = if t < CUT {
                    let beside = behind + level.at(opposite(t));
                    let beside_far = across + level.at(prev(t));
                    [regular_edge(v, ahead, beside, beside_far), regular_edge(ahead, v, beside_far, beside)]
                } else {
                    [border_edge(v, ahead), border_edge(ahead, v)]
                };
                let points = points.map(control);
                if P::SHARED && t < self.own.half_edges.start && self.account.draws(level.face_of(t)) {
                    edge = pool.lend(&points, Lent(Maker::Edge(t)));
                } else {
                    edge = pool.push(points[0]);
                    pool.push(points[1]);
                    if t < CUT {
                        if P::SHARED {
                            self.set_edge(t, (edge + 1) | REVERSED);
                        } else {
                            self.account.edge[t as usize].store((edge + 1) | REVERSED, Relaxed);
                        }
                    }
                }
                self.account.edge[h as usize].store(edge, Relaxed);
            }
            // What a single run finds is final.
            let known = |points: &Self, number: &AtomicU32| {
                let number = number.load(Relaxed);
                if P::SHARED {
                    points.known(number)
                } else {
                    number
                }
            };
            let mut corner = known(self, &self.account.corner[origin[i] as usize]);
            if corner == NONE {
                let after = twin[BEFORE[i]];
                if level.bits[origin[i] as usize] != 0 || known(self, &self.account.place[origin[i] as usize]) != NONE {
                    corner = self.corner(h, pool);
                } else {
                    let last = level.twin[prev(after) as usize];
                    let lends =
                        P::SHARED && t.min(after).min(last) < self.own.half_edges.start && self.is_of_earlier(h);
                    let known = if lends { self.lent.get(&origin[i]).copied() } else { None };
                    corner = known.unwrap_or_else(|| {
                        let spokes = (ahead + level.at(prev(after))) + (behind + level.at(opposite(t)));
                        let corners =
                            (across + level.at(opposite(last))) + (level.at(opposite(after)) + level.at(prev(t)));
                        self.add_corner(h, control(regular_vertex(v, spokes, corners)), lends, pool)
                    });
                }
            }
            ids[CORNER[i]] = corner;
            [ids[NEAR[i]], ids[FAR[i]]] = pair(edge);
        }
        ids
    }

    fn position_fan(&mut self, h: u32) {
        let v = self.level.origin[h as usize];
        if self.fan_vertex != v {
            position_fan(self.level, h, &mut self.positions);
            self.fan_vertex = v;
        }
    }

    fn colour_fan(&mut self, h: u32) {
        let tint = self.level.tint[h as usize];
        if self.fan_tint != tint {
            colour_fan(self.level, h, &mut self.colours);
            self.fan_tint = tint;
            if self.style.rules == Rules::Authors {
                // Their tool takes the smooth limit at darts.
                self.colours.dart = None;
            }
        }
    }

    /// The two inner points of the edge of `h`: near its origin, near its target, in the colours of its face.
    pub fn edge(&mut self, h: u32, pool: &mut impl Pool) -> [u32; 2] {
        let made = self.edge_of(h);
        if made != NONE {
            return pair(made);
        }
        // Along a border the face across may have made the edge already, in other colours: the place is the same.
        let known = self.level.across(h).map(|t| self.edge_of(t)).filter(|&e| e != NONE).map(pair);
        let known = known.map(|[near, far]| [far, near].map(|i| position_of(pool.at(i))));
        let points = self.edge_values(h, known);
        if let Some(maker) = self.edge_maker(h) {
            let first = pool.lend(&points, Lent(Maker::Edge(maker)));
            self.set_edge(h, first);
            return [first, first + 1];
        }
        let first = pool.push(points[0]);
        pool.push(points[1]);
        self.set_edge(h, first);
        if !self.level.colour_border(h) {
            self.set_edge(self.level.twin[h as usize], (first + 1) | REVERSED);
        }
        [first, first + 1]
    }

    /// The points themselves; `known` are their places if the face across has made them.
    pub(super) fn edge_values(&mut self, h: u32, known: Option<[DVec2; 2]>) -> [ControlPoint; 2] {
        let level = self.level;
        let next = level.next(h);
        let twin = level.across(h);
        let (v, w) = (level.at(h), level.at(next));
        // Neighbours of both ends, summed over both sides of the edge.
        let beside = twin.map(|t| {
            let at_v = level.at(level.prev(h)) + level.at(level.next(level.next(t)));
            [at_v, level.at(level.next(next)) + level.at(level.prev(t))]
        });
        let ends = |beside: [Value; 2]| {
            let [at_v, at_w] = beside;
            [
                End { half_edge: h, v, w, beside: at_v, beside_far: at_w },
                End { half_edge: next, v: w, w: v, beside: at_w, beside_far: at_v },
            ]
        };
        let points = match beside.map(ends) {
            // Everything regular: positions and colours by one rule.
            Some(ends) if (self.bits(h) | self.bits(next)) & !BOUNDARY == 0 => ends.map(|e| e.regular()),
            Some(ends) => {
                let border = level.colour_border(h);
                let mut points = ends.map(|e| Value {
                    p: if known.is_some() { DVec2::ZERO } else { self.edge_position(&e, h) },
                    c: if border { border_edge(e.v.c, e.w.c) } else { self.edge_colour(&e, h) },
                });
                if let Some(known) = known {
                    [points[0].p, points[1].p] = known;
                }
                points
            }
            None => [(h, v, w), (next, w, v)].map(|(end, v, w)| {
                let mut point = border_edge(v, w);
                // The exact boundary is a cubic whatever the valence; the authors' tool bends it with the fan's tangent.
                if self.bits(end) & EXTRAORDINARY != 0 && self.style.rules == Rules::Authors {
                    self.position_fan(end);
                    let j = spoke_index(level, &self.positions, h, end);
                    point.p = limit::authors_edge_point(&self.positions, j, self.style.corners);
                }
                point
            }),
        };
        points.map(control)
    }

    fn fan_edge<V: Linear>(&self, fan: &Fan<V>, j: usize) -> V {
        match self.style.rules {
            Rules::Gradtess => limit::edge_point(fan, j, self.style.corners),
            Rules::Authors => limit::authors_edge_point(fan, j, self.style.corners),
        }
    }

    /// Position of the point next to one end of an inner edge.
    fn edge_position(&mut self, e: &End, h: u32) -> DVec2 {
        if self.bits(e.half_edge) & EXTRAORDINARY == 0 {
            return regular_edge(e.v.p, e.w.p, e.beside.p, e.beside_far.p);
        }
        self.position_fan(e.half_edge);
        if self.style.irregular == Irregular::Bicubic {
            return weighted_edge(fan_valence(&self.positions), e.v.p, e.w.p, e.beside.p, e.beside_far.p);
        }
        let j = spoke_index(self.level, &self.positions, h, e.half_edge);
        self.fan_edge(&self.positions, j)
    }

    /// Colour of the point next to one end of an edge that is no border.
    fn edge_colour(&mut self, e: &End, h: u32) -> DVec4 {
        if !self.colour_is_extraordinary(e.half_edge) {
            return regular_edge(e.v.c, e.w.c, e.beside.c, e.beside_far.c);
        }
        self.colour_fan(e.half_edge);
        if self.style.irregular == Irregular::Bicubic {
            return weighted_edge(fan_valence(&self.colours), e.v.c, e.w.c, e.beside.c, e.beside_far.c);
        }
        let j = spoke_index(self.level, &self.colours, h, e.half_edge);
        self.fan_edge(&self.colours, j)
    }

    /// The inner point of the corner at the origin of `h` in a bicubic patch.
    pub fn inner(&mut self, h: u32) -> ControlPoint {
        let level = self.level;
        let n = level.next(h);
        let (c, d) = (level.next(n), level.prev(h));
        let at = |g: u32| level.position(g);
        let (mut np, mut nc) = (4.0, 4.0);
        if self.style.irregular == Irregular::Bicubic {
            if self.bits(h) & EXTRAORDINARY != 0 {
                self.position_fan(h);
                np = fan_valence(&self.positions);
            }
            if self.colour_is_extraordinary(h) {
                self.colour_fan(h);
                nc = fan_valence(&self.colours);
            }
        }
        let p = (at(h) * np + (at(n) + at(d)) * 2.0 + at(c)) * (1.0 / (np + 5.0));
        let colour = |g: u32| level.corner_colour(g);
        let q = (colour(h) * nc + (colour(n) + colour(d)) * 2.0 + colour(c)) * (1.0 / (nc + 5.0));
        control(Value { p, c: q })
    }

    /// Valence that Gregory points count with at the origin of `h`, for positions and for colours: edges inside,
    /// `2 k` for k faces on a border, 4 at a corner.
    pub fn gregory_valence(&mut self, h: u32) -> [f64; 2] {
        if self.bits(h) & !BOUNDARY == 0 {
            return [4.0; 2];
        }
        self.position_fan(h);
        self.colour_fan(h);
        [fan_valence(&self.positions), fan_valence(&self.colours)]
    }
}

/// One end of an inner edge, with what a regular edge point depends on.
#[derive(Clone, Copy)]
struct End {
    /// Half-edge of the face that leaves this end.
    half_edge: u32,
    /// Here, and at the far end.
    v: Value,
    w: Value,
    /// Neighbours of this end on both sides of the edge, summed; and of the far end.
    beside: Value,
    beside_far: Value,
}

impl End {
    fn regular(&self) -> Value {
        regular_edge(self.v, self.w, self.beside, self.beside_far)
    }
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
