//! Patches cut until bilinear colour is close enough to their own.

use super::Bicubic;
use crate::ferguson::hermite::halves;
use crate::ferguson::mesh::tensor;
use crate::patch::space::Interpolation;
use glam::{DVec2, DVec4};

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
    /// Greatest error of a colour channel, 0 to 1.
    pub error: f64,
    /// True: the error is a bound, from the hull of the Bezier points. False: it was sampled, where colours are of another
    /// space, premultiplied or out of range.
    pub proved: bool,
}

/// Halvings of a patch along each side that the search stops at.
const DEEPEST: u32 = 7;

/// Corner points of a net.
const CORNERS: [usize; 4] = [0, 3, 15, 12];

/// Cuts patches until their colours are bilinear to `tolerance`.
pub fn cells(patches: &[Bicubic], colour: Interpolation, tolerance: f64) -> Cells {
    let mut out = Cells { proved: true, ..Cells::default() };
    for &patch in patches {
        let mut waiting = vec![(patch, [0, 0])];
        while let Some((piece, depth)) = waiting.pop() {
            let bent = Bent::of(&piece, colour);
            let along = usize::from(bent.along[1] > bent.along[0]);
            let axis = if depth[along] < DEEPEST { along } else { 1 - along };
            if bent.error <= tolerance || depth[axis] >= DEEPEST {
                out.error = out.error.max(bent.error);
                out.proved &= bent.proved;
                out.all.push(Cell { geometry: piece.geometry, colours: corners(&piece, colour) });
                continue;
            }
            let geometry = cut(&piece.geometry, axis);
            let colours = cut(&piece.colours, axis);
            let mut deeper = depth;
            deeper[axis] += 1;
            for half in [1, 0] {
                waiting.push((Bicubic { geometry: geometry[half], colours: colours[half] }, deeper));
            }
        }
    }
    out
}

fn shown(c: DVec4, colour: Interpolation) -> DVec4 {
    colour.decode(c).clamp(DVec4::ZERO, DVec4::ONE)
}

fn corners(piece: &Bicubic, colour: Interpolation) -> [DVec4; 4] {
    CORNERS.map(|i| shown(piece.colours[i], colour))
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
    fn of(piece: &Bicubic, colour: Interpolation) -> Bent {
        let c = &piece.colours;
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
        if colour == Interpolation::default() && inside {
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
            let far = size(shown(tensor(c, u, v), colour) - bilinear(ends, u, v));
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
    fn bilinear_colours_are_one_cell() {
        let mut patch = ramp();
        for (i, c) in patch.colours.iter_mut().enumerate() {
            c.x = (i % 4) as f64 / 3.0;
        }
        assert_eq!(cells(&[patch], Interpolation::default(), 1e-9).all.len(), 1);
    }
}
