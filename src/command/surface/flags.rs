//! Flags of subdivision surfaces and their shading.

use super::open::Surface;
use crate::command::open::at_line;
use crate::command::{Failure, Global, ModeFlag, Refining};
use crate::gpu::{SolidNormals, Tessellation};
use crate::patch::solid::Segments;
use crate::scene::read_bounded;
use crate::scene::surface::{sharp, SurfaceScene};
use crate::surface::level::{Level, Scheme};
use crate::surface::normal::ControlNormals;
use crate::surface::refine::levels;
use crate::surface::shade::{Geometric, Settings};
use crate::surface::triangulate::triangulate;
use crate::surface::weight::{Darts, Initial, Rules, Variant};
use crate::surface::SurfaceError;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

/// How a surface in space is subdivided and shaded. Other scenes take none of these.
#[derive(Args, Clone, Debug, Default, PartialEq)]
#[command(next_help_heading = "Surfaces in space (OBJ)")]
pub struct SurfaceFlags {
    /// Subdivision scheme [default: catmull-clark]
    #[arg(long, value_enum)]
    scheme: Option<SchemeFlag>,
    /// Cut polygons into triangles for --scheme loop
    #[arg(long)]
    triangulate: bool,
    /// File whose fs and as lines replace the scene's sharpness
    #[arg(long, value_name = "FILE.sharp")]
    sharp: Option<PathBuf>,
    /// First level with subdivided normals [default: 1]
    #[arg(long, value_name = "L", value_parser = clap::value_parser!(u32).range(1..))]
    normals_from: Option<u32>,
    /// First level with blend weights [default: 1]
    #[arg(long, value_name = "L")]
    weights_from: Option<u32>,
    /// Blend weights of sharp vertices: as smooth ones (a), or 0 (b) [default: b]
    #[arg(long, value_enum)]
    variant: Option<VariantFlag>,
    /// Blend weights of darts [default: smooth]
    #[arg(long, value_enum)]
    darts: Option<DartsFlag>,
    /// Control weights of extraordinary vertices [default: ring]
    #[arg(long, value_enum)]
    weights: Option<WeightsFlag>,
    /// Exponent p of the blend weight, 0.01 to 100 [default: 1]
    #[arg(long, value_name = "P")]
    power: Option<f64>,
    /// Geometric normals: of the limit surface, or means of the level's faces as in the authors' tool [default: limit]
    #[arg(long, value_enum)]
    geometric: Option<GeometricFlag>,
    /// Normals that subdivision starts with: the file's vn lines, or means of faces [default: given]
    #[arg(long, value_enum)]
    control_normals: Option<ControlFlag>,
    /// Move the vertices to the limit surface
    #[arg(long)]
    pub limit: bool,
    /// Normals that are drawn [default: blended]
    #[arg(long, value_enum)]
    normals: Option<NormalsFlag>,
    /// Stripes of --show highlight and reflection: the argument of the sine for a cosine of 1 [default: 30]
    #[arg(long, value_name = "N")]
    stripes: Option<f32>,
}

