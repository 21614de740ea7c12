//! The scenes of technique `ferguson`: the schema knows them and what the program writes, they are sound, unfolded, survive
//! being written, have no cracks, and show what they are there for.

use ferguson_meshes::{change, random_split, Random};
use gpu_support::with_gpu;
use gradtess::check::sections;
use gradtess::ferguson::fit::Target;
use gradtess::ferguson::table::table;
use gradtess::ferguson::traditional::traditional;
use gradtess::ferguson::Mesh;
use gradtess::gpu::{Format, Frame, Pixels, Show};
use gradtess::patch::space::linear_of;
use gradtess::patch::tess::TessRule;
use gradtess::scene::ferguson::{parse, write};
use json_schema::validate;
use serde_json::{json, Value};
use std::path::{Path, PathBuf};

mod ferguson_meshes;
mod gpu_support;
mod json_schema;
mod models;

fn files() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/ferguson");
    let mut all: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    all.sort();
    assert!(all.len() >= 6, "only {} scenes", all.len());
    all
}

/// The scenes, and the drawings made by others where they are there.
fn files_and_drawings(test: &str) -> Vec<PathBuf> {
    let mut all = files();
    if let Some(folder) = models::folder("svg", test) {
        let drawings = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
        all.extend(drawings.filter(|p| p.extension().is_some_and(|e| e == "svg")));
    }
    all
}

fn load(path: &Path) -> Mesh {
    parse(&std::fs::read(path).unwrap(), &path.display().to_string()).unwrap_or_else(|e| panic!("{e}")).0
}

fn scene(name: &str) -> Mesh {
    load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/ferguson").join(name).with_extension("json"))
}

fn schema() -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/schema.json");
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

fn faults(document: &[u8], schema: &Value) -> Vec<String> {
    validate(&serde_json::from_slice(document).unwrap(), schema, schema, "")
}

#[test]
fn the_schema_knows_the_scenes_and_what_is_written() {
    let schema = schema();
    for path in files() {
        assert_eq!(faults(&std::fs::read(&path).unwrap(), &schema), [""; 0], "{}", path.display());
        let mesh = load(&path);
        assert_eq!(mesh.fault(), None, "{}", path.display());
        let written = write(&mesh);
        assert_eq!(faults(written.as_bytes(), &schema), [""; 0], "{}", path.display());
        assert_eq!(write(&parse(written.as_bytes(), "again").unwrap().0), written, "{}", path.display());
    }
    let unit = std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/unit")).unwrap();
    for path in unit.map(|e| e.unwrap().path()) {
        assert_eq!(faults(&std::fs::read(&path).unwrap(), &schema), [""; 0], "{}", path.display());
    }
}

#[test]
fn the_schema_refuses_what_the_reader_refuses() {
    let schema = schema();
    let sound = json!({
        "gradtess": 1, "technique": "ferguson", "points": [[0, 0], [1, 0], [1, 1], [0, 1]], "patches": [{ "points": [0, 1, 2, 3] }],
        "operations": [{ "split": 0, "u": 0.5 }, { "colour": [0, 0], "to": [1, 0, 0] }, { "handle": [0, 3, 1], "to": [0.1, 0.3] }]
    });
    let both = |document: &Value| {
        let bytes = document.to_string().into_bytes();
        [faults(&bytes, &schema).is_empty(), parse(&bytes, "x").is_ok()]
    };
    assert_eq!(both(&sound), [true; 2]);
    for (pointer, value) in [
        ("/gradtess", json!(2)),
        ("/patches", json!([])),
        ("/patches/0/points", json!([0, 1, 2])),
        ("/points/0", json!([0])),
        ("/operations/0", json!({ "split": 0, "colour": 1, "to": [1, 0, 0] })),
        ("/operations/0", json!({ "u": 0.5 })),
        ("/operations/1/colour", json!([0, 4])),
        ("/operations/1", json!({ "colour": 0 })),
        ("/operations/1/to", json!([1, 0, 0, 0, 0])),
        ("/operations/2/handle", json!([0])),
    ] {
        let mut document = sound.clone();
        *document.pointer_mut(pointer).unwrap() = value;
        assert_eq!(both(&document), [false; 2], "{document}");
    }
    for (key, value) in [("space", "cmyk"), ("blend", "swirl"), ("alpha", "none"), ("what", "?")] {
        let mut document = sound.clone();
        document[key] = value.into();
        assert_eq!(both(&document), [false; 2], "{document}");
    }
}

