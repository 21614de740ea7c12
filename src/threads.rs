//! Work in pieces for several cores.
//!
//! Pieces are runs of items in order, and what they make is put together in that order, so no result depends on how many
//! there are. Small amounts of work are one piece and stay on the calling thread. The cores are those of the rayon pool that
//! the caller is in: all of the machine's, unless `--threads` or [`rayon::ThreadPool::install`] says otherwise.
//!
//! A core that sleeps takes longer to wake than most sets of pieces take. So the cores are called together once for a whole
//! job ([`crew`]) and stay awake until it is done: then a set of pieces costs a microsecond or two.

use rayon::prelude::*;
use rustix::time::{clock_gettime, ClockId};
use std::cell::Cell;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

/// Items (faces, half-edges, points) that are worth a piece of their own.
pub const LEAST: usize = 1024;

/// Pieces' worth of items for which other cores are worth waking. On a busy machine each set of pieces may wait for a turn of
/// the system's (milliseconds), which only a job that gains many of them by a second core can afford.
const WORTH_WAKING: usize = 64;

/// Most pieces.
pub const MOST: usize = 250;

static LEAST_NOW: AtomicUsize = AtomicUsize::new(LEAST);

/// Makes pieces of `least` items or more from now on, everywhere: with few, tests see seams in small meshes.
pub fn set_least(least: usize) {
    LEAST_NOW.store(least.max(1), Ordering::Relaxed);
}

thread_local! {
    /// Cores that are awake for the job of this thread; 0 without a job.
    static CREW: Cell<usize> = const { Cell::new(0) };
    /// Whether this thread stands by for another one's job.
    static STANDS_BY: Cell<bool> = const { Cell::new(false) };
}

/// A job of about `items` items, with all cores awake if it is large enough. A job within a job has its cores.
pub fn crew<R: Send>(items: usize, job: impl FnOnce() -> R + Send) -> R {
    if CREW.get() > 0 || REHEARSAL.get().is_some() || items < WORTH_WAKING * LEAST_NOW.load(Ordering::Relaxed) {
        return job();
    }
    // The pool starts its threads when it is asked for the first time.
    let cores = rayon::current_num_threads().min(MOST);
    if cores == 1 {
        return job();
    }
    let done = AtomicBool::new(false);
    // On a thread of the pool, whoever calls: a caller from outside would be one thread more than there are cores, each of
    // its pieces would wake another thread, and it could not help with them.
    rayon::scope(|scope| {
        let owner = thread::current().id();
        for _ in 1..cores {
            let done = &done;
            scope.spawn(move |_| stand_by(done, owner));
        }
        let _end = End(&done);
        CREW.set(cores);
        job()
    })
}

/// The end of a job, by panic too.
struct End<'a>(&'a AtomicBool);

impl Drop for End<'_> {
    fn drop(&mut self) {
        CREW.set(0);
        self.0.store(true, Ordering::Release);
    }
}

/// Does pieces of work as they come until the job is done.
fn stand_by(done: &AtomicBool, owner: ThreadId) {
    // The owner comes here where nobody else had the time to; it has the job to do.
    if STANDS_BY.get() || thread::current().id() == owner {
        return;
    }
    STANDS_BY.set(true);
    while !done.load(Ordering::Acquire) {
        if rayon::yield_now() != Some(rayon::Yield::Executed) {
            (0..16).for_each(|_| std::hint::spin_loop());
        }
    }
    STANDS_BY.set(false);
}

/// Most pieces for each core. Pieces go to whoever is free; with more of them, cores end at about the same time though some
/// pieces are more work than others.
const FOR_EACH_CORE: usize = 4;

