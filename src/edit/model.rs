//! A scene with everything that follows from it.

use super::EditError;
use crate::mesh::{self, HalfEdgeMesh, ShapeNote};
use crate::patch::build::build;
use crate::patch::points::Irregular;
use crate::patch::PatchTable;
use crate::refine::{refine, Mode, Options, Refinement, Rules};
use crate::scene::Scene;
use std::time::{Duration, Instant};

/// How the scene is turned into patches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawing {
    /// Adaptive or global.
    pub mode: Mode,
    /// What draws irregular faces.
    pub irregular: Irregular,
}

impl Default for Drawing {
    fn default() -> Self {
        Drawing { mode: Mode::Adaptive { isolate: 0 }, irregular: Irregular::Gregory }
    }
}

/// A scene, its mesh, levels and patches.
pub struct Model {
    /// What the user edits.
    pub scene: Scene,
    /// Its polygons as half-edges.
    pub mesh: HalfEdgeMesh,
    /// Adaptive levels: where the surface is, whatever is drawn.
    pub refinement: Refinement,
    /// What is drawn.
    pub table: PatchTable,
    /// Faces whose shape asks for trouble.
    pub notes: Vec<ShapeNote>,
    /// How the table was made.
    pub drawing: Drawing,
    /// Rises with every change of the scene or of the drawing.
    pub revision: u64,
    /// Wall time of the last refinement and of the last patch table.
    pub times: [Duration; 2],
}

impl Model {
    /// Builds everything.
    ///
    /// # Errors
    /// The polygons form no mesh, or an edit does not fit it.
    pub fn new(scene: Scene, drawing: Drawing) -> Result<Model, EditError> {
        let mesh = mesh::build(&scene.mesh)?;
        let mut model = Model {
            notes: mesh::shape_notes(&mesh),
            refinement: adaptive(&scene, &mesh)?,
            scene,
            mesh,
            table: PatchTable::default(),
            drawing,
            revision: 0,
            times: [Duration::ZERO; 2],
        };
        model.draw(drawing)?;
        Ok(model)
    }

    /// Takes another scene, and everything that follows. After an error the model is as it was.
    ///
    /// # Errors
    /// As [`Model::new`].
    pub fn set(&mut self, scene: Scene) -> Result<(), EditError> {
        let same = scene.mesh.corners == self.scene.mesh.corners && scene.mesh.face_start == self.scene.mesh.face_start;
        let mut mesh = if same { self.mesh.clone() } else { mesh::build(&scene.mesh)? };
        if same {
            mesh.positions.clone_from(&scene.mesh.positions);
        }
        let start = Instant::now();
        let refinement = adaptive(&scene, &mesh)?;
        let refined = Instant::now();
        let made = match self.drawing.mode {
            Mode::Adaptive { isolate: 0 } => None,
            mode => Some(refine(&scene, &mesh, Options { rules: Rules::Gradtess, mode })?),
        };
        let shown = Instant::now();
        self.table = build(made.as_ref().unwrap_or(&refinement), self.drawing.irregular);
        // The time of what is drawn; the other is there for the handles.
        let refining = if made.is_some() { shown - refined } else { refined - start };
        self.times = [refining, shown.elapsed()];
        if !same || self.scene.mesh.positions != scene.mesh.positions {
            self.notes = mesh::shape_notes(&mesh);
        }
        (self.scene, self.mesh, self.refinement) = (scene, mesh, refinement);
        self.revision += 1;
        Ok(())
    }

    /// Rectangle x0, y0, x1, y1 around all control points, which is around the surface; `None` without patches.
    pub fn bounds(&self) -> Option<[f64; 4]> {
        let mut b = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for p in &self.table.control {
            b = [b[0].min(p[0]), b[1].min(p[1]), b[2].max(p[0]), b[3].max(p[1])];
        }
        (b[0] <= b[2]).then_some(b)
    }

    /// Draws the same scene in another way.
    ///
    /// # Errors
    /// A global level that is too large.
    pub fn draw(&mut self, drawing: Drawing) -> Result<(), EditError> {
        let before = std::mem::replace(&mut self.drawing, drawing);
        let done = self.set(self.scene.clone());
        if done.is_err() {
            self.drawing = before;
        }
        done
    }
}

fn adaptive(scene: &Scene, mesh: &HalfEdgeMesh) -> Result<Refinement, EditError> {
    Ok(refine(scene, mesh, Options::default())?)
}
