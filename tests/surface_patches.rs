//! Patches of surfaces in space against the exact limit, and N_B across their edges.

mod models;

use gradtess::mesh;
use gradtess::scene::surface::SurfaceScene;
use gradtess::surface::accuracy::{measure, Accuracy};
use gradtess::surface::level::{Level, Scheme};
use gradtess::surface::patches::{first_level, patches};
use gradtess::surface::refine::levels;
use gradtess::surface::shade::Settings;

fn measured(text: &str, extra: u32) -> Accuracy {
    let scene = SurfaceScene::parse(text.as_bytes(), "test").unwrap();
    let mesh = mesh::build(&scene.polygons()).unwrap();
    let control = Level::new(&scene, &mesh, Scheme::CatmullClark).unwrap();
    let levels = levels(&scene, &mesh, Scheme::CatmullClark, first_level(&control) + extra).unwrap();
    measure(levels.last().unwrap(), &patches(&levels, &scene.normals, &Settings::default()), 3, 1.0)
}

/// Regular faces are the limit; N_B does not jump anywhere; Gregory patches are within the bounds given.
fn holds(name: &str, found: &Accuracy, counts: [usize; 2], distance: f64, angle: f64) {
    assert_eq!(found.patches, counts, "{name}");
    assert!(found.distance[0] < 1e-14 && found.angle[0] < 1e-5, "{name}: {:?} {:?}", found.distance, found.angle);
    assert!(found.distance[1] < distance && found.angle[1] < angle, "{name}: {:?} {:?}", found.distance, found.angle);
    assert!(found.jump < 1e-4, "{name}: {} degrees", found.jump);
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
