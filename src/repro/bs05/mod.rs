//! Figures of BS05.

pub mod fig_3;
pub mod fig_4;
pub mod fig_5;
pub mod fig_6;
pub mod fig_7;

use super::sheet::cell;
use super::{ReproError, Sheet};
use serde_json::Value;

/// Draws a picture with a transparent ground and shows it with a caption that `words` makes of what the command said.
fn draw(
    sheet: &mut Sheet,
    name: &str,
    scene: &str,
    flags: &str,
    words: impl Fn(&Value) -> String,
) -> Result<Value, ReproError> {
    let out = sheet.file(name);
    let said = sheet.run(&format!("render {scene} -o {out} --size 512x512 --samples 4 {flags}"))?;
    sheet.picture(name, words(&said));
    Ok(said)
}

/// Counts of a picture as cells: vertices stored, triangles drawn, bytes on the device.
fn counts(said: &Value) -> [String; 3] {
    ["/vertices_stored", "/triangles", "/device_bytes"].map(|pointer| cell(said, pointer))
}
