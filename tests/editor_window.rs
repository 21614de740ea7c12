//! The editor in a real window on a virtual display, by scripts: what is saved, shown, restored and refused.
//!
//! Each session is the program itself under the validation layer, whose messages end it with status 1.

use glam::{DVec2, DVec4};
use gradtess::edit::change::Change;
use gradtess::edit::drag::size_of;
use gradtess::edit::handle::{Id, Kind, Stage};
use gradtess::edit::journal;
use gradtess::edit::model::{Drawing, Model};
use gradtess::edit::overlay::{overlay, Handle, Look};
use gradtess::image::{compare, Picture};
use gradtess::patch::build::face_control;
use gradtess::patch::eval;
use gradtess::scene::{shapes, InputMesh, Scene};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    AtomEnum, ClientMessageEvent, ConnectionExt, EventMask, ImageFormat, InputFocus, KeyButMask, KeyPressEvent,
    MapState, KEY_PRESS_EVENT, KEY_RELEASE_EVENT,
};
use x11rb::rust_connection::RustConnection;

/// An X server without a screen; it goes with this value.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    fn new() -> Display {
        // Without -noreset the server starts anew when its last client goes, and whoever connects just then is refused.
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1400x900x24", "-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb (tools/setup installs it)");
        let mut line = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut line).unwrap();
        Display { server, name: format!(":{}", line.trim()) }
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// A client of the display beside the editor: what a window manager and an eye do.
struct Client {
    connection: RustConnection,
    root: u32,
}

impl Client {
    fn new(display: &Display) -> Client {
        let (connection, screen) = RustConnection::connect(Some(&display.name)).unwrap();
        let root = connection.setup().roots[screen].root;
        Client { connection, root }
    }

    /// Waits for a window of the editor that is on the screen; its title, too.
    fn window(&self) -> (u32, String) {
        let begun = Instant::now();
        loop {
            if let Some(found) = self.look() {
                return found;
            }
            assert!(begun.elapsed() < Duration::from_secs(120), "no window");
            std::thread::sleep(Duration::from_millis(30));
        }
    }

    /// Waits until there is none. One that comes after it may have its very number.
    fn no_window(&self) {
        let begun = Instant::now();
        while self.look().is_some() {
            assert!(begun.elapsed() < Duration::from_secs(60), "the window stays");
            std::thread::sleep(Duration::from_millis(4));
        }
    }

    fn look(&self) -> Option<(u32, String)> {
        let children = self.connection.query_tree(self.root).unwrap().reply().unwrap().children;
        children.into_iter().find_map(|w| {
            let state = self.connection.get_window_attributes(w).unwrap().reply();
            let name = self.connection.get_property(false, w, AtomEnum::WM_NAME, AtomEnum::ANY, 0, 256).unwrap();
            let name = name.reply().map(|r| String::from_utf8_lossy(&r.value).into_owned()).unwrap_or_default();
            let shown = state.is_ok_and(|s| s.map_state == MapState::VIEWABLE);
            (shown && name.ends_with("gradtess")).then_some((w, name))
        })
    }

    /// The window's close button.
    fn close(&self, window: u32) {
        let atom = |name: &str| self.connection.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom;
        let data = [atom("WM_DELETE_WINDOW"), 0, 0, 0, 0];
        let event = ClientMessageEvent::new(32, window, atom("WM_PROTOCOLS"), data);
        self.connection.send_event(false, window, EventMask::NO_EVENT, event).unwrap();
        self.connection.flush().unwrap();
    }

    /// A key of the keyboard, by the code that X has for it.
    fn key(&self, window: u32, code: u8) {
        self.connection.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME).unwrap();
        for response_type in [KEY_PRESS_EVENT, KEY_RELEASE_EVENT] {
            let event = KeyPressEvent {
                response_type,
                detail: code,
                sequence: 0,
                time: x11rb::CURRENT_TIME,
                root: self.root,
                event: window,
                child: x11rb::NONE,
                root_x: 1,
                root_y: 1,
                event_x: 1,
                event_y: 1,
                state: KeyButMask::default(),
                same_screen: true,
            };
            self.connection.send_event(false, window, EventMask::NO_EVENT, event).unwrap();
        }
        self.connection.flush().unwrap();
    }

    /// The window's pixels as the display has them.
    fn picture(&self, window: u32) -> Picture {
        let size = self.connection.get_geometry(window).unwrap().reply().unwrap();
        let (width, height) = (size.width, size.height);
        let image = self.connection.get_image(ImageFormat::Z_PIXMAP, window, 0, 0, width, height, !0).unwrap();
        let mut rgba = image.reply().unwrap().data;
        for p in rgba.chunks_exact_mut(4) {
            p.swap(0, 2);
            p[3] = 255;
        }
        Picture { width: width.into(), height: height.into(), rgba }
    }
}

