//! The plan by several cores: each marks what the edits of a run of input half-edges ask for, in a forest of its own.
//!
//! Every rule of the plan has a single premise, a marked face, so the union of the shares, each closed by itself, is the
//! plan, whoever marked what. A vertex that sharp edges reach may be reached by the edits of two runs: those of others than
//! its own hand it over before anybody asks whether edges meet there.

use super::{close, mark_meeting, mark_paints, mark_polygons, Forest, NONE};
use crate::refine::edits::{Edits, Paint};
use crate::refine::meetings::{Birth, Meeting, Star, Stars};
use crate::refine::{Rules, EDIT_FACES};
use crate::scene::CornerRule;
use crate::subdiv::index_map::IndexMap;
use crate::threads;
use std::ops::Range;

/// What marks faces.
pub(super) struct Reasons<'a> {
    map: &'a IndexMap<'a>,
    edits: &'a Edits,
    /// Input half-edge that each vertex with colours is at, and its colour edits.
    groups: Vec<(u32, &'a [Paint])>,
    sharp: &'a [u32],
    rules: Rules,
    corners: CornerRule,
    extraordinary: &'a [bool],
}

/// A colour edit marks about as much as so many geometry edits.
const PAINT: u32 = 4;

impl<'a> Reasons<'a> {
    /// `extraordinary` is needed by [`Rules::Gradtess`] only.
    pub fn new(
        map: &'a IndexMap<'a>,
        edits: &'a Edits,
        sharp: &'a [u32],
        rules: Rules,
        corners: CornerRule,
        extraordinary: &'a [bool],
    ) -> Self {
        let groups = edits.paints.chunk_by(|a, b| a.vertex == b.vertex);
        let groups = groups.map(|group| (map.home(group[0].vertex.0, group[0].vertex.1), group)).collect();
        Reasons { map, edits, groups, sharp, rules, corners, extraordinary }
    }

    /// Everything marked, and the meetings of sharp edges.
    pub fn mark(&self) -> (Forest, Vec<Meeting>) {
        let runs = self.runs();
        let stars = match self.rules {
            Rules::Gradtess => self.stars(&runs),
            Rules::Authors => runs.iter().map(|_| Stars::default()).collect(),
        };
        let shares = threads::each(runs.into_iter().zip(stars).collect(), |(run, stars)| self.share(run, &stars));
        let mut shares = shares.into_iter();
        let (mut forest, mut meetings) = shares.next().expect("one run at least");
        for (share, more) in shares {
            forest.unite(&share);
            meetings.extend(more);
        }
        (forest, meetings)
    }

    /// Runs of input half-edges that are about equally much to mark.
    fn runs(&self) -> Vec<Range<u32>> {
        let half_edges = self.map.mesh().half_edges();
        let moves = self.edits.moves.iter().filter(|m| m.level > 0).map(|m| (self.map.home(m.level, m.vertex), 1));
        let paints = self.groups.iter().map(|(home, group)| (*home, PAINT * group.len() as u32));
        let total = self.edits.moves.len() + PAINT as usize * self.edits.paints.len();
        let count = threads::pieces(total * EDIT_FACES).len();
        // Each run has a number for every half-edge of M^0, which must not be most of its work.
        if count == 1 || total < half_edges as usize / 8 {
            return std::iter::once(0..half_edges).collect();
        }
        let mut work = vec![0u32; half_edges as usize];
        moves.chain(paints).for_each(|(home, n)| work[home as usize] += n);
        let total: usize = work.iter().map(|&n| n as usize).sum();
        let mut runs = Vec::with_capacity(count);
        let (mut start, mut sum) = (0, 0);
        for (h, n) in (1..half_edges).zip(&work) {
            sum += *n as usize;
            if sum * count > total * (runs.len() + 1) {
                runs.push(start..h);
                start = h;
            }
        }
        runs.push(start..half_edges);
        runs
    }

    /// For each run the vertices at its half-edges that sharp edges reach.
    fn stars(&self, runs: &[Range<u32>]) -> Vec<Stars> {
        let counted = threads::each(runs.iter().collect(), |run| {
            let mut stars = Stars::default();
            for &h in self.sharp.iter().filter(|h| run.contains(h)) {
                stars.count_tag(self.map, h, true, |_| {});
            }
            for (_, group) in self.groups.iter().filter(|(home, _)| run.contains(home)) {
                stars.count_paints(self.map, group, true, |_| {});
            }
            let others = match runs.len() {
                1 => Vec::new(),
                _ => stars.take(|birth| !run.contains(&self.map.home(birth.0, birth.1))),
            };
            (stars, others)
        });
        let (mut stars, others): (Vec<Stars>, Vec<Vec<(Birth, Star)>>) = counted.into_iter().unzip();
        for (birth, star) in others.into_iter().flatten() {
            let home = self.map.home(birth.0, birth.1);
            stars[runs.partition_point(|run| run.end <= home)].add(birth, &star);
        }
        stars
    }

    fn share(&self, run: Range<u32>, stars: &Stars) -> (Forest, Vec<Meeting>) {
        let map = self.map;
        let mut forest = Forest::new(map);
        for m in self.edits.moves.iter().filter(|m| m.level > 0 && run.contains(&map.home(m.level, m.vertex))) {
            forest.mark_two_ring(map, m.level, m.vertex);
        }
        for (_, group) in self.groups.iter().filter(|(home, _)| run.contains(home)) {
            mark_paints(&mut forest, map, group, self.rules);
        }
        mark_polygons(&mut forest, map, &run);
        if self.rules == Rules::Authors {
            return (forest, Vec::new());
        }
        let meetings = stars.meetings(map, self.corners);
        for m in &meetings {
            mark_meeting(&mut forest, map, m);
        }
        close(&mut forest, map, self.extraordinary);
        (forest, meetings)
    }
}

impl Forest {
    /// Marks what another forest of the same mesh has marked.
    fn unite(&mut self, other: &Forest) {
        for &f in other.by_level.first().into_iter().flatten() {
            if !self.level0[f as usize] {
                self.level0[f as usize] = true;
                self.by_level[0].push(f);
            }
        }
        let mut both = Vec::new();
        for &root in other.by_level.get(1).into_iter().flatten() {
            let theirs = other.root[root as usize];
            let mut own = self.root[root as usize];
            if own == NONE {
                own = self.grow(1, root);
                self.root[root as usize] = own;
            }
            both.push((1, root, own, theirs));
        }
        while let Some((level, name, own, theirs)) = both.pop() {
            for (s, &below) in (0..4).zip(&other.child[theirs as usize]).filter(|(_, below)| **below != NONE) {
                let name = name << 2 | s;
                let mut node = self.child[own as usize][s as usize];
                if node == NONE {
                    node = self.grow(level + 1, name);
                    self.child[own as usize][s as usize] = node;
                }
                both.push((level + 1, name, node, below));
            }
        }
    }
}