/// A handle named by a side is that of its curve; where the side ends in a T-section it has none.
#[test]
fn handles_are_named_by_sides_and_points_by_corners() {
    let document = |operations: Value| {
        let text = json!({
            "gradtess": 1, "technique": "ferguson",
            "points": [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]],
            "patches": [{ "points": [0, 1, 4, 3] }, { "points": [1, 2, 5, 4] }],
            "operations": operations
        });
        parse(text.to_string().as_bytes(), "x")
    };
    let split = json!({ "split": 1, "v": 0.5 });
    let (mesh, _) =
        document(json!([split, { "handle": [0, 1, 1], "to": [1.2, 0.7] }, { "move": [2, 2], "to": [2.5, 1.5] },
        { "colour": [0, 0], "to": [0, 0.5, 1] }]))
        .unwrap();
    let bar = mesh.bezier(mesh.patch(0).sides[1].curve);
    assert!(bar.iter().any(|p| p.to_array() == [1.2, 0.7]));
    assert_eq!(mesh.at(5).to_array(), [2.5, 1.5]);
    assert_eq!(mesh.patch(0).corners[0].colour.value.to_array(), [0.0, 0.5, 1.0, 1.0]);
    // Side 3 of patch 1 runs from D, now a T-section on the bar, to A.
    let error = document(json!([split, { "handle": [1, 3, 0], "to": [1, 1] }])).unwrap_err().to_string();
    assert!(error.contains("T-section"), "{error}");
    assert!(document(json!([split, { "handle": [1, 3, 1], "to": [1, 0.2] }])).is_ok());
    assert!(document(json!([{ "handle": [0, 1, 2], "to": [1, 1] }])).is_err());
    assert!(document(json!([{ "move": [9, 1], "to": [1, 1] }])).is_err());
}

/// Patches, those of the traditional mesh, T-sections, components.
#[test]
fn scenes_have_what_they_show() {
    let counts = |name: &str| {
        let mesh = scene(name);
        let sections = mesh.points.iter().filter(|p| p.on.is_some()).count();
        (mesh.live().count(), traditional(&mesh), sections, mesh.components())
    };
    assert_eq!(counts("local_refinement"), (25, 81, 20, 1));
    assert_eq!(counts("sections"), (12, 30, 11, 1));
    assert_eq!(counts("radial"), (37, 80, 21, 1));
    assert_eq!(counts("branching"), (19, 32, 4, 1));
    assert_eq!(counts("sharp_colours"), (15, 20, 4, 1));
    assert_eq!(counts("still_life"), (86, 208, 34, 3));
    // Euler: a hole for each closed loop.
    let holes = |name: &str| {
        let mesh = scene(name);
        let mut edges = std::collections::HashSet::new();
        let mut corners = std::collections::HashSet::new();
        let roots: std::collections::HashSet<u32> = mesh.live().map(|p| mesh.patch(p).root).collect();
        let flat = parse(
            &{
                let text = std::fs::read(
                    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/ferguson").join(name).with_extension("json"),
                );
                let mut document: Value = serde_json::from_slice(&text.unwrap()).unwrap();
                document["operations"] = json!([]);
                document.to_string().into_bytes()
            },
            "flat",
        );
        let flat = flat.unwrap().0;
        for p in flat.live() {
            edges.extend(flat.patch(p).sides.map(|s| s.curve));
            corners.extend(flat.patch(p).corners.map(|c| c.point));
        }
        mesh.components() as i64 + edges.len() as i64 - corners.len() as i64 - roots.len() as i64
    };
    assert_eq!(["local_refinement", "sections", "sharp_colours"].map(holes), [0; 3]);
    assert_eq!((holes("radial"), holes("branching"), holes("still_life")), (1, 1, 2));
}

