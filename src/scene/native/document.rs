//! The document of the native format as `serde` sees it: grammar, keys and types, no sense yet.

use super::VERSION;
use crate::scene::error::{quoted, Fault};
use crate::scene::json_position::{place, Step::Key};
use crate::scene::Reference;
use glam::DVec4;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Document {
    pub gradtess: u64,
    #[serde(default, rename = "$schema")]
    _schema: Option<String>,
    pub technique: Option<String>,
    #[serde(default)]
    pub name: String,
    #[serde(default)]
    pub corners: Corners,
    pub builtin: Option<String>,
    pub vertices: Option<Vec<[f64; 2]>>,
    pub faces: Option<Vec<Vec<u32>>>,
    pub vertex_colours: Option<Vec<Colour>>,
    pub corner_colours: Option<Vec<Colour>>,
    #[serde(default)]
    pub sharp: Vec<u32>,
    #[serde(default)]
    pub handles: Vec<Point>,
    #[serde(default)]
    pub face_points: Vec<Point>,
    #[serde(default)]
    pub geometry: Vec<Geometry>,
    #[serde(default)]
    pub colour: Vec<Coloured>,
    pub reference: Option<Reference>,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Corners {
    #[default]
    Sharp,
    Smooth,
}

#[derive(Clone, Copy, Default, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum FrameName {
    #[default]
    Sector,
    Boundary,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Point {
    pub half_edge: u32,
    pub at: [f64; 2],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Geometry {
    pub level: u32,
    pub half_edge: u64,
    pub vertex: Option<u64>,
    pub a: f64,
    pub b: f64,
    #[serde(default)]
    pub frame: FrameName,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Coloured {
    pub level: u32,
    pub half_edge: u64,
    pub colour: Colour,
}

/// Three or four numbers.
#[derive(Clone, Copy)]
pub(super) struct Colour(pub DVec4);

impl<'de> Deserialize<'de> for Colour {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Colour, D::Error> {
        struct Numbers;
        impl<'de> serde::de::Visitor<'de> for Numbers {
            type Value = Colour;

            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a colour [red, green, blue] or [red, green, blue, alpha]")
            }

            fn visit_seq<A: serde::de::SeqAccess<'de>>(self, mut numbers: A) -> Result<Colour, A::Error> {
                let mut colour = [0.0, 0.0, 0.0, 1.0];
                let mut count = 0;
                while let Some(number) = numbers.next_element()? {
                    *colour.get_mut(count).ok_or_else(|| serde::de::Error::invalid_length(count + 1, &self))? = number;
                    count += 1;
                }
                if count < 3 {
                    return Err(serde::de::Error::invalid_length(count, &self));
                }
                Ok(Colour(DVec4::from(colour)))
            }
        }
        deserializer.deserialize_seq(Numbers)
    }
}

/// The document in `text`, grammar and types checked.
pub(super) fn parse(text: &str) -> Result<Document, Fault> {
    serde_json::from_str(text).map_err(|error| {
        // A scene of a later version, or of another technique, has keys and types of its own: say that first.
        if let Some(fault) = foreign(text) {
            return fault;
        }
        let message = error.to_string();
        // The place is reported in front, so the parser's own wording of it goes.
        let what = message.rsplit_once(" at line ").map_or(message.as_str(), |(what, _)| what);
        let what = match what.char_indices().nth(300) {
            Some((cut, _)) => format!("{}...", &what[..cut]),
            None => what.to_owned(),
        };
        let fix = if what.starts_with("unknown field") {
            "correct or remove that key"
        } else if error.is_data() {
            "see scenes/schema.json for what belongs there"
        } else {
            "correct the JSON"
        };
        Fault::new((error.line().max(1), error.column().max(1)), what, fix)
    })
}

/// A fault when the text's version or technique is one this program does not have.
fn foreign(text: &str) -> Option<Fault> {
    #[derive(Deserialize)]
    struct Head {
        gradtess: Option<serde_json::Value>,
        technique: Option<serde_json::Value>,
    }
    let head: Head = serde_json::from_str(text).ok()?;
    head_fault(text, head.gradtess.as_ref()?, head.technique.as_ref().and_then(|name| name.as_str()))
}

/// A fault when `version` or `technique` is none of ours.
pub(super) fn head_fault(text: &str, version: &serde_json::Value, technique: Option<&str>) -> Option<Fault> {
    if version.as_u64() != Some(VERSION) {
        let what = format!("scene format version {} is not supported", quoted(&version.to_string()));
        let fix = format!("this program reads version {VERSION}: `\"gradtess\": {VERSION}`");
        return Some(Fault::new(place(text, &[Key("gradtess")]), what, fix));
    }
    let technique = technique.filter(|&name| name != "subdivision")?;
    let what = format!("technique {} is not available", quoted(technique));
    Some(Fault::new(place(text, &[Key("technique")]), what, "use \"subdivision\""))
}
