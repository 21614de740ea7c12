//! The limit surface as patches: a 16-point bicubic for every regular face of a level, a 20-point Gregory patch for every
//! other (LSNC09), with the subdivided normal and the blend weight as further channels.
//!
//! Edges that are still sharp are sides of patches: a crease, a boundary and a corner are regular where their region has
//! two faces or one. So the level has to be one where every crease has decayed or is sharp for ever.

use super::level::{Level, Scheme};
use super::limit::{shape, Shape};
use super::normal::merged;
use super::region::Wedges;
use super::shade::{subdivided_normals, Settings};
use super::stencil::region_ends;
use super::weight::control_weights;
use crate::mesh::NONE;
use crate::patch::gregory::{face_point, Edge};
use crate::patch::ControlPoint;
use crate::scene::CornerRule;
use crate::subdiv::fan::{Fan, Linear};
use crate::subdiv::limit;
use glam::DVec3;
use std::ops::{Add, Mul, Sub};

/// Position, subdivided normal and blend weight: what a control point has.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Channels {
    /// Position.
    pub p: DVec3,
    /// Normal; unit at vertices of the level, not at other control points.
    pub n: DVec3,
    /// Weight.
    pub b: f64,
}

impl Add for Channels {
    type Output = Channels;
    fn add(self, o: Channels) -> Channels {
        Channels { p: self.p + o.p, n: self.n + o.n, b: self.b + o.b }
    }
}

impl Sub for Channels {
    type Output = Channels;
    fn sub(self, o: Channels) -> Channels {
        Channels { p: self.p - o.p, n: self.n - o.n, b: self.b - o.b }
    }
}

impl Mul<f64> for Channels {
    type Output = Channels;
    fn mul(self, s: f64) -> Channels {
        Channels { p: self.p * s, n: self.n * s, b: self.b * s }
    }
}

impl Linear for Channels {}

/// Patches of a level. Control points are x, y, z, b and the normal; patches share them by index, except across sharp
/// edges, where the points differ in the normal only.
#[derive(Clone, Debug, Default)]
pub struct Patches {
    /// Control points, as in [`crate::patch`]: x, y, z, weight; normal, 0.
    pub control: Vec<ControlPoint>,
    /// Regular faces, and their numbers in the level.
    pub bicubic: Vec<([u32; 16], u32)>,
    /// The other faces.
    pub gregory: Vec<([u32; 20], u32)>,
}

/// The first level that patches can draw: where faces are quads, and no finite sharpness is left.
pub fn first_level(control: &Level) -> u32 {
    let finite = |s: &&f64| s.is_finite();
    let sharpest = control.sharpness.iter().chain(&control.corner).filter(finite).fold(0.0f64, |a, &b| a.max(b));
    (sharpest.ceil() as u32).max(1)
}

/// Patches of the last of `levels` (Catmull-Clark, level [`first_level`] or deeper). `given` as in [`super::shade::shade`].
///
/// # Panics
/// If the last level has other faces than quads.
pub fn patches(levels: &[Level], given: &[DVec3], settings: &Settings) -> Patches {
    let last = &levels[levels.len() - 1];
    assert!(last.scheme == Scheme::CatmullClark && last.sides == 4, "patches need quads");
    // The limit knows what is sharp for ever only: creases that have just decayed count as smooth.
    let live = Wedges::live(last);
    let normals = merged(&Wedges::drawn(last), &live, &subdivided_normals(levels, given, settings, None));
    let mut smooth = levels.to_vec();
    smooth[levels.len() - 1].border = last.sharpness.iter().map(|&s| s > 0.0).collect();
    let weights = control_weights(&smooth, settings.weights_from as usize, settings.rules);
    let mut builder = Builder {
        level: last,
        value: (0..last.half_edges())
            .map(|h| {
                let v = last.origin[h] as usize;
                Channels { p: last.position[v], n: normals[live.of[h] as usize], b: weights[v] }
            })
            .collect(),
        live: &live,
        corner: vec![NONE; live.len()],
        edge: vec![[NONE; 2]; last.half_edges()],
        made: Patches::default(),
    };
    for f in 0..last.faces() as u32 {
        builder.face(f);
    }
    builder.made
}

