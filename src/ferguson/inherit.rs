//! What T-sections take from the patch across, and the chain of updates that follows (BLHK18 5.1, Fig. 10).

use super::hermite;
use super::mesh::{HalfEdge, Jet, Mesh};
use glam::DVec2;
use std::collections::{BTreeSet, VecDeque};

/// How handles behave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Continuity {
    /// C^1: handles of opposite curves mirror each other, T-sections take everything from the patch across (5.1).
    #[default]
    C1,
    /// C^0: every handle is free; T-sections take their place, the tangent along their curve, and the colours there (5.2).
    C0,
}

/// Patches whose T-sections have to be looked at, first come first served, none twice.
#[derive(Default)]
struct Waiting {
    order: VecDeque<u32>,
    there: BTreeSet<u32>,
}

impl Waiting {
    fn push(&mut self, p: u32) {
        if self.there.insert(p) {
            self.order.push_back(p);
        }
    }

    fn pop(&mut self) -> Option<u32> {
        let p = self.order.pop_front()?;
        self.there.remove(&p);
        Some(p)
    }
}

/// Derivatives at a point of a patch's side: along the side, and into the patch.
struct AtSide<T> {
    value: T,
    along: T,
    inward: T,
    both: T,
}

/// Signs that turn (along, inward) of side `i` into (u, v), and back: which of u, v is along; sign of along; of inward.
const FRAME: [(bool, f64, f64); 4] = [(true, 1.0, 1.0), (false, 1.0, -1.0), (true, -1.0, -1.0), (false, -1.0, 1.0)];

impl Mesh {
    /// Geometry at fraction `s` of side `h`.
    fn geometry_at(&self, h: HalfEdge, s: f64) -> AtSide<DVec2> {
        let (along_u, sa, si) = FRAME[h.side()];
        let k = usize::from(along_u);
        let (a, b) = (self.tangents(h)[k] * si, self.tangents(h.next())[k] * si);
        let (ta, tb) = (self.corner(h).twist * (sa * si), self.corner(h.next()).twist * (sa * si));
        let [inward, both] = hermite::sample([a, ta, tb, b], s);
        let [value, along] = hermite::sample(hermite::hermite(self.half_edge(h)), s);
        AtSide { value, along, inward, both }
    }

    /// Colour at fraction `s` of side `h`.
    fn colour_at(&self, h: HalfEdge, s: f64) -> AtSide<glam::DVec4> {
        let jets = [self.corner(h).colour, self.corner(h.next()).colour];
        let (along_u, sa, si) = FRAME[h.side()];
        let parts = jets.map(|j| {
            let (along, inward) = if along_u { (j.du, j.dv) } else { (j.dv, j.du) };
            (j.value, along * sa, inward * si, j.duv * (sa * si))
        });
        let [value, along] = hermite::sample([parts[0].0, parts[0].1, parts[1].1, parts[1].0], s);
        let [inward, both] = hermite::sample([parts[0].2, parts[0].3, parts[1].3, parts[1].2], s);
        AtSide { value, along, inward, both }
    }

    /// Ratios by which derivatives of the patch of `h`, along and inward, become those of the patch of `o` across.
    fn ratios(&self, h: HalfEdge, o: HalfEdge) -> [f64; 2] {
        let width = |h: HalfEdge| self.side(h).to - self.side(h).from;
        let depth = |h: HalfEdge| self.patch(h.patch()).extent()[usize::from(h.side() % 2 == 0)];
        [width(o) / width(h), depth(o) / depth(h)]
    }

    /// The jet that corner `corner` of side `o` (its first or its second) has if it follows the colours of `h` across.
    fn colour_across(&self, h: HalfEdge, s: f64, o: HalfEdge) -> Jet {
        let at = self.colour_at(h, s);
        let [ra, ri] = self.ratios(h, o);
        // Across, both directions are reversed, and the mixed derivative twice.
        let (along, inward, both) = (at.along * -ra, at.inward * -ri, at.both * (ra * ri));
        let (along_u, sa, si) = FRAME[o.side()];
        let (du, dv) = if along_u { (along * sa, inward * si) } else { (inward * si, along * sa) };
        Jet { value: at.value, du, dv, duv: both * (sa * si) }
    }

    /// Notes at the corners of half-edge `o` that are T-sections whether their colours follow the patch across.
    pub(crate) fn note_inheritance(&mut self, o: HalfEdge) {
        for corner in [o, o.next()] {
            let point = self.corner(corner).point;
            let Some(section) = self.points[point as usize].on else { continue };
            if self.side(o).curve != section.curve {
                continue;
            }
            let Some((h, s)) = self.spanning(o, section.t) else { continue };
            let expected = self.colour_across(h, s, o);
            let got = self.corner(corner).colour;
            let near =
                |a: glam::DVec4, b: glam::DVec4| (a - b).abs().max_element() <= 1e-9 * (1.0 + a.abs().max_element());
            let along = if FRAME[o.side()].0 { near(got.du, expected.du) } else { near(got.dv, expected.dv) };
            let follows = near(got.value, expected.value) && along;
            if self.corner(corner).inherits != follows {
                self.corner_mut(corner).inherits = follows;
            }
        }
    }

