//! The patches that a view can show: for looking closely at a large table, where almost all of it lies outside.

use super::{ControlPoint, DrawRange, PatchTable};

/// The patches of `table` that may touch the model rectangle `view` (x0, y0, x1, y1), with the control points they use.
/// A patch lies in the hull of its control points (the weights of a Bezier or Gregory patch are not negative and sum
/// to 1), so what is left out has no point in the view. [`PatchTable::faces`] stays empty. Linear in the table.
pub fn within(table: &PatchTable, view: [f64; 4]) -> PatchTable {
    let mut seen = PatchTable { colour: table.colour, ..PatchTable::default() };
    // New number of each control point, plus 1.
    let mut renamed = vec![0u32; table.control.len()];
    for range in &table.ranges {
        let stride = range.stride();
        let first = seen.indices.len();
        for patch in table.indices[range.first as usize..][..range.count as usize * stride].chunks_exact(stride) {
            if !meets(patch.iter().map(|&i| &table.control[i as usize]), view) {
                continue;
            }
            seen.indices.extend(patch.iter().map(|&i| {
                let name = &mut renamed[i as usize];
                if *name == 0 {
                    seen.control.push(table.control[i as usize]);
                    *name = seen.control.len() as u32;
                }
                *name - 1
            }));
        }
        let count = ((seen.indices.len() - first) / stride) as u32;
        if count > 0 {
            seen.ranges.push(DrawRange { first: first as u32, count, ..*range });
        }
    }
    seen
}

/// Whether the bounding box of the points meets the rectangle.
fn meets<'a>(points: impl Iterator<Item = &'a ControlPoint>, view: [f64; 4]) -> bool {
    let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for p in points {
        for axis in 0..2 {
            bounds[axis] = bounds[axis].min(p[axis]);
            bounds[axis + 2] = bounds[axis + 2].max(p[axis]);
        }
    }
    bounds[0] <= view[2] && bounds[2] >= view[0] && bounds[1] <= view[3] && bounds[3] >= view[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patch::Kind;

    /// Two flat bicubics side by side, x from 0 to 1 and from 1 to 2, that share their points at x = 1.
    fn two() -> PatchTable {
        let control = (0..28).map(|i| {
            let (column, row) = (i % 7, i / 7);
            [f64::from(column) / 3.0, f64::from(row) / 3.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]
        });
        let patch = |from: u32| (0..16).map(move |i| from + i % 4 + 7 * (i / 4));
        PatchTable {
            control: control.collect(),
            indices: patch(0).chain(patch(3)).collect(),
            ranges: vec![DrawRange { kind: Kind::Bicubic, part: None, level: 0, first: 0, count: 2 }],
            ..PatchTable::default()
        }
    }

    #[test]
    fn only_what_the_view_touches_stays() {
        let table = two();
        let right = within(&table, [1.5, 0.2, 1.6, 0.3]);
        assert_eq!((right.ranges.len(), right.ranges[0].count, right.control.len()), (1, 1, 16));
        let points: Vec<_> = right.indices.iter().map(|&i| right.control[i as usize]).collect();
        let whole: Vec<_> = table.indices[16..].iter().map(|&i| table.control[i as usize]).collect();
        assert_eq!(points, whole);
        assert!(within(&table, [3.0, 0.0, 4.0, 1.0]).ranges.is_empty());
    }

    #[test]
    fn a_view_of_everything_keeps_everything() {
        let table = two();
        let seen = within(&table, [0.0, 0.0, 2.0, 1.0]);
        assert_eq!((seen.ranges, seen.control.len()), (table.ranges, table.control.len()));
    }
}
