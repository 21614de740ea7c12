//! Whole models on the GPU: pictures against those that the authors' tool drew, shader runs against the formulas, and
//! evaluated points against the CPU. The authors' models are skipped, in words, where they are absent.

mod gpu_support;
mod models;

use gpu_support::*;
use gradtess::gpu::Frame;
use gradtess::image::Picture;
use gradtess::patch::points::Irregular;
use gradtess::patch::tess::{quad_vertices, triangle_vertices, TessRule};
use gradtess::patch::transition::PARTS;
use gradtess::patch::{build, eval, ControlPoint, Kind, PatchTable};
use gradtess::refine::{refine, Mode, Options, Rules};
use gradtess::scene::Scene;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn table(path: &Path, rules: Rules) -> PatchTable {
    let scene = Scene::load(path).unwrap_or_else(|e| panic!("{e}"));
    let mesh = gradtess::mesh::build(&scene.mesh).unwrap();
    let refinement = refine(&scene, &mesh, Options { rules, mode: Mode::Adaptive { isolate: 0 } }).unwrap();
    build::build(&refinement, Irregular::Gregory)
}

fn with_extension(folder: &Path, extension: &str, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() && !["ferguson", "pattern"].iter().any(|other| path.ends_with(other)) {
            with_extension(&path, extension, found);
        } else if path.extension().is_some_and(|e| e == extension) && !path.ends_with("schema.json") {
            found.push(path);
        }
    }
}

