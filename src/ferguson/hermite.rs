//! One-dimensional cubics in Hermite and Bezier form. Everything in two dimensions here is made of these.
//!
//! A Hermite cubic is `[p0, m0, m1, p1]`: value and derivative at 0, derivative and value at 1 (BLHK18 eq. 2). A Bezier
//! cubic is its four control points (eq. 1). [`bezier`] and [`hermite`] are eq. 3 and its inverse.

use std::ops::{Add, Mul, Sub};

/// What a cubic may have as values: a number, a point, a colour.
pub trait Linear: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> {}
impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>> Linear for T {}

/// Bezier points of a Hermite cubic.
pub fn bezier<T: Linear>([p0, m0, m1, p1]: [T; 4]) -> [T; 4] {
    [p0, p0 + m0 * (1.0 / 3.0), p1 - m1 * (1.0 / 3.0), p1]
}

/// Hermite data of a Bezier cubic (eq. 3).
pub fn hermite<T: Linear>([a, b, c, d]: [T; 4]) -> [T; 4] {
    [a, (b - a) * 3.0, (d - c) * 3.0, d]
}

/// Value and derivative of a Hermite cubic: the stencils of Fig. 7, for any parameter.
pub fn sample<T: Linear>([p0, m0, m1, p1]: [T; 4], t: f64) -> [T; 2] {
    let s = 1.0 - t;
    let value = p0 * (s * s * (1.0 + 2.0 * t)) + m0 * (s * s * t) - m1 * (s * t * t) + p1 * (t * t * (3.0 - 2.0 * t));
    let slope = (p1 - p0) * (6.0 * s * t) + m0 * (s * (1.0 - 3.0 * t)) + m1 * (t * (3.0 * t - 2.0));
    [value, slope]
}

/// Both halves of a Hermite cubic at `t`, each over [0, 1].
pub fn split<T: Linear>(q: [T; 4], t: f64) -> [[T; 4]; 2] {
    let [p, m] = sample(q, t);
    let s = 1.0 - t;
    [[q[0], q[1] * t, m * t, p], [p, m * s, q[2] * s, q[3]]]
}

/// The Hermite cubic that [`split`] makes these two halves of, if they are halves of one cubic at all.
pub fn join<T: Linear>(left: [T; 4], right: [T; 4], t: f64) -> [T; 4] {
    [left[0], left[1] * (1.0 / t), right[2] * (1.0 / (1.0 - t)), right[3]]
}

/// One step towards `b`; exact at 0 and 1.
fn mix<T: Linear>(a: T, b: T, t: f64) -> T {
    a * (1.0 - t) + b * t
}

/// Point of a Bezier cubic by de Casteljau's steps.
pub fn point<T: Linear>(q: [T; 4], t: f64) -> T {
    halves(q, t)[0][3]
}

/// Both halves of a Bezier cubic at `t`.
pub fn halves<T: Linear>([a, b, c, d]: [T; 4], t: f64) -> [[T; 4]; 2] {
    let (ab, bc, cd) = (mix(a, b, t), mix(b, c, t), mix(c, d, t));
    let (abc, bcd) = (mix(ab, bc, t), mix(bc, cd, t));
    let middle = mix(abc, bcd, t);
    [[a, ab, abc, middle], [middle, bcd, cd, d]]
}

/// The part of a Bezier cubic over [from, to], as a cubic over [0, 1]: handles scaled as in Fig. 12.
pub fn restrict<T: Linear>(q: [T; 4], from: f64, to: f64) -> [T; 4] {
    match (from == 0.0, to == 1.0) {
        (true, true) => q,
        (true, false) => halves(q, to)[0],
        (false, true) => halves(q, from)[1],
        _ => halves(halves(q, to)[0], from / to)[1],
    }
}

/// The same cubic from its other end.
pub fn reverse<T: Copy>([a, b, c, d]: [T; 4]) -> [T; 4] {
    [d, c, b, a]
}

#[cfg(test)]
mod tests {
    use super::*;

    const Q: [f64; 4] = [0.3, -1.2, 2.5, 0.9];

    #[test]
    fn forms_agree_and_come_back() {
        for t in [0.0, 0.2, 0.5, 0.71, 1.0] {
            assert!((sample(Q, t)[0] - point(bezier(Q), t)).abs() < 1e-15);
        }
        let again = hermite(bezier(Q));
        assert!(Q.iter().zip(again).all(|(a, b)| (a - b).abs() < 1e-15));
    }

    #[test]
    fn a_split_is_the_same_curve_and_joins_again() {
        for t in [0.5, 0.3] {
            let [left, right] = split(Q, t);
            for k in 0..=10 {
                let x = f64::from(k) / 10.0;
                assert!((sample(left, x)[0] - sample(Q, t * x)[0]).abs() < 1e-15);
                assert!((sample(right, x)[0] - sample(Q, t + (1.0 - t) * x)[0]).abs() < 1e-15);
            }
            assert!(join(left, right, t).iter().zip(Q).all(|(a, b)| (a - b).abs() < 1e-15));
        }
    }

    #[test]
    fn a_half_has_its_end_handle_halved() {
        let q = bezier(Q);
        let half = restrict(q, 0.0, 0.5);
        assert_eq!(half[1] - half[0], (q[1] - q[0]) * 0.5);
        let inner = restrict(q, 0.25, 0.75);
        assert!((point(inner, 0.5) - point(q, 0.5)).abs() < 1e-15);
    }
}
