//! `gradtess bench SCENE --drag`: what an edit costs against the size of the mesh.
//!
//! The scene is welded into sheets of 1, 4, 16, ... copies. In each, one handle of the finest level is dragged, a new one
//! comes and goes, and everything is rebuilt, each up to the device and without drawing. Steps in the sheet take turns
//! with steps in a single copy, so that what else the machine does meets both: their ratio is that of one run.

use crate::command::open::Loaded;
use crate::command::{print, print_json, silent, Failure, Global};
use crate::gpu::{DeviceTable, Gpu};
use crate::incremental::{Delta, Outcome, Splice, State, Touched, ValueEdit};
use crate::patch::build::build;
use crate::patch::points::Irregular;
use crate::refine::{refine, Options};
use crate::scene::copies::copies;
use crate::scene::{write_atomically, Frame, GeometryEdit, Scene};
use crate::subdiv::index_map::IndexMap;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

/// What is measured.
pub struct Request<'a> {
    /// Folder of `drag.csv` and `drag.json`.
    pub folder: &'a Path,
    /// Copies in the largest sheet.
    pub most: u32,
    /// Steps of each drag.
    pub steps: u32,
}

/// One sheet. Times are medians in ms, up to the device.
#[derive(Serialize)]
struct Row {
    copies: u32,
    patches: usize,
    /// Mesh, levels and patches from the scene in memory, and their first upload.
    load_ms: f64,
    /// Ways back from edits to patches, which the first edit makes.
    prepare_ms: f64,
    /// A rebuild of everything and its upload.
    rebuild_ms: f64,
    /// A step of a drag followed in place.
    drag_ms: f64,
    /// The same step in a single copy, in turns with it.
    one_copy_ms: f64,
    over_one_copy: f64,
    over_rebuild: f64,
    drag_faces: usize,
    drag_bytes: u64,
    /// The first handle that comes.
    first_handle_ms: Option<f64>,
    /// A handle that comes (redo) and one that goes (undo).
    redo_ms: Option<f64>,
    undo_ms: Option<f64>,
    /// The dragged handle, which was there from the beginning, goes: what else asks for its faces is counted.
    removal_ms: f64,
    /// Redo and undo in a single copy, in turns with those.
    one_copy_redo_ms: Option<f64>,
    one_copy_undo_ms: Option<f64>,
    /// Faces of the levels that come with it.
    handle_came: Option<usize>,
    /// Patches that are drawn anew for it, and bytes uploaded.
    handle_patches: Option<usize>,
    handle_bytes: Option<u64>,
    /// What the host holds of the scene, with everything that edits need, after all of these.
    host_bytes: usize,
    host_bytes_per_patch: f64,
    control_bytes: u64,
    index_bytes: u64,
}

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    scene: String,
    device: String,
    debug_build: bool,
    /// Level of the handle.
    level: u32,
    /// Whether the handle is not in the scene's file.
    added: bool,
    steps: u32,
    rows: Vec<Row>,
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => f64::NAN,
        n => 0.5 * (values[(n - 1) / 2] + values[n / 2]),
    }
}

