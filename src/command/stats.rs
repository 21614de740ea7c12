//! `gradtess stats`: patch counts as in Table 1.

use super::open::{Loaded, Subject};
use super::pattern::flags::{level as pattern_level, PatternFlags};
use super::surface::flags::{level, SurfaceFlags};
use super::{print, print_json, Failure, Global, Refining, RulesFlag};
use crate::patch::transition::constellation;
use crate::patch::{Kind, PatchTable};
use crate::refine::fate;
use crate::subdiv::index_map::IndexMap;
use clap::Args;
use serde::Serialize;

/// Arguments of `stats`.
#[derive(Args)]
pub struct Stats {
    /// Scene files
    #[arg(required = true)]
    scenes: Vec<String>,
    #[command(flatten)]
    refining: Refining,
    #[command(flatten)]
    surface: SurfaceFlags,
    #[command(flatten)]
    pattern: PatternFlags,
}

/// A row of Table 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
struct Counts {
    bicubic: usize,
    bicubic_transition: usize,
    gregory: usize,
    gregory_transition: usize,
    total: usize,
}

#[derive(Serialize)]
struct LevelCounts {
    level: u32,
    faces: usize,
    affected: usize,
    drawn: usize,
}

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    scene: String,
    rules: String,
    #[serde(flatten)]
    counts: Counts,
    /// Irregular faces drawn; they are the Gregory ones unless bicubics stand in for them.
    irregular: usize,
    global: u64,
    global_level: u32,
    deepest_drawn_level: u32,
    constellations: [usize; 5],
    levels: Vec<LevelCounts>,
    control_points: usize,
    indices: usize,
    device_bytes: usize,
    refine_ms: f64,
    patch_ms: f64,
    /// The same scene under the authors' rules: bicubic, bicubic_transition, gregory, gregory_transition, total.
    #[serde(skip_serializing_if = "Option::is_none")]
    authors: Option<[usize; 5]>,
}

fn counts(table: &PatchTable) -> Counts {
    let mut c = Counts { total: table.faces.len(), ..Counts::default() };
    for f in &table.faces {
        let transition = usize::from(f.transition != 0);
        match f.kind {
            Kind::Bicubic | Kind::Stitched | Kind::RemappedBicubic => {
                (c.bicubic, c.bicubic_transition) = (c.bicubic + 1, c.bicubic_transition + transition)
            }
            Kind::Gregory | Kind::RemappedGregory => {
                (c.gregory, c.gregory_transition) = (c.gregory + 1, c.gregory_transition + transition)
            }
        }
    }
    c
}

impl Stats {
    /// Counts and prints.
    pub fn run(&self, global: &Global) -> Result<(), Failure> {
        for scene in &self.scenes {
            let subject = Subject::open(scene, global)?;
            if !matches!(subject, Subject::Pattern(_)) {
                self.pattern.refuse()?;
            }
            match subject {
                Subject::Subdivision(loaded) => {
                    self.surface.refuse()?;
                    let report = self.report(&loaded)?;
                    if global.json {
                        print_json(&report)?;
                    } else {
                        print(&text(&report));
                    }
                }
                Subject::Ferguson(mesh) => {
                    self.surface.refuse()?;
                    super::ferguson::open::refuse(&self.refining)?;
                    super::ferguson::stats::run(&mesh, global)?;
                }
                Subject::Surface(surface) => {
                    let depth = level(&self.refining)?.unwrap_or(0);
                    super::surface::stats::run(&surface, &self.surface, depth, global)?;
                }
                Subject::Pattern(mut pattern) => {
                    self.surface.refuse()?;
                    self.pattern.refuse_drawing()?;
                    self.pattern.apply(&mut pattern.scene)?;
                    let level = pattern_level(&self.refining, &pattern.scene)?;
                    super::pattern::stats::run(&pattern.scene, level, global)?;
                }
            }
        }
        Ok(())
    }

    fn report(&self, loaded: &Loaded) -> Result<Report, Failure> {
        let patched = loaded.patches(&self.refining)?;
        let authors = match self.refining.rules {
            RulesFlag::Authors => None,
            RulesFlag::Gradtess => {
                let flags = Refining { rules: RulesFlag::Authors, isolate: 0, ..self.refining.clone() };
                let c = counts(&loaded.patches(&flags)?.table);
                Some([c.bicubic, c.bicubic_transition, c.gregory, c.gregory_transition, c.total])
            }
        };
        let (table, refinement) = (&patched.table, &patched.refinement);
        let mut constellations = [0; 5];
        for f in table.faces.iter().filter(|f| f.transition != 0) {
            constellations[constellation(f.transition) as usize - 1] += 1;
        }
        let levels = refinement.levels.iter().zip(&refinement.fates).map(|(level, fates)| {
            let with = |bit: u8| fates.iter().filter(|&f| f & bit != 0).count();
            LevelCounts {
                level: level.level,
                faces: level.faces(),
                affected: with(fate::AFFECTED),
                drawn: with(fate::DRAWN),
            }
        });
        let map = IndexMap::new(&loaded.mesh);
        Ok(Report {
            schema: "gradtess.stats/1",
            scene: loaded.scene.name.clone(),
            rules: format!("{:?}", refinement.rules).to_lowercase(),
            counts: counts(table),
            irregular: table.faces.iter().filter(|f| f.irregular).count(),
            global: map.faces(refinement.edit_level),
            global_level: refinement.edit_level,
            deepest_drawn_level: table.faces.iter().map(|f| f.level).max().unwrap_or(0),
            constellations,
            levels: levels.collect(),
            control_points: table.control.len(),
            indices: table.indices.len(),
            device_bytes: 32 * table.control.len() + 4 * table.indices.len(),
            refine_ms: patched.refine_ms,
            patch_ms: patched.patch_ms,
            authors,
        })
    }
}

fn text(r: &Report) -> String {
    let c = &r.counts;
    let title = format!("{}, rules {}", r.scene, r.rules);
    let wide = title.len().max(28);
    let row = |name: &str, c: [usize; 5]| {
        format!(
            "{name:<wide$} {:>9} {:>9} {:>7}\n",
            format!("{} ({})", c[0], c[1]),
            format!("{} ({})", c[2], c[3]),
            c[4]
        )
    };
    let ours = [c.bicubic, c.bicubic_transition, c.gregory, c.gregory_transition, c.total];
    let mut out = format!("{:<wide$} {:>9} {:>9} {:>7}\n", "", "bicubic", "Gregory", "total");
    out += &row(&title, ours);
    if let Some(authors) = r.authors {
        out += &row("    rules authors", authors);
        let more = c.total as i64 - authors[4] as i64;
        out += &format!(
            "    {more:+} patches: neighbours differ by one level at most, colour edits refine only the sectors they can change, sharp edges that meet are refined once more\n"
        );
    }
    out += &format!(
        "    global (level {}): {}\n    constellations C1 to C5: {:?}\n",
        r.global_level, r.global, r.constellations
    );
    for l in &r.levels {
        out += &format!("    level {}: {} faces, {} refined, {} drawn\n", l.level, l.faces, l.affected, l.drawn);
    }
    out += &format!(
        "    {} control points, {} indices, {} bytes on the device\n    refine {:.3} ms, patches {:.3} ms\n",
        r.control_points, r.indices, r.device_bytes, r.refine_ms, r.patch_ms
    );
    out
}
