//! The committed SPIR-V is what `glsl/` compiles to, and is valid.

#[path = "../tools/expand.rs"]
mod expand;

use std::path::Path;
use std::process::Command;

#[test]
fn spv_is_in_step_with_glsl() {
    let lines = expand::out_of_step(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap();
    assert!(lines.is_empty(), "{}", lines.join("\n"));
}

#[test]
fn spv_is_valid() {
    if Command::new("spirv-val").arg("--version").output().is_err() {
        println!("skipped: spirv-val is not installed");
        return;
    }
    for output in &expand::OUTPUTS {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("spv/{}.spv", output.name));
        let run = Command::new("spirv-val").args(["--target-env", expand::TARGET_ENV]).arg(&file).output().unwrap();
        assert!(run.status.success(), "{}: {}", file.display(), String::from_utf8_lossy(&run.stderr));
    }
}

#[test]
fn every_source_is_compiled() {
    let glsl = Path::new(env!("CARGO_MANIFEST_DIR")).join("glsl");
    for entry in std::fs::read_dir(glsl).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        if entry.file_type().unwrap().is_file() {
            assert!(expand::OUTPUTS.iter().any(|output| output.source == name), "glsl/{name} is not compiled");
        }
    }
}

#[test]
fn a_missing_include_is_named() {
    let folder = std::env::temp_dir().join(format!("gradtess-expand-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("a.vert"), "#version 450\n#include \"inc/none.glsl\"\n").unwrap();
    let error = expand::expand(&folder, "a.vert").unwrap_err();
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(error.contains("none.glsl"), "{error}");
}
