//! Patches cut until bilinear colour is close enough to their own, and viewers can be trusted with the pieces.
//!
//! A patch is cut into a grid of halves of halves, and patches along a whole edge are cut alike along it: some viewers turn
//! every piece into triangles of a fixed number (MuPDF: 8 by 8 pairs), and where pieces of different sizes meet, theirs
//! leave gaps a pixel wide.

use super::Bicubic;
use crate::ferguson::hermite::halves;
use crate::ferguson::mesh::tensor;
use crate::patch::eval::FACE_EDGES;
use crate::patch::space::Interpolation;
use glam::{DVec2, DVec4};
use std::collections::HashMap;

/// A bicubic piece with the colours of its corners A, B, C, D: sRGB, straight alpha, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Positions.
    pub geometry: [DVec2; 16],
    /// Colours.
    pub colours: [DVec4; 4],
}

/// Cells of a scene and how far their colours are from it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cells {
    /// The cells, patch by patch.
    pub all: Vec<Cell>,
    /// How many cells each patch has.
    pub counts: Vec<u32>,
    /// Greatest error of a colour channel, 0 to 1.
    pub error: f64,
    /// True: the error is a bound, from the hull of the Bezier points. False: it was sampled, where colours are of another
    /// space, premultiplied, out of range or flattened.
    pub proved: bool,
}

/// Halvings of a patch along each side that the search stops at.
const DEEPEST: u32 = 7;

/// Corner points of a net.
const CORNERS: [usize; 4] = [0, 3, 15, 12];

/// Greatest distance, as a part of the drawing's longer side, of a piece's lines from eight chords of theirs: a sixteenth
/// of a point on a page.
const FLAT: f64 = 1.0 / (16.0 * super::pdf::LONG_SIDE);

/// Greatest mixed second difference of the corners' colours: halves of squares an eighth of a piece wide, each with linear
/// colours, are at most a 256th of it off the bilinear ones. (Ghostscript was 0.21/255 off at 0.15.)
const TWIST: f64 = 0.05;

/// Cuts patches until their colours are bilinear to `tolerance`.
pub fn cells(patches: &[Bicubic], colour: Interpolation, tolerance: f64) -> Cells {
    let alone = |patch: &Bicubic| Stack { geometry: patch.geometry, sheets: vec![patch.colours], paper: false };
    cut_all(&patches.iter().map(alone).collect::<Vec<_>>(), colour, tolerance)
}

/// Cuts stacks of patches until what they show is bilinear to `tolerance`.
pub(super) fn cut_all(patches: &[Stack], colour: Interpolation, tolerance: f64) -> Cells {
    let mut depths: Vec<[u32; 2]> = {
        let flat = FLAT * size(patches);
        patches.iter().map(|patch| depth(patch, colour, tolerance, flat)).collect()
    };
    level(patches, &mut depths);
    let mut out = Cells { proved: true, ..Cells::default() };
    for (patch, depth) in patches.iter().zip(depths) {
        out.counts.push(1 << (depth[0] + depth[1]));
        for piece in grid(patch, depth) {
            let bent = Bent::of(&piece, colour);
            out.error = out.error.max(bent.error);
            out.proved &= bent.proved;
            out.all.push(Cell { geometry: piece.geometry, colours: corners(&piece, colour) });
        }
    }
    out
}

/// Patches of one geometry over one another, drawn as one.
#[derive(Clone, Debug)]
pub(super) struct Stack {
    pub geometry: [DVec2; 16],
    /// Colours from the bottom.
    pub sheets: Vec<[DVec4; 16]>,
    /// Whether there is white paper beneath. Otherwise there is one sheet.
    pub paper: bool,
}

impl Stack {
    /// What is seen where the sheets have the colours that `at` finds.
    fn shown(&self, colour: Interpolation, at: impl Fn(&[DVec4; 16]) -> DVec4) -> DVec4 {
        let seen = |sheet| colour.decode(at(sheet)).clamp(DVec4::ZERO, DVec4::ONE);
        if self.paper {
            return self.sheets.iter().map(seen).fold(DVec4::ONE, |below, c| {
                let rgb = below.truncate().lerp(c.truncate(), c.w);
                rgb.extend(1.0)
            });
        }
        seen(&self.sheets[0])
    }
}

/// The longer side of the rectangle around all points.
fn size(patches: &[Stack]) -> f64 {
    let all = || patches.iter().flat_map(|patch| patch.geometry);
    let (low, high) = (all().reduce(DVec2::min), all().reduce(DVec2::max));
    (high.unwrap_or_default() - low.unwrap_or_default()).max_element()
}

