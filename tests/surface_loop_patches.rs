//! Patches of Loop surfaces against the exact limit, and N_B across their edges.

mod models;

use gradtess::mesh;
use gradtess::scene::surface::SurfaceScene;
use gradtess::surface::accuracy::{measure, Accuracy};
use gradtess::surface::adaptive::{Depth, Fate, Part};
use gradtess::surface::level::{Level, Scheme};
use gradtess::surface::patches::{first_level, patches, Patches};
use gradtess::surface::shade::Settings;
use gradtess::surface::triangulate::triangulate;
use gradtess::surface::weight::{Darts, Initial, Rules, Variant};
use std::process::Command;

fn made(text: &str, settings: &Settings, depth: impl Fn(u32) -> Depth) -> (Vec<Part>, Patches) {
    let (scene, _) = triangulate(&SurfaceScene::parse(text.as_bytes(), "test").unwrap());
    let mesh = mesh::build(&scene.polygons()).unwrap();
    let control = Level::new(&scene, &mesh, Scheme::Loop).unwrap();
    patches(&control, &scene.normals, settings, depth(first_level(&control)))
}

/// Patches of one level, `extra` after the first.
fn measured(text: &str, extra: u32) -> Accuracy {
    let (parts, made) = made(text, &Settings::default(), |first| Depth::uniform(first + extra));
    assert_eq!(made.transitions(), 0);
    measure(&parts, &made, 3, 1.0)
}

/// Patches refined locally down to level `last`.
fn adaptive(text: &str, last: u32, settings: &Settings) -> (Vec<Part>, Patches, Accuracy) {
    let (parts, made) = made(text, settings, |first| Depth::adaptive(last.max(first), settings));
    let found = measure(&parts, &made, 2, settings.power);
    (parts, made, found)
}

/// A bumpy torus of 2 m n triangles, all of them regular.
fn torus(m: u32, n: u32, tail: &str) -> String {
    let mut text = String::new();
    for (i, j) in (0..m).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let [a, b] = [(i, m), (j, n)].map(|(k, of)| std::f64::consts::TAU * f64::from(k) / f64::from(of));
        let r = 2.0 + 0.7 * b.cos() + 0.1 * (3.0 * a + b).sin();
        text += &format!("v {} {} {}\n", r * a.cos(), r * a.sin(), 0.7 * b.sin());
    }
    let at = |i: u32, j: u32| 1 + (i % m) * n + j % n;
    for (i, j) in (0..m).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    text + tail
}

/// A bumpy open hexagon of 24 triangles: with sharp corners, its boundary is of vertices of three faces and corners of two.
fn hexagon(tail: &str) -> String {
    let mut text = String::new();
    let mut number = std::collections::HashMap::new();
    let inside = |i: i32, j: i32| i.abs() <= 2 && j.abs() <= 2 && (i + j).abs() <= 2;
    for (j, i) in (-2..=2).flat_map(|j| (-2..=2).map(move |i| (j, i))).filter(|&(j, i)| inside(i, j)) {
        number.insert((i, j), number.len() + 1);
        let (x, y) = (f64::from(i) + 0.5 * f64::from(j), f64::from(j));
        text += &format!("v {x} {y} {}\n", 0.5 * (1.3 * x + y).sin());
    }
    for (j, i) in (-2..2).flat_map(|j| (-2..2).map(move |i| (j, i))) {
        for t in [[(i, j), (i + 1, j), (i, j + 1)], [(i + 1, j), (i + 1, j + 1), (i, j + 1)]] {
            if t.iter().all(|&(i, j)| inside(i, j)) {
                text += &format!("f {} {} {}\n", number[&t[0]], number[&t[1]], number[&t[2]]);
            }
        }
    }
    text + tail
}

