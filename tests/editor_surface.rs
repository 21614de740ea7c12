//! A surface in space in the editor's window, by a script: edges are picked, made sharp, and saved as OBJ.

mod editor_support;

use editor_support::*;
use glam::DVec3;
use gradtess::image::Picture;
use gradtess::scene::surface::SurfaceScene;
use std::path::Path;

const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

fn load(file: &Path) -> SurfaceScene {
    SurfaceScene::parse(&std::fs::read(file).unwrap(), "saved").unwrap()
}

/// Sharpness of the edge whose middle is at a place; both halves have to say the same.
fn sharpness(scene: &SurfaceScene, middle: DVec3) -> f64 {
    let mut found = Vec::new();
    for range in scene.face_start.windows(2) {
        let (start, end) = (range[0] as usize, range[1] as usize);
        for k in start..end {
            let before = if k == start { end - 1 } else { k - 1 };
            let [a, b] = [before, k].map(|k| scene.positions[scene.corners[k] as usize]);
            if ((a + b) * 0.5).distance(middle) < 1e-9 {
                found.push(scene.edge_sharpness[k]);
            }
        }
    }
    assert!(found.len() == 2 && found[0] == found[1], "{middle}: {found:?}");
    found[0]
}

#[test]
fn a_session_on_a_surface_saves_the_sharpness_that_was_set() {
    let display = Display::new();
    let folder = Folder::new("surface");
    let scene = folder.join("cube.obj");
    std::fs::write(&scene, CUBE).unwrap();
    let [top, right, left] = [DVec3::new(0.0, 1.0, 1.0), DVec3::new(1.0, 0.0, 1.0), DVec3::new(-1.0, 0.0, 1.0)];

    let mut script = Script::default();
    let click = |script: &mut Script, p: DVec3| {
        script.act(&format!("\"aim_at\":[{},{},{}]", p.x, p.y, p.z));
        script.act("\"down\":\"left\"");
        script.act("\"up\":\"left\"");
    };
    let press = |script: &mut Script, [x, y]: [i32; 2]| {
        script.act(&format!("\"move\":[{x},{y}]"));
        script.act("\"down\":\"left\"");
        script.act("\"up\":\"left\"");
    };
    // One edge, step by step to 1.5; then two more at once, for ever, by the panel's button.
    script.key("4");
    click(&mut script, top);
    (0..3).for_each(|_| script.key("ArrowUp"));
    click(&mut script, right);
    script.act("\"modifiers\":\"Shift\"");
    click(&mut script, left);
    script.act("\"modifiers\":\"\"");
    script.act("\"screenshot\":\"picked\"");
    press(&mut script, FOR_EVER);
    // A drag turns it and picks nothing; the same edges stay selected.
    script.act("\"move\":[600,560]");
    script.act("\"down\":\"left\"");
    (1..5).for_each(|k| script.act(&format!("\"move\":[{},{}]", 600 + 20 * k, 560 - 5 * k)));
    script.act("\"up\":\"left\"");
    script.act("\"wheel\":[0,1]");
    // Back to smooth, and to what it was.
    script.key("Delete");
    script.key("Ctrl+Z");
    script.key("Ctrl+Z");
    script.key("Ctrl+Z");
    script.key("Ctrl+Y");
    script.key("Ctrl+Y");
    script.key("Escape");
    script.act("\"move\":[880,620]");
    script.act("\"screenshot\":\"triangles\"");
    press(&mut script, PATCHES);
    script.act("\"move\":[880,620]");
    script.act("\"screenshot\":\"patches\"");
    press(&mut script, LOOP);
    script.act("\"move\":[880,620]");
    script.act("\"screenshot\":\"loop\"");
    script.key("Ctrl+S");
    let report = session(&display, &folder, Some(&scene), &script.text);
    if let Some(keep) = std::env::var_os("KEEP_PICTURES") {
        for name in ["picked.png", "triangles.png", "patches.png", "loop.png"] {
            std::fs::copy(folder.join(name), Path::new(&keep).join(name)).unwrap();
        }
    }
    assert_eq!((&report["unsaved"], &report["steps"]), (&false.into(), &4.into()), "{report}");

    let saved = load(&scene);
    for (middle, wanted) in [(top, 1.5), (right, f64::INFINITY), (left, f64::INFINITY), (-top, 0.0), (-right, 0.0)] {
        assert_eq!(sharpness(&saved, middle), wanted, "{middle}");
    }
    assert_eq!(saved.positions, load_text(CUBE).positions);
    assert!(std::fs::read_to_string(&scene).unwrap().contains("\nfs 1.5 inf 0 inf\n"));
    // The same surface by triangles and by patches, another by Loop.
    let picture = |name: &str| Picture::read_png(&folder.join(&format!("{name}.png"))).unwrap();
    let differ = |a: &Picture, b: &Picture| {
        let canvas = |p: &Picture, x: u32, y: u32| p.pixel(x, y).map(i32::from);
        let all = (220..900u32).flat_map(|x| (40..600u32).map(move |y| (x, y)));
        all.filter(|&(x, y)| canvas(a, x, y).iter().zip(canvas(b, x, y)).any(|(p, q)| (p - q).abs() > 24)).count()
    };
    let [triangles, patches, loops] = ["triangles", "patches", "loop"].map(picture);
    let (near, far) = (differ(&triangles, &patches), differ(&patches, &loops));
    assert!(near < 2000 && far > 10 * near.max(200), "{near} {far}");
}

fn load_text(text: &str) -> SurfaceScene {
    SurfaceScene::parse(text.as_bytes(), "text").unwrap()
}

/// Where the panel has its widgets, in a window of this size.
const FOR_EVER: [i32; 2] = [94, 116];
const PATCHES: [i32; 2] = [14, 239];
const LOOP: [i32; 2] = [116, 218];
