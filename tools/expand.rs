//! What `glsl/` compiles to, and the include expander. Shared by the shader tool and `tests/spirv.rs`.

use sha2::{Digest, Sha256};
use std::path::Path;

/// Schema named in the first field of `spv/manifest.json`.
pub const SCHEMA: &str = "gradtess.spv/1";
/// SPIR-V environment that every output is compiled for and validated against.
pub const TARGET_ENV: &str = "vulkan1.1";
/// Compiler settings, as the manifest records them: no optimiser (drivers have their own, and an optimiser is one
/// more thing that could reorder `precise` sums), names kept.
pub const FLAGS: [&str; 2] = ["-O0", "--target-env=vulkan1.1"];

/// One compiled shader.
pub struct Output {
    /// File name in `spv/`, without `.spv`.
    pub name: &'static str,
    /// File name in `glsl/`.
    pub source: &'static str,
    /// Macros, name and value.
    pub defines: &'static [(&'static str, &'static str)],
}

const fn out(name: &'static str, source: &'static str, defines: &'static [(&'static str, &'static str)]) -> Output {
    Output { name, source, defines }
}

/// Every output, in the order of the manifest.
#[rustfmt::skip]
pub const OUTPUTS: [Output; 58] = [
    out("patch.vert", "patch.vert", &[]),
    out("bicubic.tesc", "patch.tesc", &[("GREGORY", "0"), ("SHAPE", "0")]),
    out("bicubic_triangle.tesc", "patch.tesc", &[("GREGORY", "0"), ("SHAPE", "1")]),
    out("bicubic_quad.tesc", "patch.tesc", &[("GREGORY", "0"), ("SHAPE", "2")]),
    out("gregory.tesc", "patch.tesc", &[("GREGORY", "1"), ("SHAPE", "0")]),
    out("gregory_triangle.tesc", "patch.tesc", &[("GREGORY", "1"), ("SHAPE", "1")]),
    out("gregory_quad.tesc", "patch.tesc", &[("GREGORY", "1"), ("SHAPE", "2")]),
    out("bicubic.tese", "patch.tese", &[("GREGORY", "0"), ("SHAPE", "0")]),
    out("bicubic_triangle.tese", "patch.tese", &[("GREGORY", "0"), ("SHAPE", "1")]),
    out("bicubic_quad.tese", "patch.tese", &[("GREGORY", "0"), ("SHAPE", "2")]),
    out("gregory.tese", "patch.tese", &[("GREGORY", "1"), ("SHAPE", "0")]),
    out("gregory_triangle.tese", "patch.tese", &[("GREGORY", "1"), ("SHAPE", "1")]),
    out("gregory_quad.tese", "patch.tese", &[("GREGORY", "1"), ("SHAPE", "2")]),
    out("bicubic_readback.tese", "patch.tese", &[("GREGORY", "0"), ("SHAPE", "0"), ("READBACK", "1")]),
    out("bicubic_triangle_readback.tese", "patch.tese", &[("GREGORY", "0"), ("SHAPE", "1"), ("READBACK", "1")]),
    out("bicubic_quad_readback.tese", "patch.tese", &[("GREGORY", "0"), ("SHAPE", "2"), ("READBACK", "1")]),
    out("gregory_readback.tese", "patch.tese", &[("GREGORY", "1"), ("SHAPE", "0"), ("READBACK", "1")]),
    out("gregory_triangle_readback.tese", "patch.tese", &[("GREGORY", "1"), ("SHAPE", "1"), ("READBACK", "1")]),
    out("gregory_quad_readback.tese", "patch.tese", &[("GREGORY", "1"), ("SHAPE", "2"), ("READBACK", "1")]),
    out("stitched.tesc", "stitched.tesc", &[]),
    out("stitched.tese", "stitched.tese", &[]),
    out("stitched_readback.tese", "stitched.tese", &[("READBACK", "1")]),
    out("remap_bicubic.tesc", "remap.tesc", &[("GREGORY", "0")]),
    out("remap_gregory.tesc", "remap.tesc", &[("GREGORY", "1")]),
    out("remap_bicubic.tese", "remap.tese", &[("GREGORY", "0")]),
    out("remap_gregory.tese", "remap.tese", &[("GREGORY", "1")]),
    out("remap_bicubic_readback.tese", "remap.tese", &[("GREGORY", "0"), ("READBACK", "1")]),
    out("remap_gregory_readback.tese", "remap.tese", &[("GREGORY", "1"), ("READBACK", "1")]),
    out("colour.frag", "colour.frag", &[]),
    out("solid.vert", "solid.vert", &[]),
    out("solid.frag", "solid.frag", &[]),
    out("pattern.vert", "pattern.vert", &[("SOURCE", "0")]),
    out("pattern_uniform.vert", "pattern.vert", &[("SOURCE", "1")]),
    out("pattern_flat.vert", "pattern.vert", &[("SOURCE", "2")]),
    out("pattern_detail.vert", "pattern.vert", &[("SOURCE", "0"), ("DETAIL", "1")]),
    out("pattern_readback.vert", "pattern.vert", &[("SOURCE", "0"), ("READBACK", "1")]),
    out("pattern_flat_readback.vert", "pattern.vert", &[("SOURCE", "2"), ("READBACK", "1")]),
    out("pattern_detail_readback.vert", "pattern.vert", &[("SOURCE", "0"), ("DETAIL", "1"), ("READBACK", "1")]),
    out("pattern_detail.comp", "pattern_detail.comp", &[]),
    out("pattern_control.comp", "pattern_control.comp", &[]),
    out("pattern_static.vert", "pattern_static.vert", &[]),
    out("pattern_patch.vert", "pattern_patch.vert", &[]),
    out("pattern.tesc", "pattern.tesc", &[]),
    out("pattern.tese", "pattern.tese", &[]),
    out("pattern.frag", "pattern.frag", &[]),
    out("stencil.comp", "stencil.comp", &[]),
    out("solid_bicubic.tesc", "solid.tesc", &[("GREGORY", "0"), ("TRANSITION", "0")]),
    out("solid_gregory.tesc", "solid.tesc", &[("GREGORY", "1"), ("TRANSITION", "0")]),
    out("solid_transition.tesc", "solid.tesc", &[("GREGORY", "0"), ("TRANSITION", "1")]),
    out("solid_bicubic.tese", "solid.tese", &[("GREGORY", "0"), ("TRANSITION", "0")]),
    out("solid_gregory.tese", "solid.tese", &[("GREGORY", "1"), ("TRANSITION", "0")]),
    out("solid_transition.tese", "solid.tese", &[("GREGORY", "0"), ("TRANSITION", "1")]),
    out("solid_quartic.tesc", "solid_quartic.tesc", &[("GREGORY", "0"), ("TRANSITION", "0")]),
    out("solid_quartic_gregory.tesc", "solid_quartic.tesc", &[("GREGORY", "1"), ("TRANSITION", "0")]),
    out("solid_quartic_transition.tesc", "solid_quartic.tesc", &[("GREGORY", "0"), ("TRANSITION", "1")]),
    out("solid_quartic.tese", "solid_quartic.tese", &[("GREGORY", "0"), ("TRANSITION", "0")]),
    out("solid_quartic_gregory.tese", "solid_quartic.tese", &[("GREGORY", "1"), ("TRANSITION", "0")]),
    out("solid_quartic_transition.tese", "solid_quartic.tese", &[("GREGORY", "0"), ("TRANSITION", "1")]),
];

