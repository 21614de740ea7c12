//! The editor's window on a virtual display: sizes, scales, formats, and how it closes.
//!
//! Each session is the program itself under the validation layer, whose messages end it with status 1.

mod editor_support;

use editor_support::*;
use glam::DVec2;
use gradtess::edit::handle::{Kind, Stage};
use gradtess::edit::journal;
use gradtess::image::{compare, Picture};
use gradtess::scene::Scene;
use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

#[test]
fn windows_that_are_resized_minimised_suspended_and_closed_during_a_capture_end_well() {
    let display = Display::new();
    let folder = Folder::new("window");
    let scene = folder.join("row.json");
    row(&["quad", "fan:5"]).save(&scene).unwrap();
    let script = r#"
        {"at":0.1,"key":"T"}
        {"at":0.2,"resize":[700,500]}
        {"at":0.3,"screenshot":"small"}
        {"at":0.4,"minimise":true}
        {"at":0.5,"minimise":false}
        {"at":0.55,"suspend":true}
        {"at":0.56,"move":[300,200]}
        {"at":0.57,"wait":0.1}
        {"at":0.58,"suspend":false}
        {"at":0.6,"resize":[1000,700]}
        {"at":0.7,"screenshot":"large"}
        {"at":0.8,"key":"Shift+T"}
        {"at":0.9,"wait":0.3}
        {"at":1.0,"text":"?"}
        {"at":1.1,"close":true}
    "#;
    // Drawn into the surface itself, and through an image where the surface would convert.
    for surface in [&[][..], &["--srgb-surface"]] {
        session_with(&display, &folder, Some(&scene), script, surface);
        for (name, size) in [("small", (700, 500)), ("large", (1000, 700))] {
            let picture = Picture::read_png(&folder.join(&format!("{name}.png"))).unwrap();
            assert_eq!((picture.width, picture.height), size);
        }
    }
}

#[test]
fn the_display_has_the_colours_that_were_drawn_whatever_its_surface_converts() {
    let display = Display::new();
    let client = Client::new(&display);
    let folder = Folder::new("surface");
    let scene = folder.join("row.json");
    row(&["quad", "fan:5"]).save(&scene).unwrap();
    let file = folder.join("script.jsonl");
    std::fs::write(&file, "{\"at\":0.1,\"screenshot\":\"a\"}\n{\"at\":0.2,\"wait\":600}\n").unwrap();
    let shot = folder.join("a.png");
    for surface in [None, Some("--srgb-surface")] {
        let _ = std::fs::remove_file(&shot);
        let screenshots = folder.0.display().to_string();
        let mut arguments = vec![scene.to_str().unwrap(), "--script", file.to_str().unwrap()];
        arguments.extend(["--size", "600x400", "--screenshots", &screenshots]);
        arguments.extend(surface);
        let mut child = program(Some(&display.name), &folder, &arguments).spawn().unwrap();
        let (window, _) = client.window();
        let begun = Instant::now();
        while !shot.exists() {
            assert!(begun.elapsed() < Duration::from_secs(120), "no screenshot");
            std::thread::sleep(Duration::from_millis(30));
        }
        let drawn = Picture::read_png(&shot).unwrap();
        // The picture is written before the last frames are shown.
        let same = || compare(&drawn, &client.picture(window)).is_some_and(|c| c.fraction_beyond(1) < 0.002);
        let begun = Instant::now();
        while !same() && begun.elapsed() < Duration::from_secs(5) {
            std::thread::sleep(Duration::from_millis(100));
        }
        let right = same();
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(right, "{surface:?}: the display shows other colours than {}", shot.display());
        assert!(drawn.rgba.chunks_exact(4).any(|p| p[0] > 200 && p[1] < 150), "the mesh is in the picture");
    }
}

