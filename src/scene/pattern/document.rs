//! The JSON document of a pattern scene as `serde` sees it.

use serde::Deserialize;

/// The whole document.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Document {
    pub gradtess: u64,
    #[serde(rename = "$schema")]
    pub _schema: Option<String>,
    #[serde(rename = "technique")]
    pub _technique: String,
    #[serde(default)]
    pub name: String,
    /// An OBJ beside the scene instead of the next five.
    pub mesh: Option<String>,
    #[serde(default)]
    pub positions: Vec<[f64; 3]>,
    #[serde(default)]
    pub normals: Vec<[f64; 3]>,
    #[serde(default)]
    pub colours: Vec<Vec<f64>>,
    #[serde(default)]
    pub uv: Vec<[f64; 2]>,
    #[serde(default)]
    pub faces: Vec<Vec<u32>>,
    pub evaluator: Option<EvaluatorEntry>,
    pub normal_field: Option<FieldEntry>,
    pub displacement: Option<DisplacementEntry>,
    #[serde(default)]
    pub tags: Vec<TagEntry>,
    pub level: Option<u32>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum EvaluatorEntry {
    Linear,
    Pn,
    St,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum FieldEntry {
    Vlachos,
    Boubekeur,
    Linear,
}

/// How points move along their normal.
#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum DisplacementEntry {
    Sine {
        amplitude: f64,
        frequency: f64,
    },
    Noise {
        amplitude: f64,
        frequency: f64,
        octaves: Option<u32>,
        gain: Option<f64>,
        lacunarity: Option<f64>,
        speed: Option<f64>,
        time: Option<f64>,
        seed: Option<u32>,
    },
    Height {
        amplitude: f64,
        file: String,
        #[serde(default)]
        middle: f64,
    },
}

/// Scalar tags of a vertex.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TagEntry {
    pub vertex: u32,
    #[serde(default)]
    pub tension: f64,
    #[serde(default)]
    pub sharpness: f64,
    #[serde(default)]
    pub bias: f64,
    #[serde(default)]
    pub deviation: [f64; 3],
}
