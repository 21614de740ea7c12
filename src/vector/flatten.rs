//! Transparency composed onto white paper before it is written, for readers and standards that have none (PDF/X-1a, PDF/A-1).
//!
//! A patch over paper, or over patches of the very same geometry, shows colours that are smooth in its own parameters: cells
//! are cut until those are bilinear. Over a part of another patch they jump at its outline; that is refused.

use super::cells::{cut_all, Cells, Stack};
use super::{Bicubic, VectorError};
use crate::patch::space::Interpolation;
use glam::DVec2;

/// Opaque cells that show what the patches show over white. `component` has an entry a patch; patches of one component do
/// not lie over one another. What is hidden or composed is not drawn again: it has no cells. The time grows with the patches
/// times the translucent ones, if there are several components.
///
/// # Errors
/// [`VectorError::Overlap`], by rectangles around the patches' points.
pub fn cells(
    patches: &[Bicubic],
    component: &[u32],
    colour: Interpolation,
    tolerance: f64,
) -> Result<Cells, VectorError> {
    let boxes: Vec<[DVec2; 2]> = patches.iter().map(around).collect();
    let several = component.iter().any(|c| *c != component[0]);
    let mut beneath: Vec<Vec<usize>> = vec![Vec::new(); patches.len()];
    let mut composed = vec![false; patches.len()];
    for (above, patch) in patches.iter().enumerate() {
        // Control points bound the alpha of the patch from below, in every space.
        if !several || patch.colours.iter().all(|c| c.w >= 1.0) {
            continue;
        }
        for below in 0..above {
            let apart = boxes[below][1].cmple(boxes[above][0]).any() || boxes[above][1].cmple(boxes[below][0]).any();
            if apart || component[below] == component[above] {
                continue;
            }
            if patches[below].geometry != patch.geometry {
                return Err(VectorError::Overlap { above, below });
            }
            beneath[above].push(below);
            composed[below] = true;
        }
    }
    let drawn = (0..patches.len()).filter(|&patch| !composed[patch]);
    let stack = |patch: usize| {
        let sheets = beneath[patch].iter().chain([&patch]).map(|&sheet| patches[sheet].colours).collect();
        Stack { geometry: patches[patch].geometry, sheets, paper: true }
    };
    Ok(cut_all(&drawn.map(stack).collect::<Vec<_>>(), colour, tolerance))
}

/// The rectangle around a patch's points: low and high corner.
fn around(patch: &Bicubic) -> [DVec2; 2] {
    let reduce = |least: fn(DVec2, DVec2) -> DVec2| patch.geometry.into_iter().fold(patch.geometry[0], least);
    [reduce(DVec2::min), reduce(DVec2::max)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec4;

    fn square(x: f64, colour: [f64; 4]) -> Bicubic {
        let geometry = std::array::from_fn(|i| DVec2::new(x + (i % 4) as f64 / 3.0, (i / 4) as f64 / 3.0));
        Bicubic { geometry, colours: [DVec4::from(colour); 16] }
    }

    fn flat(squares: &[Bicubic]) -> Result<Cells, VectorError> {
        let component: Vec<u32> = (0..squares.len() as u32).collect();
        cells(squares, &component, Interpolation::default(), 1e-3)
    }

    #[test]
    fn flat_sheets_over_white_are_what_over_says() {
        let (red, blue) = (square(0.0, [1.0, 0.0, 0.0, 0.5]), square(0.0, [0.0, 0.0, 1.0, 0.25]));
        let one = flat(&[red]).unwrap();
        assert_eq!(one.all[0].colours, [DVec4::new(1.0, 0.5, 0.5, 1.0); 4]);
        let two = flat(&[red, blue]).unwrap();
        assert_eq!((two.all.len(), two.all[0].colours), (1, [DVec4::new(0.75, 0.375, 0.625, 1.0); 4]));
    }

    #[test]
    fn the_product_of_a_ramp_of_colour_and_one_of_alpha_is_cut_until_bilinear() {
        let mut patch = square(0.0, [0.0; 4]);
        for (i, c) in patch.colours.iter_mut().enumerate() {
            let u = (i % 4) as f64 / 3.0;
            *c = DVec4::new(1.0 - u, 0.0, 0.0, u);
        }
        // 1 - u^2 in red: n pieces are off by at most 1/(4 n^2).
        let cells = flat(&[patch]).unwrap();
        assert!(!cells.proved && cells.error <= 1e-3 && cells.error > 0.1e-3, "{}", cells.error);
        assert_eq!(cells.all.len(), 16);
        for cell in &cells.all {
            for k in [0, 1] {
                let x = cell.geometry[3 * k].x;
                assert!((cell.colours[k].x - (1.0 - x * x)).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn translucent_patches_over_a_part_of_others_are_refused() {
        let (opaque, clear) = ([0.2, 0.4, 0.6, 1.0], [0.2, 0.4, 0.6, 0.5]);
        let refused = flat(&[square(0.0, opaque), square(0.5, clear)]).unwrap_err();
        assert_eq!(refused, VectorError::Overlap { above: 1, below: 0 });
        assert!(flat(&[square(0.0, clear), square(0.5, opaque)]).is_ok(), "opaque ones hide");
        assert!(flat(&[square(0.0, clear), square(1.0, clear)]).is_ok(), "side by side");
    }
}
