//! The command line as a contract: exit codes, one line of error, `--json`, and nothing left behind on failure. Runs the
//! program itself.

use std::path::{Path, PathBuf};
use std::process::Command;

/// A folder of its own that is gone at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("gradtess-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    fn at(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }

    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn scene(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).display().to_string()
}

struct Ran {
    status: i32,
    out: String,
    err: String,
}

fn run(args: &[&str]) -> Ran {
    let done = Command::new(env!("CARGO_BIN_EXE_gradtess")).args(args).output().unwrap();
    Ran {
        status: done.status.code().expect("not killed by a signal"),
        out: String::from_utf8(done.stdout).unwrap(),
        err: String::from_utf8(done.stderr).unwrap(),
    }
}

/// The program has to end with `status` and one line of error; the line is returned.
fn refused(status: i32, args: &[&str]) -> String {
    let ran = run(args);
    assert_eq!(ran.status, status, "{args:?}: {}", ran.err);
    let lines: Vec<&str> = ran.err.lines().filter(|l| !l.starts_with("warning: ")).collect();
    assert!(lines.len() == 1 && lines[0].starts_with("error: ") && lines[0].len() > 12, "{args:?}: {}", ran.err);
    assert!(!ran.err.contains("panicked") && !ran.err.contains('\u{1b}'), "{args:?}: {}", ran.err);
    lines[0].to_owned()
}

fn done(args: &[&str]) -> Ran {
    let ran = run(args);
    assert_eq!(ran.status, 0, "{args:?}: {}", ran.err);
    ran
}

#[test]
fn json_names_its_schema_in_the_first_field() {
    let folder = Folder::new("json");
    let (picture, hexagon) = (folder.at("a.png"), scene("hexagon.json"));
    for (name, args) in [
        ("stats", vec!["stats", &hexagon]),
        ("mesh", vec!["mesh", &hexagon, "--level", "1"]),
        ("patches", vec!["patches", &hexagon]),
        ("sample", vec!["sample", &hexagon, "--n", "2"]),
        ("check", vec!["check", &hexagon, "--zooms", "1", "--size", "32x32"]),
        ("devices", vec!["devices"]),
        ("render", vec!["render", &hexagon, "-o", &picture, "--size", "32x32"]),
    ] {
        let ran = done(&[&args[..], &["--json"]].concat());
        let start = format!("{{\"schema\":\"gradtess.{name}/");
        assert!(ran.out.starts_with(&start), "{name}: {}", &ran.out[..ran.out.len().min(80)]);
        assert_eq!(ran.out.lines().count(), 1, "{name}");
        serde_json::from_str::<serde_json::Value>(&ran.out).unwrap();
    }
    assert_eq!(folder.names(), ["a.png"]);
}

#[test]
fn wrong_usage_is_2_and_says_what_is_wrong() {
    let hexagon = scene("hexagon.json");
    let folder = Folder::new("usage");
    let out = folder.at("a.png");
    for (args, word) in [
        (vec![], ""),
        (vec!["paint"], "paint"),
        (vec!["stats"], "SCENE"),
        (vec!["stats", &hexagon, "--mode", "sometimes"], "sometimes"),
        (vec!["stats", &hexagon, "--no-such-flag"], "--no-such-flag"),
        (vec!["stats", &hexagon, "--mode", "global", "--level", "99"], "level"),
        (vec!["stats", &hexagon, "--level", "2"], "--mode global"),
        (vec!["render", &hexagon], "-o"),
        (vec!["render", &hexagon, "-o", &out, "--size", "0x10"], "0x10"),
        (vec!["render", &hexagon, "-o", &out, "--size", "99999999999x1"], "size"),
        (vec!["render", &hexagon, "-o", &out, "--tess", "65"], "64"),
        (vec!["render", &hexagon, "-o", &out, "--tess", "0"], "0"),
        (vec!["render", &hexagon, "-o", &out, "--tess", "nan"], "number"),
        (vec!["render", &hexagon, "-o", &out, "--tess", "4", "--pixels", "3"], "--tess"),
        (vec!["render", &hexagon, "-o", &out, "--view", "1,1,0,0"], "view"),
        (vec!["render", &hexagon, "-o", &out, "--samples", "3"], "samples"),
        (vec!["render", &hexagon, "-o", &out, "--background", "pink"], "background"),
        (vec!["render", &hexagon, "-o", &out, "--device", "no such device"], "no such device"),
        (vec!["render", &hexagon, "-o", &out, "--device", "99"], "99"),
        (vec!["check", &hexagon, "--random-tess", "--tess", "4"], "--random-tess"),
        (vec!["sample", &hexagon, "--n", "0"], "--n"),
        (vec!["sample", &hexagon, "--exact", "--rules", "authors"], "--rules gradtess"),
    ] {
        let line = refused(2, &args);
        assert!(line.contains(word), "{args:?}: {line}");
    }
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}

