//! Control points of the faces near changed vertices: the faces are cut out of the levels with what they depend on, built
//! like any other mesh, and what comes out replaces the old numbers in place.

use super::index::Index;
use super::Touched;
use crate::mesh::NONE;
use crate::patch::build::build;
use crate::patch::points::Irregular;
use crate::patch::remap::part_positions;
use crate::patch::transition::{constellation, parts_of, EXTRA_POINTS};
use crate::patch::{Face, Kind, PatchTable};
use crate::refine::{fate, Refinement, Rules};
use crate::subdiv::level::{vertex_bits, Level, CUT};
use std::collections::HashMap;

/// Corners among the 16 entries of a face, from corner A.
const CORNER: [usize; 4] = [0, 3, 15, 12];

/// Replaces the control points of the table that depend on the `changed` vertices of each level.
pub fn replace(
    index: &mut Index,
    refinement: &Refinement,
    table: &mut PatchTable,
    irregular: Irregular,
    changed: &[Vec<u32>],
) -> Touched {
    let mut cut = Cut::new(refinement.levels.len());
    let mut touched = Touched::default();
    for (l, vertices) in changed.iter().enumerate() {
        for f in faces_near(index, refinement, l, vertices) {
            cut.drawn[l].push(f);
            touched.faces += 1;
            let mask = refinement.fates[l][f as usize] >> fate::TRANSITION;
            if mask != 0 && refinement.rules == Rules::Gradtess {
                // The halves of its edges are those of the children beside them.
                let level = &refinement.levels[l];
                for h in level.of_face(f).enumerate().filter(|(i, _)| mask >> i & 1 == 1).map(|i| i.1) {
                    for h in [h, level.next(h)] {
                        cut.beside[l + 1].push(level.child[h as usize]);
                    }
                }
            }
        }
    }
    if touched.faces == 0 {
        return touched;
    }
    let made = cut.out(index, refinement, table);
    let small = build(&made.refinement, irregular);
    debug_assert_eq!(small.faces.len(), made.faces.len());
    let parts: HashMap<u32, [u32; 4]> = part_positions(&small).into_iter().collect();
    for (i, (from, &to)) in small.faces.iter().zip(&made.faces).enumerate() {
        if to == NONE {
            continue;
        }
        let face = table.faces[to as usize];
        debug_assert_eq!((from.name, from.level, from.turn), (face.name, face.level, face.turn));
        let first = index.levels[face.level as usize].first_point;
        let own = parts.get(&(i as u32));
        touched.patches += copy(table, &small, &face, from, first, (&index.parts, to), own, &mut touched.control);
    }
    touched.control.sort_unstable();
    touched.control.dedup();
    touched
}

/// Copies what one face is drawn with; number of its patches.
#[allow(clippy::too_many_arguments)]
fn copy(
    table: &mut PatchTable,
    small: &PatchTable,
    face: &Face,
    from: &Face,
    first_point: u32,
    (parts, number): (&[(u32, [u32; 4])], u32),
    small_parts: Option<&[u32; 4]>,
    changed: &mut Vec<u32>,
) -> usize {
    let mut run = |at: u32, from: u32, n: usize| {
        for k in 0..n {
            let to = table.indices[at as usize + k];
            // Corners that a coarser face made are its own to change.
            if to >= first_point {
                let new = &small.control[small.indices[from as usize + k] as usize];
                let old = &mut table.control[to as usize];
                if old.map(f64::to_bits) != new.map(f64::to_bits) {
                    *old = *new;
                    changed.push(to);
                }
            }
        }
    };
    let points = face.kind.points();
    let Some(small_parts) = small_parts else {
        run(face.first, from.first, points);
        return 1;
    };
    let place = parts.binary_search_by_key(&number, |p| p.0).expect("a transition face has parts");
    let count = parts_of(constellation(face.transition)).len();
    for (&at, &from) in parts[place].1.iter().zip(small_parts).take(count) {
        run(at, from, points + EXTRA_POINTS);
    }
    count
}

