//! Subdivision scenes: refined and built anew after every edit.

use super::config::{Config, EditsFlag};
use super::source::{row, Counts, Facts, Source};
use crate::command::open::Loaded;
use crate::command::{Failure, PatchesFlag, RulesFlag};
use crate::gpu::{DeviceTable, Gpu};
use crate::incremental::{Delta, Outcome, State, ValueEdit};
use crate::mesh::{self, MeshError};
use crate::patch::build::{build, rebuild};
use crate::patch::points::Irregular;
use crate::patch::remap::Transitions;
use crate::patch::tess::TessRule;
use crate::patch::{Kind, PatchTable};
use crate::refine::{fate, Options, Refinement};
use crate::scene::copies::copies;
use crate::scene::{ColourEdit, GeometryEdit};
use crate::subdiv::index_map::IndexMap;
use crate::timing::record::Fields;
use crate::timing::triangles;
use std::collections::BTreeMap;
use std::fmt::Write;

fn counts_of(refinement: &Refinement, table: &PatchTable) -> Counts {
    let mut patches = [0; 4];
    for face in &table.faces {
        let first = if face.kind == Kind::Bicubic { 0 } else { 2 };
        patches[first] += 1;
        patches[first + 1] += u64::from(face.transition != 0);
    }
    Counts {
        affected: refinement.fates.iter().flatten().filter(|&f| f & fate::AFFECTED != 0).count() as u64,
        max_level: table.faces.iter().map(|face| u64::from(face.level)).max().unwrap_or(0),
        patches,
        control_points: table.control.len() as u64,
    }
}

/// The edits that frames apply anew, one a frame.
struct Replay {
    kind: EditsFlag,
    geometry: Vec<GeometryEdit>,
    colours: Vec<ColourEdit>,
    // Colour edits by vertex: a vertex changes as a whole, or its sectors would drift apart and become sharp.
    vertices: Vec<Vec<usize>>,
}

impl Replay {
    fn new(loaded: &Loaded, kind: EditsFlag) -> Result<Replay, Failure> {
        let scene = &loaded.scene;
        let none = |what: &str| {
            Err(Failure::input(format_args!("{}: no {what} edits to replay; use --edits rebuild", loaded.file)))
        };
        if kind == EditsFlag::Geometry && scene.geometry.is_empty() {
            return none("geometry");
        }
        if kind == EditsFlag::Colour && scene.colours.is_empty() {
            return none("colour");
        }
        let map = IndexMap::new(&loaded.mesh);
        let mut vertices: BTreeMap<_, Vec<usize>> = BTreeMap::new();
        if kind == EditsFlag::Colour {
            for (i, edit) in scene.colours.iter().enumerate() {
                // Refinement has already found every half-edge.
                if let Some(slot) = map.from_app_a(edit.level, edit.half_edge) {
                    vertices.entry((edit.level, map.birth(edit.level, slot))).or_default().push(i);
                }
            }
        }
        Ok(Replay {
            kind,
            geometry: scene.geometry.clone(),
            colours: scene.colours.clone(),
            vertices: vertices.into_values().collect(),
        })
    }

    /// What makes the scene that of frame `i`, in which all edits are as in the file but one; and the number of edits
    /// changed.
    fn edits(&self, i: u32, before: Option<u32>) -> (Vec<ValueEdit>, u64) {
        // The golden angle visits all phases evenly.
        let wave = (f64::from(i) * 2.399_963).sin();
        let mut edits = Vec::new();
        match self.kind {
            EditsFlag::None | EditsFlag::Rebuild => return (edits, 0),
            EditsFlag::Geometry => {
                let at = |i: u32| i as usize % self.geometry.len();
                if let Some(before) = before {
                    let e = &self.geometry[at(before)];
                    edits.push(ValueEdit::Geometry(at(before) as u32, [e.a, e.b]));
                }
                // A hundredth of an edge in sectors; of the angle and length beyond the boundary.
                let e = &self.geometry[at(i)];
                edits.push(ValueEdit::Geometry(at(i) as u32, [e.a + 0.01 * wave, e.b * (1.0 + 0.01 * wave)]));
            }
            EditsFlag::Colour => {
                let at = |i: u32| &self.vertices[i as usize % self.vertices.len()];
                for &k in before.map(at).into_iter().flatten() {
                    edits.push(ValueEdit::Colour(k as u32, self.colours[k].colour));
                }
                // Towards grey, so that equal colours stay equal and all stay in range.
                for &k in at(i) {
                    let c = self.colours[k].colour;
                    let grey = glam::DVec4::new(0.5, 0.5, 0.5, c.w);
                    edits.push(ValueEdit::Colour(k as u32, c + (grey - c) * 0.02 * (1.0 + wave)));
                }
            }
        }
        (edits, 1)
    }
}

