//! Exact local refinement (BLHK18 section 4): an isoline of a patch becomes a curve, and nothing changes.

use super::hermite::{self, halves};
use super::mesh::{Corner, Curve, HalfEdge, Jet, Mesh, Patch, Point, Section, Side, NONE};
use super::FergusonError;
use glam::DVec2;

/// Parameters nearer than this to one that is there already are taken as that one.
pub const SAME: f64 = 1e-12;

/// Fractions of a patch nearer than this to its sides are refused.
pub const THINNEST: f64 = 1e-6;

/// The direction whose parameter a split fixes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// The new curve is u = constant.
    U,
    /// The new curve is v = constant.
    V,
}

impl Axis {
    /// The two sides that are cut, in order: the one that runs along the axis, the one that runs against it.
    pub(super) fn cut(self) -> [usize; 2] {
        match self {
            Axis::U => [0, 2],
            Axis::V => [1, 3],
        }
    }

    /// Corner pairs (first part, second part) of the cut sides: on the side that runs along the axis, then on the other.
    pub(super) fn pairs(self) -> [[usize; 2]; 2] {
        match self {
            Axis::U => [[0, 1], [3, 2]],
            Axis::V => [[1, 2], [0, 3]],
        }
    }

    /// Sides of the first and of the second part that the new curve becomes.
    pub(super) fn middle(self) -> [usize; 2] {
        match self {
            Axis::U => [1, 3],
            Axis::V => [2, 0],
        }
    }

    /// Derivative along the axis and across it.
    pub(super) fn jet(self, jet: &Jet) -> [[glam::DVec4; 2]; 2] {
        match self {
            Axis::U => [[jet.value, jet.du], [jet.dv, jet.duv]],
            Axis::V => [[jet.value, jet.dv], [jet.du, jet.duv]],
        }
    }

    pub(super) fn to_jet(self, [[value, along], [across, both]]: [[glam::DVec4; 2]; 2]) -> Jet {
        match self {
            Axis::U => Jet { value, du: along, dv: across, duv: both },
            Axis::V => Jet { value, du: across, dv: along, duv: both },
        }
    }
}

/// What a split made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Split {
    /// The patch that is left: the part with the smaller parameter.
    pub first: u32,
    /// The new patch.
    pub second: u32,
    /// The new curve.
    pub curve: u32,
}

