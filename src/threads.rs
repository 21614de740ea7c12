//! Work in pieces for several cores.
//!
//! Pieces are runs of items in order, and what they make is put together in that order, so no result depends on how many
//! there are. Small amounts of work are one piece and stay on the calling thread. The cores are those of the rayon pool that
//! the caller is in: all of the machine's, unless `--threads` or [`rayon::ThreadPool::install`] says otherwise.

use rayon::prelude::*;
use rustix::time::{clock_gettime, ClockId};
use std::cell::Cell;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// Items (faces, half-edges, points) for which another core is worth waking. Measured on two cores: with an eighth of it,
/// scenes of 1,400 to 8,000 patches took 1.4 to 1.8 times as long as on one core.
pub const LEAST: usize = 8192;

/// Most pieces.
pub const MOST: usize = 250;

static LEAST_NOW: AtomicUsize = AtomicUsize::new(LEAST);

/// Makes pieces of `least` items or more from now on, everywhere: with few, tests see seams in small meshes.
pub fn set_least(least: usize) {
    LEAST_NOW.store(least.max(1), Ordering::Relaxed);
}

/// How many pieces `n` items are worth.
fn count(n: usize) -> usize {
    let most = n / LEAST_NOW.load(Ordering::Relaxed);
    match most {
        0 | 1 => 1,
        // The pool starts its threads when it is asked for the first time.
        _ => REHEARSAL.get().map_or_else(rayon::current_num_threads, |r| r.cores).clamp(1, most.min(MOST)),
    }
}

/// Whether `n` items are work for several cores.
pub fn several(n: usize) -> bool {
    count(n) > 1
}

/// The numbers below `n` as runs of nearly equal length, ascending; one at least.
pub fn pieces(n: usize) -> Vec<Range<usize>> {
    cut(n, count(n))
}

fn cut(n: usize, count: usize) -> Vec<Range<usize>> {
    (0..count).map(|i| i * n / count..(i + 1) * n / count).collect()
}

/// Does all pieces of work; results in their order.
pub fn each<T: Send, R: Send>(work: Vec<T>, does: impl Fn(T) -> R + Sync + Send) -> Vec<R> {
    if work.len() < 2 {
        return work.into_iter().map(does).collect();
    }
    if REHEARSAL.get().is_some() {
        return in_turn(work, does);
    }
    // The calling thread does the first: it has the memory of what is made between pieces.
    let mut made: Vec<Option<R>> = work.iter().map(|_| None).collect();
    rayon::in_place_scope(|scope| {
        let does = &does;
        let mut pairs = work.into_iter().zip(&mut made);
        let own = pairs.next();
        pairs.for_each(|(piece, made)| scope.spawn(move |_| *made = Some(does(piece))));
        if let Some((piece, made)) = own {
            *made = Some(does(piece));
        }
    });
    made.into_iter().map(|r| r.expect("the scope waits for all")).collect()
}

/// `of` every number below `n`.
pub fn collect<T: Copy + Send>(n: usize, of: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    match count(n) {
        1 => (0..n).map(of).collect(),
        count if REHEARSAL.get().is_some() => {
            let mut all = Vec::with_capacity(n);
            in_turn(cut(n, count), |piece| all.extend(piece.map(&of)));
            all
        }
        count => (0..n).into_par_iter().with_min_len(n.div_ceil(count)).map(of).collect(),
    }
}

/// Appends what becomes of each item.
pub fn extend<T: Copy + Sync, U: Send>(to: &mut Vec<U>, from: &[T], of: impl Fn(T) -> U + Sync + Send) {
    match count(from.len() / 8) {
        1 => to.extend(from.iter().map(|&x| of(x))),
        count if REHEARSAL.get().is_some() => {
            to.reserve(from.len());
            in_turn(cut(from.len(), count), |piece| to.extend(from[piece].iter().map(|&x| of(x))));
        }
        count => to.par_extend(from.par_iter().with_min_len(from.len().div_ceil(count)).map(|&x| of(x))),
    }
}

