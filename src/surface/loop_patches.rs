//! The limit of Loop's scheme as quartic triangles: 15 Bezier points of a regular face, exact; 18 of a Gregory triangle for
//! every other (after LSNC09).
//!
//! A vertex is *regular* inside six smooth faces, on a crease or boundary in a region of three, as a corner in a region of
//! one. Beyond sharp edges there are phantom points: the third corner mirrored, `a + b - c`, and around a corner whatever
//! makes its ring symmetric; with them Loop's smooth rules are the sharp ones, so such faces are box splines, too.
//!
//! Gregory triangles: edges between regular vertices, and what lies beside them, are exact. Other edges are cubics C by
//! limits and tangents T of their ends. On both sides of one, derivatives towards the third corner are `alpha C' / 2 + r`
//! and `alpha C' / 2 - r`, with alpha linear from `2 c_0` to `2 - 2 c_1`, where `T_(i-1) + T_(i+1) = 2 c T_i` around an end:
//! the tangent planes agree all along. r is a cubic; its inner points are `(r_0 + c - d) / 3` and `(r_3 + c - d) / 3` with
//! the third corners c and d, which is right at regular ends.

use super::adaptive::{Fate, Part};
use super::control_points::{ControlPoints, Scratch};
use super::level::Level;
use super::limit::{loop_across_weights, shape, Shape};
use super::patches::{Patches, Place, QuarticTransition};
use super::stencil::{loop_weight, region_ends};
use super::term::Term;
use crate::mesh::NONE;
use crate::patch::quartic::{CORNERS, INNER, SIDES};
use std::f64::consts::{PI, TAU};

