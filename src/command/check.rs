//! `gradtess check`: how far the picture is from the limit, where the surface folds, and cracks, at the whole view and at
//! random zooms.

mod report;

use super::ferguson::open::{refuse, Ferguson};
use super::measure::{measure, ErrorReport, PlaceReport};
use super::open::{Loaded, Patched, Subject};
use super::pattern::flags::{level as pattern_level, PatternFlags};
use super::picture::{bounds, PictureFlags};
use super::surface::flags::SurfaceFlags;
use super::surface::open::Surface;
use super::{ferguson, print, print_json, silent, Failure, Global, Refining};
use crate::check::cracks::OutlineEdge;
use crate::check::folds::folds;
use crate::check::seams::seams;
use crate::check::{cracks, error_map};
use crate::gpu::{Format, Frame, Gpu, Pixels};
use crate::patch::cull::within;
use crate::patch::remap::Transitions;
use crate::patch::tess::{TessRule, MAX_LEVEL};
use crate::patch::PatchTable;
use crate::timing::random::Random;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use report::{CurvePoint, FoldReport, Report, SeamReport};
use std::path::PathBuf;

/// Arguments of `check`.
#[derive(Args)]
pub struct Check {
    /// Scene file
    scene: String,
    #[command(flatten)]
    picture: PictureFlags,
    /// Write the distance from the limit, magnified, as a plasma map; silhouettes and sharp edges grey
    #[arg(short, long, value_name = "MAP.png")]
    output: Option<PathBuf>,
    /// Magnification of the map: at 200, half a per cent is the brightest colour
    #[arg(long, value_name = "G", default_value_t = error_map::GAIN)]
    gain: f64,
    /// Further random views, magnified up to 1000 times (surfaces in space: random views from all sides)
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
    /// Greatest colour distance from the limit that is let pass, in per cent of sqrt 3
    #[arg(long, value_name = "P")]
    max_error: Option<f64>,
    /// Greatest mean colour distance that is let pass, in per cent of sqrt 3
    #[arg(long, value_name = "P")]
    max_mean: Option<f64>,
    /// Greatest distance of a patch's points from the limit that is let pass, in pixels
    #[arg(long, value_name = "PIXELS")]
    max_shift: Option<f64>,
    /// Faces that are let pass though they are, or may be, turned over
    #[arg(long, value_name = "N")]
    max_folds: Option<usize>,
    /// Read all vertices of the first view back, and count the edges inside whose two sides are not the same bits
    #[arg(long)]
    seams: bool,
    /// Measure the first view again with irregular faces refined 0 to N levels further: error against patches
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=8))]
    isolate_curve: Option<u32>,
    #[command(flatten)]
    surface: SurfaceFlags,
    #[command(flatten)]
    pattern: PatternFlags,
    /// A scripted flight of N frames: background within the outline
    #[arg(long, value_name = "N", help_heading = "Refinement patterns (BS05)")]
    fly: Option<u32>,
    /// A slow zoom of N frames: how much pixels change from one to the next
    #[arg(long, value_name = "N", help_heading = "Refinement patterns (BS05)")]
    slow_zoom: Option<u32>,
}

/// Level from 1 to `most`, the integer part of a log-uniform number.
fn random_level(unit: f64, most: f32) -> u32 {
    let top = f64::from(most) + 1.0;
    (top.powf(unit) as u32).clamp(1, most as u32)
}

/// Least and greatest of the fixed levels of views.
pub fn random_levels(views: &[([f64; 4], TessRule)]) -> [u32; 2] {
    let levels = views.iter().filter_map(|v| if let TessRule::Fixed(t) = v.1 { Some(t as u32) } else { None });
    levels.fold([MAX_LEVEL as u32, 1], |[low, high], t| [low.min(t), high.max(t)])
}

