//! Checks that a mesh is what it says, for tests and for files.

use super::mesh::{HalfEdge, Mesh};
use super::split::SAME;

impl Mesh {
    /// The first thing that is wrong with the structure, with the patch it was found at; `None` for a sound mesh.
    pub fn fault(&self) -> Option<(u32, String)> {
        for p in self.live() {
            let patch = self.patch(p);
            for i in 0..4 {
                let h = HalfEdge::new(p, i);
                let side = self.side(h);
                let Some(curve) = self.curves.get(side.curve as usize) else {
                    return Some((p, format!("side {i} names curve {}, which does not exist", side.curve)));
                };
                if !(side.from < side.to && side.from >= 0.0 && side.to <= 1.0) {
                    return Some((p, format!("side {i} has the interval {} to {}", side.from, side.to)));
                }
                if !curve.sides[usize::from(side.against)].contains(&h) {
                    return Some((p, format!("curve {} does not know side {i}", side.curve)));
                }
                let point = self.corner(h).point;
                if self.points.get(point as usize).is_none_or(|q| !q.corners.contains(&h)) {
                    return Some((p, format!("point {point} does not know corner {i}")));
                }
                let t = self.start(h);
                let expected = if t == 0.0 {
                    Some(curve.ends[0])
                } else if t == 1.0 {
                    Some(curve.ends[1])
                } else {
                    None
                };
                let on = self.points[point as usize].on;
                match (expected, on) {
                    (Some(end), _) if end != point => {
                        return Some((p, format!("side {i} begins in point {point}, its curve in point {end}")));
                    }
                    (None, None) => return Some((p, format!("point {point} is inside a curve but no T-section"))),
                    (None, Some(on)) if on.curve != side.curve || (on.t - t).abs() > SAME => {
                        return Some((p, format!("point {point} is a T-section somewhere else")));
                    }
                    _ => {}
                }
            }
            if patch.rect[0] >= patch.rect[2] || patch.rect[1] >= patch.rect[3] {
                return Some((p, format!("its part of the domain is empty: {:?}", patch.rect)));
            }
        }
        for (c, curve) in self.curves.iter().enumerate() {
            for list in curve.sides.iter().filter(|list| !list.is_empty()) {
                let mut at = 0.0;
                for &h in list {
                    let side = self.side(h);
                    if side.curve as usize != c || side.from != at || !self.patch(h.patch()).alive {
                        return Some((h.patch(), format!("the sides along curve {c} do not follow one another")));
                    }
                    at = side.to;
                }
                if at != 1.0 {
                    return Some((list[0].patch(), format!("the sides along curve {c} end at {at}")));
                }
            }
        }
        for (i, point) in self.points.iter().enumerate() {
            for &h in &point.corners {
                if !self.patch(h.patch()).alive || self.corner(h).point as usize != i {
                    return Some((h.patch(), format!("point {i} lists a corner that is not its own")));
                }
            }
        }
        None
    }
}