/// Which normals are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NormalsFlag {
    /// N_B
    Blended,
    /// N_L
    Geometric,
    /// N_S
    Subdivided,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum SchemeFlag {
    CatmullClark,
    Loop,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum VariantFlag {
    A,
    B,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum DartsFlag {
    Smooth,
    Sharp,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum WeightsFlag {
    /// 1 there and at all vertices of the faces around
    Ring,
    /// What makes the limit 1
    Inverse,
    /// 1 there only
    Vertex,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum GeometricFlag {
    Limit,
    Mesh,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum ControlFlag {
    Given,
    Faces,
}

/// The level asked for; other flags of patch refinement do not go with surfaces in space.
pub fn level(refining: &Refining) -> Result<Option<u32>, Failure> {
    match (Refining { level: None, ..refining.clone() }).is_default() {
        true => Ok(refining.level),
        false => Err(Failure::input(
            "--mode, --rules, --patches and --isolate go with gradient meshes; surfaces in space take --level, and --mode where they are drawn as patches",
        )),
    }
}

/// The last level of patches asked for, and whether all are of that level.
pub fn patch_level(refining: &Refining) -> Result<(Option<u32>, bool), Failure> {
    let depth = level(&Refining { mode: ModeFlag::Adaptive, ..refining.clone() })?;
    Ok((depth, refining.mode == ModeFlag::Global))
}

/// Levels of a surface and what they were made of.
pub struct Subdivided {
    /// The scene, cut into triangles if that was asked for.
    pub scene: SurfaceScene,
    /// Levels from 0 to the one asked for.
    pub levels: Vec<Level>,
}

impl SurfaceFlags {
    /// Refuses these flags for scenes of other techniques.
    pub fn refuse(&self) -> Result<(), Failure> {
        match *self == SurfaceFlags::default() {
            true => Ok(()),
            false => Err(Failure::input("flags of surfaces in space do not go with this scene; leave them out")),
        }
    }

    /// The normals asked for.
    pub fn normals(&self) -> NormalsFlag {
        self.normals.unwrap_or(NormalsFlag::Blended)
    }

    /// The stripes asked for.
    pub fn stripes(&self) -> Result<f32, Failure> {
        match self.stripes.unwrap_or(30.0) {
            n if (0.1..=1000.0).contains(&n) => Ok(n),
            n => Err(Failure::input(format_args!("--stripes {n} is out of range; give 0.1 to 1000"))),
        }
    }

    /// How patches are drawn with `segments` on their edges.
    pub fn tessellation(&self, segments: Option<Segments>) -> Result<Tessellation, Failure> {
        Ok(Tessellation {
            segments: segments.unwrap_or(Segments::Fixed(1)),
            normals: match self.normals() {
                NormalsFlag::Blended => SolidNormals::Blended,
                NormalsFlag::Geometric => SolidNormals::Geometric,
                NormalsFlag::Subdivided => SolidNormals::Subdivided,
            },
            power: self.settings()?.power as f32,
        })
    }

    /// The scheme asked for.
    pub fn scheme(&self) -> Scheme {
        match self.scheme {
            Some(SchemeFlag::Loop) => Scheme::Loop,
            _ => Scheme::CatmullClark,
        }
    }

    /// The shading asked for.
    pub fn settings(&self) -> Result<Settings, Failure> {
        let power = self.power.unwrap_or(1.0);
        if !(0.01..=100.0).contains(&power) {
            return Err(Failure::input(format_args!("--power {power} is out of range; give 0.01 to 100")));
        }
        let rules = Rules {
            initial: match self.weights {
                Some(WeightsFlag::Inverse) => Initial::Inverse,
                Some(WeightsFlag::Vertex) => Initial::Vertex,
                _ => Initial::Ring,
            },
            variant: if self.variant == Some(VariantFlag::A) { Variant::A } else { Variant::B },
            darts: if self.darts == Some(DartsFlag::Sharp) { Darts::Sharp } else { Darts::Smooth },
        };
        Ok(Settings {
            normals_from: self.normals_from.unwrap_or(1),
            weights_from: self.weights_from.unwrap_or(1),
            rules,
            power,
            geometric: match self.geometric {
                Some(GeometricFlag::Mesh) => Geometric::Mesh,
                _ => Geometric::Limit,
            },
            control: match self.control_normals {
                Some(ControlFlag::Faces) => ControlNormals::Faces,
                _ => ControlNormals::Given,
            },
            everywhere: false,
        })
    }

    /// Subdivides `surface` to level `depth`.
    pub fn subdivide(&self, surface: &Surface, depth: u32, global: &Global) -> Result<Subdivided, Failure> {
        let mut scene = surface.scene.clone();
        if let Some(path) = &self.sharp {
            let file = path.display().to_string();
            let before = scene.notes.len();
            sharp(&mut scene, &read_bounded(Path::new(path))?, &file)?;
            super::open::warn_once(&scene.notes[before..], global);
        }
        let mut cut_mesh = None;
        if self.triangulate {
            let (triangles, cut) = triangulate(&scene);
            if cut > 0 {
                global.warn(format_args!("{}: {cut} polygons were cut into triangles", surface.file));
                scene = triangles;
                cut_mesh = Some(super::open::polygons(&surface.file, &scene)?);
            }
        }
        let mesh = cut_mesh.as_ref().unwrap_or(&surface.mesh);
        let levels = levels(&scene, mesh, self.scheme(), depth).map_err(|e| failure(&surface.file, &e))?;
        Ok(Subdivided { scene, levels })
    }
}

fn failure(file: &str, e: &SurfaceError) -> Failure {
    match e.line() {
        Some(line) => at_line(file, line, e, "correct the scene"),
        None => Failure::input(e),
    }
}
