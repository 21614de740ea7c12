//! The editor in a real window on a virtual display, by scripts: what is saved, shown, restored and refused.
//!
//! Each session is the program itself under the validation layer, whose messages end it with status 1.

mod editor_support;

use editor_support::*;
use glam::{DVec2, DVec4};
use gradtess::edit::change::Change;
use gradtess::edit::drag::size_of;
use gradtess::edit::handle::{Id, Kind, Stage};
use gradtess::edit::journal;
use gradtess::edit::model::{Drawing, Model};
use gradtess::edit::overlay::Handle;
use gradtess::image::Picture;
use gradtess::patch::build::face_control;
use gradtess::patch::eval;
use gradtess::scene::Scene;
use std::path::Path;
use std::time::{Duration, Instant};

#[test]
fn a_session_on_a_real_model_saves_the_expected_scene_and_looks_as_expected() {
    let display = Display::new();
    let folder = Folder::new("session");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let original = Scene::load(root.join("scenes/cherry.json")).unwrap();
    let scene = folder.join("cherry.json");
    original.save(&scene).unwrap();

    let mut script = Script::default();
    let size = size_of(&original);
    // Points at levels 0, 2 and 4, each seen from near enough.
    for (key, level, place) in
        [("0", 0, DVec2::new(-0.2, -0.5)), ("2", 2, DVec2::new(-0.3, -0.9)), ("4", 4, DVec2::new(-0.5, -0.6))]
    {
        let all = handles(&original, Stage::Level(0));
        let centre = all.iter().map(|h| h.at).sum::<DVec2>() / all.len() as f64 + place * 0.1 * size;
        // A close look: the whole of level 4 is more than is shown.
        let (low, high) = (centre - DVec2::splat(0.08 * size), centre + DVec2::splat(0.08 * size));
        let near = handles_in(&original, Stage::Level(level), [low.x, low.y, high.x, high.y]);
        let from = nearest(&near, Kind::Vertex, centre).at;
        script.key(key);
        script.aim(from);
        if level > 2 {
            (0..9).for_each(|_| script.act("\"wheel\":[0,1]"));
        }
        script.drag(from, from + DVec2::new(0.02, 0.015) * size / f64::from(1 << level));
        script.key("F");
    }
    script.act("\"screenshot\":\"moved\"");
    // The brush, on level 1.
    let colours = handles(&original, Stage::Level(1));
    let start = nearest(&colours, Kind::Colour, colours[colours.len() / 2].at).at;
    script.key("1");
    script.key("B");
    script.drag(start, start + DVec2::new(0.1, 0.02) * size);
    // A sharp edge of the input mesh.
    let model = Model::new(original.clone(), Drawing::default()).unwrap();
    let mesh = &model.mesh;
    let edge = (0..mesh.half_edges())
        .filter(|&h| mesh.twin[h as usize] != gradtess::mesh::NONE)
        .find(|&h| !gradtess::edit::paint::is_sharp(&original, mesh, h))
        .unwrap();
    let slot = 8 * u64::from(edge) + 4;
    let input = handles(&original, Stage::Input);
    let on_edge = gradtess::edit::place::exact_limit(&original, mesh, 0, slot).unwrap();
    assert!(input.iter().any(|h| h.at.distance(on_edge) < 1e-9));
    script.key("M");
    script.key("E");
    script.aim(on_edge);
    script.act("\"down\":\"left\"");
    script.act("\"up\":\"left\"");
    // Steps enough to undo ten of them.
    script.key("V");
    script.key("0");
    let corner = nearest(&handles(&original, Stage::Level(0)), Kind::Vertex, on_edge + DVec2::new(0.2, 0.0) * size).at;
    script.aim(corner);
    script.act("\"down\":\"left\"");
    script.act("\"up\":\"left\"");
    for key in [
        "ArrowLeft",
        "ArrowUp",
        "Shift+ArrowLeft",
        "ArrowDown",
        "ArrowRight",
        "Shift+ArrowUp",
        "ArrowLeft",
        "ArrowLeft",
    ] {
        script.key(key);
    }
    (0..10).for_each(|_| script.key("Ctrl+Z"));
    (0..5).for_each(|_| script.key("Ctrl+Shift+Z"));
    script.key("Ctrl+S");
    script.key("Escape");
    script.key("F");
    script.act("\"move\":[880,620]");
    script.act("\"screenshot\":\"saved\"");

    let report = session(&display, &folder, Some(&scene), &script.text);
    assert_eq!(report["unsaved"], false, "{report}");
    assert!(report["message"].as_str().unwrap().starts_with("saved"), "{report}");
    let bytes = std::fs::read(&scene).unwrap();
    let saved = Scene::load(&scene).unwrap();
    // Three points, the brush, the edge and eight nudges, less five undone for good.
    assert_eq!(report["steps"], 8, "{report}");
    assert!(saved.geometry.len() > original.geometry.len() && saved.colours.len() > original.colours.len());
    assert_eq!(saved.sharp.len(), original.sharp.len() + 1);
    // What is new in each list, and how much of the old is left.
    let geometry: Vec<_> = saved.geometry.iter().filter(|e| !original.geometry.contains(e)).collect();
    let colours: Vec<_> = saved.colours.iter().filter(|e| !original.colours.contains(e)).collect();
    let sharp: Vec<_> = saved.sharp.iter().filter(|e| !original.sharp.contains(e)).collect();
    let kept = [
        saved.geometry.iter().filter(|e| original.geometry.contains(e)).count(),
        saved.colours.iter().filter(|e| original.colours.contains(e)).count(),
    ];
    let rest = Scene {
        geometry: original.geometry.clone(),
        colours: original.colours.clone(),
        sharp: original.sharp.clone(),
        ..saved.clone()
    };
    assert!(Change::between(&original, &rest).is_empty(), "nothing else changed");
    let new = serde_json::json!({ "geometry": geometry, "colours": colours, "sharp": sharp, "kept": kept });
    golden_json("editor_session.json", &new);
    golden_picture("editor_session.png", &folder.join("saved.png"));
    // The same script again: the same bytes.
    original.save(&scene).unwrap();
    session(&display, &folder, Some(&scene), &script.text);
    assert!(std::fs::read(&scene).unwrap() == bytes, "the same script made another file");
}

