//! `bench` of surfaces: patches have less error than uniform levels of many more vertices.

mod models;

use serde_json::Value;
use std::process::Command;

#[test]
fn patches_draw_spot_as_well_as_level_4_with_a_tenth_of_its_vertices_computed() {
    let Some(models) = models::folder("surface", "bench of Spot") else { return };
    let folder = std::env::temp_dir().join(format!("gradtess-spot-bench-{}", std::process::id()));
    let spot = models.join("Spot2.obj");
    let args = ["bench", spot.to_str().unwrap(), "-o", folder.to_str().unwrap(), "--short", "--level", "4", "--json"];
    let ran = Command::new(env!("CARGO_BIN_EXE_gradtess")).args(args).args(["--size", "256x256"]).output().unwrap();
    let text = String::from_utf8_lossy(&ran.stderr);
    if !ran.status.success() && text.contains("no Vulkan device") {
        println!("skipped: {text}");
        return;
    }
    assert!(ran.status.success(), "{text}");
    let report: Value = serde_json::from_slice(&ran.stdout).unwrap();
    let found = &report["matches"][0];
    assert_eq!(found["uniform_level"], 4);
    let percent = found["computed_percent"].as_f64().unwrap();
    assert!(percent <= 10.0, "{found}");
    // That is what the rows say.
    let rows = report["rows"].as_array().unwrap();
    let row = |is: &dyn Fn(&Value) -> bool| rows.iter().find(|r| is(r)).unwrap();
    let uniform = row(&|r| r["adaptive"] == false && r["limit"] == false && r["level"] == 4);
    let patches = row(&|r| r["adaptive"] == true && r["level"] == found["level"] && r["segments"] == found["segments"]);
    let number = |row: &Value, key: &str| row[key].as_f64().unwrap();
    for key in ["silhouette_permille", "normal_mean_degrees"] {
        assert!(number(patches, key) <= number(uniform, key), "{key}: {patches} {uniform}");
    }
    let computed = |row: &Value| number(row, "computed_vertices") + number(row, "computed_points");
    assert_eq!(computed(uniform), 46_850.0);
    assert!((percent - 100.0 * computed(patches) / computed(uniform)).abs() < 1e-9, "{found} {patches}");
    assert!(number(patches, "computed_points") < 0.1 * number(patches, "device_vertices"), "{patches}");
    let _ = std::fs::remove_dir_all(folder);
}

#[test]
fn patches_have_less_error_for_fewer_vertices() {
    let folder = std::env::temp_dir().join(format!("gradtess-surface-bench-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1.1 0\nv 0 1 0\nv 0 0 1\nv 1 0.2 1\nv 1 1 1.3\nv 0 1 1\n\
        f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nfs 0 0 1 0\n";
    let scene = folder.join("cube.obj");
    std::fs::write(&scene, cube).unwrap();
    let out = folder.join("run");
    let run = |extra: &[&str]| {
        let mut args = vec!["bench", scene.to_str().unwrap(), "-o", out.to_str().unwrap(), "--short"];
        args.extend(extra);
        Command::new(env!("CARGO_BIN_EXE_gradtess")).args(args).output().unwrap()
    };
    let ran = run(&["--json"]);
    let text = String::from_utf8_lossy(&ran.stderr);
    if !ran.status.success() && text.contains("no Vulkan device") {
        println!("skipped: {text}");
        return;
    }
    assert!(ran.status.success(), "{text}");
    let report: Value = serde_json::from_slice(&ran.stdout).unwrap();
    assert_eq!(report["schema"], "gradtess.surface_bench/1");
    let rows = report["rows"].as_array().unwrap();
    let number = |row: &Value, key: &str| row[key].as_f64().unwrap();
    let uniform = rows.iter().find(|r| r["adaptive"] == false && r["level"] == 3 && r["limit"] == false).unwrap();
    let patches = rows.iter().find(|r| r["adaptive"] == true && r["level"] == 2 && r["segments"] == 32).unwrap();
    assert_eq!(number(uniform, "computed_vertices"), 386.0);
    for key in ["computed_vertices", "silhouette_permille", "normal_mean_degrees"] {
        assert!(number(patches, key) < 0.5 * number(uniform, key), "{key}: {patches} {uniform}");
    }
    let csv = std::fs::read_to_string(out.join("surface.csv")).unwrap();
    assert_eq!(csv.lines().count(), rows.len() + 1);
    // A scene of another technique beside it, and what does not go with surfaces.
    for extra in [&["--pair", "--tess 8"][..], &["--scheme", "loop"]] {
        assert_eq!(run(extra).status.code(), Some(2));
    }
    let _ = std::fs::remove_dir_all(folder);
}