fn ms(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

/// A sheet that edits are followed in, on host and device.
struct Sheet {
    state: State,
    table: DeviceTable,
}

/// An edit in place: time, bytes, what it touched.
struct Step {
    ms: f64,
    bytes: u64,
    touched: Touched,
}

impl Sheet {
    fn apply(&mut self, gpu: &Gpu, delta: &Delta) -> Result<Option<Step>, Failure> {
        let start = Instant::now();
        let Outcome::Local(touched) = self.state.apply(delta).map_err(Failure::input)? else {
            gpu.update(&mut self.table, &self.state.table)?;
            return Ok(None);
        };
        let changed = &touched.changed;
        let uploaded = match changed.indices.is_empty() {
            true => gpu.update_points(&mut self.table, &self.state.table, &changed.control),
            false => gpu.update_parts(&mut self.table, &self.state.table, &changed.control, &changed.indices),
        }?;
        Ok(Some(Step { ms: ms(start), bytes: uploaded.bytes, touched }))
    }

    /// Step `i` of the drag of a handle that is at `a`, `b`.
    fn drag(&mut self, gpu: &Gpu, handle: u32, [a, b]: [f64; 2], i: u32) -> Result<Step, Failure> {
        let x = 0.01 * f64::from(1 + i % 16);
        let delta = Delta::of(vec![ValueEdit::Geometry(handle, [a + x, b - x])]);
        self.apply(gpu, &delta)?.ok_or_else(|| Failure::machine("a drag was not followed in place"))
    }
}

/// The handle that is dragged: the first of the finest level inside the scene, where welds change nothing.
fn deepest(loaded: &Loaded) -> Option<usize> {
    let map = IndexMap::new(&loaded.mesh);
    let inner = |e: &GeometryEdit| {
        let closed = |first| {
            let mut spoke = map.spoke_after(e.level, first);
            while let Some(s) = spoke.filter(|&s| s != first) {
                spoke = map.spoke_after(e.level, s);
            }
            spoke == Some(first)
        };
        e.frame == Frame::Sector && map.from_app_a(e.level, e.half_edge).is_some_and(closed)
    };
    let edits = loaded.scene.geometry.iter().enumerate().filter(|(_, e)| inner(e));
    edits.min_by_key(|(i, e)| (u32::MAX - e.level, *i)).map(|(i, _)| i)
}

fn splice(scene: &Scene, removed: usize, added: Vec<GeometryEdit>) -> Delta {
    let at = scene.geometry.len() - removed;
    Delta { geometry: Splice { at, removed, added }, ..Delta::of(Vec::new()) }
}

/// A handle of the same level that no edit has refined for yet.
fn new_handle(sheet: &mut Sheet, gpu: &Gpu, loaded: &Loaded, level: u32) -> Result<Option<GeometryEdit>, Failure> {
    let map = IndexMap::new(&loaded.mesh);
    let edges = u64::from(loaded.mesh.half_edges());
    for h in 0..edges {
        // Inside the edge quad of the half-edge.
        let slot = (8 * h + 6) << (2 * level);
        let half_edge = map.to_app_a(level, slot);
        let edit = GeometryEdit { level, half_edge, vertex: None, a: 0.05, b: 0.03, frame: Frame::Sector };
        if sheet.state.scene.geometry.iter().any(|e| (e.level, e.half_edge) == (level, half_edge)) {
            continue;
        }
        let come = splice(&sheet.state.scene, 0, vec![edit]);
        let came = sheet.apply(gpu, &come)?.map_or(0, |step| step.touched.came);
        let go = splice(&sheet.state.scene, 1, Vec::new());
        sheet.apply(gpu, &go)?;
        if came > 0 {
            return Ok(Some(edit));
        }
    }
    Ok(None)
}

fn load(gpu: &Gpu, scene: Scene) -> Result<Sheet, Failure> {
    let state = State::new(scene, Options::default(), Irregular::Gregory).map_err(Failure::input)?;
    // With room to grow, as in the editor.
    let table = gpu.upload_with_room(&state.table)?;
    Ok(Sheet { state, table })
}

fn row(
    request: &Request,
    gpu: &Gpu,
    loaded: &Loaded,
    one: &mut Sheet,
    [handle, n]: [u32; 2],
    new: Option<GeometryEdit>,
) -> Result<Row, Failure> {
    let scene = copies(&loaded.scene, n).map_err(Failure::input)?;
    let dragged = &loaded.scene.geometry[handle as usize];
    let same = |e: &GeometryEdit| (e.level, e.half_edge) == (dragged.level, dragged.half_edge);
    let own = scene.geometry.iter().position(same).ok_or_else(|| Failure::machine("a weld took the handle"))? as u32;
    let at = [dragged.a, dragged.b];
    let start = Instant::now();
    let mut sheet = load(gpu, scene)?;
    let load_ms = ms(start);
    let start = Instant::now();
    sheet.state.prepare();
    let prepare_ms = ms(start);

    let (mut own_ms, mut one_ms) = (Vec::new(), Vec::new());
    let mut last = None;
    for i in 0..request.steps {
        own_ms.push(sheet.drag(gpu, own, at, i)?.ms);
        let step = one.drag(gpu, handle, at, i)?;
        one_ms.push(step.ms);
        last = Some(step);
    }
    let mut handles = None;
    let mut times: [Vec<f64>; 4] = Default::default();
    let mut first_handle_ms = None;
    if let Some(new) = new {
        for i in 0..request.steps.div_ceil(4) {
            for (k, sheet) in [&mut sheet, &mut *one].into_iter().enumerate() {
                let come = splice(&sheet.state.scene, 0, vec![new]);
                let come = sheet.apply(gpu, &come)?;
                let go = splice(&sheet.state.scene, 1, Vec::new());
                let go = sheet.apply(gpu, &go)?;
                let (Some(come), Some(go)) = (come, go) else {
                    return Err(Failure::machine("a handle was not followed in place"));
                };
                if k == 0 && i == 0 {
                    first_handle_ms = Some(come.ms);
                } else {
                    times[2 * k].push(come.ms);
                    times[2 * k + 1].push(go.ms);
                }
                if k == 0 {
                    handles = Some(come);
                }
            }
        }
    }
    let host_bytes = sheet.state.bytes();
    let gone = Splice { at: own as usize, removed: 1, added: Vec::new() };
    let gone = sheet.apply(gpu, &Delta { geometry: gone, ..Delta::of(Vec::new()) })?;
    let removal_ms = gone.ok_or_else(|| Failure::machine("a removal was not followed in place"))?.ms;
    let mut rebuild = Vec::new();
    for _ in 0..(2000 / n).clamp(3, 25).min(request.steps) {
        let start = Instant::now();
        let refined = refine(&sheet.state.scene, &sheet.state.mesh, Options::default()).map_err(Failure::input)?;
        let table = build(&refined, Irregular::Gregory);
        gpu.update(&mut sheet.table, &table)?;
        rebuild.push(ms(start));
    }
    let [drag_ms, one_copy_ms, rebuild_ms] = [&mut own_ms, &mut one_ms, &mut rebuild].map(|t| median(t));
    let patches = sheet.state.table.faces.len();
    let last = last.ok_or_else(|| Failure::input("--frames: a drag has one step at least"))?;
    let [redo_ms, undo_ms, one_redo, one_undo] = times.map(|mut t| (!t.is_empty()).then(|| median(&mut t)));
    Ok(Row {
        copies: n,
        patches,
        load_ms,
        prepare_ms,
        rebuild_ms,
        drag_ms,
        one_copy_ms,
        over_one_copy: drag_ms / one_copy_ms,
        over_rebuild: drag_ms / rebuild_ms,
        drag_faces: last.touched.faces,
        drag_bytes: last.bytes,
        first_handle_ms,
        redo_ms,
        undo_ms,
        removal_ms,
        one_copy_redo_ms: one_redo,
        one_copy_undo_ms: one_undo,
        handle_came: handles.as_ref().map(|h| h.touched.came),
        handle_patches: handles.as_ref().map(|h| h.touched.patches),
        handle_bytes: handles.as_ref().map(|h| h.bytes),
        host_bytes,
        host_bytes_per_patch: host_bytes as f64 / patches as f64,
        control_bytes: 32 * sheet.state.table.control.len() as u64,
        index_bytes: 4 * sheet.state.table.indices.len() as u64,
    })
}

/// Measures, prints and writes.
pub fn run(mut loaded: Loaded, request: &Request, global: &Global) -> Result<(), Failure> {
    let finest = loaded.scene.geometry.iter().map(|e| e.level).max().unwrap_or(0);
    let gpu = Gpu::new(&global.gpu())?;
    let own = deepest(&loaded).filter(|&i| loaded.scene.geometry[i].level == finest);
    let added = own.is_none();
    let handle = match own {
        Some(i) => i,
        None => {
            // All of that level are on the border, where welds would take them: one more in each copy.
            let mut sheet = load(&gpu, loaded.scene.clone())?;
            let Some(edit) = new_handle(&mut sheet, &gpu, &loaded, finest.max(1))? else {
                return Err(Failure::input(format_args!("{}: no handle inside to drag", loaded.file)));
            };
            loaded.scene.geometry.push(edit);
            loaded.scene.geometry.len() - 1
        }
    };
    let level = loaded.scene.geometry[handle].level;
    let loaded = &loaded;
    std::fs::create_dir_all(request.folder)
        .map_err(|e| Failure::machine(format_args!("{}: {e}", request.folder.display())))?;
    let mut one = load(&gpu, loaded.scene.clone())?;
    let new = new_handle(&mut one, &gpu, loaded, level)?;
    let mut report = Report {
        schema: "gradtess.drag/1",
        scene: loaded.scene.name.clone(),
        device: gpu.device().name.clone(),
        debug_build: cfg!(debug_assertions),
        level,
        added,
        steps: request.steps,
        rows: Vec::new(),
    };
    let mut sizes: Vec<u32> = (0..16).map(|k| 1 << (2 * k)).filter(|&n| n < request.most).collect();
    sizes.push(request.most);
    for n in sizes {
        report.rows.push(row(request, &gpu, loaded, &mut one, [handle as u32, n], new)?);
        // What is done stays, should the rest be interrupted.
        write(request.folder, &report)?;
    }
    silent(&gpu)?;
    if global.json {
        return print_json(&report);
    }
    if !global.quiet {
        print(&text(&report));
    }
    Ok(())
}

fn write(folder: &Path, report: &Report) -> Result<(), Failure> {
    let mut csv = String::new();
    for (i, row) in report.rows.iter().enumerate() {
        // Numbers and nulls by name, in the order of the fields.
        let line = serde_json::to_string(row).map_err(Failure::machine)?;
        let fields = line.trim_matches(['{', '}']).split(',').filter_map(|field| field.split_once(':'));
        let (names, values): (Vec<&str>, Vec<&str>) = fields.map(|(n, v)| (n.trim_matches('"'), v)).unzip();
        if i == 0 {
            let _ = writeln!(csv, "{}", names.join(","));
        }
        let _ = writeln!(csv, "{}", values.join(",").replace("null", "NA"));
    }
    let text = serde_json::to_string_pretty(report).map_err(Failure::machine)?;
    write_atomically(&folder.join("drag.json"), text.as_bytes())?;
    write_atomically(&folder.join("drag.csv"), csv.as_bytes())?;
    Ok(())
}

fn text(report: &Report) -> String {
    let mut out = format!(
        "{}, drag of one handle of level {}, medians of {} steps, ms\n{:>7} {:>9} {:>9} {:>9} {:>9} {:>9} {:>7} {:>8} {:>9} {:>9} {:>8}\n",
        report.scene,
        report.level,
        report.steps,
        "copies",
        "patches",
        "load",
        "prepare",
        "rebuild",
        "drag",
        "of one",
        "of all",
        "handle",
        "undo",
        "B/patch"
    );
    let fixed = |x: Option<f64>, n: usize| x.map_or("NA".to_owned(), |x| format!("{x:.n$}"));
    for r in &report.rows {
        let _ = writeln!(
            out,
            "{:>7} {:>9} {:>9.2} {:>9.2} {:>9.3} {:>9.4} {:>7.2} {:>7.3}% {:>9} {:>9} {:>8}",
            r.copies,
            r.patches,
            r.load_ms,
            r.prepare_ms,
            r.rebuild_ms,
            r.drag_ms,
            r.over_one_copy,
            100.0 * r.over_rebuild,
            fixed(r.redo_ms, 4),
            fixed(r.undo_ms, 4),
            fixed(Some(r.host_bytes_per_patch), 0)
        );
    }
    out
}
