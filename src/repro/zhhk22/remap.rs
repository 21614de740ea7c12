//! Beside Sec. 3.4: transition patches as five constellations, or in one piece with remapped edges.

use super::show;
use super::timing::{median, protocol};
use crate::repro::plot::Bars;
use crate::repro::sheet::cell;
use crate::repro::{Figure, ReproError, Sheet};
use serde_json::Value;

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-remap",
    paper: "ZHHK22",
    place: "beside Fig. 4",
    title: "Transition patches: five constellations against one pipeline with remapped edges",
    make,
};

/// Ways to draw transition patches.
const WAYS: [&str; 3] = ["constellations", "remap", "remap-own"];

/// Tessellation rules that are compared.
const RULES: [&str; 3] = ["--tess 8", "--tess-base 32", "--pixels 4"];

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let mut scenes = vec![
        ("geometry edit on level 2", sheet.scene("unit/geometry_level_2.json")?),
        ("our cherry", sheet.scene("cherry.json")?),
    ];
    scenes.extend(sheet.model("cherry/cherry_editAtSubd5.obj").map(|model| ("cherry", model)));
    for way in &WAYS[..2] {
        let flags = format!("--show wire --tess 4 --transitions {way}");
        show::picture(sheet, &scenes[0].1, way, &flags, &format!("{way}, --tess 4"))?;
    }
    let (mut seams, mut times, mut groups) = (Vec::new(), Vec::new(), Vec::new());
    for (name, scene) in &scenes {
        for way in WAYS {
            let out = sheet.file("drawn.png");
            let drawn = sheet.run(&format!("render {scene} -o {out} --size 64x64 --tess 1 --transitions {way}"))?;
            let found = sheet.run(&format!(
                "check {scene} --transitions {way} --tess 7 --seams --zooms 20 --size 256x256 --max-cracks 1000000"
            ))?;
            let keys = ["/seams/segments", "/seams/open_segments", "/pixels_inside", "/crack_pixels"];
            let cells = keys.iter().chain(&["/error/max_percent", "/error/mean_percent"]).map(|key| cell(&found, key));
            seams.push(
                [(*name).to_owned(), way.to_owned(), cell(&drawn, "/draws"), cell(&drawn, "/device_bytes")]
                    .into_iter()
                    .chain(cells)
                    .collect(),
            );
        }
        for rule in RULES {
            let folder = sheet.file(&format!("{name} {rule}").replace([' ', '-'], "_"));
            let protocol = protocol(sheet);
            let done =
                sheet.run(&format!("bench {scene} -o {folder} {rule}{protocol} --pair '--transitions remap'"))?;
            times.push(row(name, rule, &done));
            groups.push((format!("{name}\n{rule}"), vec![Some(median(&done, 0)), Some(median(&done, 1))]));
        }
    }
    sheet.caption(
        "Transition patches drawn as the parts of five constellations (NLMD12), as the paper has them, and in one piece: a split \
         edge gets the segments of both finer neighbours (OpenSubdiv). Remap evaluates the vertices of split edges on the \
         neighbours' control points and has no gap; remap-own evaluates them on the patch itself, as OpenSubdiv does, \
         which leaves gaps of a rounding and, at Gregory patches, more. Segments are those of all sides of patches at --tess 7; open ones have not the same bits on both sides. \
         Levels go up to 32 only, half of what a device has.",
    );
    let series = vec!["constellations".to_owned(), "remap".to_owned()];
    let bars = Bars { axis: "median frame, ms".to_owned(), series, groups, logarithmic: true };
    sheet.plot("times.svg", &bars.svg(), "Median time of a frame without edits and its 95 % interval, logarithmic")?;
    let columns = [
        "scene",
        "tessellation",
        "remap_over_constellations",
        "ratio_low",
        "ratio_high",
        "verdict",
        "constellations_median_ms",
        "remap_median_ms",
        "constellations_triangles",
        "remap_triangles",
        "constellations_vertices",
        "remap_vertices",
    ];
    sheet.table("times.csv", &columns, times, "Frames measured in turns; a ratio below 1: remap is faster")?;
    let columns = [
        "scene",
        "transitions",
        "draws",
        "device_bytes",
        "segments",
        "open_segments",
        "pixels_inside",
        "crack_pixels",
        "max_percent",
        "mean_percent",
    ];
    sheet.table(
        "seams.csv",
        &columns,
        seams,
        "Draw calls and bytes on the device; segments whose sides differ; background pixels inside in 21 views up to 1000 times magnified; \
         distance of the colour from the limit, per cent of sqrt 3",
    )
}

fn row(name: &str, rule: &str, done: &Value) -> Vec<String> {
    let mut row = vec![name.to_owned(), rule.to_owned()];
    for what in ["ratio", "ci95/0", "ci95/1", "verdict"] {
        row.push(cell(done, &format!("/pairs/0/ratios/cpu_frame/median/{what}")));
    }
    for what in ["results/cpu_frame/p50", "counted_triangles", "counted_vertices"] {
        row.extend([0, 1].map(|i| cell(done, &format!("/runs/{i}/{what}"))));
    }
    row
}
