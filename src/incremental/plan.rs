//! Edits that come and go: which faces are asked for, counted by cause, and the faces of the levels that come and go with
//! them.
//!
//! A face is refined while something asks for it: an edit, the colours of a vertex, a meeting of sharp edges, a polygon
//! ([`Causes`]). So an edit that comes or goes is one cause more or less, whatever else is there.

use super::grow::{grow, shrink, Changes};
use super::index::Index;
use super::memory::{of, of_map};
use crate::mesh::{HalfEdgeMesh, NONE};
use crate::refine::edits::{resolve, resolve_paint, Move, Paint};
use crate::refine::forest::Causes;
use crate::refine::meetings::meetings;
use crate::refine::{around_polygons, fate, fate_of, Refinement};
use crate::scene::Scene;
use crate::subdiv::index_map::{IndexMap, Slot};
use crate::subdiv::level::{Level, CUT};
use std::collections::HashMap;
use std::ops::Range;

/// The plan by its causes.
#[derive(Clone)]
pub struct Plan {
    causes: Causes,
    /// Vertices of M^0 around faces that are no quads.
    around_polygons: Vec<bool>,
    /// Entries of [`Scene::colours`] of each vertex, ascending; of no vertex that has none.
    painted: HashMap<Birth, Vec<u32>>,
}

/// First level of a vertex and its least slot there.
type Birth = (u32, Slot);

impl Plan {
    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let entries: usize = self.painted.values().map(of).sum();
        self.causes.bytes() + of(&self.around_polygons) + of_map(&self.painted) + entries
    }
}

impl Index {
    /// Counts the causes of the plan unless they are counted. Time linear in what they ask for. `None`: the scene's edits
    /// do not fit it.
    pub(super) fn count_causes(&mut self, scene: &Scene, mesh: &HalfEdgeMesh, refinement: &Refinement) -> Option<()> {
        if self.plan.is_some() {
            return Some(());
        }
        let map = IndexMap::new(mesh);
        let edits = resolve(scene, &map).ok()?;
        for (own, level) in self.levels.iter_mut().zip(&refinement.levels) {
            own.asked = vec![0; level.faces()];
        }
        let mut causes = Causes::new(&map, scene.corners);
        let levels = &mut self.levels;
        let mut count = |names: &[Vec<u64>]| {
            for (l, names) in names.iter().enumerate() {
                for &name in names {
                    let f = refinement.find(l as u32, name)?;
                    levels[l].asked[f as usize] += 1;
                }
            }
            Some(())
        };
        count(causes.of_polygons(&map))?;
        for m in &edits.moves {
            count(causes.of_move(&map, m))?;
        }
        for group in edits.paints.chunk_by(|a, b| a.vertex == b.vertex) {
            count(causes.of_paints(&map, group))?;
        }
        for m in meetings(&map, &edits.paints, &scene.sharp, scene.corners) {
            count(causes.of_meeting(&map, &m))?;
        }
        let around_polygons = around_polygons(&refinement.levels[0]);
        let mut painted: HashMap<Birth, Vec<u32>> = HashMap::new();
        for (i, e) in scene.colours.iter().enumerate() {
            painted.entry(resolve_paint(i, e, &map).ok()?.vertex).or_default().push(i as u32);
        }
        self.plan = Some(Box::new(Plan { causes, around_polygons, painted }));
        Some(())
    }

    /// Names of the faces of each level that a geometry edit asks for.
    pub(super) fn asked_by(&mut self, mesh: &HalfEdgeMesh, m: &Move) -> Vec<Vec<u64>> {
        let plan = self.plan.as_mut().expect("the causes are counted");
        plan.causes.of_move(&IndexMap::new(mesh), m).to_vec()
    }

    /// Names of the faces of each level that the colour edits of a vertex ask for.
    pub(super) fn asked_by_colours(&mut self, scene: &Scene, mesh: &HalfEdgeMesh, vertex: Birth) -> Vec<Vec<u64>> {
        let plan = self.plan.as_mut().expect("the causes are counted");
        let map = IndexMap::new(mesh);
        let entries = plan.painted.get(&vertex).map_or(&[][..], |list| list);
        let paint = |&i: &u32| resolve_paint(i as usize, &scene.colours[i as usize], &map).expect("it fits the mesh");
        let mut group: Vec<Paint> = entries.iter().map(paint).collect();
        group.sort_by_key(|p| p.level);
        if group.is_empty() {
            return Vec::new();
        }
        plan.causes.of_paints(&map, &group).to_vec()
    }

    /// Whether `paints` are of whole vertices, each with one colour all around, and the vertices have no other colour edit
    /// of their level: then no edge becomes sharp. `own`: entries in the scene that are `paints` themselves.
    pub(super) fn are_smooth(&self, scene: &Scene, mesh: &HalfEdgeMesh, paints: &[Paint], own: Range<usize>) -> bool {
        let plan = self.plan.as_ref().expect("the causes are counted");
        let map = IndexMap::new(mesh);
        paints.iter().all(|p| {
            let mut slots = Vec::new();
            map.around(p.level, p.slot, |s| slots.push(s));
            let same = paints.iter().filter(|q| (q.vertex, q.level) == (p.vertex, p.level));
            let entries = plan.painted.get(&p.vertex).into_iter().flatten();
            let mut others = entries.filter(|&&i| !own.contains(&(i as usize)));
            (p.level > 0 || scene.corner_colours.is_empty())
                && same.clone().count() == slots.len()
                && slots.iter().all(|s| same.clone().any(|q| q.slot == *s && q.colour == p.colour))
                && others.all(|&i| scene.colours[i as usize].level != p.level)
        })
    }

