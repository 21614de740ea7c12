//! Several cores build the patches of one level: each takes a run of faces.
//!
//! How many control points a run makes is counted first, so each run writes them where they belong. Which face makes a
//! shared point follows from the faces around it alone: the first that is drawn. Where that one is in an earlier run, the
//! number is lent ([`super::pool`]) and replaced when all runs are done. So the table is that of a single run.

use super::build::{front, places, waiting_counts, Builder, Counts, Drawn, Part, Place, Run, Waiting, BUCKETS};
use super::points::{Account, Own, Points};
use super::pool::{Piece, LENT};
use super::{ControlPoint, Face};
use crate::subdiv::level::Level;
use crate::threads;

/// A transition face is drawn in two to four parts, as much work as so many other faces.
const TRANSITION: usize = 4;

/// A run's room in the table.
struct Room<'t> {
    before: &'t [ControlPoint],
    base: u32,
    control: &'t mut [ControlPoint],
    places: [Place<'t>; BUCKETS],
    faces: &'t mut [Face],
    faces_first: usize,
}

impl Builder {
    /// Rooms for runs that make control points (`points`), indices (`counts`) and faces (`drawn`).
    fn rooms(&mut self, points: &[usize], counts: &[&Counts], drawn: &[usize]) -> Vec<Room<'_>> {
        let [mut base, mut faces_first] = self.used;
        self.used[0] += points.iter().sum::<usize>();
        self.used[1] += drawn.iter().sum::<usize>();
        if self.control.len() < self.used[0] {
            self.control.resize(self.used[0], [0.0; 8]);
        }
        let (before, mut control) = self.control.split_at_mut(base);
        let mut faces = &mut self.faces[faces_first..];
        let before = &*before;
        let places = places(&mut self.indices, &mut self.next, counts);
        let room = |((places, &points), &drawn)| {
            let (control, faces) = (front(&mut control, points), front(&mut faces, drawn));
            let room = Room { before, base: base as u32, control, places, faces, faces_first };
            (base, faces_first) = (base + points, faces_first + drawn);
            room
        };
        places.into_iter().zip(points).zip(drawn).map(room).collect()
    }

    /// As [`Run::faces`] for runs of faces that follow each other.
    pub(super) fn faces_in_runs(&mut self, account: &Account, parts: &[Part]) {
        let level = account.level;
        let start = |part: &Part| level.first(part.faces.start as u32);
        let [first, beyond] = [parts[0].faces.start, parts[parts.len() - 1].faces.end].map(|f| level.first(f as u32));
        // For all that was there before, the first run is the first of all.
        let from = |part: &Part| if start(part) == first { 0 } else { start(part) };
        let points = threads::each(parts.iter().collect(), |part| account.count(part.faces.clone(), from(part)));
        let drawn: Vec<usize> = parts.iter().map(|part| part.drawn).collect();
        let counts: Vec<&Counts> = parts.iter().map(|part| &part.whole).collect();
        let before = self.used[0] as u32;
        let rooms = self.rooms(&points, &counts, &drawn);
        let made = threads::each(parts.iter().zip(rooms).collect(), |(part, room)| {
            let base = room.base;
            let own = Own {
                half_edges: from(part)..level.first(part.faces.end as u32),
                beyond,
                before,
                points: base..base + room.control.len() as u32,
            };
            let mut points = Points::of_run(account, own);
            let mut pool = Piece::new(room.before, base, room.control);
            let Room { places, faces, faces_first, .. } = room;
            let mut drawn = Drawn { places, faces, faces_made: 0, faces_first, waiting: Vec::new(), lent: Vec::new() };
            Run { points: &mut points, pool: &mut pool, drawn: &mut drawn }.faces(part.faces.clone());
            assert!(drawn.is_full(), "a run draws what was counted");
            (drawn.waiting, drawn.lent, pool.finish())
        });
        for (mut waiting, lent, (makers, points)) in made {
            let numbers: Vec<u32> = makers.iter().flat_map(|maker| account.made(*maker)).collect();
            debug_assert!(points.iter().zip(&numbers).all(|(lent, &i)| *lent == self.control[i as usize]));
            for (from, to) in lent {
                self.indices[from as usize..to as usize].iter_mut().for_each(|i| *i = own(*i, &numbers));
            }
            if !numbers.is_empty() {
                waiting.iter_mut().for_each(|w| w.points = w.points.map(|i| own(i, &numbers)));
            }
            self.waiting.append(&mut waiting);
        }
    }

    /// As [`Run::transition`] for all faces that waited.
    pub(super) fn transitions_in_runs(&mut self, waiting: &[Waiting], coarse: &Level, fine: &Account) {
        let runs: Vec<&[Waiting]> =
            threads::pieces_worth(waiting.len(), TRANSITION).into_iter().map(|r| &waiting[r]).collect();
        let points: Vec<usize> = runs.iter().map(|run| run.iter().map(Waiting::new_points).sum()).collect();
        let counts: Vec<Counts> = runs.iter().map(|run| waiting_counts(run)).collect();
        let rooms = self.rooms(&points, &counts.iter().collect::<Vec<_>>(), &vec![0; runs.len()]);
        let firsts = threads::each(runs.into_iter().zip(rooms).collect(), |(faces, room)| {
            let mut points = Points::new(fine);
            let mut pool = Piece::new(room.before, room.base, room.control);
            let Room { places, faces_first, .. } = room;
            let mut drawn =
                Drawn { places, faces: &mut [], faces_made: 0, faces_first, waiting: Vec::new(), lent: Vec::new() };
            let mut run = Run { points: &mut points, pool: &mut pool, drawn: &mut drawn };
            let firsts: Vec<u32> = faces.iter().map(|face| run.transition(face, coarse)).collect();
            pool.finish();
            firsts
        });
        for (face, first) in waiting.iter().zip(firsts.into_iter().flatten()) {
            self.faces[face.index].first = first;
        }
    }
}

/// The final number of a point.
fn own(number: u32, lent: &[u32]) -> u32 {
    if number & LENT == 0 {
        number
    } else {
        lent[(number & !LENT) as usize]
    }
}
