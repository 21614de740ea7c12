//! The project's own scenes, within the program: a figure needs nothing but the program.

/// Scenes by their paths under `scenes/`.
macro_rules! scenes {
    ($($path:literal),* $(,)?) => {
        &[$(($path, include_bytes!(concat!("../../scenes/", $path)))),*]
    };
}

/// Path under `scenes/` and content.
const SCENES: &[(&str, &[u8])] = scenes![
    "cherry.json",
    "triangle.json",
    "quad.json",
    "pentagon.json",
    "hexagon.json",
    "ferguson/branching.json",
    "ferguson/colour_spaces.json",
    "ferguson/local_refinement.json",
    "ferguson/radial.json",
    "ferguson/sections.json",
    "ferguson/sharp_colours.json",
    "ferguson/still_life.json",
    "pattern/ball.json",
    "pattern/character.json",
    "pattern/ocean.json",
    "pattern/sphere.json",
    "unit/geometry_level_2.json",
    "unit/colour_level_2.json",
    "unit/sharp_dart.json",
    "unit/sharp_three_meet.json",
    "unit/sharp_two_meet.json",
    "unit/hole.json",
    "unit/mixed_polygons.json",
    "unit/valence_5.json",
];

/// Content of the scene at `path` under `scenes/`.
pub fn content(path: &str) -> Option<&'static [u8]> {
    SCENES.iter().find(|(name, _)| *name == path).map(|(_, bytes)| *bytes)
}
