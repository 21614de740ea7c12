//! From the bytes of a pattern scene to the coefficients of its triangles.

use crate::command::{Failure, Global};
use crate::pattern::Control;
use crate::scene::pattern::PatternScene;

/// A coarse mesh as it was read.
pub struct Pattern {
    /// The scene.
    pub scene: PatternScene,
}

impl Pattern {
    /// Reads JSON or OBJ from the `bytes` of `file`; what was mended is warned of.
    pub fn load(file: &str, bytes: &[u8], global: &Global) -> Result<Pattern, Failure> {
        let scene = PatternScene::parse(bytes, file)?;
        for note in &scene.notes {
            global.warn(format_args!("{file}: {note}"));
        }
        Ok(Pattern { scene })
    }
}

/// Coefficients of all triangles of a scene.
pub fn controls(scene: &PatternScene) -> Vec<Control> {
    (0..scene.mesh.triangles.len()).map(|t| Control::new(&scene.mesh, t, scene.evaluator, scene.normal_field)).collect()
}
