//! The limit surface itself at dyadic parameters of a level's quads or triangles: vertices of a finer level, moved to their limits.

use super::level::{Level, Scheme};
use super::limit::{limit_normal, limit_value, shape};
use super::part::step;
use crate::mesh::NONE;
use glam::DVec3;

/// Some faces of a level, some steps finer.
pub struct Exact {
    finer: Level,
    /// For each step, the finer face at the corner of each half-edge of a face that was refined; of triangles, the one in
    /// the middle follows those at the corners.
    child: Vec<Vec<u32>>,
}

impl Exact {
    /// Refines `faces` of `level` (quads of Catmull-Clark or triangles of Loop, with all their neighbours) by `steps`.
    pub fn new(level: &Level, faces: &[bool], steps: u32) -> Exact {
        let (mut finer, mut child, mut faces) = (level.clone(), Vec::new(), faces.to_vec());
        for _ in 0..steps {
            let done = step(&finer, &faces);
            let inside = &done.from.inside;
            child.push(
                (0..inside.len() as u32)
                    .map(|h| if inside[h as usize] == NONE { NONE } else { done.child(h) })
                    .collect(),
            );
            (finer, faces) = (done.next, done.owned);
        }
        Exact { finer, child }
    }

    /// Samples along each side of a face, less one.
    pub fn segments(&self) -> u32 {
        1 << self.child.len()
    }

    /// Half-edge of the finer level that leaves the point (i, j) of face `f`, in that face; i along the face's first
    /// half-edge, both from 0 to [`Exact::segments`]. In a triangle, j runs along the half-edge that ends in its first
    /// corner, backwards, and i + j is at most [`Exact::segments`].
    pub fn corner(&self, f: u32, i: u32, j: u32) -> u32 {
        if self.finer.scheme == Scheme::Loop {
            return self.triangle_corner(f, i, j);
        }
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

    fn triangle_corner(&self, f: u32, i: u32, j: u32) -> u32 {
        let n = self.segments();
        // Weights of the three corners, which sum to n.
        let (mut f, mut at, mut n) = (f, [n - i - j, i, j], n);
        for child in &self.child {
            let corner = child[3 * f as usize];
            n /= 2;
            (f, at) = match (0..3).find(|&k| at[k] >= n) {
                Some(k) => (corner + k as u32, [at[k] - n, at[(k + 1) % 3], at[(k + 2) % 3]]),
                // The middle's corners are opposite to the face's third, first and second.
                None => (corner + 3, [n - at[2], n - at[0], n - at[1]]),
            };
        }
        3 * f + (0..3).find(|&k| at[k] > 0).unwrap_or(0) as u32
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
