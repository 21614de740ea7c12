//! Which vertices, edges and faces have a point in the next level, and the numbers of these.

use super::super::level::vertex_bits::EXTRAORDINARY;
use super::super::level::Level;
use super::{split, Run};
use crate::mesh::NONE;
use crate::threads;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

/// Corners of wanted faces. Cores mark at the same time, with the same mark.
pub(super) fn touched_vertices(level: &Level, wanted: &[bool], runs: &[Run]) -> Vec<AtomicBool> {
    let touched: Vec<AtomicBool> = threads::collect(level.vertices(), |_| AtomicBool::new(false));
    let mark = |v: &u32| touched[*v as usize].store(true, Relaxed);
    threads::each(runs.iter().collect(), |run| {
        let quads = run.faces.start.min(level.quads) as usize..run.faces.end.min(level.quads) as usize;
        let corners = &level.origin[4 * quads.start..4 * quads.end];
        for (corners, &wanted) in corners.chunks_exact(4).zip(&wanted[quads]) {
            if wanted {
                corners.iter().for_each(mark);
            }
        }
        for f in run.faces.start.max(level.quads)..run.faces.end {
            if wanted[f as usize] {
                level.of_face(f).for_each(|h| mark(&level.origin[h as usize]));
            }
        }
    });
    touched
}

/// Numbers of the next level's vertices: old ones, edge points, face points.
pub(super) struct Points {
    /// Old vertices in the next level, [`NONE`] where they are not needed.
    pub vertex: Vec<u32>,
    /// Edge point of each half-edge's edge.
    pub edge: Vec<u32>,
    /// Face points.
    pub face: Vec<u32>,
    pub first_edge: u32,
    pub first_face: u32,
    pub count: u32,
    /// Children, edge points and face points of each run of faces; their numbers follow each other.
    pub of_run: Vec<[u32; 3]>,
    /// A half-edge that leaves each vertex that is kept; only where there are several runs.
    pub spoke: Vec<AtomicU32>,
    /// Whether a vertex that is kept is extraordinary.
    pub extraordinary: bool,
}

/// Numbers children (into `level.child`) and points.
pub(super) fn number(level: &mut Level, touched: &[AtomicBool], runs: &[Run]) -> Points {
    let (vertex, first_edge, extraordinary) = number_vertices(level, touched);
    let several = runs.len() > 1;
    let spoke: Vec<AtomicU32> = threads::collect(if several { level.vertices() } else { 0 }, |_| AtomicU32::new(NONE));
    let none = |n: usize| threads::collect(n, |_| NONE);
    let (mut child, mut edge, mut face) = (none(level.half_edges()), none(level.half_edges()), none(level.faces()));

    // Numbers within each run first; only the first run knows where its edge points begin.
    let lengths = || runs.iter().map(|r| r.half_edges.len());
    let arrays = split(&mut child, lengths()).into_iter().zip(split(&mut edge, lengths()));
    let arrays = arrays.zip(split(&mut face, runs.iter().map(|r| r.faces.len())));
    let shared = &*level;
    let numbered = threads::each(runs.iter().zip(arrays).collect(), |(run, ((child, edge), face))| {
        let first = if run.faces.start == 0 { first_edge } else { 0 };
        number_run(shared, touched, &spoke, run, first, child, edge, face)
    });
    let of_run: Vec<[u32; 3]> = numbered.iter().map(|n| n.0).collect();
    let total = |k: usize| of_run.iter().map(|n| n[k]).sum::<u32>();
    let first_face = first_edge + total(1);
    let count = first_face + total(2);

    let (mut children, mut edges, mut faces) = (0, first_edge, first_face);
    let mut offsets = Vec::with_capacity(runs.len());
    for (i, n) in of_run.iter().enumerate() {
        offsets.push([children, if i == 0 { 0 } else { edges }, faces]);
        (children, edges, faces) = (children + n[0], edges + n[1], faces + n[2]);
    }
    let arrays = split(&mut child, lengths()).into_iter().zip(split(&mut edge, lengths()));
    let arrays = arrays.zip(split(&mut face, runs.iter().map(|r| r.faces.len())));
    threads::each(offsets.into_iter().zip(arrays).collect(), |(offset, ((child, edge), face))| {
        for (list, by) in [(child, offset[0]), (edge, offset[1]), (face, offset[2])] {
            if by > 0 {
                list.iter_mut().for_each(|x| *x = if *x == NONE { NONE } else { *x + by });
            }
        }
    });
    for h in numbered.into_iter().flat_map(|n| n.1) {
        edge[h as usize] = edge[level.twin[h as usize] as usize];
    }
    level.child = child;
    Points { vertex, edge, face, first_edge, first_face, count, of_run, spoke, extraordinary }
}

