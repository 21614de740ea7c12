//! Several cores build the patches of one level: each takes a run of faces.
//!
//! How many control points a run makes is counted first, so each run writes them where they belong. Which face makes a
//! shared point follows from the faces around it alone: the first that is drawn. Where that one is in an earlier run, the
//! number is lent ([`super::pool`]) and replaced when all runs are done. So the table is that of a single run.

use super::build::{note_splits, Builder, Drawn, Run, Splits, Waiting, BUCKETS, NO_BUCKET};
use super::points::Points;
use super::pool::{Maker, Piece, LENT};
use super::ControlPoint;
use crate::subdiv::level::Level;
use crate::threads;
use std::ops::Range;

/// What a run of faces made.
struct Made<'a> {
    points: Points<'a>,
    buckets: Vec<Vec<u32>>,
    waiting: Vec<Waiting>,
    makers: Vec<Maker>,
    lent: Vec<ControlPoint>,
}

/// A run's room in the table.
struct Room<'t> {
    before: &'t [ControlPoint],
    base: u32,
    control: &'t mut [ControlPoint],
    drawn: Drawn<'t>,
}

impl Builder {
    /// Rooms for runs that make `control` points, whole bicubics (`plain`) and `faces`.
    fn rooms(&mut self, counts: &[[usize; 3]]) -> Vec<Room<'_>> {
        let [mut base, mut plain_first, mut faces_first] = self.used;
        for of_run in counts {
            for (used, n) in self.used.iter_mut().zip([of_run[0], 16 * of_run[1], of_run[2]]) {
                *used += n;
            }
        }
        if self.control.len() < self.used[0] {
            self.control.resize(self.used[0], [0.0; 8]);
        }
        let (before, mut control) = self.control.split_at_mut(base);
        let (mut plain, mut faces) = (&mut self.indices[plain_first..], &mut self.faces[faces_first..]);
        let mut face_bucket = &mut self.face_bucket[faces_first..];
        let before = &*before;
        let room = |&[points, whole, drawn]: &[usize; 3]| {
            let room = Room {
                before,
                base: base as u32,
                control: front(&mut control, points),
                drawn: Drawn {
                    plain: front(&mut plain, 16 * whole),
                    plain_made: 0,
                    plain_first,
                    faces: front(&mut faces, drawn),
                    face_bucket: front(&mut face_bucket, drawn),
                    faces_made: 0,
                    faces_first,
                    buckets: vec![Vec::new(); BUCKETS],
                    waiting: Vec::new(),
                },
            };
            (base, plain_first, faces_first) = (base + points, plain_first + 16 * whole, faces_first + drawn);
            room
        };
        counts.iter().map(room).collect()
    }

    /// As [`Run::faces`] for all faces of the level.
    pub(super) fn faces_in_runs(&mut self, points: &mut Points) {
        // The shrunk faces at the end of level 0 touch nothing but quads, which may be in any run: those come first.
        let (quads, faces) = (points.level().quads as usize, points.level().faces());
        for part in [0..quads, quads..faces] {
            if !part.is_empty() {
                self.part_in_runs(points, part);
            }
        }
    }

    fn part_in_runs(&mut self, points: &mut Points, part: Range<usize>) {
        let level = points.level();
        let shifted = |r: Range<usize>| part.start + r.start..part.start + r.end;
        let runs: Vec<Range<usize>> = threads::pieces(part.len()).into_iter().map(shifted).collect();
        let shared = &*points;
        let counts = threads::each(runs.clone(), |faces| shared.count(faces));
        let (makers, corners) = shared.makers(&counts);
        let counts: Vec<[usize; 3]> =
            counts.iter().zip(corners).map(|(c, corners)| [c.points + corners, c.plain, c.faces]).collect();
        let used = self.used;
        let rooms = self.rooms(&counts);
        let work: Vec<_> = runs.iter().zip(rooms).enumerate().collect();
        let made = threads::each(work, |(i, (faces, room))| {
            let mut points = shared.of_run(i as u8, faces, &makers);
            let mut pool = Piece::new(room.before, room.base, room.control);
            let mut drawn = room.drawn;
            Run { points: &mut points, pool: &mut pool, drawn: &mut drawn }.faces(faces.clone());
            let (makers, lent) = pool.finish();
            assert_eq!([drawn.plain.len(), drawn.faces.len()], [drawn.plain_made, drawn.faces_made]);
            Made { points, buckets: drawn.buckets, waiting: drawn.waiting, makers, lent }
        });
        let run_of = |maker: &Maker| match *maker {
            Maker::Corner(_, run) => run as usize,
            Maker::Edge(h) => runs.partition_point(|r| r.end <= level.face_of(h) as usize),
        };
        let final_of = |maker: &Maker| made[run_of(maker)].points.made(*maker);
        let numbers: Vec<Vec<u32>> = made.iter().map(|run| run.makers.iter().flat_map(final_of).collect()).collect();
        for (run, numbers) in made.iter().zip(&numbers) {
            debug_assert!(run.lent.iter().zip(numbers).all(|(lent, &i)| *lent == self.control[i as usize]));
        }
        // What stands in its place is put right by several cores, the rest is put behind what there is.
        let [_, plain, faces] = used;
        let (mut plain, mut faces, mut bucket) =
            (&mut self.indices[plain..], &mut self.faces[faces..], &mut self.face_bucket[faces..]);
        let mut lengths: Vec<u32> = self.buckets.iter().map(|b| b.len() as u32).collect();
        let mut work = Vec::with_capacity(made.len());
        for ((run, numbers), count) in made.iter().zip(&numbers).zip(&counts) {
            let parts = (front(&mut plain, 16 * count[1]), front(&mut faces, count[2]), front(&mut bucket, count[2]));
            work.push((parts, numbers, lengths.clone()));
            lengths.iter_mut().zip(&run.buckets).for_each(|(n, ids)| *n += ids.len() as u32);
        }
        threads::each(work, |((plain, faces, buckets), numbers, lengths)| {
            if !numbers.is_empty() {
                plain.iter_mut().for_each(|i| *i = own(*i, numbers));
            }
            for (face, &b) in faces.iter_mut().zip(&*buckets) {
                // A face that waits has no bucket yet.
                face.first += if b == 0 || b == NO_BUCKET { 0 } else { lengths[b as usize] };
            }
        });
        let mut all = Vec::with_capacity(made.len());
        for (mut run, numbers) in made.into_iter().zip(numbers) {
            if part.end < level.faces() {
                run.points.settle_edges(&numbers);
            }
            self.append(run.buckets, &numbers);
            let waiting = run.waiting.iter().map(|w| Waiting { points: w.points.map(|i| own(i, &numbers)), ..*w });
            self.waiting.extend(waiting);
            all.push(run.points);
        }
        points.merge(&all, &(part.end..level.faces()));
    }

    /// Puts a run's indices behind those there are; `numbers` stand for the lent ones.
    fn append(&mut self, buckets: Vec<Vec<u32>>, numbers: &[u32]) {
        for (all, ids) in self.buckets.iter_mut().zip(buckets) {
            threads::extend(all, &ids, |i| own(i, numbers));
        }
    }

    /// As [`Run::transition`] for all faces that waited.
    pub(super) fn transitions_in_runs(&mut self, waiting: &[Waiting], coarse: &Level, fine: &mut Points) {
        let runs: Vec<&[Waiting]> = threads::pieces(waiting.len()).into_iter().map(|r| &waiting[r]).collect();
        let count = |faces: &&[Waiting]| [faces.iter().map(Waiting::new_points).sum(), 0, 0];
        let counts: Vec<[usize; 3]> = runs.iter().map(count).collect();
        let shared = &*fine;
        let work: Vec<_> = runs.iter().zip(self.rooms(&counts)).collect();
        let made = threads::each(work, |(faces, room)| {
            let mut points = Points::bare(shared.level(), shared.fates(), shared.style());
            let mut pool = Piece::new(room.before, room.base, room.control);
            let mut drawn = room.drawn;
            let mut run = Run { points: &mut points, pool: &mut pool, drawn: &mut drawn };
            let places: Vec<((u8, u32), Splits)> = faces.iter().map(|face| run.transition(face, coarse)).collect();
            pool.finish();
            (places, drawn.buckets)
        });
        for (faces, (places, buckets)) in runs.into_iter().zip(made) {
            let first: Vec<u32> = self.buckets.iter().map(|b| b.len() as u32).collect();
            self.append(buckets, &[]);
            for (face, ((bucket, at), splits)) in faces.iter().zip(places) {
                self.place(face.index, (bucket, first[bucket as usize] + at));
                note_splits(face, coarse, &splits, fine);
            }
        }
    }
}

/// The final number of a point.
pub(super) fn own(number: u32, lent: &[u32]) -> u32 {
    if number & LENT == 0 {
        number
    } else {
        lent[(number & !LENT) as usize]
    }
}

/// Takes the first `n` items away.
fn front<'t, T>(items: &mut &'t mut [T], n: usize) -> &'t mut [T] {
    let (front, rest) = std::mem::take(items).split_at_mut(n);
    *items = rest;
    front
}