/// A subdivision scene in one configuration.
pub struct SubdivisionSource {
    loaded: Loaded,
    options: Options,
    irregular: Irregular,
    rules: RulesFlag,
    transitions: Transitions,
    replay: Replay,
    replayed: Option<u32>,
    made: Option<(Refinement, PatchTable)>,
    /// What edits are followed in, with --local.
    state: Option<State>,
    /// The last frame's table: memory for the next one.
    spare: PatchTable,
    latest: Counts,
    // As in its file.
    first: Counts,
}

impl SubdivisionSource {
    /// The scene and its patches.
    pub fn new(mut loaded: Loaded, config: &Config) -> Result<(SubdivisionSource, PatchTable), Failure> {
        if config.copies() > 1 {
            let failed = |e: MeshError| Failure::input(format_args!("{}: {e}", loaded.file));
            let sheet = copies(&loaded.scene, config.copies()).map_err(failed)?;
            loaded.mesh = mesh::build(&sheet.mesh).map_err(failed)?;
            loaded.scene = sheet;
        }
        let refining = config.refining();
        let options = loaded.options(&refining)?;
        let irregular = match refining.patches {
            PatchesFlag::Gregory => Irregular::Gregory,
            PatchesFlag::Bicubic => Irregular::Bicubic,
        };
        let refinement = loaded.refine(options)?;
        let table = build(&refinement, irregular);
        let counts = counts_of(&refinement, &table);
        let transitions = config.transitions();
        let table = transitions.of(table);
        let replay = Replay::new(&loaded, config.edits())?;
        let state = match (config.local(), config.edits()) {
            (false, _) => None,
            (true, _) if transitions != Transitions::Constellations => {
                return Err(Failure::input("--local updates constellations; leave out --transitions remap"))
            }
            (true, EditsFlag::Geometry | EditsFlag::Colour) => {
                let mut state = State::new(loaded.scene.clone(), options, irregular).map_err(Failure::input)?;
                state.prepare();
                Some(state)
            }
            _ => return Err(Failure::input("--local follows edits; give --edits geometry or colour")),
        };
        let rules = refining.rules;
        let (replayed, made) = (None, None);
        let source = SubdivisionSource {
            loaded,
            options,
            irregular,
            rules,
            transitions,
            replay,
            replayed,
            made,
            state,
            spare: PatchTable::default(),
            latest: counts,
            first: counts,
        };
        Ok((source, table))
    }

    /// Tessellation of the configuration; `matched`: by the number of triangles of uniform subdivision.
    pub fn tess(&self, table: &PatchTable, config: &Config, matched: bool) -> Result<TessRule, Failure> {
        match (matched, config.tess()) {
            (false, given) => Ok(given.unwrap_or(TessRule::Fixed(16.0))),
            (true, given) if config.is_global() => Ok(given.unwrap_or(TessRule::Fixed(1.0))),
            (true, given) => matching(&self.loaded, table, config, given.unwrap_or(TessRule::Fixed(1.0))),
        }
    }
}

impl Source for SubdivisionSource {
    fn name(&self) -> &str {
        &self.loaded.scene.name
    }

    fn facts(&self) -> Facts {
        let scene = &self.loaded.scene;
        let mut edits = String::new();
        for e in &scene.geometry {
            let _ = writeln!(edits, "g {} {} {:?} {:?} {:?}", e.level, e.half_edge, e.frame, e.a, e.b);
        }
        for e in &scene.colours {
            let _ = writeln!(edits, "c {} {} {:?}", e.level, e.half_edge, e.colour.to_array());
        }
        let global = IndexMap::new(&self.loaded.mesh).faces(self.loaded.global_level());
        Facts {
            name: scene.name.clone(),
            file: self.loaded.file.clone(),
            technique: "subdivision",
            rules: match self.rules {
                RulesFlag::Authors => "authors",
                RulesFlag::Gradtess => "gradtess",
            },
            patches: match self.irregular {
                Irregular::Gregory => "gregory",
                Irregular::Bicubic => "bicubic",
            },
            spacing: "equal",
            counts: row(self.first.patches, global),
            edits,
        }
    }

