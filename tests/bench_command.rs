//! `gradtess bench` from outside: what it writes, prints and refuses. Times themselves are not judged.

use json_schema::validate;
use serde_json::Value;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

mod json_schema;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const SCENE: &str = "scenes/unit/geometry_level_2.json";

fn bench(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gradtess"));
    command.current_dir(ROOT).arg("bench").args(arguments);
    if let Ok(device) = std::env::var("GRADTESS_DEVICE") {
        command.args(["--device", &device]);
    }
    command
}

fn run(arguments: &[&str]) -> Output {
    bench(arguments).output().unwrap()
}

/// Standard output of a run that has to succeed, as JSON.
fn json(arguments: &[&str]) -> Value {
    let out = run(&[arguments, &["--json"]].concat());
    assert!(out.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&out.stderr));
    serde_json::from_slice(&out.stdout).unwrap()
}

/// An empty folder for one test.
fn folder(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("gradtess-bench-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    path
}

fn read_json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))).unwrap()
}

/// Rows of `frames.csv` by column, after each cell was checked against the schema.
fn frames(folder: &Path) -> Vec<HashMap<String, String>> {
    let text = std::fs::read_to_string(folder.join("frames.csv")).unwrap();
    assert!(text.ends_with('\n'));
    let schema = read_json(&Path::new(ROOT).join("tests/schemas/frames.json"));
    let columns = schema["fields"].as_array().unwrap();
    let names: Vec<&str> = columns.iter().map(|c| c["name"].as_str().unwrap()).collect();
    let mut lines = text.lines();
    assert_eq!(lines.next().unwrap().split(',').collect::<Vec<_>>(), names);
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            assert_eq!(cells.len(), names.len(), "{line}");
            for (column, cell) in columns.iter().zip(&cells) {
                let fits = match column["type"].as_str().unwrap() {
                    "integer" => cell.parse::<u64>().is_ok(),
                    "number" => cell.parse::<f64>().is_ok_and(f64::is_finite),
                    _ => true,
                };
                let listed = column.get("enum").is_none_or(|all| all.as_array().unwrap().contains(&Value::from(*cell)));
                let missing = column.get("missing").is_some() && *cell == "NA";
                assert!((fits && listed) || missing, "{cell} in {column}");
            }
            names.iter().map(|&name| name.to_owned()).zip(cells.into_iter().map(str::to_owned)).collect()
        })
        .collect()
}

/// The run folder is complete and sound; returns `run.json` and the rows.
fn checked(folder: &Path) -> (Value, Vec<HashMap<String, String>>) {
    let run = read_json(&folder.join("run.json"));
    let schema = read_json(&Path::new(ROOT).join("tests/schemas/run.json"));
    let faults = validate(&run, &schema, &schema, "run.json");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert_eq!(run["run_id"], run["runs"][0]["run_id"]);
    let rows = frames(folder);
    let ids: Vec<&str> = run["runs"].as_array().unwrap().iter().map(|r| r["run_id"].as_str().unwrap()).collect();
    assert!(rows.iter().all(|row| ids.contains(&row["run_id"].as_str())));
    let trace = read_json(&folder.join("trace.json"));
    assert_eq!(trace["metadata"]["run_id"], run["run_id"]);
    let files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(files.len(), 3, "{files:?}");
    (run, rows)
}

fn number(row: &HashMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} is {}", row[column]))
}

