//! Folds: where a patch turns over, so that the surface covers a place twice.
//!
//! Two answers are proofs and need no samples.
//!
//! * [`gd01`] is the sufficient test of GD01 (ZHHK22 5.2): no control vector along u is parallel to one along v, all
//!   pairs turning the same way. In the plane the cones that GD01 puts around the vectors of either direction are
//!   separate exactly then. Such a patch is injective as a whole: between two points of the domain the surface moves by
//!   du times a mean of the one cone plus dv times a mean of the other, which vanish together only.
//! * [`jacobian_sign`] cuts the domain into rectangles until the same test holds in each, or finds a point where the
//!   Jacobian is not positive.
//!
//! # Gregory patches
//! ZHHK22 tests the bicubic in place of the Gregory patch and may miss a fold there. It need not: the derivatives of the
//! rational form lie in a hull of control vectors too. Take corner A, where `F = f- + t (f+ - f-)`, `t = u / (u + v)`.
//! The derivative of F along u is `v / (u + v)^2 (f+ - f-)`. Its weight in `dS/du` is that of F,
//! `3 u (1 - u)^2 B_1(v)`, and the weight of the control vector `F - P` that ends in F is `3 (1 - u)^2 B_1(v)`:
//! together they are this weight times `f- + (t + t (1 - t)) (f+ - f-) - P`, and `2 t - t^2` goes from 0 to 1 as t does.
//! So `dS/du` is a convex combination of three times the control vectors with either `f+` or `f-` at each inner point;
//! in the outer vectors of a row the share is `2 t - t^2`, in the middle ones t. The other corners and v follow by turns.

use crate::patch::build::face_control;
use crate::patch::{eval, ControlPoint, Face, Kind, PatchTable};
use crate::subdiv::level::Level;

/// What is known of the sign of a patch's Jacobian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JacobianSign {
    /// Positive everywhere, proved.
    Positive,
    /// Zero or negative at this point (u, v) of the domain.
    Folded([f64; 2]),
    /// Neither was found within the rectangles allowed.
    Undecided,
}

/// A control vector of a derivative with the radius within which the true one may lie: x, y, r.
type Vector = [f64; 3];

/// Relative slack for rounding.
const SLACK: f64 = 1e-12;

/// Inner points of corners A to D and, for Gregory patches, the second ones: slots of f+ and f-.
const INNER: [(usize, usize); 4] = [(5, 16), (6, 17), (10, 18), (9, 19)];

fn corner_of(slot: usize) -> Option<usize> {
    INNER.iter().position(|&(plus, _)| plus == slot)
}

/// Slot of step `k` of line `l`: along u the lines are rows, along v columns.
fn slot(along_v: bool, l: usize, k: usize) -> usize {
    if along_v {
        4 * k + l
    } else {
        4 * l + k
    }
}

/// True when the test of GD01 holds: the patch is injective. `orientation` is 1 where faces run counter-clockwise in the
/// plane, -1 where clockwise. A sufficient test: patches that fail it may be injective all the same.
///
/// # Panics
/// When there are fewer points than [`Kind::points`].
pub fn gd01(kind: Kind, points: &[ControlPoint], orientation: f64) -> bool {
    let [along_u, along_v] = [false, true].map(|along_v| {
        let mut vectors: Vec<Vector> = Vec::with_capacity(22);
        for l in 0..4 {
            for k in 0..3 {
                for from in choices(kind, slot(along_v, l, k)).into_iter().flatten() {
                    for to in choices(kind, slot(along_v, l, k + 1)).into_iter().flatten() {
                        let (a, b) = (&points[from], &points[to]);
                        vectors.push([b[0] - a[0], b[1] - a[1], 0.0]);
                    }
                }
            }
        }
        vectors
    });
    apart(&along_u, &along_v, orientation)
}

/// The control points that may stand at a slot.
fn choices(kind: Kind, slot: usize) -> [Option<usize>; 2] {
    match corner_of(slot) {
        Some(corner) if kind == Kind::Gregory => [Some(slot), Some(INNER[corner].1)],
        _ => [Some(slot), None],
    }
}

/// Whether every vector of `a` turns into every one of `b` the right way, however they lie within their radii.
fn apart(a: &[Vector], b: &[Vector], orientation: f64) -> bool {
    a.iter().all(|p| {
        let long = p[0].hypot(p[1]);
        b.iter().all(|q| {
            let other = q[0].hypot(q[1]);
            let cross = orientation * (p[0] * q[1] - p[1] * q[0]);
            cross > p[2] * other + q[2] * long + p[2] * q[2] + SLACK * long * other
        })
    })
}

