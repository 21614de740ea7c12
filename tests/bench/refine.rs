//! CPU cost of refinement and patch table: per model and stage, and growth with the size of the mesh.
//!
//! `cargo bench --bench refine` measures; `-- --short` runs each part once or twice, stops at 10,000 faces and only
//! checks that the output makes sense; `-- --drags` is the drag of one handle in sheets of copies of one model. Times are medians of runs in one process; compare ratios, not milliseconds.

use glam::{DVec2, DVec4};
use gradtess::incremental::{Outcome, State, ValueEdit};
use gradtess::mesh;
use gradtess::patch::build::{build, rebuild};
use gradtess::patch::pack::{repack, PackedTable};
use gradtess::patch::points::Irregular;
use gradtess::patch::PatchTable;
use gradtess::refine::{refine, Mode, Options, Rules};
use gradtess::scene::copies::copies;
use gradtess::scene::{ColourEdit, Frame, GeometryEdit, InputMesh, Scene};
use gradtess::subdiv::index_map::IndexMap;
use std::path::Path;
use std::time::Instant;

/// Medians in ms: mesh, refine, patch, pack; and patches drawn.
fn measure(scene: &Scene, rules: Rules, runs: usize) -> ([f64; 4], usize) {
    let options = Options { rules, mode: Mode::Adaptive { isolate: 0 } };
    let mut times: [Vec<f64>; 4] = Default::default();
    let mut patches = 0;
    // As after each edit in an editor: the tables of the run before are memory for the next.
    let (mut table, mut packed) = (PatchTable::default(), PackedTable::default());
    for _ in 0..runs {
        let start = Instant::now();
        let mesh = mesh::build(&scene.mesh).expect("a manifold");
        let t1 = Instant::now();
        let refined = refine(scene, &mesh, options).expect("edits that fit");
        let t2 = Instant::now();
        table = rebuild(&refined, Irregular::Gregory, table);
        let t3 = Instant::now();
        repack(&table, &mut packed);
        let t4 = Instant::now();
        patches = table.faces.len();
        assert!(packed.control.len() >= patches && packed.indices.len() >= 16 * patches);
        for (list, d) in times.iter_mut().zip([t1 - start, t2 - t1, t3 - t2, t4 - t3]) {
            list.push(d.as_secs_f64() * 1e3);
        }
    }
    (times.map(|mut t| median(&mut t)), patches)
}

fn median(t: &mut [f64]) -> f64 {
    t.sort_by(f64::total_cmp);
    t[t.len() / 2]
}

/// A grid of `n` by `n` quads with one painted vertex in its middle and gentle waves.
fn grid(n: u32) -> Scene {
    let mut mesh = InputMesh { face_start: vec![0], ..InputMesh::default() };
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (f64::from(i), f64::from(j));
            mesh.positions.push(DVec2::new(x + 0.2 * (0.7 * y).sin(), y + 0.2 * (0.5 * x).sin()));
        }
    }
    for j in 0..n {
        for i in 0..n {
            let v = j * (n + 1) + i;
            mesh.corners.extend([v, v + 1, v + n + 2, v + n + 1]);
            mesh.face_start.push(mesh.corners.len() as u32);
        }
    }
    let half_edge = u64::from(4 * (n * n / 2) + 1) * 9;
    let colours = vec![ColourEdit { level: 2, half_edge: half_edge * 16, colour: DVec4::new(1.0, 0.3, 0.1, 1.0) }];
    Scene { name: format!("grid {n} x {n}"), mesh, colours, ..Scene::default() }
}

fn file(path: &Path) -> Option<Scene> {
    Scene::load(path).ok()
}

fn row(scene: &Scene, rules: Rules, runs: usize) -> f64 {
    let (t, patches) = measure(scene, rules, runs);
    let total: f64 = t.iter().sum();
    println!(
        "{:<28} {:<9} {patches:>7} {:>9.3} {:>9.3} {:>9.3} {:>9.3} {:>9.3} {:>12.0}",
        scene.name,
        format!("{rules:?}").to_lowercase(),
        t[0],
        t[1],
        t[2],
        t[3],
        total,
        patches as f64 / total * 1e3
    );
    total
}

