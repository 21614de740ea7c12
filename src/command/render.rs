//! `gradtess render`: a scene to a PNG, with counts and times.

use super::picture::{background, bounds, fit, size, view, CameraFlags, Tess};
use super::{open, print, print_json, Failure, Global, Refining};
use crate::gpu::{Format, Frame, Gpu, GpuTimes, Show, Statistics};
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
    /// Pixels across and down
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1024x1024")]
    size: [u32; 2],
    /// Model rectangle X0,Y0,X1,Y1 that fills the picture; the whole scene and two pixels unless given
    #[arg(long, value_parser = view, allow_hyphen_values = true)]
    view: Option<[f64; 4]>,
    #[command(flatten)]
    camera: CameraFlags,
    #[command(flatten)]
    tess: Tess,
    #[command(flatten)]
    refining: Refining,
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
        self.camera.refuse()?;
        let patched = loaded.patches(&self.refining)?;
        let view = match self.view {
            Some(v) => v,
            None => fit(bounds(&patched.table).unwrap_or([0.0, 0.0, 1.0, 1.0]), self.size)?,
        };
        let gpu = Gpu::new(&global.gpu())?;
        let table = gpu.upload(&patched.table)?;
        let frame = Frame {
            width: self.size[0],
            height: self.size[1],
            view,
            tess: self.tess.rule(),
            show: match self.show {
                ShowFlag::Surface => Show::Surface,
                ShowFlag::Wire => Show::Wire,
                ShowFlag::Patches => Show::Patches,
                ShowFlag::Levels => Show::Levels,
            },
            background: self.background.0,
            samples: self.samples,
            format: Format::Rgba8,
            statistics: global.json && gpu.device().without.is_empty(),
        };
        let drawn = gpu.render(&table, &frame)?;
        let times = drawn.times;
        let device = gpu.device().name.clone();
        let picture = drawn.pixels.into_picture(drawn.width, drawn.height);
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
            width: self.size[0],
            height: self.size[1],
            view,
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
        }
        Ok(())
    }
}
