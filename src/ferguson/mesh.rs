//! The augmented half-edge structure (BLHK18 6.1).
//!
//! ```text
//!            side 2                 Every patch has four half-edges, its sides, and four corners: corner i is where
//!       D <----------- C            side i begins. S(u, v) runs along u from A to B and along v from A to D.
//!       |              ^
//!  side |      v       | side       A curve is what the sides of one or two patches run along. Each side covers an
//!   3   |      ^       |  1         interval of its curve: [0, 1] in the plain case, less where the patch across is
//!       v      +--> u  |            longer. A point strictly inside a side of the patch across is a T-section: it has
//!       A -----------> B            its place and its tangent along the curve from the curve (Fig. 10, Fig. 12).
//!            side 0
//! ```
//!
//! Handles are stored in Bezier form (points of the plane, once for each curve and so shared by both sides and by all
//! levels), twists in Hermite form, colours with their derivatives at the corners of patches, so that each sector of a
//! point may have its own.

use super::blend::Blend;
use super::hermite::{self, restrict, reverse};
use crate::patch::space::Interpolation;
use glam::{DVec2, DVec4};
use std::collections::BTreeSet;

/// No entity.
pub const NONE: u32 = u32::MAX;

/// A side of a patch: 4 times the patch's number, plus the side's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct HalfEdge(pub u32);

impl HalfEdge {
    /// Side `side` (0 to 3) of a patch.
    pub fn new(patch: u32, side: usize) -> HalfEdge {
        HalfEdge(4 * patch + side as u32)
    }

    /// Number of its patch.
    pub fn patch(self) -> u32 {
        self.0 / 4
    }

    /// Side of the patch, 0 to 3; also the corner that it begins in.
    pub fn side(self) -> usize {
        self.0 as usize & 3
    }

    /// The half-edge after this one in its patch.
    pub fn next(self) -> HalfEdge {
        HalfEdge((self.0 & !3) | ((self.0 + 1) & 3))
    }

    /// The half-edge before this one in its patch.
    pub fn prev(self) -> HalfEdge {
        HalfEdge((self.0 & !3) | ((self.0 + 3) & 3))
    }
}

/// Where a T-section lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// The curve, the bar of the T.
    pub curve: u32,
    /// Parameter on it, strictly between 0 and 1.
    pub t: f64,
}

/// A control point.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Position, scene units.
    pub at: DVec2,
    /// The curve that a T-section inherits from; `None` for every other point.
    pub on: Option<Section>,
    /// Half-edges that begin here, one for each corner of a patch, in no order. Empty: the point is gone.
    pub corners: Vec<HalfEdge>,
}

/// A cubic with what runs along it.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Points at parameter 0 and 1.
    pub ends: [u32; 2],
    /// The two inner Bezier points.
    pub handles: [DVec2; 2],
    /// Half-edges on either side, in the order of their intervals: \[0\] those that run along the curve, \[1\] those
    /// that run against it. One list is empty on the boundary, both when the curve is gone.
    pub sides: [Vec<HalfEdge>; 2],
}

/// A side of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// The curve that it runs along.
    pub curve: u32,
    /// Whether it runs against the curve.
    pub against: bool,
    /// Its interval on the curve, `from < to` whatever its direction.
    pub from: f64,
    /// See `from`.
    pub to: f64,
    /// How often it was split (6.1).
    pub level: u32,
}

/// Colour at a corner with its derivatives in the patch's u and v, in the mesh's colour space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jet {
    /// Colour.
    pub value: DVec4,
    /// Along u.
    pub du: DVec4,
    /// Along v.
    pub dv: DVec4,
    /// Mixed: the colour twist.
    pub duv: DVec4,
}

/// What a patch knows of one of its corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// The point.
    pub point: u32,
    /// Twist of the geometry, S_uv, in Hermite form.
    pub twist: DVec2,
    /// Colour of this sector.
    pub colour: Jet,
    /// At a T-section: the colour follows the patch across. Off where the colours of both sides differ.
    pub inherits: bool,
}