/// Our scenes and the authors' models.
fn all_scenes(test: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    with_extension(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"), "json", &mut found);
    if let Some(folder) = models::folder("paper", test) {
        with_extension(&folder, "obj", &mut found);
    }
    found
}

#[test]
fn pictures_are_the_authors() {
    let Some(folder) = models::folder("paper", "pictures_are_the_authors") else { return };
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(folder.join("view.json")).unwrap()).unwrap();
    with_gpu(|gpu| {
        for (name, facts) in json["models"].as_object().unwrap() {
            let file = folder.join(facts["png"].as_str().unwrap());
            if !file.is_file() {
                println!("{name}: skipped, there is no picture of it");
                continue;
            }
            let theirs = Picture::read_png(&file).unwrap();
            let side = |key: &str| facts["world_rect"][key].as_f64().unwrap();
            let tess = TessRule::Fixed(facts["tess_level"].as_f64().unwrap() as f32);
            let view = [side("x_min"), side("y_min"), side("x_max"), side("y_max")];
            let uploaded = gpu.upload(&table(&folder.join(name), Rules::Authors)).unwrap();
            let frame = Frame { width: theirs.width, height: theirs.height, view, tess, ..frame(1) };
            let ours = gpu.render(&uploaded, &frame).unwrap().pixels.into_picture(theirs.width, theirs.height);

            let (mut covered, mut both, mut met, mut equal, mut differ) = (0u32, 0u32, 0u32, 0u32, 0u32);
            for (a, b) in ours.rgba.chunks_exact(4).zip(theirs.rgba.chunks_exact(4)) {
                // Theirs is where the surface is (alpha 255), ours how opaque it is there: all are opaque.
                covered += u32::from(b[3] > 0);
                differ += u32::from((a[3] > 0) != (b[3] > 0));
                if a[3] > 0 && b[3] > 0 {
                    let error = (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap();
                    both += 1;
                    met += u32::from(error <= 2);
                    equal += u32::from(error == 0);
                }
            }
            let percent = |n: u32, of: u32| 100.0 * f64::from(n) / f64::from(of);
            println!(
                "{name}: within 2/255 at {:.4} % of {covered} covered pixels, the same byte at {:.3} %; coverage differs at {differ} ({:.4} %)",
                percent(met, both),
                percent(equal, both),
                percent(differ, covered)
            );
            assert!(percent(met, both) >= 99.5, "{name}");
            assert!(percent(differ, covered) <= 0.2, "{name}");
        }
    });
}

#[test]
fn models_run_as_many_shaders_as_the_formulas_say() {
    with_gpu(|gpu| {
        for path in all_scenes("models_run_as_many_shaders_as_the_formulas_say") {
            for (rules, tess) in [(Rules::Authors, TessRule::Fixed(5.0)), (Rules::Gradtess, TessRule::Base(16.0))] {
                let table = table(&path, rules);
                let (mut patches, mut exact) = (0, 0u64);
                for range in &table.ranges {
                    let levels = tess.levels(range.level);
                    let vertices = match range.part {
                        None => quad_vertices(levels.full as u64),
                        // With one level on all sides the formulas hold for parts too; `Base` mixes levels there.
                        Some(_) if matches!(tess, TessRule::Base(_)) => 0,
                        Some(part) if PARTS[part as usize].triangle => triangle_vertices(levels.full as u64),
                        Some(_) => quad_vertices(levels.full as u64),
                    };
                    patches += u64::from(range.count);
                    exact += u64::from(range.count) * vertices;
                }
                let bounds = {
                    let x = table.control.iter().map(|c| c[0]);
                    let y = table.control.iter().map(|c| c[1]);
                    let least = |i: &mut dyn Iterator<Item = f64>| i.fold(f64::INFINITY, f64::min);
                    let most = |i: &mut dyn Iterator<Item = f64>| i.fold(f64::NEG_INFINITY, f64::max);
                    [
                        least(&mut x.clone()) - 0.1,
                        least(&mut y.clone()) - 0.1,
                        most(&mut x.clone()) + 0.1,
                        most(&mut y.clone()) + 0.1,
                    ]
                };
                let frame = Frame { view: bounds, tess, statistics: true, ..frame(64) };
                let counted = gpu.render(&gpu.upload(&table).unwrap(), &frame).unwrap().statistics.unwrap();
                let name = path.file_stem().unwrap().to_string_lossy();
                assert_eq!(counted.tcs_patches, patches, "{name}: {rules:?}");
                if matches!(tess, TessRule::Fixed(_)) {
                    println!("{name}: {patches} TCS patches, {exact} TES runs");
                    assert_eq!(counted.tes_invocations, exact, "{name}: {rules:?}");
                } else {
                    assert!(counted.tes_invocations >= exact, "{name}: {rules:?}");
                }
            }
        }
    });
}

#[test]
fn models_on_the_gpu_are_what_the_cpu_says() {
    let mut tables: Vec<(String, PatchTable)> = Vec::new();
    let mut add = |path: PathBuf, rules: Rules| {
        tables.push((path.file_stem().unwrap().to_string_lossy().into_owned(), table(&path, rules)));
    };
    add(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cherry.json"), Rules::Gradtess);
    if let Some(folder) = models::folder("paper", "models_on_the_gpu_are_what_the_cpu_says") {
        for name in
            ["cherry/cherry_editAtSubd5", "bolling/bolling_Subd3", "glass/1/glass3", "cherry/cherry_editAtSubd0"]
        {
            add(folder.join(format!("{name}.obj")), Rules::Gradtess);
            add(folder.join(format!("{name}.obj")), Rules::Authors);
        }
    }
    with_gpu(|gpu| {
        let mut met = BTreeSet::new();
        for (name, table) in &tables {
            let size = table.control.iter().flatten().fold(1.0f64, |most, x| most.max(x.abs()));
            let uploaded = gpu.upload(table).unwrap();
            let points = gpu.evaluate(&uploaded, TessRule::Fixed(4.0), [1.0; 2]).unwrap();
            let mut greatest = 0.0f64;
            for patch in by_patch(&points) {
                let range = &table.ranges[patch[0].range as usize];
                let first = range.first as usize + patch[0].patch as usize * range.stride();
                let indices = &table.indices[first..first + range.stride()];
                let control: Vec<ControlPoint> = indices.iter().map(|&i| table.control[i as usize]).collect();
                met.insert((range.kind, range.part.map_or(0, |p| PARTS[p as usize].constellation)));
                for p in patch {
                    let outer = p.outer.map(f64::from);
                    let expected = eval::vertex(range.kind, p.part, &control, outer, p.coord.map(f64::from));
                    for (got, expected) in p.value.iter().zip(expected) {
                        greatest = greatest.max((f64::from(*got) - expected).abs() / size);
                    }
                }
            }
            println!("{name}: {} points within {greatest:.1e} of the CPU", points.len());
            assert!(greatest < 1e-5, "{name}: {greatest}");
        }
        println!("kinds and constellations met (0: whole): {met:?}");
        assert!(met.contains(&(Kind::Bicubic, 0)) && met.contains(&(Kind::Gregory, 0)));
    });
}
