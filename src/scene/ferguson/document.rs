//! The JSON document of a gradient mesh as `serde` sees it.

use serde::{Deserialize, Serialize};

/// The whole document.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Document {
    pub gradtess: u64,
    #[serde(default, rename = "$schema", skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    pub technique: String,
    #[serde(default)]
    pub name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub space: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alpha: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blend: Option<String>,
    pub points: Vec<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub colours: Vec<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub curves: Vec<CurveEntry>,
    pub patches: Vec<PatchEntry>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub operations: Vec<Operation>,
}

/// Handles of a curve.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CurveEntry {
    pub points: [u32; 2],
    pub handles: [[f64; 2]; 2],
}

/// A patch.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PatchEntry {
    pub points: [u32; 4],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colours: Option<[Vec<f64>; 4]>,
    /// At each corner: colour, derivative along u, along v, mixed; coordinates in the scene's space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub jets: Option<[[[f64; 4]; 4]; 4]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub twists: Option<[[f64; 2]; 4]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sides: Option<[SideEntry; 4]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inherits: Option<[bool; 4]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub root: Option<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<[f64; 4]>,
}

/// A side: number of its curve, where it begins on it, where it ends, its level.
#[derive(Clone, Copy, Deserialize, Serialize)]
pub(super) struct SideEntry(pub u32, pub f64, pub f64, pub u32);

/// One operation; exactly one of the first seven keys says which.
#[derive(Deserialize, Serialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct Operation {
    pub split: Option<u32>,
    pub remove_split: Option<u32>,
    #[serde(rename = "move")]
    pub move_point: Option<PointName>,
    pub handle: Option<HandleName>,
    pub twist: Option<[u32; 2]>,
    pub colour: Option<PointName>,
    pub sector: Option<[u32; 2]>,
    pub u: Option<f64>,
    pub v: Option<f64>,
    pub to: Option<Vec<f64>>,
    pub mode: Option<String>,
}

/// A point by its number, or as a corner of a patch: splits give points numbers that people would have to count.
#[derive(Clone, Copy, Deserialize, Serialize)]
#[serde(untagged)]
pub(super) enum PointName {
    Number(u32),
    Corner([u32; 2]),
}

/// A handle by its curve and end, or by the patch, the side and the end of the side.
#[derive(Clone, Copy, Deserialize, Serialize)]
#[serde(untagged)]
pub(super) enum HandleName {
    Curve([u32; 2]),
    Side([u32; 3]),
}
