//! The command line: a contract of names, flags, exit codes and JSON.

mod bench;
mod check;
mod convert;
mod devices;
mod edit;
mod ferguson;
mod measure;
mod mesh;
mod open;
mod patches;
mod pattern;
mod picture;
mod render;
mod repro;
mod sample;
mod stats;
mod surface;

use crate::gpu::{GpuError, GpuOptions};
use crate::image::ImageError;
use crate::patch::remap::Transitions;
use crate::scene::SceneError;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::fmt::Display;
use std::process::ExitCode;

/// Hardware-tessellated curved patches, measured.
#[derive(Parser)]
#[command(name = "gradtess", version, about, max_term_width = 110)]
struct Cli {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    command: Command,
}

/// Flags that every command takes.
#[derive(Args, Clone, Debug, Default)]
pub struct Global {
    /// Vulkan device: index or part of its name
    #[arg(long, global = true, value_name = "NAME|INDEX")]
    device: Option<String>,
    /// Load the Khronos validation layer with synchronisation checks; what it reports is an error
    #[arg(long, global = true)]
    validate: bool,
    /// No progress and no warnings
    #[arg(long, global = true)]
    quiet: bool,
    /// Machine-readable result on stdout; its first field names the schema
    #[arg(long, global = true)]
    json: bool,
    /// Cores that refinement and patches may use; all unless given. Results are the same whatever their number
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=250))]
    threads: Option<u16>,
}

impl Global {
    /// Before anything asks for the pool of threads.
    fn start_threads(&self) -> Result<(), Failure> {
        let Some(n) = self.threads else { return Ok(()) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n.into());
        pool.build_global().map_err(|e| Failure::machine(format!("{n} threads: {e}")))
    }

    fn gpu(&self) -> GpuOptions {
        GpuOptions { device: self.device.clone(), validate: self.validate }
    }

    /// A line on stderr that does not change the result.
    fn warn(&self, text: impl Display) {
        if !self.quiet {
            eprintln!("warning: {text}");
        }
    }
}

#[derive(Subcommand)]
enum Command {
    /// Draw a scene to a PNG
    Render(render::Render),
    /// Patch counts as in Table 1 of the paper, with levels, bytes and times
    Stats(stats::Stats),
    /// The whole mesh M^L after edits
    Mesh(mesh::Mesh),
    /// Every patch: kind, level, constellation, control points
    Patches(patches::Patches),
    /// Parameter samples of the drawn surface, face by face of M^0
    Sample(sample::Sample),
    /// Look for cracks: background pixels inside the surface
    Check(check::Check),
    /// Capture frame timings by a stated protocol
    Bench(Box<bench::Bench>),
    /// Every table and figure of the papers, as data, pictures and one HTML report
    Repro(repro::Repro),
    /// Between scene formats, told by the extension of OUT
    Convert(convert::Convert),
    /// The editor: subdivision gradient meshes, live
    Edit(Box<edit::Edit>),
    /// Vulkan devices and what they lack
    Devices,
}

/// How a scene becomes patches; shared by the commands that make them.
#[derive(Args, Clone, Debug)]
pub struct Refining {
    /// Feature-adaptive refinement, or uniform subdivision of every face to one level
    #[arg(long, value_enum, default_value = "adaptive")]
    mode: ModeFlag,
    /// Ours (graded, sector-local, watertight), or the authors' tool to the letter
    #[arg(long, value_enum, default_value = "gradtess")]
    rules: RulesFlag,
    /// What draws irregular faces: Gregory patches (ACC2) or bicubics (ACC1)
    #[arg(long, value_enum, default_value = "gregory")]
    patches: PatchesFlag,
    /// Level of --mode global; the finest edit level unless given
    #[arg(long, value_name = "L")]
    level: Option<u32>,
    /// Refine irregular faces this many levels more, around extraordinary vertices and meeting sharp edges; where five and
    /// more edges meet, as many as make the error so many times less (rules gradtess)
    #[arg(long, value_name = "N", default_value_t = 0)]
    isolate: u32,
    /// Leave out the cascade of refinement around extraordinary vertices, to see what it is for (rules authors)
    #[arg(long)]
    no_cascade: bool,
}

