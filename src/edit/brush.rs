//! Picking, the brush, and boxes: which handles are meant (ZHHK22 5.1).

use super::handle::{Id, Kind};
use super::overlay::Handle;
use glam::DVec2;

/// The handle nearest to `at` within `reach`, among those that `accept` lets through. Where several lie at one place
/// the smaller sort wins: sectors, then colours, then points; and of one sort the one after `current`, so that picking
/// again goes through all of them.
pub fn pick(handles: &[Handle], at: DVec2, reach: f64, accept: impl Fn(Id) -> bool, current: Option<Id>) -> Option<Id> {
    let near: Vec<&Handle> = handles.iter().filter(|h| accept(h.id) && h.shown.distance(at) <= reach).collect();
    let least = near.iter().map(|h| h.shown.distance(at)).fold(f64::INFINITY, f64::min);
    // What nobody could tell apart by eye counts as one place.
    let mut same: Vec<Id> =
        near.iter().filter(|h| h.shown.distance(at) <= least + 0.15 * reach).map(|h| h.id).collect();
    same.sort_unstable_by_key(|id| (rank(id.kind), *id));
    let after = current.and_then(|id| same.iter().position(|&s| s == id)).map(|i| (i + 1) % same.len());
    same.get(after.unwrap_or(0)).copied()
}

fn rank(kind: Kind) -> u8 {
    match kind {
        Kind::Sector => 0,
        Kind::Colour => 1,
        Kind::Gradient => 2,
        Kind::FacePoint => 3,
        Kind::Input | Kind::Vertex => 4,
    }
}

/// All handles within `radius` of `at`.
pub fn within(handles: &[Handle], at: DVec2, radius: f64, accept: impl Fn(Id) -> bool) -> Vec<Id> {
    handles.iter().filter(|h| accept(h.id) && h.shown.distance(at) <= radius).map(|h| h.id).collect()
}

/// All handles in the box with the corners `a` and `b`.
pub fn boxed(handles: &[Handle], a: DVec2, b: DVec2, accept: impl Fn(Id) -> bool) -> Vec<Id> {
    let (low, high) = (a.min(b), a.max(b));
    let inside = |p: DVec2| p.cmpge(low).all() && p.cmple(high).all();
    handles.iter().filter(|h| accept(h.id) && inside(h.shown)).map(|h| h.id).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec4;

    fn handle(kind: Kind, slot: u64, x: f64, y: f64) -> Handle {
        let at = DVec2::new(x, y);
        Handle { id: Id { kind, level: 1, slot }, at, shown: at, control: at, colour: DVec4::ONE }
    }

    #[test]
    fn picking_again_goes_through_coincident_handles() {
        let handles =
            [handle(Kind::Vertex, 0, 1.0, 1.0), handle(Kind::Colour, 0, 1.0, 1.0), handle(Kind::Vertex, 9, 1.0, 1.0)];
        let at = DVec2::new(1.1, 1.0);
        let mut seen = Vec::new();
        let mut current = None;
        for _ in 0..3 {
            current = pick(&handles, at, 0.5, |_| true, current);
            seen.push(current.unwrap());
        }
        assert_eq!(seen, [handles[1].id, handles[0].id, handles[2].id]);
        assert_eq!(pick(&handles, at, 0.5, |_| true, current), Some(handles[1].id));
        assert_eq!(pick(&handles, at, 0.05, |_| true, None), None);
        assert_eq!(pick(&handles, at, 0.5, |id| id.kind == Kind::Vertex, None), Some(handles[0].id));
    }

    #[test]
    fn circles_and_boxes() {
        let handles: Vec<Handle> = (0..25).map(|i| handle(Kind::Vertex, i, (i % 5) as f64, (i / 5) as f64)).collect();
        assert_eq!(within(&handles, DVec2::new(2.0, 2.0), 1.0, |_| true).len(), 5);
        assert_eq!(boxed(&handles, DVec2::new(3.5, 0.5), DVec2::new(0.5, 2.5), |_| true).len(), 6);
    }
}
