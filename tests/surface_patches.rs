//! Patches of surfaces in space against the exact limit, and N_B across their edges.

mod models;

use gradtess::mesh;
use gradtess::scene::surface::SurfaceScene;
use gradtess::surface::accuracy::{measure, Accuracy};
use gradtess::surface::adaptive::{Depth, Fate, Part};
use gradtess::surface::level::{Level, Scheme};
use gradtess::surface::patches::{first_level, patches, Patches};
use gradtess::surface::refine::levels;
use gradtess::surface::shade::{shade, Settings};
use gradtess::surface::weight::{Darts, Initial, Rules, Variant};

fn control(text: &str) -> (SurfaceScene, Level) {
    let scene = SurfaceScene::parse(text.as_bytes(), "test").unwrap();
    let mesh = mesh::build(&scene.polygons()).unwrap();
    let control = Level::new(&scene, &mesh, Scheme::CatmullClark).unwrap();
    (scene, control)
}

fn made(text: &str, settings: &Settings, depth: impl Fn(u32) -> Depth) -> (Vec<Part>, Patches) {
    let (scene, control) = control(text);
    patches(&control, &scene.normals, settings, depth(first_level(&control)))
}

/// Patches of one level, `extra` after the first.
fn measured(text: &str, extra: u32) -> Accuracy {
    let (parts, made) = made(text, &Settings::default(), |first| Depth::uniform(first + extra));
    assert!(made.transition.is_empty());
    measure(&parts, &made, 3, 1.0)
}

/// Patches refined locally down to level `last`, 4 x 4 samples each.
fn adaptive(text: &str, last: u32, settings: &Settings) -> (Vec<Part>, Patches, Accuracy) {
    let (parts, made) = made(text, settings, |first| Depth::adaptive(last.max(first), settings));
    let found = measure(&parts, &made, 2, settings.power);
    (parts, made, found)
}

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1.1 0\nv 0 1 0\nv 0 0 1\nv 1 0.2 1\nv 1 1 1.3\nv 0 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// Regular faces are the limit; N_B does not jump anywhere; Gregory patches are within the bounds given.
fn holds(name: &str, found: &Accuracy, counts: [usize; 2], distance: f64, angle: f64) {
    assert_eq!(found.patches, counts, "{name}");
    assert!(found.distance[0] < 1e-14 && found.angle[0] < 1e-5, "{name}: {:?} {:?}", found.distance, found.angle);
    assert!(found.distance[1] < distance && found.angle[1] < angle, "{name}: {:?} {:?}", found.distance, found.angle);
    assert!(found.jump < 1e-4 && found.gap < 1e-14, "{name}: {} degrees, {}", found.jump, found.gap);
}

/// A bumpy open sheet of 3 x 3 quads, all regular from level 1 on but the four round corners.
fn sheet(tail: &str) -> String {
    let mut text = String::new();
    for i in 0..16 {
        let (x, y) = (f64::from(i % 4), f64::from(i / 4));
        text += &format!("v {x} {y} {}\n", (1.3 * x + y).sin());
    }
    for i in 0..9 {
        let at = 1 + i % 3 + 4 * (i / 3);
        text += &format!("f {} {} {} {}\n", at, at + 1, at + 5, at + 4);
    }
    text + tail
}

#[test]
fn regular_faces_creases_boundaries_and_corners_are_exact() {
    // Sharp corners: nothing is irregular.
    let corners = "t interpolateboundary 1/0/0 1\n";
    holds("sheet", &measured(&sheet(corners), 0), [36, 0], 1e-14, 1e-5);
    // An endless crease across, too: two of its ends meet the boundary, where they are corners of two faces.
    let crease = format!("{corners}t crease 4/1/0 1 5 9 13 10\n");
    holds("crease", &measured(&sheet(&crease), 0), [36, 0], 1e-14, 1e-5);
    // A semi-sharp one is isolated to level 2.
    let semi = format!("{corners}t crease 4/1/0 1 5 9 13 1.5\n");
    holds("semi-sharp", &measured(&sheet(&semi), 0), [144, 0], 1e-14, 1e-5);
}

#[test]
fn irregular_faces_are_near_and_smooth() {
    let Some(folder) = models::folder("surface", "patches") else { return };
    let read = |name: &str| std::fs::read_to_string(folder.join(format!("{name}.obj"))).unwrap();
    holds("cube", &measured(&read("cube"), 0), [0, 24], 8e-3, 1.3);
    holds("cube, isolated", &measured(&read("cube"), 2), [360, 24], 1.6e-3, 0.3);
    holds("Spot2", &measured(&read("Spot2"), 0), [2536, 392], 2e-3, 10.0);
    holds("ItaPaperGeom", &measured(&read("ItaPaperGeom"), 0), [64, 64], 4e-3, 3.2);
}