struct Builder<'a> {
    level: &'a Level,
    /// At the origin of each half-edge, in the region of its face.
    value: Vec<Channels>,
    live: &'a Wedges,
    /// Control point of each wedge.
    corner: Vec<u32>,
    /// Control points of each half-edge's edge, near its origin and near its end.
    edge: Vec<[u32; 2]>,
    made: Patches,
}

/// Control points of corner i, near it on the edge that leaves it, far on that edge; inner point.
const CORNER: [usize; 4] = [0, 3, 15, 12];
const NEAR: [usize; 4] = [1, 7, 14, 8];
const FAR: [usize; 4] = [2, 11, 13, 4];
const INNER: [usize; 4] = [5, 6, 10, 9];

/// A fan with what decides how its vertex is drawn.
struct Around {
    fan: Fan<Channels>,
    shape: Shape,
}

impl Around {
    fn regular(&self) -> bool {
        match (self.fan.closed, self.fan.faces(), self.shape) {
            (true, 4, _) => self.fan.dart.is_none(),
            (false, 2, Shape::Crease) | (false, 1, Shape::Corner) => true,
            _ => false,
        }
    }

    fn rule(&self) -> CornerRule {
        if self.shape == Shape::Corner {
            CornerRule::Sharp
        } else {
            CornerRule::Smooth
        }
    }

    /// Valence that face points count with.
    fn valence(&self) -> f64 {
        match (self.fan.closed, self.fan.faces()) {
            (true, n) => n as f64,
            (false, 1) => 4.0,
            (false, k) => 2.0 * k as f64,
        }
    }

    fn limit(&self) -> Channels {
        match self.shape {
            Shape::Corner => self.fan.centre,
            _ => limit::limit(&self.fan, self.rule()),
        }
    }
}

