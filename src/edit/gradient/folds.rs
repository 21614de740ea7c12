//! Fold prevention for gradient meshes: a drag stops where a patch would turn over, as in ZHHK22 5.2.
//!
//! Every patch is a bicubic, so that [`crate::check::folds`] proves what it says. Only patches that a drag touches are
//! looked at. Those that were folded, or collapsed, before the drag may stay so.

use super::{Gradient, Pick};
use crate::check::folds::{gd01, jacobian_sign, JacobianSign};
use crate::ferguson::{FergusonError, Mesh};
use crate::patch::{ControlPoint, Kind};
use glam::DVec2;
use std::collections::BTreeMap;

/// Rectangles that the Jacobian test may cut a patch into.
const RECTANGLES: usize = 1000;

/// What is known of the patches of a gesture.
#[derive(Debug, Default)]
pub(super) struct Watch {
    /// Orientation of each before the gesture: 1 or -1; 0 where it was not sound.
    before: BTreeMap<u32, f64>,
    /// The last place of what is dragged where nothing folds.
    good: Option<DVec2>,
}

/// Whether a patch of the mesh is free of folds, its sides turning as `orientation` says.
pub fn sound(mesh: &Mesh, p: u32, orientation: f64) -> bool {
    let points = mesh.geometry(p).map(|q| -> ControlPoint { [q.x, q.y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0] });
    gd01(Kind::Bicubic, &points, orientation)
        || jacobian_sign(Kind::Bicubic, &points, orientation, RECTANGLES) == JacobianSign::Positive
}

/// The orientation of a patch that is free of folds; 0 for another.
fn orientation(mesh: &Mesh, p: u32) -> f64 {
    let [a, b, c, d] = mesh.patch(p).corners.map(|corner| mesh.at(corner.point));
    let likely = if (c - a).perp_dot(d - b) < 0.0 { -1.0 } else { 1.0 };
    [likely, -likely].into_iter().find(|&way| sound(mesh, p, way)).unwrap_or(0.0)
}

impl Gradient {
    /// Drags a thing to a place, as part of a gesture; with `tolerance`, scene units, no further than patches stay free of
    /// folds, to within so much. `true`: it was stopped.
    ///
    /// # Errors
    /// As the operation; the gesture has then done nothing.
    pub fn drag(&mut self, pick: Pick, to: DVec2, tolerance: Option<f64>) -> Result<bool, FergusonError> {
        let start = self.place(pick);
        let good = *self.watch.good.get_or_insert(start);
        if self.try_at(pick, to, tolerance.is_some())? {
            self.watch.good = Some(to);
            return Ok(false);
        }
        let (mut low, mut high) = (good, to);
        while low.distance(high) > tolerance.unwrap_or_default() {
            let middle = low.midpoint(high);
            if middle == low || middle == high {
                break;
            }
            if self.try_at(pick, middle, true)? {
                low = middle;
            } else {
                high = middle;
            }
        }
        self.try_at(pick, low, false)?;
        self.watch.good = Some(low);
        Ok(true)
    }

    /// Puts it there; whether all patches stay sound, where that is asked.
    fn try_at(&mut self, pick: Pick, at: DVec2, watched: bool) -> Result<bool, FergusonError> {
        let Some(op) = self.moving(pick, at) else { return Ok(true) };
        self.during(op)?;
        if !watched {
            return Ok(true);
        }
        let touched: Vec<u32> = self.gesture.as_ref().map(|g| g.touched.iter().copied().collect()).unwrap_or_default();
        let new: Vec<u32> = touched.iter().copied().filter(|p| !self.watch.before.contains_key(p)).collect();
        if !new.is_empty() {
            if let Some(step) = self.gesture.take() {
                self.take_back(step.journal);
            }
            for p in new {
                let way = orientation(&self.mesh, p);
                self.watch.before.insert(p, way);
            }
            self.during(op)?;
        }
        Ok(touched.into_iter().all(|p| match self.watch.before[&p] {
            0.0 => true,
            way => sound(&self.mesh, p, way),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edit::gradient::Op;
    use crate::ferguson::split::Axis;
    use glam::DVec4;

    fn grid() -> Gradient {
        let mut g = Gradient::new(Mesh::grid(3, 3, [0.0, 0.0, 3.0, 3.0], |_, _| DVec4::ONE).unwrap());
        g.act(Op::Split(4, Axis::U, 0.5)).unwrap();
        g
    }

    fn folded(g: &Gradient) -> usize {
        g.mesh.live().filter(|&p| !sound(&g.mesh, p, 1.0)).count()
    }

    #[test]
    fn a_drag_stops_where_a_patch_would_fold_and_goes_on_where_it_would_not() {
        for (at, to) in
            [(DVec2::new(1.0, 1.0), DVec2::new(2.7, 2.4)), (DVec2::new(4.0 / 3.0, 1.0), DVec2::new(1.6, 3.5))]
        {
            let mut g = grid();
            let pick = g.at(at, 1e-6).unwrap();
            // There are T-sections of the split in the patches above and below.
            assert!(!g.drag(pick, at + (to - at) * 0.05, Some(1e-4)).unwrap());
            assert!(g.drag(pick, to, Some(1e-4)).unwrap());
            let stopped = g.place(pick);
            assert!(folded(&g) == 0 && stopped.distance(at) > 0.05 && stopped.distance(to) > 0.1, "{stopped}");
            // A little further and it would fold.
            let beyond = stopped + (to - stopped).normalize() * 3e-4;
            assert!(g.drag(pick, beyond, Some(1e-4)).unwrap());
            // Back again: nothing holds it.
            assert!(!g.drag(pick, at, Some(1e-4)).unwrap());
            assert_eq!(g.place(pick), at);
            // Without prevention it goes where it is put.
            assert!(!g.drag(pick, to, None).unwrap());
            assert!(g.place(pick) == to && folded(&g) > 0);
            g.commit();
            // What is folded already does not hold a drag up.
            assert!(!g.drag(pick, to + DVec2::new(0.01, 0.0), Some(1e-4)).unwrap());
            g.commit();
            assert_eq!(g.steps(), 3);
        }
    }
}
