//! What the device makes of coarse triangles against the CPU, and the seams between them bit by bit.

use crate::command::Failure;
use crate::gpu::{Gpu, PatternFrame, PatternMethod, PatternScene as Drawn};
use crate::pattern::detail::place;
use crate::pattern::evaluate::evaluate;
use crate::pattern::RefinementPattern;
use glam::Vec3;
use std::collections::HashMap;

/// What was found.
#[derive(Clone, Copy, Debug, Default)]
pub struct Twin {
    /// Vertices looked at.
    pub vertices: usize,
    /// Greatest distance of the device's positions from the CPU's, model units.
    pub worst: f64,
    /// Edges that two coarse triangles share.
    pub shared: usize,
    /// Vertices on them that only one side has.
    pub parted: usize,
}

impl Twin {
    /// Both together.
    pub fn and(self, other: Twin) -> Twin {
        Twin {
            vertices: self.vertices + other.vertices,
            // NaN stays.
            worst: if other.worst > self.worst || other.worst.is_nan() { other.worst } else { self.worst },
            shared: self.shared + other.shared,
            parted: self.parted + other.parted,
        }
    }
}

/// A triangle's pattern, and the positions of its vertices.
type Refined = (u32, Vec<[f32; 3]>);

/// Reads back what `frame` draws, by the pattern or between levels of detail, and compares. `corners`: those of each
/// triangle, for the seams.
pub fn compare(gpu: &Gpu, drawn: &Drawn, corners: &[[u32; 3]], frame: &PatternFrame) -> Result<Twin, Failure> {
    let mut twin = Twin::default();
    let mut measure = |t: usize, weights: [f32; 3], found: [f32; 3]| {
        let point = evaluate(&drawn.controls[t], drawn.evaluator, drawn.displacement, weights.map(f64::from));
        let distance = (Vec3::from(found).as_dvec3() - point.position).length();
        twin = twin.and(Twin { vertices: 1, worst: distance, ..Twin::default() });
    };
    let mut refined: Vec<Refined> = Vec::with_capacity(corners.len());
    if frame.detail.is_some() && matches!(frame.method, PatternMethod::Instanced | PatternMethod::Indirect) {
        let mut patterns: HashMap<u32, RefinementPattern> = HashMap::new();
        for t in gpu.evaluate_detail(drawn, frame)? {
            let n = 1 << t.levels.pattern();
            if let std::collections::hash_map::Entry::Vacant(entry) = patterns.entry(n) {
                entry.insert(RefinementPattern::triangle(n).map_err(Failure::input)?);
            }
            for (&w, point) in patterns[&n].weights.iter().zip(&t.points) {
                measure(t.triangle as usize, place(w, n, &t.levels), point[0]);
            }
            refined.push((n, t.points.iter().map(|p| p[0]).collect()));
        }
    } else {
        let records = gpu.evaluate_pattern(drawn, frame)?;
        let each = drawn.pattern.weights.len();
        for (t, points) in records.chunks(each).enumerate() {
            for (&w, point) in drawn.pattern.weights.iter().zip(points) {
                measure(t, w, point[0]);
            }
            refined.push((drawn.pattern.level, points.iter().map(|p| p[0]).collect()));
        }
    }
    let (shared, parted) = seams(corners, &refined);
    Ok(Twin { shared, parted, ..twin })
}

/// Edges that two triangles share, and the vertices along them that only one side has, bit for bit.
fn seams(corners: &[[u32; 3]], refined: &[Refined]) -> (usize, usize) {
    let at = |i: u32, j: u32| (i * (i + 1) / 2 + j) as usize;
    // Bits along edge e from its first corner; vertices that meet count once.
    let along = |t: usize, e: usize| {
        let (n, points) = &refined[t];
        let mut all: Vec<[u32; 3]> = (0..=*n)
            .map(|k| match e {
                0 => at(k, 0),
                1 => at(*n, k),
                _ => at(n - k, n - k),
            })
            .map(|i| points[i].map(f32::to_bits))
            .collect();
        all.dedup();
        all
    };
    let mut seen: HashMap<[u32; 2], (usize, usize)> = HashMap::new();
    let (mut shared, mut parted) = (0, 0);
    for (t, v) in corners.iter().enumerate().take(refined.len()) {
        for e in 0..3 {
            let (a, b) = (v[e], v[(e + 1) % 3]);
            let Some((other, f)) = seen.insert([a.min(b), a.max(b)], (t, e)) else { continue };
            shared += 1;
            let (here, mut there) = (along(t, e), along(other, f));
            if corners[other][f] != a {
                there.reverse();
            }
            let same = here.iter().zip(&there).filter(|(p, q)| p == q).count();
            parted += here.len().max(there.len()) - same;
        }
    }
    (shared, parted)
}
