//! How far patches are from the limit surface, and how N_B crosses their edges.

use super::adaptive::{Fate, Part};
use super::exact::Exact;
use super::patch_eval::{point, Point};
use super::patches::Patches;
use crate::camera::bounds;
use crate::mesh::NONE;
use crate::patch::Kind;
use glam::DVec3;

/// What samples on a grid of every patch, sides included, have found. Lists are of bicubic, then Gregory patches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Accuracy {
    /// Patches.
    pub patches: [usize; 2],
    /// Greatest distance of the same parameter on the limit surface, over the diagonal of the control mesh's box.
    pub distance: [f64; 2],
    /// Its mean over samples.
    pub mean_distance: [f64; 2],
    /// Greatest distance along the limit's normal, over the diagonal: how far the surface is off, whatever its parameters.
    pub off: [f64; 2],
    /// Greatest angle between N_L and the limit's normal, degrees; where the limit has one.
    pub angle: [f64; 2],
    /// Greatest angle between N_B on both sides of an edge that is not sharp, degrees.
    pub jump: f64,
    /// Greatest distance of both sides of an edge, sharp or not, over the diagonal.
    pub gap: f64,
}

/// Samples `patches` of `parts` at 2^`steps` + 1 parameters in each direction, `steps` at least 1; `power`: of the blend
/// weight.
pub fn measure(parts: &[Part], patches: &Patches, steps: u32, power: f64) -> Accuracy {
    let drawn = |part: &Part| part.fate.iter().map(|&f| f == Fate::Drawn).collect::<Vec<bool>>();
    let exact: Vec<Option<Exact>> = parts
        .iter()
        .map(|part| part.fate.contains(&Fate::Drawn).then(|| Exact::new(&part.level, &drawn(part), steps)))
        .collect();
    let size = parts.first().and_then(|control| bounds(control.level.position.iter().copied()));
    let size = size.map_or(1.0, |[low, high]| (high - low).length()).max(f64::MIN_POSITIVE);
    let n = 1 << steps;
    let mut found = Accuracy {
        patches: [patches.bicubic.len() + patches.transition.len(), patches.gregory.len()],
        ..Accuracy::default()
    };
    let mut sides: Vec<Vec<Vec<Point>>> = parts.iter().map(|p| vec![Vec::new(); p.level.half_edges()]).collect();
    let mut samples = [0.0f64; 2];
    for patch in patches.iter() {
        let k = usize::from(patch.kind == Kind::Gregory);
        let (level, f) = (patch.place.level as usize, patch.place.face);
        let Some(exact) = &exact[level] else { continue };
        let step = |i: u32| f64::from(i) / f64::from(n);
        let grid: Vec<Point> = (0..=n)
            .flat_map(|j| (0..=n).map(move |i| (i, j)))
            .map(|(i, j)| point(patch.kind, &patch.control, step(i), step(j), power))
            .collect();
        let at = |i: u32, j: u32| grid[(j * (n + 1) + i) as usize];
        for (j, i) in (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))) {
            let (position, normal) = exact.limit(f, i, j);
            let distance = (at(i, j).position - position).length() / size;
            found.distance[k] = found.distance[k].max(distance);
            found.mean_distance[k] += distance;
            samples[k] += 1.0;
            if normal != DVec3::ZERO {
                found.off[k] = found.off[k].max((at(i, j).position - position).dot(normal).abs() / size);
                found.angle[k] = found.angle[k].max(at(i, j).geometric.angle_between(normal).to_degrees());
            }
        }
        for i in 0..=n {
            for (e, p) in [at(i, 0), at(n, i), at(n - i, n), at(0, n - i)].into_iter().enumerate() {
                sides[level][4 * f as usize + e].push(p);
            }
        }
    }
    for (mean, samples) in found.mean_distance.iter_mut().zip(samples) {
        *mean /= samples.max(1.0);
    }
    for (l, part) in parts.iter().enumerate() {
        let level = &part.level;
        for (h, side) in sides[l].iter().enumerate().filter(|(_, side)| !side.is_empty()) {
            let t = level.twin[h];
            if t == NONE {
                continue;
            }
            // From the other end; of a refined face's children, every other sample of both halves.
            let mut other: Vec<Point> = sides[l][t as usize].clone();
            if part.fate[level.face_of(t)] == Fate::Refined {
                let half = |child: u32, k: u32| &sides[l + 1][(4 * child + k) as usize];
                let [a, b] = [half(part.child[t as usize], 0), half(part.child[level.next(t) as usize], 3)];
                other = a.iter().step_by(2).chain(b.iter().step_by(2).skip(1)).copied().collect();
            }
            for (a, b) in side.iter().zip(other.iter().rev()) {
                found.gap = found.gap.max((a.position - b.position).length() / size);
                if !level.is_sharp(h as u32) {
                    found.jump = found.jump.max(a.blended.angle_between(b.blended).to_degrees());
                }
            }
        }
    }
    found
}