/// A bicubic patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Sides 0 to 3.
    pub sides: [Side; 4],
    /// Corners A, B, C, D.
    pub corners: [Corner; 4],
    /// The patch of level 0 that it is part of.
    pub root: u32,
    /// Its part of the root's domain: u0, v0, u1, v1.
    pub rect: [f64; 4],
    /// False: the patch is gone.
    pub alive: bool,
}

impl Patch {
    /// Sizes in the root's domain along u and v.
    pub fn extent(&self) -> [f64; 2] {
        [self.rect[2] - self.rect[0], self.rect[3] - self.rect[1]]
    }

    /// Greatest level of its half-edges.
    pub fn level(&self) -> u32 {
        self.sides.iter().map(|s| s.level).max().unwrap_or(0)
    }
}

/// What was there before a change, to take it back.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Journal {
    pub(super) points: Vec<(u32, Point)>,
    pub(super) curves: Vec<(u32, Curve)>,
    pub(super) patches: Vec<(u32, Patch)>,
    pub(super) lengths: [usize; 3],
    pub(super) seen: [BTreeSet<u32>; 3],
}

/// A locally refinable gradient mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Short name for tables and pictures.
    pub name: String,
    /// What the colours of the corners are coordinates of: the space that is interpolated in.
    pub colour: Interpolation,
    /// How colour runs along a curve between two points.
    pub blend: Blend,
    /// Control points.
    pub points: Vec<Point>,
    /// Curves.
    pub curves: Vec<Curve>,
    /// Patches.
    pub patches: Vec<Patch>,
    pub(super) journal: Journal,
}

