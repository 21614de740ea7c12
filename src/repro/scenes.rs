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
    "unit/alpha.json",
    "unit/colour_level_0.json",
    "unit/colour_level_2.json",
    "unit/colour_one_sector.json",
    "unit/concave_face.json",
    "unit/corners_smooth.json",
    "unit/face_point.json",
    "unit/geometry_boundary.json",
    "unit/geometry_interior.json",
    "unit/geometry_level_2.json",
    "unit/handles.json",
    "unit/hole.json",
    "unit/mixed_polygons.json",
    "unit/sharp_dart.json",
    "unit/sharp_edge.json",
    "unit/sharp_three_meet.json",
    "unit/sharp_two_meet.json",
    "unit/two_components.json",
    "unit/valence_3.json",
    "unit/valence_5.json",
    "unit/valence_6.json",
];

/// Content of the scene at `path` under `scenes/`.
pub fn content(path: &str) -> Option<&'static [u8]> {
    SCENES.iter().find(|(name, _)| *name == path).map(|(_, bytes)| *bytes)
}

/// Paths of all scenes of technique `subdivision`.
pub fn subdivision() -> impl Iterator<Item = &'static str> {
    SCENES.iter().map(|(name, _)| *name).filter(|name| !name.starts_with("ferguson/") && !name.starts_with("pattern/"))
}
