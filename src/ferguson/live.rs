//! A patch table that follows the edits of a mesh: an edit costs what it touches, however large the mesh is.
//!
//! ```text
//!   Mesh --edit--> Journal --touched--> LiveTable::update --> Update: which control points to send again
//! ```
//!
//! Every patch has 32 control points of its own, its slot, so that nothing moves when another one changes; neighbours meet
//! without cracks because they evaluate the same numbers, not because they share an index. Each component has a run of
//! slots with room to grow, so that what lies on top stays on top.

use super::fit::Target;
use super::mesh::{HalfEdge, Journal, Mesh, NONE};
use super::table::{points, table};
use crate::patch::{DrawRange, Kind, PatchTable};
use std::collections::BTreeSet;
use std::ops::Range;

/// Control points of a slot.
const SLOT: usize = 32;

/// The slots of a component.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Layer {
    first: u32,
    used: u32,
    room: u32,
}

/// A patch table that can be changed in parts.
#[derive(Clone, Debug)]
pub struct LiveTable {
    table: PatchTable,
    target: Target,
    /// Patches of the mesh; empty where the table is made anew each time.
    slot_of: Vec<u32>,
    layer_of: Vec<u32>,
    patch_of: Vec<u32>,
    layers: Vec<Layer>,
}

/// What an edit changed in a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Update {
    /// Patches whose control points are others now, ascending; without those that are gone.
    pub patches: Vec<u32>,
    /// Patches that were looked at: the work that was done.
    pub examined: usize,
    /// Control points to be sent again, ascending and apart; empty if `whole`.
    pub control: Vec<Range<usize>>,
    /// The whole table is another: control points, indices and ranges.
    pub whole: bool,
}

impl Journal {
    /// Numbers of the patches that an edit may have changed on the screen: those with a record of their own in it, new
    /// ones, and those along its curves, whose T-sections are others now. To follow an undo, ask before [`Mesh::undo`].
    pub fn touched(&self, mesh: &Mesh) -> BTreeSet<u32> {
        let count = |n: usize| n as u32;
        let mut all: BTreeSet<u32> = self.changed().collect();
        all.extend(count(self.lengths[2])..count(mesh.patches.len()));
        for (c, old) in &self.curves {
            let now = mesh.curves.get(*c as usize).map(|curve| &curve.sides);
            all.extend(old.sides.iter().chain(now.into_iter().flatten()).flatten().map(|h| h.patch()));
        }
        for curve in mesh.curves.iter().skip(self.lengths[1]) {
            all.extend(curve.sides.iter().flatten().map(|h| h.patch()));
        }
        all
    }
}

impl LiveTable {
    /// The table of a mesh. Time linear in the patches.
    pub fn new(mesh: &Mesh, target: Target) -> LiveTable {
        let empty = LiveTable {
            table: PatchTable::default(),
            target,
            slot_of: Vec::new(),
            layer_of: Vec::new(),
            patch_of: Vec::new(),
            layers: Vec::new(),
        };
        let cut = mesh.live().any(|p| mesh.has_to_be_cut(p, &target).is_some());
        if cut {
            return LiveTable { table: table(&mesh.fit(&target), &target), ..empty };
        }
        let mut live = LiveTable { layer_of: mesh.component(), ..empty };
        live.slot_of = vec![NONE; mesh.patches.len()];
        live.table.colour = mesh.colour;
        let layers = live.layer_of.iter().filter(|&&l| l != NONE).max().map_or(0, |&l| l as usize + 1);
        let mut used = vec![0; layers];
        mesh.live().for_each(|p| used[live.layer_of[p as usize] as usize] += 1);
        let mut first = 0;
        for used in used {
            // Half as many again, so that growing is rare.
            let room = used + used / 2 + 16;
            let range = DrawRange { kind: Kind::Stitched, part: None, level: 0, first: SLOT as u32 * first, count: 0 };
            live.layers.push(Layer { first, used: 0, room });
            live.table.ranges.push(range);
            first += room;
        }
        live.patch_of = vec![NONE; first as usize];
        live.table.control = vec![[0.0; 8]; SLOT * first as usize];
        live.table.indices = (0..SLOT as u32 * first).collect();
        for p in mesh.live() {
            let slot = live.claim(p).unwrap_or_default();
            live.write(mesh, p, slot);
        }
        live
    }

    /// The table as it is now. Of a mesh without virtual patches, a range holds a whole component, whatever its levels, and
    /// faces have no entries.
    pub fn table(&self) -> &PatchTable {
        &self.table
    }