    fn counts(&self) -> Counts {
        // Edits that are followed in place change none of them.
        self.made.as_ref().map_or(self.latest, |(refinement, table)| counts_of(refinement, table))
    }

    fn edit(
        &mut self,
        i: u32,
        gpu: &Gpu,
        table: &mut DeviceTable,
        fields: &mut Fields,
        lap: &mut dyn FnMut() -> Option<f64>,
    ) -> Result<(), Failure> {
        let (edits, changed_edits) = self.replay.edits(i, self.replayed);
        fields.edits = Some(changed_edits);
        self.replayed = Some(i);
        if let Some(state) = &mut self.state {
            fields.cpu_edit_ms = lap();
            let outcome = state.apply(&Delta::of(edits)).map_err(Failure::input)?;
            let both = lap();
            if let Outcome::Local(touched) = outcome {
                let [_, patches] = touched.times.map(|t| t.as_secs_f64() * 1e3);
                fields.cpu_patch_ms = Some(patches);
                fields.cpu_refine_ms = both.map(|ms| ms - patches);
                let changed = &touched.changed;
                let uploaded = match changed.indices.is_empty() {
                    true => gpu.update_points(table, &state.table, &changed.control),
                    // Colours became equal or stopped being so: other patches.
                    false => gpu.update_parts(table, &state.table, &changed.control, &changed.indices),
                }?;
                fields.edits_in_place = Some(changed_edits);
                fields.upload_bytes = Some(uploaded.bytes);
                fields.faces_touched = Some(touched.faces as u64);
                fields.patches_changed = Some(touched.patches as u64);
            } else {
                fields.edits_in_place = Some(0);
                fields.cpu_refine_ms = both;
                gpu.update(table, &state.table)?;
            }
            fields.cpu_upload_ms = lap();
            return Ok(());
        }
        edits.iter().for_each(|e| e.write(&mut self.loaded.scene));
        fields.edits_in_place = Some(0);
        fields.cpu_edit_ms = lap();
        let refinement = self.loaded.refine(self.options)?;
        fields.cpu_refine_ms = lap();
        let made = self.transitions.of(rebuild(&refinement, self.irregular, std::mem::take(&mut self.spare)));
        fields.cpu_patch_ms = lap();
        gpu.update(table, &made)?;
        fields.cpu_upload_ms = lap();
        fields.upload_bytes = Some(table.bytes());
        fields.faces_touched = Some(made.faces.len() as u64);
        fields.patches_changed = Some(made.ranges.iter().map(|r| u64::from(r.count)).sum());
        self.made = Some((refinement, made));
        Ok(())
    }

    fn let_go(&mut self) {
        if let Some((_, table)) = self.made.take() {
            self.spare = table;
        }
    }
}

/// The base level at which adaptive refinement has the triangles of uniform subdivision drawn by `rule`, or just exceeds them.
fn matching(loaded: &Loaded, table: &PatchTable, config: &Config, rule: TessRule) -> Result<TessRule, Failure> {
    rule.check().map_err(Failure::input)?;
    let level = config.level().unwrap_or_else(|| loaded.global_level());
    let faces = IndexMap::new(&loaded.mesh).faces(level.min(crate::refine::edits::MAX_LEVEL));
    let wanted = triangles::uniform(faces, level, rule).ok_or_else(|| {
        Failure::input("--match-triangles needs a tessellation that can be counted; use --tess or --tess-base")
    })?;
    let base = triangles::matching_base(table, wanted).ok_or_else(|| {
        Failure::input(format_args!(
            "{}: no tessellation of the adaptive patches makes more than {wanted} triangles; give uniform subdivision a lower --tess or --level",
            loaded.file
        ))
    })?;
    Ok(TessRule::Base(base as f32))
}
