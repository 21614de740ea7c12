//! Gradient meshes in the editor's window, by a script: what is saved is what the operations make.

mod editor_support;

use editor_support::*;
use glam::{DVec2, DVec4};
use gradtess::edit::gradient::journal::restore;
use gradtess::edit::gradient::pick::Pick;
use gradtess::edit::journal_file::left_behind;
use gradtess::ferguson::inherit::Continuity;
use gradtess::ferguson::split::Axis;
use gradtess::ferguson::Mesh;
use gradtess::scene::ferguson::{parse, write};
use std::path::Path;
use std::time::{Duration, Instant};

fn load(file: &Path) -> Mesh {
    parse(&std::fs::read(file).unwrap(), "scene").unwrap().0
}

#[test]
fn a_session_on_a_gradient_mesh_saves_what_the_operations_make() {
    let display = Display::new();
    let folder = Folder::new("gradient");
    let scene = folder.join("grid.json");
    let colour = |i: u32, j: u32| DVec4::new(f64::from(i) / 3.0, f64::from(j) / 3.0, 0.5, 1.0);
    let mut wanted = Mesh::grid(3, 3, [0.0, 0.0, 3.0, 3.0], colour).unwrap();
    wanted.name = "grid".to_owned();
    std::fs::write(&scene, write(&wanted)).unwrap();
    let mut wanted = load(&scene);
    let at = |mesh: &Mesh, p: DVec2| {
        let near = |&q: &u32| mesh.at(q).distance(p) < 1e-9 && !mesh.points[q as usize].corners.is_empty();
        (0..mesh.points.len() as u32).find(near).unwrap()
    };
    let patch = wanted.live().find(|&p| wanted.evaluate(p, 0.5, 0.5).0.distance(DVec2::new(1.5, 1.5)) < 1e-9).unwrap();

    let mut script = Script::default();
    // A split at the cursor, another that is undone for good, and one whose curve is selected and removed.
    script.aim(DVec2::new(1.4, 1.7));
    script.key("U");
    script.aim(DVec2::new(0.5, 0.4));
    script.key("V");
    script.aim(DVec2::new(0.2, 0.4));
    script.act("\"down\":\"left\"");
    script.act("\"up\":\"left\"");
    script.act("\"screenshot\":\"split\"");
    script.key("Delete");
    // A point, a handle in C0 mode, and one sector of a point.
    script.drag(DVec2::new(2.0, 2.0), DVec2::new(2.2, 2.1));
    script.key("C");
    script.drag(DVec2::new(1.0 + 1.0 / 3.0, 1.0), DVec2::new(1.4, 0.9));
    script.aim(DVec2::new(1.0, 2.0));
    script.act("\"down\":\"left\"");
    script.act("\"up\":\"left\"");
    script.act("\"paste\":\"#102030\"");
    script.aim(DVec2::new(0.88, 2.12));
    script.act("\"down\":\"left\"");
    script.act("\"up\":\"left\"");
    script.act("\"paste\":\"#ff0000\"");
    (0..4).for_each(|_| script.key("Ctrl+Z"));
    (0..4).for_each(|_| script.key("Ctrl+Y"));
    script.key("Ctrl+S");
    script.act("\"move\":[880,620]");
    script.act("\"screenshot\":\"saved\"");
    let report = session(&display, &folder, Some(&scene), &script.text);
    assert_eq!((&report["unsaved"], &report["steps"]), (&false.into(), &7.into()), "{report}");

    wanted.split(patch, Axis::U, 0.4).unwrap();
    let other = wanted.live().find(|&p| wanted.evaluate(p, 0.5, 0.5).0.distance(DVec2::splat(0.5)) < 1e-9).unwrap();
    let split = wanted.split(other, Axis::V, 0.4).unwrap();
    wanted.remove_split(split.curve).unwrap();
    wanted.move_point(at(&wanted, DVec2::splat(2.0)), DVec2::new(2.2, 2.1), Continuity::C1).unwrap();
    let near = |c: &u32, end: usize| wanted.curve(*c).handles[end].distance(DVec2::new(4.0 / 3.0, 1.0)) < 1e-9;
    let used = |c: &u32| wanted.curve(*c).sides.iter().any(|l| !l.is_empty());
    let (c, end) = (0..wanted.curves.len() as u32)
        .filter(used)
        .find_map(|c| (0..2).find(|&end| near(&c, end)).map(|end| (c, end)))
        .unwrap();
    wanted.move_handle(c, end, DVec2::new(1.4, 0.9), Continuity::C0).unwrap();
    let point = at(&wanted, DVec2::new(1.0, 2.0));
    wanted.set_colour(point, DVec4::new(16.0, 32.0, 48.0, 255.0) / 255.0, Continuity::C0).unwrap();
    let corner = wanted.points[point as usize].corners.iter().copied().find(|h| {
        let middle = wanted.evaluate(h.patch(), 0.5, 0.5).0;
        middle.x < 1.0 && middle.y > 2.0
    });
    wanted.set_sector_colour(corner.unwrap(), DVec4::new(1.0, 0.0, 0.0, 1.0), Continuity::C0).unwrap();

    // Through the same file; the pointer's places are single precision, so numbers agree to that.
    let file = folder.join("wanted.json");
    std::fs::write(&file, write(&wanted)).unwrap();
    let (saved, wanted) = (load(&scene), load(&file));
    assert_eq!(saved.fault(), None);
    assert_eq!(saved.live().count(), wanted.live().count());
    for (p, q) in saved.live().zip(wanted.live()) {
        for k in 0..25 {
            let (u, v) = (f64::from(k % 5) / 4.0, f64::from(k / 5) / 4.0);
            let (a, b) = (saved.evaluate(p, u, v), wanted.evaluate(q, u, v));
            assert!(a.0.distance(b.0) < 1e-5 && a.1.distance(b.1) < 1e-5, "patch {p} {u} {v}: {a:?} {b:?}");
        }
    }
    // The picture in the window is that of the scene: the sharp sector is red.
    let picture = gradtess::image::Picture::read_png(&folder.join("saved.png")).unwrap();
    let reds = picture.rgba.chunks_exact(4).filter(|p| p[0] > 235 && p[1] < 40 && p[2] < 40).count();
    assert!(reds > 30, "{reds}");
    keep_pictures(&folder, &["split.png", "saved.png"]);
}

