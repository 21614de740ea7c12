//! Who makes a control point: the coarsest face drawn, and of several cores that refine runs of faces the first.

use super::super::pool::{Maker, LENT};
use super::super::runs::own;
use super::{pair, Counts, Irregular, Points, Style, REVERSED};
use crate::mesh::NONE;
use crate::refine::fate;
use crate::subdiv::fan::Fan;
use crate::subdiv::level::{Level, CUT};
use crate::threads;
use std::ops::Range;

impl<'a> Points<'a> {
    /// Nothing made yet. `fates` are those of the level's faces.
    pub fn new(level: &'a Level, fates: &'a [u8], style: Style) -> Self {
        Points {
            corner: vec![NONE; level.value.len()],
            place: vec![NONE; level.vertices()],
            edge: vec![NONE; level.half_edges()],
            ..Points::bare(level, fates, style)
        }
    }

    /// For values only: keeps no account of what is made.
    pub(in crate::patch) fn bare(level: &'a Level, fates: &'a [u8], style: Style) -> Self {
        Points {
            level,
            fates,
            style,
            run: 0,
            first: 0,
            maker: &[],
            corner: Vec::new(),
            place: Vec::new(),
            edge: Vec::new(),
            positions: Fan::default(),
            colours: Fan::default(),
            fan_vertex: NONE,
            fan_tint: NONE,
        }
    }