/// Changes every item.
pub fn update<T: Send>(items: &mut [T], change: impl Fn(usize, &mut T) + Sync + Send) {
    let n = items.len();
    match count(n / 8) {
        1 => items.iter_mut().enumerate().for_each(|(i, x)| change(i, x)),
        count if REHEARSAL.get().is_some() => {
            in_turn(cut(n, count), |piece| piece.for_each(|i| change(i, &mut items[i])));
        }
        count => {
            items.par_iter_mut().with_min_len(n.div_ceil(count)).enumerate().for_each(|(i, x)| change(i, x));
        }
    }
}

/// A rehearsal under way.
#[derive(Clone, Copy)]
struct Rehearsal {
    cores: usize,
    /// Time of all pieces.
    pieces: Duration,
    /// Time of the longest of each set of pieces.
    longest: Duration,
}

thread_local! {
    static REHEARSAL: Cell<Option<Rehearsal>> = const { Cell::new(None) };
}

/// What work would take on some number of cores.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// Outside of pieces: the part that has one core to itself whatever there are.
    pub serial: Duration,
    /// Of each set of pieces the longest.
    pub parallel: Duration,
}

/// CPU time of this thread so far: unlike the time on the wall it does not grow while others have the core.
pub fn cpu_time() -> Duration {
    let t = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(t.tv_sec as u64, t.tv_nsec as u32)
}

/// Does the work in as many pieces as for that many cores, but one after another on this thread: what it would take if
/// the cores were free, in CPU time and without what waking them costs.
pub fn rehearse(cores: usize, work: impl FnOnce()) -> Estimate {
    REHEARSAL.set(Some(Rehearsal { cores, pieces: Duration::ZERO, longest: Duration::ZERO }));
    let start = cpu_time();
    work();
    let whole = cpu_time() - start;
    let done = REHEARSAL.take().expect("nobody else takes it");
    Estimate { serial: whole.saturating_sub(done.pieces), parallel: done.longest }
}

/// All pieces on this thread, timed.
fn in_turn<T, R>(work: Vec<T>, mut does: impl FnMut(T) -> R) -> Vec<R> {
    let mut longest = Duration::ZERO;
    let mut sum = Duration::ZERO;
    let timed = |piece| {
        let start = cpu_time();
        let made = does(piece);
        let took = cpu_time() - start;
        (longest, sum) = (longest.max(took), sum + took);
        made
    };
    let made = work.into_iter().map(timed).collect();
    if let Some(r) = REHEARSAL.get() {
        REHEARSAL.set(Some(Rehearsal { pieces: r.pieces + sum, longest: r.longest + longest, ..r }));
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_cover_everything_in_order() {
        for n in [0, 1, 5, LEAST, 10 * LEAST + 3] {
            for cores in [1, 2, 3, 8] {
                let runs = cut(n, cores);
                assert_eq!((runs[0].start, runs[cores - 1].end), (0, n));
                assert!(runs.windows(2).all(|w| w[0].end == w[1].start));
            }
        }
    }

    #[test]
    fn a_rehearsal_has_the_results_of_the_work_and_its_pieces() {
        let n = 4 * LEAST;
        let mut got = Vec::new();
        let estimate = rehearse(4, || {
            assert_eq!(pieces(n).len(), 4);
            got = collect(n, |i| i);
            let busy = |ms| {
                let end = cpu_time() + Duration::from_millis(ms);
                while cpu_time() < end {}
            };
            each(vec![2, 6], busy);
            busy(1);
        });
        assert!(got.into_iter().eq(0..n));
        assert!(estimate.parallel >= Duration::from_millis(6) && estimate.parallel < Duration::from_millis(8));
        assert!(estimate.serial >= Duration::from_millis(1));
    }
}
