//! `shaders` compiles `glsl/` to `spv/` (with the feature `shaderc`); `shaders --check` changes nothing and exits 1
//! when `spv/` is out of step with `glsl/`.
//!
//!     cargo run --bin shaders --features shaderc
//!     cargo run --bin shaders -- --check

#[path = "expand.rs"]
mod expand;

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let done = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["--check"] => check(root),
        [] => compile(root),
        _ => {
            eprintln!("error: usage: shaders [--check]");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(line) => {
            println!("{line}");
            ExitCode::SUCCESS
        }
        Err(line) => {
            eprintln!("error: {line}");
            ExitCode::from(1)
        }
    }
}

fn check(root: &Path) -> Result<String, String> {
    let lines = expand::out_of_step(root)?;
    if lines.is_empty() {
        Ok(format!("{} shaders in step with glsl/", expand::OUTPUTS.len()))
    } else {
        Err(lines.join("\nerror: "))
    }
}

#[cfg(not(feature = "shaderc"))]
fn compile(_: &Path) -> Result<String, String> {
    Err("built without a compiler; use `cargo run --bin shaders --features shaderc`, or `--check`".to_owned())
}

#[cfg(feature = "shaderc")]
fn compile(root: &Path) -> Result<String, String> {
    use serde_json::json;
    let compiler = shaderc::Compiler::new().map_err(|e| format!("shaderc: {e}"))?;
    let mut rows = Vec::new();
    let mut files = Vec::new();
    for output in &expand::OUTPUTS {
        let source = expand::expand(&root.join("glsl"), output.source)?;
        let mut options = shaderc::CompileOptions::new().map_err(|e| format!("shaderc: {e}"))?;
        options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_1 as u32);
        options.set_optimization_level(shaderc::OptimizationLevel::Zero);
        options.set_warnings_as_errors();
        for (name, value) in output.defines {
            options.add_macro_definition(name, Some(value));
        }
        let kind = match output.source.rsplit('.').next() {
            Some("vert") => shaderc::ShaderKind::Vertex,
            Some("tesc") => shaderc::ShaderKind::TessControl,
            Some("tese") => shaderc::ShaderKind::TessEvaluation,
            Some("comp") => shaderc::ShaderKind::Compute,
            _ => shaderc::ShaderKind::Fragment,
        };
        let artifact = compiler
            .compile_into_spirv(&source, kind, output.source, "main", Some(&options))
            .map_err(|e| format!("glsl/{} for spv/{}.spv: {e}", output.source, output.name))?;
        let words = artifact.as_binary_u8().to_vec();
        rows.push(json!({
            "name": output.name,
            "source": format!("glsl/{}", output.source),
            "defines": expand::defines(output),
            "source_sha256": expand::sha256(source.as_bytes()),
            "spv_sha256": expand::sha256(&words),
        }));
        files.push((format!("{}.spv", output.name), words));
    }
    let spv = root.join("spv");
    for (name, words) in &files {
        write(&spv.join(name), words)?;
    }
    let manifest = json!({
        "schema": expand::SCHEMA,
        "compiler": compiler_version(root),
        "target_env": expand::TARGET_ENV,
        "flags": expand::FLAGS,
        "outputs": rows,
    });
    let text = serde_json::to_string_pretty(&manifest).map_err(|e| e.to_string())? + "\n";
    write(&spv.join("manifest.json"), text.as_bytes())?;
    let validated = validate(&spv, &files)?;
    Ok(format!("{} shaders written to spv/; {validated}", files.len()))
}

/// Writes beside the file and renames, so that nothing is overwritten half-way.
#[cfg(feature = "shaderc")]
fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let part = path.with_extension("part");
    std::fs::write(&part, bytes)
        .and_then(|()| std::fs::rename(&part, path))
        .map_err(|e| format!("{}: {e}", path.display()))
}

/// The version of the compiler's sources, from `Cargo.lock`.
#[cfg(feature = "shaderc")]
fn compiler_version(root: &Path) -> String {
    let lock = std::fs::read_to_string(root.join("Cargo.lock")).unwrap_or_default();
    let version = lock
        .split("name = \"shaderc-sys\"\nversion = \"")
        .nth(1)
        .and_then(|rest| rest.split('"').next())
        .unwrap_or("unknown");
    let (spirv, _) = shaderc::get_spirv_version();
    format!("shaderc-sys {version} from source, SPIR-V headers {}.{}", spirv >> 16, (spirv >> 8) & 255)
}

#[cfg(feature = "shaderc")]
fn validate(spv: &Path, files: &[(String, Vec<u8>)]) -> Result<String, String> {
    for (name, _) in files {
        let run = std::process::Command::new("spirv-val")
            .args(["--target-env", expand::TARGET_ENV])
            .arg(spv.join(name))
            .output();
        match run {
            Err(_) => return Ok("not validated, spirv-val is not installed".to_owned()),
            Ok(run) if !run.status.success() => {
                return Err(format!("spv/{name}: {}", String::from_utf8_lossy(&run.stderr).trim()))
            }
            Ok(_) => {}
        }
    }
    Ok("spirv-val found nothing".to_owned())
}