/// Drawn faces of level `l` that touch a face of one of the vertices, ascending.
fn faces_near(index: &mut Index, refinement: &Refinement, l: usize, vertices: &[u32]) -> Vec<u32> {
    if vertices.is_empty() {
        return Vec::new();
    }
    let epochs = [index.next_epoch(), index.next_epoch()];
    let own = &mut index.levels[l];
    let level = &refinement.levels[l];
    let mut found = Vec::new();
    for h in vertices.iter().flat_map(|&v| own.around.of(v)) {
        let f = level.face_of(*h);
        if std::mem::replace(&mut own.face_mark[f as usize], epochs[0]) == epochs[0] {
            continue;
        }
        for g in level.of_face(f) {
            let w = level.origin[g as usize];
            if std::mem::replace(&mut own.vertex_mark[w as usize], epochs[0]) != epochs[0] {
                found.extend(own.around.of(w).iter().map(|&h| level.face_of(h)));
            }
        }
    }
    found.retain(|&f| {
        own.drawn[f as usize] != NONE && std::mem::replace(&mut own.face_mark[f as usize], epochs[1]) != epochs[1]
    });
    found.sort_unstable();
    found
}

/// Which faces are cut out of each level.
struct Cut {
    /// Drawn faces whose control points are wanted.
    drawn: Vec<Vec<u32>>,
    /// Faces whose edges are wanted.
    beside: Vec<Vec<u32>>,
    /// Drawn faces that make a corner for a finer one.
    makers: Vec<Vec<u32>>,
    /// Faces through which such a corner is handed down.
    between: Vec<Vec<u32>>,
}

/// A piece of the levels.
struct Piece {
    refinement: Refinement,
    /// Entry in the whole table's faces of each face that is drawn, or [`NONE`] where its points are not wanted.
    faces: Vec<u32>,
}

impl Cut {
    fn new(levels: usize) -> Cut {
        let none = || vec![Vec::new(); levels];
        Cut { drawn: none(), beside: none(), makers: none(), between: none() }
    }

    /// Corners that a coarser level made and that other points of a wanted face depend on: the faces around them come along
    /// from every level up to that one, so that the corner is made as it was.
    fn follow_corners(&mut self, index: &Index, refinement: &Refinement, table: &PatchTable, l: usize) {
        let (level, own) = (&refinement.levels[l], &index.levels[l]);
        let mut wanted = Vec::new();
        for &f in &self.drawn[l] {
            let face = &table.faces[own.drawn[f as usize] as usize];
            // No other point of a whole bicubic depends on its corners.
            let needs = face.kind == Kind::Gregory || face.transition != 0;
            for (k, slot) in CORNER.into_iter().enumerate() {
                let point = table.indices[face.first as usize + slot];
                let h = level.first(f) + ((k as u32 + u32::from(face.turn)) & 3);
                let v = level.origin[h as usize];
                // Around sharp edges a corner of another colour may have lent its place.
                let lent = level.bits[v as usize] & vertex_bits::SECTORS != 0;
                if lent || (needs && point < own.first_point) {
                    wanted.push((v, point, lent));
                }
            }
        }
        for (v, point, lent) in wanted {
            let (mut l, mut v) = (l, v);
            while l > 0 && (lent || point < index.levels[l].first_point) {
                let h = index.levels[l].around.of(v)[0];
                if h & 3 != 0 {
                    // The level above did not have the vertex.
                    break;
                }
                let parent = index.levels[l].parent[h as usize >> 2];
                l -= 1;
                v = refinement.levels[l].origin[parent as usize];
                for &g in index.levels[l].around.of(v) {
                    let f = refinement.levels[l].face_of(g);
                    if index.levels[l].drawn[f as usize] != NONE {
                        self.makers[l].push(f);
                    } else {
                        self.between[l].push(f);
                    }
                }
            }
        }
    }

