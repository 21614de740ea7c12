//! Refinement patterns (BS05 3.2): a tessellated triangle whose vertices are barycentric weights.

use super::PatternError;

/// Greatest level of a pattern.
pub const MAX_LEVEL: u32 = 128;

/// A tessellated triangle or quad, made once and drawn for every coarse triangle.
#[derive(Clone, Debug, PartialEq)]
pub struct RefinementPattern {
    /// Segments along each side.
    pub level: u32,
    /// Weights (w, u, v) of each vertex, at corners 0, 1, 2; each is a quotient rounded once, so that two triangles
    /// get the same weights along a shared edge.
    pub weights: Vec<[f32; 3]>,
    /// Three vertices a triangle, in the orientation of the coarse triangle.
    pub indices: Vec<u32>,
}

fn check(level: u32) -> Result<(), PatternError> {
    match (1..=MAX_LEVEL).contains(&level) {
        true => Ok(()),
        false => Err(PatternError::Level(level)),
    }
}

impl RefinementPattern {
    /// The triangular lattice with `level` segments a side: (n + 1)(n + 2) / 2 vertices, n^2 triangles. Row i holds the
    /// vertices with u + v = i / n, ordered by v.
    ///
    /// # Errors
    /// The level is out of range.
    pub fn triangle(level: u32) -> Result<RefinementPattern, PatternError> {
        check(level)?;
        let n = level;
        let part = |k: u32| k as f32 / n as f32;
        let weights = (0..=n).flat_map(|i| (0..=i).map(move |j| [part(n - i), part(i - j), part(j)])).collect();
        let at = |i: u32, j: u32| i * (i + 1) / 2 + j;
        let triangles = bands(n).flat_map(|(from, to)| {
            (0..n).flat_map(move |i| {
                (from..to.min(i + 1)).flat_map(move |j| {
                    let up = [at(i, j), at(i + 1, j), at(i + 1, j + 1)];
                    let down = [at(i, j), at(i + 1, j + 1), at(i, j + 1)];
                    [Some(up), (j < i).then_some(down)]
                })
            })
        });
        Ok(RefinementPattern { level, weights, indices: triangles.flatten().flatten().collect() })
    }

    /// The grid with `level` segments a side, as BS05 Fig. 7 counts it: (n + 1)^2 vertices, 2 n^2 triangles, those of the
    /// first column without area. On a coarse triangle the square's left side is corner 0: w = 1 - s, u = s (1 - t),
    /// v = s t.
    ///
    /// # Errors
    /// The level is out of range.
    pub fn quad(level: u32) -> Result<RefinementPattern, PatternError> {
        check(level)?;
        let n = level;
        let part = |k: u32, of: u32| k as f32 / of as f32;
        let weights = (0..=n)
            .flat_map(|i| (0..=n).map(move |j| [part(n - i, n), part(i * (n - j), n * n), part(i * j, n * n)]))
            .collect();
        let at = |i: u32, j: u32| i * (n + 1) + j;
        let triangles = bands(n).flat_map(|(from, to)| {
            (0..n).flat_map(move |i| {
                (from..to).flat_map(move |j| {
                    [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
                })
            })
        });
        Ok(RefinementPattern { level, weights, indices: triangles.flatten().collect() })
    }

    /// Triangles.
    pub fn triangles(&self) -> usize {
        self.indices.len() / 3
    }

    /// Bytes on the device: weights as three floats, indices as words.
    pub fn bytes(&self) -> usize {
        12 * self.weights.len() + 4 * self.indices.len()
    }

    /// Vertices that a first-in first-out cache of `size` entries misses, over triangles: 3 at worst, about 0.5 at best.
    pub fn cache_misses(&self, size: usize) -> f64 {
        let mut cache = std::collections::VecDeque::with_capacity(size + 1);
        let mut misses = 0;
        for &i in &self.indices {
            if !cache.contains(&i) {
                misses += 1;
                cache.push_back(i);
                if cache.len() > size {
                    cache.pop_front();
                }
            }
        }
        f64::from(misses) / self.triangles().max(1) as f64
    }
}

/// Columns are walked in bands so narrow that a row of one is still in the vertex cache when the next row needs it.
fn bands(n: u32) -> impl Iterator<Item = (u32, u32)> {
    const WIDTH: u32 = 12;
    (0..n.div_ceil(WIDTH)).map(move |b| (b * WIDTH, ((b + 1) * WIDTH).min(n)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_follow_the_formulas_and_weights_sum_to_one() {
        for n in 1..=MAX_LEVEL {
            let p = RefinementPattern::triangle(n).unwrap();
            assert_eq!((p.weights.len() as u32, p.triangles() as u32), ((n + 1) * (n + 2) / 2, n * n));
            let q = RefinementPattern::quad(n).unwrap();
            assert_eq!((q.weights.len() as u32, q.triangles() as u32), ((n + 1) * (n + 1), 2 * n * n));
            for w in p.weights.iter().chain(&q.weights) {
                assert!((w[0] + w[1] + w[2] - 1.0).abs() < 2e-7 && w.iter().all(|&x| x >= 0.0));
            }
        }
        assert_eq!(RefinementPattern::quad(64).unwrap().weights.len(), 4225);
        assert_eq!(RefinementPattern::quad(128).unwrap().weights.len(), 16641);
        assert_eq!(RefinementPattern::triangle(0), Err(PatternError::Level(0)));
        assert_eq!(RefinementPattern::quad(129), Err(PatternError::Level(129)));
    }

    #[test]
    fn triangles_tile_the_domain_once_with_one_orientation() {
        for n in [1, 2, 7, 64, 128] {
            for p in [RefinementPattern::triangle(n).unwrap(), RefinementPattern::quad(n).unwrap()] {
                let area: f64 = p
                    .indices
                    .chunks(3)
                    .map(|t| {
                        let [a, b, c] = [0, 1, 2].map(|k| p.weights[t[k] as usize].map(f64::from));
                        let twice = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
                        assert!(twice > -1e-9, "turned over");
                        twice
                    })
                    .sum();
                assert!((area - 1.0).abs() < 1e-5, "{area}");
            }
        }
    }

    #[test]
    fn a_small_vertex_cache_is_enough() {
        let p = RefinementPattern::triangle(64).unwrap();
        assert!(p.cache_misses(32) < 0.62, "{}", p.cache_misses(32));
        assert!(RefinementPattern::quad(64).unwrap().cache_misses(32) < 0.62);
    }
}
