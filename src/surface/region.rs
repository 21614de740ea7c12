//! Regions at sharp vertices (ZBK23 3.4, Fig. 6): wedges.

use super::level::Level;
use crate::mesh::NONE;

/// The pairs of vertex and region of a level. The first region of vertex `v` is wedge `v`; further ones follow the
/// vertices.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Wedges {
    /// Wedge at the origin of each half-edge, in the region of its face.
    pub of: Vec<u32>,
    /// Of each wedge, the half-edge that leaves its vertex where its region begins counter-clockwise.
    pub first: Vec<u32>,
}

impl Wedges {
    /// The regions of `level` between the edges of which `cuts` (one an edge) holds. A vertex with one such edge inside
    /// the surface, a dart, is one region.
    pub fn new<T>(level: &Level, cuts: &[T], is: impl Fn(&T) -> bool) -> Wedges {
        let mut wedges = Wedges { of: level.origin.clone(), first: level.spoke.clone() };
        let count = level.count_edges(cuts, &is);
        let cut = |h: u32| is(&cuts[level.edge[h as usize] as usize]);
        for (v, &cuts_here) in count.iter().enumerate() {
            let boundary = level.twin[level.spoke[v] as usize] == NONE;
            // Boundary edges count as cuts.
            if cuts_here < if boundary { 3 } else { 2 } {
                continue;
            }
            // Inside, the fan may begin in the middle of a region: turn to a cut first.
            let first = level.fan(v as u32).find(|&h| cut(h)).unwrap_or(level.spoke[v]);
            let (mut h, mut wedge) = (first, v as u32);
            loop {
                if h == first {
                    wedges.first[v] = h;
                } else if cut(h) {
                    wedge = wedges.first.len() as u32;
                    wedges.first.push(h);
                }
                wedges.of[h as usize] = wedge;
                match level.spoke_after(h) {
                    Some(g) if g != first => h = g,
                    _ => break,
                }
            }
        }
        wedges
    }

    /// The wedges that a level is drawn with, unless every vertex has only one.
    pub fn several(level: &Level) -> Option<Wedges> {
        let mut borders = level.border_edges.iter().enumerate().filter(|(_, &n)| n > 1);
        let several = borders.any(|(v, &n)| n > 2 || !level.on_boundary(v as u32));
        several.then(|| Wedges::drawn(level))
    }

    /// The wedges that a level is drawn with.
    pub fn drawn(level: &Level) -> Wedges {
        Wedges::new(level, &level.border, |&b| b)
    }

    /// The wedges that the next step keeps apart: fewer than are drawn where a crease has decayed.
    pub fn live(level: &Level) -> Wedges {
        Wedges::new(level, &level.sharpness, |&s| s > 0.0)
    }

    /// Wedges.
    pub fn len(&self) -> usize {
        self.first.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.first.is_empty()
    }
}
