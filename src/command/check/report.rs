//! What `check` has found, as JSON and as text.

use crate::check::folds::{self, Fold, Folds};
use crate::command::measure::{kind_name, ErrorReport};
use crate::patch::PatchTable;
use crate::subdiv::level::Level;
use serde::Serialize;

#[derive(Serialize)]
pub struct Report {
    pub schema: &'static str,
    pub scene: String,
    pub views: usize,
    pub pixels_inside: usize,
    pub crack_pixels: usize,
    /// Least and greatest level of `--random-tess`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub random_levels: Option<[u32; 2]>,
    /// Edges of drawn faces on the boundary of the mesh.
    pub boundary_edges: usize,
    /// Edges that only one patch has: as many, if every other edge has the same control points on both sides.
    pub outline_edges: usize,
    /// Where the first cracks are: x, y in the model.
    pub first_cracks: Vec<[f64; 2]>,
    /// Distance from the limit in the first view.
    pub error: ErrorReport,
    /// Of `--seams`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seams: Option<SeamReport>,
    /// Error against patches, by `--isolate-curve`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub isolate_curve: Vec<CurvePoint>,
    pub folds: FoldReport,
}

/// Whether both sides of all edges got the same bits.
#[derive(Serialize)]
pub struct SeamReport {
    /// Segments on sides of patches and parts.
    pub segments: usize,
    /// Segments on the boundary of the mesh, which have one side.
    pub boundary_segments: usize,
    /// Others that have no partner.
    pub open_segments: usize,
}

impl SeamReport {
    pub fn text(&self) -> String {
        format!(
            "  seams: {} of {} segments inside have not the same bits on both sides\n",
            self.open_segments,
            self.segments - self.boundary_segments.min(self.segments)
        )
    }
}

/// One point of the curve of error against patches.
#[derive(Serialize)]
pub struct CurvePoint {
    /// Levels by which irregular faces are refined further.
    pub isolate: u32,
    /// Patches drawn, every part of a transition face for itself; and faces.
    pub patches: u64,
    pub faces: usize,
    /// Greatest and mean colour distance, per cent of sqrt 3; null of no pixels.
    pub max_percent: Option<f64>,
    pub mean_percent: Option<f64>,
    /// Greatest distance of patch and limit point, pixels.
    pub shift_pixels: f64,
}

/// The curve as a table; empty of no points.
pub fn curve_text(curve: &[CurvePoint]) -> String {
    if curve.is_empty() {
        return String::new();
    }
    let mut text = "  --isolate  patches    faces   max %     mean %      pixels off\n".to_owned();
    for point in curve {
        let number = |x: Option<f64>, digits: usize| x.map_or("NA".to_owned(), |x| format!("{x:.digits$}"));
        text += &format!(
            "  {:9}  {:7}  {:7}   {:<7}   {:<9}   {:.4}\n",
            point.isolate,
            point.patches,
            point.faces,
            number(point.max_percent, 4),
            number(point.mean_percent, 6),
            point.shift_pixels
        );
    }
    text
}

#[derive(Serialize)]
pub struct FoldReport {
    /// Faces that pass the test of GD01.
    pub gd01: usize,
    /// Faces that do not, but whose Jacobian was proved positive.
    pub positive: usize,
    /// Faces turned over somewhere.
    pub folded: usize,
    /// Faces of which neither was shown.
    pub undecided: usize,
    /// Least sine of the angle between a patch's parameter lines at 8 x 8 points: negative where it is turned over.
    pub least_sine: Option<f64>,
    /// The first that are turned over: number of the face, a point of its domain, and where that is.
    pub first: Vec<FoldPlace>,
}

#[derive(Serialize)]
pub struct FoldPlace {
    pub patch: usize,
    pub kind: &'static str,
    pub level: u32,
    pub u: f64,
    pub v: f64,
    pub position: [f64; 2],
}

impl FoldReport {
    pub fn new(found: &Folds, table: &PatchTable, zero: &Level) -> FoldReport {
        let place = |fold: &Fold| {
            let face = &table.faces[fold.face];
            FoldPlace {
                patch: fold.face,
                kind: kind_name(face.kind),
                level: face.level,
                u: fold.uv[0],
                v: fold.uv[1],
                position: fold.position,
            }
        };
        FoldReport {
            gd01: found.gd01,
            positive: found.positive,
            folded: found.folded.len(),
            undecided: found.undecided.len(),
            least_sine: folds::least_sine(table, zero, 8),
            first: found.folded.iter().take(10).map(place).collect(),
        }
    }

    pub fn text(&self) -> String {
        let mut text = format!(
            "  folds: {} faces turned over, {} undecided; {} injective by GD01, {} more with a positive Jacobian\n",
            self.folded, self.undecided, self.gd01, self.positive
        );
        if let Some(first) = self.first.first() {
            let [x, y] = first.position;
            text += &format!(
                "    first at {x:.6},{y:.6}, {} patch {} of level {} at u {:.4}, v {:.4}\n",
                first.kind, first.patch, first.level, first.u, first.v
            );
        }
        text
    }
}
