//! CPU cost of refinement and patch table: per model and stage, and growth with the size of the mesh.
//!
//! `cargo bench --bench refine` measures; `-- --short` runs each part once or twice, stops at 10,000 faces and only
//! checks that the output makes sense; `-- --drags` is the drag of one handle in sheets of copies of one model,
//! `-- --cores` a full rebuild on one core against all of them, `-- --tables [--theirs FILE]` sets patch tables beside
//! those of OpenSubdiv; `--only NAME` takes the scenes of that name. Times are medians of runs in one process; compare
//! ratios, not milliseconds.

use glam::{DVec2, DVec4};
use gradtess::incremental::{Delta, Outcome, State, ValueEdit};
use gradtess::mesh;
use gradtess::patch::build::{build, rebuild};
use gradtess::patch::pack::{repack, PackedTable};
use gradtess::patch::points::Irregular;
use gradtess::patch::PatchTable;
use gradtess::refine::{refine, Mode, Options, Rules};
use gradtess::scene::copies::copies;
use gradtess::scene::{ColourEdit, Frame, GeometryEdit, InputMesh, Scene};
use gradtess::subdiv::index_map::IndexMap;
use gradtess::threads::{cpu_time, crew, rehearse};
use std::collections::HashMap;
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
            let delta = Delta::of(vec![ValueEdit::Geometry(handle as u32, [a + x, b - x])]);
            let outcome = state.apply(&delta).unwrap();
            times[1].push(start.elapsed().as_secs_f64() * 1e3);
            let Outcome::Local(t) = outcome else { panic!("a drag keeps the plan") };
            assert!(!t.changed.control.is_empty());
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

/// A full rebuild (refinement, patches, their cast to single precision) on one core and on all, in turns.
fn cores(scene: &Scene, runs: usize, all: usize) {
    let mesh = mesh::build(&scene.mesh).expect("a manifold");
    let mut patches = 0;
    let mut memory = [(); 3].map(|()| Some((PatchTable::default(), PackedTable::default())));
    let rebuild_all = |memory: &mut Option<(PatchTable, PackedTable)>| {
        let (table, mut packed) = memory.take().expect("put back after each run");
        let (start, cpu) = (Instant::now(), cpu_time());
        let table = crew(2 * mesh.half_edges() as usize + 16 * scene.geometry.len(), || {
            let refined = refine(scene, &mesh, Options::default()).expect("edits that fit");
            let table = rebuild(&refined, Irregular::Gregory, table);
            repack(&table, &mut packed);
            table
        });
        let ms = [start.elapsed(), cpu_time() - cpu].map(|t| t.as_secs_f64() * 1e3);
        let n = table.faces.len();
        *memory = Some((table, packed));
        (ms, n)
    };
    let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads");
    let pools = [pool(1), pool(all)];
    let (mut times, mut estimates): ([Vec<f64>; 2], [Vec<f64>; 3]) = Default::default();
    // The first run of each fills the memory.
    for i in 0..=runs {
        for (k, pool) in pools.iter().enumerate() {
            let (ms, n) = pool.install(|| rebuild_all(&mut memory[k]));
            patches = n;
            if i > 0 {
                times[k].push(ms[0]);
                if k == 0 {
                    estimates[2].push(ms[1]);
                }
            }
        }
        let estimate = rehearse(all, || {
            rebuild_all(&mut memory[2]);
        });
        if i > 0 {
            estimates[0].push(estimate.serial.as_secs_f64() * 1e3);
            estimates[1].push(estimate.parallel.as_secs_f64() * 1e3);
        }
    }
    let (tables, packed): (Vec<_>, Vec<_>) = memory.into_iter().flatten().unzip();
    for (table, packed_other) in tables.iter().zip(&packed) {
        assert!(table.faces == tables[0].faces && table.ranges == tables[0].ranges && *packed_other == packed[0]);
        assert!(table.control.iter().zip(&tables[0].control).all(|(a, b)| a.map(f64::to_bits) == b.map(f64::to_bits)));
    }
    // Others use the machine too: of the pairs, the half in which both cores together took least.
    let mut pairs: Vec<(f64, f64)> = times[0].iter().copied().zip(times[1].iter().copied()).collect();
    pairs.sort_by(|a, b| a.1.total_cmp(&b.1));
    pairs.truncate(pairs.len().div_ceil(2));
    let mut best: Vec<f64> = pairs.iter().map(|p| p.0 / p.1).collect();
    let mut ratios: Vec<f64> = times[0].iter().zip(&times[1]).map(|(a, b)| a / b).collect();
    let [one, several] = times.map(|mut t| median(&mut t));
    let [serial, parallel, cpu] = estimates.map(|mut t| median(&mut t));
    println!(
        "{:<28} {patches:>9} {one:>9.3} {several:>9.3} {:>7.2} {:>7.2} {cpu:>9.3} {serial:>9.3} {parallel:>9.3} {:>8.2}",
        scene.name,
        median(&mut ratios),
        median(&mut best),
        cpu / (serial + parallel)
    );
}

