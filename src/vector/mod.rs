//! Pictures as patches for other programs: bicubics with bilinear colours, which is what PDF knows.

pub mod cells;
pub mod flatten;
pub mod layers;
pub mod pdf;

use crate::patch::build::face_control;
use crate::patch::{eval, ControlPoint, Kind, PatchTable};
use glam::{DVec2, DVec4};

/// A bicubic patch with bicubic colours, Bezier points in the order of [`crate::patch`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bicubic {
    /// Positions.
    pub geometry: [DVec2; 16],
    /// Colours, in whatever the table's channels mean.
    pub colours: [DVec4; 16],
}

/// Why a scene cannot be exported.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VectorError {
    /// A patch is turned over somewhere: viewers disagree about what is on top.
    #[error(
        "patch {patch} folds over near {x:.6},{y:.6}, which viewers draw in different ways; unfold it, or write a PNG"
    )]
    Folded {
        /// Number of the drawn face.
        patch: usize,
        /// Where.
        x: f64,
        /// Where.
        y: f64,
    },
    /// A translucent patch lies over another of a different outline: its colours jump there, and no patch has that.
    #[error(
        "patch {above} is translucent and lies over part of patch {below}; --flatten composes only patches of one \
         outline: leave it out (the page is then transparent), or write a PNG"
    )]
    Overlap {
        /// Number of the drawn face on top.
        above: usize,
        /// Number of the one beneath.
        below: usize,
    },
    /// Nothing to draw, or coordinates that no page has room for.
    #[error("the scene has no area to put on a page; give it patches of moderate size")]
    Empty,
}

/// Greatest distance of the bicubics from the patches that they stand for: 0 unless there are Gregory patches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Conversion {
    /// Gregory patches converted.
    pub gregory: usize,
    /// Of the position, model units.
    pub position: f64,
    /// Of a colour channel.
    pub colour: f64,
}

/// The drawn faces as bicubics. Of a Gregory patch the two inner points of each corner are replaced by their mean; the
/// error is measured at 9 by 9 points.
pub fn bicubics(table: &PatchTable) -> (Vec<Bicubic>, Conversion) {
    let mut conversion = Conversion::default();
    let mut all = Vec::with_capacity(table.faces.len());
    for face in &table.faces {
        let control = face_control(table, face);
        let mut net: Vec<ControlPoint> = control[..16].to_vec();
        if face.kind == Kind::Gregory {
            conversion.gregory += 1;
            for (plus, minus) in [(5, 16), (6, 17), (10, 18), (9, 19)] {
                net[plus] = std::array::from_fn(|c| 0.5 * (control[plus][c] + control[minus][c]));
            }
            for (i, j) in (0..9).flat_map(|j| (0..9).map(move |i| (i, j))) {
                let (u, v) = (f64::from(i) / 8.0, f64::from(j) / 8.0);
                let (a, b) = (eval::face(Kind::Gregory, &control, u, v), eval::face(Kind::Bicubic, &net, u, v));
                conversion.position = conversion.position.max((a[0] - b[0]).hypot(a[1] - b[1]));
                for c in 4..8 {
                    conversion.colour = conversion.colour.max((a[c] - b[c]).abs());
                }
            }
        }
        all.push(Bicubic {
            geometry: std::array::from_fn(|i| DVec2::new(net[i][0], net[i][1])),
            colours: std::array::from_fn(|i| DVec4::new(net[i][4], net[i][5], net[i][6], net[i][7])),
        });
    }
    (all, conversion)
}

/// The first patch that is turned over somewhere.
pub fn folded(patches: &[Bicubic]) -> Option<VectorError> {
    use crate::check::folds::{jacobian, jacobian_sign, JacobianSign};
    patches.iter().enumerate().find_map(|(patch, bicubic)| {
        let net: Vec<ControlPoint> =
            bicubic.geometry.iter().map(|p| [p.x, p.y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]).collect();
        let at = [(0.5, 0.5), (0.2, 0.3), (0.8, 0.6)];
        let sum: f64 = at.iter().map(|&(u, v)| jacobian(Kind::Bicubic, &net, u, v)).sum();
        let orientation = if sum < 0.0 { -1.0 } else { 1.0 };
        match jacobian_sign(Kind::Bicubic, &net, orientation, 1000) {
            // A collapsed side has a Jacobian of 0 and is no fold.
            JacobianSign::Folded([u, v])
                if orientation * jacobian(Kind::Bicubic, &net, u, v) < -1e-9 * (sum.abs() / 3.0).max(1e-300) =>
            {
                let uv = [u, v];
                let p = eval::face(Kind::Bicubic, &net, uv[0], uv[1]);
                Some(VectorError::Folded { patch, x: p[0], y: p[1] })
            }
            _ => None,
        }
    })
}