/// A big triangle of 16, all regular from level 0 on if its corners are sharp.
fn triangle(tail: &str) -> String {
    let mut text = String::new();
    let at = |i: u32, j: u32| 1 + i + j * 5 - j * (j.max(1) - 1) / 2;
    for (j, i) in (0..=4u32).flat_map(|j| (0..=4 - j).map(move |i| (j, i))) {
        let (x, y) = (f64::from(i) + 0.4 * f64::from(j), f64::from(j));
        text += &format!("v {x} {y} {}\n", 0.6 * (1.1 * x - y).cos());
    }
    for (j, i) in (0..4u32).flat_map(|j| (0..4 - j).map(move |i| (j, i))) {
        text += &format!("f {} {} {}\n", at(i, j), at(i + 1, j), at(i, j + 1));
        if i + j < 3 {
            text += &format!("f {} {} {}\n", at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        }
    }
    text + tail
}

const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.2 0.1 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1.1 0\nv 0 1 0\nv 0 0 1\nv 1 0.2 1\nv 1 1 1.3\nv 0 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
const SHARP: &str = "t interpolateboundary 1/0/0 1\n";

/// Regular faces are the limit; N_B does not jump anywhere; Gregory triangles are within the bounds given.
fn holds(name: &str, found: &Accuracy, counts: [usize; 2], off: f64, angle: f64) {
    assert_eq!(found.patches, counts, "{name}");
    assert!(found.distance[0] < 1e-14 && found.angle[0] < 1e-5, "{name}: {found:?}");
    assert!(found.off[1] <= off && found.angle[1] <= angle, "{name}: {found:?}");
    assert!(found.jump < 1e-4 && found.gap < 1e-14, "{name}: {found:?}");
}

#[test]
fn regular_faces_creases_boundaries_and_corners_are_exact() {
    holds("torus", &measured(&torus(5, 4, ""), 0), [160, 0], 0.0, 0.0);
    // A closed crease: each of its vertices has three faces on either side.
    holds("crease", &measured(&torus(5, 4, "t crease 5/1/0 0 1 2 3 0 10\n"), 0), [160, 0], 0.0, 0.0);
    // Boundaries with corners of one face.
    holds("triangle", &measured(&triangle(SHARP), 0), [64, 0], 0.0, 0.0);
    // Semi-sharp creases are isolated to their level.
    holds("semi-sharp", &measured(&torus(5, 4, "t crease 5/1/0 0 1 2 3 0 1.5\n"), 0), [640, 0], 0.0, 0.0);
    // Not smooth, though: neither are all of these exact by chance.
    let (_, found) = made(&torus(5, 4, "t crease 5/1/0 0 1 2 3 0 1.5\n"), &Settings::default(), Depth::uniform);
    let (_, smooth) = made(&torus(5, 4, ""), &Settings::default(), |_| Depth::uniform(2));
    assert!((0..found.points() as u32).any(|i| found.control(i) != smooth.control(i)));
}

#[test]
fn irregular_faces_are_near_and_smooth() {
    holds("tetrahedron", &measured(TETRAHEDRON, 0), [4, 12], 1e-3, 8.0);
    holds("tetrahedron, isolated", &measured(TETRAHEDRON, 2), [244, 12], 1e-4, 2.5);
    holds("round corners", &measured(&triangle(""), 0), [61, 3], 1e-4, 0.8);
    holds("cube", &measured(CUBE, 0), [12, 36], 2e-3, 3.2);
    let Some(folder) = models::folder("surface", "Loop patches") else { return };
    let read = |name: &str| std::fs::read_to_string(folder.join(format!("{name}.obj"))).unwrap();
    holds("Tetrahedron4", &measured(&read("Tetrahedron4"), 0), [1012, 12], 1e-4, 2.5);
    holds("cross", &measured(&read("3d-cross-triangles4"), 0), [15198, 162], 3e-4, 5.0);
    holds("Spot2", &measured(&read("Spot2"), 0), [5238, 714], 1e-3, 24.0);
}

/// Meshes with everything that asks for refinement, and how far their surfaces may be off at level 10.
fn shapes() -> Vec<String> {
    let tagged = |text: &str, tags: &str| format!("{text}{tags}");
    vec![
        triangle(""),
        hexagon(&format!("{SHARP}t crease 5/1/0 7 8 9 10 11 10\n")),
        tagged(TETRAHEDRON, "t crease 4/1/0 0 1 2 0 10\n"),
        tagged(TETRAHEDRON, "t crease 4/1/0 0 1 2 0 1.5\n"),
        tagged(TETRAHEDRON, "t crease 3/1/0 0 1 2 10\n"),
        tagged(TETRAHEDRON, "t corner 1/1/0 3 2.5\n"),
        tagged(CUBE, ""),
        tagged(CUBE, "t crease 5/1/0 0 1 5 4 0 10\nt crease 2/1/0 2 6 1.5\n"),
        tagged(CUBE, "t crease 3/1/0 0 1 2 3.25\nt crease 3/1/0 2 6 7 99\n"),
        tagged(CUBE, "fs 4 4 0 0\nas 3 4 0 0 3\n"),
    ]
}

#[test]
fn refined_locally_it_is_the_limit_without_gaps_or_jumps() {
    for text in shapes() {
        for variant in [Variant::A, Variant::B] {
            let settings = Settings { rules: Rules { variant, ..Rules::default() }, ..Settings::default() };
            let (parts, made, found) = adaptive(&text, 6, &settings);
            assert!(made.transitions() > 0, "{text}");
            assert!(found.distance[0] < 1e-14 && found.angle[0] < 1e-5, "{text}: {found:?}");
            assert!(found.distance[1] < 5e-4 && found.off[1] < 2e-5 && found.gap < 1e-14, "{text}: {found:?}");
            assert!(found.jump < 1e-3, "{text} {variant:?}: {found:?}");
            // Two levels meet, and irregular faces are on the last one.
            assert!(made.quartic_gregory.iter().all(|(_, place)| place.level == 6));
            let faces: usize = parts.iter().map(|p| p.fate.iter().filter(|&&f| f == Fate::Drawn).count()).sum();
            assert_eq!(faces, made.len());
        }
    }
}

#[test]
fn level_10_is_the_limit_to_a_hundred_thousandth() {
    for text in shapes() {
        let (_, made, found) = adaptive(&text, 10, &Settings::default());
        // At the same parameters, wide fans take longer; the surface itself is nearer by far.
        assert!(found.off[1] < 2e-7 && found.distance[1] < 4e-5, "{text}: {found:?}");
        assert!(found.jump < 1e-4 && made.len() < 3000, "{text}: {} {found:?}", made.len());
    }
}

#[test]
fn n_b_is_continuous_under_all_settings() {
    for text in [shapes()[1].clone(), shapes()[4].clone(), shapes()[7].clone(), hexagon("t crease 3/1/0 7 8 9 3\n")] {
        for (initial, darts, normals_from, weights_from) in [
            (Initial::Ring, Darts::Sharp, 1, 3),
            (Initial::Inverse, Darts::Smooth, 3, 0),
            (Initial::Vertex, Darts::Sharp, 2, 2),
            (Initial::Ring, Darts::Smooth, 1, 9),
        ] {
            for variant in [Variant::A, Variant::B] {
                let rules = Rules { initial, variant, darts };
                let settings = Settings { normals_from, weights_from, rules, ..Settings::default() };
                let (_, _, found) = adaptive(&text, 5, &settings);
                assert!(found.jump < 0.1 && found.gap < 1e-14, "{rules:?} {normals_from} {weights_from}: {found:?}");
            }
        }
    }
}

#[test]
fn sharp_vertices_inside_a_surface_are_spikes_and_have_no_cracks() {
    // All around, a Loop corner narrows by 5/8 along its axis and faster across.
    for text in [format!("{TETRAHEDRON}t corner 1/1/0 3 10\n"), hexagon("t corner 1/1/0 9 10\n")] {
        let (_, _, found) = adaptive(&text, 8, &Settings::default());
        assert!(found.off[1] < 2e-6 && found.gap < 1e-14 && found.jump < 0.1, "{found:?}");
    }
}

#[test]
fn commands_draw_count_sample_and_check_triangles() {
    let folder = std::env::temp_dir().join(format!("gradtess-loop-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let scene = folder.join("cube.obj");
    std::fs::write(&scene, format!("{CUBE}t crease 5/1/0 0 1 5 4 0 10\n")).unwrap();
    let picture = folder.join("out.png");
    let run = |command: &str, flags: &str| -> Option<serde_json::Value> {
        let mut args = vec![command, scene.to_str().unwrap(), "--scheme", "loop", "--triangulate", "--json"];
        args.extend(flags.split(' '));
        if command == "render" {
            args.extend(["-o", picture.to_str().unwrap()]);
        }
        let ran = Command::new(env!("CARGO_BIN_EXE_gradtess")).args(args).output().unwrap();
        let text = String::from_utf8_lossy(&ran.stderr);
        if !ran.status.success() && text.contains("no Vulkan device") {
            println!("skipped: {text}");
            return None;
        }
        assert!(ran.status.success(), "{command} {flags}: {text}");
        Some(serde_json::from_slice(&ran.stdout).unwrap())
    };
    let sampled = run("sample", "--level 3 --n 5").unwrap();
    let exact = run("sample", "--level 3 --n 5 --exact").unwrap();
    let rows = |v: &serde_json::Value| v["samples"].as_array().unwrap().clone();
    let (sampled, exact) = (rows(&sampled), rows(&exact));
    // 15 samples of a triangle; faces are those of the file.
    assert!(sampled.len() == exact.len() && sampled.len() % 15 == 0);
    let mut kinds = std::collections::BTreeSet::new();
    let mut faces = std::collections::BTreeSet::new();
    for (a, b) in sampled.iter().zip(&exact) {
        let kind = a["kind"].as_str().unwrap();
        kinds.insert(kind.to_owned());
        faces.insert(a["face"].as_u64().unwrap());
        let place = |v: &serde_json::Value| [0, 1, 2].map(|k| v["position"][k].as_f64().unwrap());
        let apart = place(a).iter().zip(place(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < if kind == "quartic" { 1e-14 } else { 1e-2 }, "{a} {b}");
    }
    assert_eq!(kinds.into_iter().collect::<Vec<_>>(), ["quartic", "quartic-gregory"]);
    assert_eq!(faces.into_iter().collect::<Vec<_>>(), (0..6).collect::<Vec<_>>());
    let Some(drawn) = run("render", "--tess 5 --level 3 --size 96x96 --validate") else { return };
    let count = |key: &str| drawn[key].as_u64().unwrap();
    assert_eq!(count("quartic") + count("quartic_transition") + count("quartic_gregory"), sampled.len() as u64 / 15);
    assert!(count("quartic_transition") > 0 && count("bicubic") == 0 && count("triangles") == 0);
    let checked = run("check", "--tess 5 --level 3 --zooms 4 --size 96x96 --validate").unwrap();
    assert_eq!(checked["crack_pixels"], 0);
    assert_eq!(checked["patches"]["count"][0].as_u64().unwrap(), count("quartic") + count("quartic_transition"));
    let _ = std::fs::remove_dir_all(folder);
}
