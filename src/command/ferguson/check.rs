//! `gradtess check` of a gradient mesh: cracks at T-sections, at the whole view and at random zooms.

use super::open::{rule, Ferguson};
use crate::check::sections::{cracks, outline};
use crate::command::Failure;
use crate::gpu::{Format, Frame, Gpu, Pixels, Show};
use crate::patch::tess::TessRule;

/// What one view showed.
pub struct Seen {
    /// Pixels inside the outline.
    pub inside: usize,
    /// Where background shows inside it, in the model.
    pub cracks: Vec<[f64; 2]>,
}

/// Draws one view and looks.
pub fn look(ferguson: &Ferguson, gpu: &Gpu, tess: TessRule, view: [f64; 4], size: [u32; 2]) -> Result<Seen, Failure> {
    let (fitted, table, target) = ferguson.patches(rule(tess)?, view, size);
    let table = gpu.upload(&crate::patch::cull::within(&table, view))?;
    let [width, height] = size;
    let frame = Frame {
        width,
        height,
        view,
        tess,
        // Flat: a colour without alpha is no crack.
        show: Show::Patches,
        background: None,
        samples: 1,
        format: Format::Rgba32f,
        statistics: false,
    };
    let covered: Vec<bool> = match gpu.render(&table, &frame)?.pixels {
        Pixels::Rgba32f(p) => p.chunks_exact(4).map(|p| p[3] > 0.0).collect(),
        Pixels::Rgba8(p) => p.chunks_exact(4).map(|p| p[3] > 0).collect(),
    };
    let (found, inside) = cracks(&outline(&fitted, &target, view, size), &covered, size);
    let unit = [(view[2] - view[0]) / f64::from(width), (view[3] - view[1]) / f64::from(height)];
    let place = |[x, y]: [u32; 2]| [view[0] + (f64::from(x) + 0.5) * unit[0], view[3] - (f64::from(y) + 0.5) * unit[1]];
    Ok(Seen { inside, cracks: found.into_iter().map(place).collect() })
}
