//! What a user does to a mesh (BLHK18 section 5, 7.2): points, handles, twists and colours, with the updates that follow.
//!
//! Each operation touches the patches that change and no others; [`Mesh::take_journal`] says which those were, and
//! [`Mesh::undo`] takes them back.

use super::inherit::Continuity;
use super::mesh::{HalfEdge, Jet, Mesh};
use super::FergusonError;
use glam::{DVec2, DVec4};

impl Mesh {
    fn point_exists(&self, point: u32) -> Result<(), FergusonError> {
        match self.points.get(point as usize) {
            Some(p) if !p.corners.is_empty() => Ok(()),
            _ => Err(FergusonError::NoPoint(point)),
        }
    }

    fn curve_exists(&self, c: u32) -> Result<(), FergusonError> {
        match self.curves.get(c as usize) {
            Some(curve) if curve.sides.iter().any(|list| !list.is_empty()) => Ok(()),
            _ => Err(FergusonError::NoCurve(c)),
        }
    }

    /// Patches along a curve, on both sides.
    fn along(&self, c: u32) -> Vec<u32> {
        self.curve(c).sides.iter().flatten().map(|h| h.patch()).collect()
    }

    /// Curves that end in a point, each with which of its ends.
    pub fn curves_at(&self, point: u32) -> Vec<(u32, usize)> {
        let mut found = Vec::new();
        for &h in &self.points[point as usize].corners {
            for side in [h, h.prev()] {
                let c = self.side(side).curve;
                for end in 0..2 {
                    if self.curve(c).ends[end] == point && !found.contains(&(c, end)) {
                        found.push((c, end));
                    }
                }
            }
        }
        found
    }

    /// Moves a control point; its handles follow.
    ///
    /// # Errors
    /// There is no such point, it is a T-section, or `to` is not finite.
    pub fn move_point(&mut self, point: u32, to: DVec2, continuity: Continuity) -> Result<(), FergusonError> {
        self.point_exists(point)?;
        if self.points[point as usize].on.is_some() {
            return Err(FergusonError::Section(point));
        }
        if !to.is_finite() {
            return Err(FergusonError::NotFinite);
        }
        let by = to - self.at(point);
        self.point_mut(point).at = to;
        let mut touched: Vec<u32> = self.points[point as usize].corners.iter().map(|h| h.patch()).collect();
        for (c, end) in self.curves_at(point) {
            self.curve_mut(c).handles[end] += by;
            touched.extend(self.along(c));
        }
        self.touch_and_settle(touched, continuity);
        Ok(())
    }

    /// Moves a handle, a Bezier point, of curve `c` at its end 0 or 1. In C^1 mode the handle of the opposite curve mirrors
    /// it, scaled where the patches there are of other sizes.
    ///
    /// # Errors
    /// There is no such curve, `to` is not finite, or in C^1 mode the end is a T-section.
    pub fn move_handle(&mut self, c: u32, end: usize, to: DVec2, continuity: Continuity) -> Result<(), FergusonError> {
        self.curve_exists(c)?;
        if !to.is_finite() {
            return Err(FergusonError::NotFinite);
        }
        let end = end.min(1);
        let point = self.curve(c).ends[end];
        if continuity == Continuity::C1 && self.points[point as usize].on.is_some() {
            return Err(FergusonError::Section(point));
        }
        self.curve_mut(c).handles[end] = to;
        let mut touched = self.along(c);
        if continuity == Continuity::C1 {
            if let Some((other, far)) = self.opposite_curve(c, end) {
                let ratio = self.extent_of(other) / self.extent_of(c);
                let at = self.at(point);
                self.curve_mut(other).handles[far] = at - (to - at) * ratio;
                touched.extend(self.along(other));
            }
        }
        self.touch_and_settle(touched, continuity);
        Ok(())
    }

    /// The curve that continues curve `c` beyond its end: at an inner point of four patches the one across, at a boundary
    /// point of two patches the other boundary curve. Elsewhere, as where branches meet, there is none.
    pub fn opposite_curve(&self, c: u32, end: usize) -> Option<(u32, usize)> {
        let point = self.curve(c).ends[end];
        let corners = &self.points[point as usize].corners;
        let leaving = |h: HalfEdge| (self.side(h).curve, usize::from(self.side(h).against));
        let arriving = |h: HalfEdge| (self.side(h.prev()).curve, usize::from(!self.side(h.prev()).against));
        let this = (c, end);
        match corners.len() {
            4 => {
                // Twice round: from the curve that leaves to the one that arrives in the same corner, which leaves the next.
                let first = *corners.iter().find(|&&h| leaving(h) == this)?;
                let second = *corners.iter().find(|&&h| h != first && leaving(h) == arriving(first))?;
                let found = arriving(second);
                (self.curve(found.0).ends[found.1] == point).then_some(found)
            }
            2 => {
                let all: Vec<(u32, usize)> = corners.iter().flat_map(|&h| [leaving(h), arriving(h)]).collect();
                let once = |x: &(u32, usize)| all.iter().filter(|y| *y == x).count() == 1;
                once(&this).then(|| all.iter().copied().find(|x| *x != this && once(x))).flatten()
            }
            _ => None,
        }
    }