/// Scenes of 10,000 patches and more.
fn all_cores(short: bool) {
    let all = std::thread::available_parallelism().map_or(1, |n| n.get());
    println!("full rebuild on 1 core and on {all}; tables compared bit for bit");
    println!("CPU time: on 1 core; of the pieces for {all} the serial part and the longest of each set; what free cores make of it");
    let head = |c: [&str; 10]| {
        let [a, b, c, d, e, f, g, h, i, j] = c;
        println!("{a:<28} {b:>9} {c:>9} {d:>9} {e:>7} {f:>7} {g:>9} {h:>9} {i:>9} {j:>8}");
    };
    head(["", "", "1 core", "all", "", "better", "CPU", "serial", "pieces", "if free"]);
    head(["scene", "patches", "ms", "ms", "times", "half", "ms", "ms", "ms", "times"]);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let cherry = file(&root.join("../shared/models/paper/cherry/cherry_editAtSubd5.obj"));
    let cherry = cherry.or_else(|| file(&root.join("scenes/cherry.json"))).expect("a cherry");
    let sheet = |n: u32| {
        let mut sheet = copies(&cherry, n).expect("a manifold");
        sheet.name = format!("{n} x {}", cherry.name);
        sheet
    };
    let scenes: Vec<Scene> = match short {
        true => vec![grid(34), sheet(2)],
        false => vec![grid(34), grid(100), grid(316), sheet(8), sheet(64), sheet(256)],
    };
    let only = std::env::args().skip_while(|a| a != "--only").nth(1).unwrap_or_default();
    for scene in scenes.into_iter().filter(|s| s.name.contains(&only)) {
        let faces = scene.mesh.corners.len() + scene.geometry.len();
        cores(&scene, if short { 1 } else { (2_000_000 / faces).clamp(7, 61) }, all);
    }
}

/// What `tests/bench/opensubdiv.cpp` printed on this machine, any number of times: for each mesh's faces and each level the
/// least CPU ms of topology, adaptive refinement and patch table, the least with all control points, and the patches.
fn opensubdiv(file: &str) -> HashMap<(usize, usize), (f64, f64, usize)> {
    let text = std::fs::read_to_string(file).expect("what OpenSubdiv takes here");
    let mut least: HashMap<(usize, usize), (f64, f64, usize)> = HashMap::new();
    for line in text.lines() {
        let is_number = |c: char| c.is_ascii_digit() || c == '.';
        let numbers: Vec<f64> = line.split(|c| !is_number(c)).filter_map(|word| word.parse().ok()).collect();
        let [faces, level, patches, _, _, ms, _, whole, ..] = numbers[..] else { continue };
        let best = least.entry((faces as usize, level as usize)).or_insert((ms, whole, patches as usize));
        *best = (best.0.min(ms), best.1.min(whole), best.2);
    }
    least
}

