//! Shared by the tests of the editor's window: a display of their own, the program on it, scripts, goldens.
#![allow(dead_code)] // each test file uses its own part

use glam::{DVec2, DVec4};
use gradtess::edit::handle::{Kind, Stage};
use gradtess::edit::model::{Drawing, Model};
use gradtess::edit::overlay::{overlay, Handle, Look};
use gradtess::image::{compare, Picture};
use gradtess::scene::{shapes, InputMesh, Scene};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use x11rb::connection::{Connection, RequestConnection};
use x11rb::protocol::xproto::{
    AtomEnum, ClientMessageEvent, ConnectionExt, EventMask, ImageFormat, InputFocus, KeyButMask, KeyPressEvent,
    MapState, KEY_PRESS_EVENT, KEY_RELEASE_EVENT,
};
use x11rb::rust_connection::RustConnection;

/// An X server without a screen; it goes with this value.
pub struct Display {
    server: Child,
    pub name: String,
}

impl Display {
    pub fn new() -> Display {
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
pub struct Client {
    connection: RustConnection,
    root: u32,
}

impl Client {
    pub fn new(display: &Display) -> Client {
        let (connection, screen) = RustConnection::connect(Some(&display.name)).unwrap();
        let root = connection.setup().roots[screen].root;
        Client { connection, root }
    }

    /// Waits for a window of the editor that is on the screen; its title, too.
    pub fn window(&self) -> (u32, String) {
        let begun = Instant::now();
        loop {
            if let Some(found) = self.look() {
                return found;
            }
            assert!(begun.elapsed() < Duration::from_secs(120), "no window");
            std::thread::sleep(Duration::from_millis(30));
        }
    }

    pub fn look(&self) -> Option<(u32, String)> {
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
    pub fn close(&self, window: u32) {
        let atom = |name: &str| self.connection.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom;
        let data = [atom("WM_DELETE_WINDOW"), 0, 0, 0, 0];
        let event = ClientMessageEvent::new(32, window, atom("WM_PROTOCOLS"), data);
        self.connection.send_event(false, window, EventMask::NO_EVENT, event).unwrap();
        self.connection.flush().unwrap();
    }

    /// A key of the keyboard, by the code that X has for it.
    pub fn key(&self, window: u32, code: u8) {
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

    /// Waits for the window of a scene that has changes.
    pub fn changed(&self) -> u32 {
        let begun = Instant::now();
        loop {
            let (window, title) = self.window();
            if title.starts_with('*') {
                return window;
            }
            assert!(begun.elapsed() < Duration::from_secs(120), "no change");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Waits until the window looks as it should.
    pub fn until(&self, window: u32, otherwise: &str, right: impl Fn(&Picture) -> bool) {
        self.repeat(window, otherwise, right, || {});
    }

    /// As [`Client::until`], pressing a key all the while.
    pub fn until_key(&self, window: u32, code: u8, otherwise: &str, right: impl Fn(&Picture) -> bool) {
        self.repeat(window, otherwise, right, || self.key(window, code));
    }

    fn repeat(&self, window: u32, otherwise: &str, right: impl Fn(&Picture) -> bool, act: impl Fn()) {
        let begun = Instant::now();
        while !right(&self.picture(window)) {
            if begun.elapsed() > Duration::from_secs(60) {
                let file = std::env::temp_dir().join("gradtess-editor-failed.png");
                let _ = self.picture(window).write_png(&file, &[]);
                panic!("{otherwise}; look at {}", file.display());
            }
            act();
            std::thread::sleep(Duration::from_millis(200));
        }
    }

    /// Input as from a mouse (`XTestFakeInput`): 6 moves to a place of the screen, 4 and 5 press and release a button.
    pub fn pointer(&self, kind: u8, button: u8, [x, y]: [i16; 2]) {
        let extension = self.connection.extension_information("XTEST").unwrap().expect("the server has XTEST");
        let mut request = [0u8; 36];
        (request[0], request[1], request[4], request[5]) = (extension.major_opcode, 2, kind, button);
        request[2..4].copy_from_slice(&9u16.to_ne_bytes());
        request[12..16].copy_from_slice(&self.root.to_ne_bytes());
        request[24..26].copy_from_slice(&x.to_ne_bytes());
        request[26..28].copy_from_slice(&y.to_ne_bytes());
        let sent = self.connection.send_request_without_reply(&[std::io::IoSlice::new(&request)], Vec::new());
        sent.unwrap();
        self.connection.flush().unwrap();
    }

    /// Where the window's top left is on the screen.
    pub fn place(&self, window: u32) -> [i16; 2] {
        let at = self.connection.translate_coordinates(window, self.root, 0, 0).unwrap().reply().unwrap();
        [at.dst_x, at.dst_y]
    }

    /// The window's pixels as the display has them.
    pub fn picture(&self, window: u32) -> Picture {
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
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("gradtess-editor-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    pub fn join(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

pub fn program(display: Option<&str>, folder: &Folder, arguments: &[&str]) -> Command {
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
pub fn session(display: &Display, folder: &Folder, scene: Option<&Path>, script: &str) -> serde_json::Value {
    session_with(display, folder, scene, script, &[])
}

pub fn session_with(
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
pub fn within(mut child: Child, seconds: u64) -> Output {
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
pub struct Script {
    pub text: String,
    pub at: f64,
}

impl Script {
    pub fn act(&mut self, action: &str) {
        self.at += 0.05;
        self.text += &format!("{{\"at\":{:.2},{action}}}\n", self.at);
    }

    pub fn key(&mut self, name: &str) {
        self.act(&format!("\"key\":{name:?}"));
    }

    pub fn aim(&mut self, p: DVec2) {
        self.act(&format!("\"aim\":[{},{}]", p.x, p.y));
    }

    /// Presses at a place, moves in steps, and lets go.
    pub fn drag(&mut self, from: DVec2, to: DVec2) {
        self.hold(from, to);
        self.act("\"up\":\"left\"");
    }

    pub fn hold(&mut self, from: DVec2, to: DVec2) {
        self.aim(from);
        self.act("\"down\":\"left\"");
        for k in 1..=4 {
            self.aim(from.lerp(to, f64::from(k) / 4.0));
        }
    }
}

pub fn handles(scene: &Scene, stage: Stage) -> Vec<Handle> {
    handles_in(scene, stage, [-1e4, -1e4, 1e4, 1e4])
}

pub fn handles_in(scene: &Scene, stage: Stage, view: [f64; 4]) -> Vec<Handle> {
    let model = Model::new(scene.clone(), Drawing::default()).unwrap();
    let look = Look { stage, view, pixel: 1e-9, control: false };
    overlay(scene, &model.mesh, &model.refinement, &look).unwrap().handles
}

/// The points of one kind nearest to a place that no colour lies on.
pub fn nearest(handles: &[Handle], kind: Kind, to: DVec2) -> Handle {
    let coloured = |h: &Handle| handles.iter().any(|c| c.id.kind == Kind::Colour && c.at == h.at);
    let all = handles.iter().filter(|h| h.id.kind == kind && !(kind.is_geometry() && coloured(h)));
    *all.min_by(|a, b| a.at.distance(to).total_cmp(&b.at.distance(to))).unwrap()
}

/// Several polygons side by side, so that what happens to one leaves the others alone.
pub fn row(names: &[&str]) -> Scene {
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

pub fn middle(i: usize) -> DVec2 {
    DVec2::new(2.6 * (i % 4) as f64, -2.6 * (i / 4) as f64)
}

/// Every sample of `gradtess sample --exact`.
pub fn exact_samples(scene: &Path, n: u32) -> Vec<DVec2> {
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

/// Compares with a golden document, numbers to a millionth; `GRADTESS_MAKE_GOLDEN` writes it.
pub fn golden_json(name: &str, value: &serde_json::Value) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    if std::env::var_os("GRADTESS_MAKE_GOLDEN").is_some() {
        std::fs::write(&file, value.to_string() + "\n").unwrap();
    }
    let golden: serde_json::Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    close(&golden, value, name);
}

pub fn close(a: &serde_json::Value, b: &serde_json::Value, place: &str) {
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
pub fn golden_picture(name: &str, picture: &Path) {
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