impl Mesh {
    /// Patches that are drawn.
    pub fn live(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.patches.len() as u32).filter(|&p| self.patches[p as usize].alive)
    }

    /// A patch.
    pub fn patch(&self, p: u32) -> &Patch {
        &self.patches[p as usize]
    }

    /// A curve.
    pub fn curve(&self, c: u32) -> &Curve {
        &self.curves[c as usize]
    }

    /// A side of a patch.
    pub fn side(&self, h: HalfEdge) -> &Side {
        &self.patches[h.patch() as usize].sides[h.side()]
    }

    /// The corner that a half-edge begins in.
    pub fn corner(&self, h: HalfEdge) -> &Corner {
        &self.patches[h.patch() as usize].corners[h.side()]
    }

    /// Position of a point.
    pub fn at(&self, point: u32) -> DVec2 {
        self.points[point as usize].at
    }

    /// Bezier points of a whole curve.
    pub fn bezier(&self, c: u32) -> [DVec2; 4] {
        let curve = self.curve(c);
        [self.at(curve.ends[0]), curve.handles[0], curve.handles[1], self.at(curve.ends[1])]
    }

    /// Bezier points of a half-edge, from where it begins: those of its curve where it covers all of it.
    pub fn half_edge(&self, h: HalfEdge) -> [DVec2; 4] {
        let side = self.side(h);
        let q = restrict(self.bezier(side.curve), side.from, side.to);
        let mut q = if side.against { reverse(q) } else { q };
        // The ends are points of the mesh; a T-section was computed once, from the curve.
        (q[0], q[3]) = (self.at(self.corner(h).point), self.at(self.corner(h.next()).point));
        q
    }

    /// Parameter on its curve where a half-edge begins.
    pub fn start(&self, h: HalfEdge) -> f64 {
        let side = self.side(h);
        if side.against {
            side.to
        } else {
            side.from
        }
    }

    /// The opposite of a half-edge (6.1): of those across, the one that meets the point where `h` begins. Not always
    /// symmetric near T-sections (Fig. 10). `None` on the boundary.
    pub fn opposite(&self, h: HalfEdge) -> Option<HalfEdge> {
        let side = self.side(h);
        let across = &self.curve(side.curve).sides[usize::from(!side.against)];
        across.iter().copied().find(|&o| {
            let o = self.side(o);
            if side.against {
                o.from < side.to && side.to <= o.to
            } else {
                o.from <= side.from && side.from < o.to
            }
        })
    }

    /// The outgoing half-edge of a point: at a T-section the one along its stem, else any.
    pub fn outgoing(&self, point: u32) -> Option<HalfEdge> {
        let p = &self.points[point as usize];
        let on = p.on.map(|section| section.curve);
        p.corners.iter().copied().find(|&h| Some(self.side(h).curve) != on)
    }

    /// T-sections strictly inside a half-edge: of each, the half-edge across that begins in it, and the fraction along
    /// `h` where it lies.
    pub fn sections(&self, h: HalfEdge) -> Vec<(HalfEdge, f64)> {
        let side = self.side(h);
        let across = &self.curve(side.curve).sides[usize::from(!side.against)];
        let width = side.to - side.from;
        let mut found = Vec::new();
        for &o in across {
            let t = self.start(o);
            if side.from < t && t < side.to {
                let along = (t - side.from) / width;
                found.push((o, if side.against { 1.0 - along } else { along }));
            }
        }
        found
    }

    /// Hermite matrix C of the geometry (eq. 4) as 16 Bezier points in the order of [`crate::patch`].
    pub fn geometry(&self, p: u32) -> [DVec2; 16] {
        let mut net = [DVec2::ZERO; 16];
        for (side, slots) in crate::patch::eval::FACE_EDGES.into_iter().enumerate() {
            for (slot, at) in slots.into_iter().zip(self.half_edge(HalfEdge::new(p, side))) {
                net[slot] = at;
            }
        }
        let corners = &self.patch(p).corners;
        for (corner, (inner, [point, along, other], sign)) in INNER.into_iter().enumerate() {
            net[inner] = net[along] + net[other] - net[point] + corners[corner].twist * (sign / 9.0);
        }
        net
    }

    /// The colour channels as 16 Bezier points.
    pub fn colours(&self, p: u32) -> [DVec4; 16] {
        colour_net(&self.patch(p).corners.map(|c| c.colour))
    }

    /// Position and colour at (u, v) of a patch.
    pub fn evaluate(&self, p: u32, u: f64, v: f64) -> (DVec2, DVec4) {
        (tensor(&self.geometry(p), u, v), tensor(&self.colours(p), u, v))
    }

    /// First derivatives of the geometry at a corner: along u, along v.
    pub fn tangents(&self, h: HalfEdge) -> [DVec2; 2] {
        let out = self.half_edge(h);
        let back = self.half_edge(h.prev());
        let (along, inward) = ((out[1] - out[0]) * 3.0, (back[2] - back[3]) * 3.0);
        // From here the next side is `along`, the one before leads back: in the patch's u and v.
        match h.side() {
            0 => [along, inward],
            1 => [-inward, along],
            2 => [-along, -inward],
            _ => [inward, -along],
        }
    }

    /// Takes the record of changes since the last call; patches in it are those that changed.
    pub fn take_journal(&mut self) -> Journal {
        let lengths = [self.points.len(), self.curves.len(), self.patches.len()];
        std::mem::replace(&mut self.journal, Journal { lengths, ..Journal::default() })
    }

    /// Undoes what a journal recorded; journals are undone in the reverse order of their making.
    pub fn undo(&mut self, journal: Journal) {
        self.points.truncate(journal.lengths[0]);
        self.curves.truncate(journal.lengths[1]);
        self.patches.truncate(journal.lengths[2]);
        for (i, old) in journal.points {
            self.points[i as usize] = old;
        }
        for (i, old) in journal.curves {
            self.curves[i as usize] = old;
        }
        for (i, old) in journal.patches {
            self.patches[i as usize] = old;
        }
        self.take_journal();
    }

    pub(super) fn point_mut(&mut self, i: u32) -> &mut Point {
        if (i as usize) < self.journal.lengths[0] && self.journal.seen[0].insert(i) {
            self.journal.points.push((i, self.points[i as usize].clone()));
        }
        &mut self.points[i as usize]
    }

    pub(super) fn curve_mut(&mut self, i: u32) -> &mut Curve {
        if (i as usize) < self.journal.lengths[1] && self.journal.seen[1].insert(i) {
            self.journal.curves.push((i, self.curves[i as usize].clone()));
        }
        &mut self.curves[i as usize]
    }

    pub(super) fn patch_mut(&mut self, i: u32) -> &mut Patch {
        if (i as usize) < self.journal.lengths[2] && self.journal.seen[2].insert(i) {
            self.journal.patches.push((i, self.patches[i as usize]));
        }
        &mut self.patches[i as usize]
    }

    pub(super) fn side_mut(&mut self, h: HalfEdge) -> &mut Side {
        &mut self.patch_mut(h.patch()).sides[h.side()]
    }

    pub(super) fn corner_mut(&mut self, h: HalfEdge) -> &mut Corner {
        &mut self.patch_mut(h.patch()).corners[h.side()]
    }
}

