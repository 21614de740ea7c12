//! `gradtess render`: a scene to a PNG, with counts and times.

use super::measure::{measure, ErrorReport};
use super::picture::{background, PictureFlags};
use super::{open, print, print_json, Failure, Global};
use crate::check::error_map;
use crate::gpu::{Frame, Gpu, GpuTimes, Show, Statistics};
use crate::image::Picture;
use clap::{Args, ValueEnum};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Arguments of `render`.
#[derive(Args)]
pub struct Render {
    /// Scene file
    scene: String,
    /// Picture to write
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    #[command(flatten)]
    picture: PictureFlags,
    /// What the picture shows
    #[arg(long, value_enum, default_value = "surface")]
    show: ShowFlag,
    /// Colour under the surface: #rrggbb, or none for transparent
    #[arg(long, value_parser = background_flag, default_value = "none")]
    background: Ground,
    /// Samples a pixel: 1 or 4
    #[arg(long, default_value_t = 1)]
    samples: u32,
}

/// An optional colour, wrapped so that the flag parser does not take `None` for a missing flag.
#[derive(Clone, Copy, Debug)]
struct Ground(Option<[f32; 4]>);

fn background_flag(text: &str) -> Result<Ground, String> {
    background(text).map(Ground)
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ShowFlag {
    Surface,
    Wire,
    Patches,
    Levels,
    /// Distance from the limit surface, 200 times, as a plasma map
    Error,
}

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    scene: String,
    output: String,
    width: u32,
    height: u32,
    view: [f64; 4],
    device: String,
    patches: usize,
    control_points: usize,
    device_bytes: u64,
    refine_ms: f64,
    patch_ms: f64,
    cpu_ms: f64,
    record_ms: f64,
    submit_ms: f64,
    wait_ms: f64,
    gpu_frame_ms: Option<f64>,
    gpu: GpuTimes,
    statistics: Option<Statistics>,
    /// Of `--show error`.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<ErrorReport>,
}

impl Render {
    /// Draws.
    pub fn run(&self, global: &Global) -> Result<(), Failure> {
        if self.output.extension().is_none_or(|e| !e.eq_ignore_ascii_case("png")) {
            return Err(Failure::input(format_args!(
                "{}: only PNG is written; name the picture *.png",
                self.output.display()
            )));
        }
        // Drawing first and failing then would waste the user's time.
        if self.output.parent().is_some_and(|folder| folder != Path::new("") && !folder.is_dir()) {
            return Err(Failure::machine(format_args!(
                "{}: its folder does not exist; make it first",
                self.output.display()
            )));
        }
        let loaded = open::load(&self.scene, global)?;
        let patched = loaded.patches(&self.picture.refining)?;
        let gpu = Gpu::new(&global.gpu())?;
        let table = gpu.upload(&patched.table)?;
        let frame = Frame {
            show: match self.show {
                ShowFlag::Surface | ShowFlag::Error => Show::Surface,
                ShowFlag::Wire => Show::Wire,
                ShowFlag::Patches => Show::Patches,
                ShowFlag::Levels => Show::Levels,
            },
            background: self.background.0,
            samples: self.samples,
            statistics: global.json && gpu.device().without.is_empty(),
            ..self.picture.frame(&patched.table, [1024, 1024])?
        };
        let size = [frame.width, frame.height];
        let drawn = gpu.render(&table, &frame)?;
        let times = drawn.times;
        let device = gpu.device().name.clone();
        let (picture, error): (Picture, _) = match self.show {
            ShowFlag::Error => {
                let error = measure(&gpu, &loaded, &patched, &frame)?;
                let map = error_map::picture(&error.map, size, error_map::GAIN);
                (map, Some(ErrorReport::new(&error, &patched.table)))
            }
            _ => (drawn.pixels.into_picture(drawn.width, drawn.height), None),
        };
        let driver = gpu.device().driver.clone();
        picture.write_png(
            &self.output,
            &[("Software", concat!("gradtess ", env!("CARGO_PKG_VERSION"))), ("Comment", &driver)],
        )?;
        if let Some(m) = gpu.messages().first() {
            return Err(Failure::machine(format_args!("the validation layer reports: {}: {}", m.id, m.text)));
        }
        let ms = |ns: u64| open::milliseconds(ns.into());
        let result = Report {
            schema: "gradtess.render/1",
            scene: loaded.scene.name,
            output: self.output.display().to_string(),
            width: size[0],
            height: size[1],
            view: frame.view,
            device,
            patches: patched.table.faces.len(),
            control_points: patched.table.control.len(),
            device_bytes: table.bytes(),
            refine_ms: patched.refine_ms,
            patch_ms: patched.patch_ms,
            cpu_ms: patched.refine_ms + patched.patch_ms,
            record_ms: ms(times.record_ns),
            submit_ms: ms(times.submit_ns),
            wait_ms: ms(times.wait_ns),
            gpu_frame_ms: times.gpu.frame_ns.map(ms),
            gpu: times.gpu,
            statistics: drawn.statistics,
            error,
        };
        if global.json {
            return print_json(&result);
        }
        if !global.quiet {
            let frame = result.gpu_frame_ms.map_or("NA".to_string(), |t| format!("{t:.3}"));
            print(&format!(
                "{}: {} patches, {} x {}, refine {:.3} ms, patches {:.3} ms, GPU frame {frame} ms on {}\n",
                result.output,
                result.patches,
                result.width,
                result.height,
                result.refine_ms,
                result.patch_ms,
                result.device
            ));
            if let Some(error) = &result.error {
                print(&error.text());
            }
        }
        Ok(())
    }
}
