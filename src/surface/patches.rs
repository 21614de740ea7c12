//! The limit surface as patches: a 16-point bicubic for every regular face, a 20-point Gregory patch for every other
//! (LSNC09), with the subdivided normal and the blend weight as further channels. Of Loop's scheme, 15-point quartic
//! triangles and 18-point Gregory ones (`loop_patches`).
//!
//! Control points are weighted sums of the vertices of levels, position, normal and weight by the same weights. Only the weights
//! are made here, and the sums where they are needed: for pictures, on the device ([`crate::patch::stencil`]).
//!
//! Edges that are sharp for ever are sides of patches: a crease, a boundary and a corner are regular where their region
//! has two faces or one. Beside finer patches, a side has the control points of the two halves that lie along it, too.

use super::adaptive::{subdivide, Depth, Fate, Part};
use super::control_points::{ControlPoints, Scratch};
use super::level::{Level, Scheme};
use super::limit::{shape, Shape};
use super::shade::Settings;
use super::stencil::region_ends;
use super::term::Term;
use crate::mesh::NONE;
use crate::patch::eval::FACE_EDGES;
use crate::patch::gregory::{face_point, Edge};
use crate::patch::stencil::StencilTable;
use crate::patch::ControlPoint;
use crate::scene::CornerRule;
use crate::subdiv::fan::Fan;
use crate::subdiv::limit;
use glam::DVec3;

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
    /// Vertices of levels that control points are sums of, one for each region: x, y, z, weight; normal, 0. Normals are unit
    /// up to the first level that may be drawn.
    pub sources: Vec<ControlPoint>,
    /// What they weigh in each control point.
    pub stencils: StencilTable,
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
    let (mut made, mut scratch) = (Patches::default(), Scratch::default());
    if parts.first().is_some_and(|part| part.level.scheme == Scheme::Loop) {
        super::loop_patches::of_parts(parts, &mut made, &mut scratch);
        return made;
    }
    let mut finer: Option<Shared> = None;
    for part in parts.iter().rev() {
        let level = &part.level;
        let mut shared = Shared {
            corner: vec![NONE; part.live.len()],
            vertex: vec![NONE; level.vertices()],
            edge: vec![[NONE; 2]; level.half_edges()],
        };
        if let Some(finer) = &finer {
            let next = &parts[level.depth as usize + 1];
            for (h, &child) in part.child.iter().enumerate().filter(|(_, &child)| child != NONE) {
                // A limit is the same on all levels; its one control point makes it the same bits.
                let c = 4 * child as usize;
                let (corner, vertex) =
                    (finer.corner[next.live.of[c] as usize], finer.vertex[next.level.origin[c] as usize]);
                if corner != NONE {
                    shared.corner[part.live.of[h] as usize] = corner;
                }
                if vertex != NONE {
                    shared.vertex[level.origin[h] as usize] = vertex;
                }
            }
        }
        if part.fate.contains(&Fate::Drawn) {
            let mut builder = Builder {
                level,
                part,
                points: ControlPoints::new(part, &mut scratch, &mut made),
                shared,
                finer: finer.as_ref().map(|shared| (shared, &parts[level.depth as usize + 1])),
            };
            for f in (0..level.faces() as u32).filter(|&f| part.fate[f as usize] == Fate::Drawn) {
                builder.face(f);
                builder.points.clear();
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
    /// Of each vertex, that of any of its wedges: they lie in the same place.
    vertex: Vec<u32>,
    /// Of each half-edge's edge, near its origin and near its end.
    edge: Vec<[u32; 2]>,
}

struct Builder<'a> {
    level: &'a Level,
    part: &'a Part,
    points: ControlPoints<'a>,
    shared: Shared,
    /// The next level.
    finer: Option<(&'a Shared, &'a Part)>,
}

/// Control points of corner i, near it on the edge that leaves it, far on that edge; inner point.
const CORNER: [usize; 4] = [0, 3, 15, 12];
const NEAR: [usize; 4] = [1, 7, 14, 8];
const FAR: [usize; 4] = [2, 11, 13, 4];
const INNER: [usize; 4] = [5, 6, 10, 9];

/// A fan with what decides how its vertex is drawn.
struct Around<'a> {
    fan: Fan<Term<'a>>,
    shape: Shape,
    /// The half-edges that leave the vertex, if it lies inside four smooth faces: then there is nothing else in the fan.
    cross: Option<[u32; 4]>,
}

impl<'a> Around<'a> {
    fn regular(&self) -> bool {
        match (self.fan.closed, self.fan.faces(), self.shape) {
            _ if self.cross.is_some() => true,
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
            _ if self.cross.is_some() => 4.0,
            (true, n) => n as f64,
            (false, 1) => 4.0,
            (false, k) => 2.0 * k as f64,
        }
    }

    fn limit(&self) -> Term<'a> {
        match self.shape {
            Shape::Corner => self.fan.centre,
            _ => limit::limit(&self.fan, self.rule()),
        }
    }
}

