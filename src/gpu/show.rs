//! What a picture shows, and the colours that stand for kinds and levels.

use crate::patch::transition::PARTS;
use crate::patch::Kind;

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Show {
    /// The interpolated colour.
    #[default]
    Surface,
    /// The tessellation as dark lines on the background.
    Wire,
    /// The tessellation over the surface.
    SurfaceWire,
    /// One colour for each kind and constellation, see [`patch_colour`].
    Patches,
    /// One colour for each subdivision level, see [`level_colour`].
    Levels,
}

/// Colour of the lines of a wireframe, straight alpha.
pub const WIRE_COLOUR: [f32; 4] = [0.1, 0.1, 0.12, 1.0];

/// Colour of a kind and constellation in [`Show::Patches`]: blue to green for bicubic, red to yellow for Gregory, the
/// parts of a constellation in two shades so that they can be told apart.
pub fn patch_colour(kind: Kind, part: Option<u8>) -> [f32; 4] {
    let [r, g, b] = match (kind, part.map(|number| PARTS[number as usize].constellation)) {
        (Kind::Bicubic, None) => [0.45, 0.60, 0.85],
        (Kind::Bicubic, Some(1)) => [0.30, 0.75, 0.80],
        (Kind::Bicubic, Some(2)) => [0.25, 0.70, 0.60],
        (Kind::Bicubic, Some(3)) => [0.35, 0.75, 0.40],
        (Kind::Bicubic, Some(4)) => [0.55, 0.80, 0.35],
        (Kind::Bicubic, Some(_)) => [0.75, 0.85, 0.45],
        (Kind::Stitched, _) => [0.50, 0.70, 0.90],
        (Kind::RemappedBicubic, _) => [0.30, 0.75, 0.60],
        (Kind::RemappedGregory, _) => [0.95, 0.65, 0.30],
        (Kind::Gregory, None) => [0.85, 0.35, 0.30],
        (Kind::Gregory, Some(1)) => [0.90, 0.50, 0.25],
        (Kind::Gregory, Some(2)) => [0.95, 0.60, 0.25],
        (Kind::Gregory, Some(3)) => [0.95, 0.70, 0.30],
        (Kind::Gregory, Some(4)) => [0.95, 0.80, 0.35],
        (Kind::Gregory, Some(_)) => [0.95, 0.90, 0.50],
    };
    let shade = if part.is_some_and(|number| number % 2 == 1) { 0.85 } else { 1.0 };
    [r * shade, g * shade, b * shade, 1.0]
}

/// Colour of a subdivision level in [`Show::Levels`]; they repeat after eight.
pub fn level_colour(level: u32) -> [f32; 4] {
    const COLOURS: [[f32; 3]; 8] = [
        [0.85, 0.85, 0.88],
        [0.56, 0.72, 0.90],
        [0.45, 0.80, 0.62],
        [0.93, 0.85, 0.40],
        [0.95, 0.62, 0.33],
        [0.88, 0.40, 0.40],
        [0.70, 0.45, 0.75],
        [0.42, 0.38, 0.68],
    ];
    let [r, g, b] = COLOURS[level as usize % COLOURS.len()];
    [r, g, b, 1.0]
}