    /// Cuts the faces out, each with all faces around its corners.
    fn out(mut self, index: &mut Index, refinement: &Refinement, table: &PatchTable) -> Piece {
        for l in (1..refinement.levels.len()).rev() {
            self.follow_corners(index, refinement, table, l);
        }
        // Ascending, so that sums run in the same order as in the whole level.
        let mut taken: Vec<Vec<u32>> = Vec::with_capacity(refinement.levels.len());
        for (l, level) in refinement.levels.iter().enumerate() {
            let epoch = index.next_epoch();
            let own = &mut index.levels[l];
            let mut faces = Vec::new();
            let cores = self.drawn[l].iter().chain(&self.beside[l]).chain(&self.makers[l]);
            for h in cores.flat_map(|&f| level.of_face(f)) {
                let v = level.origin[h as usize];
                if std::mem::replace(&mut own.vertex_mark[v as usize], epoch) != epoch {
                    faces.extend(own.around.of(v).iter().map(|&h| level.face_of(h)));
                }
            }
            faces.extend_from_slice(&self.between[l]);
            faces.sort_unstable();
            faces.dedup();
            taken.push(faces);
        }
        let mut piece = Piece {
            refinement: Refinement {
                levels: Vec::new(),
                fates: Vec::new(),
                corners: refinement.corners,
                rules: refinement.rules,
                edit_level: refinement.edit_level,
            },
            faces: Vec::new(),
        };
        for (l, faces) in taken.iter().enumerate() {
            let below = taken.get(l + 1).map_or(&[][..], |t| t);
            let (drawn, makers) = (&mut self.drawn[l], &mut self.makers[l]);
            makers.sort_unstable();
            let mut fates = Vec::with_capacity(faces.len());
            for f in faces {
                let fate = refinement.fates[l][*f as usize];
                if drawn.binary_search(f).is_ok() {
                    fates.push(fate);
                    piece.faces.push(index.levels[l].drawn[*f as usize]);
                } else if makers.binary_search(f).is_ok() {
                    // Its corners are wanted, not its parts.
                    fates.push(fate & ((1 << fate::TRANSITION) - 1));
                    piece.faces.push(NONE);
                } else {
                    fates.push(0);
                }
            }
            piece.refinement.levels.push(part_of(&refinement.levels[l], faces, below));
            piece.refinement.fates.push(fates);
        }
        piece
    }
}

/// The given faces of a level, ascending, as a level of their own; `below` are those of the next level.
fn part_of(level: &Level, faces: &[u32], below: &[u32]) -> Level {
    let local = |f: u32| faces.binary_search(&f).ok().map(|f| f as u32);
    let quads = faces.partition_point(|&f| f < level.quads) as u32;
    let mut part = Level { level: level.level, quads, ..Level::default() };
    let polygons = faces[quads as usize..].iter().map(|&f| level.valence(f));
    let mut end = 4 * quads;
    if level.level == 0 {
        part.polygon_start.push(end);
        for (i, n) in polygons.enumerate() {
            end += n;
            part.polygon_start.push(end);
            part.polygon_face.extend((0..n).map(|_| quads + i as u32));
        }
    }
    part.origin.reserve_exact(end as usize);
    let half_edges = || faces.iter().flat_map(|&f| level.of_face(f));
    // Vertices in the order of their old numbers, then further tints.
    let mut vertices: Vec<u32> = half_edges().map(|h| level.origin[h as usize]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let number = |v: u32| vertices.binary_search(&v).expect("a corner of a face") as u32;
    let mut tints: Vec<u32> =
        half_edges().map(|h| level.tint[h as usize]).filter(|&t| t as usize >= level.vertices()).collect();
    tints.sort_unstable();
    tints.dedup();
    part.bits = vertices.iter().map(|&v| level.bits[v as usize]).collect();
    part.value = vertices.iter().chain(&tints).map(|&v| level.value[v as usize]).collect();
    for (i, &f) in faces.iter().enumerate() {
        part.face.push(level.face[f as usize]);
        part.inside.push(level.inside[f as usize]);
        debug_assert_eq!(part.first(i as u32), part.origin.len() as u32);
        for h in level.of_face(f) {
            let (v, t) = (level.origin[h as usize], level.tint[h as usize]);
            let own = number(v);
            part.origin.push(own);
            part.tint.push(if t == v {
                own
            } else {
                (vertices.len() + tints.binary_search(&t).expect("a tint of a face")) as u32
            });
            part.twin.push(match level.twin[h as usize] {
                t if t < CUT => {
                    let g = level.face_of(t);
                    local(g).map_or(CUT, |g| part.first(g) + (t - level.first(level.face_of(t))))
                }
                t => t,
            });
            if !level.sharp.is_empty() {
                part.sharp.push(level.sharp[h as usize]);
            }
            part.child.push(match level.child.get(h as usize) {
                Some(&c) if c < CUT => below.binary_search(&c).map_or(NONE, |c| c as u32),
                _ => NONE,
            });
        }
    }
    part
}