    /// The half-edge across `o` that has parameter `t` of their curve strictly inside, and the fraction along it.
    pub(super) fn spanning(&self, o: HalfEdge, t: f64) -> Option<(HalfEdge, f64)> {
        let side = self.side(o);
        let across = &self.curve(side.curve).sides[usize::from(!side.against)];
        across.iter().find_map(|&h| {
            let s = self.side(h);
            (s.from < t && t < s.to).then(|| {
                let along = (t - s.from) / (s.to - s.from);
                (h, if s.against { 1.0 - along } else { along })
            })
        })
    }

    /// Brings all T-sections that depend on `patches` up to date, and those that depend on these, and so on; only what
    /// really changes is touched.
    pub(super) fn settle(&mut self, patches: impl IntoIterator<Item = u32>, continuity: Continuity) {
        let mut waiting = Waiting::default();
        patches.into_iter().for_each(|p| waiting.push(p));
        // Where splits are dyadic, chains end: a stem points at ever younger curves. Where both sides of a curve have
        // T-sections of their own, each depends on the other, and going round converges; a file may hold a pinwheel.
        let mut most = 256 * self.patches.len() + 256;
        while let Some(p) = waiting.pop() {
            if most == 0 {
                return;
            }
            most -= 1;
            for side in 0..4 {
                let h = HalfEdge::new(p, side);
                for (o, s) in self.sections(h) {
                    self.follow(h, s, o, continuity, &mut waiting);
                }
            }
        }
    }

    /// Updates the T-section at fraction `s` of `h`, where `o` begins; `prev(o)` is its stem.
    fn follow(&mut self, h: HalfEdge, s: f64, o: HalfEdge, continuity: Continuity, waiting: &mut Waiting) {
        let point = self.corner(o).point;
        let Some(section) = self.points[point as usize].on else { return };
        let at = hermite::point(self.bezier(section.curve), section.t);
        let moved = at - self.at(point);
        let stem = o.prev();
        let stem_side = *self.side(stem);
        let end = usize::from(!stem_side.against);
        let geometry = self.geometry_at(h, s);
        let [_, depth] = self.ratios(h, o);
        // The stem leaves the curve away from the patch across.
        let handle = match continuity {
            // The stem's curve may be longer than this side of it.
            Continuity::C1 => at - geometry.inward * (depth / (3.0 * (stem_side.to - stem_side.from))),
            Continuity::C0 => self.curve(stem_side.curve).handles[end] + moved,
        };
        let old = self.curve(stem_side.curve).handles[end];
        let mut changed = moved != DVec2::ZERO;
        if self.curve(stem_side.curve).ends[end] == point && apart(old, handle, at) {
            self.curve_mut(stem_side.curve).handles[end] = handle;
            changed = true;
        }
        if moved != DVec2::ZERO {
            self.point_mut(point).at = at;
        }
        // The two patches at the stem: o's, and the one whose side before it on the curve ends here.
        let before =
            self.points[point as usize].corners.iter().copied().find(|&c| {
                c != o && self.side(c.prev()).curve == section.curve && self.side(c).curve == stem_side.curve
            });
        for (corner, along) in [(Some(o), o), (before, before.map_or(o, HalfEdge::prev))] {
            let Some(corner) = corner else { continue };
            let old = *self.corner(corner);
            let mut new = old;
            if continuity == Continuity::C1 {
                let [ra, ri] = self.ratios(h, along);
                let (_, sa, si) = FRAME[along.side()];
                new.twist = geometry.both * (ra * ri * sa * si);
            }
            if old.inherits {
                let jet = self.colour_across(h, s, along);
                new.colour = match continuity {
                    Continuity::C1 => jet,
                    Continuity::C0 if FRAME[along.side()].0 => Jet { value: jet.value, du: jet.du, ..old.colour },
                    Continuity::C0 => Jet { value: jet.value, dv: jet.dv, ..old.colour },
                };
            }
            if differs(&old, &new) {
                *self.corner_mut(corner) = new;
                changed = true;
            }
        }
        if changed {
            let stem = self.curve(stem_side.curve).sides.iter().flatten().map(|h| h.patch());
            let both = [o.patch()].into_iter().chain(before.map(HalfEdge::patch));
            for p in stem.chain(both).collect::<BTreeSet<u32>>() {
                self.patch_mut(p);
                waiting.push(p);
            }
        }
    }
}

/// Whether a handle really moves, seen from its point.
fn apart(old: DVec2, new: DVec2, point: DVec2) -> bool {
    let size = point.abs().max_element() + (new - point).abs().max_element();
    (old - new).abs().max_element() > 1e-14 * size
}

/// More than rounding: an update that only rounds differently would run through the mesh for nothing.
fn differs(a: &super::mesh::Corner, b: &super::mesh::Corner) -> bool {
    let far = |x: f64, y: f64| (x - y).abs() > 1e-13 * (1.0 + x.abs() + y.abs());
    let c = |a: glam::DVec4, b: glam::DVec4| (0..4).any(|i| far(a[i], b[i]));
    far(a.twist.x, b.twist.x)
        || far(a.twist.y, b.twist.y)
        || c(a.colour.value, b.colour.value)
        || c(a.colour.du, b.colour.du)
        || c(a.colour.dv, b.colour.dv)
        || c(a.colour.duv, b.colour.duv)
}
