//! Triangles that the tessellator makes of a patch table, by formula, and the base level that matches a count.
//!
//! A domain with integer levels, equal spacing, has V vertices of which B lie on its border; a triangulated disc of
//! them has 2 V - B - 2 triangles (Euler). Outer levels decide B, inner levels the vertices inside.

use crate::patch::remap;
use crate::patch::stitched::Stitch;
use crate::patch::tess::{greatest, triangle_vertices, Levels, TessRule, MAX_LEVEL};
use crate::patch::transition::{Side, PARTS};
use crate::patch::{ControlPoint, DrawRange, Kind, PatchTable};

/// Triangles of a quad domain: `outer` in order around, `inner` across and along. Integers from 1.
pub fn quad(outer: [u64; 4], inner: [u64; 2]) -> u64 {
    if outer == [1; 4] && inner == [1; 2] {
        return 2;
    }
    // The tessellator raises an inner level of 1 when another level is greater.
    let [m, n] = inner.map(|x| x.max(2));
    2 * (m - 1) * (n - 1) + outer.iter().sum::<u64>() - 2
}

/// Triangles of a triangle domain.
pub fn triangle(outer: [u64; 3], inner: u64) -> u64 {
    if outer == [1; 3] && inner == 1 {
        return 1;
    }
    let n = inner.max(2);
    2 * (triangle_vertices(n) - 3 * n) + outer.iter().sum::<u64>() - 2
}

/// Triangles of one patch or part of `range`.
fn of_patch(range: &DrawRange, levels: Levels) -> u64 {
    let [full, half, inner] = [levels.full, levels.half, levels.inner].map(|x| x as u64);
    let Some(number) = range.part else {
        return quad([full; 4], [full; 2]);
    };
    let part = &PARTS[number as usize];
    let [a, b, c, d] = part.sides.map(|side| match side {
        Side::Inner => inner,
        Side::Full(_) => full,
        Side::Half(_) => half,
    });
    // Inner levels as `glsl/patch.tesc` sets them.
    if part.triangle {
        triangle([a, b, c], a.max(b).max(c))
    } else {
        quad([a, b, c, d], [a.max(c), b.max(d)])
    }
}

/// Triangles of transition faces in one piece.
fn of_remapped(table: &PatchTable, range: &DrawRange, levels: Levels) -> u64 {
    let [full, half] = [levels.full, levels.half].map(|x| x as u64);
    let first = range.first as usize;
    let patches = table.indices[first..first + range.stride() * range.count as usize].chunks_exact(range.stride());
    let of_one = |indices: &[u32]| {
        let points: Vec<ControlPoint> = indices.iter().map(|&i| table.control[i as usize]).collect();
        let [a, b, c, d] = [0, 1, 2, 3].map(|e| if remap::mask(&points) >> e & 1 == 1 { 2 * half } else { full });
        quad([a, b, c, d], [a.max(c), b.max(d)])
    };
    patches.map(of_one).sum()
}

/// Triangles of stitched patches: levels are even, those of stitched sides stand in the table.
fn of_stitched(table: &PatchTable, range: &DrawRange, levels: Levels) -> u64 {
    let free = 2 * (levels.full.max(2.0) as u64).div_ceil(2);
    let first = range.first as usize;
    let patches = table.indices[first..first + range.stride() * range.count as usize].chunks_exact(range.stride());
    let of_one = |indices: &[u32]| {
        let points: Vec<ControlPoint> = indices.iter().map(|&i| table.control[i as usize]).collect();
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| Stitch::read(&points, i).map_or(free, |s| u64::from(s.level())));
        quad([a, b, c, d], [a.max(c), b.max(d)])
    };
    patches.map(of_one).sum()
}

/// Triangles of a whole table before clipping; `None` for [`TessRule::Pixels`], where the view decides.
pub fn count(table: &PatchTable, rule: TessRule) -> Option<u64> {
    if matches!(rule, TessRule::Pixels(_)) {
        return None;
    }
    let most = greatest(&table.ranges);
    let of = |range: &DrawRange| match range.kind {
        Kind::Stitched => of_stitched(table, range, rule.levels(0)),
        Kind::RemappedBicubic | Kind::RemappedGregory => of_remapped(table, range, rule.levels_to(range.level, most)),
        _ => u64::from(range.count) * of_patch(range, rule.levels_to(range.level, most)),
    };
    Some(table.ranges.iter().map(of).sum())
}

/// Triangles of `faces` whole faces of one level, all quads: uniform subdivision; `None` as for [`count`].
pub fn uniform(faces: u64, level: u32, rule: TessRule) -> Option<u64> {
    if matches!(rule, TessRule::Pixels(_)) {
        return None;
    }
    let full = rule.levels(level).full as u64;
    Some(faces * quad([full; 4], [full; 2]))
}

/// The least integer T such that T / 2^l at level l makes at least `wanted` triangles of `table`; `None` if no level can.
pub fn matching_base(table: &PatchTable, wanted: u64) -> Option<u32> {
    let deepest = table.ranges.iter().map(|range| range.level).max()?;
    let enough = |t: u32| count(table, TessRule::Base(t as f32)).is_some_and(|n| n >= wanted);
    // The count never falls as T grows.
    let (mut low, mut high) = (0, (MAX_LEVEL as u32) << deepest.min(16));
    if !enough(high) {
        return None;
    }
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if enough(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_levels_make_the_well_known_counts() {
        for n in 1..=64 {
            assert_eq!(quad([n; 4], [n; 2]), 2 * n * n);
        }
        assert_eq!([1, 2, 3, 4, 5].map(|n| triangle([n; 3], n)), [1, 6, 13, 24, 37]);
    }

    #[test]
    fn one_split_side_goes_around_the_middle() {
        // One inner vertex and five on the border: a fan of five.
        assert_eq!(quad([2, 1, 1, 1], [1, 1]), 5);
        assert_eq!(triangle([2, 1, 1], 1), 4);
    }
}