#[test]
fn drags_end_on_the_limit_and_stop_at_folds_unless_that_is_switched_off() {
    let display = Display::new();
    let folder = Folder::new("drags");
    let names =
        ["quad", "pentagon", "fan:5", "ring:5", "hexagon", "triangle", "pentagon", "pentagon", "hexagon", "quad"];
    let original = row(&names);
    let scene = folder.join("row.json");
    original.save(&scene).unwrap();
    let mut script = Script::default();
    // One kind of handle on each of the first six.
    let kinds = [
        (Stage::Level(0), "0", Kind::Vertex, DVec2::new(0.3, 0.3)),
        (Stage::Input, "M", Kind::Gradient, DVec2::new(0.3, 0.9)),
        (Stage::Level(1), "1", Kind::Vertex, DVec2::new(0.2, 0.2)),
        (Stage::Level(2), "2", Kind::Vertex, DVec2::new(0.0, 1.0)),
        (Stage::Input, "M", Kind::FacePoint, DVec2::new(0.1, 0.4)),
        (Stage::Level(1), "1", Kind::Vertex, DVec2::new(-0.5, 0.2)),
    ];
    let mut wanted = Vec::new();
    for (i, (stage, key, kind, place)) in kinds.into_iter().enumerate() {
        let handle = nearest(&handles(&original, stage), kind, middle(i) + place);
        script.key(key);
        script.drag(handle.at, handle.at + DVec2::new(0.031, -0.023));
        wanted.push(handle);
    }
    // Points that lie under a colour: the second click goes through to them.
    for (i, stage, key, kind) in [(8, Stage::Input, "M", Kind::Input), (9, Stage::Level(1), "1", Kind::Vertex)] {
        let all = handles(&original, stage);
        let far = |h: &&Handle| h.at.distance(middle(i) + DVec2::new(0.9, 0.9));
        let coloured = |h: &Handle| all.iter().any(|c| c.id.kind == Kind::Colour && c.at == h.at);
        let under = all.iter().filter(|h| h.id.kind == kind && coloured(h));
        let handle = *under.min_by(|a, b| far(a).total_cmp(&far(b))).unwrap();
        script.key(key);
        script.aim(handle.at);
        for _ in 0..2 {
            script.act("\"down\":\"left\"");
            script.act("\"up\":\"left\"");
        }
        script.drag(handle.at, handle.at + DVec2::new(0.031, -0.023));
        wanted.push(handle);
    }
    // The same drag into a fold with and without prevention.
    let all = handles(&original, Stage::Level(1));
    for (i, key) in [(6, "1"), (7, "P")] {
        let handle = nearest(&all, Kind::Vertex, middle(i) + DVec2::new(0.35, 0.3));
        script.key(key);
        script.drag(handle.at, handle.at + DVec2::new(-0.9, -0.8));
        wanted.push(handle);
    }
    script.key("Ctrl+S");
    script.act("\"screenshot\":\"row\"");
    let report = session(&display, &folder, Some(&scene), &script.text);
    let dragged = report["dragged"].as_array().unwrap();
    assert_eq!(dragged.len(), wanted.len(), "{report}");
    let size = size_of(&original);
    let samples = exact_samples(&scene, 5);
    for (drag, handle) in dragged.iter().zip(&wanted) {
        let id: Id = serde_json::from_value(drag["handle"].clone()).unwrap();
        assert_eq!(id, handle.id);
        let at: DVec2 = serde_json::from_value(drag["at"].clone()).unwrap();
        assert!(at.distance(handle.at) > 1e-3 * size, "{id:?} did not move");
        let off = samples.iter().map(|p| p.distance(at)).fold(f64::INFINITY, f64::min);
        assert!(off < 1e-9 * size, "{id:?}: {off:e} from the limit");
    }
    // The Jacobian of every patch at 64 x 64 points, by the side of the row it lies in.
    let saved = Model::new(Scene::load(&scene).unwrap(), Drawing::default()).unwrap();
    let mut least = vec![f64::INFINITY; names.len()];
    for face in &saved.table.faces {
        let points = face_control(&saved.table, face);
        let centre = DVec2::new(points[5][0], points[5][1]);
        let side = (0..names.len())
            .min_by(|&a, &b| middle(a).distance(centre).total_cmp(&middle(b).distance(centre)))
            .unwrap();
        for k in 0..64 * 64 {
            let at = |k: usize| (k as f64 + 0.5) / 64.0;
            let s = eval::face_sample(face.kind, &points, at(k % 64), at(k / 64));
            least[side] = least[side].min(s.du[0] * s.dv[1] - s.du[1] * s.dv[0]);
        }
    }
    let folded: Vec<usize> = (0..names.len()).filter(|&i| least[i] <= 0.0).collect();
    assert_eq!(folded, [7], "it folds where nothing prevents it and nowhere else: {least:?}");
}

