//! What makes the patches of a measured scene, one kind for each technique.

use crate::command::Failure;
use crate::gpu::{DeviceTable, Gpu};
use crate::timing::record::Fields;
use std::collections::BTreeMap;

/// Counts of what is drawn.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    /// Faces refined on all levels.
    pub affected: u64,
    /// Deepest level drawn.
    pub max_level: u64,
    /// Bicubic faces, transition faces among them, Gregory faces, transition faces among them.
    pub patches: [u64; 4],
    /// Control points.
    pub control_points: u64,
}

/// What does not change while a scene is measured.
pub struct Facts {
    /// Name of the scene.
    pub name: String,
    /// File, as the user named it.
    pub file: String,
    /// Technique.
    pub technique: &'static str,
    /// Rules of refinement, in a word.
    pub rules: &'static str,
    /// What draws irregular faces, in a word.
    pub patches: &'static str,
    /// Spacing of the tessellator.
    pub spacing: &'static str,
    /// Row of Table 1.
    pub counts: BTreeMap<String, u64>,
    /// All edits as text, without the mesh.
    pub edits: String,
}

/// A scene of some technique in some configuration.
pub trait Source {
    /// Name of the scene.
    fn name(&self) -> &str;

    /// What is written into `run.json`.
    fn facts(&self) -> Facts;

    /// Counts of what was made last.
    fn counts(&self) -> Counts;

    /// Does the edit that belongs to frame `i` and brings the device's table up to date. `lap` gives the time since it was
    /// called last, ms, for the stages in `fields`.
    fn edit(
        &mut self,
        i: u32,
        gpu: &Gpu,
        table: &mut DeviceTable,
        fields: &mut Fields,
        lap: &mut dyn FnMut() -> Option<f64>,
    ) -> Result<(), Failure>;

    /// Frees what the last edit made and nobody needs any more.
    fn let_go(&mut self) {}
}

/// The row of Table 1 from counts of patches as in [`Counts::patches`].
pub fn row(patches: [u64; 4], global: u64) -> BTreeMap<String, u64> {
    let [bicubic, bicubic_transition, gregory, gregory_transition] = patches;
    let counts = [
        ("bicubic", bicubic),
        ("bicubic_transition", bicubic_transition),
        ("gregory", gregory),
        ("gregory_transition", gregory_transition),
        ("total", bicubic + gregory),
        ("global", global),
    ];
    counts.map(|(name, n)| (name.to_owned(), n)).into()
}