#[test]
fn the_close_button_ends_what_is_saved_and_asks_about_what_is_not() {
    let display = Display::new();
    let client = Client::new(&display);
    let folder = Folder::new("close");
    let scene = folder.join("row.json");
    let original = row(&["quad"]);
    original.save(&scene).unwrap();
    let path = scene.to_str().unwrap();
    let ended = |child: Child| {
        let out = within(child, 120);
        let error = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.success() && error.is_empty(), "{}: {error}", out.status);
    };
    let child = program(Some(&display.name), &folder, &[path, "--size", "600x400"]).spawn().unwrap();
    let (window, title) = client.window();
    assert!(!title.contains('*'), "{title}");
    client.close(window);
    ended(child);

    // With a change the same window asks. Escape takes it back, Enter saves, and that is the end.
    let from = nearest(&handles(&original, Stage::Level(1)), Kind::Vertex, DVec2::new(0.2, 0.2)).at;
    let mut script = Script::default();
    script.key("1");
    script.drag(from, from + DVec2::new(0.05, 0.0));
    let file = folder.join("script.jsonl");
    std::fs::write(&file, &script.text).unwrap();
    let arguments = [path, "--size", "600x400", "--script", file.to_str().unwrap(), "--stay", "--validate"];
    let mut child = program(Some(&display.name), &folder, &arguments).spawn().unwrap();
    let window = client.changed();
    // The step is whole, and the script at its end.
    std::thread::sleep(Duration::from_millis(1000));
    let plain = client.picture(window);
    let asking = |p: &Picture| compare(&plain, p).is_some_and(|c| c.fraction_beyond(8) > 0.02);
    for _ in 0..2 {
        client.close(window);
        client.until(window, "no question", asking);
        client.close(window);
        client.until_key(window, ESCAPE, "the question stays", |p| !asking(p));
    }
    assert!(child.try_wait().unwrap().is_none(), "the session ended");
    assert_eq!(client.window().0, window);
    assert_eq!(Scene::load(&scene).unwrap().geometry.len(), 0);
    client.close(window);
    client.until(window, "no question", asking);
    let begun = Instant::now();
    while Scene::load(&scene).unwrap().geometry.is_empty() {
        assert!(begun.elapsed() < Duration::from_secs(60), "Enter does not save");
        client.key(window, ENTER);
        std::thread::sleep(Duration::from_millis(300));
    }
    ended(child);
    assert_eq!(Scene::load(&scene).unwrap().geometry.len(), 1);
    assert!(journal::left_behind(Some(&scene), None).is_empty());
}

