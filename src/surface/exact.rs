//! The limit surface itself at dyadic parameters of a level's quads: vertices of a finer level, moved to their limits.

use super::level::Level;
use super::limit::{limit_normal, limit_value, shape};
use super::refine::refine;
use glam::DVec3;

/// A level, and one some steps finer.
pub struct Exact {
    finer: Level,
    steps: u32,
}

impl Exact {
    /// Refines `level` (quads, Catmull-Clark) by `steps`.
    pub fn new(level: &Level, steps: u32) -> Exact {
        let mut finer = level.clone();
        for _ in 0..steps {
            finer = refine(&finer);
        }
        Exact { finer, steps }
    }

    /// Samples along each side of a face, less one.
    pub fn segments(&self) -> u32 {
        1 << self.steps
    }

    /// Half-edge of the finer level that leaves the point (i, j) of face `f`, in that face; i along the face's first
    /// half-edge, both from 0 to [`Exact::segments`].
    pub fn corner(&self, f: u32, i: u32, j: u32) -> u32 {
        let (mut f, mut at, mut n) = (f, [i, j], self.segments());
        loop {
            // The quadrant: coordinates from its corner, along the half-edge that leaves and the one that arrives.
            let [a, b] = at;
            let k = match (2 * a > n, 2 * b > n) {
                (false, false) => 0,
                (true, false) => 1,
                (true, true) => 2,
                (false, true) => 3,
            };
            let local = match k {
                0 => [a, b],
                1 => [b, n - a],
                2 => [n - a, n - b],
                _ => [n - b, a],
            };
            let h = 4 * f + k;
            if n == 1 {
                return h;
            }
            // The child quad of h has the same corner first and the same sense.
            (f, at, n) = (h, local, n / 2);
            if at[0] > n || at[1] > n {
                return h;
            }
        }
    }

    /// Limit position and unit normal of the surface at (i, j) of face `f`, seen from that face.
    pub fn limit(&self, f: u32, i: u32, j: u32) -> (DVec3, DVec3) {
        let (level, h) = (&self.finer, self.corner(f, i, j));
        let v = level.origin[h as usize];
        let shape = shape(level.sharp_edges[v as usize], level.corner_sharpness(v) > 0.0);
        let stops = |g: u32| level.is_sharp(g);
        let position = limit_value(level, h, shape, stops, |g| level.position[level.origin[g as usize] as usize]);
        (position, limit_normal(level, h, shape, stops))
    }
}
