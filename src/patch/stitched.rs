//! Stitched patches (BLHK18 6.2): bicubics that meet shorter neighbours at T-sections without cracks.
//!
//! Points 0 to 15 are the face. Points 16 + 4 e to 19 + 4 e are the *curve* that side e runs along, in the curve's own
//! direction, which is the same for everything along it. A side that covers all of its curve, as the side across does, is
//! *free*: its level is found by the control shader and may be a fraction. Every other side is *stitched*: the curve is
//! divided into an even number `n` of segments, with a whole and even number of them for each side along it, and a vertex
//! on it has the number K of a segment's end. Whichever patch it belongs to, it is evaluated at the parameter of K on the
//! four points of the curve, so that all patches along it get the same bits.
//!
//! What a stitched side has to know stands in the unused channels z, w, r, g, b, a of its four curve points, see
//! [`Stitch`]; that it is stitched is said by z = 1 in the inner point of the corner where it begins (5, 6, 10, 9).
//! Twin of `glsl/inc/stitch.glsl`.

use super::eval::{bernstein, cubic, FACE_EDGES};
use super::ControlPoint;

/// Inner point of the corner where each side begins.
pub const INNER: [usize; 4] = [5, 6, 10, 9];

/// Most (K, t) pairs that a side has room for.
pub const MOST_KNOTS: usize = 10;

/// A side that is stitched.
#[derive(Clone, Debug, PartialEq)]
pub struct Stitch {
    /// Numbers K on the curve where the side begins and ends; the first is greater when it runs against the curve.
    pub range: [u32; 2],
    /// Segments of the whole curve.
    pub segments: u32,
    /// Where segments of other lengths begin: (K, t) of all ends of sides along the curve within the range, ascending;
    /// empty: all segments are equal, t = K / segments.
    pub knots: Vec<(u32, f64)>,
}

impl Stitch {
    /// Tessellation level of the side.
    pub fn level(&self) -> u32 {
        self.range[0].abs_diff(self.range[1])
    }

    /// The 24 numbers that go into the curve points.
    fn numbers(&self) -> [f64; 24] {
        let mut d = [0.0; 24];
        d[0] = f64::from(self.range[0]);
        d[1] = f64::from(self.range[1]);
        d[2] = f64::from(self.segments);
        d[3] = self.knots.len() as f64;
        for (i, &(k, t)) in self.knots.iter().take(MOST_KNOTS).enumerate() {
            (d[4 + 2 * i], d[5 + 2 * i]) = (f64::from(k), t);
        }
        d
    }

    /// Puts the side's numbers into the four points of its curve.
    pub fn write(&self, curve: &mut [ControlPoint; 4]) {
        for (point, numbers) in curve.iter_mut().zip(self.numbers().chunks_exact(6)) {
            point[2..8].copy_from_slice(numbers);
        }
    }

    /// Reads a side of a patch; `None` where it is free.
    ///
    /// # Panics
    /// When `points` are fewer than 32.
    pub fn read(points: &[ControlPoint], side: usize) -> Option<Stitch> {
        if points[INNER[side]][2] != 1.0 {
            return None;
        }
        let d: Vec<f64> = points[16 + 4 * side..][..4].iter().flat_map(|p| p[2..8].to_vec()).collect();
        let knots = (0..d[3] as usize).map(|i| (d[4 + 2 * i] as u32, d[5 + 2 * i])).collect();
        Some(Stitch { range: [d[0] as u32, d[1] as u32], segments: d[2] as u32, knots })
    }

    /// Parameter t of K on the curve, and 1 - t. CPU twin of `stitch_parameter`.
    pub fn parameter(&self, k: u32) -> [f64; 2] {
        let n = f64::from(self.segments);
        if self.knots.is_empty() {
            return [f64::from(k) / n, f64::from(self.segments - k) / n];
        }
        let at = self.knots.iter().rposition(|&(knot, _)| knot <= k).unwrap_or(0);
        let (k0, t0) = self.knots[at];
        if k == k0 || at + 1 == self.knots.len() {
            return [t0, 1.0 - t0];
        }
        let (k1, t1) = self.knots[at + 1];
        let d = f64::from(k1 - k0);
        let t = (t0 * f64::from(k1 - k) + t1 * f64::from(k - k0)) / d;
        [t, 1.0 - t]
    }