/// Jacobian determinant of the position at (u, v): negative where a counter-clockwise patch is turned over.
pub fn jacobian(kind: Kind, points: &[ControlPoint], u: f64, v: f64) -> f64 {
    let s = eval::face_sample(kind, points, u, v);
    s.du[0] * s.dv[1] - s.du[1] * s.dv[0]
}

/// Share of the direction's own inner point at corner `c` over a rectangle u0, v0, u1, v1: least and greatest.
fn share(c: usize, along_v: bool, [u0, v0, u1, v1]: [f64; 4]) -> [f64; 2] {
    let right = c == 1 || c == 2;
    let top = c >= 2;
    let u = if right { [1.0 - u1, 1.0 - u0] } else { [u0, u1] };
    let v = if top { [1.0 - v1, 1.0 - v0] } else { [v0, v1] };
    let (own, other) = if along_v { (v, u) } else { (u, v) };
    let part = |x: f64, y: f64, at_corner: f64| if x + y > 0.0 { x / (x + y) } else { at_corner };
    [part(own[0], other[1], 0.0), part(own[1], other[0], 1.0)]
}

/// Control vectors of a derivative that serve all points of a rectangle, 3 a line.
fn vectors(kind: Kind, points: &[ControlPoint], along_v: bool, rectangle: [f64; 4]) -> [[Vector; 3]; 4] {
    // The inner points f+ and f- of a corner: along u, A and C own f+; along v, B and D do.
    let end = |slot: usize, outer: bool| -> Vector {
        let corner = corner_of(slot).filter(|_| kind == Kind::Gregory);
        let Some(c) = corner else {
            return [points[slot][0], points[slot][1], 0.0];
        };
        let (plus, minus) = (&points[INNER[c].0], &points[INNER[c].1]);
        let (own, other) = if (c % 2 == 0) != along_v { (plus, minus) } else { (minus, plus) };
        let t = share(c, along_v, rectangle).map(|t| if outer { t * (2.0 - t) } else { t });
        let (mid, half) = (0.5 * (t[0] + t[1]), 0.5 * (t[1] - t[0]));
        let d = [own[0] - other[0], own[1] - other[1]];
        [other[0] + mid * d[0], other[1] + mid * d[1], half * d[0].hypot(d[1])]
    };
    std::array::from_fn(|l| {
        std::array::from_fn(|k| {
            let outer = k != 1;
            let (a, b) = (end(slot(along_v, l, k), outer), end(slot(along_v, l, k + 1), outer));
            [b[0] - a[0], b[1] - a[1], a[2] + b[2]]
        })
    })
}

fn mix(a: Vector, b: Vector, t: f64) -> Vector {
    std::array::from_fn(|i| a[i] + t * (b[i] - a[i]))
}

/// Bernstein coefficients of a polynomial over [t0, t1] from those over [0, 1]: convex combinations, so radii go along.
fn restrict<const N: usize>(p: [Vector; N], t0: f64, t1: f64) -> [Vector; N] {
    // Coefficient k is the blossom at t0 (N - 1 - k times) and t1 (k times).
    std::array::from_fn(|k| {
        let mut q = p;
        for step in 1..N {
            let t = if step <= k { t1 } else { t0 };
            for i in 0..N - step {
                q[i] = mix(q[i], q[i + 1], t);
            }
        }
        q[0]
    })
}

/// Twelve vectors, restricted to the rectangle: `own` the interval along the vectors, `other` across the lines.
fn restricted(net: &[[Vector; 3]; 4], own: [f64; 2], other: [f64; 2]) -> [Vector; 12] {
    let lines = net.map(|line| restrict(line, own[0], own[1]));
    let mut out = [[0.0; 3]; 12];
    for k in 0..3 {
        let across = restrict([lines[0][k], lines[1][k], lines[2][k], lines[3][k]], other[0], other[1]);
        for (l, vector) in across.into_iter().enumerate() {
            out[4 * k + l] = vector;
        }
    }
    out
}

