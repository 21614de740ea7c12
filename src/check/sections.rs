//! Cracks of meshes with T-sections: what of [`super::cracks`] is different for technique `ferguson`.
//!
//! Levels of its sides may be fractions, whose places along a side the device chooses, so the outline is the curve itself
//! and pixels count that are farther from it than the tessellation can be.

use super::cracks::{find_beyond, winding, AMBIGUOUS};
use crate::ferguson::fit::{free_level, Target};
use crate::ferguson::hermite;
use crate::ferguson::Mesh;
use glam::DVec2;

/// The boundary of a mesh in pixels.
pub struct Outline {
    /// Segments that approximate it, pixels from the top left.
    pub segments: Vec<[DVec2; 2]>,
    /// How far the drawn boundary may be from them, pixels.
    pub margin: f64,
}

/// Segments for each curve of the boundary: four times as many as the device may use, so that their own distance from the
/// curve is a sixteenth of that of the drawn boundary.
const FINER: f64 = 4.0;

/// Boundary of a mesh that was made to fit `target` in a picture of `view`.
pub fn outline(mesh: &Mesh, target: &Target, view: [f64; 4], [width, height]: [u32; 2]) -> Outline {
    let scale = DVec2::new(f64::from(width) / (view[2] - view[0]), f64::from(height) / (view[3] - view[1]));
    let mut out = Outline { segments: Vec::new(), margin: AMBIGUOUS };
    for (c, curve) in mesh.curves.iter().enumerate() {
        let inside = curve.sides.iter().all(|list| !list.is_empty());
        let gone = curve.sides.iter().all(|list| list.is_empty());
        if inside || gone {
            continue;
        }
        let model = mesh.bezier(c as u32);
        let q = model.map(|p| DVec2::new((p.x - view[0]) * scale.x, (view[3] - p.y) * scale.y));
        let level = free_level(model, target);
        // A chord over a step h of the parameter is at most h^2 / 8 times the greatest second derivative away.
        let bend = (q[0] - q[1] * 2.0 + q[2]).length().max((q[1] - q[2] * 2.0 + q[3]).length()) * 6.0;
        let seen = q.iter().copied().reduce(DVec2::min).zip(q.iter().copied().reduce(DVec2::max));
        if seen.is_some_and(|(a, b)| b.x >= 0.0 && b.y >= 0.0 && a.x <= f64::from(width) && a.y <= f64::from(height)) {
            out.margin = out.margin.max(AMBIGUOUS + 1.1 * bend / (8.0 * level * level));
        }
        let n = (FINER * level).ceil();
        let mut from = q[0];
        for k in 1..=n as u32 {
            let to = hermite::point(q, f64::from(k) / n);
            out.segments.push([from, to]);
            from = to;
        }
    }
    out
}

/// Background pixels inside the outline, and how many pixels are inside; `covered` as in [`super::cracks::find`].
pub fn cracks(outline: &Outline, covered: &[bool], [width, height]: [u32; 2]) -> (Vec<[u32; 2]>, usize) {
    let inside = winding(&outline.segments, width, height).iter().filter(|&&n| n != 0).count();
    (find_beyond(&outline.segments, covered, width, height, outline.margin), inside)
}