/// Halvings along u and v that a patch needs on its own.
fn depth(patch: &Stack, colour: Interpolation, tolerance: f64, flat: f64) -> [u32; 2] {
    let mut depth = [0, 0];
    loop {
        let mut along = [0.0f64; 2];
        for piece in grid(patch, depth) {
            let bent = Bent::of(&piece, colour);
            let [p, q, r, s] = corners(&piece, colour);
            let twist = (p - q + r - s).abs().max_element() / TWIST;
            // In parts of what is allowed.
            for (axis, bend) in bends(&piece.geometry).into_iter().enumerate() {
                // A cubic is at most 6/8 of its second differences off its chord; an eighth of it a 64th of that.
                along[axis] = along[axis].max(bend * 0.75 / 64.0 / flat.max(f64::MIN_POSITIVE)).max(twist);
            }
            if bent.error > tolerance {
                let (more, part) = (bent.along[0].max(bent.along[1]), bent.error / tolerance);
                for (need, bend) in along.iter_mut().zip(bent.along) {
                    // Off in the middle alone: either direction is as good.
                    *need = need.max(part * if more > 0.0 { bend / more } else { 1.0 });
                }
            }
        }
        if along[0].max(along[1]) <= 1.0 {
            return depth;
        }
        let worse = usize::from(along[1] > along[0]);
        let axis = if depth[worse] < DEEPEST { worse } else { 1 - worse };
        if depth[axis] >= DEEPEST {
            return depth;
        }
        depth[axis] += 1;
    }
}

/// Greatest second difference of a net's lines along u and along v.
fn bends(net: &[DVec2; 16]) -> [f64; 2] {
    let mut along = [0.0f64; 2];
    for line in 0..4 {
        for k in 0..2 {
            let (u, v) = (4 * line + k, line + 4 * k);
            along[0] = along[0].max((net[u] - net[u + 1] * 2.0 + net[u + 2]).length());
            along[1] = along[1].max((net[v] - net[v + 4] * 2.0 + net[v + 8]).length());
        }
    }
    along
}

/// Cuts both patches along an edge alike: an edge is known by its points, in either direction.
fn level(patches: &[Stack], depths: &mut [[u32; 2]]) {
    let key = |patch: &Stack, slots: [usize; 4]| {
        let q = slots.map(|i| patch.geometry[i].to_array().map(|x| (x + 0.0).to_bits()));
        let reversed = [q[3], q[2], q[1], q[0]];
        if q <= reversed {
            q
        } else {
            reversed
        }
    };
    let mut edges: HashMap<[[u64; 2]; 4], Vec<(usize, usize)>> = HashMap::new();
    for (p, patch) in patches.iter().enumerate() {
        for (side, slots) in FACE_EDGES.into_iter().enumerate() {
            edges.entry(key(patch, slots)).or_default().push((p, side % 2));
        }
    }
    let mut waiting: Vec<usize> = (0..patches.len()).collect();
    while let Some(p) = waiting.pop() {
        for (side, slots) in FACE_EDGES.into_iter().enumerate() {
            let most = depths[p][side % 2];
            for &(other, axis) in edges.get(&key(&patches[p], slots)).into_iter().flatten() {
                if depths[other][axis] < most {
                    depths[other][axis] = most;
                    waiting.push(other);
                }
            }
        }
    }
}

/// The pieces of a patch halved so often along u and v, row by row.
fn grid(patch: &Stack, depth: [u32; 2]) -> Vec<Stack> {
    let halve = |pieces: Vec<Stack>, axis: usize| -> Vec<Stack> {
        let both = |piece: Stack| {
            let geometry = cut(&piece.geometry, axis);
            let sheets: Vec<_> = piece.sheets.iter().map(|sheet| cut(sheet, axis)).collect();
            [0, 1].map(|half| Stack {
                geometry: geometry[half],
                sheets: sheets.iter().map(|both| both[half]).collect(),
                paper: piece.paper,
            })
        };
        pieces.into_iter().flat_map(both).collect()
    };
    let rows = (0..depth[1]).fold(vec![patch.clone()], |pieces, _| halve(pieces, 1));
    (0..depth[0]).fold(rows, |pieces, _| halve(pieces, 0))
}

fn corners(piece: &Stack, colour: Interpolation) -> [DVec4; 4] {
    CORNERS.map(|i| piece.shown(colour, |sheet| sheet[i]))
}

/// Halves of a net along u (axis 0) or v (axis 1).
fn cut<T: crate::ferguson::hermite::Linear>(net: &[T; 16], axis: usize) -> [[T; 16]; 2] {
    let (across, along) = if axis == 0 { (4, 1) } else { (1, 4) };
    let mut out = [*net; 2];
    for line in 0..4 {
        let at = |k: usize| line * across + k * along;
        let both = halves([net[at(0)], net[at(1)], net[at(2)], net[at(3)]], 0.5);
        for (half, q) in out.iter_mut().zip(both) {
            for (k, value) in q.into_iter().enumerate() {
                half[at(k)] = value;
            }
        }
    }
    out
}

/// How far the colours of a piece are from bilinear ones.
struct Bent {
    error: f64,
    proved: bool,
    /// Greatest bend along u and v: where to cut.
    along: [f64; 2],
}