    /// Follows a view: another target for the same mesh. `large` are the patches that may be seen and
    /// [`Target::may_be_cut`] says may be cut. Only patches with T-sections have other control points then, and those only
    /// where the scale is another; the whole table is made anew where patches are virtually subdivided, before or now.
    pub fn retarget(&mut self, mesh: &Mesh, target: Target, large: &[u32]) -> Update {
        let old = std::mem::replace(&mut self.target, target);
        let finer = (old.rule, old.scale) != (target.rule, target.scale);
        let has_sections = |p: &u32| mesh.patch(*p).sides.iter().any(|side| mesh.has_sections(side.curve));
        let stitched: Vec<u32> = if finer { mesh.live().filter(has_sections).collect() } else { Vec::new() };
        let cut = |p: &u32| mesh.has_to_be_cut(*p, &target).is_some();
        if self.layers.is_empty() || large.iter().any(cut) || stitched.iter().any(cut) {
            *self = LiveTable::new(mesh, target);
            return Update { whole: true, ..Update::default() };
        }
        let mut update = Update { examined: large.len() + stitched.len(), ..Update::default() };
        let mut slots = BTreeSet::new();
        for p in stitched {
            let slot = self.slot_of[p as usize];
            if self.write(mesh, p, slot) {
                slots.insert(slot);
                update.patches.push(p);
            }
        }
        update.control = runs(slots);
        update
    }

    /// Follows an edit of the mesh that may have changed the patches `touched` ([`Journal::touched`]). The time depends on
    /// those alone, unless patches are virtually subdivided, or a component has outgrown its room.
    pub fn update(&mut self, mesh: &Mesh, touched: &BTreeSet<u32>) -> Update {
        let mut update = Update { examined: touched.len(), ..Update::default() };
        let there = |p: u32| mesh.patches.get(p as usize).is_some_and(|patch| patch.alive);
        let mut slots = BTreeSet::new();
        let local = !self.layers.is_empty()
            && touched.iter().filter(|&&p| there(p)).all(|&p| mesh.has_to_be_cut(p, &self.target).is_none());
        if !local || !self.follow(mesh, touched, &mut slots, &mut update) {
            let patches = touched.iter().copied().filter(|&p| there(p)).collect();
            *self = LiveTable::new(mesh, self.target);
            return Update { patches, control: Vec::new(), whole: true, ..update };
        }
        update.control = runs(slots);
        update
    }

    /// False: there is no room.
    fn follow(&mut self, mesh: &Mesh, touched: &BTreeSet<u32>, slots: &mut BTreeSet<u32>, update: &mut Update) -> bool {
        let there = |p: u32| mesh.patches.get(p as usize).is_some_and(|patch| patch.alive);
        // What is gone goes first, so that its slots can be used again.
        for &p in touched.iter().filter(|&&p| !there(p)) {
            slots.extend(self.release(p));
        }
        let n = mesh.patches.len();
        self.slot_of.resize(n, NONE);
        self.layer_of.resize(n, NONE);
        for &p in touched.iter().filter(|&&p| there(p)) {
            let known = self.slot_of[p as usize];
            let slot = match known {
                NONE => {
                    let beside =
                        (0..4).flat_map(|i| mesh.curve(mesh.side(HalfEdge::new(p, i)).curve).sides.iter().flatten());
                    let layers = beside.map(|h| self.layer_of[h.patch() as usize]);
                    self.layer_of[p as usize] = layers.filter(|&l| l != NONE).min().unwrap_or(NONE);
                    let Some(slot) = self.claim(p) else { return false };
                    slot
                }
                slot => slot,
            };
            if self.write(mesh, p, slot) || known == NONE {
                slots.insert(slot);
                update.patches.push(p);
            }
        }
        true
    }

    /// A slot for a patch that has none; `None`: its component has no room.
    fn claim(&mut self, p: u32) -> Option<u32> {
        let number = self.layer_of[p as usize] as usize;
        let layer = self.layers.get_mut(number).filter(|layer| layer.used < layer.room)?;
        let slot = layer.first + layer.used;
        layer.used += 1;
        self.table.ranges[number].count = layer.used;
        self.slot_of[p as usize] = slot;
        self.patch_of[slot as usize] = p;
        Some(slot)
    }

    /// Takes the slot of a patch that is gone away; the last of its component moves there. The slot that was written.
    fn release(&mut self, p: u32) -> Option<u32> {
        let slot = self.slot_of.get(p as usize).copied().filter(|&slot| slot != NONE)?;
        let number = self.layer_of[p as usize] as usize;
        let layer = &mut self.layers[number];
        layer.used -= 1;
        let last = layer.first + layer.used;
        self.table.ranges[number].count = layer.used;
        self.slot_of[p as usize] = NONE;
        let moved = std::mem::replace(&mut self.patch_of[last as usize], NONE);
        if last == slot {
            return None;
        }
        self.slot_of[moved as usize] = slot;
        self.patch_of[slot as usize] = moved;
        let from = SLOT * last as usize;
        self.table.control.copy_within(from..from + SLOT, SLOT * slot as usize);
        Some(slot)
    }