    /// Number on the curve of vertex `k` of the side, counted from where the side begins.
    pub fn number(&self, k: u32) -> u32 {
        if self.range[0] < self.range[1] {
            self.range[0] + k
        } else {
            self.range[0] - k
        }
    }
}

/// A vertex of a stitched patch as the evaluation shader makes it; `coord` are the tessellator's u and v, `outer` the
/// levels of sides 0 to 3.
///
/// # Panics
/// When `points` are fewer than 32.
pub fn vertex(points: &[ControlPoint], outer: [f64; 4], [u, v]: [f64; 2]) -> ControlPoint {
    let on = [v == 0.0, u == 1.0, v == 1.0, u == 0.0];
    let along = [u, v, 1.0 - u, 1.0 - v];
    let corner = (0..4).find(|&i| on[i] && on[(i + 3) & 3]);
    if let Some(i) = corner {
        let own = points[FACE_EDGES[i][0]];
        let sides = [(i, 0), ((i + 3) & 3, outer[(i + 3) & 3] as u32)];
        for (side, k) in sides {
            if let Some(stitch) = Stitch::read(points, side) {
                let number = stitch.number(k);
                if number > 0 && number < stitch.segments {
                    return place(own, on_curve(points, side, &stitch, number));
                }
            }
        }
        return place(own, own);
    }
    if let Some(side) = (0..4).find(|&i| on[i]) {
        let q = FACE_EDGES[side].map(|i| &points[i]);
        return match Stitch::read(points, side) {
            None => {
                let k = (along[side] * 65536.0 + 0.5).floor();
                let p = cubic(bernstein((65536.0 - k) / 65536.0, k / 65536.0), q);
                place(p, p)
            }
            Some(stitch) => {
                let n = f64::from(stitch.level());
                let k = (along[side] * n + 0.5).floor();
                let number = stitch.number(k as u32);
                let local = local_parameter(&stitch, number, k, n);
                let colour = cubic(bernstein(1.0 - local, local), q);
                place(colour, on_curve(points, side, &stitch, number))
            }
        };
    }
    let p = super::eval::face(super::Kind::Bicubic, points, u, v);
    place(p, p)
}

/// Parameter on the side itself, for its colours: equal steps unless the segments are not equal.
fn local_parameter(stitch: &Stitch, number: u32, k: f64, n: f64) -> f64 {
    if stitch.knots.is_empty() {
        return k / n;
    }
    let (t, a, b) =
        (stitch.parameter(number)[0], stitch.parameter(stitch.range[0])[0], stitch.parameter(stitch.range[1])[0]);
    (t - a) / (b - a)
}

fn on_curve(points: &[ControlPoint], side: usize, stitch: &Stitch, number: u32) -> ControlPoint {
    let [t, s] = stitch.parameter(number);
    let first = 16 + 4 * side;
    cubic(bernstein(s, t), [0, 1, 2, 3].map(|j| &points[first + j]))
}

/// Colour of one and position of the other.
fn place(colour: ControlPoint, position: ControlPoint) -> ControlPoint {
    let mut out = colour;
    (out[0], out[1], out[2], out[3]) = (position[0], position[1], 0.0, 0.0);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stitch() -> Stitch {
        Stitch { range: [12, 4], segments: 16, knots: vec![(4, 0.25), (6, 0.3), (12, 0.75)] }
    }

    #[test]
    fn what_is_written_reads_back() {
        let mut points = vec![[0.0; 8]; 32];
        points[INNER[2]][2] = 1.0;
        let mut curve = [[0.5; 8]; 4];
        stitch().write(&mut curve);
        points[24..28].copy_from_slice(&curve);
        assert_eq!(Stitch::read(&points, 2), Some(stitch()));
        assert_eq!(Stitch::read(&points, 1), None);
    }

    #[test]
    fn parameters_meet_the_knots_and_rise_between() {
        let s = stitch();
        assert_eq!((s.parameter(4)[0], s.parameter(6)[0], s.parameter(12)[0]), (0.25, 0.3, 0.75));
        assert!((s.parameter(5)[0] - 0.275).abs() < 1e-15 && (s.parameter(9)[0] - 0.525).abs() < 1e-15);
        assert_eq!((s.level(), s.number(0), s.number(8)), (8, 12, 4));
        let even = Stitch { range: [0, 8], segments: 32, knots: Vec::new() };
        assert_eq!(even.parameter(8), [0.25, 0.75]);
    }
}
