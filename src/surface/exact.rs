//! The limit surface itself at dyadic parameters of a level's quads: vertices of a finer level, moved to their limits.

use super::level::Level;
use super::limit::{limit_normal, limit_value, shape};
use super::part::step;
use glam::DVec3;

/// Some faces of a level, some steps finer.
pub struct Exact {
    finer: Level,
    /// For each step, the finer face at the corner of each half-edge of a face that was refined.
    child: Vec<Vec<u32>>,
}

impl Exact {
    /// Refines `faces` of `level` (quads, Catmull-Clark, with all their neighbours) by `steps`.
    pub fn new(level: &Level, faces: &[bool], steps: u32) -> Exact {
        let (mut finer, mut child, mut faces) = (level.clone(), Vec::new(), faces.to_vec());
        for _ in 0..steps {
            let done = step(&finer, &faces);
            child.push(done.from.inside);
            (finer, faces) = (done.next, done.owned);
        }
        Exact { finer, child }
    }

    /// Samples along each side of a face, less one.
    pub fn segments(&self) -> u32 {
        1 << self.child.len()
    }

    /// Half-edge of the finer level that leaves the point (i, j) of face `f`, in that face; i along the face's first
    /// half-edge, both from 0 to [`Exact::segments`].
    pub fn corner(&self, f: u32, i: u32, j: u32) -> u32 {
        let (mut f, mut at, mut n) = (f, [i, j], self.segments());
        let mut steps = self.child.iter();
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
            // The child quad of h has the same corner first and the same sense.
            let Some(child) = steps.next() else { return h };
            (f, at, n) = (child[h as usize], local, n / 2);
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