#[test]
fn inputs_that_cannot_be_read_are_2_and_named() {
    let folder = Folder::new("input");
    let missing = folder.at("missing.json");
    let directory = folder.at("directory.json");
    std::fs::create_dir(&directory).unwrap();
    let mut files = vec![missing, directory];
    for (name, bytes) in [
        ("empty.obj", &b""[..]),
        ("binary.obj", &b"v 0 0\0\x01\x02"[..]),
        ("json.json", &b"{ \"gradtess\": 1, \"vertices\": [[0, 0], [1, 0]"[..]),
        ("future.json", &b"{ \"gradtess\": 2 }"[..]),
        ("bow.obj", &b"v 0 0\nv 1 0\nv 0 1\nv 1 1\nv 2 2\nf 1 2 3\nf 1 4 5\n"[..]),
        ("edit.obj", &b"v 0 0\nv 1 0\nv 1 1\nv 0 1\nf 1 2 3 4\nve 9 1 12345678901 0.1 0.1 0\n"[..]),
    ] {
        let path = folder.at(name);
        std::fs::write(&path, bytes).unwrap();
        files.push(path);
    }
    let before = folder.names();
    let picture = folder.at("a.png");
    for file in &files {
        for args in [
            vec!["stats", file],
            vec!["render", file, "-o", &picture],
            vec!["check", file],
            vec!["mesh", file, "--level", "1"],
            vec!["patches", file],
            vec!["sample", file],
        ] {
            let line = refused(2, &args);
            assert!(line.contains(file), "{args:?}: {line}");
        }
        let line = refused(2, &["convert", file, &folder.at("b.json")]);
        assert!(line.contains(file), "{line}");
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn outputs_that_cannot_be_written_are_1_and_leave_nothing() {
    let folder = Folder::new("output");
    let hexagon = scene("hexagon.json");
    // A folder where the file should go, a folder that is not there, and a file where a folder should be.
    let taken = folder.at("taken.png");
    std::fs::create_dir(&taken).unwrap();
    std::fs::write(folder.at("file"), "x").unwrap();
    let before = folder.names();
    for out in [taken.clone(), folder.at("none/a.png"), folder.at("file/a.png")] {
        let line = refused(1, &["render", &hexagon, "-o", &out, "--size", "16x16"]);
        assert!(line.contains(&out), "{line}");
    }
    for out in [folder.at("none/a.json"), folder.at("file/a.obj")] {
        let line = refused(1, &["convert", &hexagon, &out]);
        assert!(line.contains(&out), "{line}");
    }
    let line = refused(1, &["mesh", &hexagon, "--level", "1", "-o", &folder.at("none/a.obj")]);
    assert!(line.contains("none"), "{line}");
    assert_eq!(folder.names(), before);
    assert!(std::fs::read_dir(&taken).unwrap().next().is_none());
}

#[test]
fn a_failure_leaves_the_old_output_as_it_was() {
    let folder = Folder::new("old");
    let (picture, json) = (folder.at("a.png"), folder.at("a.json"));
    std::fs::write(&picture, "old picture").unwrap();
    std::fs::write(&json, "old scene").unwrap();
    refused(2, &["render", &folder.at("none.json"), "-o", &picture]);
    refused(2, &["render", &scene("hexagon.json"), "-o", &picture, "--tess", "1000"]);
    refused(2, &["render", &scene("hexagon.json"), "-o", &picture, "--size", "65536x65536"]);
    refused(2, &["convert", &folder.at("none.obj"), &json]);
    assert_eq!(folder.names(), ["a.json", "a.png"]);
    assert_eq!(std::fs::read(&picture).unwrap(), b"old picture");
    assert_eq!(std::fs::read(&json).unwrap(), b"old scene");
    done(&["render", &scene("hexagon.json"), "-o", &picture, "--size", "16x16", "--quiet"]);
    done(&["convert", &scene("hexagon.json"), &json, "--quiet"]);
    assert_eq!(folder.names(), ["a.json", "a.png"]);
    assert!(std::fs::read(&picture).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn flattened_pages_have_no_transparency_and_what_cannot_be_flattened_is_2() {
    let folder = Folder::new("flatten");
    let square = |id: &str, x: u32| {
        format!(
            "<meshgradient id='{id}' x='{x}' y='0' gradientUnits='userSpaceOnUse'><meshrow><meshpatch>\
             <stop path='l 9,0' stop-color='red' stop-opacity='0.5'/><stop path='l 0,9' stop-color='lime'/>\
             <stop path='l -9,0' stop-color='blue'/><stop path='l 0,-9' stop-color='white'/></meshpatch></meshrow>\
             </meshgradient><rect x='{x}' width='9' height='9' fill='url(#{id})'/>"
        )
    };
    let drawing = |name: &str, body: String| {
        std::fs::write(folder.at(name), format!("<svg xmlns='http://www.w3.org/2000/svg'>{body}</svg>")).unwrap();
        folder.at(name)
    };
    let (one, page) = (drawing("one.svg", square("a", 0)), folder.at("page.pdf"));
    let masks = || std::fs::read(&page).unwrap().windows(6).filter(|part| part == b"/SMask").count();
    done(&["convert", &one, &page, "--quiet"]);
    assert_eq!(masks(), 1);
    done(&["convert", &one, &page, "--quiet", "--flatten"]);
    assert_eq!(masks(), 0);
    let before = std::fs::read(&page).unwrap();
    let two = drawing("two.svg", square("a", 0) + &square("b", 5));
    let line = refused(2, &["convert", &two, &page, "--flatten"]);
    assert!(line.contains("patch 1 is translucent and lies over part of patch 0"), "{line}");
    let line = refused(2, &["convert", &one, &folder.at("page.json"), "--flatten"]);
    assert!(line.contains("--flatten is for PDF"), "{line}");
    assert_eq!(std::fs::read(&page).unwrap(), before);
}

#[test]
fn checks_pass_with_0_and_fall_short_with_3() {
    let sharp = scene("unit/sharp_dart.json");
    let ran = done(&["check", &sharp, "--zooms", "6", "--size", "64x64", "--random-tess", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(report["crack_pixels"], 0);
    assert_eq!(report["boundary_edges"], report["outline_edges"]);
    let levels: Vec<u64> = report["random_levels"].as_array().unwrap().iter().map(|l| l.as_u64().unwrap()).collect();
    assert!(levels[0] >= 1 && levels[1] <= 64 && levels[0] < levels[1], "{levels:?}");
    let again = done(&["check", &sharp, "--zooms", "6", "--size", "64x64", "--random-tess", "--json"]);
    assert_eq!(again.out, ran.out);

    // Edits of level 3 next to a bent edge of level 0: the authors' rules grade nothing, so faces two levels apart meet.
    let folder = Folder::new("cracks");
    let steep = folder.at("steep.json");
    let text = r#"{ "gradtess": 1, "builtin": "quad",
        "geometry": [{ "level": 0, "half_edge": 7, "a": 0.9, "b": 0.5 },
                     { "level": 0, "half_edge": 16, "a": -0.4, "b": 0.9 },
                     { "level": 0, "half_edge": 25, "a": -0.4, "b": 0.9 },
                     { "level": 3, "half_edge": 1500, "a": 0.1, "b": 0.1 },
                     { "level": 3, "half_edge": 1577, "a": 0.1, "b": 0.1 }] }"#;
    std::fs::write(&steep, text).unwrap();
    let common = ["check", &steep, "--zooms", "60", "--size", "128x128", "--tess", "1"];
    done(&common);
    let line = refused(3, &[&common[..], &["--rules", "authors"]].concat());
    assert!(line.contains("background pixels inside"), "{line}");
    done(&[&common[..], &["--rules", "authors", "--max-cracks", "1000000"]].concat());
}

#[test]
fn error_falls_as_patches_are_spent_along_the_isolation_curve() {
    let hexagon = scene("hexagon.json");
    let common = ["check", &hexagon, "--zooms", "0", "--size", "64x64", "--isolate-curve", "1"];
    let ran = done(&[&common[..], &["--json"]].concat());
    let report: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    let curve = report["isolate_curve"].as_array().unwrap();
    assert_eq!(curve.len(), 2);
    let of = |point: usize, field: &str| curve[point][field].as_f64().unwrap();
    assert!(of(1, "patches") > of(0, "patches") && of(1, "faces") > of(0, "faces"));
    assert!(of(1, "max_percent") < of(0, "max_percent") && of(1, "shift_pixels") < of(0, "shift_pixels"));
    assert_eq!(of(0, "max_percent"), report["error"]["max_percent"].as_f64().unwrap());
    assert!(refused(2, &[&common[..], &["--rules", "authors"]].concat()).contains("--rules gradtess"));
}

#[test]
fn errors_and_folds_beyond_their_thresholds_are_3_and_named() {
    let folder = Folder::new("error");
    let (map, hexagon) = (folder.at("map.png"), scene("hexagon.json"));
    let common = ["check", &hexagon, "--zooms", "0", "--size", "128x128", "--pixels", "1"];
    let line = refused(3, &[&common[..], &["--max-error", "0.05", "-o", &map]].concat());
    assert!(line.contains("% of sqrt 3") && line.contains("gregory patch") && line.contains("at pixel"), "{line}");
    assert_eq!(folder.names(), ["map.png"]);
    let line = refused(3, &[&common[..], &["--max-shift", "0.01"]].concat());
    assert!(line.contains("pixels off the limit"), "{line}");
    refused(3, &[&common[..], &["--max-mean", "1e-6"]].concat());
    done(&[&common[..], &["--max-error", "2", "--max-mean", "0.2", "--max-shift", "10", "--max-folds", "0"]].concat());
    let concave = scene("unit/concave_face.json");
    let line = refused(3, &["check", &concave, "--zooms", "0", "--size", "64x64", "--max-folds", "0", "--quiet"]);
    assert!(line.contains("turned over"), "{line}");
}

#[test]
fn quiet_is_quiet_and_help_is_0() {
    let folder = Folder::new("quiet");
    let out = folder.at("a.png");
    let ran = done(&["render", &scene("unit/concave_face.json"), "-o", &out, "--size", "16x16", "--quiet"]);
    assert!(ran.out.is_empty() && ran.err.is_empty(), "{}{}", ran.out, ran.err);
    for args in [&["--help"][..], &["--version"], &["render", "--help"]] {
        let ran = done(args);
        assert!(ran.err.is_empty() && !ran.out.is_empty());
    }
}

#[test]
fn the_number_of_threads_changes_nothing_and_is_checked() {
    let cherry = scene("cherry.json");
    let patches = |n: &str| {
        let ran = run(&["patches", &cherry, "--json", "--threads", n]);
        assert_eq!(ran.status, 0, "{}", ran.err);
        ran.out
    };
    let one = patches("1");
    assert!(one.len() > 1000 && one == patches("3"));
    for n in ["0", "251", "many"] {
        refused(2, &["stats", &cherry, "--threads", n]);
    }
}

/// Hostile drawings through the program: with an address space of 1 GiB, one line of error or a mesh.
#[test]
fn malformed_drawings_take_one_line_and_little_memory() {
    let folder = Folder::new("malformed");
    let stop = |path: &str| format!("<stop path='{path}' stop-color='red'/>");
    let patch =
        |paths: &[&str]| format!("<meshpatch>{}</meshpatch>", paths.iter().map(|p| stop(p)).collect::<String>());
    let square = patch(&["l 1,0", "l 0,1", "l -1,0", "l 0,-1"]);
    let mesh = |rows: &str| format!("<svg><meshgradient gradientUnits='userSpaceOnUse'>{rows}</meshgradient></svg>");
    let row = |patches: &str| format!("<meshrow>{patches}</meshrow>");
    let sound = mesh(&row(&square));
    let entities: String =
        (0..30).map(|k| format!("<!ENTITY e{} \"{}\">", k + 1, format!("&e{k};").repeat(10))).collect();
    let bomb = format!("<!DOCTYPE svg [<!ENTITY e0 'lol'>{entities}]>");
    let megabytes = |piece: &str, n: usize| piece.repeat(n * 1_000_000 / piece.len());
    let cases = [
        ("ragged", mesh(&format!("{}<meshrow/>", row(&square))), "patches"),
        ("missing stops", mesh(&row(&patch(&["l 1,0", "l 0,1"]))), "stops"),
        ("unit", sound.replace("<meshgradient", "<meshgradient x='3parsec'"), "length"),
        ("nan", sound.replace("l 0,1", "l NaN,1"), "malformed"),
        ("cut off", sound[..sound.len() / 2].to_owned(), ""),
        ("nested 100 MB", format!("<svg>{}", megabytes("<g>", 100)), "larger"),
        ("nested 66 MB", format!("<svg>{}", megabytes("<g>", 66)), "deep"),
        ("beside one another", format!("<svg>{}{}", megabytes("<g/>", 66), &sound[5..]), "elements"),
        (
            "a long style",
            sound.replace("<meshgradient", &format!("<style>{}</style><meshgradient", megabytes("g{fill:red}", 60))),
            "too many rules",
        ),
        ("bomb in an attribute", format!("{bomb}{}", sound.replace("red", "&e30;")), "entit"),
    ];
    let styled = |sheet: &str| sound.replace("<meshg", &format!("<style>{sheet}</style><meshg"));
    let beside = |text: String| text.replace("<meshg", &format!("{}<meshg", "<stop/>".repeat(20_000)));
    let limited = |text: String| {
        let file = folder.at("drawing.svg");
        std::fs::write(&file, text).unwrap();
        let command = format!("ulimit -v 1048576; exec '{}' stats \"$0\"", env!("CARGO_BIN_EXE_gradtess"));
        Command::new("sh").args(["-c", &command, &file]).output().unwrap()
    };
    for (name, text, word) in cases {
        let done = limited(text);
        let said = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(2), "{name}: {said}");
        assert!(said.starts_with("error: ") && said.lines().count() == 1 && said.len() < 1000, "{name}: {said}");
        assert!(said.contains(word) && said.contains("; "), "{name}: {said}");
    }
    for (name, text) in [
        ("collapsed", mesh(&row(&patch(&["l 0,0", "l 0,1", "l 0,0", "l 0,-1"])))),
        ("bomb in the text", format!("{bomb}{}", sound.replace("<meshgradient", "&e30;<meshgradient"))),
        ("many attributes", sound.replace("<svg", &format!("<svg {}", megabytes("a='b' ", 66)))),
        ("a long text", sound.replace("<meshgradient", &format!("{}<meshgradient", megabytes("text ", 66)))),
        ("a long block", styled(&format!("g{{{}}}", megabytes("fill:red;", 60)))),
        ("every rule for every element", beside(styled(&"*{fill:red}".repeat(2000)))),
        ("a long value for every element", beside(styled(&format!("*{{fill:{}}}", "r".repeat(900))))),
        (
            "a colour that all inherit",
            beside(styled("")).replace("<svg", &format!("<svg color='{}'", megabytes("red", 1))),
        ),
    ] {
        let done = limited(text);
        assert_eq!(done.status.code(), Some(0), "{name}: {}", String::from_utf8_lossy(&done.stderr));
    }
}
