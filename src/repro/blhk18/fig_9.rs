//! Fig. 9: how exact a split is.

use super::difference;
use crate::repro::{Figure, ReproError, Sheet};
use serde_json::{json, Value};
use std::collections::HashMap;

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "blhk18-fig9",
    paper: "BLHK18",
    place: "Fig. 9",
    title: "A patch before and after splits: nothing changes",
    make,
};

/// Samples of the whole patch along a side; those of halves and quarters fall on the same places.
const N: usize = 65;

/// Position and colour at (u, v) of the root, in steps of 1 / (N - 1).
fn by_place(samples: &Value, patches: &Value, n: usize) -> HashMap<[u64; 2], [f64; 6]> {
    let part = |face: u64| {
        let patch = patches["patches"].as_array().into_iter().flatten().find(|p| p["patch"].as_u64() == Some(face));
        let part: Vec<f64> =
            patch.and_then(|p| p["part"].as_array()).into_iter().flatten().filter_map(Value::as_f64).collect();
        part
    };
    let mut parts: HashMap<u64, Vec<f64>> = HashMap::new();
    let mut found = HashMap::new();
    for s in samples["samples"].as_array().into_iter().flatten() {
        let face = s["face"].as_u64().unwrap_or_default();
        let p = parts.entry(face).or_insert_with(|| part(face));
        let &mut [u0, v0, u1, v1] = &mut p[..] else { continue };
        let number = |pointer: &str| s.pointer(pointer).and_then(Value::as_f64).unwrap_or(f64::NAN);
        let step = |low: f64, high: f64, t: f64| ((low + (high - low) * t) * (n as f64 - 1.0)).round() as u64;
        let place = [step(u0, u1, number("/u")), step(v0, v1, number("/v"))];
        let value = ["/position/0", "/position/1", "/colour/0", "/colour/1", "/colour/2", "/colour/3"].map(number);
        found.insert(place, value);
    }
    found
}

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let splits = [
        ("before", json!([])),
        ("vertical", json!([{ "split": 0, "u": 0.5 }])),
        ("cross", json!([{ "split": 0, "u": 0.5 }, { "split": 0, "v": 0.5 }, { "split": 1, "v": 0.5 }])),
        (
            "nested",
            json!([{ "split": 0, "u": 0.25 }, { "split": 1, "v": 0.5 }, { "split": 2, "u": 1.0 / 3.0 }, { "split": 3, "v": 0.5 }]),
        ),
    ];
    let mut whole = HashMap::new();
    let mut rows = Vec::new();
    for (name, operations) in splits {
        // Bent on all sides, and twisted: the hardest patch that there is.
        let scene = json!({
            "gradtess": 1, "technique": "ferguson", "name": name,
            "points": [[0, 0], [100, 10], [90, 100], [-10, 80]],
            "curves": [
                { "points": [0, 1], "handles": [[30, -25], [60, 40]] }, { "points": [1, 2], "handles": [[125, 40], [75, 70]] },
                { "points": [2, 3], "handles": [[60, 120], [30, 60]] }, { "points": [3, 0], "handles": [[-35, 50], [10, 30]] }
            ],
            "patches": [{
                "points": [0, 1, 2, 3], "twists": [[40, -20], [-30, 50], [20, 30], [60, -10]],
                "colours": [[0.95, 0.2, 0.1], [0.98, 0.9, 0.2], [0.1, 0.5, 0.9], [0.05, 0.3, 0.25]]
            }],
            "operations": operations
        });
        let file = sheet.write(&format!("{name}.json"), &format!("{scene}\n"))?;
        let picture = format!("{name}.png");
        let out = sheet.file(&picture);
        sheet.run(&format!("render {file} -o {out} --size 512x512 --view -30,-20,130,140 --pixels 1"))?;
        sheet.picture(&picture, name);
        let patches = sheet.run(&format!("patches {file}"))?;
        let count = patches["patches"].as_array().map_or(0, Vec::len);
        let values = by_place(&sheet.run(&format!("sample {file} --n {N}"))?, &patches, 48 * (N - 1) + 1);
        if name == "before" {
            whole = values;
            continue;
        }
        let (mut position, mut colour, mut compared) = (0.0f64, 0.0f64, 0);
        for (place, value) in &values {
            let Some(old) = whole.get(place) else { continue };
            compared += 1;
            let apart = |range: std::ops::Range<usize>| range.map(|k| (value[k] - old[k]).abs()).fold(0.0, f64::max);
            (position, colour) = (position.max(apart(0..2) / 160.0), colour.max(apart(2..6)));
        }
        let (most, differ) = difference(&sheet.read_picture("before.png")?, &sheet.read_picture(&picture)?);
        rows.push(vec![
            name.to_owned(),
            count.to_string(),
            compared.to_string(),
            format!("{position:.1e}"),
            format!("{colour:.1e}"),
            most.to_string(),
            differ.to_string(),
        ]);
    }
    sheet.caption(
        "One patch with bent sides and twists, cut in one direction, in both, and again in its parts. The paper thresholds \
         the differences of 8-bit pictures: of Illustrator, CorelDRAW and Inkscape they show; of exact splits only what \
         tessellation does. The numbers here are of the surface itself, in double precision, and of the pictures.",
    );
    let columns =
        ["split", "patches", "samples", "position_of_canvas", "colour_of_1", "picture_255", "pixels_that_differ"];
    sheet.table("exactness.csv", &columns, rows, "Greatest change of position, colour, and of the picture")
}
