//! How finely to tessellate. Twin of `glsl/inc/levels.glsl`.

use super::{remap, DrawRange, Kind};

/// The greatest tessellation level that every Vulkan device has.
pub const MAX_LEVEL: f32 = 64.0;

/// How the tessellation level of a patch's side is found. Levels are integers; fractions round up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TessRule {
    /// The same level T for every side of every patch and part, 1 to 64 (`--tess T`).
    Fixed(f32),
    /// T / 2^l for the patches of level l, at least 1 and at most 64 (`--tess-base T`). The half edges of a transition
    /// part take the level of the finer neighbour.
    Base(f32),
    /// Segments of about this many pixels: each side's level is the length of its control polygon over this number
    /// (`--pixels P`).
    Pixels(f32),
}

/// Level of one kind of side each, as the control shader gets them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// Whole edges of the face.
    pub full: f32,
    /// Halves of transition edges.
    pub half: f32,
    /// Sides inside the face.
    pub inner: f32,
    /// Pixels a segment, at most `full` segments; 0: the three levels count.
    pub pixels: f32,
}

impl TessRule {
    /// Checks the number.
    ///
    /// # Errors
    /// What is wrong and what to do, when it is not finite, not positive, or a fixed level above 64.
    pub fn check(self) -> Result<(), String> {
        self.check_to(MAX_LEVEL)
    }

    /// The same where no level may exceed `most` ([`greatest`]).
    ///
    /// # Errors
    /// As [`TessRule::check`].
    pub fn check_to(self, most: f32) -> Result<(), String> {
        let (TessRule::Fixed(x) | TessRule::Base(x) | TessRule::Pixels(x)) = self;
        if !x.is_finite() || x <= 0.0 {
            let what = if matches!(self, TessRule::Pixels(_)) { "pixels a segment" } else { "tessellation level" };
            return Err(format!("{what} {x} is not a positive number; give one above 0"));
        }
        if matches!(self, TessRule::Fixed(_)) && x > most {
            return Err(match most < MAX_LEVEL {
                true => format!("tessellation level {x} is above {most}, the most that remapped transition faces take"),
                false => format!("tessellation level {x} is above 64, the most a device has to have"),
            });
        }
        Ok(())
    }

    /// Levels of the sides of patches at subdivision level `level`.
    pub fn levels(self, level: u32) -> Levels {
        self.levels_to(level, MAX_LEVEL)
    }

    /// The same where no level exceeds `most` ([`greatest`]).
    pub fn levels_to(self, level: u32, most: f32) -> Levels {
        let integer = |x: f32| x.ceil().clamp(1.0, most);
        match self {
            TessRule::Fixed(t) => Levels { full: integer(t), half: integer(t), inner: integer(t), pixels: 0.0 },
            TessRule::Base(t) => {
                let at = |l: u32| integer(t / 2f32.powi(l.min(100) as i32));
                Levels { full: at(level), half: at(level.saturating_add(1)), inner: at(level), pixels: 0.0 }
            }
            TessRule::Pixels(p) => Levels { full: most, half: most, inner: most, pixels: p },
        }
    }
}

/// Greatest level that a table with these ranges can have and stay without cracks.
pub fn greatest(ranges: &[DrawRange]) -> f32 {
    let remapped = |range: &DrawRange| matches!(range.kind, Kind::RemappedBicubic | Kind::RemappedGregory);
    if ranges.iter().any(remapped) {
        remap::MOST
    } else {
        MAX_LEVEL
    }
}

/// Vertices that the tessellator makes of a quad domain with the same integer level `n` on all sides: (n + 1)^2.
pub fn quad_vertices(n: u64) -> u64 {
    (n + 1) * (n + 1)
}

/// Vertices of a triangle domain with the same integer level `n` on all sides. Rings of n, n - 2, ... segments a side
/// have 3 n + 3 (n - 2) + ... vertices: 3 ((n + 1) / 2)^2 for odd n, and 3 (n / 2) (n / 2 + 1) + 1 for even n, where
/// the innermost ring is a point.
pub fn triangle_vertices(n: u64) -> u64 {
    if n % 2 == 1 {
        3 * n.div_ceil(2).pow(2)
    } else {
        3 * (n / 2) * (n / 2 + 1) + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_follow_the_rules() {
        let fixed = TessRule::Fixed(3.2).levels(7);
        assert_eq!((fixed.full, fixed.half, fixed.inner, fixed.pixels), (4.0, 4.0, 4.0, 0.0));
        let base = TessRule::Base(16.0).levels(2);
        assert_eq!((base.full, base.half, base.inner), (4.0, 2.0, 4.0));
        let base = TessRule::Base(16.0).levels(9);
        assert_eq!((base.full, base.half, base.inner), (1.0, 1.0, 1.0));
        assert_eq!(TessRule::Base(1000.0).levels(0).full, 64.0);
    }

    #[test]
    fn senseless_numbers_are_requests() {
        for rule in [TessRule::Fixed(0.0), TessRule::Fixed(65.0), TessRule::Base(f32::NAN), TessRule::Pixels(-1.0)] {
            assert!(rule.check().is_err());
        }
        assert!(TessRule::Base(256.0).check().is_ok());
    }

    #[test]
    fn triangle_rings_sum_up() {
        assert_eq!([1, 2, 3, 4, 5].map(triangle_vertices), [3, 7, 12, 19, 27]);
    }
}