/// The chain of Fig. 10: one handle of the bar is moved and every T-section of the chain with it, and nothing else.
#[test]
fn a_chain_of_sections_follows_its_bar() {
    let mut mesh = scene("sections");
    mesh.take_journal();
    let bar = mesh.patch(0).sides[1].curve;
    let before: Vec<_> = mesh.points.iter().map(|p| p.at).collect();
    let handle = mesh.curve(bar).handles[0];
    mesh.move_handle(bar, 0, handle + glam::DVec2::new(2.0, 0.0), gradtess::ferguson::inherit::Continuity::C1).unwrap();
    let moved: Vec<usize> = (0..before.len()).filter(|&i| mesh.points[i].at != before[i]).collect();
    let on_bar = moved.iter().filter(|&&i| mesh.points[i].on.is_some_and(|s| s.curve == bar)).count();
    assert!(on_bar == 2 && moved.len() >= 4, "{moved:?}");
    assert!(moved.iter().all(|&i| mesh.points[i].on.is_some()));
}

/// Fig. 18 and App. A in numbers: what the paper says of the spaces holds of the 2 x 3 mesh.
#[test]
fn colour_spaces_differ_as_the_paper_says() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/ferguson/colour_spaces.json");
    let document: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let in_space = |space: &str| {
        let mut document = document.clone();
        document["space"] = space.into();
        parse(document.to_string().as_bytes(), "x").unwrap().0
    };
    let luminance = |c: glam::DVec4| {
        let [r, g, b] = [c.x, c.y, c.z].map(|x| linear_of(x.clamp(0.0, 1.0)));
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    // Colours at 17 x 17 points of each of the six patches.
    let sampled = |space: &str| -> Vec<glam::DVec4> {
        let mesh = in_space(space);
        let steps = || (0..=16).map(|k| f64::from(k) / 16.0);
        let all = mesh.live().flat_map(|p| steps().flat_map(move |v| steps().map(move |u| (p, u, v))));
        all.map(|(p, u, v)| mesh.colour.decode(mesh.evaluate(p, u, v).1)).collect()
    };
    let mean = |space: &str| {
        let all = sampled(space);
        all.iter().map(|&c| luminance(c)).sum::<f64>() / all.len() as f64
    };
    // "Linear sRGB is a linear transformation of CIEXYZ and therefore produces the same interpolation results."
    let apart = sampled("linear").into_iter().zip(sampled("xyz")).map(|(a, b)| (a - b).abs().max_element());
    assert!(apart.fold(0.0, f64::max) < 1e-9);
    // "CIELUV, CIELAB and sRGB produce slightly darker results than CIEXYZ"; "dark regions can occur" in sRGB.
    let [srgb, xyz, lab, luv, oklab] = ["srgb", "xyz", "lab", "luv", "oklab"].map(mean);
    println!("mean luminance: sRGB {srgb:.4}, XYZ {xyz:.4}, CIELAB {lab:.4}, CIELUV {luv:.4}, Oklab {oklab:.4}");
    assert!(srgb < lab && [lab, luv, oklab].into_iter().all(|y| y < xyz), "{srgb} {xyz} {lab} {luv} {oklab}");
    for (y, expected) in [srgb, xyz, lab, luv, oklab].into_iter().zip([0.33, 0.51, 0.45, 0.45, 0.46]) {
        assert!((y - expected).abs() < 0.01, "{y} {expected}");
    }
    // "CIELAB introduces some undesirable purple when interpolating from blue to yellow": midway along the first side.
    let middle = |space: &str| {
        let mesh = in_space(space);
        mesh.colour.decode(mesh.evaluate(0, 0.5, 0.0).1)
    };
    let (lab, luv) = (middle("lab"), middle("luv"));
    assert!(lab.x - lab.y > 0.2 && lab.z - lab.y > 0.1, "purple: {lab}");
    assert!((luv.x - luv.y).abs() < 0.01 && (luv.z - luv.y).abs() < 0.06, "nearly grey: {luv}");
    let srgb = middle("srgb");
    assert!((srgb.truncate() - 0.5).abs().max_element() < 1e-12, "{srgb}");
}

#[test]
fn no_scene_folds() {
    for path in files() {
        let (nets, _) = gradtess::vector::bicubics(&table(&load(&path), &Target::default()));
        assert_eq!(gradtess::vector::folded(&nets), None, "{}", path.display());
    }
}