#[test]
fn after_kill_nine_the_next_start_restores_all_but_the_last_second() {
    let display = Display::new();
    let folder = Folder::new("kill");
    let original = row(&["quad", "pentagon", "hexagon"]);
    let scene = folder.join("row.json");
    original.save(&scene).unwrap();
    let bytes = std::fs::read(&scene).unwrap();
    let mut script = Script::default();
    let all = handles(&original, Stage::Level(1));
    script.key("1");
    for i in 0..2 {
        let from = nearest(&all, Kind::Vertex, middle(i) + DVec2::new(0.2, 0.1)).at;
        script.drag(from, from + DVec2::new(0.05, 0.02));
    }
    // And one that is still held when the end comes.
    let held = nearest(&all, Kind::Vertex, middle(2) + DVec2::new(0.2, 0.1));
    let target = held.at + DVec2::new(0.04, 0.03);
    script.hold(held.at, target);
    script.act("\"wait\":600");
    let file = folder.join("script.jsonl");
    std::fs::write(&file, &script.text).unwrap();
    let arguments = [scene.to_str().unwrap(), "--script", file.to_str().unwrap(), "--size", "900x640"];
    let mut child = program(Some(&display.name), &folder, &arguments).spawn().unwrap();
    // Two steps and the gesture are in the journal within a second of being made; how long that takes to be made here
    // is another matter.
    let begun = Instant::now();
    let lines = || {
        let files = std::fs::read_dir(&folder.0).unwrap().flatten().map(|e| e.path());
        let journal = files.into_iter().find(|p| p.extension().is_some_and(|e| e == "gradtess-journal"));
        journal.map_or(0, |j| std::fs::read_to_string(j).unwrap_or_default().lines().count())
    };
    while lines() < 4 {
        assert!(begun.elapsed() < Duration::from_secs(240), "{} lines", lines());
        std::thread::sleep(Duration::from_millis(50));
    }
    // What is older than a second has to be there.
    std::thread::sleep(Duration::from_millis(1200));
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(std::fs::read(&scene).unwrap() == bytes, "the scene itself was not touched");
    let left = journal::left_behind(Some(&scene), None);
    assert_eq!(left.len(), 1);
    let expected = journal::restore(&left[0]).unwrap().scene;
    assert_eq!(expected.geometry.len(), 3);
    let mesh = gradtess::mesh::build(&expected.mesh).unwrap();
    let at = gradtess::edit::place::exact_limit(&expected, &mesh, held.id.level, held.id.slot).unwrap();
    assert!(at.distance(target) < 1e-4, "the point that was held is {at}, not {target}");

    let mut script = Script::default();
    script.act("\"screenshot\":\"offer\"");
    script.key("Enter");
    script.key("Ctrl+S");
    let report = session(&display, &folder, Some(&scene), &script.text);
    assert_eq!((&report["unsaved"], &report["steps"]), (&false.into(), &3.into()), "{report}");
    assert_eq!(Scene::load(&scene).unwrap().geometry, expected.geometry);
    assert!(journal::left_behind(Some(&scene), None).is_empty());
}

