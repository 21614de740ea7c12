//! Locally refinable gradient meshes: an edit changes the table where the mesh changes.

use super::config::{Config, EditsFlag};
use super::source::{row, Counts, Facts, Source};
use crate::command::ferguson::open::{refuse, rule, target, Ferguson};
use crate::command::{Failure, ModeFlag};
use crate::ferguson::fit::Target;
use crate::ferguson::inherit::Continuity;
use crate::ferguson::live::LiveTable;
use crate::ferguson::mesh::{HalfEdge, Journal, Mesh};
use crate::ferguson::table::table;
use crate::ferguson::traditional::{propagated, traditional};
use crate::gpu::{DeviceTable, Frame, Gpu};
use crate::patch::remap::Transitions;
use crate::patch::tess::TessRule;
use crate::patch::PatchTable;
use crate::timing::record::Fields;
use glam::DVec4;

/// A gradient mesh in one configuration.
pub struct FergusonSource {
    file: String,
    mesh: Mesh,
    kind: EditsFlag,
    live: LiveTable,
    target: Target,
    /// What takes back the edit of the frame before.
    undo: Option<Journal>,
    /// Ends of curves with a handle, and points with a colour.
    handles: Vec<(u32, usize)>,
    points: Vec<u32>,
    traditional: u64,
    /// Patches that the last edit changed.
    changed: u64,
}

impl FergusonSource {
    /// The mesh and its patches. `--mode global` is the traditional gradient mesh, where every split runs through its row.
    pub fn new(
        file: &str,
        ferguson: Ferguson,
        config: &Config,
        frame: impl Fn(&PatchTable) -> Result<Frame, Failure>,
    ) -> Result<(FergusonSource, PatchTable, Frame), Failure> {
        let mut refining = config.refining();
        refining.mode = ModeFlag::Adaptive;
        refuse(&refining)?;
        if config.transitions() != Transitions::Constellations {
            return Err(Failure::input("--transitions goes with scenes of technique subdivision"));
        }
        if config.local() || config.copies() > 1 {
            return Err(Failure::input("--local and --copies go with subdivision scenes; leave them out"));
        }
        let mut mesh = if config.is_global() { propagated(&ferguson.mesh) } else { ferguson.mesh };
        mesh.take_journal();
        let mut frame = frame(&table(&mesh, &Target::default()))?;
        frame.tess = rule(config.tess().unwrap_or(TessRule::Fixed(16.0)))?;
        let target = target(frame.tess, frame.view, [frame.width, frame.height]);
        let live = LiveTable::new(&mesh, target);
        let alive = |c: u32| mesh.curve(c).sides.iter().any(|list| !list.is_empty());
        let free = |point: u32| mesh.points[point as usize].on.is_none();
        let curves = (0..mesh.curves.len() as u32).filter(|&c| alive(c));
        let ends = curves.flat_map(|c| [(c, 0), (c, 1)]);
        let source = FergusonSource {
            file: file.to_owned(),
            kind: config.edits(),
            target,
            undo: None,
            handles: ends.filter(|&(c, end)| free(mesh.curve(c).ends[end])).collect(),
            points: (0..mesh.points.len() as u32)
                .filter(|&p| free(p) && !mesh.points[p as usize].corners.is_empty())
                .collect(),
            traditional: traditional(&mesh),
            changed: 0,
            mesh,
            live,
        };
        let table = source.live.table().clone();
        Ok((source, table, frame))
    }

    /// Changes one handle or one colour by a little.
    fn change(&mut self, i: u32) -> Result<(), Failure> {
        // The golden angle visits all phases evenly.
        let wave = (f64::from(i) * 2.399_963).sin();
        let done = if self.kind == EditsFlag::Geometry {
            let (c, end) = self.handles[i as usize % self.handles.len()];
            let (handle, point) = (self.mesh.curve(c).handles[end], self.mesh.at(self.mesh.curve(c).ends[end]));
            self.mesh.move_handle(c, end, point + (handle - point) * (1.0 + 0.03 * (1.2 + wave)), Continuity::C1)
        } else {
            let point = self.points[i as usize % self.points.len()];
            let corner = self.mesh.points[point as usize].corners[0];
            let colour = self.mesh.corner(corner).colour.value;
            let grey = self.mesh.colour.space.encode(DVec4::new(0.5, 0.5, 0.5, 1.0), self.mesh.colour.premultiplied);
            self.mesh.set_colour(point, colour + (grey - colour) * 0.02 * (1.2 + wave), Continuity::C1)
        };
        done.map_err(Failure::input)
    }
}

impl Source for FergusonSource {
    fn name(&self) -> &str {
        &self.mesh.name
    }

    fn facts(&self) -> Facts {
        Facts {
            name: self.mesh.name.clone(),
            file: self.file.clone(),
            technique: "ferguson",
            rules: "none",
            patches: "bicubic",
            spacing: "fractional_even",
            counts: row(self.counts().patches, self.traditional),
            // A mesh has no list of edits: what was done to it is in it.
            edits: String::new(),
        }
    }

    fn counts(&self) -> Counts {
        let sections = |p: u32| (0..4).any(|i| !self.mesh.sections(HalfEdge::new(p, i)).is_empty());
        Counts {
            affected: self.changed,
            max_level: self.mesh.live().map(|p| u64::from(self.mesh.patch(p).level())).max().unwrap_or(0),
            patches: [self.mesh.live().count() as u64, self.mesh.live().filter(|&p| sections(p)).count() as u64, 0, 0],
            control_points: self.live.table().ranges.iter().map(|r| u64::from(r.count) * r.stride() as u64).sum(),
        }
    }

    fn edit(
        &mut self,
        i: u32,
        gpu: &Gpu,
        table: &mut DeviceTable,
        fields: &mut Fields,
        lap: &mut dyn FnMut() -> Option<f64>,
    ) -> Result<(), Failure> {
        fields.edits_in_place = Some(0);
        if self.kind == EditsFlag::Rebuild {
            fields.edits = Some(0);
            fields.cpu_edit_ms = lap();
            self.live = LiveTable::new(&self.mesh, self.target);
            fields.cpu_patch_ms = lap();
            gpu.update(table, self.live.table())?;
            self.changed = self.mesh.live().count() as u64;
        } else {
            let mut touched = self.undo.as_ref().map(|journal| journal.touched(&self.mesh)).unwrap_or_default();
            if let Some(journal) = self.undo.take() {
                self.mesh.undo(journal);
            }
            self.change(i)?;
            let journal = self.mesh.take_journal();
            touched.extend(journal.touched(&self.mesh));
            self.undo = Some(journal);
            fields.edits = Some(1);
            fields.cpu_edit_ms = lap();
            let update = self.live.update(&self.mesh, &touched);
            self.changed = update.patches.len() as u64;
            fields.cpu_patch_ms = lap();
            if !update.whole {
                let points: Vec<u32> = update.control.iter().cloned().flatten().map(|i| i as u32).collect();
                let sent = gpu.update_points(table, self.live.table(), &points)?;
                fields.cpu_upload_ms = lap();
                fields.edits_in_place = Some(1);
                fields.upload_bytes = Some(sent.bytes);
                return Ok(());
            }
            gpu.update(table, self.live.table())?;
        }
        fields.cpu_upload_ms = lap();
        fields.upload_bytes = Some(table.bytes());
        Ok(())
    }
}
