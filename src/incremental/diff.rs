//! From two scenes to value edits, where only values differ.

use super::ValueEdit;
use crate::scene::Scene;

/// The value edits that turn `old` into `new`, or `None` where more than values differs: polygons, rules, sharp tags, or
/// which places are edited. Names and reference pictures are not looked at. Time linear in the scenes.
pub fn between(old: &Scene, new: &Scene) -> Option<Vec<ValueEdit>> {
    let same = old.mesh.corners == new.mesh.corners
        && old.mesh.face_start == new.mesh.face_start
        && old.mesh.positions.len() == new.mesh.positions.len()
        && old.corners == new.corners
        && old.corner_colours.len() == new.corner_colours.len()
        && old.sharp == new.sharp
        && old.handles.len() == new.handles.len()
        && old.face_points.len() == new.face_points.len()
        && old.geometry.len() == new.geometry.len()
        && old.colours.len() == new.colours.len();
    if !same {
        return None;
    }
    let mut edits = Vec::new();
    for (i, (a, b)) in old.mesh.positions.iter().zip(&new.mesh.positions).enumerate() {
        if a != b {
            edits.push(ValueEdit::Position(i as u32, *b));
        }
    }
    for (i, (a, b)) in old.corner_colours.iter().zip(&new.corner_colours).enumerate() {
        if a != b {
            edits.push(ValueEdit::CornerColour(i as u32, *b));
        }
    }
    for (lists, make) in [
        ([&old.handles, &new.handles], ValueEdit::Handle as fn(u32, glam::DVec2) -> ValueEdit),
        ([&old.face_points, &new.face_points], ValueEdit::FacePoint),
    ] {
        for (i, (a, b)) in lists[0].iter().zip(lists[1]).enumerate() {
            if a.half_edge != b.half_edge {
                return None;
            }
            if a.at != b.at {
                edits.push(make(i as u32, b.at));
            }
        }
    }
    for (i, (a, b)) in old.geometry.iter().zip(&new.geometry).enumerate() {
        if (a.level, a.half_edge, a.frame) != (b.level, b.half_edge, b.frame) {
            return None;
        }
        if (a.a, a.b) != (b.a, b.b) {
            edits.push(ValueEdit::Geometry(i as u32, [b.a, b.b]));
        }
    }
    for (i, (a, b)) in old.colours.iter().zip(&new.colours).enumerate() {
        if (a.level, a.half_edge) != (b.level, b.half_edge) {
            return None;
        }
        if a.colour != b.colour {
            edits.push(ValueEdit::Colour(i as u32, b.colour));
        }
    }
    Some(edits)
}