#[test]
fn rendering_alone_fills_every_file() {
    let out = folder("none");
    let printed = json(&[SCENE, "-o", out.to_str().unwrap(), "--short", "--tess", "5"]);
    assert_eq!(printed["schema"], "gradtess.bench/1");
    let (run, rows) = checked(&out);
    let of = |phase: &str| rows.iter().filter(|row| row["phase"] == phase).collect::<Vec<_>>();
    // Two repeats of two, six and two frames.
    assert_eq!((of("warmup").len(), of("measure").len(), of("stats").len()), (4, 12, 4));
    assert_eq!(run["results"]["cpu_frame"]["pooled"]["n"], 12);
    assert_eq!(run["results"]["cpu_frame"]["repeats"].as_array().unwrap().len(), 2);
    assert_eq!((&run["protocol"]["repeats_done"], &run["settings"]["edits"]), (&2.into(), &"none".into()));
    for row in of("measure") {
        assert!(number(row, "cpu_frame_ms") >= number(row, "cpu_wait_ms") + number(row, "cpu_record_ms"));
        for column in ["cpu_edit_ms", "cpu_refine_ms", "cpu_patch_ms", "cpu_upload_ms", "tcs_patches", "in_present_ms"]
        {
            assert_eq!(row[column], "NA", "{column}");
        }
        assert_eq!((row["edits"].as_str(), row["upload_bytes"].as_str()), ("0", "0"));
    }
    for row in of("stats") {
        assert_eq!(row["cpu_frame_ms"], "NA");
        if run["device"]["type"] == "cpu" {
            // The formula for triangles, transition parts included, against the device's own count.
            assert_eq!(number(row, "clip_invocations"), run["settings"]["triangles"].as_f64().unwrap());
        }
    }
    let caveats: Vec<&str> = run["caveats"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    for expected in ["clocks not locked", "shorter than the protocol asks for"] {
        assert!(caveats.contains(&expected), "{caveats:?}");
    }
    assert_eq!(caveats.contains(&"debug build"), cfg!(debug_assertions));
    assert_eq!(caveats.iter().any(|c| c.starts_with("software")), run["device"]["type"] == "cpu");
    assert!(!std::fs::read_to_string(out.join("run.json")).unwrap().contains(ROOT));
    std::fs::remove_dir_all(&out).unwrap();
}

#[test]
fn edits_rebuild_every_frame_in_both_modes() {
    for (edits, scene) in [("geometry", SCENE), ("colour", "scenes/unit/colour_level_2.json")] {
        let out = folder(edits);
        let arguments = [
            scene,
            "-o",
            out.to_str().unwrap(),
            "--short",
            "--mode",
            "both",
            "--match-triangles",
            "--tess",
            "2",
            "--edits",
            edits,
            "--validate",
        ];
        let printed = json(&arguments);
        let (run, rows) = checked(&out);
        assert_eq!(run["runs"].as_array().unwrap().len(), 2);
        let settings = |i: usize, key: &str| run["runs"][i]["settings"][key].clone();
        assert_eq!((settings(0, "mode"), settings(1, "mode")), ("adaptive".into(), "global".into()));
        // Just above: one step less would be below.
        assert!(settings(0, "triangles").as_u64() > settings(1, "triangles").as_u64());
        assert_eq!((settings(0, "tess_rule"), settings(1, "tess_factor")), ("base".into(), 2.0.into()));
        for row in rows.iter().filter(|row| row["phase"] == "measure") {
            let stages = [
                "cpu_edit_ms",
                "cpu_refine_ms",
                "cpu_patch_ms",
                "cpu_upload_ms",
                "cpu_record_ms",
                "cpu_submit_ms",
                "cpu_wait_ms",
            ];
            let total: f64 = stages.iter().map(|stage| number(row, stage)).sum();
            assert!(total <= number(row, "cpu_frame_ms") + 1e-5);
            assert_eq!((row["edits"].as_str(), &row["upload_bytes"]), ("1", &row["gpu_bytes"]));
        }
        // A row of A, a row of B, in either order.
        let measured: Vec<_> = rows.iter().filter(|row| row["phase"] == "measure").collect();
        assert_eq!(measured.len(), 24);
        let pair = &printed["pairs"][0];
        for scope in ["median", "mean"] {
            let r = &pair["ratios"]["cpu_frame"][scope];
            let [low, high] = [0, 1].map(|i| r["ci95"][i].as_f64().unwrap());
            let one_inside = low <= 1.0 && 1.0 <= high;
            assert_eq!(r["verdict"] == "equal", one_inside, "{r}");
        }
        std::fs::remove_dir_all(&out).unwrap();
    }
}

#[test]
fn a_pair_with_itself_is_equal_and_twice_the_time_is_not() {
    let verdict = |flags: &str, seed: &str| {
        let out = folder("pair");
        let arguments = [
            "scenes/quad.json",
            "-o",
            out.to_str().unwrap(),
            "--short",
            "--frames",
            "40",
            "--seed",
            seed,
            "--pair",
            flags,
        ];
        let printed = json(&arguments);
        checked(&out);
        std::fs::remove_dir_all(&out).unwrap();
        printed["pairs"][0]["ratios"]["cpu_frame"]["median"]["verdict"].as_str().unwrap().to_owned()
    };
    // An interval misses once in twenty by its nature, so three tries.
    assert!(["1", "2", "3"].iter().any(|seed| verdict("", seed) == "equal"));
    assert!(["1", "2", "3"].iter().any(|seed| verdict("--slowdown 100", seed) == "different"));
}

#[test]
fn kinds_apart_are_drawn_alike_and_said() {
    let out = folder("isolate");
    json(&[
        SCENE,
        "scenes/unit/valence_5.json",
        "-o",
        out.to_str().unwrap(),
        "--short",
        "--isolate",
        "--pair",
        "--isolate=false",
        "--validate",
    ]);
    let (run, rows) = checked(&out);
    assert_eq!(run["runs"].as_array().unwrap().len(), 4);
    assert_eq!(run["pairs"].as_array().unwrap().len(), 2);
    assert_eq!(run["settings"]["isolate"], true);
    assert_eq!(run["runs"][1]["settings"]["isolate"], false);
    assert!(run["caveats"].as_array().unwrap().iter().any(|c| c.as_str().unwrap().starts_with("kinds isolated")));
    // Passes and barriers change no count.
    let counts = |id: &Value| {
        let row = rows.iter().find(|row| row["phase"] == "stats" && *id == row["run_id"]).unwrap();
        ["ia_primitives", "tes_invocations", "clip_primitives", "fs_invocations"].map(|c| row[c].clone())
    };
    assert_eq!(counts(&run["runs"][0]["run_id"]), counts(&run["runs"][1]["run_id"]));
    std::fs::remove_dir_all(&out).unwrap();
}

#[test]
fn comparison_warns_of_other_machines_drivers_and_clocks() {
    let (a, b) = (folder("compare-a"), folder("compare-b"));
    for out in [&a, &b] {
        json(&["scenes/quad.json", "-o", out.to_str().unwrap(), "--short"]);
    }
    let [first, second] = [&a, &b].map(|p| p.to_str().unwrap());
    let same = json(&["--compare", first, first]);
    assert_eq!(same["runs"][0]["ratios"]["cpu_frame"]["ratio"], 1.0);
    assert_eq!(same["runs"][0]["ratios"]["cpu_frame"]["verdict"], "equal");
    assert!(!same["warnings"].as_array().unwrap().iter().any(|w| w.as_str().unwrap().contains("differs")));

    let path = b.join("run.json");
    let mut changed = read_json(&path);
    changed["device"]["driver_info"] = "another".into();
    changed["device"]["name"] = "Another Device".into();
    changed["host"]["cpu"] = "Another Processor".into();
    changed["clocks"]["requested_mhz"] = 1234.0.into();
    std::fs::write(&path, serde_json::to_vec(&changed).unwrap()).unwrap();
    let other = json(&["--compare", first, second]);
    let warnings = other["warnings"].to_string();
    for what in ["device differs", "driver differs", "host differs", "clocks differs"] {
        assert!(warnings.contains(what), "{what}: {warnings}");
    }
    let out = run_text(&["--compare", first, second]);
    assert!(out.contains("warning: device differs"), "{out}");

    std::fs::write(&path, "{}").unwrap();
    let out = run(&["--compare", first, second]);
    assert_eq!(out.status.code(), Some(2));
    assert_eq!(String::from_utf8_lossy(&out.stderr).lines().count(), 1);
    for path in [a, b] {
        std::fs::remove_dir_all(&path).unwrap();
    }
}

fn run_text(arguments: &[&str]) -> String {
    String::from_utf8_lossy(&run(arguments).stderr).into_owned()
}

#[test]
fn an_interrupted_run_keeps_its_finished_repeats() {
    let out = folder("interrupted");
    let mut child =
        bench(&["scenes/quad.json", "-o", out.to_str().unwrap(), "--short", "--repeats", "100000", "--quiet"])
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
    let start = Instant::now();
    // run.json comes last of the three.
    while !out.join("run.json").exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "nothing was written");
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let rows = frames(&out);
    // Whole repeats only: two, six and two frames.
    assert!(!rows.is_empty() && rows.len() % 10 == 0, "{} rows", rows.len());
    let run = read_json(&out.join("run.json"));
    assert!(run["protocol"]["repeats_done"].as_u64().unwrap() >= 1);
    assert!(run["caveats"].as_array().unwrap().iter().any(|c| c.as_str().unwrap().starts_with("unfinished")));
    std::fs::remove_dir_all(&out).unwrap();
}