/// Text of `glsl/NAME` with every `#include "..."` (relative to `glsl/`) replaced by the file's text, and the
/// directive's `#extension` line dropped.
///
/// # Errors
/// A line that names the file that could not be read.
pub fn expand(glsl: &Path, name: &str) -> Result<String, String> {
    let path = glsl.join(name);
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut expanded = String::with_capacity(2 * text.len());
    for line in text.lines() {
        let include = line.strip_prefix("#include \"").and_then(|rest| rest.strip_suffix('"'));
        match include {
            Some(file) => expanded += &expand(glsl, file)?,
            None if line.starts_with("#extension GL_GOOGLE_include_directive") => {}
            None => {
                expanded += line;
                expanded.push('\n');
            }
        }
    }
    Ok(expanded)
}

/// SHA-256 in lower-case hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// Compares `spv/` and its manifest with `glsl/`: one line for each output that is out of step, with what to do.
///
/// # Errors
/// A line when a file cannot be read or the manifest is not one.
pub fn out_of_step(root: &Path) -> Result<Vec<String>, String> {
    let path = root.join("spv/manifest.json");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let manifest: serde_json::Value = serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut lines = Vec::new();
    if manifest["schema"] != SCHEMA
        || manifest["target_env"] != TARGET_ENV
        || manifest["flags"] != serde_json::json!(FLAGS)
    {
        lines.push(format!("spv/manifest.json: schema, target or flags differ from {SCHEMA}; compile again"));
    }
    let rows = manifest["outputs"].as_array().cloned().unwrap_or_default();
    for output in &OUTPUTS {
        let Some(row) = rows.iter().find(|row| row["name"] == output.name) else {
            lines.push(format!("spv/{}.spv: not in the manifest; compile again", output.name));
            continue;
        };
        let source = expand(&root.join("glsl"), output.source)?;
        if row["source_sha256"] != sha256(source.as_bytes()) || row["defines"] != defines(output) {
            lines.push(format!(
                "spv/{}.spv: glsl/{} changed since it was compiled; compile again",
                output.name, output.source
            ));
        }
        match std::fs::read(root.join(format!("spv/{}.spv", output.name))) {
            Ok(words) if row["spv_sha256"] == sha256(&words) => {}
            Ok(_) => lines.push(format!("spv/{}.spv: not the file in the manifest; compile again", output.name)),
            Err(e) => lines.push(format!("spv/{}.spv: {e}; compile again", output.name)),
        }
    }
    for row in &rows {
        if !OUTPUTS.iter().any(|output| row["name"] == output.name) {
            lines.push(format!("spv/{}.spv: no longer made; remove it", row["name"].as_str().unwrap_or("?")));
        }
    }
    Ok(lines)
}

/// The macros of an output as the manifest has them, `NAME=VALUE`.
pub fn defines(output: &Output) -> serde_json::Value {
    output.defines.iter().map(|(name, value)| format!("{name}={value}")).collect()
}
