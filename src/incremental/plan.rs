//! Edits that come and go: which faces are asked for, by cause, and the faces of the levels that come and go with them.
//!
//! A face is refined while something asks for it: an edit, the colours of a vertex, a meeting of sharp edges, a polygon
//! ([`Causes`]). So an edit that comes or goes is one cause more or less ([`super::asked`]), whatever else is there.

use super::grow::{grow, shrink, Changes};
use super::index::{Index, Source};
use crate::mesh::{HalfEdgeMesh, NONE};
use crate::refine::edits::{resolve, resolve_paint, Move, Paint};
use crate::refine::forest::Causes;
use crate::refine::meetings::{Birth, Stars};
use crate::refine::{fate, fate_of, Refinement};
use crate::scene::Scene;
use crate::subdiv::index_map::IndexMap;
use crate::subdiv::level::{Level, CUT};

/// The plan by its causes.
#[derive(Clone)]
pub struct Plan {
    pub(super) causes: Causes,
    /// What sharp edges reach, once someone asked.
    pub(super) stars: Option<Stars>,
    /// How many meetings of sharp edges there are among them.
    pub(super) meetings: usize,
    /// Levels of isolation.
    pub(super) isolate: u32,
}

impl Plan {
    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.causes.bytes() + self.stars.as_ref().map_or(0, Stars::bytes)
    }
}

