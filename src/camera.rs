//! Cameras for scenes in space.
//!
//! Clip space is Vulkan's: x right, y down, depth 0 (near) to 1 (far). Angles in the interface are degrees.

use glam::{DMat4, DVec3};

/// How depth becomes size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Vertical angle of view, degrees, above 0 and below 180.
    Perspective {
        /// The angle.
        fov: f64,
    },
    /// Height of what the picture shows, model units.
    Orthographic {
        /// The height.
        height: f64,
    },
}

/// Where the eye is, where it looks, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Eye.
    pub eye: DVec3,
    /// A point in the middle of the picture, in front of the eye.
    pub target: DVec3,
    /// A direction that is upwards in the picture; not parallel to the view.
    pub up: DVec3,
    /// Projection.
    pub projection: Projection,
}

/// Part of the picture's half size that a fitted scene fills.
const FILLED: f64 = 0.95;

impl Camera {
    /// The camera that looks at the middle of `bounds` (least and greatest corner) from `yaw` degrees to the right
    /// around `up` (from +z towards +x with y up) and `pitch` degrees above, as near as shows all eight corners.
    /// `aspect` is width over height; an orthographic projection's height is chosen too.
    pub fn orbit(bounds: [DVec3; 2], yaw: f64, pitch: f64, projection: Projection, aspect: f64) -> Camera {
        let middle = (bounds[0] + bounds[1]) * 0.5;
        let radius = (0.5 * (bounds[1] - bounds[0]).length()).max(f64::MIN_POSITIVE);
        let (sy, cy) = yaw.to_radians().sin_cos();
        let (sp, cp) = pitch.to_radians().sin_cos();
        let back = DVec3::new(sy * cp, sp, cy * cp);
        // The derivative along the pitch: upwards even straight above.
        let up = DVec3::new(-sy * sp, cp, -cy * sp);
        let right = up.cross(back);
        let corners = box_corners(bounds).map(|q| q - middle);
        let mut camera = Camera { eye: middle + back * (2.0 * radius), target: middle, up, projection };
        match projection {
            Projection::Perspective { fov } => {
                let tan = (0.5 * fov.to_radians()).tan() * FILLED;
                let need = |q: DVec3| {
                    let across = (q.dot(right).abs() / aspect).max(q.dot(up).abs());
                    across / tan + q.dot(back)
                };
                // Some way off even from a flat thing seen from its edge.
                let distance = corners.into_iter().map(need).fold(1e-3 * radius, f64::max);
                camera.eye = middle + back * distance;
            }
            Projection::Orthographic { .. } => {
                let half = |q: DVec3| (q.dot(right).abs() / aspect).max(q.dot(up).abs());
                let height = 2.0 * corners.into_iter().map(half).fold(0.0, f64::max) / FILLED;
                camera.projection = Projection::Orthographic { height: height.max(1e-3 * radius) };
            }
        }
        camera
    }

    /// The same view from `distance` away from its target.
    #[must_use]
    pub fn at_distance(self, distance: f64) -> Camera {
        Camera { eye: self.target + (self.eye - self.target).normalize_or(DVec3::Z) * distance, ..self }
    }

    /// Unit vectors to the right, up and back towards the eye.
    pub fn axes(&self) -> [DVec3; 3] {
        let back = (self.eye - self.target).normalize_or(DVec3::Z);
        let right = self.up.cross(back).normalize_or(back.any_orthonormal_vector());
        [right, back.cross(right), back]
    }

    /// Nearest and farthest depth that shows all of `bounds` in front of the eye.
    pub fn depths(&self, bounds: [DVec3; 2]) -> [f64; 2] {
        let [_, _, back] = self.axes();
        let depth = box_corners(bounds).map(|q| (self.eye - q).dot(back));
        let far = depth.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let near = depth.into_iter().fold(f64::INFINITY, f64::min);
        let margin = 0.01 * (far - near) + 1e-9 * far.abs() + f64::MIN_POSITIVE;
        match self.projection {
            Projection::Orthographic { .. } => [near - margin, far + margin],
            Projection::Perspective { .. } => {
                let far = (far + margin).max(f64::MIN_POSITIVE * 1e6);
                [(near - margin).max(1e-4 * far), far]
            }
        }
    }

