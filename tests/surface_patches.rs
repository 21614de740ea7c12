//! Patches of surfaces in space against the exact limit, and N_B across their edges.

mod models;

use gradtess::mesh::{self, NONE};
use gradtess::patch::Kind;
use gradtess::scene::surface::SurfaceScene;
use gradtess::surface::exact::Exact;
use gradtess::surface::level::{Level, Scheme};
use gradtess::surface::patch_eval::{point, Point};
use gradtess::surface::patches::{first_level, patches};
use gradtess::surface::refine::levels;
use gradtess::surface::shade::Settings;

struct Found {
    bicubic: usize,
    gregory: usize,
    /// Greatest distance from the limit over the box's diagonal, by kind; greatest angle between normals, degrees.
    distance: [f64; 2],
    angle: [f64; 2],
    /// Greatest angle between N_B on both sides of a smooth edge, degrees.
    jump: f64,
}

fn measure(text: &str, extra: u32) -> Found {
    let scene = SurfaceScene::parse(text.as_bytes(), "test").unwrap();
    let mesh = mesh::build(&scene.polygons()).unwrap();
    let control = Level::new(&scene, &mesh, Scheme::CatmullClark).unwrap();
    let levels = levels(&scene, &mesh, Scheme::CatmullClark, first_level(&control) + extra).unwrap();
    let last = levels.last().unwrap();
    let made = patches(&levels, &scene.normals, &Settings::default());
    let exact = Exact::new(last, 3);
    let [low, high] = gradtess::camera::bounds(last.position.iter().copied()).unwrap();
    let size = (high - low).length();
    let n = exact.segments();
    let mut found = Found {
        bicubic: made.bicubic.len(),
        gregory: made.gregory.len(),
        distance: [0.0; 2],
        angle: [0.0; 2],
        jump: 0.0,
    };
    let mut sides: Vec<Vec<Point>> = vec![Vec::new(); last.half_edges()];
    for (kind, control, f) in made.iter() {
        let k = usize::from(kind == Kind::Gregory);
        let at = |i: u32, j: u32| point(kind, &control, f64::from(i) / f64::from(n), f64::from(j) / f64::from(n), 1.0);
        for j in 0..=n {
            for i in 0..=n {
                let (p, normal) = exact.limit(f, i, j);
                let here = at(i, j);
                found.distance[k] = found.distance[k].max((here.position - p).length() / size);
                let angle = here.geometric.angle_between(normal).to_degrees();
                found.angle[k] = found.angle[k].max(angle);
            }
        }
        for i in 0..=n {
            for (e, p) in [at(i, 0), at(n, i), at(n - i, n), at(0, n - i)].into_iter().enumerate() {
                sides[4 * f as usize + e].push(p);
            }
        }
    }
    for h in 0..last.half_edges() {
        let t = last.twin[h];
        if t != NONE {
            for (a, b) in sides[h].iter().zip(sides[t as usize].iter().rev()) {
                assert!((a.position - b.position).length() < 1e-14 * size);
                if !last.is_sharp(h as u32) {
                    found.jump = found.jump.max(a.blended.angle_between(b.blended).to_degrees());
                }
            }
        }
    }
    found
}

/// Regular faces are the limit; N_B does not jump anywhere; Gregory patches are within the bounds given.
fn holds(name: &str, found: &Found, counts: [usize; 2], distance: f64, angle: f64) {
    assert_eq!([found.bicubic, found.gregory], counts, "{name}");
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
    holds("sheet", &measure(&sheet(corners), 0), [36, 0], 1e-14, 1e-5);
    // An endless crease across, too: two of its ends meet the boundary, where they are corners of two faces.
    let crease = format!("{corners}t crease 4/1/0 1 5 9 13 10\n");
    holds("crease", &measure(&sheet(&crease), 0), [36, 0], 1e-14, 1e-5);
    // A semi-sharp one is isolated to level 2.
    let semi = format!("{corners}t crease 4/1/0 1 5 9 13 1.5\n");
    holds("semi-sharp", &measure(&sheet(&semi), 0), [144, 0], 1e-14, 1e-5);
}

#[test]
fn irregular_faces_are_near_and_smooth() {
    let Some(folder) = models::folder("surface", "patches") else { return };
    let read = |name: &str| std::fs::read_to_string(folder.join(format!("{name}.obj"))).unwrap();
    holds("cube", &measure(&read("cube"), 0), [0, 24], 8e-3, 1.3);
    holds("cube, isolated", &measure(&read("cube"), 2), [360, 24], 1.6e-3, 0.3);
    holds("Spot2", &measure(&read("Spot2"), 0), [2536, 392], 2e-3, 10.0);
    holds("ItaPaperGeom", &measure(&read("ItaPaperGeom"), 0), [64, 64], 4e-3, 3.2);
}