    /// Length of a curve in the parameter of the patches of level 0.
    fn extent_of(&self, c: u32) -> f64 {
        let h = self.curve(c).sides.iter().flatten().next().copied();
        h.map_or(1.0, |h| {
            let side = self.side(h);
            self.patch(h.patch()).extent()[h.side() % 2] / (side.to - side.from)
        })
    }

    /// Sets the twist of the geometry at a corner.
    ///
    /// # Errors
    /// There is no such patch, `twist` is not finite, or in C^1 mode the corner is a T-section.
    pub fn set_twist(&mut self, corner: HalfEdge, twist: DVec2, continuity: Continuity) -> Result<(), FergusonError> {
        self.check_corner(corner, continuity)?;
        if !twist.is_finite() {
            return Err(FergusonError::NotFinite);
        }
        self.corner_mut(corner).twist = twist;
        self.touch_and_settle(vec![corner.patch()], continuity);
        Ok(())
    }

    fn check_corner(&self, corner: HalfEdge, continuity: Continuity) -> Result<(), FergusonError> {
        if self.patches.get(corner.patch() as usize).is_none_or(|p| !p.alive) {
            return Err(FergusonError::NoPatch(corner.patch()));
        }
        let point = self.corner(corner).point;
        if continuity == Continuity::C1 && self.points[point as usize].on.is_some() {
            return Err(FergusonError::Section(point));
        }
        Ok(())
    }

    /// Sets the colour of a point in all its sectors, in coordinates of the mesh's space.
    ///
    /// # Errors
    /// There is no such point, it is a T-section, or the colour is not finite.
    pub fn set_colour(&mut self, point: u32, colour: DVec4, continuity: Continuity) -> Result<(), FergusonError> {
        self.point_exists(point)?;
        if self.points[point as usize].on.is_some() {
            return Err(FergusonError::Section(point));
        }
        if !colour.is_finite() {
            return Err(FergusonError::NotFinite);
        }
        let corners = self.points[point as usize].corners.clone();
        for &h in &corners {
            self.recolour(h, colour);
        }
        self.touch_and_settle(corners.iter().map(|h| h.patch()).collect(), continuity);
        Ok(())
    }

    /// Sets the colour of one sector of a point (7.2), also at a T-section, whose sector then keeps it: a sharp colour.
    ///
    /// # Errors
    /// There is no such patch, or the colour is not finite.
    pub fn set_sector_colour(
        &mut self,
        corner: HalfEdge,
        colour: DVec4,
        continuity: Continuity,
    ) -> Result<(), FergusonError> {
        self.check_corner(corner, Continuity::C0)?;
        if !colour.is_finite() {
            return Err(FergusonError::NotFinite);
        }
        self.recolour(corner, colour);
        self.corner_mut(corner).inherits = false;
        self.touch_and_settle(vec![corner.patch()], continuity);
        Ok(())
    }

    /// Adds the change of a corner's colour to its patch by the blending function, so that what splits have put into the
    /// derivatives stays.
    fn recolour(&mut self, h: HalfEdge, colour: DVec4) {
        let (p, i) = (h.patch(), h.side());
        let mut change = [DVec4::ZERO; 4];
        change[i] = colour - self.corner(h).colour.value;
        let more = [0, 1, 2, 3].map(|k| self.blended(p, change, k));
        let patch = self.patch_mut(p);
        for (k, (corner, more)) in patch.corners.iter_mut().zip(more).enumerate() {
            let old = corner.colour;
            corner.colour = Jet {
                value: if k == i { colour } else { old.value },
                du: old.du + more.du,
                dv: old.dv + more.dv,
                duv: old.duv + more.duv,
            };
        }
    }

    fn touch_and_settle(&mut self, mut touched: Vec<u32>, continuity: Continuity) {
        touched.sort_unstable();
        touched.dedup();
        for &p in &touched {
            // A patch whose curves moved has changed although its own record has not.
            self.patch_mut(p);
        }
        self.settle(touched, continuity);
    }
}