impl Mesh {
    /// Splits patch `p` at `axis` = `at`. Geometry and colours stay what they are, to rounding: the new data are values
    /// and derivatives of the patch (eq. 5, Fig. 7). A side whose neighbour is not cut there ends up with a T-section.
    ///
    /// # Errors
    /// There is no such patch, or `at` is not well inside (0, 1).
    pub fn split(&mut self, p: u32, axis: Axis, at: f64) -> Result<Split, FergusonError> {
        if self.patches.get(p as usize).is_none_or(|patch| !patch.alive) {
            return Err(FergusonError::NoPatch(p));
        }
        if !(THINNEST..=1.0 - THINNEST).contains(&at) {
            return Err(FergusonError::SplitOutside(at));
        }
        let old = *self.patch(p);
        let tangents = [0, 1, 2, 3].map(|i| self.tangents(HalfEdge::new(p, i)));
        let q = self.patches.len() as u32;

        // The two ends of the new curve, and the derivative across and the mixed one there.
        let mut corners = [old.corners; 2];
        let mut ends = [NONE; 2];
        let mut across = [DVec2::ZERO; 2];
        for (line, [a, b]) in axis.pairs().into_iter().enumerate() {
            let side = axis.cut()[line];
            // For u the first line runs along the axis and the second against it; for v it is the same with B-C and D-A.
            let h = HalfEdge::new(p, side);
            let along = line == 0;
            ends[line] = self.cut_side(h, q, axis, if along { at } else { 1.0 - at });
            let k = if axis == Axis::U { 1 } else { 0 };
            let cross = [tangents[a][k], old.corners[a].twist, old.corners[b].twist, tangents[b][k]];
            let [left, right] = hermite::split(cross, at);
            across[line] = left[3];
            let (ja, jb) = (axis.jet(&old.corners[a].colour), axis.jet(&old.corners[b].colour));
            // Row 0: value and its derivative along the axis; row 1: the derivative across and the mixed one.
            let rows = [0, 1].map(|r| hermite::split([ja[r][0], ja[r][1], jb[r][1], jb[r][0]], at));
            let jet = |half: usize, end: usize| {
                axis.to_jet([0, 1].map(|r: usize| {
                    let c = rows[r][half];
                    if end == 0 {
                        [c[0], c[1]]
                    } else {
                        [c[3], c[2]]
                    }
                }))
            };
            let new = |twist, colour| Corner { point: ends[line], twist, colour, inherits: false };
            corners[0][a] = Corner { twist: left[1], colour: jet(0, 0), ..old.corners[a] };
            corners[0][b] = new(left[2], jet(0, 1));
            corners[1][a] = new(right[1], jet(1, 0));
            corners[1][b] = Corner { twist: right[2], colour: jet(1, 1), ..old.corners[b] };
        }

        // The new curve runs from the first line to the second for u; for v from B-C to D-A, so towards smaller u.
        let sign = if axis == Axis::U { 1.0 } else { -1.0 };
        let (from, to) = (self.at(ends[0]), self.at(ends[1]));
        let c = self.curves.len() as u32;
        let middle = axis.middle();
        self.curves.push(Curve {
            ends,
            handles: [from + across[0] * (sign / 3.0), to - across[1] * (sign / 3.0)],
            sides: [vec![HalfEdge::new(p, middle[0])], vec![HalfEdge::new(q, middle[1])]],
        });

        // Sides: the cut ones were put in place by `cut_side`; the far side of the second part moves over.
        let far = middle[0];
        let mut second = Patch { corners: corners[1], ..*self.patch(q) };
        second.sides[far] = self.patch(p).sides[far];
        self.relabel(second.sides[far].curve, HalfEdge::new(p, far), HalfEdge::new(q, far));
        let level = old.sides[middle[0]].level.max(old.sides[middle[1]].level);
        let whole = |against| Side { curve: c, against, from: 0.0, to: 1.0, level };
        second.sides[middle[1]] = whole(true);
        let i = if axis == Axis::U { 0 } else { 1 };
        let cut = old.rect[i] + at * (old.rect[i + 2] - old.rect[i]);
        second.rect[i] = cut;
        self.patches[q as usize] = second;
        let first = self.patch_mut(p);
        first.corners = corners[0];
        first.sides[middle[0]] = whole(false);
        first.rect[i + 2] = cut;

        // Corner lists of the points: the far corners change their patch, the ends of the curve gain two each.
        for (line, [a, b]) in axis.pairs().into_iter().enumerate() {
            let (was, is) = (HalfEdge::new(p, b), HalfEdge::new(q, b));
            let point = old.corners[b].point;
            if let Some(slot) = self.point_mut(point).corners.iter_mut().find(|h| **h == was) {
                *slot = is;
            }
            self.point_mut(ends[line]).corners.extend([HalfEdge::new(p, b), HalfEdge::new(q, a)]);
        }
        for h in [p, q].into_iter().flat_map(|p| (0..4).map(move |i| HalfEdge::new(p, i))) {
            self.note_inheritance(h);
        }
        Ok(Split { first: p, second: q, curve: c })
    }