/// A drawing is opened, edited and still held by a handle when the process is killed; the next start restores it, and it is
/// saved beside the drawing.
#[test]
fn after_kill_nine_a_drawing_s_mesh_is_restored_and_saved() {
    let display = Display::new();
    let folder = Folder::new("gradient-kill");
    let drawing = folder.join("two.svg");
    let patch = |stops: [&str; 4], paths: [&str; 4]| {
        let stop = |(path, colour): (&str, &str)| format!("<stop path='{path}' stop-color='{colour}'/>");
        let all: String = paths.into_iter().zip(stops).filter(|(path, _)| !path.is_empty()).map(stop).collect();
        format!("<meshpatch>{all}</meshpatch>")
    };
    let text = format!(
        "<svg xmlns='http://www.w3.org/2000/svg'><meshgradient gradientUnits='userSpaceOnUse'><meshrow>{}{}</meshrow></meshgradient></svg>",
        patch(["#f00", "#ff0", "#0a0", "#00f"], ["l 100,0", "l 0,100", "l -100,0", "l 0,-100"]),
        patch(["#0ff", "#0ff", "#333", "#333"], ["l 100,0", "l 0,100", "l -100,0", ""]),
    );
    std::fs::write(&drawing, &text).unwrap();
    // y is up in the editor.
    let mut script = Script::default();
    script.aim(DVec2::new(30.0, -40.0));
    script.key("U");
    script.key("V");
    script.drag(DVec2::new(100.0, 0.0), DVec2::new(110.0, 8.0));
    script.key("C");
    let target = DVec2::new(205.0, -140.0);
    script.hold(DVec2::new(200.0, -100.0), target);
    script.act("\"wait\":600");
    let file = folder.join("script.jsonl");
    std::fs::write(&file, &script.text).unwrap();
    let arguments = [drawing.to_str().unwrap(), "--script", file.to_str().unwrap(), "--size", "900x640"];
    let mut child = program(Some(&display.name), &folder, &arguments).spawn().unwrap();
    let begun = Instant::now();
    let lines = || {
        let files = std::fs::read_dir(&folder.0).unwrap().flatten().map(|e| e.path());
        let journal = files.into_iter().find(|p| p.extension().is_some_and(|e| e == "gradtess-journal"));
        journal.map_or(0, |j| std::fs::read_to_string(j).unwrap_or_default().lines().count())
    };
    // The mesh, three steps, and what is held.
    while lines() < 5 {
        assert!(begun.elapsed() < Duration::from_secs(240), "{} lines", lines());
        std::thread::sleep(Duration::from_millis(50));
    }
    std::thread::sleep(Duration::from_millis(1200));
    child.kill().unwrap();
    child.wait().unwrap();
    let left = left_behind(Some(&drawing), None);
    let expected = restore(&left[0]).unwrap().gradient;
    assert_eq!((left.len(), expected.steps(), expected.mesh.live().count()), (1, 4, 4));
    let held = expected.at(target, 1e-3).map(|pick| (pick, expected.place(pick)));
    assert!(matches!(held, Some((Pick::Point(_), at)) if at.distance(target) < 1e-3), "{held:?}");

    let mut script = Script::default();
    script.act("\"screenshot\":\"offer\"");
    script.key("Enter");
    script.key("Ctrl+S");
    script.act("\"screenshot\":\"name\"");
    script.key("Enter");
    script.act("\"screenshot\":\"restored\"");
    let report = session(&display, &folder, Some(&drawing), &script.text);
    assert_eq!((&report["unsaved"], &report["steps"]), (&false.into(), &4.into()), "{report}");
    let saved = load(&folder.join("two.json"));
    assert_eq!(write(&saved), write(&expected.mesh));
    assert_eq!(std::fs::read_to_string(&drawing).unwrap(), text, "the drawing itself was not touched");
    assert!(left_behind(Some(&drawing), None).is_empty());
    keep_pictures(&folder, &["offer.png", "name.png", "restored.png"]);
}

fn keep_pictures(folder: &Folder, names: &[&str]) {
    if let Some(keep) = std::env::var_os("KEEP_PICTURES") {
        for name in names {
            std::fs::copy(folder.join(name), Path::new(&keep).join(name)).unwrap();
        }
    }
}