#[test]
fn habits_of_a_drawing_program() {
    let display = Display::new();
    let folder = Folder::new("habits");
    let original = row(&["quad", "pentagon"]);
    let scene = folder.join("row.json");
    original.save(&scene).unwrap();
    let bytes = std::fs::read(&scene).unwrap();
    let other = folder.join("deep/other.json");
    let reference = folder.join("under.png");
    Picture { width: 2, height: 2, rgba: [10, 200, 30, 255].repeat(4) }.write_png(&reference, &[]).unwrap();

    let mut script = Script::default();
    script.key("M");
    // A box around the quad; by one pixel to the right, by ten upwards.
    script.drag(DVec2::new(-0.85, -0.85), DVec2::new(0.85, 0.85));
    script.key("ArrowRight");
    script.key("Shift+ArrowUp");
    // A colour from one handle to another, of the pentagon.
    let colour = |at: DVec2| nearest(&handles(&original, Stage::Input), Kind::Sector, at);
    let vertex = nearest(&handles(&original, Stage::Input), Kind::Colour, middle(1) + DVec2::new(1.0, 0.0));
    let quad = nearest(&handles(&original, Stage::Input), Kind::Colour, DVec2::new(1.0, -1.0));
    assert_ne!(colour(quad.at).colour, vertex.colour);
    script.aim(vertex.at);
    script.act("\"down\":\"left\"");
    script.act("\"up\":\"left\"");
    script.act("\"paste\":\"#112233\"");
    // A polygon click by click: the last corner taken back, another in its place, closed by Enter.
    script.key("D");
    let corners = [(-0.8, -1.4), (0.0, -1.7), (0.9, -1.5), (1.1, -1.7), (0.4, -1.25)].map(|(x, y)| DVec2::new(x, y));
    for (i, &corner) in corners.iter().enumerate() {
        script.aim(corner);
        script.act("\"down\":\"left\"");
        script.act("\"up\":\"left\"");
        if i == 3 {
            script.key("Backspace");
        }
    }
    script.key("Enter");
    // A picture dropped on the window lies under the mesh.
    script.act(&format!("\"drop\":{:?}", reference.display().to_string()));
    // Everything undone and done again, and saved under another name in another folder.
    (0..9).for_each(|_| script.key("Ctrl+Z"));
    (0..9).for_each(|_| script.key("Ctrl+Y"));
    std::fs::create_dir(folder.join("deep")).unwrap();
    script.key("Ctrl+Shift+S");
    script.key("Ctrl+A");
    script.act("\"text\":\"deep/other\"");
    script.key("Enter");
    script.act("\"wait\":0.05");
    let report = session(&display, &folder, Some(&scene), &script.text);
    assert_eq!(report["unsaved"], false, "{report}");
    assert!(std::fs::read(&scene).unwrap() == bytes, "the first file is as it was");
    let saved = Scene::load(&other).unwrap();
    let step = saved.mesh.positions[0] - original.mesh.positions[0];
    assert!(step.x > 0.0 && (step.y - 10.0 * step.x).abs() < 1e-9, "{step}");
    for (before, after) in original.mesh.positions.iter().zip(&saved.mesh.positions) {
        let moved = if before.x < 1.5 { step } else { DVec2::ZERO };
        assert!((*after - *before).distance(moved) < 1e-9, "{before} {after}");
    }
    let pasted = DVec4::new(17.0, 34.0, 51.0, 255.0) / 255.0;
    let painted = saved.corner_colours.iter().chain(saved.colours.iter().map(|e| &e.colour));
    assert!(painted.into_iter().any(|c| c.distance(pasted) < 1e-3), "the pasted colour");
    let drawn = &saved.mesh.positions[original.mesh.positions.len()..];
    assert_eq!((drawn.len(), saved.mesh.face_start.len()), (4, original.mesh.face_start.len() + 1));
    assert!(drawn[3].distance(corners[4]) < 0.02 && drawn[2].distance(corners[2]) < 0.02, "{drawn:?}");
    // The picture is found from the other folder too.
    let named = saved.reference.unwrap();
    assert!(folder.join("deep").join(&named.file).is_file(), "{}", named.file);
}

