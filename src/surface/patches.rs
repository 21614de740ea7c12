//! The limit surface as patches: a 16-point bicubic for every regular face, a 20-point Gregory patch for every other
//! (LSNC09), with the subdivided normal and the blend weight as further channels. Of Loop's scheme, 15-point quartic
//! triangles and 18-point Gregory ones (`loop_patches`).
//!
//! Edges that are sharp for ever are sides of patches: a crease, a boundary and a corner are regular where their region
//! has two faces or one. Beside finer patches, a side has the control points of the two halves that lie along it, too.

use super::adaptive::{subdivide, Depth, Fate, Part};
use super::level::{Level, Scheme};
use super::limit::{shape, Shape};
use super::shade::Settings;
use super::stencil::region_ends;
use crate::mesh::NONE;
use crate::patch::eval::FACE_EDGES;
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

/// Where a patch is: a face of a [`Part`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Level.
    pub level: u32,
    /// Face of that level's part.
    pub face: u32,
}

/// A bicubic patch with finer neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transition {
    /// As of any bicubic.
    pub points: [u32; 16],
    /// For each side of `sides` in turn, what lies along it after its corner: two points of the first half, the middle,
    /// two points of the second half. The rest repeats a point.
    pub halves: [u32; 15],
    /// Bit i: the neighbour across side i is finer.
    pub sides: u8,
    /// Where.
    pub place: Place,
}

/// A quartic triangle with finer neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QuarticTransition {
    /// As of any quartic triangle.
    pub points: [u32; 15],
    /// For each side of `sides` in turn, what lies along it after its corner: three points of the first half, the middle,
    /// three points of the second half. The rest repeats a point.
    pub halves: [u32; 14],
    /// Bit i: the neighbour across side i is finer.
    pub sides: u8,
    /// Where.
    pub place: Place,
}

/// What a patch is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// 16 points, as in [`crate::patch`].
    Bicubic,
    /// 20 points.
    Gregory,
    /// 15 points, as in [`crate::patch::quartic`].
    Quartic,
    /// 18 points.
    QuarticGregory,
}

impl Form {
    /// Sides: 3 or 4.
    pub fn sides(self) -> usize {
        match self {
            Form::Bicubic | Form::Gregory => 4,
            Form::Quartic | Form::QuarticGregory => 3,
        }
    }

    /// Whether it stands for an irregular face.
    pub fn is_gregory(self) -> bool {
        matches!(self, Form::Gregory | Form::QuarticGregory)
    }

    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Form::Bicubic => "bicubic",
            Form::Gregory => "gregory",
            Form::Quartic => "quartic",
            Form::QuarticGregory => "quartic-gregory",
        }
    }
}

/// Patches of a surface, finest first. Control points are x, y, z, b and the normal; patches share them by index, except
/// across sharp edges, where the points differ in the normal only.
#[derive(Clone, Debug, Default)]
pub struct Patches {
    /// Control points, as in [`crate::patch`]: x, y, z, weight; normal, 0.
    pub control: Vec<ControlPoint>,
    /// Regular faces.
    pub bicubic: Vec<([u32; 16], Place)>,
    /// Regular faces with finer neighbours.
    pub transition: Vec<Transition>,
    /// The other faces, all on the last level.
    pub gregory: Vec<([u32; 20], Place)>,
    /// Regular faces of Loop's scheme.
    pub quartic: Vec<([u32; 15], Place)>,
    /// Such faces with finer neighbours.
    pub quartic_transition: Vec<QuarticTransition>,
    /// The other faces of Loop's scheme, all on the last level.
    pub quartic_gregory: Vec<([u32; 18], Place)>,
}

/// The first level that can be the last one of patches: where faces have all the scheme's number of sides, and no finite sharpness
/// is left.
pub fn first_level(control: &Level) -> u32 {
    let finite = |s: &&f64| s.is_finite();
    let sharpest = control.sharpness.iter().chain(&control.corner).filter(finite).fold(0.0f64, |a, &b| a.max(b));
    (sharpest.ceil() as u32).max(1)
}

/// Levels of `control` and their patches; `depth.last` is [`first_level`] or more. `given` as in [`super::shade::shade`].
pub fn patches(control: &Level, given: &[DVec3], settings: &Settings, depth: Depth) -> (Vec<Part>, Patches) {
    let parts = subdivide(control, given, settings, depth);
    let made = of_parts(&parts);
    (parts, made)
}

