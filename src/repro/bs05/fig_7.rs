//! Fig. 7: frame rates and stored vertices of a static buffer and of refinement patterns.

use crate::repro::plot::{Bar, Bars};
use crate::repro::sheet::{cell, number};
use crate::repro::{Figure, ReproError, Sheet};
use serde_json::Value;

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "bs05-fig7",
    paper: "BS05",
    place: "Fig. 7",
    title: "Frame rates and stored vertices: static buffer, patterns, hardware tessellation",
    make,
};

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let out = sheet.file("run");
    // The whole grid takes minutes a repeat on a software rasteriser.
    let flags = if sheet.full() { "--repeats 5" } else { "--short" };
    let said = sheet.run(&format!("bench --grid fig7 -o {out} --size 640x480 {flags}"))?;
    let all = said["rows"].as_array().cloned().unwrap_or_default();
    let row = |r: &Value| {
        ["/level", "/coarse_triangles", "/method", "/vertices_stored", "/device_bytes", "/median_fps", "/over_static"]
            .map(|pointer| cell(r, pointer))
            .to_vec()
    };
    let rows = all.iter().map(row).collect();
    let methods = ["static", "draws", "instanced", "hardware"];
    let mut groups: Vec<(String, Vec<Option<Bar>>)> = Vec::new();
    for r in &all {
        let name = format!("{} x {}²", cell(r, "/coarse_triangles"), cell(r, "/level"));
        if groups.last().is_none_or(|(last, _)| *last != name) {
            groups.push((name, vec![None; methods.len()]));
        }
        let fps = number(r, "/median_fps");
        let at = methods.iter().position(|m| r["method"] == *m);
        if let (Some(at), Some((_, bars)), false) = (at, groups.last_mut(), fps.is_nan()) {
            bars[at] = Some(Bar { value: fps, interval: None });
        }
    }
    let bars = Bars {
        axis: "frames a second".to_owned(),
        series: methods.map(str::to_owned).to_vec(),
        groups,
        logarithmic: true,
    };
    sheet.plot("rates.svg", &bars.svg(), "Median frames a second, logarithmic")?;
    if !sheet.full() {
        sheet.note("Few frames of a part of the grid: shows that all works, measures little.");
    }
    sheet.caption(
        "The paper's two claims: patterns draw as fast as a static buffer of the whole refined mesh, and store the vertices \
         of one pattern whatever the number of coarse triangles. 4,225 and 16,641 vertices are grids of 65² and 129². Beside \
         the paper's one draw a triangle stand one instanced draw and hardware tessellation, to level 64.",
    );
    let columns =
        ["level", "coarse_triangles", "method", "vertices_stored", "device_bytes", "median_fps", "over_static"];
    sheet.table("fig7.csv", &columns, rows, "Medians over interleaved repeats; ratios are of one repeat each")
}
