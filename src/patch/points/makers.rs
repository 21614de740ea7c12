//! Who makes a control point: the coarsest face drawn, and of several cores that build runs of faces the first.

use super::super::pool::Maker;
use super::{pair, Account, Irregular, Own, Points, Style, COUNTED, REVERSED};
use crate::mesh::NONE;
use crate::refine::fate;
use crate::subdiv::level::{vertex_bits::BOUNDARY, Level, CUT};
use crate::threads;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

impl<'a> Account<'a> {
    /// Nothing made yet. `fates` are those of the level's faces.
    pub fn new(level: &'a Level, fates: &'a [u8], style: Style) -> Self {
        let nothing = |n: usize| threads::collect(n, |_| AtomicU32::new(NONE));
        Account {
            level,
            fates,
            style,
            corner: nothing(level.value.len()),
            place: nothing(level.vertices()),
            edge: nothing(level.half_edges()),
        }
    }

    /// Whether a face is drawn by four corners, and so makes all points of its edges and corners that are not there yet.
    #[inline]
    pub(super) fn draws(&self, f: u32) -> bool {
        self.fates[f as usize] & fate::DRAWN != 0 && self.level.valence(f) == 4
    }

    /// Whether [`Points::plain_face`] serves face `f`: a quad among quads, everything regular at its corners.
    #[inline(always)]
    pub fn is_plain(&self, f: u32) -> bool {
        let level = self.level;
        // At level 0 a corner may touch a face other than a quad.
        if self.fates[f as usize] & fate::IRREGULAR != 0 {
            return false;
        }
        let first = level.first(f) as usize;
        level.origin[first..first + 4].iter().fold(0, |bits, &v| bits | level.bits[v as usize]) & !BOUNDARY == 0
    }

    /// How many control points a run of faces will make; the runs of the level end at half-edge `own.beyond`. Marks its
    /// corners as counted.
    pub(in crate::patch) fn count(&self, faces: Range<usize>, start: u32) -> usize {
        let level = self.level;
        let mut count = 0;
        for f in (faces.start as u32..faces.end as u32).filter(|&f| self.draws(f)) {
            let gregory = self.fates[f as usize] & fate::IRREGULAR != 0 && self.style.irregular == Irregular::Gregory;
            count += if gregory { 8 } else { 4 };
            for h in level.of_face(f) {
                let twin = level.twin[h as usize];
                let made = twin < h && !level.colour_border(h) && self.draws(level.face_of(twin));
                if !made && self.edge[h as usize].load(Relaxed) == NONE {
                    count += 2;
                }
                // Those of earlier runs are left to these.
                let corner = &self.corner[level.tint[h as usize] as usize];
                if corner.load(Relaxed) == NONE && !self.is_of_run_before(start, h) {
                    corner.store(COUNTED, Relaxed);
                    count += 1;
                }
            }
        }
        count
    }

    /// Whether a face before half-edge `start` makes the corner at the origin of `h`.
    fn is_of_run_before(&self, start: u32, h: u32) -> bool {
        if start == 0 {
            return false;
        }
        let level = self.level;
        let tint = level.tint[h as usize];
        let makes = |s: u32| s < start && level.tint[s as usize] == tint && self.draws(level.face_of(s));
        let mut spoke = h;
        while let Some(s) = level.spoke_after(spoke) {
            if s == h {
                return false;
            }
            if makes(s) {
                return true;
            }
            spoke = s;
        }
        spoke = h;
        while let Some(s) = level.spoke_before(spoke) {
            if makes(s) {
                return true;
            }
            spoke = s;
        }
        false
    }

    /// Final numbers of what was lent, when all runs are done.
    pub(in crate::patch) fn made(&self, maker: Maker) -> impl Iterator<Item = u32> {
        let (numbers, n) = match maker {
            Maker::Corner(tint) => ([self.corner[tint as usize].load(Relaxed), NONE], 1),
            Maker::Edge(t) => {
                let [near, far] = pair(self.edge[t as usize].load(Relaxed));
                ([far, near], 2)
            }
        };
        numbers.into_iter().take(n)
    }

