//! Flags that make one configuration of a scene.

use crate::command::{ModeFlag, PatchesFlag, Refining, RulesFlag, TransitionsFlag};
use crate::patch::remap::Transitions;
use crate::patch::tess::TessRule;
use clap::{Args, Parser, ValueEnum};

/// Which faces are refined, or both ways in turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BenchMode {
    Adaptive,
    Global,
    /// Adaptive as A and global as B, a frame of each in turns
    Both,
}

/// What every frame does before it draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum EditsFlag {
    /// Nothing: rendering alone
    #[default]
    None,
    /// Refine, build and upload the same scene
    Rebuild,
    /// Move the vertex of one geometry edit of the scene a little, then rebuild
    Geometry,
    /// Change the colour of one edited vertex of the scene a little, then rebuild
    Colour,
}

/// One configuration; what is not given is the default, or in --pair what the first configuration has.
#[derive(Args, Clone, Debug, Default)]
pub struct Config {
    /// Feature-adaptive refinement, uniform subdivision, or both in turns; of technique ferguson local refinement, the
    /// traditional mesh where every split runs through its row, or both [default: adaptive]
    #[arg(long, value_enum)]
    pub mode: Option<BenchMode>,
    /// Ours, or the authors' tool to the letter [default: gradtess]
    #[arg(long, value_enum)]
    rules: Option<RulesFlag>,
    /// What draws irregular faces: Gregory patches (ACC2) or bicubics (ACC1) [default: gregory]
    #[arg(long, value_enum)]
    patches: Option<PatchesFlag>,
    /// How transition faces are drawn [default: constellations]
    #[arg(long, value_enum)]
    transitions: Option<TransitionsFlag>,
    /// Level of --mode global; the finest edit level unless given
    #[arg(long, value_name = "L")]
    level: Option<u32>,
    /// Refine irregular faces this many levels more (render's --isolate)
    #[arg(long, value_name = "N")]
    isolate_level: Option<u32>,
    /// Tessellation level of every patch, 1 to 64 [default: 16; 1 with --match-triangles]
    #[arg(long, value_name = "T", group = "tessellation")]
    tess: Option<f32>,
    /// Tessellation level T / 2^l of the patches of level l
    #[arg(long, value_name = "T", group = "tessellation")]
    tess_base: Option<f32>,
    /// As many segments as make an edge's pieces P pixels long
    #[arg(long, value_name = "P", group = "tessellation")]
    pixels: Option<f32>,
    /// What every frame does before it draws [default: none]
    #[arg(long, value_enum)]
    edits: Option<EditsFlag>,
    /// Follow edits in place instead of rebuilding everything; goes with --edits geometry or colour
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "true|false")]
    local: Option<bool>,
    /// Measure N copies of the scene, welded into one sheet [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    copies: Option<u32>,
    /// Keep kinds of patches apart by passes and full barriers, so that their GPU times add up; slower as a whole
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "true|false")]
    isolate: Option<bool>,
    /// Stretch every frame by P per cent: tests whether a difference is found
    #[arg(long, value_name = "P")]
    slowdown: Option<f64>,
}

#[derive(Parser)]
#[command(name = "--pair", no_binary_name = true, disable_help_flag = true)]
struct PairFlags {
    #[command(flatten)]
    config: Config,
}

impl Config {
    /// Reads the text of `--pair`.
    pub fn parse(text: &str) -> Result<Config, String> {
        PairFlags::try_parse_from(text.split_whitespace()).map(|flags| flags.config).map_err(|e| {
            let text = e.to_string();
            let line = text.lines().next().unwrap_or("wrong flags");
            format!("--pair: {}", line.trim_start_matches("error: "))
        })
    }

    /// This configuration where it says something, `base` where it does not.
    pub fn over(&self, base: &Config) -> Config {
        let own_tess = self.tess.or(self.tess_base).or(self.pixels).is_some();
        let tess = if own_tess { self } else { base };
        Config {
            mode: self.mode.or(base.mode),
            rules: self.rules.or(base.rules),
            patches: self.patches.or(base.patches),
            transitions: self.transitions.or(base.transitions),
            level: self.level.or(base.level),
            isolate_level: self.isolate_level.or(base.isolate_level),
            tess: tess.tess,
            tess_base: tess.tess_base,
            pixels: tess.pixels,
            edits: self.edits.or(base.edits),
            local: self.local.or(base.local),
            copies: self.copies.or(base.copies),
            isolate: self.isolate.or(base.isolate),
            slowdown: self.slowdown.or(base.slowdown),
        }
    }

    /// The same in one of the two modes.
    pub fn with_mode(&self, mode: BenchMode) -> Config {
        Config { mode: Some(mode), ..self.clone() }
    }

    /// True for uniform subdivision.
    pub fn is_global(&self) -> bool {
        self.mode == Some(BenchMode::Global)
    }

    /// What frames do first.
    pub fn edits(&self) -> EditsFlag {
        self.edits.unwrap_or_default()
    }

    /// Whether edits are followed in place.
    pub fn local(&self) -> bool {
        self.local.unwrap_or_default()
    }

    /// Copies of the scene, if said.
    pub fn copies_given(&self) -> Option<u32> {
        self.copies
    }

    /// Copies of the scene.
    pub fn copies(&self) -> u32 {
        self.copies.unwrap_or(1)
    }

    /// Whether kinds are kept apart.
    pub fn isolate(&self) -> bool {
        self.isolate.unwrap_or_default()
    }

    /// Per cent by which frames are stretched.
    pub fn slowdown(&self) -> f64 {
        self.slowdown.unwrap_or_default()
    }

    /// The tessellation rule that was given.
    pub fn tess(&self) -> Option<TessRule> {
        let fixed = self.tess.map(TessRule::Fixed);
        fixed.or(self.tess_base.map(TessRule::Base)).or(self.pixels.map(TessRule::Pixels))
    }

    /// Flags of refinement and patches. Adaptive refinement has no use for `--level`, which may be meant for the other
    /// half of a pair.
    pub fn refining(&self) -> Refining {
        let global = self.is_global();
        Refining {
            mode: if global { ModeFlag::Global } else { ModeFlag::Adaptive },
            rules: self.rules.unwrap_or(RulesFlag::Gradtess),
            patches: self.patches.unwrap_or(PatchesFlag::Gregory),
            level: if global { self.level } else { None },
            isolate: if global { 0 } else { self.isolate_level.unwrap_or(0) },
            no_cascade: false,
        }
    }

    /// How transition faces are drawn.
    pub fn transitions(&self) -> Transitions {
        self.transitions.unwrap_or_default().into()
    }

    /// Level that uniform subdivision goes to, if given.
    pub fn level(&self) -> Option<u32> {
        self.level
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_configuration_changes_what_it_names() {
        let a = Config { tess: Some(4.0), level: Some(3), edits: Some(EditsFlag::Colour), ..Config::default() };
        let b = Config::parse("--mode global --tess-base 8 --isolate").unwrap().over(&a);
        assert!(b.is_global() && b.isolate());
        assert_eq!(b.tess(), Some(TessRule::Base(8.0)));
        assert_eq!((b.level, b.edits()), (Some(3), EditsFlag::Colour));
        assert_eq!(Config::parse("").unwrap().over(&a).tess(), Some(TessRule::Fixed(4.0)));
        assert!(Config::parse("--nonsense").unwrap_err().starts_with("--pair: "));
        assert!(Config::parse("--tess 3 --pixels 2").is_err());
    }
}
