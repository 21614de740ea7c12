//! `gradtess check`: cracks, at the whole view and at random zooms.

use super::picture::{bounds, fit, size, view, Tess};
use super::{open, print, print_json, Failure, Global, Refining};
use crate::check::cracks;
use crate::gpu::{Format, Frame, Gpu, Pixels, Show};
use crate::patch::cull::within;
use crate::patch::tess::{TessRule, MAX_LEVEL};
use crate::patch::PatchTable;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

/// Arguments of `check`.
#[derive(Args)]
pub struct Check {
    /// Scene file
    scene: String,
    /// Pixels across and down
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "512x512")]
    size: [u32; 2],
    /// Model rectangle X0,Y0,X1,Y1 to look at first
    #[arg(long, value_parser = view, allow_hyphen_values = true)]
    view: Option<[f64; 4]>,
    #[command(flatten)]
    tess: Tess,
    #[command(flatten)]
    refining: Refining,
    /// Further random views, magnified up to 1000 times
    #[arg(long, value_name = "N", default_value_t = 8)]
    zooms: u32,
    /// Draw each view at a random level of its own, 1 to 64, each octave as likely as any other
    #[arg(long, conflicts_with_all = ["fixed", "base", "pixels"])]
    random_tess: bool,
    /// Seed of the random views and levels
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Background pixels inside that are let pass
    #[arg(long, value_name = "N", default_value_t = 0)]
    max_cracks: usize,
}

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    scene: String,
    views: usize,
    pixels_inside: usize,
    crack_pixels: usize,
    /// Least and greatest level of `--random-tess`.
    #[serde(skip_serializing_if = "Option::is_none")]
    random_levels: Option<[u32; 2]>,
    /// Edges of drawn faces on the boundary of the mesh.
    boundary_edges: usize,
    /// Edges that only one patch has: as many, if every other edge has the same control points on both sides.
    outline_edges: usize,
    /// Where the first cracks are: x, y in the model.
    first_cracks: Vec<[f64; 2]>,
}

/// A small generator with a full period (Steele, Lea, Flood 2014, "SplitMix64"): the same views on every machine.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Level from 1 to 64, the integer part of a log-uniform number.
fn random_level(unit: f64) -> u32 {
    let top = f64::from(MAX_LEVEL) + 1.0;
    (top.powf(unit) as u32).clamp(1, MAX_LEVEL as u32)
}

impl Check {
    /// Draws and looks.
    pub fn run(&self, global: &Global) -> Result<(), Failure> {
        let loaded = open::load(&self.scene, global)?;
        let patched = loaded.patches(&self.refining)?;
        let whole = bounds(&patched.table).unwrap_or([0.0, 0.0, 1.0, 1.0]);
        let first = match self.view {
            Some(v) => v,
            None => fit(whole, self.size)?,
        };
        let boundary = cracks::boundary(&patched.table, &loaded.mesh);
        let gpu = Gpu::new(&global.gpu())?;
        let mut table = gpu.upload(&PatchTable::default())?;
        let mut random = Random(self.seed);
        let mut views = vec![first];
        let (w, h) = (first[2] - first[0], first[3] - first[1]);
        for _ in 0..self.zooms {
            let zoom = 1000f64.powf(random.unit());
            let x = whole[0] + random.unit() * (whole[2] - whole[0]);
            let y = whole[1] + random.unit() * (whole[3] - whole[1]);
            let (dx, dy) = (0.5 * w / zoom, 0.5 * h / zoom);
            views.push([x - dx, y - dy, x + dx, y + dy]);
        }
        // After all views, so that the flag does not change them.
        let levels: Vec<u32> = views.iter().filter(|_| self.random_tess).map(|_| random_level(random.unit())).collect();
        let bar =
            if global.quiet || global.json { ProgressBar::hidden() } else { ProgressBar::new(views.len() as u64) };
        bar.set_style(
            ProgressStyle::with_template("{bar:30} {pos}/{len} views, {eta} left")
                .unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        let [width, height] = self.size;
        let mut report = Report {
            schema: "gradtess.check/1",
            scene: loaded.scene.name.clone(),
            views: views.len(),
            pixels_inside: 0,
            crack_pixels: 0,
            random_levels: levels.iter().min().zip(levels.iter().max()).map(|(&low, &high)| [low, high]),
            boundary_edges: boundary.len(),
            outline_edges: cracks::outline(&patched.table).len(),
            first_cracks: Vec::new(),
        };
        for (i, view) in views.into_iter().enumerate() {
            let frame = Frame {
                width,
                height,
                view,
                tess: levels.get(i).map_or(self.tess.rule(), |&level| TessRule::Fixed(level as f32)),
                show: Show::Surface,
                background: None,
                samples: 1,
                format: Format::Rgba32f,
                statistics: false,
            };
            // Closely looked at, almost all of a large scene is outside. A pixel more: single precision may move points a little.
            let (dx, dy) = ((view[2] - view[0]) / f64::from(width), (view[3] - view[1]) / f64::from(height));
            let near = [view[0] - dx, view[1] - dy, view[2] + dx, view[3] + dy];
            gpu.update(&mut table, &within(&patched.table, near))?;
            let covered: Vec<bool> = match gpu.render(&table, &frame)?.pixels {
                Pixels::Rgba32f(p) => p.chunks_exact(4).map(|p| p[3] > 0.0).collect(),
                Pixels::Rgba8(p) => p.chunks_exact(4).map(|p| p[3] > 0).collect(),
            };
            let segments = cracks::segments(&boundary, frame.tess, view, width, height);
            report.pixels_inside += cracks::winding(&segments, width, height).iter().filter(|&&n| n != 0).count();
            let found = cracks::find(&segments, &covered, width, height);
            report.crack_pixels += found.len();
            for [x, y] in found {
                if report.first_cracks.len() < 10 {
                    let unit = [(view[2] - view[0]) / f64::from(width), (view[3] - view[1]) / f64::from(height)];
                    report
                        .first_cracks
                        .push([view[0] + (f64::from(x) + 0.5) * unit[0], view[3] - (f64::from(y) + 0.5) * unit[1]]);
                }
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        if let Some(m) = gpu.messages().first() {
            return Err(Failure::machine(format_args!("the validation layer reports: {}: {}", m.id, m.text)));
        }
        if global.json {
            print_json(&report)?;
        } else if !global.quiet {
            print(&format!(
                "{}: {} background pixels among {} inside, in {} views\n",
                report.scene, report.crack_pixels, report.pixels_inside, report.views
            ));
        }
        if report.crack_pixels > self.max_cracks {
            let [x, y] = report.first_cracks[0];
            return Err(Failure::short(format_args!(
                "{}: {} background pixels inside the surface, the first at {x},{y}; at most {} are let pass",
                self.scene, report.crack_pixels, self.max_cracks
            )));
        }
        Ok(())
    }
}