/// Cubes with everything that asks for refinement.
const TAGS: [&str; 6] = [
    "",
    "t crease 5/1/0 0 1 5 4 0 10\nt crease 2/1/0 2 6 1.5\n",
    "t crease 2/1/0 2 6 10\nt corner 1/1/0 4 2.5\n",
    "fs 4 4 0 0\nas 3 4 0 0 3\n",
    "t crease 3/1/0 0 1 2 3.25\nt crease 3/1/0 2 6 7 99\n",
    "t crease 2/1/0 0 1 1\nt crease 2/1/0 6 7 2\nt corner 1/1/0 3 3\nt corner 1/1/0 5 1\n",
];

#[test]
fn refined_locally_it_is_the_limit_without_gaps_or_jumps() {
    for tags in TAGS {
        for variant in [Variant::A, Variant::B] {
            let settings = Settings { rules: Rules { variant, ..Rules::default() }, ..Settings::default() };
            let (parts, made, found) = adaptive(&format!("{CUBE}{tags}"), 6, &settings);
            assert!(!made.transition.is_empty(), "{tags}");
            assert!(found.distance[0] < 1e-14 && found.angle[0] < 1e-5, "{tags}: {found:?}");
            assert!(found.distance[1] < 2e-4 && found.off[1] < 2e-5 && found.gap < 1e-14, "{tags}: {found:?}");
            assert!(found.jump < 1e-3, "{tags} {variant:?}: {found:?}");
            // Two levels meet everywhere, and irregular faces are on the last one.
            assert!(made.gregory.iter().all(|(_, place)| place.level == 6));
            let faces: usize = parts.iter().map(|p| p.fate.iter().filter(|&&f| f == Fate::Drawn).count()).sum();
            assert_eq!(faces, made.len());
        }
    }
}

#[test]
fn n_b_is_continuous_under_all_settings_and_on_open_meshes() {
    let open = "v 0 0 0\nv 1 0 1\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 1 2 0\n\
        f 1 2 5 4\nf 2 3 6 5\nf 4 5 7\nf 5 6 7\nt crease 2/1/0 1 4 3\n";
    let corners = format!("{open}t interpolateboundary 1/0/0 1\n");
    for text in [format!("{CUBE}{}", TAGS[1]), format!("{CUBE}{}", TAGS[4]), open.to_string(), corners] {
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
fn channels_are_those_of_uniform_levels() {
    // Where nothing is sharp, b on patches is b of a level's vertices, and N_S turns from it by little: levels normalise.
    let (scene, control) = control(CUBE);
    let settings = Settings::default();
    let (parts, made) = patches(&control, &scene.normals, &settings, Depth::adaptive(4, &settings));
    let levels = levels(&scene, &mesh::build(&scene.polygons()).unwrap(), Scheme::CatmullClark, 4).unwrap();
    let shaded = shade(&levels, &scene.normals, &Settings { everywhere: true, ..settings });
    let mut met = 0;
    for (ids, place) in &made.gregory {
        let name = parts[place.level as usize].name[place.face as usize] as usize;
        let v = levels[4].origin[4 * name] as usize;
        let [_, _, _, b, nx, ny, nz, _] = made.control(ids[0]);
        assert!((b.min(1.0) - shaded.weight[v]).abs() < 1e-12, "{b} {}", shaded.weight[v]);
        let n = glam::DVec3::new(nx, ny, nz);
        assert!(n.angle_between(shaded.subdivided[v]).to_degrees() < 1.0);
        met += 1;
    }
    assert_eq!(met, 24);
}

#[test]
fn level_10_is_the_limit_to_a_hundred_thousandth() {
    for tags in TAGS {
        let (_, made, found) = adaptive(&format!("{CUBE}{tags}"), 10, &Settings::default());
        assert!(found.distance.iter().all(|&d| d < 1e-5), "{tags}: {found:?}");
        assert!(made.len() < 2500, "{tags}: {}", made.len());
    }
    let Some(folder) = models::folder("surface", "ItaPaperGeom") else { return };
    let read = |name: &str| std::fs::read_to_string(folder.join(format!("{name}.obj"))).unwrap();
    let (_, _, found) = adaptive(&read("ItaPaperGeom"), 10, &Settings::default());
    // At the same parameters, valences above 4 take longer; the surface itself is nearer by far.
    assert!(found.off.iter().all(|&d| d < 1e-6) && found.distance[1] < 2e-5, "{found:?}");
    assert!(found.jump < 0.1, "{found:?}");
}