    /// Cuts side `h` of patch `p` at `fraction` of it, between `p` and the new patch `q`; the point there.
    fn cut_side(&mut self, h: HalfEdge, q: u32, axis: Axis, fraction: f64) -> u32 {
        let (p, i) = (h.patch(), h.side());
        if self.patches.len() as u32 == q {
            self.patches.push(*self.patch(p));
        }
        let side = *self.side(h);
        let width = side.to - side.from;
        let mut t = if side.against { side.to - width * fraction } else { side.from + width * fraction };
        // Whatever is cut across already at this parameter is the same point.
        let there = self.sections(h).into_iter().map(|(o, _)| (self.start(o), self.corner(o).point));
        let there = there.filter(|(at, _)| (at - t).abs() <= SAME * width.max(SAME)).collect::<Vec<_>>();
        let point = match there.first() {
            Some(&(at, point)) => {
                t = at;
                point
            }
            None => {
                let at = hermite::point(self.bezier(side.curve), t);
                self.points.push(Point { at, on: Some(Section { curve: side.curve, t }), corners: Vec::new() });
                self.points.len() as u32 - 1
            }
        };
        // Along its own direction, the first part of sides 0 and 1 stays with p; sides 2 and 3 run the other way.
        let kept_first = i == axis.cut()[0];
        let level = side.level + 1;
        let (low, high) = (Side { to: t, level, ..side }, Side { from: t, level, ..side });
        let kept_is_low = kept_first != side.against;
        let (kept, given) = if kept_is_low { (low, high) } else { (high, low) };
        *self.side_mut(h) = kept;
        self.patches[q as usize].sides[i] = given;
        let list = &mut self.curve_mut(side.curve).sides[usize::from(side.against)];
        if let Some(at) = list.iter().position(|o| *o == h) {
            list.insert(at + usize::from(kept_is_low), HalfEdge::new(q, i));
        }
        let across_empty = self.curve(side.curve).sides[usize::from(!side.against)].is_empty();
        if across_empty || !there.is_empty() {
            self.split_curve(side.curve, t, point);
        }
        point
    }

    /// Makes two curves of one at `t`, where the sides of both patches have an end: the point there is no T-section
    /// any more.
    fn split_curve(&mut self, c: u32, t: f64, point: u32) {
        let q = self.bezier(c);
        let [low, high] = halves(q, t);
        let d = self.curves.len() as u32;
        let mut curve = self.curve(c).clone();
        let end = curve.ends[1];
        let mut second = Curve { ends: [point, end], handles: [high[1], high[2]], sides: Default::default() };
        curve.ends[1] = point;
        curve.handles = [low[1], low[2]];
        for (list, far) in curve.sides.iter_mut().zip(&mut second.sides) {
            let cut = list.iter().position(|&h| self.patches[h.patch() as usize].sides[h.side()].from >= t);
            *far = list.split_off(cut.unwrap_or(list.len()));
        }
        let lists = [(c, curve.sides.clone()), (d, second.sides.clone())];
        *self.curve_mut(c) = curve;
        self.curves.push(second);
        self.point_mut(point).on = None;
        for (number, sides) in lists {
            let map = move |x: f64| {
                if number == c {
                    if x == t {
                        1.0
                    } else {
                        x / t
                    }
                } else if x == t {
                    0.0
                } else if x == 1.0 {
                    1.0
                } else {
                    (x - t) / (1.0 - t)
                }
            };
            self.renumber(number, &sides, map);
        }
    }

    /// Gives the half-edges of a curve, and the T-sections between them, the curve's number and mapped parameters.
    pub(super) fn renumber(&mut self, c: u32, sides: &[Vec<HalfEdge>; 2], map: impl Fn(f64) -> f64) {
        for list in sides {
            for &h in list {
                let side = self.side_mut(h);
                (side.curve, side.from, side.to) = (c, map(side.from), map(side.to));
            }
        }
        for list in sides {
            for &h in list {
                let t = self.start(h);
                if t > 0.0 && t < 1.0 {
                    let point = self.corner(h).point;
                    // While a patch is being split its new corner has no point yet; `cut_side` sets that.
                    if self.points[point as usize].on.is_some() {
                        self.point_mut(point).on = Some(Section { curve: c, t });
                    }
                }
            }
        }
    }

    /// Puts `is` where `was` stands in the lists of a curve.
    pub(super) fn relabel(&mut self, c: u32, was: HalfEdge, is: HalfEdge) {
        for list in &mut self.curve_mut(c).sides {
            if let Some(slot) = list.iter_mut().find(|h| **h == was) {
                *slot = is;
            }
        }
    }
}
