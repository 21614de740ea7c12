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

/// The inverse of [`into_child`].
pub fn from_child(s: u32, u: f64, v: f64) -> [f64; 2] {
    match s {
        0 => [0.5 * u, 0.5 * v],
        1 => [1.0 - 0.5 * v, 0.5 * u],
        2 => [1.0 - 0.5 * u, 1.0 - 0.5 * v],
        _ => [0.5 * v, 1.0 - 0.5 * u],
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

/// One face with what its surface depends on, refined as samples ask for it.
pub struct ExactFace {
    shape: Shape,
    corners: CornerRule,
}

enum Shape {
    /// Control points of a regular face.
    Regular(Box<[[Value; 4]; 4]>),
    /// An irregular face, and its four children once a sample has asked for them.
    Irregular { level: Box<Level>, face: u32, children: Option<Box<[ExactFace; 4]>> },
}

impl ExactFace {
    /// The limit over quad `face` of level `level` of a refinement. That the face is drawn there is not asked, but
    /// edits of finer levels are not seen. A regular face costs its control points, an irregular one a copy of the level.
    pub fn new(refinement: &Refinement, level: usize, face: u32) -> ExactFace {
        ExactFace::of(&refinement.levels[level], face, refinement.corners)
    }

    fn of(level: &Level, face: u32, corners: CornerRule) -> ExactFace {
        let shape = if irregular_face(level, face, corners, Rules::Gradtess) {
            // Names take two bits a level, so they would overflow on the way down. Nothing here needs them.
            let level = Box::new(Level { face: vec![0; level.faces()], ..level.clone() });
            Shape::Irregular { level, face, children: None }
        } else {
            Shape::Regular(Box::new(spline_net(level, face)))
        };
        ExactFace { shape, corners }
    }

    /// Limit position and colour at (u, v) of the face. Over a regular face (u, v) may lie a little outside [0, 1]: the
    /// polynomial goes on.
    pub fn at(&mut self, u: f64, v: f64) -> Value {
        self.descend(u, v, DEEPEST)
    }

    fn descend(&mut self, u: f64, v: f64, steps: u32) -> Value {
        let corners = self.corners;
        match &mut self.shape {
            Shape::Regular(net) => sum(net, basis(u), basis(v)),
            Shape::Irregular { level, face, children } => {
                let s = quarter(u, v);
                if steps == 0 {
                    return corner(level, level.first(*face) + s, corners);
                }
                let [u, v] = into_child(s, u, v);
                let children = children.get_or_insert_with(|| {
                    let mut wanted = vec![false; level.faces()];
                    wanted[*face as usize] = true;
                    let next = catmull_clark::refine(level, &wanted, corners);
                    let first = level.first(*face);
                    Box::new([0, 1, 2, 3].map(|s| ExactFace::of(&next, level.child[(first + s) as usize], corners)))
                });
                children[s as usize].descend(u, v, steps - 1)
            }
        }
    }
}

/// Limit at the vertex that half-edge `h` leaves.
fn corner(level: &Level, h: u32, corners: CornerRule) -> Value {
    let (mut p, mut c) = (Fan::default(), Fan::default());
    position_fan(level, h, &mut p);
    colour_fan(level, h, &mut c);
    Value { p: limit(&p, corners), c: limit(&c, corners) }
}

/// The 4 by 4 control points of a regular face.
fn spline_net(level: &Level, face: u32) -> [[Value; 4]; 4] {
    let first = level.first(face);
    let positions = net(level, first, |h| level.position(h), |h| level.across(h).is_none());
    let colours = net(level, first, |h| level.corner_colour(h), |h| level.colour_border(h));
    std::array::from_fn(|r| std::array::from_fn(|k| Value { p: positions[r][k], c: colours[r][k] }))
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

fn sum(net: &[[Value; 4]; 4], bu: [f64; 4], bv: [f64; 4]) -> Value {
    let mut out = Value::default();
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
