//! `gradtess render`: a scene to a PNG, with counts and times.

use super::ferguson::open::refuse;
use super::measure::{measure, ErrorReport};
use super::open::{self, Subject};
use super::pattern::flags::{level as pattern_level, PatternFlags};
use super::picture::{background, deliver, PictureFlags};
use super::surface::flags::SurfaceFlags;
use super::surface::render::{Canvas, Look};
use super::{ferguson, print, print_json, surface, Failure, Global};
use crate::check::error_map;
use crate::check::picture_error::PictureError;
use crate::gpu::{Frame, Gpu, GpuTimes, PatternShow, Show, SolidShow, Statistics};
use crate::image::Picture;
use crate::patch::remap::Transitions;
use crate::patch::PatchTable;
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
    #[command(flatten)]
    surface: SurfaceFlags,
    #[command(flatten)]
    pattern: PatternFlags,
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
    /// Lit (surfaces in space; as are the rest)
    Shaded,
    /// Stripes by the normal's direction: isophotes
    Highlight,
    /// Stripes by the direction of the mirrored view
    Reflection,
    /// Normals as colours
    Normals,
    /// Blend weights from blue (0) to red (1)
    Weights,
    /// The control mesh, sharp edges orange to red
    Control,
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
    /// Draw calls, unless the device needs them in pieces.
    draws: usize,
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

/// Pixels unless `--size` says otherwise.
const SIZE: [u32; 2] = [1024, 1024];

