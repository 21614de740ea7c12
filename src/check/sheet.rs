//! Triangles that know which of their edges they share.

use glam::DVec3;
use std::collections::HashMap;

/// Corners nearer than this times the size of all count as one: what the two sides of an edge may differ by in the
/// evaluation, and far less than any triangle.
const SAME: f64 = 2.5e-10;

/// Triangles by numbers of their corners.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheet {
    /// Corners.
    pub positions: Vec<DVec3>,
    /// Three corners each, counter-clockwise from the front; none twice in one.
    pub triangles: Vec<[u32; 3]>,
}

impl Sheet {
    /// Of triangles that share corners by their places.
    pub fn weld(triangles: &[[DVec3; 3]]) -> Sheet {
        let [low, high] = crate::camera::bounds(triangles.iter().flatten().copied()).unwrap_or_default();
        let cell = (4.0 * SAME * (high - low).length()).max(f64::MIN_POSITIVE);
        let mut sheet = Sheet::default();
        let mut number: HashMap<[i64; 3], u32> = HashMap::new();
        let mut corner = |sheet: &mut Sheet, p: DVec3| {
            let at = ((p - low) / cell).to_array();
            let near =
                |i: usize| [0, 1, 2].map(|k| (at[k] + if i >> k & 1 == 0 { -0.25 } else { 0.25 }).floor() as i64);
            if let Some(&i) = (0..8).find_map(|i| number.get(&near(i))) {
                return i;
            }
            sheet.positions.push(p);
            let i = sheet.positions.len() as u32 - 1;
            number.insert(at.map(|x| x.floor() as i64), i);
            i
        };
        for t in triangles {
            let [a, b, c] = t.map(|p| corner(&mut sheet, p));
            if a != b && b != c && c != a {
                sheet.triangles.push([a, b, c]);
            }
        }
        sheet
    }

    /// Edges where the surface ends: as many as have not a triangle of either direction for each other.
    pub fn open_edges(&self) -> usize {
        let mut sum: HashMap<[u32; 2], i32> = HashMap::new();
        for &[a, b, c] in &self.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *sum.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
            }
        }
        sum.values().map(|n| n.unsigned_abs() as usize).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shared_edges_are_found_by_place_and_others_are_open() {
        let [a, b, c, d] = [DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::Y];
        let near = b + DVec3::splat(1e-13);
        let sheet = Sheet::weld(&[[a, b, c], [a, c, d], [a, near, b]]);
        assert_eq!((sheet.positions.len(), sheet.triangles.len(), sheet.open_edges()), (4, 2, 4));
        let middle = (a + c) * 0.5;
        let torn = Sheet::weld(&[[a, b, c], [a, middle, d], [middle, c, d]]);
        assert_eq!(torn.open_edges(), 4 + 3);
        let ball = Sheet::weld(&[[a, c, b], [a, b, d], [b, c, d], [c, a, d]]);
        assert_eq!(ball.open_edges(), 0);
    }
}