    /// Instead of colour edits `old`, the scene has `new` from entry `at` on from now on; `behind`: others follow.
    pub(super) fn recount_colours(&mut self, at: usize, old: &[Paint], new: &[Paint], behind: bool) {
        let plan = self.plan.as_mut().expect("the causes are counted");
        let (at, end, by) = (at as u32, (at + old.len()) as u32, new.len() as i64 - old.len() as i64);
        for p in old {
            if let Some(entries) = plan.painted.get_mut(&p.vertex) {
                entries.retain(|&i| i < at || i >= end);
                if entries.is_empty() {
                    plan.painted.remove(&p.vertex);
                }
            }
        }
        if behind && by != 0 {
            let moved = plan.painted.values_mut().flatten().filter(|i| **i >= end);
            moved.for_each(|i| *i = (i64::from(*i) + by) as u32);
        }
        for (p, i) in new.iter().zip(at..) {
            let entries = plan.painted.entry(p.vertex).or_default();
            entries.insert(entries.partition_point(|&e| e < i), i);
        }
    }

    /// Makes the faces below those that are asked for now. `None`: colours run through where faces would come.
    pub(super) fn rise(
        &mut self,
        refinement: &mut Refinement,
        added: &[Vec<Vec<u64>>],
        changes: &mut Changes,
    ) -> Option<()> {
        let deepest = added.iter().map(Vec::len).max().unwrap_or(0);
        for l in 0..deepest {
            let mut risen = Vec::new();
            for &name in added.iter().filter_map(|names| names.get(l)).flatten() {
                let f = refinement.find(l as u32, name).expect("its parent is asked for, too");
                let asked = &mut self.levels[l].asked[f as usize];
                *asked += 1;
                if *asked == 1 {
                    risen.push(f);
                }
            }
            if risen.is_empty() {
                continue;
            }
            if refinement.levels.len() == l + 1 {
                refinement.levels.push(Level { level: l as u32 + 1, ..Level::default() });
                refinement.fates.push(Vec::new());
                self.push_level(refinement.levels.last().expect("just made"));
            }
            let level = &mut refinement.levels[l];
            level.child.resize(level.half_edges(), NONE);
            for &f in &risen {
                changes.turned(refinement, l, f, true);
            }
            for &f in &risen {
                for h in refinement.levels[l].of_face(f) {
                    if refinement.levels[l].child[h as usize] >= CUT {
                        let v = refinement.levels[l].origin[h as usize];
                        grow(refinement, &mut self.levels, l, v, changes)?;
                    }
                }
            }
        }
        Some(())
    }

    /// Takes the faces away that nothing asks for any more.
    pub(super) fn fall(&mut self, refinement: &mut Refinement, removed: &[Vec<Vec<u64>>], changes: &mut Changes) {
        let deepest = removed.iter().map(Vec::len).max().unwrap_or(0);
        for l in (0..deepest).rev() {
            let mut fallen = Vec::new();
            for &name in removed.iter().filter_map(|names| names.get(l)).flatten() {
                let f = refinement.find(l as u32, name).expect("what is asked for is there");
                let asked = &mut self.levels[l].asked[f as usize];
                *asked -= 1;
                if *asked == 0 {
                    fallen.push(f);
                }
            }
            for &f in &fallen {
                changes.turned(refinement, l, f, false);
            }
            for &f in &fallen {
                for h in refinement.levels[l].of_face(f) {
                    let level = &refinement.levels[l];
                    let v = level.origin[h as usize];
                    let own = &self.levels[l];
                    let needed = own.around.of(v).iter().any(|&h| own.asked[level.face_of(h) as usize] > 0);
                    if !needed && level.child[h as usize] < CUT {
                        shrink(refinement, &mut self.levels, l, v, changes);
                    }
                }
            }
        }
    }

    /// Drops the deepest levels if nothing is left of them.
    pub(super) fn trim(&mut self, refinement: &mut Refinement) {
        while refinement.levels.len() > 1 {
            let above = refinement.levels.len() - 2;
            if refinement.levels[above + 1].faces() > self.levels[above + 1].free_faces.len() {
                break;
            }
            refinement.levels.pop();
            refinement.fates.pop();
            self.levels.pop();
        }
    }

    /// Decides what becomes of the faces that changed and of their neighbours: those to draw anew, by level.
    pub(super) fn decide(&mut self, refinement: &mut Refinement, changes: &mut Changes) -> Vec<Vec<u32>> {
        let plan = self.plan.as_ref().expect("the causes are counted");
        let mut draw = vec![Vec::new(); refinement.levels.len()];
        for (l, draw) in draw.iter_mut().enumerate() {
            let (level, own) = (&refinement.levels[l], &self.levels[l]);
            let around: &[bool] = if l == 0 { &plan.around_polygons } else { &[] };
            let mut dirty = std::mem::take(&mut changes.dirty(l).faces);
            dirty.sort_unstable();
            dirty.dedup();
            for &f in dirty.iter().filter(|&&f| level.face[f as usize] != u64::MAX) {
                let affected = |f: u32| own.asked[f as usize] > 0;
                let now = fate_of(level, f, affected, around, refinement.corners);
                let before = std::mem::replace(&mut refinement.fates[l][f as usize], now);
                let entry = own.drawn[f as usize];
                let drawn = now & fate::DRAWN != 0 && level.valence(f) == 4;
                if now != before || drawn != (entry != NONE) {
                    if drawn {
                        draw.push(f);
                    }
                    if entry != NONE {
                        changes.gone.push((l as u32, f));
                    }
                }
            }
        }
        draw
    }
}