#[test]
fn at_twice_the_scale_the_whole_window_is_painted_and_clicks_land_where_they_aim() {
    let display = Display::new();
    let client = Client::new(&display);
    let folder = Folder::new("scale");
    let scene = folder.join("quad.json");
    let script = folder.join("script.jsonl");
    // At level 1 there are points that no colour lies over; without outlines their green stands alone.
    std::fs::write(&script, "{\"at\":0.1,\"key\":\"1\"}\n{\"at\":0.2,\"key\":\"P\"}\n").unwrap();
    for (scale, size) in [("1", "1100x800"), ("2", "550x400")] {
        row(&["quad"]).save(&scene).unwrap();
        let arguments =
            [scene.to_str().unwrap(), "--size", size, "--validate", "--stay", "--script", script.to_str().unwrap()];
        let mut command = program(Some(&display.name), &folder, &arguments);
        let child = command.env("WINIT_X11_SCALE_FACTOR", scale).spawn().unwrap();
        let (window, _) = client.window();
        let scale: u32 = scale.parse().unwrap();
        let found = |p: &Picture| blobs(p, POINT, 16 * scale as usize * scale as usize);
        let points = |p: &Picture| found(p).len() >= 8;
        client.until(window, "no points", points);
        let picture = client.picture(window);
        assert_eq!((picture.width, picture.height), (1100, 800));
        // What nobody painted is black.
        let black = picture.rgba.chunks_exact(4).filter(|p| p[..3] == [0, 0, 0]).count();
        assert!(black < 500, "{black} pixels are black at scale {scale}");
        // Takes the green point nearest to the middle and lets it go elsewhere.
        let middle = DVec2::new(550.0, 400.0);
        let near = |p: &Picture, to: DVec2| {
            found(p).into_iter().min_by(|a, b| a.distance(to).total_cmp(&b.distance(to))).unwrap()
        };
        let (from, step) = (near(&picture, middle), DVec2::new(31.0, 23.0));
        let corner = client.place(window);
        let place = |p: DVec2| [corner[0] + p.x.round() as i16, corner[1] + p.y.round() as i16];
        client.pointer(6, 0, place(from));
        std::thread::sleep(Duration::from_millis(300));
        client.pointer(4, 1, [0, 0]);
        for k in 1..=4 {
            std::thread::sleep(Duration::from_millis(120));
            client.pointer(6, 0, place(from + step * f64::from(k) / 4.0));
        }
        std::thread::sleep(Duration::from_millis(120));
        client.pointer(5, 1, [0, 0]);
        client.changed();
        // A click on nothing takes the selection's outline away.
        client.pointer(6, 0, place(DVec2::new(265.0, 60.0)));
        std::thread::sleep(Duration::from_millis(300));
        client.pointer(4, 1, [0, 0]);
        std::thread::sleep(Duration::from_millis(120));
        client.pointer(5, 1, [0, 0]);
        let there = |p: &Picture| points(p) && near(p, from + step).distance(from + step) < 1.6;
        client.until(window, "the point is elsewhere", there);
        client.close(window);
        let begun = Instant::now();
        while Scene::load(&scene).unwrap().geometry.is_empty() {
            assert!(begun.elapsed() < Duration::from_secs(60), "nothing was moved");
            client.key(window, ENTER);
            std::thread::sleep(Duration::from_millis(300));
        }
        let out = within(child, 120);
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    }
}

#[test]
fn without_a_display_there_is_a_clear_message_and_drawing_still_works() {
    let folder = Folder::new("none");
    for display in [None, Some(":9999")] {
        let out = within(program(display, &folder, &[]).spawn().unwrap(), 60);
        let error = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(1), "{error}");
        assert!(error.starts_with("error: ") && error.lines().count() == 1, "{error}");
    }
    let picture = folder.join("a.png");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/quad.json");
    let out = Command::new(env!("CARGO_BIN_EXE_gradtess"))
        .args(["render", scene.to_str().unwrap(), "--size", "64x64", "-o", picture.to_str().unwrap()])
        .env_remove("DISPLAY")
        .output()
        .unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
}

/// Codes of keys on X.
const ESCAPE: u8 = 9;
const ENTER: u8 = 36;

/// Green of points.
const POINT: [u8; 3] = [40, 150, 60];

/// Middles of the patches of a colour that have this many pixels or more.
fn blobs(picture: &Picture, colour: [u8; 3], least: usize) -> Vec<DVec2> {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let is = |i: usize| (0..3).all(|c| picture.rgba[4 * i + c].abs_diff(colour[c]) < 12);
    let mut seen = vec![false; width * height];
    let mut out = Vec::new();
    for start in 0..width * height {
        if seen[start] || !is(start) {
            continue;
        }
        let (mut stack, mut members) = (vec![start], Vec::new());
        seen[start] = true;
        while let Some(i) = stack.pop() {
            members.push(i);
            let (x, y) = (i % width, i / width);
            let beside = [
                (x > 0).then(|| i - 1),
                (x + 1 < width).then(|| i + 1),
                (y > 0).then(|| i - width),
                (y + 1 < height).then(|| i + width),
            ];
            for k in beside.into_iter().flatten().filter(|&k| is(k)) {
                if !std::mem::replace(&mut seen[k], true) {
                    stack.push(k);
                }
            }
        }
        if members.len() >= least {
            let sum: DVec2 = members.iter().map(|i| DVec2::new((i % width) as f64, (i / width) as f64)).sum();
            out.push(sum / members.len() as f64 + 0.5);
        }
    }
    out
}
