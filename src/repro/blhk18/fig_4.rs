//! Fig. 4: colour blending functions.

use super::short;
use crate::ferguson::blend::BLENDS;
use crate::repro::plot::Lines;
use crate::repro::{Figure, ReproError, Sheet};
use serde_json::{json, Value};

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "blhk18-fig4",
    paper: "BLHK18",
    place: "Fig. 4",
    title: "Colour blending functions; only the first joins curves smoothly",
    make,
};

/// Samples along a patch.
const N: usize = 33;

/// Red along the lowest row of samples of the patches, and where.
fn profile(samples: &Value) -> Vec<[f64; 2]> {
    let all = samples["samples"].as_array().into_iter().flatten();
    let low = all.filter(|s| s["v"].as_f64() == Some(0.0));
    let mut line: Vec<[f64; 2]> =
        low.filter_map(|s| Some([s.pointer("/position/0")?.as_f64()?, s.pointer("/colour/0")?.as_f64()?])).collect();
    line.sort_by(|a, b| a[0].total_cmp(&b[0]));
    line
}

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    // Three patches in a row: dark, light, middle, dark.
    let grey = [0.05, 0.95, 0.5, 0.1];
    let points: Vec<[f64; 2]> = (0..8).map(|i| [f64::from(i % 4), f64::from(i / 4)]).collect();
    let colours: Vec<[f64; 3]> = (0..8).map(|i| [grey[i % 4]; 3]).collect();
    let patches: Vec<Value> = (0..3).map(|i| json!({ "points": [i, i + 1, i + 5, i + 4] })).collect();
    let mut rows = Vec::new();
    let mut series = Vec::new();
    for (blend, name) in BLENDS {
        let scene = json!({
            "gradtess": 1, "technique": "ferguson", "name": name, "blend": name,
            "points": points, "colours": colours, "patches": patches
        });
        let file = sheet.write(&format!("{name}.json"), &format!("{scene}\n"))?;
        let picture = format!("{name}.png");
        let out = sheet.file(&picture);
        sheet.run(&format!("render {file} -o {out} --size 480x160 --pixels 1 --samples 4"))?;
        sheet.picture(&picture, format!("{name}: slopes {:?}", blend.slopes()));
        let line = profile(&sheet.run(&format!("sample {file} --n {N}"))?);
        // The slope on both sides of where the second curve begins, from four samples each: exact for a cubic.
        let jump = |at: f64| {
            let side = |sign: f64| {
                let value = |k: f64| {
                    let x = at + sign * k / (N as f64 - 1.0);
                    line.iter().find(|p| (p[0] - x).abs() < 1e-9).map_or(f64::NAN, |p| p[1])
                };
                let sum = 18.0 * value(1.0) - 11.0 * value(0.0) - 9.0 * value(2.0) + 2.0 * value(3.0);
                sign * sum / 6.0 * (N as f64 - 1.0)
            };
            (side(1.0) - side(-1.0)).abs()
        };
        let [a, b] = blend.slopes();
        rows.push(vec![name.to_owned(), a.to_string(), b.to_string(), short(jump(1.0)), short(jump(2.0))]);
        series.push((name.to_owned(), line));
    }
    sheet.caption(
        "Colour along three curves by each function: a cubic from 0 to 1 with the slopes given at its ends. Where two curves \
         meet, colour has a kink unless both slopes are 0. Curves \
         have a direction, and those along the upper side run to the left: `in` and `out` are turned there.",
    );
    let lines =
        Lines { axes: ["along the curves".to_owned(), "colour".to_owned()], logarithmic: [false, false], series };
    sheet.plot("functions.svg", &lines.svg(), "Colour along the three curves")?;
    let columns = ["function", "slope_at_0", "slope_at_1", "kink_at_first_point", "kink_at_second_point"];
    sheet.table(
        "functions.csv",
        &columns,
        rows,
        "Jump of the slope where curves meet, from four samples on either side, which is exact for cubics",
    )
}