#[test]
fn wrong_requests_say_what_to_do() {
    let out = folder("wrong");
    let o = out.to_str().unwrap();
    let wrong: &[&[&str]] = &[
        &["-o", o],
        &["scenes/quad.json"],
        &["scenes/quad.json", "-o", o, "--frames", "0"],
        &["scenes/quad.json", "-o", o, "--pair", "--nonsense"],
        &["scenes/quad.json", "-o", o, "--pair", "--tess 65", "--short"],
        &["scenes/quad.json", "-o", o, "--mode", "both", "--pair", "--tess 2"],
        &["scenes/quad.json", "-o", o, "--level", "2"],
        &["scenes/quad.json", "-o", o, "--short", "--edits", "geometry"],
        &["scenes/quad.json", "-o", o, "--short", "--match-triangles", "--pixels", "4"],
        &["scenes/quad.json", "-o", o, "--short", "--isolate", "--samples", "4"],
        &["scenes/absent.json", "-o", o, "--short"],
        &["--compare", "scenes", "scenes"],
    ];
    for arguments in wrong {
        let out = run(arguments);
        let stderr = String::from_utf8_lossy(&out.stderr).into_owned();
        let errors = stderr.lines().filter(|line| line.starts_with("error: ")).count();
        assert_eq!((out.status.code(), errors), (Some(2), 1), "{arguments:?}: {stderr}");
    }
    assert!(!out.exists(), "nothing is written for a wrong request");
}