/// What a technique has made of its scene.
struct Made<'a> {
    name: &'a str,
    table: &'a PatchTable,
    transitions: Transitions,
    frame: Frame,
    refine_ms: f64,
    patch_ms: f64,
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
        let subject = Subject::open(&self.scene, global)?;
        if !matches!(subject, Subject::Pattern(_)) {
            self.pattern.refuse()?;
        }
        match subject {
            Subject::Subdivision(loaded) => {
                self.refuse_space()?;
                let mut patched = loaded.patches(&self.picture.refining)?;
                patched.transitions = self.picture.transitions();
                let made = Made {
                    transitions: patched.transitions,
                    name: &loaded.scene.name,
                    table: &patched.table,
                    frame: self.picture.frame(&patched.table, SIZE)?,
                    refine_ms: patched.refine_ms,
                    patch_ms: patched.patch_ms,
                };
                self.draw(&made, |gpu, frame| measure(gpu, &loaded, &patched, frame), global)
            }
            Subject::Ferguson(mesh) => {
                self.refuse_space()?;
                refuse(&self.picture.refining)?;
                self.picture.refuse_transitions()?;
                let exact = || Failure::input("--show error: patches of this technique are the surface itself");
                if matches!(self.show, ShowFlag::Error) {
                    return Err(exact());
                }
                let size = self.picture.size.unwrap_or(SIZE);
                let patches = ferguson::render::patches(&mesh, self.picture.tess.rule(), self.picture.view, size)?;
                let made = Made {
                    transitions: Transitions::default(),
                    name: &mesh.mesh.name,
                    table: &patches.table,
                    frame: Frame { view: patches.view, ..self.picture.frame(&patches.table, SIZE)? },
                    refine_ms: patches.fit_ms,
                    patch_ms: patches.table_ms,
                };
                self.draw(&made, |_, _| Err(exact()), global)
            }
            Subject::Surface(surface) => {
                let canvas = Canvas {
                    picture: &self.picture,
                    output: &self.output,
                    background: self.background.0,
                    samples: self.samples,
                };
                surface::render::run(&surface, &self.surface, self.look()?, &canvas, global)
            }
            Subject::Pattern(mut pattern) => {
                self.picture.refuse_plane()?;
                self.surface.refuse()?;
                self.pattern.apply(&mut pattern.scene)?;
                let canvas = super::pattern::render::Canvas {
                    picture: &self.picture,
                    output: &self.output,
                    show: match self.show {
                        ShowFlag::Surface | ShowFlag::Shaded => PatternShow::Shaded,
                        ShowFlag::Normals => PatternShow::Normals,
                        ShowFlag::Wire => PatternShow::Wire,
                        _ => return Err(Failure::input("refinement patterns have --show surface, wire and normals")),
                    },
                    method: self.pattern.method(),
                    grid: self.pattern.grid_pattern,
                    level: pattern_level(&self.picture.refining, &pattern.scene)?,
                    background: self.background.0,
                    samples: self.samples,
                    detail: self.pattern.detail(self.picture.refining.level)?,
                    coarse: self.pattern.coarse(&pattern.scene),
                };
                super::pattern::render::run(&pattern.scene, &canvas, global)
            }
        }
    }

    /// What of a surface in space is shown.
    fn look(&self) -> Result<Look, Failure> {
        Ok(match self.show {
            ShowFlag::Surface | ShowFlag::Shaded => Look::Surface(SolidShow::Shaded),
            ShowFlag::Highlight => Look::Surface(SolidShow::Highlight),
            ShowFlag::Reflection => Look::Surface(SolidShow::Reflection),
            ShowFlag::Normals => Look::Surface(SolidShow::Normals),
            ShowFlag::Weights => Look::Surface(SolidShow::Weights),
            ShowFlag::Wire => Look::Mesh,
            ShowFlag::Control => Look::Control,
            ShowFlag::Patches | ShowFlag::Levels | ShowFlag::Error => {
                return Err(Failure::input("--show patches, levels and error go with gradient meshes"))
            }
        })
    }

    /// Refuses what only surfaces in space take.
    fn refuse_space(&self) -> Result<(), Failure> {
        self.surface.refuse()?;
        match self.show {
            ShowFlag::Surface | ShowFlag::Wire | ShowFlag::Patches | ShowFlag::Levels | ShowFlag::Error => Ok(()),
            _ => Err(Failure::input(
                "this --show goes with surfaces in space; use surface, wire, patches, levels or error",
            )),
        }
    }

    /// Draws what a technique has made; `measure` is for `--show error`.
    fn draw(
        &self,
        made: &Made,
        measure: impl FnOnce(&Gpu, &Frame) -> Result<PictureError, Failure>,
        global: &Global,
    ) -> Result<(), Failure> {
        let gpu = Gpu::new(&global.gpu())?;
        let table = match made.transitions {
            Transitions::Constellations => gpu.upload(made.table)?,
            other => gpu.upload(&other.of(made.table.clone()))?,
        };
        let frame = Frame {
            show: match self.show {
                ShowFlag::Wire => Show::Wire,
                ShowFlag::Patches => Show::Patches,
                ShowFlag::Levels => Show::Levels,
                // The error's picture is made elsewhere; the rest was refused.
                _ => Show::Surface,
            },
            background: self.background.0,
            samples: self.samples,
            statistics: global.json && gpu.device().without.is_empty(),
            ..made.frame.clone()
        };
        let size = [frame.width, frame.height];
        let drawn = gpu.render(&table, &frame)?;
        let times = drawn.times;
        let device = gpu.device().name.clone();
        let (picture, error): (Picture, _) = match self.show {
            ShowFlag::Error => {
                let error = measure(&gpu, &frame)?;
                let map = error_map::picture(&error.map, size, error_map::GAIN);
                (map, Some(ErrorReport::new(&error, made.table)))
            }
            _ => (drawn.pixels.into_picture(drawn.width, drawn.height), None),
        };
        deliver(&picture, &self.output, &gpu)?;
        let ms = |ns: u64| open::milliseconds(ns.into());
        let result = Report {
            schema: "gradtess.render/1",
            scene: made.name.to_owned(),
            output: self.output.display().to_string(),
            width: size[0],
            height: size[1],
            view: frame.view,
            device,
            patches: made.table.faces.len(),
            draws: table.ranges().len(),
            control_points: made.table.control.len(),
            device_bytes: table.bytes(),
            refine_ms: made.refine_ms,
            patch_ms: made.patch_ms,
            cpu_ms: made.refine_ms + made.patch_ms,
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