    /// Writes a patch into its slot; whether that changed anything.
    fn write(&mut self, mesh: &Mesh, p: u32, slot: u32) -> bool {
        let new = points(mesh, p, &self.target);
        let old = &mut self.table.control[SLOT * slot as usize..][..SLOT];
        let changed = old != new;
        old.copy_from_slice(&new);
        changed
    }
}

/// The control points of slots, neighbours together.
fn runs(slots: BTreeSet<u32>) -> Vec<Range<usize>> {
    let mut all: Vec<Range<usize>> = Vec::new();
    for slot in slots {
        let range = SLOT * slot as usize..SLOT * (slot as usize + 1);
        match all.last_mut().filter(|last| last.end == range.start) {
            Some(last) => last.end = range.end,
            None => all.push(range),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ferguson::inherit::Continuity;
    use crate::ferguson::split::Axis;
    use glam::{DVec2, DVec4};

    fn grid(n: u32) -> Mesh {
        let colour = |i: u32, j: u32| DVec4::new(f64::from(i % 2), f64::from(j % 2), 0.5, 1.0);
        let mut mesh = Mesh::grid(n, n, [0.0, 0.0, 1.0, 1.0], colour).unwrap();
        mesh.take_journal();
        mesh
    }

    /// Every patch is in one slot with its own points, in the run of its component.
    fn sound(live: &LiveTable, mesh: &Mesh) {
        let components = mesh.component();
        let mut seen = 0;
        for p in mesh.live() {
            let slot = live.slot_of[p as usize];
            assert_eq!(live.patch_of[slot as usize], p);
            assert_eq!(live.table.control[SLOT * slot as usize..][..SLOT], points(mesh, p, &live.target), "patch {p}");
            let layer = live.layers[live.layer_of[p as usize] as usize];
            assert_eq!(live.layer_of[p as usize], components[p as usize]);
            assert!((layer.first..layer.first + layer.used).contains(&slot));
            seen += 1;
        }
        assert_eq!(live.table.ranges.iter().map(|r| r.count).sum::<u32>(), seen);
    }

    fn follow(live: &mut LiveTable, mesh: &mut Mesh) -> Update {
        let touched = mesh.take_journal().touched(mesh);
        live.update(mesh, &touched)
    }

    #[test]
    fn an_edit_of_ten_thousand_patches_sends_the_few_that_change() {
        let mut mesh = grid(100);
        let mut live = LiveTable::new(&mesh, Target::default());
        mesh.split(5050, Axis::U, 0.5).unwrap();
        let split = follow(&mut live, &mut mesh);
        // Both halves, and the neighbours below and above, which have a T-section now.
        assert_eq!((split.patches, split.whole), (vec![4950, 5050, 5150, 10_000], false));
        assert!(split.examined <= 6 && split.control.iter().map(Range::len).sum::<usize>() == 4 * 32);

        let c = mesh.patch(5050).sides[3].curve;
        mesh.move_handle(c, 0, mesh.curve(c).handles[0] + DVec2::new(1e-3, 0.0), Continuity::C1).unwrap();
        let drag = follow(&mut live, &mut mesh);
        // Two along the curve, two along the mirrored one, and the other half at its T-section.
        assert_eq!((drag.patches, drag.whole), (vec![4949, 4950, 5049, 5050, 10_000], false));
        assert!(drag.examined <= 8, "{}", drag.examined);

        let point = mesh.patch(3333).corners[0].point;
        mesh.set_colour(point, DVec4::ONE, Continuity::C1).unwrap();
        let colour = follow(&mut live, &mut mesh);
        assert_eq!((colour.patches.len(), colour.examined), (4, 4));
        sound(&live, &mesh);
    }

    #[test]
    fn the_table_follows_edits_of_all_kinds_and_their_undoing() {
        let mut mesh = grid(4);
        // A second component over the first.
        let more = Mesh::grid(2, 1, [0.2, 0.2, 0.8, 0.5], |_, _| DVec4::ONE).unwrap();
        let written = crate::scene::ferguson::write(&more);
        let (more, _) = crate::scene::ferguson::parse(written.as_bytes(), "x").unwrap();
        mesh = together(&mesh, &more);
        let mut live = LiveTable::new(&mesh, Target::default());
        let mut random = crate::timing::random::Random::new(3);
        let mut below = |n: usize| (random.unit() * n as f64) as usize;
        let (mut undone, mut removed, mut kept) = (0, 0, Vec::new());
        for _ in 0..300 {
            let live_patches: Vec<u32> = mesh.live().collect();
            let (p, c) = (live_patches[below(live_patches.len())], below(mesh.curves.len()) as u32);
            match below(5) {
                0 | 1 if mesh.patch(p).extent().iter().all(|&e| e > 1e-3) => {
                    mesh.split(p, [Axis::U, Axis::V][below(2)], 0.5).unwrap();
                }
                2 => removed += usize::from(mesh.remove_split(c).is_ok()),
                3 => drop(mesh.move_handle(c, 0, mesh.curve(c).handles[0] + DVec2::splat(1e-3), Continuity::C1)),
                _ if !kept.is_empty() && below(2) == 0 => {
                    mesh.take_journal();
                    let journal: Journal = kept.pop().unwrap();
                    let touched = journal.touched(&mesh);
                    mesh.undo(journal);
                    live.update(&mesh, &touched);
                    undone += 1;
                    sound(&live, &mesh);
                    continue;
                }
                _ => drop(mesh.move_point(p, mesh.at(p) + DVec2::splat(1e-3), Continuity::C0)),
            }
            let journal = mesh.take_journal();
            let touched = journal.touched(&mesh);
            live.update(&mesh, &touched);
            kept.push(journal);
            sound(&live, &mesh);
        }
        assert!(undone > 20 && removed > 2, "{undone} {removed}");
    }

    /// Two meshes side by side in one.
    fn together(a: &Mesh, b: &Mesh) -> Mesh {
        let quads = |m: &Mesh, by: u32| m.patches.iter().map(|p| p.corners.map(|c| c.point + by)).collect::<Vec<_>>();
        let points: Vec<DVec2> = a.points.iter().chain(&b.points).map(|p| p.at).collect();
        let all = [quads(a, 0), quads(b, a.points.len() as u32)].concat();
        let mut mesh = Mesh::from_quads(&points, &all, &[]).unwrap();
        mesh.take_journal();
        mesh
    }

    /// Views of all sizes: whatever is skipped would have come out the same.
    #[test]
    fn the_table_follows_views_and_only_sections_change() {
        let mut mesh = grid(6);
        for p in [7, 8, 14, 21] {
            mesh.split(p, Axis::U, 0.25).unwrap();
            mesh.split(p, Axis::V, 0.5).unwrap();
        }
        mesh.take_journal();
        let rule = crate::patch::tess::TessRule::Pixels(5.0);
        let target = |scale: f64, x: f64| Target {
            rule,
            scale: [scale; 2],
            view: Some([x, x, x + 600.0 / scale, x + 600.0 / scale]),
        };
        let mut live = LiveTable::new(&mesh, target(300.0, 0.0));
        let mut random = crate::timing::random::Random::new(8);
        let (mut whole, mut still, mut few) = (0, 0, 0);
        for _ in 0..150 {
            let scale = [200.0, 300.0, 400.0, 500.0, 4000.0][(random.unit() * 5.0) as usize];
            let next = target(scale, random.unit());
            // All patches may be seen as far as this list goes: a longer one changes nothing.
            let size = |p: &u32| {
                let net = mesh.geometry(*p);
                net.into_iter().reduce(DVec2::max).unwrap() - net.into_iter().reduce(DVec2::min).unwrap()
            };
            let large: Vec<u32> = mesh.live().filter(|p| next.may_be_cut(size(p))).collect();
            let before = live.table.control.clone();
            let update = live.retarget(&mesh, next, &large);
            let fresh = LiveTable::new(&mesh, next);
            assert_eq!(
                (live.layers.is_empty(), live.table.ranges.len()),
                (fresh.layers.is_empty(), fresh.table.ranges.len())
            );
            if live.layers.is_empty() {
                assert!(update.whole && live.table.control == fresh.table.control);
                whole += 1;
                continue;
            }
            sound(&live, &mesh);
            if !update.whole {
                let changed: Vec<usize> = (0..before.len()).filter(|&i| before[i] != live.table.control[i]).collect();
                assert!(changed.iter().all(|i| update.control.iter().any(|run| run.contains(i))));
                still += usize::from(changed.is_empty());
                few += usize::from(!changed.is_empty());
                assert!(update.patches.len() < 30);
            }
        }
        assert!(whole > 10 && still > 5 && few > 20, "{whole} {still} {few}");
    }

    #[test]
    fn patches_too_large_for_a_device_are_made_anew() {
        let mut mesh = grid(2);
        let target = Target { rule: crate::patch::tess::TessRule::Pixels(1.0), scale: [1000.0; 2], view: None };
        let mut live = LiveTable::new(&mesh, target);
        assert!(live.table().faces.len() > 4);
        mesh.split(0, Axis::U, 0.5).unwrap();
        let update = follow(&mut live, &mut mesh);
        assert!(update.whole && update.control.is_empty());
        assert_eq!(live.table().control, table(&mesh.fit(&target), &target).control);
    }
}
