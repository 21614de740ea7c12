//! How far patches are from the limit surface, and how N_B crosses their edges.

use super::adaptive::{Fate, Part};
use super::exact::Exact;
use super::level::Level;
use super::limit::{shape, Shape};
use super::patch_eval::{point, Point};
use super::patches::Patches;
use super::stencil::region_ends;
use crate::camera::bounds;
use crate::mesh::NONE;
use glam::DVec3;
use std::collections::HashMap;

/// What samples on a grid of every patch, sides included, have found. Lists are of regular, then Gregory patches.
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
    /// Greatest angle between N_L and the limit's normal, degrees; where the limit has one, which spikes have not.
    pub angle: [f64; 2],
    /// Greatest angle between N_B on both sides of an edge that is not sharp, degrees; spikes left out.
    pub jump: f64,
    /// Greatest distance of both sides of an edge, sharp or not, over the diagonal.
    pub gap: f64,
}

/// Whether the surface has no tangent plane at the origin of `h`, in the region of `h`: at a sharp vertex with three faces or
/// more between sharp edges, or none, smooth faces narrow into a spike.
fn is_spike(level: &Level, h: u32) -> bool {
    let v = level.origin[h as usize];
    if shape(level.sharp_edges[v as usize], level.corner_sharpness(v) > 0.0) != Shape::Corner {
        return false;
    }
    let Some([first, last]) = region_ends(level, h, |g| level.is_sharp(g)) else { return true };
    std::iter::successors(Some(first), |&g| if g == last { None } else { level.spoke_after(g) }).nth(2).is_some()
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
        patches: [
            patches.bicubic.len() + patches.transition.len() + patches.quartic.len() + patches.quartic_transition.len(),
            patches.gregory.len() + patches.quartic_gregory.len(),
        ],
        ..Accuracy::default()
    };
    let mut sides: Vec<Vec<Vec<Point>>> = parts.iter().map(|p| vec![Vec::new(); p.level.half_edges()]).collect();
    let mut samples = [0.0f64; 2];
    for patch in patches.iter() {
        let k = usize::from(patch.form.is_gregory());
        let (level, f) = (patch.place.level as usize, patch.place.face);
        let Some(exact) = &exact[level] else { continue };
        let step = |i: u32| f64::from(i) / f64::from(n);
        let corners = patch.form.sides();
        let grid: Vec<(u32, u32)> =
            (0..=n).flat_map(|j| (0..=if corners == 3 { n - j } else { n }).map(move |i| (i, j))).collect();
        let points: HashMap<(u32, u32), Point> =
            grid.iter().map(|&(i, j)| ((i, j), point(patch.form, &patch.control, step(i), step(j), power))).collect();
        let at = |i: u32, j: u32| points[&(i, j)];
        for (i, j) in grid {
            let (position, normal) = exact.limit(f, i, j);
            let distance = (at(i, j).position - position).length() / size;
            found.distance[k] = found.distance[k].max(distance);
            found.mean_distance[k] += distance;
            samples[k] += 1.0;
            let corner = match (corners, i, j) {
                (_, 0, 0) => Some(0),
                (3, i, 0) if i == n => Some(1),
                (3, 0, j) if j == n => Some(2),
                (4, i, 0) if i == n => Some(1),
                (4, i, j) if i == n && j == n => Some(2),
                (4, 0, j) if j == n => Some(3),
                _ => None,
            };
            let at_spike = corner.is_some_and(|k| is_spike(&parts[level].level, corners as u32 * f + k));
            if normal != DVec3::ZERO && !at_spike {
                found.off[k] = found.off[k].max((at(i, j).position - position).dot(normal).abs() / size);
                found.angle[k] = found.angle[k].max(at(i, j).geometric.angle_between(normal).to_degrees());
            }
        }
        for i in 0..=n {
            let quad = [(i, 0), (n, i), (n - i, n), (0, n - i)];
            let triangle = [(i, 0), (n - i, i), (0, n - i)];
            let around = if corners == 3 { &triangle[..] } else { &quad };
            for (e, &(i, j)) in around.iter().enumerate() {
                sides[level][corners * f as usize + e].push(at(i, j));
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
                let corners = parts[l + 1].level.sides;
                let half = |child: u32, k: u32| &sides[l + 1][(corners * child + k) as usize];
                let [a, b] = [half(part.child[t as usize], 0), half(part.child[level.next(t) as usize], corners - 1)];
                other = a.iter().step_by(2).chain(b.iter().step_by(2).skip(1)).copied().collect();
            }
            let spikes = [h as u32, level.next(h as u32)].map(|h| is_spike(level, h));
            for (k, (a, b)) in side.iter().zip(other.iter().rev()).enumerate() {
                found.gap = found.gap.max((a.position - b.position).length() / size);
                let at_spike = k == 0 && spikes[0] || k + 1 == side.len() && spikes[1];
                if !level.is_sharp(h as u32) && !at_spike {
                    found.jump = found.jump.max(a.blended.angle_between(b.blended).to_degrees());
                }
            }
        }
    }
    found
}
