//! From bytes to a JSON document of the right version, for the readers of native scenes.

use super::error::Fault;
use super::json_position::{line_column, place, Step};
use super::native::VERSION;
use serde::Deserialize;

/// The text and what it says; `version` reads the number of the format.
///
/// # Errors
/// The bytes are not UTF-8, not JSON, not a document of this form, or of another version.
pub(super) fn document<'a, D: Deserialize<'a>>(
    bytes: &'a [u8],
    version: impl Fn(&D) -> u64,
) -> Result<(&'a str, D), Fault> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let valid = String::from_utf8_lossy(&bytes[..error.valid_up_to()]);
        Fault::new(line_column(&valid, valid.len()), "this is not UTF-8", "save the scene as UTF-8")
    })?;
    let document: D = serde_json::from_str(text).map_err(|error| {
        let message = error.to_string();
        let what = message.rsplit_once(" at line ").map_or(message.as_str(), |(what, _)| what);
        let what: String = what.chars().take(300).collect();
        let fix = match (what.starts_with("unknown field"), error.is_data()) {
            (true, _) => "correct or remove that key",
            (_, true) => "see scenes/schema.json for what belongs there",
            _ => "correct the JSON",
        };
        Fault::new((error.line().max(1), error.column().max(1)), what, fix)
    })?;
    match version(&document) {
        VERSION => Ok((text, document)),
        other => {
            let what = format!("scene format version {other} is not supported");
            let fix = format!("this program reads version {VERSION}");
            Err(Fault::new(place(text, &[Step::Key("gradtess")]), what, fix))
        }
    }
}