/// How many pieces `n` items are worth: the same number for each core, if all get some.
fn count(n: usize) -> usize {
    let cores = REHEARSAL.get().map_or(CREW.get(), |r| r.cores).max(1);
    let most = (n / LEAST_NOW.load(Ordering::Relaxed)).clamp(1, MOST);
    match most / cores {
        0 => most,
        _ if cores == 1 => 1,
        rounds => cores * rounds.min(FOR_EACH_CORE),
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

/// The same of items each of which is as much work as `worth` others.
pub fn pieces_worth(n: usize, worth: usize) -> Vec<Range<usize>> {
    cut(n, count(n * worth).min(n.max(1)))
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
    let left = AtomicUsize::new(work.len() - 1);
    rayon::in_place_scope(|scope| {
        let (does, left) = (&does, &left);
        let mut pairs = work.into_iter().zip(&mut made);
        let own = pairs.next();
        pairs.for_each(|(piece, made)| {
            scope.spawn(move |_| {
                *made = Some(does(piece));
                left.fetch_sub(1, Ordering::Release);
            });
        });
        if let Some((piece, made)) = own {
            *made = Some(does(piece));
        }
        wait_awake(left);
    });
    made.into_iter().map(|r| r.expect("the scope waits for all")).collect()
}

/// Waits for the last pieces as long as it would take to fall asleep and wake again, and helps with them meanwhile.
fn wait_awake(left: &AtomicUsize) {
    let mut since = None;
    while left.load(Ordering::Acquire) > 0 {
        if rayon::yield_now() == Some(rayon::Yield::Executed) {
            continue;
        }
        (0..16).for_each(|_| std::hint::spin_loop());
        if since.get_or_insert_with(Instant::now).elapsed() > Duration::from_micros(300) {
            return;
        }
    }
}

/// `of` every number below `n`.
pub fn collect<T: Send>(n: usize, of: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    let mut all = Vec::with_capacity(n);
    append(&mut all, n, of);
    all
}

/// Appends `of` every number below `n`.
pub fn append<T: Send>(to: &mut Vec<T>, n: usize, of: impl Fn(usize) -> T + Sync + Send) {
    // Of the little that is done with an item here, a piece needs more.
    match count(n / 2) {
        1 => to.extend((0..n).map(of)),
        count if REHEARSAL.get().is_some() => {
            to.reserve(n);
            in_turn(cut(n, count), |piece| to.extend(piece.map(&of)));
        }
        count => to.par_extend((0..n).into_par_iter().with_min_len(n.div_ceil(count)).map(of)),
    }
}

/// Makes `to` what becomes of each item, in the memory it has.
pub fn replace<T: Copy + Sync, U: Copy + Default + Send>(
    to: &mut Vec<U>,
    from: &[T],
    of: impl Fn(T) -> U + Sync + Send,
) {
    if to.capacity() < from.len() {
        // Zeros from the system come page by page to the core that writes there first.
        *to = vec![U::default(); from.len()];
    }
    to.resize(from.len(), U::default());
    let pieces = cut(from.len(), count(from.len() / 4));
    let mut rest = &mut to[..];
    let lists = pieces.into_iter().map(|range| {
        let (list, after) = std::mem::take(&mut rest).split_at_mut(range.len());
        rest = after;
        (&from[range], list)
    });
    each(lists.collect(), |(from, to)| to.iter_mut().zip(from).for_each(|(to, &from)| *to = of(from)));
}

/// A rehearsal under way.
#[derive(Clone, Copy)]
struct Rehearsal {
    cores: usize,
    /// Time of all pieces.
    pieces: Duration,
    /// Of each set of pieces the time of the core that has most to do.
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
    /// Of each set of pieces what the core does that has most to do.
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

/// All pieces on this thread, timed; each counts for the core that would be free first.
fn in_turn<T, R>(work: Vec<T>, mut does: impl FnMut(T) -> R) -> Vec<R> {
    // Work within a piece is on the core that has it.
    let rehearsal = REHEARSAL.take();
    let mut busy = vec![Duration::ZERO; rehearsal.map_or(1, |r| r.cores.max(1))];
    let timed = |piece| {
        let start = cpu_time();
        let made = does(piece);
        let took = cpu_time() - start;
        *busy.iter_mut().min().expect("one core at least") += took;
        made
    };
    let made = work.into_iter().map(timed).collect();
    if let Some(r) = rehearsal {
        let (sum, longest) = (busy.iter().sum::<Duration>(), busy.into_iter().max().unwrap_or_default());
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
