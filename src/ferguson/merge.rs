//! Taking a split back, where the result is still exact.

use super::hermite::{self, halves, Linear};
use super::mesh::{Corner, HalfEdge, Mesh, Point, Section};
use super::split::Axis;
use super::FergusonError;
use glam::{DVec2, DVec4};

/// How far two numbers of the size of the mesh may differ and still be the same.
const EXACT: f64 = 1e-10;

/// What becomes of one end of the curve that goes.
enum End {
    /// The two curves along it are one, [from, to] of it each side; the point is a T-section of what is across, or gone.
    Join { first: u32, second: u32, t: f64, handles: [DVec2; 2] },
    /// Already one curve: the point was a T-section and is gone.
    Section,
}

impl Mesh {
    /// Removes the split that made curve `c`: the two patches along it become one. The number of the second patch, of the
    /// curve and of points that nothing meets in any more are left unused.
    ///
    /// # Errors
    /// There is no such curve, it is not a split between two halves of one patch, something ends in the middle of it, or
    /// the two patches have been edited so that one patch could not draw the same.
    pub fn remove_split(&mut self, c: u32) -> Result<u32, FergusonError> {
        let curve = self.curves.get(c as usize).ok_or(FergusonError::NoCurve(c))?;
        let no = |why| FergusonError::NotRemovable { curve: c, why };
        let ([h], [o]) = (&curve.sides[0][..], &curve.sides[1][..]) else {
            return Err(no("it is a boundary, or another curve ends on it; remove that one first"));
        };
        let (p, q) = (h.patch(), o.patch());
        let axis = match (h.side(), o.side()) {
            (1, 3) => Axis::U,
            (2, 0) => Axis::V,
            _ => return Err(no("it is no split; only splits can be removed")),
        };
        let (a, b) = (*self.patch(p), *self.patch(q));
        let i = usize::from(axis == Axis::V);
        let same_lines = [i ^ 1, (i ^ 1) + 2].into_iter().all(|k| (a.rect[k] - b.rect[k]).abs() < EXACT);
        if a.root != b.root || !same_lines || (a.rect[i + 2] - b.rect[i]).abs() > EXACT || p == q {
            return Err(no("it is no split of one patch; only splits can be removed"));
        }
        let t = (a.rect[i + 2] - a.rect[i]) / (b.rect[i + 2] - a.rect[i]);

        // The joined patch, and whether splitting it would give the two again.
        let scale = self.scale([p, q]);
        let mut corners = a.corners;
        let (ta, tb) = (
            [0, 1, 2, 3].map(|k| self.tangents(HalfEdge::new(p, k))),
            [0, 1, 2, 3].map(|k| self.tangents(HalfEdge::new(q, k))),
        );
        let k = usize::from(axis == Axis::U);
        for [first, second] in axis.pairs() {
            let left = [ta[first][k], a.corners[first].twist, a.corners[second].twist, ta[second][k]];
            let right = [tb[first][k], b.corners[first].twist, b.corners[second].twist, tb[second][k]];
            let cross = joined(left, right, t, |x: DVec2| x.abs().max_element() <= EXACT * 9.0 * scale);
            let cross = cross.ok_or(no("a twist or a handle beside it was changed; restore it first"))?;
            let mut rows = [[[DVec4::ZERO; 2]; 2]; 2];
            for r in [0, 1] {
                let data = |patch: &super::mesh::Patch| {
                    let (x, y) =
                        (axis.jet(&patch.corners[first].colour)[r], axis.jet(&patch.corners[second].colour)[r]);
                    [x[0], x[1], y[1], y[0]]
                };
                let size = self.colour_scale([p, q]);
                let all = joined(data(&a), data(&b), t, |x: DVec4| x.abs().max_element() <= EXACT * 9.0 * size);
                let all = all.ok_or(no("a colour on it was changed; restore it first"))?;
                rows[0][r] = [all[0], all[1]];
                rows[1][r] = [all[3], all[2]];
            }
            corners[first] = Corner { twist: cross[1], colour: axis.to_jet(rows[0]), ..a.corners[first] };
            corners[second] = Corner { twist: cross[2], colour: axis.to_jet(rows[1]), ..b.corners[second] };
        }
        let cut = axis.cut();
        let ends = [0, 1].map(|line| {
            let (x, y) = (HalfEdge::new(p, cut[line]), HalfEdge::new(q, cut[line]));
            self.end(if line == 0 { [x, y] } else { [y, x] }, if line == 0 { t } else { 1.0 - t }, scale)
        });
        let [Ok(first), Ok(second)] = ends else {
            return Err(no("the curves at its ends do not continue one another; restore their handles first"));
        };

        // Nothing can fail from here on.
        for (line, end) in [first, second].into_iter().enumerate() {
            let (x, y) = (HalfEdge::new(p, cut[line]), HalfEdge::new(q, cut[line]));
            let point = self.corner(if line == 0 { y } else { x }).point;
            if let End::Join { first, second, t, handles } = end {
                self.join_curves(first, second, t, handles, point);
            }
            // One half-edge where there were two.
            let (low, high) = (self.side(x).from.min(self.side(y).from), self.side(x).to.max(self.side(y).to));
            let along = self.side(x).curve;
            for list in &mut self.curve_mut(along).sides {
                list.retain(|h| *h != y);
            }
            let side = self.side_mut(x);
            (side.from, side.to, side.level) = (low, high, side.level.saturating_sub(1));
            let dead =
                [0, 1, 2, 3].map(|k| HalfEdge::new(p, k)).into_iter().chain([0, 1, 2, 3].map(|k| HalfEdge::new(q, k)));
            let dead: Vec<HalfEdge> = dead.filter(|&h| self.corner(h).point == point).collect();
            self.point_mut(point).corners.retain(|h| !dead.contains(h));
        }
        let far = axis.middle()[0];
        let far_side = b.sides[far];
        let current = self.patch(q).sides[far];
        self.relabel(current.curve, HalfEdge::new(q, far), HalfEdge::new(p, far));
        for [_, second] in axis.pairs() {
            let point = b.corners[second].point;
            if let Some(slot) = self.point_mut(point).corners.iter_mut().find(|h| **h == HalfEdge::new(q, second)) {
                *slot = HalfEdge::new(p, second);
            }
        }
        debug_assert_eq!(far_side.against, current.against);
        let kept = self.patch_mut(p);
        kept.corners = corners;
        kept.sides[far] = current;
        kept.rect[i + 2] = b.rect[i + 2];
        self.patch_mut(q).alive = false;
        self.curve_mut(c).sides = Default::default();
        Ok(p)
    }