impl Journal {
    /// Numbers of the patches that were there before and were changed, ascending.
    pub fn changed(&self) -> impl Iterator<Item = u32> + '_ {
        self.seen[2].iter().copied()
    }
}

/// For corners A to D: inner Bezier point, then corner point and its two neighbours on the sides, and the sign of the
/// twist there.
const INNER: [(usize, [usize; 3], f64); 4] =
    [(5, [0, 1, 4], 1.0), (6, [3, 2, 7], -1.0), (10, [15, 14, 11], 1.0), (9, [12, 13, 8], -1.0)];

/// 16 Bezier points of four colour jets: X^-1 C X^-T.
pub fn colour_net(jets: &[Jet; 4]) -> [DVec4; 16] {
    let [a, b, c, d] = jets;
    let value = [hermite::bezier([a.value, a.du, b.du, b.value]), hermite::bezier([d.value, d.du, c.du, c.value])];
    let slope = [hermite::bezier([a.dv, a.duv, b.duv, b.dv]), hermite::bezier([d.dv, d.duv, c.duv, c.dv])];
    let mut net = [DVec4::ZERO; 16];
    for column in 0..4 {
        let rows = hermite::bezier([value[0][column], slope[0][column], slope[1][column], value[1][column]]);
        for (row, at) in rows.into_iter().enumerate() {
            net[4 * row + column] = at;
        }
    }
    net
}

/// Twist at corner `corner` of a net of 16 Bezier points.
pub fn twist_of<T: hermite::Linear>(net: &[T; 16], corner: usize) -> T {
    let (inner, [point, along, other], sign) = INNER[corner];
    (net[inner] - net[along] - (net[other] - net[point])) * (9.0 * sign)
}

/// Colour jets of a net of 16 Bezier points: the inverse of [`colour_net`].
pub fn jets_of(net: &[DVec4; 16]) -> [Jet; 4] {
    std::array::from_fn(|i| {
        let (_, [point, along_u, along_v], _) = INNER[i];
        let (su, sv) = ([1.0, -1.0, -1.0, 1.0][i], [1.0, 1.0, -1.0, -1.0][i]);
        Jet {
            value: net[point],
            du: (net[along_u] - net[point]) * (3.0 * su),
            dv: (net[along_v] - net[point]) * (3.0 * sv),
            duv: twist_of(net, i),
        }
    })
}

/// Point of a tensor-product net at (u, v).
pub fn tensor<T: hermite::Linear>(net: &[T; 16], u: f64, v: f64) -> T {
    let row = |r: usize| hermite::point([net[4 * r], net[4 * r + 1], net[4 * r + 2], net[4 * r + 3]], u);
    hermite::point([row(0), row(1), row(2), row(3)], v)
}