/// Edits followed in place touch and upload a part of what a rebuild does, and draw the same patches.
#[test]
fn edits_are_followed_in_place_in_sheets_of_copies() {
    for edits in ["geometry", "colour"] {
        let out = folder("local");
        let arguments = [
            &["scenes/cherry.json", "-o", out.to_str().unwrap(), "--short", "--tess", "1", "--edits", edits][..],
            &["--copies", "3", "--local", "--pair", "--local=false"],
            &["--frames", "3", "--warmup", "1", "--warmup-seconds", "0", "--stats-frames", "1", "--repeats", "1"],
        ]
        .concat();
        json(&arguments);
        let (run, rows) = checked(&out);
        let own = run["runs"][0]["run_id"].as_str().unwrap();
        let mut seen = [0; 2];
        for row in rows.iter().filter(|row| row["phase"] == "measure") {
            let local = row["run_id"] == own;
            let (touched, patches) =
                (number(row, "faces_touched"), number(row, "patches_bicubic") + number(row, "patches_gregory"));
            let (sent, all) = (number(row, "upload_bytes"), number(row, "gpu_bytes"));
            seen[usize::from(local)] += 1;
            assert_eq!(number(row, "edits_in_place"), f64::from(u8::from(local)));
            if local {
                assert!(
                    touched < 0.25 * patches && sent < 0.25 * all,
                    "{touched} of {patches} faces, {sent} of {all} bytes"
                );
            } else {
                assert_eq!((touched, sent), (patches, all));
            }
        }
        assert!(seen.iter().all(|&n| n > 0));
        std::fs::remove_dir_all(&out).unwrap();
    }
    for flags in [&["--local"][..], &["--local", "--edits", "rebuild"], &["--copies", "0"]] {
        let out = folder("local-refused");
        let arguments = [&["scenes/cherry.json", "-o", out.to_str().unwrap(), "--short"], flags].concat();
        assert_eq!(run(&arguments).status.code(), Some(2), "{flags:?}");
    }
}

