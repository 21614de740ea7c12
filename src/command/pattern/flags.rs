//! Flags of refinement patterns.

use crate::command::{Failure, Refining};
use crate::gpu::PatternMethod;
use crate::pattern::detail::{Scope, MOST};
use crate::pattern::lattice::MAX_LEVEL;
use crate::pattern::{CoarseMesh, Detail, Evaluator, NormalField};
use crate::scene::pattern::PatternScene;
use clap::{Args, ValueEnum};

/// How a coarse mesh is refined by patterns. Other scenes take none of these.
#[derive(Args, Clone, Debug, Default, PartialEq)]
#[command(next_help_heading = "Refinement patterns (BS05)")]
pub struct PatternFlags {
    /// What a coarse triangle becomes; the scene says unless given
    #[arg(long, value_enum)]
    evaluator: Option<EvaluatorFlag>,
    /// Normals of curved triangles: factor 2 (Vlachos et al.), factor 4 as BS05 prints it, or linear
    #[arg(long, value_enum)]
    normal_field: Option<FieldFlag>,
    /// Time of animated displacement
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    time: Option<f64>,
    /// How the refined mesh is drawn [default: instanced]
    #[arg(long, value_enum)]
    method: Option<MethodFlag>,
    /// The grid pattern of Fig. 7 instead of the triangular one
    #[arg(long)]
    pub grid_pattern: bool,
    /// Levels of detail by the length of edges on the picture; --level is then the finest [default: 128]
    #[arg(long, value_enum)]
    lod: Option<LodFlag>,
    /// Pixels that a segment of an edge should have, with --lod [default: 8]
    #[arg(long, value_name = "PX")]
    segment: Option<f64>,
    /// Levels pop instead of melting into one another, with --lod
    #[arg(long)]
    no_morph: bool,
    /// Where coefficients of curved triangles are made [default: cpu]
    #[arg(long, value_enum)]
    coefficients: Option<CoefficientsFlag>,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum LodFlag {
    /// One level for all of the mesh, by its distance
    Mesh,
    /// Each edge has its own
    Triangle,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum CoefficientsFlag {
    /// Before they are uploaded, as in the paper
    Cpu,
    /// By a compute shader, from the coarse mesh
    Gpu,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum MethodFlag {
    /// One draw a coarse triangle with its attributes as uniforms, the paper's way
    Draws,
    /// One draw with an instance a coarse triangle
    Instanced,
    /// The whole refined mesh in a vertex buffer
    Static,
    /// Hardware tessellation
    Hardware,
    /// Levels of detail chosen on the device, one indirect draw for each
    Indirect,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum EvaluatorFlag {
    /// Flat
    Linear,
    /// Curved PN triangles
    Pn,
    /// Scalar tagged PN triangles
    St,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum FieldFlag {
    Vlachos,
    Boubekeur,
    Linear,
}

impl PatternFlags {
    /// Refuses these flags for scenes of other techniques.
    pub fn refuse(&self) -> Result<(), Failure> {
        match *self == PatternFlags::default() {
            true => Ok(()),
            false => Err(Failure::input(
                "--evaluator, --normal-field, --time, --method, --grid-pattern, --lod, --segment, --no-morph and --coefficients go with scenes of technique pattern; leave them out",
            )),
        }
    }

    /// The draw method asked for.
    pub fn method(&self) -> PatternMethod {
        match self.method {
            Some(MethodFlag::Draws) => PatternMethod::Draws,
            Some(MethodFlag::Static) => PatternMethod::Static,
            Some(MethodFlag::Hardware) => PatternMethod::Hardware,
            Some(MethodFlag::Indirect) => PatternMethod::Indirect,
            Some(MethodFlag::Instanced) | None => PatternMethod::Instanced,
        }
    }

    /// Refuses flags of pictures, for commands that draw none.
    pub fn refuse_drawing(&self) -> Result<(), Failure> {
        let kept = PatternFlags {
            evaluator: self.evaluator,
            normal_field: self.normal_field,
            time: self.time,
            ..PatternFlags::default()
        };
        match *self == kept {
            true => Ok(()),
            false => Err(Failure::input(
                "--method, --grid-pattern, --lod, --segment, --no-morph and --coefficients go with commands that draw; leave them out",
            )),
        }
    }

    /// The mesh that the device makes coefficients of, if it is to.
    pub fn coarse<'a>(&self, scene: &'a PatternScene) -> Option<(&'a CoarseMesh, NormalField)> {
        (self.coefficients == Some(CoefficientsFlag::Gpu)).then_some((&scene.mesh, scene.normal_field))
    }

    /// Levels of detail, if asked for; `level`: what `--level` says.
    pub fn detail(&self, level: Option<u32>) -> Result<Option<Detail>, Failure> {
        let Some(lod) = self.lod else {
            return match self.segment.is_none() && !self.no_morph {
                true => Ok(None),
                false => {
                    Err(Failure::input("--segment and --no-morph go with --lod; give --lod triangle or --lod mesh"))
                }
            };
        };
        if self.grid_pattern {
            return Err(Failure::input("--lod draws triangular patterns; leave out --grid-pattern"));
        }
        let most = match level {
            None => MOST,
            Some(level) if level.is_power_of_two() && level <= MAX_LEVEL => level.ilog2(),
            Some(level) => {
                return Err(Failure::input(format_args!(
                    "with --lod, --level {level} is no finest level; give 1, 2, 4, ... up to {MAX_LEVEL}"
                )));
            }
        };
        let segment = self.segment.unwrap_or(Detail::default().segment);
        if !(0.1..=1e4).contains(&segment) {
            return Err(Failure::input(format_args!("--segment {segment} is out of range; give 0.1 to 10000 pixels")));
        }
        let scope = match lod {
            LodFlag::Mesh => Scope::Mesh,
            LodFlag::Triangle => Scope::Triangle,
        };
        Ok(Some(Detail { scope, segment, most, morph: !self.no_morph }))
    }

    /// Changes a scene as the flags say.
    pub fn apply(&self, scene: &mut PatternScene) -> Result<(), Failure> {
        if let Some(evaluator) = self.evaluator {
            scene.evaluator = match evaluator {
                EvaluatorFlag::Linear => Evaluator::Linear,
                EvaluatorFlag::Pn => Evaluator::Pn,
                EvaluatorFlag::St => Evaluator::St,
            };
        }
        if let Some(field) = self.normal_field {
            scene.normal_field = match field {
                FieldFlag::Vlachos => NormalField::Vlachos,
                FieldFlag::Boubekeur => NormalField::Boubekeur,
                FieldFlag::Linear => NormalField::Linear,
            };
        }
        if let Some(time) = self.time {
            if time.is_nan() || time.abs() > 1e6 {
                return Err(Failure::input(format_args!("--time {time} is out of range; give -1e6 to 1e6")));
            }
            scene.displacement = std::mem::take(&mut scene.displacement).at_time(time);
        }
        Ok(())
    }
}

/// The level of the pattern: `--level`, or the scene's.
pub fn level(refining: &Refining, scene: &PatternScene) -> Result<u32, Failure> {
    if !(Refining { level: None, ..refining.clone() }).is_default() {
        return Err(Failure::input(
            "--mode, --rules, --patches and --isolate go with gradient meshes; refinement patterns take --level",
        ));
    }
    match refining.level.unwrap_or(scene.level) {
        level @ 1..=MAX_LEVEL => Ok(level),
        level => {
            Err(Failure::input(format_args!("--level {level} is out of range; patterns have levels 1 to {MAX_LEVEL}")))
        }
    }
}

/// The evaluator as the command line calls it.
pub fn evaluator_name(evaluator: Evaluator) -> &'static str {
    match evaluator {
        Evaluator::Linear => "linear",
        Evaluator::Pn => "pn",
        Evaluator::St => "st",
    }
}

/// The method as the command line calls it.
pub fn method_name(method: PatternMethod) -> &'static str {
    match method {
        PatternMethod::Draws => "draws",
        PatternMethod::Instanced => "instanced",
        PatternMethod::Static => "static",
        PatternMethod::Hardware => "hardware",
        PatternMethod::Indirect => "indirect",
    }
}