#[test]
fn bad_input_is_a_message_in_the_window_and_harms_nothing() {
    let display = Display::new();
    let folder = Folder::new("bad");
    let say = |scene: &Path, script: &str| {
        session(&display, &folder, Some(scene), script)["message"].as_str().unwrap_or_default().to_owned()
    };
    let wait = "{\"at\":0.1,\"wait\":0.01}\n";
    let missing = folder.join("missing.json");
    assert!(say(&missing, wait).contains("cannot be read"));
    let newer = folder.join("newer.json");
    std::fs::write(&newer, "{\"gradtess\": 2, \"spline\": []}").unwrap();
    assert!(say(&newer, wait).contains("version"));
    let lost = folder.join("lost.json");
    std::fs::write(
        &lost,
        "{\"gradtess\": 1, \"builtin\": \"quad\", \"reference\": {\"file\": \"gone.png\", \"rect\": [0, 0, 1, 1], \"opacity\": 1, \"locked\": true}}",
    )
    .unwrap();
    assert!(say(&lost, wait).contains("reference picture"));
    // A folder that is not there cannot be written to, whoever runs the test. The work stays in the journal.
    let gone = folder.join("gone");
    std::fs::create_dir(&gone).unwrap();
    let scene = gone.join("a.json");
    let original = row(&["quad"]);
    original.save(&scene).unwrap();
    let from = nearest(&handles(&original, Stage::Level(1)), Kind::Vertex, DVec2::new(0.2, 0.2)).at;
    let mut script = Script::default();
    script.key("1");
    script.drag(from, from + DVec2::new(0.05, 0.0));
    script.act("\"wait\":6");
    script.key("Ctrl+S");
    let file = folder.join("late.jsonl");
    std::fs::write(&file, &script.text).unwrap();
    let arguments = [scene.to_str().unwrap(), "--json", "--script", file.to_str().unwrap()];
    let child = program(Some(&display.name), &folder, &arguments).spawn().unwrap();
    let begun = Instant::now();
    while std::fs::read_dir(&gone).unwrap().count() < 2 {
        assert!(begun.elapsed() < Duration::from_secs(200), "no journal");
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_millis(500));
    std::fs::rename(&gone, folder.join("elsewhere")).unwrap();
    let out = within(child, 240);
    let report: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    assert!(report["message"].as_str().unwrap().contains("cannot be written"), "{report}");
    assert_eq!(report["unsaved"], true);
    let left = journal::left_behind(Some(&folder.join("elsewhere/a.json")), None);
    assert_eq!(journal::restore(&left[0]).unwrap().scene.geometry.len(), 1);
}