/// Sign of the Jacobian all over a patch. At most `rectangles` are looked at; 1000 decide all but patches whose Jacobian
/// touches zero. `orientation` as in [`gd01`].
///
/// # Panics
/// When there are fewer points than [`Kind::points`].
pub fn jacobian_sign(kind: Kind, points: &[ControlPoint], orientation: f64, rectangles: usize) -> JacobianSign {
    let mut waiting = std::collections::VecDeque::from([[0.0, 0.0, 1.0, 1.0]]);
    for _ in 0..rectangles {
        let Some(rectangle) = waiting.pop_front() else {
            return JacobianSign::Positive;
        };
        let [u0, v0, u1, v1]: [f64; 4] = rectangle;
        let (u, v) = (0.5 * (u0 + u1), 0.5 * (v0 + v1));
        for at in [[u, v], [u0, v0], [u1, v0], [u1, v1], [u0, v1]] {
            // Corners of Gregory patches are left out: there the derivative is a limit that depends on the way.
            let corner = at.iter().all(|&x| x == 0.0 || x == 1.0);
            if !(corner && kind == Kind::Gregory) && orientation * jacobian(kind, points, at[0], at[1]) <= 0.0 {
                return JacobianSign::Folded(at);
            }
        }
        let along_u = restricted(&vectors(kind, points, false, rectangle), [u0, u1], [v0, v1]);
        let along_v = restricted(&vectors(kind, points, true, rectangle), [v0, v1], [u0, u1]);
        if !apart(&along_u, &along_v, orientation) {
            waiting.extend([[u0, v0, u, v], [u, v0, u1, v], [u, v, u1, v1], [u0, v, u, v1]]);
        }
    }
    if waiting.is_empty() {
        JacobianSign::Positive
    } else {
        JacobianSign::Undecided
    }
}

/// Orientation of every face of M^0, 1 or -1: that of the component it belongs to, by the component's area. A face that
/// is turned over as a whole is so told from one in a component that runs the other way.
pub fn orientations(zero: &Level) -> Vec<f64> {
    let mut out = vec![0.0; zero.faces()];
    for seed in 0..zero.faces() as u32 {
        if out[seed as usize] != 0.0 {
            continue;
        }
        let (mut faces, mut area) = (vec![seed], 0.0);
        out[seed as usize] = 1.0;
        let mut next = 0;
        while next < faces.len() {
            for h in zero.of_face(faces[next]) {
                area += zero.position(h).perp_dot(zero.position(zero.next(h)));
                if let Some(g) = zero.across(h).map(|t| zero.face_of(t)).filter(|&g| out[g as usize] == 0.0) {
                    out[g as usize] = 1.0;
                    faces.push(g);
                }
            }
            next += 1;
        }
        if area < 0.0 {
            faces.iter().for_each(|&f| out[f as usize] = -1.0);
        }
    }
    out
}

/// The face of M^0 that a drawn face lies in.
pub fn base_face(zero: &Level, face: &Face) -> u32 {
    base_of_name(zero, face.level, face.name)
}

/// The face of M^0 that the face `name` of `level` lies in.
pub fn base_of_name(zero: &Level, level: u32, name: u64) -> u32 {
    if level == 0 {
        name as u32
    } else {
        // A half-edge's slot is its number at level 0, and every level adds two bits.
        zero.face_of((name >> (2 * (level - 1))) as u32)
    }
}

/// A drawn face that is turned over somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fold {
    /// Number in [`PatchTable::faces`].
    pub face: usize,
    /// A point of its domain where the Jacobian is not positive.
    pub uv: [f64; 2],
    /// Where that is in the model.
    pub position: [f64; 2],
}

/// The drawn faces by what is known of them.
#[derive(Clone, Debug, Default)]
pub struct Folds {
    /// Faces that pass [`gd01`].
    pub gd01: usize,
    /// Faces that do not, but whose Jacobian was proved to be positive.
    pub positive: usize,
    /// Faces that are turned over somewhere.
    pub folded: Vec<Fold>,
    /// Numbers of the faces of which neither was shown.
    pub undecided: Vec<usize>,
}

/// Looks at every drawn face. `zero` is M^0.
pub fn folds(table: &PatchTable, zero: &Level) -> Folds {
    let orientations = orientations(zero);
    let mut found = Folds::default();
    for (i, face) in table.faces.iter().enumerate() {
        let points = face_control(table, face);
        let orientation = orientations[base_face(zero, face) as usize];
        if gd01(face.kind, &points, orientation) {
            found.gd01 += 1;
            continue;
        }
        match jacobian_sign(face.kind, &points, orientation, 1000) {
            JacobianSign::Positive => found.positive += 1,
            JacobianSign::Undecided => found.undecided.push(i),
            JacobianSign::Folded(uv) => {
                let at = eval::face(face.kind, &points, uv[0], uv[1]);
                found.folded.push(Fold { face: i, uv, position: [at[0], at[1]] });
            }
        }
    }
    found
}

