//! The limit itself, by a road of its own: no patch code.
//!
//! A sample in a regular face is a uniform bicubic B-spline over the face's 4 by 4 control points. In an
//! irregular face the mesh around it is subdivided until the sample lies in a regular face; what is left after
//! [`DEEPEST`] steps lies at an extraordinary vertex to within 2^-48 of the face, whose limit point it takes.

use crate::refine::{irregular_face, Refinement, Rules};
use crate::scene::CornerRule;
use crate::subdiv::catmull_clark;
use crate::subdiv::fan::{colour_fan, position_fan, Fan, Linear};
use crate::subdiv::level::{Level, Value};
use crate::subdiv::limit::limit;

/// Steps of isolation before a sample counts as the vertex it is next to.
pub const DEEPEST: u32 = 48;

/// Where a point of a face lies in the child at its corner `s`: the child's first edge runs along edge `s`.
pub fn into_child(s: u32, u: f64, v: f64) -> [f64; 2] {
    match s {
        0 => [2.0 * u, 2.0 * v],
        1 => [2.0 * v, 2.0 * (1.0 - u)],
        2 => [2.0 * (1.0 - u), 2.0 * (1.0 - v)],
        _ => [2.0 * (1.0 - v), 2.0 * u],
    }
}

/// Corner of a quad whose quarter holds (u, v).
pub fn quarter(u: f64, v: f64) -> u32 {
    match (u < 0.5, v < 0.5) {
        (true, true) => 0,
        (false, true) => 1,
        (false, false) => 2,
        (true, false) => 3,
    }
}

/// One face with the ring that its surface depends on, refined as samples ask for it.
pub struct ExactFace {
    level: Level,
    face: u32,
    corners: CornerRule,
    regular: bool,
    children: Option<Box<[ExactFace; 4]>>,
}

impl ExactFace {
    /// The limit over quad `face` of level `level` of a refinement. That the face is drawn there is not asked, but
    /// edits of finer levels are not seen.
    pub fn new(refinement: &Refinement, level: usize, face: u32) -> ExactFace {
        ExactFace::of(refinement.levels[level].clone(), face, refinement.corners)
    }

    fn of(mut level: Level, face: u32, corners: CornerRule) -> ExactFace {
        // Names take two bits a level, so they would overflow on the way down. Nothing here needs them.
        level.face.fill(0);
        let regular = !irregular_face(&level, face, corners, Rules::Gradtess);
        ExactFace { level, face, corners, regular, children: None }
    }

    /// Limit position and colour at (u, v) of the face.
    pub fn at(&mut self, u: f64, v: f64) -> Value {
        self.descend(u, v, DEEPEST)
    }

    fn descend(&mut self, u: f64, v: f64, steps: u32) -> Value {
        if self.regular {
            return self.spline(u, v);
        }
        let s = quarter(u, v);
        if steps == 0 {
            return self.corner(s);
        }
        let [u, v] = into_child(s, u, v);
        let children = self.children.get_or_insert_with(|| {
            let mut wanted = vec![false; self.level.faces()];
            wanted[self.face as usize] = true;
            let next = catmull_clark::refine(&mut self.level, &wanted, self.corners);
            let first = self.level.first(self.face);
            Box::new([0, 1, 2, 3].map(|s| {
                let child = self.level.child[(first + s) as usize];
                ExactFace::of(next.clone(), child, self.corners)
            }))
        });
        children[s as usize].descend(u, v, steps - 1)
    }

    fn corner(&self, s: u32) -> Value {
        let h = self.level.first(self.face) + s;
        let (mut p, mut c) = (Fan::default(), Fan::default());
        position_fan(&self.level, h, &mut p);
        colour_fan(&self.level, h, &mut c);
        Value { p: limit(&p, self.corners), c: limit(&c, self.corners) }
    }

    fn spline(&self, u: f64, v: f64) -> Value {
        let level = &self.level;
        let first = level.first(self.face);
        let net_p = net(level, first, |h| level.position(h), |h| level.across(h).is_none());
        let net_c = net(level, first, |h| level.corner_colour(h), |h| level.colour_border(h));
        let (bu, bv) = (basis(u), basis(v));
        Value { p: sum(&net_p, bu, bv), c: sum(&net_c, bu, bv) }
    }
}

/// Uniform cubic B-spline basis.
fn basis(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [
        s * s * s / 6.0,
        (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
        (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
        t * t * t / 6.0,
    ]
}

fn sum<V: Linear>(net: &[[V; 4]; 4], bu: [f64; 4], bv: [f64; 4]) -> V {
    let mut out = V::default();
    for (row, wv) in net.iter().zip(bv) {
        for (value, wu) in row.iter().zip(bu) {
            out = out + *value * (wu * wv);
        }
    }
    out
}

/// The 4 by 4 control points of a regular face, rows along v; past a border, linear extrapolation of the two rows
/// inside, which is what makes the border its own cubic B-spline and a corner interpolated.
fn net<V: Linear>(level: &Level, first: u32, value: impl Fn(u32) -> V, border: impl Fn(u32) -> bool) -> [[V; 4]; 4] {
    let h = [0, 1, 2, 3].map(|i| first + i);
    let q = h.map(&value);
    let beyond = |a: V, b: V| a * 2.0 - b;
    // Across edge i: the points next to its two ends.
    let across: [[V; 2]; 4] = std::array::from_fn(|i| match level.across(h[i]) {
        Some(t) if !border(h[i]) => [value(level.next(level.next(t))), value(level.prev(t))],
        _ => [beyond(q[i], q[(i + 3) & 3]), beyond(q[(i + 1) & 3], q[(i + 2) & 3])],
    });
    // Beyond corner i, between edge i - 1 and edge i.
    let corner: [V; 4] = std::array::from_fn(|i| {
        let before = (i + 3) & 3;
        match (border(h[before]), border(h[i])) {
            (false, false) => {
                let t = level.across(h[i]).expect("no border");
                let d = level.across(level.next(t)).expect("an inner vertex");
                value(level.prev(d))
            }
            // Past the border of edge i, in the column of edge i - 1's neighbour.
            (false, true) => beyond(across[before][1], across[before][0]),
            (true, false) => beyond(across[i][0], across[i][1]),
            (true, true) => beyond(across[i][0], across[i][1]),
        }
    });
    [
        [corner[0], across[0][0], across[0][1], corner[1]],
        [across[3][1], q[0], q[1], across[1][0]],
        [across[3][0], q[3], q[2], across[1][1]],
        [corner[3], across[2][1], across[2][0], corner[2]],
    ]
}
