//! `gradtess patches`: every drawn face with its control points.

use super::ferguson::{list, open::refuse};
use super::open::Subject;
use super::{print, print_json, Failure, Global, Refining};
use crate::patch::build::face_control;
use crate::patch::transition::constellation;
use crate::patch::Kind;
use crate::refine::forest::first_slot;
use crate::subdiv::index_map::IndexMap;
use clap::Args;
use serde::Serialize;

/// Arguments of `patches`.
#[derive(Args)]
pub struct Patches {
    /// Scene file
    scene: String,
    #[command(flatten)]
    refining: Refining,
}

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    scene: String,
    patches: Vec<Patch>,
}

#[derive(Serialize)]
struct Patch {
    level: u32,
    face: u64,
    first_half_edge: u64,
    kind: &'static str,
    irregular: bool,
    /// 1 to 5, 0 without a transition edge.
    constellation: u8,
    /// One digit an edge, from the face's first half-edge.
    transition: String,
    /// Edges from the face's first half-edge to the one that leaves corner A of the control points.
    turn: u8,
    /// x, y, r, g, b, a of 16 (bicubic) or 20 (Gregory) points: row by row from corner A, u first; then f- of corners A to D.
    control: Vec<[f64; 6]>,
}

impl Patches {
    /// Lists the patches.
    pub fn run(&self, global: &Global) -> Result<(), Failure> {
        let loaded = match Subject::open(&self.scene, global)? {
            Subject::Subdivision(loaded) => loaded,
            Subject::Ferguson(mesh) => {
                refuse(&self.refining)?;
                return list::patches(&mesh, global);
            }
            other => return Err(other.refused(&self.scene)),
        };
        let patched = loaded.patches(&self.refining)?;
        let map = IndexMap::new(&loaded.mesh);
        let table = &patched.table;
        let patches = table.faces.iter().map(|f| {
            let slot = first_slot(&map, f.level, f.name);
            let mask = f.transition << f.turn | f.transition >> (4 - f.turn);
            Patch {
                level: f.level,
                face: map.face_app_a(f.level, slot),
                first_half_edge: map.to_app_a(f.level, slot),
                kind: if f.kind == Kind::Gregory { "gregory" } else { "bicubic" },
                irregular: f.irregular,
                constellation: constellation(f.transition),
                transition: (0..4).map(|i| if mask >> i & 1 == 1 { '1' } else { '0' }).collect(),
                turn: f.turn,
                control: face_control(table, f).iter().map(|c| [c[0], c[1], c[4], c[5], c[6], c[7]]).collect(),
            }
        });
        let report =
            Report { schema: "gradtess.patches/1", scene: loaded.scene.name.clone(), patches: patches.collect() };
        if global.json {
            return print_json(&report);
        }
        let mut out = String::from("level\tface\tfirst_halfedge\tkind\ttransition\n");
        for p in &report.patches {
            let kind = if p.kind == "gregory" { "G" } else { "B" };
            let transition = match p.constellation {
                0 => "-".to_string(),
                c => format!("C{c}:{}", p.transition),
            };
            out += &format!("{}\t{}\t{}\t{kind}\t{transition}\n", p.level, p.face, p.first_half_edge);
        }
        print(&out);
        Ok(())
    }
}
