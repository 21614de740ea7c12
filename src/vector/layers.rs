//! Which pieces of a drawing may share one mask.
//!
//! A soft mask knows one alpha a place, that of the piece that was drawn last. Pieces that lie over one another must
//! therefore be painted by masks of their own, or what is below a translucent piece would vanish with it. Pieces of one
//! component do not: folded patches are refused.

use super::cells::{Cell, Cells};
use crate::patch::PatchTable;
use glam::DVec2;
use std::collections::HashMap;

/// Corner points of a patch.
const CORNERS: [usize; 4] = [0, 3, 15, 12];

/// Of every patch its component: patches that share corner points in the table, counted in the order of their first ones.
/// For tables that share points through their indices wherever patches meet; time linear in the patches.
pub fn components(table: &PatchTable) -> Vec<u32> {
    let mut above: Vec<u32> = (0..table.faces.len() as u32).collect();
    fn top(above: &mut [u32], mut of: u32) -> u32 {
        while above[of as usize] != of {
            above[of as usize] = above[above[of as usize] as usize];
            of = above[of as usize];
        }
        of
    }
    let mut first_at: HashMap<u32, u32> = HashMap::new();
    for (patch, face) in table.faces.iter().enumerate() {
        for corner in CORNERS {
            let point = table.indices[face.first as usize + corner];
            let other = *first_at.entry(point).or_insert(patch as u32);
            let (a, b) = (top(&mut above, other), top(&mut above, patch as u32));
            above[a.max(b) as usize] = a.min(b);
        }
    }
    let mut number: HashMap<u32, u32> = HashMap::new();
    (0..above.len() as u32)
        .map(|patch| {
            let next = number.len() as u32;
            *number.entry(top(&mut above, patch)).or_insert(next)
        })
        .collect()
}

/// The cells in layers to be painted one over another; in one layer no two components lie over each other. `component`
/// has an entry a patch. An opaque drawing is one layer, since later pieces hide earlier ones; otherwise the time grows
/// with the square of the number of components.
pub fn layers(cells: &Cells, component: &[u32]) -> Vec<Vec<Cell>> {
    if cells.all.iter().flat_map(|cell| cell.colours).all(|c| c.w >= 1.0) {
        return vec![cells.all.clone()];
    }
    let mut out: Vec<Vec<Cell>> = Vec::new();
    let mut placed: Vec<Part> = Vec::new();
    let mut at = 0;
    let mut patch = 0;
    while patch < component.len() {
        let run = component[patch..].iter().take_while(|&&c| c == component[patch]).count();
        let count: usize = cells.counts[patch..patch + run].iter().map(|&n| n as usize).sum();
        let part = Part::of(component[patch], &cells.all[at..at + count]);
        // On top of everything that it lies over, at least as high as its own component.
        let layer = placed.iter().filter_map(|below| below.least_above(&part)).max().unwrap_or(0);
        if out.len() == layer {
            out.push(Vec::new());
        }
        out[layer].extend_from_slice(&cells.all[at..at + count]);
        match placed.iter_mut().find(|other| (other.layer, other.component) == (layer, part.component)) {
            Some(same) => (same.low, same.high) = (same.low.min(part.low), same.high.max(part.high)),
            None => placed.push(Part { layer, ..part }),
        }
        at += count;
        patch += run;
    }
    out
}

/// What a component has in a layer: the rectangle around it.
struct Part {
    component: u32,
    layer: usize,
    low: DVec2,
    high: DVec2,
}

impl Part {
    fn of(component: u32, cells: &[Cell]) -> Part {
        let all = || cells.iter().flat_map(|cell| cell.geometry);
        let (low, high) = (all().reduce(DVec2::min), all().reduce(DVec2::max));
        Part { component, layer: 0, low: low.unwrap_or(DVec2::INFINITY), high: high.unwrap_or(DVec2::NEG_INFINITY) }
    }

    /// The lowest layer that `above` may be in because of this part, which was drawn before.
    fn least_above(&self, above: &Part) -> Option<usize> {
        if self.component == above.component {
            return Some(self.layer);
        }
        let apart = self.high.cmplt(above.low).any() || above.high.cmplt(self.low).any();
        (!apart).then_some(self.layer + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patch::space::Interpolation;
    use crate::vector::{cells::cells, Bicubic};
    use glam::DVec4;

    fn square(x: f64, alpha: f64) -> Bicubic {
        let geometry = std::array::from_fn(|i| DVec2::new(x + (i % 4) as f64 / 3.0, (i / 4) as f64 / 3.0));
        Bicubic { geometry, colours: [DVec4::new(0.2, 0.4, 0.6, alpha); 16] }
    }

    fn of(squares: &[(f64, f64)], component: &[u32]) -> Vec<usize> {
        let patches: Vec<Bicubic> = squares.iter().map(|&(x, alpha)| square(x, alpha)).collect();
        let cells = cells(&patches, Interpolation::default(), 1e-3);
        layers(&cells, component).iter().map(Vec::len).collect()
    }

    #[test]
    fn only_what_lies_over_another_component_needs_a_layer_of_its_own() {
        assert_eq!(of(&[(0.0, 1.0), (0.5, 1.0)], &[0, 1]), [2], "opaque");
        assert_eq!(of(&[(0.0, 1.0), (0.5, 0.5)], &[0, 1]), [1, 1], "one over the other");
        assert_eq!(of(&[(0.0, 1.0), (2.0, 0.5)], &[0, 1]), [2], "side by side");
        assert_eq!(of(&[(0.0, 0.5), (1.0, 0.5)], &[0, 0]), [2], "of one component");
        assert_eq!(of(&[(0.0, 0.5), (0.5, 0.5), (0.0, 0.5)], &[0, 1, 0]), [1, 1, 1], "over what lies over its own");
        assert_eq!(of(&[(0.0, 0.5), (2.0, 0.5), (0.0, 0.5)], &[0, 1, 0]), [3], "its own does not count");
        assert_eq!(of(&[(0.0, 0.5), (0.5, 0.5), (1.0, 0.5), (9.0, 0.5)], &[0, 1, 2, 3]), [2, 1, 1], "three in a pile");
    }
}
