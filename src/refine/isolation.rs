//! How many levels isolate an extraordinary vertex.
//!
//! Around a vertex of valence n the limit is its point, a linear part that shrinks by λ a level, and a rest that shrinks by
//! μ, the next eigenvalue of the subdivision matrix. A Gregory patch has the point and the tangents right, so what it
//! misses shrinks by μ: 1/4 at a regular vertex, 0.34, 0.41 and 0.46 at valences 5, 6 and 7. So that isolation by N levels
//! means the same everywhere, 4^N times less error, vertices of higher valence get more of them.

use std::f64::consts::TAU;

/// The greatest eigenvalue of Catmull-Clark subdivision at an interior vertex of valence `n` >= 3 after 1 and the two
/// that are subdominant (Ball, Storry 1988).
pub fn decay(n: u32) -> f64 {
    let valence = f64::from(n);
    // A pair of frequency f, 2 f = n alone counts once.
    let of_frequency = |f: u32| {
        let c = (TAU * f64::from(f) / valence).cos();
        let root = ((c + 1.0) * (c + 9.0)).max(0.0).sqrt();
        [(c + 5.0 + root) / 16.0, (c + 5.0 - root) / 16.0]
    };
    // Frequency 0 beside 1: both of (4 α - 1 ± sqrt((4 α - 1)^2 + 8 β - 4)) / 8, with α = 1 - 7 / (4 n) and β = 3 / (2 n^2).
    let a = 4.0 * (1.0 - 7.0 / (4.0 * valence)) - 1.0;
    let square = a * a + 12.0 / (valence * valence) - 4.0;
    let constant = match square < 0.0 {
        true => (a * a - square).sqrt() / 8.0,
        false => (a.abs() + square.sqrt()) / 8.0,
    };
    let second = of_frequency(1)[1];
    (2..=n / 2).map(|f| of_frequency(f)[0]).fold(constant.max(second), f64::max)
}

/// Levels that make the error at an interior vertex of valence `n` as many times less as `depth` do at a regular one, to
/// the nearest; no fewer than `depth`.
pub fn levels(n: u32, depth: u32) -> u32 {
    if n <= 4 {
        return depth;
    }
    let factor = 4f64.ln() / -decay(n).ln();
    depth.max((f64::from(depth) * factor).round() as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh;
    use crate::refine::{refine, Mode, Options};
    use crate::scene::Scene;
    use glam::DVec2;

    #[test]
    fn a_regular_vertex_has_a_quarter_and_others_are_as_published() {
        assert!((decay(4) - 0.25).abs() < 1e-15);
        // Valence 6: frequency 2, cos 120° = -1/2: (9/2 + sqrt(17/4)) / 16.
        assert!((decay(6) - (4.5 + 4.25f64.sqrt()) / 16.0).abs() < 1e-15);
        assert!((3..40).all(|n| decay(n) < 0.65) && (4..40).all(|n| decay(n) < decay(n + 1)));
        assert!(decay(3) < 0.25 && (decay(8) - 0.5).abs() < 1e-15);
        assert_eq!([3, 4, 5, 6, 7, 9].map(|n| levels(n, 3)), [3, 3, 4, 5, 5, 7]);
        assert_eq!([5, 6, 9].map(|n| levels(n, 1)), [1, 2, 2]);
        assert_eq!(levels(6, 0), 0);
    }

    /// What is neither point nor tangent shrinks as said: a fan whose rings carry a wave of frequency 2.
    #[test]
    fn a_wave_around_a_vertex_shrinks_by_the_eigenvalue() {
        for n in [5u32, 6, 8] {
            // A vertex in the middle, edge neighbours at even numbers, opposite corners at odd ones.
            let ring = (0..2 * n).map(|i| {
                let (r, a) = (if i % 2 == 0 { 1.0 } else { 1.3 }, TAU * f64::from(i) / f64::from(2 * n));
                (DVec2::from_angle(a) + DVec2::from_angle(2.0 * a) * 0.1) * r
            });
            let vertices: Vec<[f64; 2]> = std::iter::once(DVec2::ZERO).chain(ring).map(|p| [p.x, p.y]).collect();
            let faces: Vec<[u32; 4]> = (0..n).map(|k| [0, 2 * k + 1, 2 * k + 2, (2 * k + 2) % (2 * n) + 1]).collect();
            let text = serde_json::json!({"gradtess": 1, "name": "fan", "vertices": vertices, "faces": faces});
            let scene = Scene::parse(text.to_string().as_bytes(), "fan").unwrap();
            let mesh = mesh::build(&scene.mesh).unwrap();
            let amplitude = |level: u32| {
                let refined =
                    refine(&scene, &mesh, Options { mode: Mode::Global(level), ..Options::default() }).unwrap();
                let last = &refined.levels[level as usize];
                let at = |h: u32| last.value[last.origin[h as usize] as usize].p;
                let first = (0..last.origin.len() as u32).find(|&h| at(h).length() < 1e-12).unwrap();
                let mut spoke = first;
                let mut wave = [DVec2::ZERO; 2];
                for j in 0..n {
                    let turn = DVec2::from_angle(2.0 * TAU * f64::from(j) / f64::from(n));
                    let neighbour = at(last.next(spoke));
                    // Spokes may go round either way.
                    wave[0] += neighbour.rotate(turn);
                    wave[1] += neighbour.rotate(DVec2::new(turn.x, -turn.y));
                    spoke = last.next(last.twin[spoke as usize]);
                }
                assert_eq!(spoke, first);
                wave[0].length().max(wave[1].length())
            };
            let ratio = amplitude(5) / amplitude(4);
            assert!((ratio - decay(n)).abs() < 5e-3, "valence {n}: {ratio}, {}", decay(n));
        }
    }
}
