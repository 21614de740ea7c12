//! Beside 7.2, which leaves local updates of the buffers to future work: what an edit costs against the size of the mesh.

use crate::repro::plot::Lines;
use crate::repro::sheet::{cell, number};
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-drag",
    paper: "ZHHK22",
    place: "beside Sec. 7.2",
    title: "What the drag of one handle costs against the size of the mesh",
    make,
};

/// Step of a drag in the largest sheet over that in a single copy that is wanted at most.
const WANTED: f64 = 1.5;

/// Columns of the table: as `bench --drag` names them.
const COLUMNS: [&str; 23] = [
    "copies",
    "patches",
    "drag_ms",
    "one_copy_ms",
    "over_one_copy",
    "rebuild_ms",
    "over_rebuild",
    "drag_faces",
    "drag_bytes",
    "redo_ms",
    "undo_ms",
    "one_copy_redo_ms",
    "one_copy_undo_ms",
    "handle_came",
    "handle_patches",
    "handle_bytes",
    "first_handle_ms",
    "removal_ms",
    "load_ms",
    "prepare_ms",
    "host_bytes_per_patch",
    "control_bytes",
    "index_bytes",
];

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let mut models = vec![("our cherry", sheet.scene("cherry.json")?)];
    models.extend(sheet.model("cherry/cherry_editAtSubd5.obj").map(|file| ("cherry 5", file)));
    let most = if sheet.full() { 1024 } else { 64 };
    let steps = sheet.frames().map_or(101, |n| n.max(3));
    let mut rows = Vec::new();
    let mut series = Vec::new();
    let mut found = Vec::new();
    for (name, scene) in models {
        let folder = sheet.file(&name.replace(' ', "_"));
        let done = sheet.run(&format!("bench {scene} -o {folder} --drag --copies {most} --frames {steps}"))?;
        let sheets = done["rows"].as_array().map_or(0, Vec::len);
        let line = |what: &str| {
            let at = |i: usize| ["copies", what].map(|what| number(&done, &format!("/rows/{i}/{what}")));
            (0..sheets).map(at).filter(|[_, ms]| ms.is_finite()).collect::<Vec<_>>()
        };
        for (what, field) in [
            ("everything rebuilt", "rebuild_ms"),
            ("step of a drag", "drag_ms"),
            ("a handle comes", "redo_ms"),
            ("a handle goes", "undo_ms"),
        ] {
            series.push((format!("{name}: {what}"), line(field)));
        }
        for i in 0..sheets {
            let cells = COLUMNS.map(|column| cell(&done, &format!("/rows/{i}/{column}")));
            rows.push([vec![name.to_owned()], cells.into()].concat());
        }
        let last = |what: &str| number(&done, &format!("/rows/{}/{what}", sheets.saturating_sub(1)));
        let ratio = last("over_one_copy");
        let met = if ratio <= WANTED { "met" } else { "not met" };
        found.push(format!(
            "{name}, {} patches: {ratio:.2} times a single copy's, {:.4} % of a rebuild",
            last("patches"),
            100.0 * last("over_rebuild")
        ));
        found.push(format!("at most {WANTED} times wanted: {met}"));
    }
    sheet.caption(format!(
        "The model in sheets of 1 to {most} copies, welded into one mesh. One handle of the finest level is dragged; another one of that \
         level comes and goes, and refinement with it; both are followed in place, with the bits of a rebuild. For comparison \
         everything is rebuilt. Times are those of the processor up to the device, without drawing; steps in the sheet take turns with \
         steps in a single copy. {}.",
        found.join("; ")
    ));
    let plot = Lines { axes: ["copies".to_owned(), "median, ms".to_owned()], logarithmic: [true, true], series };
    sheet.plot("drag.svg", &plot.svg(), "Time of an edit against the copies in the sheet, both logarithmic")?;
    let columns = [&["model"][..], &COLUMNS].concat();
    sheet.table(
        "drag.csv",
        &columns,
        rows,
        "Times in ms; memory of the host with everything that edits need, bytes a patch; control points and indices on the device, bytes",
    )
}