    #[inline(always)]
    pub(super) fn note_corner(&self, h: u32, index: u32) {
        self.corner[self.level.tint[h as usize] as usize].store(index, Relaxed);
        let place = &self.place[self.level.origin[h as usize] as usize];
        if place.load(Relaxed) == NONE {
            place.store(index, Relaxed);
        }
    }

    /// Takes over what a coarser face made of one of its edges: near and far point of its first half, the middle, near and
    /// far of the second; the halves are `first` and `second`.
    pub(in crate::patch) fn note_split(&self, first: u32, second: u32, split: [u32; 5]) {
        self.note_corner(first + 1, split[2]);
        for (h, near) in [(first, split[0]), (second, split[3])] {
            self.edge[h as usize].store(near, Relaxed);
            if !self.level.colour_border(h) {
                self.edge[self.level.twin[h as usize] as usize].store((near + 1) | REVERSED, Relaxed);
            }
        }
    }

    /// Takes over the corners that coarser faces made.
    pub fn inherit(&self, coarse: &Account) {
        threads::each(threads::pieces(coarse.level.half_edges()), |half_edges| {
            // All corners of a vertex hand down the same, so it does not matter whose core is the last.
            for h in half_edges.filter(|&h| coarse.level.child[h] < CUT) {
                let first = 4 * coarse.level.child[h] as usize;
                let place = coarse.place[coarse.level.origin[h] as usize].load(Relaxed);
                if place < COUNTED {
                    self.place[self.level.origin[first] as usize].store(place, Relaxed);
                }
                let corner = coarse.corner[coarse.level.tint[h] as usize].load(Relaxed);
                if corner < COUNTED {
                    self.corner[self.level.tint[first] as usize].store(corner, Relaxed);
                }
            }
        });
    }
}

impl Points<'_> {
    /// The corner of a tint if it is final or this run's own.
    #[inline(always)]
    pub(super) fn corner_of(&self, tint: u32) -> u32 {
        self.known(self.account.corner[tint as usize].load(Relaxed))
    }

    /// A point at the place of a vertex, likewise.
    #[inline(always)]
    pub(super) fn place_of(&self, vertex: u32) -> u32 {
        self.known(self.account.place[vertex as usize].load(Relaxed))
    }

    #[inline(always)]
    pub(super) fn known(&self, number: u32) -> u32 {
        let Own { before, points, .. } = &self.own;
        if number < *before || points.contains(&number) {
            number
        } else {
            NONE
        }
    }

    /// Whether an earlier run makes the corner at the origin of `h`.
    #[inline]
    pub(super) fn is_of_earlier(&self, h: u32) -> bool {
        self.account.is_of_run_before(self.own.half_edges.start, h)
    }

    /// Half-edge of the face of an earlier run that makes the points of the edge of `h`.
    #[inline]
    pub(super) fn edge_maker(&self, h: u32) -> Option<u32> {
        let twin = self.level.twin[h as usize];
        let earlier = twin < self.own.half_edges.start && !self.level.colour_border(h);
        (earlier && self.account.draws(self.level.face_of(twin))).then_some(twin)
    }

    /// The edge of a half-edge of its own, or one that was there before.
    #[inline]
    pub(super) fn edge_of(&self, h: u32) -> u32 {
        let edge = self.account.edge[h as usize].load(Relaxed);
        if self.own.half_edges.contains(&h) || edge & !REVERSED < self.own.before {
            edge
        } else {
            NONE
        }
    }

    /// Notes the edge of a half-edge that is its own or no run's.
    #[inline(always)]
    pub(super) fn set_edge(&mut self, h: u32, edge: u32) {
        if self.own.half_edges.contains(&h) || h >= self.own.beyond {
            self.account.edge[h as usize].store(edge, Relaxed);
        }
    }
}
