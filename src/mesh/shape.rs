//! Faces whose shape the technique does not promise to draw without folds.

use super::HalfEdgeMesh;

/// Something about a face that is legal but has consequences.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ShapeNote {
    /// Not convex: its Catmull-Clark surface may fold over its own edge (ZHHK22 7.1).
    NonConvex {
        /// Face, from 0.
        face: u32,
    },
    /// No area: the surface collapses there.
    NoArea {
        /// Face, from 0.
        face: u32,
    },
    /// Turns the other way round in the plane than most faces: it lies over its neighbours.
    Reversed {
        /// Face, from 0.
        face: u32,
    },
}

impl std::fmt::Display for ShapeNote {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            ShapeNote::NonConvex { face } => {
                write!(out, "face {} is not convex; its surface may fold over, split it into convex faces", face + 1)
            }
            ShapeNote::NoArea { face } => write!(out, "face {} has no area; nothing of it will be seen", face + 1),
            ShapeNote::Reversed { face } => {
                write!(out, "face {} is turned over against most others; it will cover its neighbours", face + 1)
            }
        }
    }
}

/// All notes on the faces of `mesh`, in face order.
pub fn shape_notes(mesh: &HalfEdgeMesh) -> Vec<ShapeNote> {
    let corner = |h: u32| mesh.positions[mesh.origin[h as usize] as usize];
    let area = |f: u32| -> f64 {
        let (a, b) = (mesh.face_start[f as usize], mesh.face_start[f as usize + 1]);
        (a..b).map(|h| (corner(h) - corner(a)).perp_dot(corner(mesh.next(h)) - corner(a))).sum::<f64>()
    };
    let areas: Vec<f64> = (0..mesh.faces()).map(area).collect();
    let turned = areas.iter().map(|a| a.signum()).sum::<f64>().signum();
    let mut notes = Vec::new();
    for (f, &area) in areas.iter().enumerate() {
        let face = f as u32;
        if area == 0.0 {
            notes.push(ShapeNote::NoArea { face });
            continue;
        }
        if area * turned < 0.0 {
            notes.push(ShapeNote::Reversed { face });
        }
        let bent = (mesh.face_start[f]..mesh.face_start[f + 1]).any(|h| {
            let (p, n) = (corner(mesh.prev(h)), corner(mesh.next(h)));
            (corner(h) - p).perp_dot(n - corner(h)) * area.signum() < 0.0
        });
        if bent {
            notes.push(ShapeNote::NonConvex { face });
        }
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::InputMesh;
    use glam::DVec2;

    #[test]
    fn an_arrowhead_is_not_convex_and_a_square_is_fine() {
        let at = |points: &[[f64; 2]]| InputMesh {
            positions: points.iter().map(|&p| DVec2::from(p)).collect(),
            corners: vec![0, 1, 2, 3],
            face_start: vec![0, 4],
            face_line: vec![],
        };
        let arrow = super::super::build(&at(&[[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]])).unwrap();
        assert_eq!(shape_notes(&arrow), [ShapeNote::NonConvex { face: 0 }]);
        let square = super::super::build(&at(&[[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]])).unwrap();
        assert!(shape_notes(&square).is_empty());
        let flat = super::super::build(&at(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])).unwrap();
        assert_eq!(shape_notes(&flat), [ShapeNote::NoArea { face: 0 }]);
    }
}
