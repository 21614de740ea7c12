//! The faces of the next level: their corners, twins and sharp edges.

use super::super::level::{Level, CUT};
use super::{split, Points, Run, SectorColours};
use crate::mesh::NONE;
use crate::threads;

/// A run's children: its parts of the next level's arrays, one entry a face and four.
struct Children<'a> {
    face: &'a mut [u64],
    inside: &'a mut [bool],
    origin: &'a mut [u32],
    twin: &'a mut [u32],
    tint: &'a mut [u32],
    /// Empty without sharp edges.
    sharp: &'a mut [bool],
    made: usize,
}

pub(super) fn connect(
    level: &Level,
    wanted: &[bool],
    points: &Points,
    sectors: &SectorColours,
    runs: &[Run],
    next: &mut Level,
) {
    let of_run = || points.of_run.iter().map(|n| n[0] as usize);
    let children: usize = of_run().sum();
    let sharp = !level.sharp.is_empty();
    next.quads = children as u32;
    next.face = vec![0; children];
    next.inside = vec![false; children];
    [next.origin, next.twin, next.tint] = [(); 3].map(|()| threads::collect(4 * children, |_| 0));
    next.sharp = vec![false; if sharp { 4 * children } else { 0 }];
    let four = || of_run().map(|n| 4 * n);
    let mut lists = [&mut next.origin, &mut next.twin, &mut next.tint].map(|list| split(list, four()).into_iter());
    let mut sharps = split(&mut next.sharp, four().map(|n| if sharp { n } else { 0 })).into_iter();
    let named = split(&mut next.face, of_run()).into_iter().zip(split(&mut next.inside, of_run()));
    let work = runs.iter().zip(named).map(|(run, (face, inside))| {
        let [origin, twin, tint] = std::array::from_fn(|i| lists[i].next().expect("a part for each run"));
        let sharp = sharps.next().expect("a part for each run");
        (run, Children { face, inside, origin, twin, tint, sharp, made: 0 })
    });
    threads::each(work.collect(), |(run, mut to)| connect_run(level, wanted, points, sectors, run, &mut to));
}

fn connect_run(level: &Level, wanted: &[bool], points: &Points, sectors: &SectorColours, run: &Run, to: &mut Children) {
    let sharp = !level.sharp.is_empty();
    // Slot `s` of child face `c`, if there is one.
    let slot_of = |c: u32, s: u32| if c == NONE { CUT } else { 4 * c + s };
    // Across an edge whose twin is `t`: the child at the start of the edge, which is the end of `t`; that at its end.
    let across_start = |t: u32| if t < CUT { slot_of(level.child[level.next(t) as usize], 3) } else { t };
    let across_end = |t: u32| if t < CUT { slot_of(level.child[t as usize], 0) } else { t };
    let tints = |h: usize, p: usize, at: [u32; 4]| {
        let corner = sectors.corner[h];
        [if corner == NONE { at[0] } else { corner }, sectors.side[h], at[2], sectors.side[p]]
    };
    for f in run.faces.start..run.faces.end.min(level.quads) {
        let centre = points.face[f as usize];
        if centre == NONE {
            continue;
        }
        let first = 4 * f;
        // Slots and local half-edges are the same numbers at level 0.
        let slot = if level.level == 0 { u64::from(first) } else { 4 * level.face[f as usize] };
        let child = Level::quad(&level.child, f);
        let edge = Level::quad(&points.edge, f);
        let origin = Level::quad(&level.origin, f);
        let twin = Level::quad(&level.twin, f);
        for i in 0..4 {
            if child[i] == NONE {
                continue;
            }
            let (n, p) = ((i + 1) & 3, (i + 3) & 3);
            let at = [points.vertex[origin[i] as usize], edge[i], centre, edge[p]];
            let twins = [across_start(twin[i]), slot_of(child[n], 2), slot_of(child[p], 1), across_end(twin[p])];
            let (h, p) = (first as usize + i, first as usize + p);
            let tint = if sharp { tints(h, p, at) } else { at };
            if sharp {
                to.add_sharp([level.sharp[h], false, false, level.sharp[p]]);
            }
            to.add(slot + i as u64, wanted[f as usize], at, tint, twins);
        }
    }
    for f in run.faces.start.max(level.quads)..run.faces.end {
        for h in level.of_face(f).filter(|&h| level.child[h as usize] != NONE) {
            let (n, p) = (level.next(h) as usize, level.prev(h) as usize);
            let (vertex, edge) = (level.origin[h as usize] as usize, points.edge[h as usize]);
            let at = [points.vertex[vertex], edge, points.face[f as usize], points.edge[p]];
            let twins = [
                across_start(level.twin[h as usize]),
                slot_of(level.child[n], 2),
                slot_of(level.child[p], 1),
                across_end(level.twin[p]),
            ];
            let tint = if sharp { tints(h as usize, p, at) } else { at };
            if sharp {
                to.add_sharp([level.sharp[h as usize], false, false, level.sharp[p]]);
            }
            to.add(u64::from(h), wanted[f as usize], at, tint, twins);
        }
    }
}

impl Children<'_> {
    // A call for each child would cost as much as its body.
    #[inline(always)]
    fn add(&mut self, slot: u64, inside: bool, at: [u32; 4], tint: [u32; 4], twins: [u32; 4]) {
        let f = self.made;
        self.face[f] = slot;
        self.inside[f] = inside;
        let h = 4 * f..4 * f + 4;
        self.origin[h.clone()].copy_from_slice(&at);
        self.tint[h.clone()].copy_from_slice(&tint);
        self.twin[h].copy_from_slice(&twins);
        self.made += 1;
    }

    /// Before the child itself is added.
    fn add_sharp(&mut self, sharp: [bool; 4]) {
        self.sharp[4 * self.made..4 * self.made + 4].copy_from_slice(&sharp);
    }
}