/// The drag of one handle and handles that come and go touch as much in a sheet of copies as in one.
#[test]
fn a_drag_touches_as_much_in_a_sheet_as_in_one_copy() {
    let out = folder("drag");
    let scene = "scenes/unit/geometry_level_2.json";
    let done = json(&[scene, "-o", out.to_str().unwrap(), "--drag", "--copies", "5", "--frames", "3"]);
    let rows = done["rows"].as_array().unwrap();
    assert_eq!(done["schema"], "gradtess.drag/1");
    assert_eq!(rows.iter().map(|row| row["copies"].as_u64().unwrap()).collect::<Vec<_>>(), [1, 4, 5]);
    for row in rows {
        for what in ["drag_faces", "drag_bytes"] {
            assert!(row[what] == rows[0][what] && row[what].as_u64() > Some(0), "{what}: {row}");
        }
        // Welds near the handle that comes ask for other faces.
        assert!(row["handle_came"].as_u64() > Some(0) && row["handle_patches"].as_u64() > Some(0), "{row}");
        assert!(row["host_bytes_per_patch"].as_f64().unwrap() > 500.0, "{row}");
        assert!(row["control_bytes"].as_u64() > row["drag_bytes"].as_u64(), "{row}");
    }
    let csv = std::fs::read_to_string(out.join("drag.csv")).unwrap();
    assert!(csv.starts_with("copies,patches,load_ms,") && csv.lines().count() == 4, "{csv}");
    std::fs::remove_dir_all(&out).unwrap();
    for wrong in [&["scenes/quad.json", "scenes/cherry.json"][..], &["scenes/ferguson/sections.json"]] {
        let arguments = [wrong, &["-o", out.to_str().unwrap(), "--drag", "--short"]].concat();
        assert_eq!(run(&arguments).status.code(), Some(2), "{wrong:?}");
    }
}

/// Edits of a locally refinable mesh change a few patches; the traditional mesh that draws the same has more. Triangles by
/// formula are those that the device counts.
#[test]
fn gradient_meshes_are_measured_against_their_traditional_form() {
    for edits in ["geometry", "colour", "rebuild"] {
        let out = folder("ferguson");
        let scene = "scenes/ferguson/local_refinement.json";
        let arguments =
            [scene, "-o", out.to_str().unwrap(), "--short", "--mode", "both", "--edits", edits, "--tess", "6"];
        json(&arguments);
        let (run, rows) = checked(&out);
        let of = |i: usize, pointer: &str| run["runs"][i].pointer(pointer).unwrap().clone();
        assert_eq!(
            (of(0, "/scene/technique"), of(0, "/settings/spacing")),
            ("ferguson".into(), "fractional_even".into())
        );
        assert_eq!((of(0, "/scene/counts/total"), of(0, "/scene/counts/global")), (25.into(), 81.into()));
        assert_eq!(of(1, "/scene/counts/total"), 81);
        for row in &rows {
            let adaptive = row["run_id"] == of(0, "/run_id").as_str().unwrap();
            let changed = number(row, "faces_affected");
            match edits {
                "rebuild" => assert_eq!(changed, if adaptive { 25.0 } else { 81.0 }),
                _ => assert!((1.0..=24.0).contains(&changed), "{changed}"),
            }
            if row["phase"] == "measure" {
                // 32 points of 32 bytes a patch, and nothing that did not change.
                let sent = if edits == "rebuild" { number(row, "gpu_bytes") } else { 1024.0 * changed };
                assert_eq!(number(row, "upload_bytes"), sent, "{edits}");
            }
            if row["phase"] == "stats" {
                assert_eq!(number(row, "tcs_patches"), if adaptive { 25.0 } else { 81.0 });
                let triangles = of(usize::from(!adaptive), "/settings/triangles").as_f64().unwrap();
                assert_eq!(number(row, "clip_invocations"), triangles);
            }
        }
        std::fs::remove_dir_all(&out).unwrap();
    }
    let out = folder("ferguson-refused");
    for flags in [&["--match-triangles"][..], &["--rules", "authors"], &["--tess-base", "4"], &["--copies", "2"]] {
        let arguments = [&["scenes/ferguson/sections.json", "-o", out.to_str().unwrap(), "--short"], flags].concat();
        assert_eq!(run(&arguments).status.code(), Some(2), "{flags:?}");
    }
}