    /// The same account for run number `run`, of these faces; `maker` is the run that makes the corner of each tint.
    pub(in crate::patch) fn of_run<'b>(&self, run: u8, faces: &Range<usize>, maker: &'b [u8]) -> Points<'b>
    where
        'a: 'b,
    {
        let [first, end] = [faces.start, faces.end].map(|f| self.level.first(f as u32));
        Points {
            run,
            first,
            maker,
            corner: self.corner.clone(),
            place: self.place.clone(),
            edge: self.edge[first as usize..end as usize].to_vec(),
            ..Points::bare(self.level, self.fates, self.style)
        }
    }

    /// Replaces lent numbers of edges.
    pub(in crate::patch) fn settle_edges(&mut self, numbers: &[u32]) {
        for e in self.edge.iter_mut().filter(|e| **e != NONE && **e & LENT != 0) {
            // A lent pair stands in the order of its half-edge, the maker's own in that of the twin.
            *e = own(*e & !REVERSED, numbers) | REVERSED;
        }
    }

    /// Takes over the corners that runs made, whose numbers are final where they are not lent, and the edges that they share
    /// with the faces `after` them.
    pub(in crate::patch) fn merge(&mut self, runs: &[Points], after: &Range<usize>) {
        let level = self.level;
        if !after.is_empty() {
            let edges = |h: u32| runs.iter().rev().find(|r| r.first <= h).map_or(NONE, |r| r.edge_of(h));
            let [first, end] = [after.start, after.end].map(|f| level.first(f as u32));
            threads::update(&mut self.edge[first as usize..end as usize], |i, edge| {
                let h = first + i as u32;
                let twin = level.twin[h as usize];
                if twin < first && !level.colour_border(h) && *edge == NONE {
                    *edge = match edges(twin) {
                        NONE => NONE,
                        e if e & REVERSED == 0 => (e + 1) | REVERSED,
                        e => (e & !REVERSED) - 1,
                    };
                }
            });
        }
        let final_ = |e: &u32| *e != NONE && e & LENT == 0;
        threads::update(&mut self.corner, |i, x| *x = runs.iter().map(|r| r.corner[i]).find(final_).unwrap_or(NONE));
        threads::update(&mut self.place, |i, x| *x = runs.iter().map(|r| r.place[i]).find(final_).unwrap_or(NONE));
    }

    /// Whether a face is drawn by four corners, and so makes all points of its edges and corners that are not there yet.
    pub(super) fn draws(&self, f: u32) -> bool {
        self.fates[f as usize] & fate::DRAWN != 0 && self.level.valence(f) == 4
    }

    /// What a run of faces will make.
    pub(in crate::patch) fn count(&self, faces: Range<usize>) -> Counts {
        let level = self.level;
        let mut counts = Counts { seen: vec![false; level.value.len()], ..Counts::default() };
        for f in (faces.start as u32..faces.end as u32).filter(|&f| self.draws(f)) {
            let fate = self.fates[f as usize];
            let gregory = fate & fate::IRREGULAR != 0 && self.style.irregular == Irregular::Gregory;
            counts.faces += 1;
            counts.plain += usize::from(!gregory && fate >> fate::TRANSITION == 0);
            counts.points += if gregory { 8 } else { 4 };
            for h in level.of_face(f) {
                let twin = level.twin[h as usize];
                let made = twin < h && !level.colour_border(h) && self.draws(level.face_of(twin));
                if !made && self.edge[h as usize] == NONE {
                    counts.points += 2;
                }
                counts.seen[level.tint[h as usize] as usize] = true;
            }
        }
        counts
    }

    /// For each tint the first run that has seen it, which makes its corner unless that is there, and how many corners
    /// each run makes.
    pub(in crate::patch) fn makers(&self, counts: &[Counts]) -> (Vec<u8>, Vec<usize>) {
        let first = |tint: usize| counts.iter().position(|c| c.seen[tint]).map_or(u8::MAX, |run| run as u8);
        let makers = threads::collect(self.corner.len(), first);
        let of = |tints: Range<usize>| {
            let mut corners = vec![0; counts.len()];
            for (maker, corner) in makers[tints.clone()].iter().zip(&self.corner[tints]) {
                if *corner == NONE && *maker != u8::MAX {
                    corners[*maker as usize] += 1;
                }
            }
            corners
        };
        let parts = threads::each(threads::pieces(makers.len()), of);
        let corners = (0..counts.len()).map(|run| parts.iter().map(|p: &Vec<usize>| p[run]).sum()).collect();
        (makers, corners)
    }

    /// An earlier run that makes the corner of `tint`.
    #[inline]
    pub(super) fn corner_maker(&self, tint: u32) -> Option<Maker> {
        let run = *self.maker.get(tint as usize)?;
        (run < self.run).then_some(Maker::Corner(tint, run))
    }

    /// Half-edge of the face of an earlier run that makes the points of the edge of `h`.
    #[inline]
    pub(super) fn edge_maker(&self, h: u32) -> Option<u32> {
        let twin = self.level.twin[h as usize];
        (twin < self.first && !self.level.colour_border(h) && self.draws(self.level.face_of(twin))).then_some(twin)
    }

    /// Final numbers of what `maker`, whose face is in this run, made.
    pub(in crate::patch) fn made(&self, maker: Maker) -> impl Iterator<Item = u32> {
        let (numbers, n) = match maker {
            Maker::Corner(tint, _) => ([self.corner[tint as usize], NONE], 1),
            Maker::Edge(t) => {
                let [near, far] = pair(self.edge_of(t));
                ([far, near], 2)
            }
        };
        debug_assert!(numbers[..n].iter().all(|i| *i < LENT), "the maker is the first to make it");
        numbers.into_iter().take(n)
    }

    #[inline]
    pub(super) fn edge_of(&self, h: u32) -> u32 {
        self.edge.get(h.wrapping_sub(self.first) as usize).copied().unwrap_or(NONE)
    }

    /// Half-edges of other runs are not accounted for.
    #[inline]
    pub(super) fn set_edge(&mut self, h: u32, edge: u32) {
        if let Some(e) = self.edge.get_mut(h.wrapping_sub(self.first) as usize) {
            *e = edge;
        }
    }

    /// An edge's two points, which are final, are from now on those of `h` and of the face across unless a border runs
    /// along it.
    pub(super) fn note_edge(&mut self, h: u32, first: u32) {
        self.set_edge(h, first);
        if !self.level.colour_border(h) {
            self.set_edge(self.level.twin[h as usize], (first + 1) | REVERSED);
        }
    }

    pub(super) fn note_corner(&mut self, h: u32, index: u32) {
        self.corner[self.level.tint[h as usize] as usize] = index;
        let place = &mut self.place[self.level.origin[h as usize] as usize];
        if *place == NONE {
            *place = index;
        }
    }

    /// Takes over what a coarser face made of one of its edges: near and far point of its first half, the middle, near and
    /// far of the second; the halves are `first` and `second`.
    pub(in crate::patch) fn note_split(&mut self, first: u32, second: u32, split: [u32; 5]) {
        self.note_edge(first, split[0]);
        self.note_corner(first + 1, split[2]);
        self.note_edge(second, split[3]);
    }

    /// Takes over the corners that coarser faces made.
    pub fn inherit(&mut self, coarse: &Points) {
        // Few do: only around what is drawn coarser.
        let handed_down = |half_edges: Range<usize>| {
            let mut found = Vec::new();
            for h in half_edges.filter(|&h| coarse.level.child[h] < CUT) {
                let place = coarse.place[coarse.level.origin[h] as usize];
                let corner = coarse.corner[coarse.level.tint[h] as usize];
                if place != NONE || corner != NONE {
                    found.push((4 * coarse.level.child[h] as usize, place, corner));
                }
            }
            found
        };
        for found in threads::each(threads::pieces(coarse.level.half_edges()), handed_down) {
            for (first, place, corner) in found {
                if place != NONE {
                    self.place[self.level.origin[first] as usize] = place;
                }
                if corner != NONE {
                    self.corner[self.level.tint[first] as usize] = corner;
                }
            }
        }
    }
}