/// Patches of all drawn faces of `parts`, which are those of all levels from 0 on.
pub fn of_parts(parts: &[Part]) -> Patches {
    let mut made = Patches::default();
    if parts.first().is_some_and(|part| part.level.scheme == Scheme::Loop) {
        super::loop_patches::of_parts(parts, &mut made);
        return made;
    }
    let mut finer: Option<Shared> = None;
    for part in parts.iter().rev() {
        let level = &part.level;
        let mut shared = Shared { corner: vec![NONE; part.live.len()], edge: vec![[NONE; 2]; level.half_edges()] };
        if let Some(finer) = &finer {
            let next = &parts[level.depth as usize + 1];
            for (h, &child) in part.child.iter().enumerate().filter(|(_, &child)| child != NONE) {
                // A limit is the same on all levels; its one control point makes it the same bits.
                let id = finer.corner[next.live.of[4 * child as usize] as usize];
                if id != NONE {
                    shared.corner[part.live.of[h] as usize] = id;
                }
            }
        }
        if part.fate.contains(&Fate::Drawn) {
            let mut builder = Builder {
                level,
                part,
                value: (0..level.half_edges())
                    .map(|h| {
                        let v = level.origin[h] as usize;
                        let n = part.normal[part.live.of[h] as usize];
                        Channels { p: level.position[v], n, b: part.weight[v] }
                    })
                    .collect(),
                shared,
                finer: finer.as_ref().map(|shared| (shared, &parts[level.depth as usize + 1])),
                made: &mut made,
            };
            for f in (0..level.faces() as u32).filter(|&f| part.fate[f as usize] == Fate::Drawn) {
                builder.face(f);
            }
            shared = builder.shared;
        }
        finer = Some(shared);
    }
    made
}

/// Control points of a level that several patches have.
struct Shared {
    /// Of each wedge.
    corner: Vec<u32>,
    /// Of each half-edge's edge, near its origin and near its end.
    edge: Vec<[u32; 2]>,
}

struct Builder<'a> {
    level: &'a Level,
    part: &'a Part,
    /// At the origin of each half-edge, in the region of its face.
    value: Vec<Channels>,
    shared: Shared,
    /// The next level.
    finer: Option<(&'a Shared, &'a Part)>,
    made: &'a mut Patches,
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
        // At a dart, the end of a crease runs into the tangent plane.
        if level.is_sharp(h) && !around.fan.closed {
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
        let wedge = self.part.live.of[h as usize] as usize;
        if self.shared.corner[wedge] == NONE {
            self.shared.corner[wedge] = self.push(around.limit());
        }
        self.shared.corner[wedge]
    }

    fn edge(&mut self, h: u32, ends: [&Around; 2]) -> [u32; 2] {
        if self.shared.edge[h as usize][0] == NONE {
            let points = [self.near(ends[0], h, false), self.near(ends[1], h, true)];
            let made = points.map(|p| self.push(p));
            self.shared.edge[h as usize] = made;
            if !self.level.is_sharp(h) {
                self.shared.edge[self.level.twin[h as usize] as usize] = [made[1], made[0]];
            }
        }
        self.shared.edge[h as usize]
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
            let mut points = [0; 16];
            points.copy_from_slice(&ids[..16]);
            self.regular(f, points);
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
        self.made.gregory.push((ids, Place { level: self.level.depth, face: f }));
    }

    /// A bicubic, with the halves of sides that finer patches lie along.
    fn regular(&mut self, f: u32, points: [u32; 16]) {
        let level = self.level;
        let place = Place { level: level.depth, face: f };
        let (mut halves, mut sides, mut n) = ([points[0]; 15], 0, 0);
        for (i, side) in FACE_EDGES.into_iter().enumerate() {
            let h = 4 * f + i as u32;
            let t = level.twin[h as usize];
            if t == NONE || self.part.fate[level.face_of(t)] != Fate::Refined {
                continue;
            }
            sides |= 1 << i;
            let Some((finer, next)) = self.finer else { continue };
            // The twin runs the other way: its second half is our first.
            let second = 4 * self.part.child[t as usize];
            let first = 4 * self.part.child[level.next(t) as usize] + 3;
            let [from, to] = [finer.edge[first as usize], finer.edge[second as usize]];
            let middle = finer.corner[next.live.of[first as usize] as usize];
            let mut half = [from[1], from[0], middle, to[1], to[0]];
            if level.is_sharp(h) {
                half = self.own_side(side.map(|k| points[k]), half);
            }
            halves[n..n + 5].copy_from_slice(&half);
            n += 5;
        }
        match sides {
            0 => self.made.bicubic.push((points, place)),
            _ => self.made.transition.push(Transition { points, halves, sides, place }),
        }
    }

    /// Across a sharp edge the finer points' places, with the normals of this side: those of the side's own cubic, halved.
    fn own_side(&mut self, side: [u32; 4], half: [u32; 5]) -> [u32; 5] {
        let [a, b, c, d] = side.map(|i| self.channels(i));
        let mean = |a: Channels, b: Channels| (a + b) * 0.5;
        let (ab, bc, cd) = (mean(a, b), mean(b, c), mean(c, d));
        let (abc, bcd) = (mean(ab, bc), mean(bc, cd));
        let own = [ab, abc, mean(abc, bcd), bcd, cd];
        std::array::from_fn(|k| {
            let finer = self.channels(half[k]);
            self.push(Channels { n: own[k].n, ..finer })
        })
    }

    fn channels(&self, i: u32) -> Channels {
        let [x, y, z, b, nx, ny, nz, _] = self.made.control[i as usize];
        Channels { p: DVec3::new(x, y, z), n: DVec3::new(nx, ny, nz), b }
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
        let [corner, near, far] = bezier.map(|i| self.channels(i));
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