/// Progress over views, where it is wanted.
fn bar(views: usize, global: &Global) -> ProgressBar {
    let bar = if global.quiet || global.json { ProgressBar::hidden() } else { ProgressBar::new(views as u64) };
    bar.set_style(
        ProgressStyle::with_template("{bar:30} {pos}/{len} views, {eta} left")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    bar
}

/// Pixels unless `--size` says otherwise.
const SIZE: [u32; 2] = [512, 512];

impl Check {
    /// Draws and looks.
    pub fn run(&self, global: &Global) -> Result<(), Failure> {
        let subject = Subject::open(&self.scene, global)?;
        if !matches!(subject, Subject::Pattern(_)) {
            self.pattern.refuse()?;
            if self.fly.or(self.slow_zoom).is_some() {
                return Err(Failure::input(
                    "--fly and --slow-zoom go with scenes of technique pattern; leave them out",
                ));
            }
        }
        match subject {
            Subject::Subdivision(loaded) => {
                self.surface.refuse()?;
                self.subdivision(&loaded, global)
            }
            Subject::Ferguson(mesh) => {
                self.surface.refuse()?;
                refuse(&self.picture.refining)?;
                self.picture.refuse_transitions()?;
                self.sections(&mesh, global)
            }
            Subject::Surface(surface) => self.space(&surface, global),
            Subject::Pattern(mut pattern) => {
                self.picture.refuse_plane()?;
                self.surface.refuse()?;
                let measured = self.max_error.or(self.max_mean).or(self.max_shift).is_some();
                if measured || self.output.is_some() || self.max_folds.is_some() || self.random_tess {
                    return Err(Failure::input(
                        "refinement patterns are checked by --zooms and --seed; leave out the rest",
                    ));
                }
                self.pattern.apply(&mut pattern.scene)?;
                let request = super::pattern::check::Request {
                    level: pattern_level(&self.picture.refining, &pattern.scene)?,
                    views: self.zooms,
                    seed: self.seed,
                    size: self.picture.size.unwrap_or(SIZE),
                    fly: self.fly,
                    slow_zoom: self.slow_zoom,
                    method: self.pattern.method(),
                    detail: self.pattern.detail(self.picture.refining.level)?,
                    coarse: self.pattern.coarse(&pattern.scene),
                };
                super::pattern::check::run(&pattern.scene, &request, global)
            }
        }
    }

    /// Views to look at, the first and then the random ones in `whole`, and how finely each is drawn.
    fn views(&self, first: [f64; 4], whole: [f64; 4], most: f32) -> Vec<([f64; 4], TessRule)> {
        let mut random = Random::new(self.seed);
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
        let mut tess = || match self.random_tess {
            true => TessRule::Fixed(random_level(random.unit(), most) as f32),
            false => self.picture.tess.rule(),
        };
        views.into_iter().map(|view| (view, tess())).collect()
    }

    /// Cracks of a surface in space.
    fn space(&self, surface: &Surface, global: &Global) -> Result<(), Failure> {
        let measured =
            self.max_error.or(self.max_mean).or(self.max_shift).is_some() || self.isolate_curve.is_some() || self.seams;
        if measured || self.output.is_some() || self.max_folds.is_some() || self.random_tess {
            return Err(Failure::input(
                "surfaces in space are checked for cracks; leave out --output, --random-tess, --seams, --isolate-curve and every --max but --max-cracks",
            ));
        }
        let views = self.zooms.max(1);
        let (found, torn) =
            super::surface::check::run(surface, &self.surface, &self.picture, views, self.seed, global)?;
        match found.cracks as usize > self.max_cracks || torn > 0 {
            true => Err(Failure::short(format_args!(
                "{} background pixels inside the silhouette, {} pixels with a wrong side, {} with the surface beyond its silhouette, {torn} torn edges; at most {} pixels are let pass",
                found.background, found.swapped, found.outside, self.max_cracks
            ))),
            false => Ok(()),
        }
    }

    /// Cracks of a mesh whose patches are the surface itself.
    fn sections(&self, mesh: &Ferguson, global: &Global) -> Result<(), Failure> {
        let measured =
            self.max_error.or(self.max_mean).or(self.max_shift).is_some() || self.isolate_curve.is_some() || self.seams;
        if measured || self.output.is_some() || self.max_folds.is_some() {
            return Err(Failure::input(
                "patches of technique ferguson are the surface itself; leave out --output, --seams, --isolate-curve and every --max but --max-cracks",
            ));
        }
        self.picture.camera.refuse()?;
        let size = self.picture.size.unwrap_or(SIZE);
        let views = self.views(mesh.view(self.picture.view, size)?, mesh.bounds(), MAX_LEVEL);
        let gpu = Gpu::new(&global.gpu())?;
        let bar = bar(views.len(), global);
        let report = ferguson::check::run(mesh, &gpu, &views, size, &bar)?;
        bar.finish_and_clear();
        silent(&gpu)?;
        if global.json {
            print_json(&report)?;
        } else if !global.quiet {
            print(&report.text());
        }
        self.judge_cracks(report.crack_pixels, &report.first_cracks)
    }

    fn subdivision(&self, loaded: &Loaded, global: &Global) -> Result<(), Failure> {
        if self.isolate_curve.is_some() {
            // Flags that do not go with it are refused before anything is drawn.
            loaded.options(&Refining { isolate: 1, ..self.picture.refining.clone() })?;
        }
        let mut patched = loaded.patches(&self.picture.refining)?;
        patched.transitions = self.picture.transitions();
        let greatest = patched.transitions.greatest();
        let frame = Frame { format: Format::Rgba32f, ..self.picture.frame(&patched.table, SIZE)? };
        let boundary = cracks::boundary(&patched.table, &loaded.mesh);
        let gpu = Gpu::new(&global.gpu())?;
        // Parts of one face are needed together to draw it in one piece, so then the whole table is.
        let mut table = match patched.transitions {
            Transitions::Constellations => gpu.upload(&PatchTable::default())?,
            other => gpu.upload(&other.of(patched.table.clone()))?,
        };
        let views = self.views(frame.view, bounds(&patched.table).unwrap_or([0.0, 0.0, 1.0, 1.0]), greatest);
        let bar = bar(views.len(), global);
        let (width, height) = (frame.width, frame.height);
        let error = measure(&gpu, loaded, &patched, &frame)?;
        if let Some(path) = &self.output {
            let text = [("Software", concat!("gradtess ", env!("CARGO_PKG_VERSION")))];
            error_map::picture(&error.map, [width, height], self.gain).write_png(path, &text)?;
        }
        let zero = &patched.refinement.levels[0];
        let mut report = Report {
            schema: "gradtess.check/1",
            scene: loaded.scene.name.clone(),
            views: views.len(),
            pixels_inside: 0,
            crack_pixels: 0,
            random_levels: self.random_tess.then(|| random_levels(&views)),
            boundary_edges: boundary.len(),
            outline_edges: cracks::outline(&patched.table).len(),
            first_cracks: Vec::new(),
            error: ErrorReport::new(&error, &patched.table),
            seams: self.seam_report(&gpu, &patched, &frame, &boundary)?,
            isolate_curve: self.curve(&gpu, loaded, &frame)?,
            folds: FoldReport::new(&folds(&patched.table, zero), &patched.table, zero),
        };
        for (view, tess) in views {
            let frame = Frame { view, tess, ..frame.clone() };
            // Closely looked at, almost all of a large scene is outside. A pixel more: single precision may move points a little.
            let (dx, dy) = ((view[2] - view[0]) / f64::from(width), (view[3] - view[1]) / f64::from(height));
            let near = [view[0] - dx, view[1] - dy, view[2] + dx, view[3] + dy];
            if patched.transitions == Transitions::Constellations {
                gpu.update(&mut table, &within(&patched.table, near))?;
            }
            let covered: Vec<bool> = match gpu.render(&table, &frame)?.pixels {
                Pixels::Rgba32f(p) => p.chunks_exact(4).map(|p| p[3] > 0.0).collect(),
                Pixels::Rgba8(p) => p.chunks_exact(4).map(|p| p[3] > 0).collect(),
            };
            let segments = cracks::segments(&boundary, frame.tess, greatest, view, [width, height]);
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
        silent(&gpu)?;
        if global.json {
            print_json(&report)?;
        } else if !global.quiet {
            print(&format!(
                "{}: {} background pixels among {} inside, in {} views\n",
                report.scene, report.crack_pixels, report.pixels_inside, report.views
            ));
            print(&report.error.text());
            print(&report.seams.as_ref().map_or(String::new(), SeamReport::text));
            print(&report::curve_text(&report.isolate_curve));
            print(&report.folds.text());
        }
        self.judge(&report)
    }

    /// Counts the segments of the whole surface that do not pair, with `--seams`.
    fn seam_report(
        &self,
        gpu: &Gpu,
        patched: &Patched,
        frame: &Frame,
        boundary: &[OutlineEdge],
    ) -> Result<Option<SeamReport>, Failure> {
        if !self.seams {
            return Ok(None);
        }
        let table = gpu.upload(&patched.transitions.of(patched.table.clone()))?;
        let found = seams(&gpu.evaluate(&table, frame.tess, frame.scale())?);
        let most = patched.transitions.greatest();
        // The device finds lengths in pixels in single precision, so a level may round either way.
        let expected = [1.0 + 1e-5, 1.0 - 1e-5].map(|slack| {
            let tess = match frame.tess {
                TessRule::Pixels(pixels) => TessRule::Pixels(pixels * slack),
                other => other,
            };
            let segments = cracks::segments(boundary, tess, most, frame.view, [frame.width, frame.height]);
            segments.iter().filter(|[a, b]| a != b).count()
        });
        let on_boundary = found.open.clamp(expected[0], expected[1]);
        Ok(Some(SeamReport {
            segments: found.segments,
            boundary_segments: on_boundary,
            open_segments: found.open.abs_diff(on_boundary),
        }))
    }

    /// Error against patches over the levels of `--isolate-curve`; empty without it.
    fn curve(&self, gpu: &Gpu, loaded: &Loaded, frame: &Frame) -> Result<Vec<CurvePoint>, Failure> {
        let levels = self.isolate_curve.map_or(0..0, |most| 0..most + 1);
        levels
            .map(|isolate| {
                let mut patched = loaded.patches(&Refining { isolate, ..self.picture.refining.clone() })?;
                patched.transitions = self.picture.transitions();
                let error = measure(gpu, loaded, &patched, frame)?;
                Ok(CurvePoint {
                    isolate,
                    patches: patched.table.ranges.iter().map(|r| u64::from(r.count)).sum(),
                    faces: patched.table.faces.len(),
                    max_percent: (error.all.pixels > 0).then_some(error.all.max),
                    mean_percent: (error.all.pixels > 0).then_some(error.all.mean),
                    shift_pixels: error.shift,
                })
            })
            .collect()
    }

    fn judge_cracks(&self, found: usize, first: &[[f64; 2]]) -> Result<(), Failure> {
        match first.first().filter(|_| found > self.max_cracks) {
            None => Ok(()),
            Some([x, y]) => Err(Failure::short(format_args!(
                "{}: {found} background pixels inside the surface, the first at {x},{y}; at most {} are let pass",
                self.scene, self.max_cracks
            ))),
        }
    }

    /// Compares what was found with what is let pass.
    fn judge(&self, report: &Report) -> Result<(), Failure> {
        let scene = &self.scene;
        self.judge_cracks(report.crack_pixels, &report.first_cracks)?;
        if let Some(open) = report.seams.as_ref().map(|s| s.open_segments).filter(|&n| n > 0) {
            return Err(Failure::short(format_args!(
                "{scene}: {open} segments inside have not the same bits on both sides"
            )));
        }
        let error = &report.error;
        let place = |place: &Option<PlaceReport>| place.as_ref().map_or(String::new(), PlaceReport::text);
        let limits = [
            ("colour is {} % of sqrt 3 off the limit", self.max_error, error.max_percent, place(&error.worst)),
            ("colour is {} % of sqrt 3 off the limit on average", self.max_mean, error.mean_percent, String::new()),
            ("a patch is {} pixels off the limit", self.max_shift, Some(error.shift_pixels), place(&error.shift_at)),
        ];
        for (what, limit, value, at) in limits {
            let (Some(limit), Some(value)) = (limit, value) else { continue };
            if value.is_nan() || value > limit {
                let what = what.replace("{}", &value.to_string());
                let at = if at.is_empty() { at } else { format!(", at {at}") };
                return Err(Failure::short(format_args!("{scene}: {what}{at}; at most {limit} is let pass")));
            }
        }
        if let Some(limit) = self.max_folds.filter(|&n| report.folds.folded + report.folds.undecided > n) {
            let at = report.folds.first.first().map_or(String::new(), |f| {
                format!(", the first at {},{} (patch {})", f.position[0], f.position[1], f.patch)
            });
            return Err(Failure::short(format_args!(
                "{scene}: {} faces are turned over{at}, and {} may be; at most {limit} are let pass",
                report.folds.folded, report.folds.undecided
            )));
        }
        Ok(())
    }
}
