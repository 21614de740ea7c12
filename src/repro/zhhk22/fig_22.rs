//! Fig. 22: bicubic and Gregory patches at extraordinary vertices.

use super::show;
use crate::repro::plot::{Bar, Bars};
use crate::repro::{Figure, ReproError, Sheet};
use serde_json::json;
use std::f64::consts::TAU;

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-fig22",
    paper: "ZHHK22",
    place: "Fig. 22",
    title: "Bicubic against Gregory patches at extraordinary vertices",
    make,
};

/// Valences shown.
const VALENCES: [u32; 5] = [3, 5, 6, 7, 9];

/// A regular polygon; its corners go through the hues.
fn polygon(n: u32) -> String {
    let turn = |i: u32| f64::from(i) / f64::from(n);
    let vertices: Vec<[f64; 2]> = (0..n).map(|i| [(TAU * turn(i)).cos(), (TAU * turn(i)).sin()]).collect();
    let hue = |i: u32, shift: f64| ((6.0 * turn(i) + shift).rem_euclid(6.0) - 3.0).abs().clamp(1.0, 2.0) - 1.0;
    let colours: Vec<[f64; 3]> = (0..n).map(|i| [hue(i, 0.0), hue(i, 4.0), hue(i, 2.0)]).collect();
    let faces = [(0..n).collect::<Vec<u32>>()];
    let name = format!("polygon of {n}");
    let scene = json!({"gradtess": 1, "name": name, "vertices": vertices, "faces": faces, "vertex_colours": colours});
    format!("{scene}\n")
}

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let mut rows = Vec::new();
    let mut groups = Vec::new();
    for n in VALENCES {
        let scene = sheet.write(&format!("polygon_{n}.json"), &polygon(n))?;
        let mut bars = Vec::new();
        for patches in ["bicubic", "gregory"] {
            let what = format!("valence {n}, {patches}");
            let cells =
                show::error(sheet, &scene, &format!("valence_{n}_{patches}"), &format!("--patches {patches}"), &what)?;
            let value = cells[0].parse().unwrap_or(f64::NAN);
            bars.push(Some(Bar { value, interval: None }));
            rows.push(vec![n.to_string(), patches.to_owned(), cells[0].clone(), cells[1].clone()]);
        }
        groups.push((format!("valence {n}"), bars));
    }
    sheet.caption(
        "A polygon of n corners leaves a vertex of valence n in the middle of M^1. At valence 3 bicubic patches (ACC1) come nearer to the \
         limit, from valence 5 on Gregory patches (ACC2) do, and only those join smoothly.",
    );
    let series = vec!["bicubic (ACC1)".to_owned(), "Gregory (ACC2)".to_owned()];
    let plot = Bars { axis: "maximum, % of sqrt 3".to_owned(), series, groups, logarithmic: false };
    sheet.plot("errors.svg", &plot.svg(), "Greatest distance of the colour from the limit")?;
    let columns = ["valence", "patches", "max_percent", "mean_percent"];
    sheet.table("errors.csv", &columns, rows, "Distance of the colour from the limit, per cent of sqrt 3")
}