    /// Size of the numbers of two patches and of the curves along them, for comparisons.
    fn scale(&self, patches: [u32; 2]) -> f64 {
        let sides = patches.into_iter().flat_map(|p| self.patch(p).sides);
        let all = sides.flat_map(|side| self.bezier(side.curve)).map(|at| at.abs().max_element());
        all.fold(1e-300, f64::max)
    }

    fn colour_scale(&self, patches: [u32; 2]) -> f64 {
        let corners = patches.into_iter().flat_map(|p| self.patch(p).corners);
        corners.map(|c| c.colour.value.abs().max_element()).fold(1.0, f64::max)
    }

    /// Whether what runs along half-edges `x` and then `y` is one cubic, `x` being the part `t` of it.
    fn end(&self, [x, y]: [HalfEdge; 2], t: f64, scale: f64) -> Result<End, ()> {
        let (sx, sy) = (*self.side(x), *self.side(y));
        if sx.curve == sy.curve {
            return Ok(End::Section);
        }
        // In the direction of the curves.
        let (first, second, part) = if sx.against { (sy, sx, 1.0 - t) } else { (sx, sy, t) };
        if sx.against != sy.against || first.to != 1.0 || second.from != 0.0 {
            return Err(());
        }
        // Lengths of the whole curves in the patch's parameter.
        let (l1, l2) = (part / (first.to - first.from), (1.0 - part) / (second.to - second.from));
        let middle = l1 / (l1 + l2);
        let (a, b) = (self.bezier(first.curve), self.bezier(second.curve));
        let handles = [a[0] + (a[1] - a[0]) / middle, b[3] + (b[2] - b[3]) / (1.0 - middle)];
        let again = halves([a[0], handles[0], handles[1], b[3]], middle);
        let near = again
            .iter()
            .zip([a, b])
            .all(|(x, y)| x.iter().zip(y).all(|(x, y)| (*x - y).abs().max_element() <= EXACT * scale));
        // Across, the two curves are continued by two patches with one curve between them, or by none.
        let across = |c: u32| &self.curve(c).sides[usize::from(!first.against)];
        let (before, after) = (across(first.curve).last(), across(second.curve).first());
        let continued = match (before, after) {
            (None, None) => true,
            (Some(&m), Some(&n)) => {
                let (m, n) = if first.against { (m.next(), n.prev()) } else { (m.prev(), n.next()) };
                self.side(m).curve == self.side(n).curve && m.patch() != n.patch()
            }
            _ => false,
        };
        if near && continued {
            Ok(End::Join { first: first.curve, second: second.curve, t: middle, handles })
        } else {
            Err(())
        }
    }

    /// The curves `first` and `second` become `first`, which they divided at `t`.
    fn join_curves(&mut self, first: u32, second: u32, t: f64, handles: [DVec2; 2], point: u32) {
        let gone = self.curve(second).clone();
        let front = self.curve(first).sides.clone();
        self.renumber(first, &front, |x| if x == 1.0 { t } else { x * t });
        self.renumber(first, &gone.sides, move |x| if x == 1.0 { 1.0 } else { t + x * (1.0 - t) });
        self.curve_mut(second).sides = Default::default();
        let curve = self.curve_mut(first);
        curve.ends[1] = gone.ends[1];
        curve.handles = handles;
        for (list, more) in curve.sides.iter_mut().zip(gone.sides) {
            list.extend(more);
        }
        let on = Some(Section { curve: first, t });
        *self.point_mut(point) = Point { on, ..self.points[point as usize].clone() };
        let corners = self.points[point as usize].corners.clone();
        for h in corners {
            self.note_inheritance(h);
            self.note_inheritance(h.prev());
        }
    }
}

/// The cubic that these are the parts of at `t`, if they are.
fn joined<T: Linear>(left: [T; 4], right: [T; 4], t: f64, small: impl Fn(T) -> bool) -> Option<[T; 4]> {
    let all = hermite::join(left, right, t);
    let again = hermite::split(all, t);
    let same = |x: &[T; 4], y: [T; 4]| x.iter().zip(y).all(|(a, b)| small(*a - b));
    (same(&again[0], left) && same(&again[1], right)).then_some(all)
}