/// Patches of all drawn faces of `parts` into `made`.
pub(super) fn of_parts(parts: &[Part], made: &mut Patches, scratch: &mut Scratch) {
    let mut finer: Option<Shared> = None;
    for part in parts.iter().rev() {
        let level = &part.level;
        let mut shared = Shared {
            corner: vec![NONE; part.live.len()],
            vertex: vec![NONE; level.vertices()],
            edge: vec![[NONE; 3]; level.half_edges()],
        };
        if let Some(finer) = &finer {
            let next = &parts[level.depth as usize + 1];
            for (h, &child) in part.child.iter().enumerate().filter(|(_, &child)| child != NONE) {
                // A limit is the same on all levels; its one control point makes it the same bits.
                let c = 3 * child as usize;
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
                points: ControlPoints::new(part, scratch, made),
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
}

/// Control points of a level that several patches have.
struct Shared {
    /// Of each wedge.
    corner: Vec<u32>,
    /// Of each vertex, that of any of its wedges: they lie in the same place.
    vertex: Vec<u32>,
    /// Of each half-edge's edge: near its origin, in the middle, near its end.
    edge: Vec<[u32; 3]>,
}

struct Builder<'a> {
    level: &'a Level,
    part: &'a Part,
    points: ControlPoints<'a>,
    shared: Shared,
    /// The next level.
    finer: Option<(&'a Shared, &'a Part)>,
}

/// Subdominant eigenvalue around a smooth vertex of valence `n`.
fn shrinking(n: f64) -> f64 {
    0.375 + 0.25 * (TAU / n).cos()
}

/// Length of a tangent of valence `n` for that of the ring. It is free; twice what the ring shrinks to in a step is right in
/// the plane. Another, which below valence 6 tends to 0, puts the middles of edges where the characteristic map has them.
/// Half-way between them neither the surface nor its parameters are far off.
pub(super) fn reach(n: usize) -> f64 {
    if n == 6 {
        return 1.0;
    }
    let n = n as f64;
    let (lambda, c2) = (shrinking(n), (TAU / n).cos());
    // The second ring of the map, whose first has radius 1: between spokes (its part along one), and on them. The former is
    // 3/4 cos^2(pi / n) / (lambda - 1/8), whose denominator is cos^2(pi / n) / 2, so that valence 2 has it too.
    let between = 1.5;
    let on = (0.625 + (c2 + between) / 8.0) / (lambda - 0.0625);
    // Limit of the first ring, and its derivative outwards.
    let limit = 0.5 + (2.0 * c2 + on + 2.0 * between) / 12.0;
    let slope = (on + between - c2) / 3.0;
    let (step, middle) = (2.0 * lambda * limit, 8.0 * limit * (lambda - 0.5) + slope);
    0.5 * (step + middle)
}

/// What lies around a vertex in a region.
struct Around<'a> {
    centre: Term<'a>,
    /// Far ends of the edges, counter-clockwise; one more than faces unless closed.
    spoke: Vec<Term<'a>>,
    closed: bool,
    /// Closed, with a sharp edge or more.
    dart: bool,
    shape: Shape,
    /// Where the face that asked is: between this spoke and the next.
    at: usize,
}

impl<'a> Around<'a> {
    fn faces(&self) -> usize {
        self.spoke.len() - usize::from(!self.closed)
    }

    fn regular(&self) -> bool {
        match (self.closed, self.faces(), self.shape) {
            (true, 6, Shape::Smooth) => !self.dart,
            (false, 3, Shape::Crease) | (false, 1, Shape::Corner) => true,
            _ => false,
        }
    }

    /// Spoke `at` plus `j`, of a regular vertex with its phantoms.
    fn ring(&self, j: usize) -> Term<'a> {
        let (v, s) = (self.centre, &self.spoke);
        match ((self.at + j) % 6, s.len()) {
            (i, n) if i < n => s[i],
            (4, 4) => v + s[3] - s[2],
            (5, n) => v + s[0] - if n == 4 { s[1] } else { s[n - 1] },
            (2, _) => v + s[1] - s[0],
            (3, _) => v * 2.0 - s[0],
            _ => v * 2.0 - s[1],
        }
    }

    /// Inner point of the face, of a regular vertex.
    fn inner(&self) -> Term<'a> {
        let r = |j| self.ring(j);
        (self.centre * 10.0 + (r(0) + r(1)) * 6.0 + r(2) + r(5)) * (1.0 / 24.0)
    }

    fn limit(&self) -> Term<'a> {
        let (v, s) = (self.centre, &self.spoke);
        match self.shape {
            Shape::Corner => v,
            Shape::Crease => (v * 4.0 + (s[0] + s[s.len() - 1])) * (1.0 / 6.0),
            Shape::Smooth => {
                let n = s.len() as f64;
                let w = 1.0 / (0.375 / loop_weight(n) + n);
                let sum = s.iter().fold(Term::default(), |sum, &s| sum + s);
                v * (1.0 - n * w) + sum * w
            }
        }
    }

    /// Derivative along the edge that leaves the corner in the face (0) or the one that ends there (1).
    fn tangent(&self, side: usize) -> Term<'a> {
        let (v, s, j) = (self.centre, &self.spoke, (self.at + side) as f64);
        let sum = |weight: &dyn Fn(f64) -> f64| {
            s.iter().enumerate().fold(Term::default(), |sum, (i, &s)| sum + s * weight(i as f64))
        };
        let n = s.len() as f64;
        if self.closed {
            let scale = 2.0 / n;
            let first = |i: f64| scale * (TAU * (i - j) / n).cos();
            return match self.shape {
                // A spike: all edges start out along its axis.
                Shape::Corner => sum(&|_| 1.0 / n) - v,
                _ => sum(&first) * reach(s.len()),
            };
        }
        let (from, to, k) = (s[0], s[s.len() - 1], self.faces());
        match self.shape {
            Shape::Corner => {
                // As if one more face made the half-turn: right for one and two faces.
                let (theta, k) = (PI / (k as f64 + 1.0), k as f64);
                ((from - v) * ((k - j) * theta).sin() + (to - v) * (j * theta).sin()) * (1.0 / (k * theta).sin())
            }
            _ => {
                let along = (from - to) * 0.5;
                if k == 1 {
                    return if j == 0.0 { along } else { along * -1.0 };
                }
                let theta = PI / k as f64;
                let [vertex, end, edge] = loop_across_weights(k);
                let inside = sum(&|i| edge * (i * theta).sin());
                let across = (v * vertex + (from + to) * end + inside) * (2.0 / k as f64 * reach(2 * k));
                along * (j * theta).cos() + across * (j * theta).sin()
            }
        }
    }

    /// c of `T_(i-1) + T_(i+1) = 2 c T_i`.
    fn cosine(&self) -> f64 {
        let k = self.faces() as f64;
        match (self.closed, self.shape) {
            (true, Shape::Corner) => 1.0,
            (true, _) => (TAU / k).cos(),
            // A ring of phantoms.
            (false, Shape::Corner) if k == 1.0 => 0.5,
            (false, Shape::Corner) => (PI / (k + 1.0)).cos(),
            (false, _) => (PI / k).cos(),
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
        let sharp = level.sharp_edges[v as usize];
        let shape = shape(sharp, level.corner_sharpness(v) > 0.0);
        let ends = if sharp < 2 { None } else { region_ends(level, h, |g| level.is_sharp(g)) };
        let closed = ends.is_none();
        let mut found = Around { centre: self.at(h), spoke: Vec::new(), closed, dart: sharp > 0, shape, at: 0 };
        let [first, last] = ends.unwrap_or([level.spoke[v as usize], NONE]);
        let mut g = first;
        loop {
            if g == h {
                found.at = found.spoke.len();
            }
            let mut far = self.at(level.next(g));
            let t = level.twin[g as usize];
            if closed && t != NONE {
                far = (far + self.at(t)) * 0.5;
            }
            found.spoke.push(far);
            if g == last {
                break;
            }
            match level.spoke_after(g) {
                Some(after) if after != first => g = after,
                _ => break,
            }
        }
        if !closed {
            found.spoke.push(self.at(level.prev(g)));
        }
        found
    }

    fn corner(&mut self, h: u32, around: &Around<'a>) -> u32 {
        let (wedge, v) = (self.part.live.of[h as usize] as usize, self.level.origin[h as usize] as usize);
        if self.shared.corner[wedge] == NONE {
            let limit = around.limit();
            let made = match self.shared.vertex[v] {
                NONE => self.points.push(limit),
                there => self.points.push_beside(there, limit),
            };
            self.shared.corner[wedge] = made;
            self.shared.vertex[v] = made;
        }
        self.shared.corner[wedge]
    }

    /// The point of a cubic near the end at `around` of an edge; `side` as in [`Around::tangent`], `far`: its other end,
    /// `limit`: of this one.
    fn near(&self, around: &Around<'a>, side: usize, sharp: bool, far: Term<'a>, limit: Term<'a>) -> Term<'a> {
        // At a dart, the end of a crease runs into the tangent plane.
        if sharp && (!around.closed || around.shape == Shape::Corner) {
            return around.centre * (2.0 / 3.0) + far * (1.0 / 3.0);
        }
        limit + around.tangent(side) * (1.0 / 3.0)
    }

    fn edge(&mut self, h: u32, ends: [&Around<'a>; 2], corners: [u32; 2]) -> [u32; 3] {
        if self.shared.edge[h as usize][0] == NONE {
            let [a, b] = ends;
            let sharp = self.level.is_sharp(h);
            let limits = corners.map(|i| self.points.point(i));
            let e0 = self.near(a, 0, sharp, b.centre, limits[0]);
            let e1 = self.near(b, 1, sharp, a.centre, limits[1]);
            let middle = if !sharp && a.regular() && b.regular() {
                ((a.centre + b.centre) * 2.0 + a.ring(1) + a.ring(5)) * (1.0 / 6.0)
            } else {
                (e0 + e1) * 0.5
            };
            let points = [limits[0] * 0.25 + e0 * 0.75, middle, limits[1] * 0.25 + e1 * 0.75];
            let t = self.level.twin[h as usize];
            let mut across = if t == NONE { [NONE; 3] } else { self.shared.edge[t as usize] };
            across.reverse();
            let made = std::array::from_fn(|k| match across[k] {
                NONE => self.points.push(points[k]),
                // The other side of a sharp edge was there before.
                there => self.points.push_beside(there, points[k]),
            });
            self.shared.edge[h as usize] = made;
            if !sharp {
                self.shared.edge[t as usize] = [made[2], made[1], made[0]];
            }
        }
        self.shared.edge[h as usize]
    }

    fn face(&mut self, f: u32) {
        let h: [u32; 3] = std::array::from_fn(|i| 3 * f + i as u32);
        let around = h.map(|h| self.around(h));
        let mut ids = [0; 18];
        for i in 0..3 {
            ids[CORNERS[i]] = self.corner(h[i], &around[i]);
        }
        for i in 0..3 {
            let j = (i + 1) % 3;
            let corners = [ids[CORNERS[i]], ids[CORNERS[j]]];
            let made = self.edge(h[i], [&around[i], &around[j]], corners);
            for (k, id) in made.into_iter().enumerate() {
                ids[SIDES[i][k + 1]] = id;
            }
        }
        let regular: [bool; 3] = std::array::from_fn(|i| around[i].regular());
        if regular == [true; 3] {
            for i in 0..3 {
                ids[INNER[i]] = self.points.push(around[i].inner());
            }
            let mut points = [0; 15];
            points.copy_from_slice(&ids[..15]);
            self.regular(f, points);
            return;
        }
        for i in 0..3 {
            let j = (i + 1) % 3;
            let [plus, minus] = if regular[i] && regular[j] {
                [around[i].inner(), around[j].inner()]
            } else {
                self.beside(h[i], [&around[i], &around[j]], SIDES[i].map(|k| ids[k]))
            };
            ids[INNER[i]] = self.points.push(plus);
            ids[15 + j] = self.points.push(minus);
        }
        self.points.made.quartic_gregory.push((ids, Place { level: self.level.depth, face: f }));
    }

    /// The two inner points beside the edge of `h`, whose own points are `side`.
    fn beside(&self, h: u32, [a, b]: [&Around<'a>; 2], side: [u32; 5]) -> [Term<'a>; 2] {
        let level = self.level;
        let q = side.map(|i| self.points.point(i));
        let cubic = [q[0], (q[1] * 4.0 - q[0]) * (1.0 / 3.0), (q[3] * 4.0 - q[4]) * (1.0 / 3.0), q[4]];
        let slope: [Term<'a>; 3] = std::array::from_fn(|i| (cubic[i + 1] - cubic[i]) * 3.0);
        let alpha = [2.0 * a.cosine(), 2.0 - 2.0 * b.cosine()];
        let g1 = (slope[0] * alpha[1] + slope[1] * (2.0 * alpha[0])) * (1.0 / 3.0);
        let g2 = (slope[1] * (2.0 * alpha[1]) + slope[2] * alpha[0]) * (1.0 / 3.0);
        let third = self.at(level.prev(h));
        let other = match level.is_sharp(h) {
            true => a.centre + b.centre - third,
            false => self.at(level.prev(level.twin[h as usize])),
        };
        let r0 = a.tangent(1) - a.tangent(0) * a.cosine();
        let r3 = b.tangent(0) - b.tangent(1) * b.cosine();
        let r = |end: Term<'a>| (end + third - other) * (1.0 / 3.0);
        [q[1] + (g1 * 0.5 + r(r0)) * 0.25, q[2] + (g2 * 0.5 + r(r3)) * 0.25]
    }

    /// A regular triangle, with the halves of sides that finer patches lie along.
    fn regular(&mut self, f: u32, points: [u32; 15]) {
        let level = self.level;
        let place = Place { level: level.depth, face: f };
        let (mut halves, mut sides, mut n) = ([points[0]; 14], 0, 0);
        for (i, side) in SIDES.into_iter().enumerate() {
            let h = 3 * f + i as u32;
            let t = level.twin[h as usize];
            if t == NONE || self.part.fate[level.face_of(t)] != Fate::Refined {
                continue;
            }
            sides |= 1 << i;
            let Some((finer, next)) = self.finer else { continue };
            // The twin runs the other way: its second half is our first.
            let second = 3 * self.part.child[t as usize];
            let first = 3 * self.part.child[level.next(t) as usize] + 2;
            let [from, to] = [finer.edge[first as usize], finer.edge[second as usize]];
            let middle = finer.corner[next.live.of[first as usize] as usize];
            let mut half = [from[2], from[1], from[0], middle, to[2], to[1], to[0]];
            if level.is_sharp(h) {
                half = self.own_side(side.map(|k| points[k]), half);
            }
            halves[n..n + 7].copy_from_slice(&half);
            n += 7;
        }
        match sides {
            0 => self.points.made.quartic.push((points, place)),
            _ => self.points.made.quartic_transition.push(QuarticTransition { points, halves, sides, place }),
        }
    }

    /// Across a sharp edge the finer points' places, with the normals of this side: those of the side's own curve, halved.
    fn own_side(&mut self, side: [u32; 5], half: [u32; 7]) -> [u32; 7] {
        let mut row = side.map(|i| self.points.point(i)).to_vec();
        let mut own = [Term::default(); 7];
        for k in 0..4 {
            row = row.windows(2).map(|w| (w[0] + w[1]) * 0.5).collect();
            own[k] = row[0];
            own[6 - k] = row[row.len() - 1];
        }
        std::array::from_fn(|k| self.points.push_beside(half[k], own[k]))
    }
}
