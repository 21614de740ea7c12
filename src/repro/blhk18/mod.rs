//! Tables and figures of BLHK18.

pub mod fig_13;
pub mod fig_15;
pub mod fig_18;
pub mod fig_4;
pub mod fig_6;
pub mod fig_9;
pub mod net;
pub mod table_1;

use super::{ReproError, Sheet};
use serde_json::Value;

/// Puts a scene of the project into the figure's folder with some of its keys set to other values; returns the name by
/// which commands call it.
fn variant(sheet: &Sheet, scene: &str, name: &str, keys: &[(&str, Value)]) -> Result<String, ReproError> {
    let bytes =
        super::scenes::content(scene).ok_or_else(|| ReproError::Figure(format!("there is no scene {scene}")))?;
    let mut document: Value = serde_json::from_slice(bytes).map_err(|e| ReproError::Figure(e.to_string()))?;
    for (key, value) in keys {
        document[*key] = value.clone();
    }
    let text = serde_json::to_string(&document).map_err(|e| ReproError::Figure(e.to_string()))?;
    sheet.write(name, &(text + "\n"))
}

/// Greatest difference of two pictures in a channel, and how many pixels differ.
pub fn difference(a: &crate::image::Picture, b: &crate::image::Picture) -> (u8, usize) {
    let pixels = (0..a.height.min(b.height)).flat_map(|y| (0..a.width.min(b.width)).map(move |x| (x, y)));
    let each = pixels.map(|(x, y)| {
        let (p, q) = (a.pixel(x, y), b.pixel(x, y));
        (0..4).map(|c| p[c].abs_diff(q[c])).max().unwrap_or(0)
    });
    each.fold((0, 0), |(most, differ), d| (most.max(d), differ + usize::from(d > 0)))
}

/// A number as tables show it.
fn short(x: f64) -> String {
    format!("{x:.4}")
}