/// Colour edits and tags that come or go.
pub(super) struct Recount<'a> {
    /// All colour edits of the vertices that have others now, as they were; then as they are.
    pub paints: [&'a [Vec<Paint>]; 2],
    /// Tags that go and come.
    pub tags: [&'a [u32]; 2],
}

/// All colour edits of a vertex, by level, the input's colours among them.
pub(super) fn paints_of(index: &Index, scene: &Scene, mesh: &HalfEdgeMesh, vertex: Birth) -> Vec<(Source, Paint)> {
    let map = IndexMap::new(mesh);
    let entries = index.entries.get(&vertex).into_iter().flatten();
    let paint = |&i: &u32| {
        let paint = resolve_paint(i as usize, &scene.colours[i as usize], &map).expect("it fits the mesh");
        (Source::Edit(i), paint)
    };
    let mut paints: Vec<(Source, Paint)> = entries.map(paint).collect();
    if vertex.0 == 0 && !scene.corner_colours.is_empty() && map.is_colour_vertex(0, vertex.1) {
        let own = paints.len();
        map.around(0, vertex.1, |slot| {
            if paints[..own].iter().all(|(_, p)| (p.level, p.slot) != (0, slot)) {
                let h = (slot >> 3) as u32;
                let colour = scene.corner_colours[h as usize];
                paints.push((Source::Corner(h), Paint { level: 0, slot, vertex, colour }));
            }
        });
    }
    paints.sort_by_key(|(_, p)| p.level);
    paints
}

/// Whether the same sectors have equal colours in both.
pub(super) fn alike(a: &[(Source, Paint)], b: &[(Source, Paint)]) -> bool {
    let same = |(_, p): &(Source, Paint), (_, q): &(Source, Paint)| (p.level, p.slot) == (q.level, q.slot);
    let equal = |list: &[(Source, Paint)], i: usize, j: usize| {
        list[i].1.level == list[j].1.level && list[i].1.colour == list[j].1.colour
    };
    a.len() == b.len()
        && a.iter().zip(b).all(|(p, q)| same(p, q))
        && (0..a.len()).all(|i| (0..i).all(|j| equal(a, i, j) == equal(b, i, j)))
}

impl Index {
    /// Makes the plan unless it is there. Time linear in the levels.
    pub(super) fn make_plan(&mut self, scene: &Scene, mesh: &HalfEdgeMesh, refinement: &Refinement, isolate: u32) {
        if self.plan.is_none() {
            let map = IndexMap::new(mesh);
            let mut causes = Causes::new(&map, scene.corners, isolate);
            self.begin_asking(causes.of_shape(&map), refinement);
            self.plan = Some(Box::new(Plan { causes, stars: None, meetings: 0, isolate }));
        }
    }

    /// Counts what sharp edges reach, unless that is known, in the scene as the index has it. Time linear in its edits.
    pub(super) fn count_stars(&mut self, scene: &Scene, mesh: &HalfEdgeMesh) {
        let plan = self.plan.as_mut().expect("there is one");
        if plan.stars.is_none() {
            let map = IndexMap::new(mesh);
            let edits = resolve(scene, &map).expect("they fit the mesh");
            let mut stars = Stars::default();
            scene.sharp.iter().for_each(|&h| stars.count_tag(&map, h, true, |_| {}));
            stars.count_paints(&map, &edits.paints, true, |_| {});
            plan.meetings = stars.vertices().filter(|&v| stars.meeting(&map, v, scene.corners).is_some()).count();
            plan.stars = Some(stars);
        }
    }

    /// Whether isolation follows from more than each edit by itself.
    pub(super) fn has_isolated_meetings(&self) -> bool {
        self.plan.as_ref().is_some_and(|plan| plan.isolate > 0 && plan.meetings > 0)
    }

    /// Follows colour edits and tags that come and go: adds the names of the faces of each level that they ask for no longer
    /// to `went`, and of those that they do to `came`.
    pub(super) fn recount(
        &mut self,
        scene: &Scene,
        mesh: &HalfEdgeMesh,
        recount: &Recount,
        went: &mut Vec<Vec<Vec<u64>>>,
        came: &mut Vec<Vec<Vec<u64>>>,
    ) {
        let Plan { causes, stars, meetings, .. } = &mut **self.plan.as_mut().expect("there is one");
        let stars = stars.as_mut().expect("they were counted");
        let map = IndexMap::new(mesh);
        let mut reached: Vec<Birth> = Vec::new();
        // Before anything is counted anew, whom it reaches.
        let mut trial = Stars::default();
        for (tags, paints) in recount.tags.into_iter().zip(recount.paints) {
            tags.iter().for_each(|&h| trial.count_tag(&map, h, true, |v| reached.push(v)));
            paints.iter().for_each(|paints| trial.count_paints(&map, paints, true, |v| reached.push(v)));
        }
        reached.sort_unstable();
        reached.dedup();
        let before: Vec<_> = reached.iter().map(|&v| stars.meeting(&map, v, scene.corners)).collect();
        for (more, (tags, paints)) in [false, true].into_iter().zip(recount.tags.into_iter().zip(recount.paints)) {
            tags.iter().for_each(|&h| stars.count_tag(&map, h, more, |_| {}));
            for paints in paints.iter().filter(|paints| !paints.is_empty()) {
                stars.count_paints(&map, paints, more, |_| {});
                let names = if more { &mut *came } else { &mut *went };
                names.push(causes.of_paints(&map, paints).to_vec());
            }
        }
        for (v, before) in reached.into_iter().zip(before) {
            let now = stars.meeting(&map, v, scene.corners);
            if now != before {
                *meetings = *meetings + usize::from(now.is_some()) - usize::from(before.is_some());
                went.extend(before.map(|m| causes.of_meeting(&map, &m).to_vec()));
                came.extend(now.map(|m| causes.of_meeting(&map, &m).to_vec()));
            }
        }
    }

    /// Names of the faces of each level that a geometry edit asks for.
    pub(super) fn asked_by(&mut self, mesh: &HalfEdgeMesh, m: &Move) -> Vec<Vec<u64>> {
        let plan = self.plan.as_mut().expect("there is one");
        plan.causes.of_move(&IndexMap::new(mesh), m).to_vec()
    }

    /// Instead of colour edits `old`, the scene has `new` from entry `at` on from now on; `behind`: others follow.
    pub(super) fn renumber_entries(&mut self, at: usize, old: &[Paint], new: &[Paint], behind: bool) {
        let (at, end, by) = (at as u32, (at + old.len()) as u32, new.len() as i64 - old.len() as i64);
        for p in old {
            if let Some(entries) = self.entries.get_mut(&p.vertex) {
                entries.retain(|&i| i < at || i >= end);
                if entries.is_empty() {
                    self.entries.remove(&p.vertex);
                }
            }
        }
        if behind && by != 0 {
            let moved = self.entries.values_mut().flatten().filter(|i| **i >= end);
            moved.for_each(|i| *i = (i64::from(*i) + by) as u32);
        }
        for (p, i) in new.iter().zip(at..) {
            let entries = self.entries.entry(p.vertex).or_default();
            entries.insert(entries.partition_point(|&e| e < i), i);
        }
    }

    /// Makes the faces below those that are asked for now.
    pub(super) fn rise(&mut self, refinement: &mut Refinement, added: &[Vec<Vec<u64>>], changes: &mut Changes) {
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
                        grow(refinement, &mut self.levels, l, v, changes);
                    }
                }
            }
        }
    }

    /// Takes the faces away that nothing asks for any more.
    pub(super) fn fall(
        &mut self,
        scene: &Scene,
        mesh: &HalfEdgeMesh,
        refinement: &mut Refinement,
        removed: &[Vec<Vec<u64>>],
        changes: &mut Changes,
    ) {
        let left = self.ask_less(scene, mesh, refinement, removed);
        for (l, mut fallen) in left.into_iter().enumerate().rev() {
            fallen.retain(|&f| self.levels[l].asked[f as usize] == 0);
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
        let planned = self.plan.is_some();
        let mut draw = vec![Vec::new(); refinement.levels.len()];
        for (l, draw) in draw.iter_mut().enumerate() {
            let (level, own) = (&refinement.levels[l], &self.levels[l]);
            let (fates, rules) = (&mut refinement.fates[l], refinement.rules);
            let around: &[bool] = if l == 0 { &self.around_polygons } else { &[] };
            let mut dirty = std::mem::take(&mut changes.dirty(l).faces);
            dirty.sort_unstable();
            dirty.dedup();
            for &f in dirty.iter().filter(|&&f| level.face[f as usize] != u64::MAX) {
                // Without a plan none comes or goes.
                let affected = |f: u32| match planned {
                    true => own.asked[f as usize] > 0,
                    false => fates[f as usize] & fate::AFFECTED != 0,
                };
                let now = fate_of(level, f, affected, around, refinement.corners, rules);
                let before = std::mem::replace(&mut fates[f as usize], now);
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