impl<'a> Builder<'a> {
    fn at(&self, h: u32) -> Term<'a> {
        self.points.at(h)
    }

    /// Everything around the origin of `h`, in the region of `h`.
    fn around(&self, h: u32) -> Around<'a> {
        let level = self.level;
        let v = level.origin[h as usize];
        let shape = shape(level.sharp_edges[v as usize], level.corner_sharpness(v) > 0.0);
        if shape == Shape::Smooth && level.sharp_edges[v as usize] == 0 {
            let cross = level.cross(v);
            if cross.is_some() {
                return Around { fan: Fan { closed: true, ..Fan::default() }, shape, cross };
            }
        }
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
        Around { fan, shape, cross: None }
    }

    /// Weights of the Bezier point near a regular vertex on the edge of `h`, as in [`Builder::near`].
    fn near_regular(&self, h: u32, reverse: bool) -> [(u32, f64); 6] {
        let level = self.level;
        let t = level.twin[h as usize];
        let (here, there) = if reverse { (level.next(h), h) } else { (h, level.next(h)) };
        let (hv, hw) = (level.prev(h), level.next(level.next(h)));
        let (tw, tv) = (level.prev(t), level.next(level.next(t)));
        let (beside, far) = if reverse { ([hw, tw], [hv, tv]) } else { ([hv, tv], [hw, tw]) };
        let [a, b] = beside.map(|g| (g, 2.0 / 18.0));
        let [c, d] = far.map(|g| (g, 1.0 / 18.0));
        [(here, 8.0 / 18.0), (there, 4.0 / 18.0), a, b, c, d]
    }

    /// Bezier point near the vertex of `around` on the edge of `h`, which leaves it or (`reverse`) comes to it in its
    /// face.
    fn near(&self, around: &Around<'a>, h: u32, reverse: bool) -> Term<'a> {
        let level = self.level;
        let (here, there) = if reverse { (level.next(h), h) } else { (h, level.next(h)) };
        let (v, w) = (self.at(here), self.at(there));
        // At a dart, the end of a crease runs into the tangent plane.
        if level.is_sharp(h) && !around.fan.closed {
            return v * (2.0 / 3.0) + w * (1.0 / 3.0);
        }
        if around.regular() {
            return self.near_regular(h, reverse).iter().fold(Term::default(), |sum, &(g, w)| sum + self.at(g) * w);
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

    fn corner(&mut self, h: u32, around: &Around<'a>) -> u32 {
        let (level, wedge) = (self.level, self.part.live.of[h as usize] as usize);
        if self.shared.corner[wedge] == NONE {
            let v = level.origin[h as usize] as usize;
            let made = if let Some(cross) = around.cross {
                let ring = cross.map(|g| (level.next(g), 4.0 / 36.0));
                let beyond = cross.map(|g| (level.next(level.next(g)), 1.0 / 36.0));
                let [a, b, c, d] = ring;
                let [e, f, g, i] = beyond;
                self.points.push_sum([(h, 16.0 / 36.0), a, b, c, d, e, f, g, i])
            } else {
                let limit = around.limit();
                match self.shared.vertex[v] {
                    NONE => self.points.push(limit),
                    there => self.points.push_beside(there, limit),
                }
            };
            self.shared.corner[wedge] = made;
            self.shared.vertex[v] = made;
        }
        self.shared.corner[wedge]
    }

    fn edge(&mut self, h: u32, ends: [&Around<'a>; 2]) -> [u32; 2] {
        if self.shared.edge[h as usize][0] == NONE {
            let t = self.level.twin[h as usize];
            let across = if t == NONE { [NONE; 2] } else { self.shared.edge[t as usize] };
            let made = [0, 1].map(|end| {
                let reverse = end == 1;
                if ends[end].cross.is_some() {
                    let terms = self.near_regular(h, reverse);
                    return self.points.push_sum(terms);
                }
                let point = self.near(ends[end], h, reverse);
                match across[1 - end] {
                    NONE => self.points.push(point),
                    // The other side of a sharp edge was there before.
                    there => self.points.push_beside(there, point),
                }
            });
            self.shared.edge[h as usize] = made;
            if !self.level.is_sharp(h) {
                self.shared.edge[t as usize] = [made[1], made[0]];
            }
        }
        self.shared.edge[h as usize]
    }

    fn face(&mut self, f: u32) {
        let h: [u32; 4] = std::array::from_fn(|i| 4 * f + i as u32);
        let around = h.map(|h| self.around(h));
        let mut ids = [0; 20];
        for i in 0..4 {
            ids[CORNER[i]] = self.corner(h[i], &around[i]);
            [ids[NEAR[i]], ids[FAR[i]]] = self.edge(h[i], [&around[i], &around[(i + 1) % 4]]);
        }
        if around.iter().all(|around| around.regular()) {
            for i in 0..4 {
                let weight = |k: usize, w: f64| (h[(i + k) % 4], w / 9.0);
                ids[INNER[i]] = self.points.push_sum([weight(0, 4.0), weight(1, 2.0), weight(2, 1.0), weight(3, 2.0)]);
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
            ids[INNER[i]] = self.points.push(f_plus);
            ids[16 + i] = self.points.push(f_minus);
        }
        self.points.made.gregory.push((ids, Place { level: self.level.depth, face: f }));
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
            0 => self.points.made.bicubic.push((points, place)),
            _ => self.points.made.transition.push(Transition { points, halves, sides, place }),
        }
    }

    /// Across a sharp edge the finer points' places, with the normals of this side: those of the side's own cubic, halved.
    fn own_side(&mut self, side: [u32; 4], half: [u32; 5]) -> [u32; 5] {
        let [a, b, c, d] = side.map(|i| self.points.point(i));
        let mean = |a: Term<'a>, b: Term<'a>| (a + b) * 0.5;
        let (ab, bc, cd) = (mean(a, b), mean(b, c), mean(c, d));
        let (abc, bcd) = (mean(ab, bc), mean(bc, cd));
        let own = [ab, abc, mean(abc, bcd), bcd, cd];
        std::array::from_fn(|k| self.points.push_beside(half[k], own[k]))
    }

    fn face_point(&self, h: u32, reverse: bool, bezier: [u32; 3], valence: [f64; 2]) -> Term<'a> {
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
        let [corner, near, far] = bezier.map(|i| self.points.point(i));
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
