//! `gradtess check` of a gradient mesh: cracks at T-sections, at the whole view and at random zooms.

use super::open::{rule, Ferguson};
use crate::check::sections::{cracks, outline};
use crate::command::Failure;
use crate::gpu::{Format, Frame, Gpu, Pixels, Show};
use crate::patch::tess::TessRule;
use indicatif::ProgressBar;
use serde::Serialize;

/// What was seen in all views.
#[derive(Serialize)]
pub struct Report {
    schema: &'static str,
    scene: String,
    technique: &'static str,
    views: usize,
    pixels_inside: usize,
    pub crack_pixels: usize,
    /// Where the first cracks are: x, y in the model.
    pub first_cracks: Vec<[f64; 2]>,
}

impl Report {
    /// A line for people.
    pub fn text(&self) -> String {
        format!(
            "{}: {} background pixels among {} inside, in {} views\n",
            self.scene, self.crack_pixels, self.pixels_inside, self.views
        )
    }
}

/// Draws every view by its rule and looks for background inside the outline.
pub fn run(
    ferguson: &Ferguson,
    gpu: &Gpu,
    views: &[([f64; 4], TessRule)],
    size: [u32; 2],
    bar: &ProgressBar,
) -> Result<Report, Failure> {
    let mut report = Report {
        schema: "gradtess.check/1",
        scene: ferguson.mesh.name.clone(),
        technique: "ferguson",
        views: views.len(),
        pixels_inside: 0,
        crack_pixels: 0,
        first_cracks: Vec::new(),
    };
    for &(view, tess) in views {
        let seen = look(ferguson, gpu, tess, view, size)?;
        report.pixels_inside += seen.inside;
        report.crack_pixels += seen.cracks.len();
        let room = 10 - report.first_cracks.len();
        report.first_cracks.extend(seen.cracks.into_iter().take(room));
        bar.inc(1);
    }
    Ok(report)
}

/// What one view showed.
struct Seen {
    /// Pixels inside the outline.
    inside: usize,
    /// Where background shows inside it, in the model.
    cracks: Vec<[f64; 2]>,
}

fn look(ferguson: &Ferguson, gpu: &Gpu, tess: TessRule, view: [f64; 4], size: [u32; 2]) -> Result<Seen, Failure> {
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