/// A step of the drag of one handle of the deepest level: medians in ms of a rebuild and of following it in place, each
/// with its patches; drawn faces, all and touched; and the program's memory, bytes.
fn drag(one: &Scene, n: u32, runs: usize) -> ([f64; 2], [usize; 2], f64) {
    let scene = copies(one, n).expect("a manifold");
    let mesh = mesh::build(&one.mesh).expect("a manifold");
    let map = IndexMap::new(&mesh);
    // The first copy's half-edges have the numbers of the model.
    let inner = |e: &&GeometryEdit| {
        // Welds change the boundary.
        let slot = map.from_app_a(e.level, e.half_edge);
        let closed = |first| {
            let mut spoke = map.spoke_after(e.level, first);
            while let Some(s) = spoke.filter(|&s| s != first) {
                spoke = map.spoke_after(e.level, s);
            }
            spoke == Some(first)
        };
        e.frame == Frame::Sector && slot.is_some_and(closed)
    };
    let deepest = one.geometry.iter().filter(inner).max_by_key(|e| e.level).expect("an edit inside");
    let same = |e: &GeometryEdit| (e.level, e.half_edge) == (deepest.level, deepest.half_edge);
    let handle = scene.geometry.iter().position(same).expect("the edit of the first copy");
    let mut state = State::new(scene, Options::default(), Irregular::Gregory).expect("edits that fit");
    state.prepare();
    let memory = resident();
    let [a, b] = [state.scene.geometry[handle].a, state.scene.geometry[handle].b];
    let mut times: [Vec<f64>; 2] = Default::default();
    let mut touched = 0;
    for i in 0..runs {
        let start = Instant::now();
        let refined = refine(&state.scene, &state.mesh, Options::default()).expect("edits that fit");
        let table = build(&refined, Irregular::Gregory);
        times[0].push(start.elapsed().as_secs_f64() * 1e3);
        drop((refined, table));
        // The same number of times, and short ones oftener.
        for k in 0..8 {
            let x = 0.01 * (1 + k + 8 * (i % 4)) as f64;
            let start = Instant::now();
            let outcome = state.apply(&[ValueEdit::Geometry(handle as u32, [a + x, b - x])]);
            times[1].push(start.elapsed().as_secs_f64() * 1e3);
            let Outcome::Local(t) = outcome else { panic!("a drag keeps the plan") };
            assert!(!t.control.is_empty());
            touched = t.faces;
        }
    }
    (times.map(|mut t| median(&mut t)), [state.table.faces.len(), touched], memory)
}

/// Bytes of memory that the program holds, as far as Linux says it.
fn resident() -> f64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages: f64 = text.split(' ').nth(1).and_then(|n| n.parse().ok()).unwrap_or(f64::NAN);
    4096.0 * pages
}

/// Drag of one handle against the size of the sheet.
fn drags(scene: &Scene, short: bool) {
    println!(
        "{:<28} {:>7} {:>9} {:>9} {:>9} {:>9} {:>10} {:>9} {:>8}",
        "drag of one handle",
        "copies",
        "patches",
        "touched",
        "full ms",
        "local ms",
        "local/full",
        "of 1 copy",
        "B/patch"
    );
    let sizes: &[u32] = if short { &[1, 4] } else { &[1, 4, 16, 64, 256, 1024] };
    let mut first = 0.0;
    for &n in sizes {
        let runs = if short { 1 } else { (2000 / n as usize).clamp(5, 101) };
        let ([full, local], [patches, touched], memory) = drag(scene, n, runs);
        if n == 1 {
            first = local;
        }
        println!(
            "{:<28} {n:>7} {patches:>9} {touched:>9} {full:>9.3} {local:>9.4} {:>9.2}% {:>9.2} {:>8.0}",
            scene.name,
            local / full * 100.0,
            local / first,
            memory / patches as f64
        );
    }
}

fn main() {
    if std::env::args().any(|a| a == "--drags") {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let cherry = root.join("../shared/models/paper/cherry/cherry_editAtSubd5.obj");
        let scene = file(&cherry).or_else(|| file(&root.join("scenes/cherry.json"))).expect("a cherry");
        return drags(&scene, std::env::args().any(|a| a == "--short"));
    }
    // As `src/main.rs` does, for the same reason: page faults would be half of what is measured.
    drop(std::hint::black_box(Vec::<u8>::with_capacity(31 << 20)));
    let short = std::env::args().any(|a| a == "--short");
    let runs = if short { 2 } else { 101 };
    println!(
        "{:<28} {:<9} {:>7} {:>9} {:>9} {:>9} {:>9} {:>9} {:>12}",
        "scene", "rules", "patches", "mesh ms", "refine ms", "patch ms", "pack ms", "total ms", "patches/s"
    );
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let models = root.join("../shared/models/paper");
    // Median CPU time of the authors' tool for the same job on a 2-core machine (its own timing table).
    let theirs = [
        ("cherry/cherry_editAtSubd5.obj", 13.415),
        ("bolling/bolling_Subd3.obj", 11.904),
        ("butterfly/butterfly_Subdi4.obj", 18.037),
    ];
    for (name, ms) in theirs {
        match file(&models.join(name)) {
            Some(scene) => {
                let ours = row(&scene, Rules::Authors, runs);
                row(&scene, Rules::Gradtess, runs);
                println!("    authors' tool {ms} ms: {:.0} times as long", ms / ours);
            }
            None => println!("{name}: not here, skipped"),
        }
    }
    if let Some(scene) = file(&root.join("scenes/cherry.json")) {
        row(&scene, Rules::Gradtess, runs);
    }
    let mut points = Vec::new();
    let sides: &[u32] = if short { &[3, 10, 32, 100] } else { &[3, 10, 32, 100, 316] };
    for &n in sides {
        let scene = grid(n);
        let runs = if short { 1 } else { (20_000 / (n * n)).clamp(3, 101) as usize };
        let ms = row(&scene, Rules::Gradtess, runs);
        points.push((f64::from(n * n).ln(), ms.ln()));
    }
    // Exponent of the growth: slope of the fit through log time over log faces.
    let growth = slope(&points[1..]);
    let faces = sides[sides.len() - 1].pow(2);
    println!("growth: time ~ faces^{growth:.2} from 100 to {faces} input faces");
    assert!(growth.is_finite());
}

fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>() / points.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>()
}
