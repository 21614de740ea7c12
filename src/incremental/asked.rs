//! How many causes ask for each face to be refined, as far as anyone needs to know.
//!
//! A face that was refined before the first edit came or went is asked for by one cause at least. That will do until more
//! causes have gone than have come since; only then those around it are looked up and counted.
//!
//! # How far causes reach
//!
//! In steps from a face to one that shares a vertex with it, the faces that an edit of M^l marks in M^(l-1) have parents
//! within 3 of its own, and in each level above grading and the cascade ([`crate::refine::forest`]) lead to 4 at most,
//! since two steps among children are one among their parents. Four steps of M^0 end within two rings of input faces;
//! isolation adds the faces around a vertex and what refining those brings, four steps more at most. Further away are only
//! faces that polygons bring: they are asked for as long as the mesh is what it is.

use super::index::Index;
use super::memory::roomy;
use super::plan::{paints_of, Plan};
use crate::mesh::{HalfEdgeMesh, NONE};
use crate::refine::edits::resolve_move;
use crate::refine::{fate, Refinement};
use crate::scene::Scene;
use crate::subdiv::index_map::{IndexMap, Slot};
use std::collections::{HashMap, HashSet};

/// Of a face that something asked for from the beginning, plus what came and less what went since.
const OPEN: u32 = 1 << 31;
/// The same of a face that the shape of the mesh asks for.
const FIXED: u32 = 3 << 30;
/// Rings of input faces within which an edit's faces lie.
const RINGS: usize = 2;
/// With isolation.
const MORE_RINGS: usize = 4;

/// Whether more causes have gone than came, of a face that was not counted.
fn is_in_doubt(asked: u32) -> bool {
    (OPEN / 2..OPEN).contains(&asked)
}

impl Index {
    /// From the fates at hand. Time linear in the levels.
    pub(super) fn begin_asking(&mut self, shape: &[Vec<u64>], refinement: &Refinement) {
        for (own, fates) in self.levels.iter_mut().zip(&refinement.fates) {
            own.asked = roomy(fates.iter().map(|&fate| if fate & fate::AFFECTED != 0 { OPEN } else { 0 }));
        }
        for (l, names) in shape.iter().enumerate() {
            for f in names.iter().filter_map(|&name| refinement.find(l as u32, name)) {
                self.levels[l].asked[f as usize] = FIXED;
            }
        }
    }

    /// One cause less for each face of each level that is named: those that lost some, in ascending order. Afterwards it is
    /// known of each whether one is left.
    pub(super) fn ask_less(
        &mut self,
        scene: &Scene,
        mesh: &HalfEdgeMesh,
        refinement: &Refinement,
        removed: &[Vec<Vec<u64>>],
    ) -> Vec<Vec<u32>> {
        let mut left = vec![Vec::new(); removed.iter().map(Vec::len).max().unwrap_or(0)];
        for (l, names) in removed.iter().flat_map(|names| names.iter().enumerate()) {
            for &name in names {
                let f = refinement.find(l as u32, name).expect("what is asked for is there");
                self.levels[l].asked[f as usize] -= 1;
                left[l].push(f);
            }
        }
        let mut doubts = HashMap::new();
        for (l, left) in left.iter_mut().enumerate() {
            left.sort_unstable();
            left.dedup();
            for &f in left.iter().filter(|&&f| is_in_doubt(self.levels[l].asked[f as usize])) {
                doubts.insert((l, refinement.levels[l].face[f as usize]), (f, 0));
            }
        }
        if !doubts.is_empty() {
            self.count_causes(scene, mesh, refinement, &mut doubts);
            for ((l, _), (f, asked)) in doubts {
                self.levels[l].asked[f as usize] = asked;
            }
        }
        left
    }

    /// Counts how many causes ask for faces, by level and name. Looks at the place of each edit, and closely at those
    /// nearby.
    fn count_causes(
        &mut self,
        scene: &Scene,
        mesh: &HalfEdgeMesh,
        refinement: &Refinement,
        doubts: &mut HashMap<(usize, u64), (u32, u32)>,
    ) {
        self.count_stars(scene, mesh);
        let mut plan = self.plan.take().expect("there is one");
        let Plan { causes, stars, isolate, .. } = &mut *plan;
        let rings = if *isolate > 0 { MORE_RINGS } else { RINGS };
        let stars = stars.as_ref().expect("just counted");
        let map = IndexMap::new(mesh);
        let first = |(l, name)| crate::refine::forest::first_slot(&map, l as u32, name);
        let home = |level: u32, slot: Slot| mesh.face[map.home(level, slot) as usize];
        let near = self.near(mesh, rings, doubts.keys().map(|&(l, name)| home(l as u32, first((l, name)))));
        let is_near = |level: u32, slot: Slot| near.contains(&home(level, slot));
        let mut count = |names: &[Vec<u64>]| {
            for (l, names) in names.iter().enumerate() {
                for &name in names {
                    if let Some((_, asked)) = doubts.get_mut(&(l, name)) {
                        *asked += 1;
                    }
                }
            }
        };
        // Edits of M^0 ask for nothing.
        for (own, level) in self.levels.iter().zip(&refinement.levels).skip(1) {
            for m in own.moves.iter().filter(|m| m.entry != NONE) {
                let h = m.local.half_edge;
                if is_near(level.level, 4 * level.face[h as usize >> 2] + u64::from(h & 3)) {
                    let entry = m.entry as usize;
                    let m = resolve_move(entry, &scene.geometry[entry], &map).expect("it fits the mesh");
                    count(causes.of_move(&map, &m));
                }
            }
        }
        for &vertex in self.entries.keys().filter(|v| is_near(v.0, v.1)) {
            let paints: Vec<_> = paints_of(self, scene, mesh, vertex).into_iter().map(|p| p.1).collect();
            count(causes.of_paints(&map, &paints));
        }
        for vertex in stars.vertices().filter(|v| is_near(v.0, v.1)) {
            if let Some(m) = stars.meeting(&map, vertex, scene.corners) {
                count(causes.of_meeting(&map, &m));
            }
        }
        self.plan = Some(plan);
    }

    /// Input faces within some rings of others.
    fn near(&self, mesh: &HalfEdgeMesh, rings: usize, faces: impl Iterator<Item = u32>) -> HashSet<u32> {
        let mut near: HashSet<u32> = faces.collect();
        let mut front: Vec<u32> = near.iter().copied().collect();
        for _ in 0..rings {
            let corners = front.iter().flat_map(|&f| mesh.face_start[f as usize]..mesh.face_start[f as usize + 1]);
            let spokes = corners.flat_map(|h| self.input.of(mesh.origin[h as usize]));
            front = spokes.map(|&h| mesh.face[h as usize]).filter(|&f| near.insert(f)).collect();
        }
        near
    }
}