#[test]
fn a_thousand_random_splits_of_scenes_and_drawings_change_nothing() {
    for path in files_and_drawings("splits of drawings") {
        for dyadic in [true, false] {
            let mesh = load(&path);
            let mut split = mesh.clone();
            let mut random = Random::new(7);
            for _ in 0..1000 {
                random_split(&mut split, &mut random, dyadic);
            }
            assert_eq!(split.fault(), None, "{}", path.display());
            let worst = change(&mesh, &split, &mut random);
            println!(
                "{}, dyadic {dyadic}: {} patches, position {:.1e} of the canvas, colour {:.1e}",
                path.display(),
                split.live().count(),
                worst[0],
                worst[1]
            );
            assert!(worst.iter().all(|&w| w <= 1e-12), "{} {worst:?}", path.display());
        }
    }
}

/// Components lie over one another in the order of the file, however deep what lies below is split.
#[test]
fn splits_do_not_change_what_lies_on_top() {
    let square = |x: f64| [[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]];
    let points: Vec<[f64; 2]> = [0.0, 0.5].into_iter().flat_map(square).collect();
    let document = json!({
        "gradtess": 1, "technique": "ferguson", "points": points,
        "patches": [{ "points": [0, 1, 2, 3] }, { "points": [4, 5, 6, 7] }],
        "operations": [{ "split": 0, "u": 0.5 }, { "split": 2, "v": 0.5 }]
    });
    let (mesh, _) = parse(document.to_string().as_bytes(), "x").unwrap();
    let names: Vec<u64> = table(&mesh, &Target::default()).faces.iter().map(|f| f.name).collect();
    assert_eq!(names.last(), Some(&1));
    assert_eq!(names.len(), 4);
}

/// Zooms of every scene and drawing; `GRADTESS_CRACK_VIEWS` asks for more than the few that every run has time for.
#[test]
fn random_views_have_no_cracks() {
    let views: u32 = std::env::var("GRADTESS_CRACK_VIEWS").ok().and_then(|v| v.parse().ok()).unwrap_or(3);
    let all = files_and_drawings("cracks of drawings");
    with_gpu(|gpu| {
        for path in &all {
            let mesh = load(path);
            let patches: Vec<u32> = mesh.live().collect();
            let mut random = Random::new(4);
            let mut inside = 0;
            for view in 0..views {
                // Around a T-section where there are any, else anywhere in a patch.
                let sections: Vec<_> = mesh.points.iter().filter(|p| p.on.is_some() && !p.corners.is_empty()).collect();
                let middle = match sections.len() {
                    0 => mesh.evaluate(patches[random.below(patches.len())], random.unit(), random.unit()).0,
                    n => sections[random.below(n)].at,
                };
                let nets: Vec<glam::DVec2> = patches.iter().flat_map(|&p| mesh.geometry(p)).collect();
                let low = nets.iter().copied().reduce(glam::DVec2::min).unwrap();
                let high = nets.iter().copied().reduce(glam::DVec2::max).unwrap();
                let zoom = 1000f64.powf(if view == 0 { 1.0 } else { random.unit() });
                let d = 0.5 * (high - low).max_element() / zoom;
                let view = [middle.x - d, middle.y - d, middle.x + d, middle.y + d];
                let size = 160u32;
                let rule = TessRule::Pixels(3.0 + 8.0 * random.unit() as f32);
                let target = Target { rule, scale: [f64::from(size) / (2.0 * d); 2], view: Some(view) };
                let fitted = mesh.fit(&target);
                let device = gpu.upload(&gradtess::patch::cull::within(&table(&fitted, &target), view)).unwrap();
                let frame = Frame {
                    width: size,
                    height: size,
                    view,
                    tess: rule,
                    show: Show::Patches,
                    background: None,
                    samples: 1,
                    format: Format::Rgba32f,
                    statistics: false,
                };
                let Pixels::Rgba32f(pixels) = gpu.render(&device, &frame).unwrap().pixels else { panic!() };
                let covered: Vec<bool> = pixels.chunks_exact(4).map(|p| p[3] > 0.0).collect();
                let outline = sections::outline(&fitted, &target, view, [size, size]);
                let (found, n) = sections::cracks(&outline, &covered, [size, size]);
                assert!(found.is_empty(), "{}: {found:?} in {view:?}", path.display());
                inside += n;
            }
            println!("{}: {inside} pixels inside in {views} views", path.display());
            assert!(inside > 1000, "{}", path.display());
        }
    });
}