impl Refining {
    /// Whether no flag asks for anything but the defaults.
    pub fn is_default(&self) -> bool {
        self.mode == ModeFlag::Adaptive
            && self.rules == RulesFlag::Gradtess
            && self.patches == PatchesFlag::Gregory
            && self.level.is_none()
            && self.isolate == 0
            && !self.no_cascade
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ModeFlag {
    Adaptive,
    Global,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum RulesFlag {
    Authors,
    Gradtess,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PatchesFlag {
    Gregory,
    Bicubic,
}

/// How transition faces are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum TransitionsFlag {
    /// As two to four parts
    #[default]
    Constellations,
    /// In one piece, the segments of both finer edges along each split one; levels up to 32
    Remap,
    /// The same along the face's own curves, as OpenSubdiv does it: to see what gaps that leaves
    RemapOwn,
}

impl From<TransitionsFlag> for Transitions {
    fn from(flag: TransitionsFlag) -> Self {
        match flag {
            TransitionsFlag::Constellations => Transitions::Constellations,
            TransitionsFlag::Remap => Transitions::Remap,
            TransitionsFlag::RemapOwn => Transitions::RemapOwn,
        }
    }
}

/// Why a command ended without its result.
#[derive(Debug)]
pub struct Failure {
    /// Exit status: 1 the machine failed, 2 input or usage is wrong, 3 a check falls short.
    status: u8,
    /// One line.
    message: String,
}

/// Fails with the first message of the validation layer.
fn silent(gpu: &crate::gpu::Gpu) -> Result<(), Failure> {
    match gpu.messages().first() {
        Some(m) => Err(Failure::machine(format_args!("the validation layer reports: {}: {}", m.id, m.text))),
        None => Ok(()),
    }
}

impl Failure {
    fn machine(message: impl Display) -> Failure {
        Failure { status: 1, message: message.to_string() }
    }

    fn input(message: impl Display) -> Failure {
        Failure { status: 2, message: message.to_string() }
    }

    fn short(message: impl Display) -> Failure {
        Failure { status: 3, message: message.to_string() }
    }
}

impl From<SceneError> for Failure {
    fn from(e: SceneError) -> Self {
        if e.is_machine_failure() {
            Failure::machine(e)
        } else {
            Failure::input(e)
        }
    }
}

impl From<GpuError> for Failure {
    fn from(e: GpuError) -> Self {
        if e.is_request() {
            Failure::input(e)
        } else {
            Failure::machine(e)
        }
    }
}

impl From<ImageError> for Failure {
    fn from(e: ImageError) -> Self {
        Failure::machine(e)
    }
}

/// Runs the program on the process's arguments.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(e) if e.kind() == clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            eprintln!("error: no command was given; see 'gradtess --help'");
            return ExitCode::from(2);
        }
        Err(e) if e.use_stderr() => {
            let text = e.to_string();
            let what = text.lines().find(|l| !l.trim().is_empty()).unwrap_or("wrong usage");
            let what = what.trim_start_matches("error: ").trim_end_matches(':');
            // What is missing stands on the indented lines after "not provided".
            let more: Vec<&str> = text.lines().skip(1).take_while(|l| l.starts_with("  ")).map(str::trim).collect();
            eprintln!(
                "error: {what}{}{}; see 'gradtess --help'",
                if more.is_empty() { "" } else { ": " },
                more.join(", ")
            );
            return ExitCode::from(2);
        }
        Err(help) => {
            print(&help.to_string());
            return ExitCode::SUCCESS;
        }
    };
    let g = &cli.global;
    let done = g.start_threads().and_then(|()| match &cli.command {
        Command::Render(c) => c.run(g),
        Command::Stats(c) => c.run(g),
        Command::Mesh(c) => c.run(g),
        Command::Patches(c) => c.run(g),
        Command::Sample(c) => c.run(g),
        Command::Check(c) => c.run(g),
        Command::Bench(c) => c.run(g),
        Command::Repro(c) => c.run(g),
        Command::Convert(c) => c.run(g),
        Command::Edit(c) => c.run(g),
        Command::Devices => devices::run(g),
    });
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(f) => {
            let line: String = f.message.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
            eprintln!("error: {line}");
            ExitCode::from(f.status)
        }
    }
}

/// Prints to stdout; a reader that has seen enough (`| head`) is no error.
fn print(text: &str) {
    use std::io::Write;
    let _ = std::io::stdout().write_all(text.as_bytes());
}

/// One JSON document on stdout.
fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string(value).map_err(Failure::machine)?;
    print(&(text + "\n"));
    Ok(())
}