/// Least sine of the angle from the u to the v direction of all patches, at n x n points inside each: 1 where parameter
/// lines are perpendicular, 0 where they touch, negative where the patch is turned over. `None` without patches.
pub fn least_sine(table: &PatchTable, zero: &Level, n: u32) -> Option<f64> {
    let orientations = orientations(zero);
    let mut least: Option<f64> = None;
    for face in &table.faces {
        let points = face_control(table, face);
        let orientation = orientations[base_face(zero, face) as usize];
        for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
            let [u, v] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(n));
            let s = eval::face_sample(face.kind, &points, u, v);
            let size = s.du[0].hypot(s.du[1]) * s.dv[0].hypot(s.dv[1]);
            let cross = orientation * (s.du[0] * s.dv[1] - s.du[1] * s.dv[0]);
            let sine = if size > 0.0 { cross / size } else { 0.0 };
            least = Some(least.map_or(sine, |l| l.min(sine)));
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timing::random::Random;

    /// A face over the unit square with every point moved by up to `spread`.
    fn face(kind: Kind, spread: f64, random: &mut Random) -> Vec<ControlPoint> {
        (0..kind.points())
            .map(|i| {
                let at = [5, 6, 10, 9].get(i.wrapping_sub(16)).copied().unwrap_or(i);
                let mut p = [0.0; 8];
                p[0] = (at % 4) as f64 / 3.0 + spread * (random.below(2001) as f64 / 1000.0 - 1.0);
                p[1] = (at / 4) as f64 / 3.0 + spread * (random.below(2001) as f64 / 1000.0 - 1.0);
                p
            })
            .collect()
    }

    fn least_sample(kind: Kind, points: &[ControlPoint]) -> f64 {
        let at = |i: usize| (i as f64 + 0.5) / 40.0;
        (0..1600).map(|i| jacobian(kind, points, at(i % 40), at(i / 40))).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn what_is_proved_holds_at_samples_and_what_is_found_is_there() {
        let mut random = Random::new(7);
        for kind in [Kind::Bicubic, Kind::Gregory] {
            let (mut passed, mut positive, mut folded) = (0, 0, 0);
            for i in 0..400 {
                let points = face(kind, 0.02 + 0.0008 * f64::from(i), &mut random);
                let least = least_sample(kind, &points);
                if gd01(kind, &points, 1.0) {
                    passed += 1;
                    assert!(least > 0.0);
                }
                match jacobian_sign(kind, &points, 1.0, 1000) {
                    JacobianSign::Positive => {
                        positive += 1;
                        assert!(least > 0.0, "{kind:?} {i}: {least}");
                    }
                    JacobianSign::Folded([u, v]) => {
                        folded += 1;
                        assert!(jacobian(kind, &points, u, v) <= 0.0);
                        assert!(!gd01(kind, &points, 1.0));
                    }
                    JacobianSign::Undecided => panic!("{kind:?} {i}: undecided, least sample {least}"),
                }
            }
            assert!(passed > 20 && positive > passed + 20 && folded > 50, "{kind:?}: {passed}, {positive}, {folded}");
        }
    }

    /// The hull of the module's derivation, at the points themselves: no rectangle, no slack.
    #[test]
    fn derivatives_of_gregory_patches_are_means_of_control_vectors() {
        let mut random = Random::new(3);
        let points = face(Kind::Gregory, 0.2, &mut random);
        for (u, v) in [(0.3, 0.2), (0.9, 0.05), (0.5, 0.5), (0.01, 0.99), (0.7, 0.6)] {
            let s = eval::face_sample(Kind::Gregory, &points, u, v);
            for (along_v, derivative) in [(false, s.du), (true, s.dv)] {
                let net = vectors(Kind::Gregory, &points, along_v, [u, v, u, v]);
                let (own, other) = if along_v { (v, u) } else { (u, v) };
                let at = restricted(&net, [own; 2], [other; 2])[0];
                assert!(at[2] < 1e-15);
                assert!((3.0 * at[0] - derivative[0]).abs() < 1e-13 && (3.0 * at[1] - derivative[1]).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn a_mirrored_patch_is_folded_and_has_the_other_orientation() {
        let mut random = Random::new(1);
        for kind in [Kind::Bicubic, Kind::Gregory] {
            let mut points = face(kind, 0.02, &mut random);
            points.iter_mut().for_each(|p| p[0] = -p[0]);
            assert!(!gd01(kind, &points, 1.0) && gd01(kind, &points, -1.0));
            assert!(matches!(jacobian_sign(kind, &points, 1.0, 100), JacobianSign::Folded(_)));
        }
    }
}
