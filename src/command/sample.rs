//! `gradtess sample`: the drawn surface, or the limit itself, at parameters of the faces of M^0.

use super::ferguson::{list, open::refuse};
use super::open::Subject;
use super::pattern::flags::PatternFlags;
use super::surface::flags::SurfaceFlags;
use super::{print, print_json, surface, Failure, Global, Refining};
use crate::check::exact::ExactFace;
use crate::check::locate::{locate, turned, BasePoint, Drawn};
use crate::patch::build::face_control;
use crate::patch::{eval, Kind};
use crate::refine::Rules;
use clap::Args;
use serde::Serialize;
use std::collections::HashMap;

/// Arguments of `sample`.
#[derive(Args)]
pub struct Sample {
    /// Scene file
    scene: String,
    /// Samples along each side of a face, borders included
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=4096))]
    n: u32,
    /// The Catmull-Clark limit instead of the patches
    #[arg(long)]
    exact: bool,
    #[command(flatten)]
    refining: Refining,
    #[command(flatten)]
    surface: SurfaceFlags,
    #[command(flatten)]
    pattern: PatternFlags,
}

/// Most samples that one run makes; they are held in memory.
pub(super) const MOST: u64 = 4_000_000;

/// What `sample` gives of gradient meshes.
#[derive(Serialize)]
pub(super) struct Samples {
    pub schema: &'static str,
    pub scene: String,
    pub exact: bool,
    /// A sample is: face of M^0; corner of a face that is no quad (u, v then run over the quad at that corner), else null; u, v; x, y; r, g, b, a; level and kind of what is drawn there.
    pub samples: Vec<Row>,
}

#[derive(Serialize)]
pub(super) struct Row {
    pub face: u32,
    pub corner: Option<u32>,
    pub u: f64,
    pub v: f64,
    pub position: [f64; 2],
    pub colour: [f64; 4],
    pub level: u32,
    pub kind: &'static str,
}

impl Samples {
    /// As JSON or as a table.
    pub fn print(&self, global: &Global) -> Result<(), Failure> {
        if global.json {
            return print_json(self);
        }
        let mut out = String::from("face\tcorner\tu\tv\tx\ty\tr\tg\tb\ta\tlevel\tkind\n");
        for s in &self.samples {
            let corner = s.corner.map_or("-".to_string(), |c| c.to_string());
            let [x, y] = s.position;
            let [r, g, b, a] = s.colour;
            out += &format!(
                "{}\t{corner}\t{}\t{}\t{x}\t{y}\t{r}\t{g}\t{b}\t{a}\t{}\t{}\n",
                s.face, s.u, s.v, s.level, s.kind
            );
        }
        print(&out);
        Ok(())
    }
}

impl Sample {
    /// Samples every face of M^0.
    pub fn run(&self, global: &Global) -> Result<(), Failure> {
        let subject = Subject::open(&self.scene, global)?;
        if !matches!(subject, Subject::Pattern(_)) {
            self.pattern.refuse()?;
        }
        let loaded = match subject {
            Subject::Subdivision(loaded) => loaded,
            Subject::Ferguson(mesh) => {
                self.surface.refuse()?;
                refuse(&self.refining)?;
                return list::sample(&mesh, self.n, self.exact, global);
            }
            Subject::Surface(surface) => {
                return surface::sample::run(&surface, &self.surface, &self.refining, self.n, self.exact, global)
            }
            Subject::Pattern(mut pattern) => {
                if self.exact || !self.refining.is_default() {
                    return Err(Failure::input("refinement patterns are the surface itself; --n alone goes with them"));
                }
                self.surface.refuse()?;
                self.pattern.refuse_drawing()?;
                self.pattern.apply(&mut pattern.scene)?;
                return super::pattern::sample::run(&pattern.scene, self.n, global);
            }
        };
        self.surface.refuse()?;
        let patched = loaded.patches(&self.refining)?;
        let (r, table) = (&patched.refinement, &patched.table);
        if self.exact && r.rules == Rules::Authors {
            return Err(Failure::input("--exact needs --rules gradtess, whose drawn faces no finer edit reaches"));
        }
        let drawn = Drawn::new(table);
        let mut exact: HashMap<(u32, u32), ExactFace> = HashMap::new();
        let mut samples = Vec::new();
        let step = |i: u32| if self.n == 1 { 0.5 } else { f64::from(i) / f64::from(self.n - 1) };
        let zero = &r.levels[0];
        let quads: u64 =
            (0..zero.faces() as u32).map(|f| zero.valence(f)).map(|n| if n == 4 { 1 } else { n.into() }).sum();
        let all = quads * u64::from(self.n).pow(2);
        if all > MOST {
            return Err(Failure::input(format_args!(
                "{all} samples are too many; at most {MOST}, choose a smaller --n"
            )));
        }
        for face in 0..zero.faces() as u32 {
            let corners = match zero.valence(face) {
                4 => vec![None],
                n => (0..n).map(Some).collect(),
            };
            for corner in corners {
                for (j, i) in (0..self.n).flat_map(|j| (0..self.n).map(move |i| (j, i))) {
                    let at = locate(r, BasePoint { face, corner, uv: [step(i), step(j)] });
                    let Some(index) = drawn.at(r, at) else {
                        return Err(Failure::machine(format_args!(
                            "face {} of level {} is neither refined nor drawn",
                            at.face, at.level
                        )));
                    };
                    let (l, f, [u, v]) = (at.level, at.face, at.uv);
                    let patch = &table.faces[index];
                    let (position, colour) = if self.exact {
                        let value = exact.entry((l, f)).or_insert_with(|| ExactFace::new(r, l as usize, f)).at(u, v);
                        (value.p.to_array(), value.c.to_array())
                    } else {
                        let [pu, pv] = turned(patch.turn, [u, v]);
                        let c = eval::face(patch.kind, &face_control(table, patch), pu, pv);
                        ([c[0], c[1]], [c[4], c[5], c[6], c[7]])
                    };
                    samples.push(Row {
                        face,
                        corner,
                        u: step(i),
                        v: step(j),
                        position,
                        colour,
                        level: l,
                        kind: if patch.kind == Kind::Gregory { "gregory" } else { "bicubic" },
                    });
                }
            }
            exact.clear();
        }
        Samples { schema: "gradtess.sample/1", scene: loaded.scene.name.clone(), exact: self.exact, samples }
            .print(global)
    }
}