/// A folder of its own.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("gradtess-editor-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    fn join(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn program(display: Option<&str>, folder: &Folder, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gradtess"));
    command.arg("edit").args(arguments).env("XDG_STATE_HOME", folder.join("state")).env("WINIT_X11_SCALE_FACTOR", "1");
    match display {
        Some(name) => command.env("DISPLAY", name),
        None => command.env_remove("DISPLAY"),
    };
    command.env_remove("WAYLAND_DISPLAY").stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Runs a script to its end and returns what the session reports.
fn session(display: &Display, folder: &Folder, scene: Option<&Path>, script: &str) -> serde_json::Value {
    session_with(display, folder, scene, script, &[])
}

fn session_with(
    display: &Display,
    folder: &Folder,
    scene: Option<&Path>,
    script: &str,
    more: &[&str],
) -> serde_json::Value {
    let file = folder.join("script.jsonl");
    std::fs::write(&file, script).unwrap();
    let mut arguments: Vec<String> = Vec::new();
    arguments.extend(scene.map(|s| s.display().to_string()));
    for a in ["--json", "--validate", "--size", "900x640", "--script"] {
        arguments.push(a.to_owned());
    }
    arguments.push(file.display().to_string());
    arguments.push("--screenshots".to_owned());
    arguments.push(folder.0.display().to_string());
    arguments.extend(more.iter().map(|&a| a.to_owned()));
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let out = within(program(Some(&display.name), folder, &arguments).spawn().unwrap(), 240);
    let error = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success(), "{}: {error}", out.status);
    serde_json::from_slice(&out.stdout).unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&out.stdout)))
}

/// The output of a child that ends within some seconds.
fn within(mut child: Child, seconds: u64) -> Output {
    let begun = Instant::now();
    loop {
        match child.try_wait().unwrap() {
            Some(_) => return child.wait_with_output().unwrap(),
            None if begun.elapsed() > Duration::from_secs(seconds) => {
                let _ = child.kill();
                let out = child.wait_with_output().unwrap();
                panic!("the session hangs: {}", String::from_utf8_lossy(&out.stderr));
            }
            None => std::thread::sleep(Duration::from_millis(20)),
        }
    }
}

/// Lines of a script, one after another in time.
#[derive(Default)]
struct Script {
    text: String,
    at: f64,
}

impl Script {
    fn act(&mut self, action: &str) {
        self.at += 0.05;
        self.text += &format!("{{\"at\":{:.2},{action}}}\n", self.at);
    }

    fn key(&mut self, name: &str) {
        self.act(&format!("\"key\":{name:?}"));
    }

    fn aim(&mut self, p: DVec2) {
        self.act(&format!("\"aim\":[{},{}]", p.x, p.y));
    }

    /// Presses at a place, moves in steps, and lets go.
    fn drag(&mut self, from: DVec2, to: DVec2) {
        self.hold(from, to);
        self.act("\"up\":\"left\"");
    }

    fn hold(&mut self, from: DVec2, to: DVec2) {
        self.aim(from);
        self.act("\"down\":\"left\"");
        for k in 1..=4 {
            self.aim(from.lerp(to, f64::from(k) / 4.0));
        }
    }
}

fn handles(scene: &Scene, stage: Stage) -> Vec<Handle> {
    handles_in(scene, stage, [-1e4, -1e4, 1e4, 1e4])
}

fn handles_in(scene: &Scene, stage: Stage, view: [f64; 4]) -> Vec<Handle> {
    let model = Model::new(scene.clone(), Drawing::default()).unwrap();
    let look = Look { stage, view, pixel: 1e-9, control: false };
    overlay(scene, &model.mesh, &model.refinement, &look).unwrap().handles
}

/// The points of one kind nearest to a place that no colour lies on.
fn nearest(handles: &[Handle], kind: Kind, to: DVec2) -> Handle {
    let coloured = |h: &Handle| handles.iter().any(|c| c.id.kind == Kind::Colour && c.at == h.at);
    let all = handles.iter().filter(|h| h.id.kind == kind && !(kind.is_geometry() && coloured(h)));
    *all.min_by(|a, b| a.at.distance(to).total_cmp(&b.at.distance(to))).unwrap()
}

/// Several polygons side by side, so that what happens to one leaves the others alone.
fn row(names: &[&str]) -> Scene {
    let mut mesh = InputMesh { face_start: vec![0], ..InputMesh::default() };
    for (i, name) in names.iter().enumerate() {
        let piece = shapes::builtin(name).unwrap();
        let (first, corners) = (mesh.positions.len() as u32, mesh.corners.len() as u32);
        let place = DVec2::new(2.6 * (i % 4) as f64, -2.6 * (i / 4) as f64);
        mesh.positions.extend(piece.positions.iter().map(|p| *p + place));
        mesh.corners.extend(piece.corners.iter().map(|c| c + first));
        mesh.face_start.extend(piece.face_start[1..].iter().map(|f| f + corners));
    }
    let corner_colours = (0..mesh.corners.len())
        .map(|h| DVec4::new(0.9, 0.3 + 0.5 * ((h % 3) as f64) / 2.0, 0.3 + 0.4 * ((h % 5) as f64) / 4.0, 1.0))
        .collect();
    Scene { name: "row".into(), mesh, corner_colours, ..Scene::default() }
}

