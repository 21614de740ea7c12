//! Seams: do both sides of every inner edge get the same bits?
//!
//! Every vertex that the device makes is read back. The segments between neighbouring vertices on a patch's sides must
//! come in pairs, there and back, but for those on the boundary of the mesh. No view is needed and no rasteriser hides
//! anything: a surface whose segments all pair has no gap at any magnification.

use crate::gpu::EvaluatedPoint;
use crate::patch::eval;
use std::collections::HashMap;

/// What was found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seams {
    /// Segments on sides of patches and parts, those inside of transition faces too.
    pub segments: usize,
    /// Those that no other runs back along.
    pub open: usize,
}

/// Pairs the segments of `points`, which stand patch by patch (`Gpu::evaluate`). Two vertices are the same if their
/// positions have the same bits; segments without length do not count.
pub fn seams(points: &[EvaluatedPoint]) -> Seams {
    let mut found = Seams::default();
    let mut balance: HashMap<[[u32; 2]; 2], i32> = HashMap::new();
    for patch in points.chunk_by(|a, b| (a.range, a.patch) == (b.range, b.patch)) {
        for side in 0..eval::sides(patch[0].part) {
            for pair in side_positions(patch, side).windows(2) {
                let (a, b) = (pair[0], pair[1]);
                if a == b {
                    continue;
                }
                found.segments += 1;
                *balance.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
            }
        }
    }
    found.open = balance.values().map(|n| n.unsigned_abs() as usize).sum();
    found
}

/// Bits of x and y of the vertices along a side, from its corner to the next.
fn side_positions(patch: &[EvaluatedPoint], side: usize) -> Vec<[u32; 2]> {
    let part = patch[0].part;
    let mut along: Vec<(f32, [u32; 2])> = patch
        .iter()
        .filter_map(|p| {
            let (on, t) = eval::along_side(part, p.coord.map(f64::from), side)?;
            on.then_some((t as f32, [p.value[0].to_bits(), p.value[1].to_bits()]))
        })
        .collect();
    along.sort_by(|a, b| a.0.total_cmp(&b.0));
    along.into_iter().map(|(_, bits)| bits).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat patch at level 1 with these corners.
    fn patch(number: u32, corners: [[f32; 2]; 4]) -> Vec<EvaluatedPoint> {
        let coords = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let point = |([x, y], coord): ([f32; 2], [f32; 3])| EvaluatedPoint {
            range: 0,
            patch: number,
            part: None,
            coord,
            outer: [1.0; 4],
            value: [x, y, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        };
        corners.into_iter().zip(coords).map(point).collect()
    }

    #[test]
    fn a_last_bit_opens_a_seam() {
        let left = patch(0, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        let right = patch(1, [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]]);
        let torn = patch(1, [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0f32.next_up(), 1.0]]);
        assert_eq!(seams(&[left.clone(), right].concat()), Seams { segments: 8, open: 6 });
        assert_eq!(seams(&[left, torn].concat()), Seams { segments: 8, open: 8 });
    }
}