/// As the shapes that OpenSubdiv is tested with: a sheet of quads, every `step`-th of them cut into two triangles, so that there are faces
/// other than quads and vertices of valence 5 and 6 all over.
fn mixed(n: u32, step: u32) -> Scene {
    let quads = grid(n).mesh;
    let mut mesh = InputMesh { face_start: vec![0], positions: quads.positions, ..InputMesh::default() };
    for (f, q) in quads.corners.chunks_exact(4).enumerate() {
        let faces = match f as u32 % step {
            0 => vec![vec![q[0], q[1], q[2]], vec![q[0], q[2], q[3]]],
            _ => vec![q.to_vec()],
        };
        for face in faces {
            mesh.corners.extend(face);
            mesh.face_start.push(mesh.corners.len() as u32);
        }
    }
    Scene { name: format!("mixed sheet ({})", mesh.face_start.len() - 1), mesh, ..Scene::default() }
}

/// Patches a second of refinement and patch table on one core, beside OpenSubdiv's where its times are given.
fn tables(short: bool) {
    println!(
        "patch tables on one core: half-edges, refinement and patch table, least CPU time; the same meshes, as many levels."
    );
    println!(
        "OpenSubdiv's (`--theirs FILE`, the output of tests/bench/opensubdiv.cpp on the same machine) are topology and"
    );
    println!("indices alone; ours have all control points, positions and colours. The ternary step makes nine faces of a quad:");
    println!("`rate` is the ratio of patches a second, `points` the same when theirs compute their control points, too, `mesh`");
    println!("the ratio of times for the mesh.");
    let theirs = std::env::args().skip_while(|a| a != "--theirs").nth(1);
    let theirs = theirs.map(|file| opensubdiv(&file)).unwrap_or_default();
    println!(
        "{:<28} {:>6} {:>9} {:>9} {:>12} {:>9} {:>9} {:>12} {:>6} {:>6} {:>6}",
        "mesh (faces)", "level", "patches", "ms", "patches/s", "theirs", "ms", "patches/s", "rate", "points", "mesh"
    );
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let isolations: &[u32] = if short { &[1] } else { &[0, 1, 2, 3, 4] };
    let only = std::env::args().skip_while(|a| a != "--only").nth(1).unwrap_or_default();
    let mut meshes = vec![mixed(24, 7), mixed(38, 11), mixed(100, u32::MAX)];
    meshes.retain(|s| s.name.contains(&only));
    for (scene, isolate) in meshes.iter().flat_map(|s| isolations.iter().map(move |&i| (s, i))) {
        let options = Options { mode: Mode::Adaptive { isolate }, ..Options::default() };
        let mut table = PatchTable::default();
        let mut levels = 0;
        let mut ms = f64::INFINITY;
        for _ in 0..if short { 1 } else { 41 } {
            ms = pool.install(|| {
                let start = cpu_time();
                let mesh = mesh::build(&scene.mesh).expect("a manifold");
                let refined = refine(scene, &mesh, options).expect("no edits");
                table = rebuild(&refined, Irregular::Gregory, std::mem::take(&mut table));
                levels = refined.levels.len() - 1;
                ms.min((cpu_time() - start).as_secs_f64() * 1e3)
            });
        }
        let faces = scene.mesh.face_start.len() - 1;
        let (patches, ours) = (table.faces.len(), table.faces.len() as f64 / ms * 1e3);
        let rate = |ms: f64, n: usize| n as f64 / ms * 1e3;
        print!("{:<28} {levels:>6} {patches:>9} {ms:>9.3} {ours:>12.0}", scene.name);
        match theirs.get(&(faces, levels)) {
            Some(&(theirs, whole, n)) => println!(
                " {n:>9} {theirs:>9.3} {:>12.0} {:>6.2} {:>6.2} {:>6.2}",
                rate(theirs, n),
                ours / rate(theirs, n),
                ours / rate(whole, n),
                theirs / ms
            ),
            None => println!(),
        }
        assert!(patches >= faces);
    }
}

fn main() {
    if std::env::args().any(|a| a == "--tables") {
        drop(std::hint::black_box(Vec::<u8>::with_capacity(31 << 20)));
        return tables(std::env::args().any(|a| a == "--short"));
    }
    if std::env::args().any(|a| a == "--cores") {
        drop(std::hint::black_box(Vec::<u8>::with_capacity(31 << 20)));
        return all_cores(std::env::args().any(|a| a == "--short"));
    }
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