impl Bent {
    fn of(piece: &Stack, colour: Interpolation) -> Bent {
        let c = &piece.sheets[0];
        let size = |x: DVec4| x.abs().max_element();
        let mut along = [0.0f64; 2];
        for line in 0..4 {
            for k in 0..2 {
                let (u, v) = (4 * line + k, line + 4 * k);
                along[0] = along[0].max(size(c[u] - c[u + 1] * 2.0 + c[u + 2]));
                along[1] = along[1].max(size(c[v] - c[v + 4] * 2.0 + c[v + 8]));
            }
        }
        let inside = c.iter().all(|c| c.min_element() >= 0.0 && c.max_element() <= 1.0);
        let opaque = || c.iter().all(|c| c.w >= 1.0);
        let polynomial = !piece.paper || (piece.sheets.len() == 1 && opaque());
        if colour == Interpolation::default() && inside && polynomial {
            // The difference from the bilinear patch is a Bezier patch, which lies in the hull of its points.
            let mut error = 0.0f64;
            for (i, value) in c.iter().enumerate() {
                let (u, v) = ((i % 4) as f64 / 3.0, (i / 4) as f64 / 3.0);
                error = error.max(size(*value - bilinear(CORNERS.map(|k| c[k]), u, v)));
            }
            return Bent { error, proved: true, along };
        }
        let ends = corners(piece, colour);
        let (mut error, mut at) = (0.0f64, [0.0f64; 2]);
        for (i, j) in (0..7).flat_map(|j| (0..7).map(move |i| (i, j))) {
            let (u, v) = (f64::from(i) / 6.0, f64::from(j) / 6.0);
            let far = size(piece.shown(colour, |sheet| tensor(sheet, u, v)) - bilinear(ends, u, v));
            error = error.max(far);
            if j == 0 || j == 6 {
                at[0] = at[0].max(far);
            }
            if i == 0 || i == 6 {
                at[1] = at[1].max(far);
            }
        }
        Bent { error, proved: false, along: at }
    }
}

fn bilinear(q: [DVec4; 4], u: f64, v: f64) -> DVec4 {
    (q[0] * (1.0 - u) + q[1] * u) * (1.0 - v) + (q[3] * (1.0 - u) + q[2] * u) * v
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ferguson::Mesh;

    fn ramp() -> Bicubic {
        let mesh = Mesh::grid(1, 1, [0.0, 0.0, 1.0, 1.0], |i, _| DVec4::new(f64::from(i), 0.5, 0.5, 1.0)).unwrap();
        Bicubic { geometry: mesh.geometry(0), colours: mesh.colours(0) }
    }

    #[test]
    fn a_smoothstep_is_cut_along_itself_only_and_the_bound_holds() {
        let patch = ramp();
        let cells = cells(&[patch], Interpolation::default(), 0.5 / 255.0);
        assert!(cells.proved && cells.error <= 0.5 / 255.0);
        // 20 pieces are the least; halving takes more, but none across.
        assert!((20..=64).contains(&cells.all.len()), "{}", cells.all.len());
        assert!(cells.all.iter().all(|c| c.geometry[0].y == 0.0 && c.geometry[12].y == 1.0));
        let mut worst = 0.0f64;
        for cell in &cells.all {
            for k in 0..=8 {
                let u = f64::from(k) / 8.0;
                let x = tensor(&cell.geometry, u, 0.3).x;
                let wanted = tensor(&patch.colours, x, 0.3);
                worst = worst.max((bilinear(cell.colours, u, 0.3) - wanted).abs().max_element());
            }
        }
        assert!(worst <= cells.error && worst > 0.1 * cells.error, "{worst} {}", cells.error);
    }

    #[test]
    fn neighbours_are_cut_alike_along_their_edge() {
        let (left, mut right) = (ramp(), ramp());
        // Across the edge between them, no colours that need cutting.
        for (i, at) in right.geometry.iter_mut().enumerate() {
            *at = left.geometry[i] + DVec2::new(1.0, 0.0);
        }
        let mut turned = ramp();
        // Its v runs along the u of `left`, above it.
        turned.geometry = std::array::from_fn(|i| left.geometry[4 * (i % 4) + i / 4] + DVec2::new(0.0, 1.0));
        turned.colours = [DVec4::ONE; 16];
        let alone = cells(&[turned], Interpolation::default(), 1e-3).all.len();
        let one = cells(&[left], Interpolation::default(), 1e-3).all.len();
        assert_eq!(alone, 1);
        assert_eq!(cells(&[left, turned], Interpolation::default(), 1e-3).all.len(), 2 * one);
        right.colours = [DVec4::ONE; 16];
        assert_eq!(cells(&[left, right], Interpolation::default(), 1e-3).all.len(), one + 1);
    }

    #[test]
    fn bilinear_colours_are_one_cell() {
        let mut patch = ramp();
        for (i, c) in patch.colours.iter_mut().enumerate() {
            c.x = (i % 4) as f64 / 3.0;
        }
        assert_eq!(cells(&[patch], Interpolation::default(), 1e-9).all.len(), 1);
    }
}
