//! How far patches are from the limit surface, and how N_B crosses their edges.

use super::exact::Exact;
use super::level::Level;
use super::patch_eval::{point, Point};
use super::patches::Patches;
use crate::camera::bounds;
use crate::mesh::NONE;
use crate::patch::Kind;

/// What samples on a grid of every patch, sides included, have found. Lists are of bicubic, then Gregory patches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Accuracy {
    /// Patches.
    pub patches: [usize; 2],
    /// Greatest distance of the same parameter on the limit surface, over the diagonal of the level's box.
    pub distance: [f64; 2],
    /// Its mean.
    pub mean_distance: [f64; 2],
    /// Greatest angle between N_L and the limit's normal, degrees.
    pub angle: [f64; 2],
    /// Greatest angle between N_B on both sides of an edge that is not sharp, degrees.
    pub jump: f64,
}

/// Samples `patches` of `level` at 2^`steps` + 1 parameters in each direction; `power`: of the blend weight.
pub fn measure(level: &Level, patches: &Patches, steps: u32, power: f64) -> Accuracy {
    let exact = Exact::new(level, steps);
    let size = bounds(level.position.iter().copied()).map_or(1.0, |[low, high]| (high - low).length());
    let size = size.max(f64::MIN_POSITIVE);
    let n = exact.segments();
    let mut found = Accuracy { patches: [patches.bicubic.len(), patches.gregory.len()], ..Accuracy::default() };
    let mut sides: Vec<Vec<Point>> = vec![Vec::new(); level.half_edges()];
    let mut samples = [0.0f64; 2];
    for (kind, control, f) in patches.iter() {
        let k = usize::from(kind == Kind::Gregory);
        let step = |i: u32| f64::from(i) / f64::from(n);
        let grid: Vec<Point> = (0..=n)
            .flat_map(|j| (0..=n).map(move |i| (i, j)))
            .map(|(i, j)| point(kind, &control, step(i), step(j), power))
            .collect();
        let at = |i: u32, j: u32| grid[(j * (n + 1) + i) as usize];
        for (j, i) in (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))) {
            let (position, normal) = exact.limit(f, i, j);
            let distance = (at(i, j).position - position).length() / size;
            found.distance[k] = found.distance[k].max(distance);
            found.mean_distance[k] += distance;
            samples[k] += 1.0;
            found.angle[k] = found.angle[k].max(at(i, j).geometric.angle_between(normal).to_degrees());
        }
        for i in 0..=n {
            for (e, p) in [at(i, 0), at(n, i), at(n - i, n), at(0, n - i)].into_iter().enumerate() {
                sides[4 * f as usize + e].push(p);
            }
        }
    }
    for (mean, samples) in found.mean_distance.iter_mut().zip(samples) {
        *mean /= samples.max(1.0);
    }
    for (h, side) in sides.iter().enumerate() {
        let t = level.twin[h];
        if t != NONE && !level.is_sharp(h as u32) {
            for (a, b) in side.iter().zip(sides[t as usize].iter().rev()) {
                found.jump = found.jump.max(a.blended.angle_between(b.blended).to_degrees());
            }
        }
    }
    found
}
