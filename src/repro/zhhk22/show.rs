//! Pictures, meshes and errors that several figures show in the same way.

use crate::repro::plot::Mesh;
use crate::repro::sheet::cell;
use crate::repro::{ReproError, Sheet};
use serde_json::Value;

/// Columns of [`error`]'s cells.
pub const ERROR_COLUMNS: [&str; 7] = [
    "max_percent",
    "mean_percent",
    "bicubic_max_percent",
    "gregory_max_percent",
    "worst_kind",
    "worst_level",
    "edge_pixels_left_out",
];

/// Draws a scene with `flags` into `NAME.png`, and shows it.
pub fn picture(sheet: &mut Sheet, scene: &str, name: &str, flags: &str, caption: &str) -> Result<Value, ReproError> {
    let file = format!("{name}.png");
    let out = sheet.file(&file);
    let drawn = sheet.run(&format!("render {scene} -o {out} --size 480x480 --samples 4 {flags}"))?;
    sheet.picture(&file, caption);
    Ok(drawn)
}

/// Patches as the fewest triangles, their edges drawn.
pub fn wire(sheet: &mut Sheet, scene: &str, name: &str, flags: &str, caption: &str) -> Result<Value, ReproError> {
    picture(sheet, scene, name, &format!("--show wire --tess 1 {flags}"), caption)
}

/// The distance of a scene's picture from the limit, as `NAME.png`, and its cells ([`ERROR_COLUMNS`]). Segments are a pixel
/// long: coarser ones are chords whose own error hides that of the patches.
pub fn error(sheet: &mut Sheet, scene: &str, name: &str, flags: &str, what: &str) -> Result<Vec<String>, ReproError> {
    let file = format!("{name}.png");
    let out = sheet.file(&file);
    let found = sheet.run(&format!("check {scene} -o {out} --zooms 0 --size 480x480 --pixels 1 {flags}"))?;
    let max = found.pointer("/error/max_percent").and_then(Value::as_f64);
    let max = max.map_or_else(|| "nothing to compare".to_owned(), |x| format!("maximum {x:.3} %"));
    sheet.picture(&file, format!("{what}, distance from the limit × 200: {max}"));
    Ok(error_cells(&found))
}

/// The same cells without a picture, at a tessellation of the caller's.
pub fn error_at(sheet: &mut Sheet, scene: &str, flags: &str) -> Result<Vec<String>, ReproError> {
    Ok(error_cells(&sheet.run(&format!("check {scene} --zooms 0 --size 480x480 {flags}"))?))
}

fn error_cells(found: &Value) -> Vec<String> {
    let at = ["max_percent", "mean_percent", "bicubic/max_percent", "gregory/max_percent", "worst/kind", "worst/level"];
    at.iter().chain(&["edge_pixels"]).map(|key| cell(found, &format!("/error/{key}"))).collect()
}

/// Faces of a whole mesh as `gradtess mesh` prints it: their corners.
pub fn faces(mesh: &Value) -> Vec<Vec<[f64; 2]>> {
    let points: Vec<[f64; 2]> = mesh["vertices"].as_array().into_iter().flatten().filter_map(point).collect();
    let corners = |face: &Value| -> Vec<[f64; 2]> {
        let numbers = face.as_array().into_iter().flatten().filter_map(Value::as_u64);
        numbers.filter_map(|v| points.get(v as usize).copied()).collect()
    };
    mesh["faces"].as_array().into_iter().flatten().map(corners).collect()
}

/// The mesh M^0 of a scene as `NAME.svg`, non-quads marked; returns how many faces it has, and how many are no quads.
pub fn base_mesh(sheet: &mut Sheet, scene: &str, name: &str, caption: &str) -> Result<[usize; 2], ReproError> {
    let faces = faces(&sheet.run(&format!("mesh {scene} --level 0"))?);
    let counts = [faces.len(), faces.iter().filter(|corners| corners.len() != 4).count()];
    let fill = |corners: Vec<[f64; 2]>| {
        let other = usize::from(corners.len() != 4);
        (corners, other)
    };
    let mesh = Mesh {
        fills: vec!["quads".to_owned(), "other polygons".to_owned()],
        faces: faces.into_iter().map(fill).collect(),
    };
    sheet.plot(&format!("{name}.svg"), &mesh.svg(), caption)?;
    Ok(counts)
}

/// Corners A, B, C, D of a patch as `gradtess patches` prints it.
pub fn corners(patch: &Value) -> Vec<[f64; 2]> {
    [0, 3, 15, 12].iter().filter_map(|&i| point(&patch["control"][i])).collect()
}

fn point(value: &Value) -> Option<[f64; 2]> {
    Some([value.get(0)?.as_f64()?, value.get(1)?.as_f64()?])
}
