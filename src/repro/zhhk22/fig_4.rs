//! Fig. 4: the constellations of transition patches (NLMD12).

use super::show::{self, corners};
use crate::repro::sheet::cell;
use crate::repro::{Figure, ReproError, Sheet};
use serde_json::Value;

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-fig4",
    paper: "ZHHK22",
    place: "Fig. 4",
    title: "The five constellations of transition patches",
    make,
};

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let scene = sheet.scene("cherry.json")?;
    let listed = sheet.run(&format!("patches {scene}"))?;
    let patches = || listed["patches"].as_array().into_iter().flatten();
    let mut rows = Vec::new();
    for constellation in 1..=5 {
        let all: Vec<&Value> = patches().filter(|p| p["constellation"].as_u64() == Some(constellation)).collect();
        let Some(patch) = all.iter().max_by(|a, b| extent(a).0.total_cmp(&extent(b).0)) else {
            return Err(ReproError::Figure(format!("the cherry has no patch of constellation {constellation}")));
        };
        let (size, [x, y]) = extent(patch);
        let view = [x - size, y - size, x + size, y + size].map(|v| format!("{v:.6}")).join(",");
        let flags = format!("--show patches --tess 1 --view {view}");
        let name = format!("constellation_{constellation}");
        show::picture(sheet, &scene, &name, &flags, &format!("Constellation {constellation}, in the middle"))?;
        let transition = cell(patch, "/transition");
        let edges = transition.matches('1').count();
        rows.push(vec![
            constellation.to_string(),
            all.len().to_string(),
            cell(patch, "/level"),
            edges.to_string(),
            transition,
            cell(patch, "/kind"),
        ]);
    }
    sheet.caption(
        "A patch next to finer ones is drawn in parts, so that all evaluate the shared edges at the same places. One patch of each \
         constellation in the cherry: transition patches green to yellow by constellation, Gregory patches red, others blue.",
    );
    let columns = ["constellation", "in_the_cherry", "level_shown", "transition_edges", "edges_shown", "kind_shown"];
    sheet.table("constellations.csv", &columns, rows, "Transition patches of the cherry, and those that are shown")
}

/// Largest side of the box around a patch's corners, and its middle.
fn extent(patch: &Value) -> (f64, [f64; 2]) {
    let points = corners(patch);
    let range = |axis: usize| {
        points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], p| [l.min(p[axis]), h.max(p[axis])])
    };
    let [[x0, x1], [y0, y1]] = [range(0), range(1)];
    ((x1 - x0).max(y1 - y0), [0.5 * (x0 + x1), 0.5 * (y0 + y1)])
}