/// Numbers of old vertices, how many are kept, and whether one of them is extraordinary.
fn number_vertices(level: &Level, touched: &[AtomicBool]) -> (Vec<u32>, u32, bool) {
    let pieces = threads::pieces(level.vertices());
    let kept = |range: &Range<usize>| touched[range.clone()].iter().filter(|t| t.load(Relaxed)).count() as u32;
    // The first piece is numbered without looking ahead.
    let counts = threads::each(pieces[..pieces.len() - 1].iter().collect(), kept);
    let mut vertex = threads::collect(level.vertices(), |_| NONE);
    let mut first = 0;
    let firsts: Vec<u32> = std::iter::once(0)
        .chain(counts.into_iter().map(|n| {
            first += n;
            first
        }))
        .collect();
    let lists = split(&mut vertex, pieces.iter().map(Range::len));
    let done = threads::each(pieces.into_iter().zip(firsts).zip(lists).collect(), |((range, first), list)| {
        let (mut count, mut extraordinary) = (first, 0);
        for ((number, touched), bits) in list.iter_mut().zip(&touched[range.clone()]).zip(&level.bits[range]) {
            if touched.load(Relaxed) {
                *number = count;
                count += 1;
                extraordinary |= bits & EXTRAORDINARY;
            }
        }
        (count, extraordinary)
    });
    let extraordinary = done.iter().any(|d| d.1 != 0);
    (vertex, done.last().map_or(0, |d| d.0), extraordinary)
}

/// Numbers the children, edge points (from `first_edge`) and face points of a run, whose parts of the arrays are given: how
/// many there are, and the half-edges whose edge belongs to an earlier run. `spoke`, unless it is empty, gets a half-edge of
/// each vertex.
#[allow(clippy::too_many_arguments)]
fn number_run(
    level: &Level,
    touched: &[AtomicBool],
    spoke: &[AtomicU32],
    run: &Run,
    first_edge: u32,
    child: &mut [u32],
    edge: &mut [u32],
    face: &mut [u32],
) -> ([u32; 3], Vec<u32>) {
    let first = run.half_edges.start;
    let mut children = 0;
    let several = !spoke.is_empty();
    for (h, (child, &v)) in (first..).zip(child.iter_mut().zip(&level.origin[first as usize..])) {
        if touched[v as usize].load(Relaxed) {
            *child = children;
            children += 1;
            if several {
                spoke[v as usize].store(h, Relaxed);
            }
        }
    }
    let (mut edges, mut faces, mut seams) = (first_edge, 0, Vec::new());
    // An edge needs its point if one of its ends is touched, which its half-edges' children tell; a face if any corner is.
    for f in run.faces.start..run.faces.end.min(level.quads) {
        let children = Level::quad(child, f - run.faces.start);
        if children == [NONE; 4] {
            continue;
        }
        face[(f - run.faces.start) as usize] = faces;
        faces += 1;
        let twin = Level::quad(&level.twin, f);
        for i in 0..4 {
            let h = 4 * f + i as u32;
            edge[(h - first) as usize] = if twin[i] < h {
                if twin[i] >= first {
                    edge[(twin[i] - first) as usize]
                } else {
                    seams.push(h);
                    NONE
                }
            } else if children[i] != NONE || children[(i + 1) & 3] != NONE {
                edges += 1;
                edges - 1
            } else {
                NONE
            };
        }
    }
    for f in run.faces.start.max(level.quads)..run.faces.end {
        let has = |h: u32| child[(h - first) as usize] != NONE;
        if level.of_face(f).any(has) {
            face[(f - run.faces.start) as usize] = faces;
            faces += 1;
        }
        for h in level.of_face(f) {
            let t = level.twin[h as usize];
            edge[(h - first) as usize] = if t < h {
                if t >= first {
                    edge[(t - first) as usize]
                } else {
                    seams.push(h);
                    NONE
                }
            } else if has(h) || has(level.next(h)) {
                edges += 1;
                edges - 1
            } else {
                NONE
            };
        }
    }
    ([children, edges - first_edge, faces], seams)
}
