//! Colour blending functions (BLHK18 3.2, Fig. 4).

/// A colour blending function: the cubic from 0 to 1 with these slopes (Fig. 4). Curves run from their first point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blend {
    /// Slopes 0 and 0: the only one that joins patches with tangent continuity. The paper's choice.
    #[default]
    G1,
    /// Slopes 1 and 1: bilinear, as SVG and PDF have it.
    Linear,
    /// Slopes 0 and 2: t^2.
    In,
    /// Slopes 2 and 0: 2 t - t^2.
    Out,
    /// Slopes 2 and 2: fast at both ends, level between.
    Plateau,
}

/// All blending functions with their names.
pub const BLENDS: [(Blend, &str); 5] =
    [(Blend::G1, "g1"), (Blend::Linear, "linear"), (Blend::In, "in"), (Blend::Out, "out"), (Blend::Plateau, "plateau")];

impl Blend {
    /// Slopes at 0 and 1 of the function that runs from 0 to 1.
    pub fn slopes(self) -> [f64; 2] {
        match self {
            Blend::G1 => [0.0, 0.0],
            Blend::Linear => [1.0, 1.0],
            Blend::In => [0.0, 2.0],
            Blend::Out => [2.0, 0.0],
            Blend::Plateau => [2.0, 2.0],
        }
    }

    /// The function of a name.
    pub fn named(name: &str) -> Option<Blend> {
        BLENDS.iter().find(|(_, n)| *n == name).map(|(blend, _)| *blend)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        BLENDS[self as usize].1
    }
}