    /// From model to clip space, all of `bounds` between near and far; `aspect` is width over height.
    pub fn matrix(&self, aspect: f64, bounds: [DVec3; 2]) -> DMat4 {
        let [right, up, back] = self.axes();
        let [near, far] = self.depths(bounds);
        let view = DMat4::from_cols(right.extend(0.0), up.extend(0.0), back.extend(0.0), glam::DVec4::W).transpose()
            * DMat4::from_translation(-self.eye);
        let projection = match self.projection {
            Projection::Perspective { fov } => {
                let f = 1.0 / (0.5 * fov.to_radians()).tan();
                DMat4::from_cols_array_2d(&[
                    [f / aspect, 0.0, 0.0, 0.0],
                    [0.0, -f, 0.0, 0.0],
                    [0.0, 0.0, far / (near - far), -1.0],
                    [0.0, 0.0, near * far / (near - far), 0.0],
                ])
            }
            Projection::Orthographic { height } => DMat4::from_cols_array_2d(&[
                [2.0 / (height * aspect), 0.0, 0.0, 0.0],
                [0.0, -2.0 / height, 0.0, 0.0],
                [0.0, 0.0, 1.0 / (near - far), 0.0],
                [0.0, 0.0, near / (near - far), 1.0],
            ]),
        };
        projection * view
    }
}

/// The eight corners of a box.
pub fn box_corners([low, high]: [DVec3; 2]) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    })
}

/// Least and greatest corner of the box around `points`; `None` without points.
pub fn bounds(points: impl IntoIterator<Item = DVec3>) -> Option<[DVec3; 2]> {
    points.into_iter().fold(None, |b, p| Some(b.map_or([p, p], |[low, high]: [DVec3; 2]| [low.min(p), high.max(p)])))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: [DVec3; 2] = [DVec3::new(-1.0, 2.0, -3.0), DVec3::new(4.0, 3.0, 5.0)];

    #[test]
    fn a_fitted_box_fills_the_picture_and_stays_inside() {
        for projection in [Projection::Perspective { fov: 40.0 }, Projection::Orthographic { height: 1.0 }] {
            for (yaw, pitch) in [(0.0, 0.0), (30.0, 20.0), (-100.0, 90.0), (180.0, -90.0)] {
                for aspect in [0.5, 1.0, 2.0] {
                    let camera = Camera::orbit(BOX, yaw, pitch, projection, aspect);
                    let m = camera.matrix(aspect, BOX);
                    let mut most: f64 = 0.0;
                    for q in box_corners(BOX) {
                        let c = m * q.extend(1.0);
                        let n = c / c.w;
                        most = most.max(n.x.abs()).max(n.y.abs());
                        assert!(c.w > 0.0 && (0.0..=1.0).contains(&n.z), "{n}");
                    }
                    assert!((most - FILLED).abs() < 1e-9, "{most}");
                }
            }
        }
    }

    #[test]
    fn right_is_right_and_up_is_up() {
        let camera = Camera::orbit(BOX, 0.0, 0.0, Projection::Perspective { fov: 30.0 }, 1.0);
        let m = camera.matrix(1.0, BOX);
        let at = |p: DVec3| {
            let c = m * p.extend(1.0);
            c / c.w
        };
        let middle = camera.target;
        assert!(at(middle).truncate().truncate().length() < 1e-12);
        assert!(at(middle + DVec3::X).x > 0.0 && at(middle + DVec3::Y * 0.1).y < 0.0);
        assert!(at(middle + DVec3::Z).z < at(middle).z);
        assert!(Camera::orbit(BOX, 90.0, 0.0, Projection::Perspective { fov: 30.0 }, 1.0).eye.x > 4.0);
    }
}