impl Builder<'_> {
    fn at(&self, h: u32) -> Channels {
        self.value[h as usize]
    }

    fn push(&mut self, c: Channels) -> u32 {
        self.made.control.push([c.p.x, c.p.y, c.p.z, c.b, c.n.x, c.n.y, c.n.z, 0.0]);
        self.made.control.len() as u32 - 1
    }

    /// Everything around the origin of `h`, in the region of `h`.
    fn around(&self, h: u32) -> Around {
        let level = self.level;
        let v = level.origin[h as usize];
        let shape = shape(level.sharp_edges[v as usize], level.corner_sharpness(v) > 0.0);
        let ends = match level.sharp_edges[v as usize] {
            0 | 1 => None,
            _ => region_ends(level, h, |g| level.is_sharp(g)),
        };
        let mut fan = Fan { centre: self.at(h), closed: ends.is_none(), ..Fan::default() };
        let [first, last] = ends.unwrap_or_else(|| [level.spoke[v as usize], NONE]);
        let mut g = first;
        loop {
            let next = level.next(g);
            let mut far = self.at(next);
            if fan.closed {
                far = (far + self.at(level.twin[g as usize])) * 0.5;
                if level.is_sharp(g) {
                    fan.dart = Some(fan.spoke.len());
                }
            }
            let opposite = self.at(level.next(next));
            fan.half_edge.push(g);
            fan.spoke.push(far);
            fan.opposite.push(opposite);
            fan.face.push((self.at(g) + self.at(next) + opposite + self.at(level.prev(g))) * 0.25);
            if g == last {
                break;
            }
            match level.spoke_after(g) {
                Some(after) if after != first => g = after,
                _ => break,
            }
        }
        if !fan.closed {
            fan.spoke.push(self.at(level.prev(g)));
        }
        Around { fan, shape }
    }

    /// Bezier point near the vertex of `around` on the edge of `h`, which leaves it or (`reverse`) comes to it in its
    /// face.
    fn near(&self, around: &Around, h: u32, reverse: bool) -> Channels {
        let level = self.level;
        let (here, there) = if reverse { (level.next(h), h) } else { (h, level.next(h)) };
        let (v, w) = (self.at(here), self.at(there));
        if level.is_sharp(h) {
            return v * (2.0 / 3.0) + w * (1.0 / 3.0);
        }
        if around.regular() {
            let t = level.twin[h as usize];
            let (hv, hw) = (self.at(level.prev(h)), self.at(level.next(level.next(h))));
            let (tw, tv) = (self.at(level.prev(t)), self.at(level.next(level.next(t))));
            let (beside, far) = if reverse { (hw + tw, hv + tv) } else { (hv + tv, hw + tw) };
            return (v * 8.0 + w * 4.0 + beside * 2.0 + far) * (1.0 / 18.0);
        }
        let fan = &around.fan;
        // The spoke along the edge: that of the half-edge that leaves the vertex.
        let leaving = if reverse { level.twin[h as usize] } else { h };
        let j = fan.half_edge.iter().position(|&g| g == leaving).unwrap_or(fan.faces());
        if around.shape == Shape::Corner {
            return fan.centre * (2.0 / 3.0) + fan.spoke[j] * (1.0 / 3.0);
        }
        limit::edge_point(fan, j, around.rule())
    }

    fn corner(&mut self, h: u32, around: &Around) -> u32 {
        let wedge = self.live.of[h as usize] as usize;
        if self.corner[wedge] == NONE {
            self.corner[wedge] = self.push(around.limit());
        }
        self.corner[wedge]
    }

    fn edge(&mut self, h: u32, ends: [&Around; 2]) -> [u32; 2] {
        if self.edge[h as usize][0] == NONE {
            let points = [self.near(ends[0], h, false), self.near(ends[1], h, true)];
            let made = points.map(|p| self.push(p));
            self.edge[h as usize] = made;
            if !self.level.is_sharp(h) {
                self.edge[self.level.twin[h as usize] as usize] = [made[1], made[0]];
            }
        }
        self.edge[h as usize]
    }

    fn face(&mut self, f: u32) {
        let h: [u32; 4] = std::array::from_fn(|i| 4 * f + i as u32);
        let around = h.map(|h| self.around(h));
        let q = h.map(|h| self.at(h));
        let mut ids = [0; 20];
        for i in 0..4 {
            ids[CORNER[i]] = self.corner(h[i], &around[i]);
            [ids[NEAR[i]], ids[FAR[i]]] = self.edge(h[i], [&around[i], &around[(i + 1) % 4]]);
        }
        if around.iter().all(Around::regular) {
            for i in 0..4 {
                let inner = (q[i] * 4.0 + (q[(i + 1) % 4] + q[(i + 3) % 4]) * 2.0 + q[(i + 2) % 4]) * (1.0 / 9.0);
                ids[INNER[i]] = self.push(inner);
            }
            let mut bicubic = [0; 16];
            bicubic.copy_from_slice(&ids[..16]);
            self.made.bicubic.push((bicubic, f));
            return;
        }
        for i in 0..4 {
            let before = (i + 3) % 4;
            // Along the edge that leaves the corner, and along the one that ends there.
            let plus = [ids[CORNER[i]], ids[NEAR[i]], ids[FAR[i]]];
            let minus = [ids[CORNER[i]], ids[FAR[before]], ids[NEAR[before]]];
            let valence = |j: usize| [around[i].valence(), around[j].valence()];
            let f_plus = self.face_point(h[i], false, plus, valence((i + 1) % 4));
            let f_minus = self.face_point(h[i], true, minus, valence(before));
            ids[INNER[i]] = self.push(f_plus);
            ids[16 + i] = self.push(f_minus);
        }
        self.made.gregory.push((ids, f));
    }

    fn face_point(&self, h: u32, reverse: bool, bezier: [u32; 3], valence: [f64; 2]) -> Channels {
        let level = self.level;
        let edge = if reverse { level.prev(h) } else { h };
        let own = if reverse { level.next(h) } else { level.prev(h) };
        let end = if reverse { edge } else { level.next(h) };
        let centre = |h: u32| {
            let n = level.next(h);
            (self.at(h) + self.at(n) + self.at(level.next(n)) + self.at(level.prev(h))) * 0.25
        };
        let twin = (!level.is_sharp(edge)).then(|| level.twin[edge as usize]);
        let beyond = twin.map(|t| if reverse { level.prev(t) } else { level.next(level.next(t)) });
        let [corner, near, far] = bezier.map(|i| {
            let [x, y, z, b, nx, ny, nz, _] = self.made.control[i as usize];
            Channels { p: DVec3::new(x, y, z), n: DVec3::new(nx, ny, nz), b }
        });
        face_point(&Edge {
            v: self.at(h),
            corner,
            near,
            far,
            own: self.at(own),
            other: beyond.map(|g| self.at(g)),
            end: self.at(end),
            centre: centre(h),
            across: twin.map_or(centre(h), centre),
            valence,
        })
    }
}