fn middle(i: usize) -> DVec2 {
    DVec2::new(2.6 * (i % 4) as f64, -2.6 * (i / 4) as f64)
}

/// Every sample of `gradtess sample --exact`.
fn exact_samples(scene: &Path, n: u32) -> Vec<DVec2> {
    let out = Command::new(env!("CARGO_BIN_EXE_gradtess"))
        .args(["sample", "--exact", "--json", "--n", &n.to_string()])
        .arg(scene)
        .output()
        .unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let report: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    let point =
        |s: &serde_json::Value| DVec2::new(s["position"][0].as_f64().unwrap(), s["position"][1].as_f64().unwrap());
    report["samples"].as_array().unwrap().iter().map(point).collect()
}

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

    // With a change the session is there again, and asks. Enter saves, and that was the end.
    let from = nearest(&handles(&original, Stage::Level(1)), Kind::Vertex, DVec2::new(0.2, 0.2)).at;
    let mut script = Script::default();
    script.key("1");
    script.drag(from, from + DVec2::new(0.05, 0.0));
    let file = folder.join("script.jsonl");
    std::fs::write(&file, &script.text).unwrap();
    let arguments = [path, "--size", "600x400", "--script", file.to_str().unwrap(), "--stay", "--validate"];
    let child = program(Some(&display.name), &folder, &arguments).spawn().unwrap();
    let begun = Instant::now();
    let (window, _) = loop {
        let found = client.window();
        if found.1.starts_with('*') {
            break found;
        }
        assert!(begun.elapsed() < Duration::from_secs(120), "no change");
        std::thread::sleep(Duration::from_millis(50));
    };
    // The gesture has ended once the step is in the journal.
    let journal = || journal::left_behind(Some(&scene), None).len();
    std::thread::sleep(Duration::from_millis(1000));
    client.close(window);
    client.no_window();
    let (again, title) = client.window();
    assert!(title.starts_with('*'), "{title}");
    assert_eq!(Scene::load(&scene).unwrap().geometry.len(), 0);
    // Its keyboard is not there with the window's first frame.
    let begun = Instant::now();
    while Scene::load(&scene).unwrap().geometry.is_empty() {
        assert!(begun.elapsed() < Duration::from_secs(60), "Enter does not save");
        client.key(again, 36);
        std::thread::sleep(Duration::from_millis(300));
    }
    ended(child);
    assert_eq!((Scene::load(&scene).unwrap().geometry.len(), journal()), (1, 0));
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

/// Compares with a golden document, numbers to a millionth; `GRADTESS_MAKE_GOLDEN` writes it.
fn golden_json(name: &str, value: &serde_json::Value) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    if std::env::var_os("GRADTESS_MAKE_GOLDEN").is_some() {
        std::fs::write(&file, value.to_string() + "\n").unwrap();
    }
    let golden: serde_json::Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    close(&golden, value, name);
}

fn close(a: &serde_json::Value, b: &serde_json::Value, place: &str) {
    use serde_json::Value;
    match (a, b) {
        (Value::Array(x), Value::Array(y)) => {
            assert_eq!(x.len(), y.len(), "{place}");
            x.iter().zip(y).enumerate().for_each(|(i, (a, b))| close(a, b, &format!("{place}[{i}]")));
        }
        (Value::Object(x), Value::Object(y)) => {
            assert_eq!(x.keys().collect::<Vec<_>>(), y.keys().collect::<Vec<_>>(), "{place}");
            x.iter().for_each(|(k, a)| close(a, &y[k], &format!("{place}.{k}")));
        }
        (Value::Number(x), Value::Number(y)) => {
            let (x, y) = (x.as_f64().unwrap(), y.as_f64().unwrap());
            assert!((x - y).abs() <= 1e-6 * x.abs().max(1.0), "{place}: {x} and {y}");
        }
        _ => assert_eq!(a, b, "{place}"),
    }
}

/// Compares with a golden picture: one pixel in five hundred may differ by more than 3 of 255.
fn golden_picture(name: &str, picture: &Path) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    let now = Picture::read_png(picture).unwrap();
    // Without the status line, which names a folder of this run.
    let now = now.crop(0, 0, now.width, now.height - 24);
    if std::env::var_os("GRADTESS_MAKE_GOLDEN").is_some() {
        now.write_png(&file, &[]).unwrap();
    }
    let golden = Picture::read_png(&file).unwrap();
    let beyond = compare(&golden, &now).expect("the same size").fraction_beyond(3);
    assert!(beyond < 0.002, "{beyond} of the pixels differ; look at {}", picture.display());
}
