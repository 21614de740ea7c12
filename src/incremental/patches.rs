//! Control points of the faces near changed vertices: the faces are cut out of the levels with what they depend on, built
//! like any other mesh, and what comes out replaces the old numbers in place.

use super::grow::Changes;
use super::index::Index;
use super::slots::{first_points, Slots, Written};
use super::{Changed, Touched};
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
        faces_near(index, refinement, l, vertices, &mut cut.drawn);
    }
    for l in 0..cut.drawn.len() {
        cut.drawn[l].sort_unstable();
        cut.drawn[l].dedup();
        touched.faces += cut.drawn[l].len();
        for i in 0..cut.drawn[l].len() {
            cut.add_beside(refinement, l, cut.drawn[l][i]);
        }
    }
    if touched.faces == 0 {
        return touched;
    }
    for l in (1..refinement.levels.len()).rev() {
        cut.follow_corners(index, refinement, table, l);
    }
    let made = cut.out(index, refinement);
    let small = build(&made.refinement, irregular);
    debug_assert_eq!(small.faces.len(), made.faces.len());
    let parts: HashMap<u32, [u32; 4]> = part_positions(&small).into_iter().collect();
    for (i, (from, number)) in small.faces.iter().zip(&made.faces).enumerate() {
        let Some(f) = *number else { continue };
        let to = index.levels[from.level as usize].drawn[f as usize];
        let face = table.faces[to as usize];
        debug_assert_eq!((from.name, from.level, from.turn), (face.name, face.level, face.turn));
        let own = parts.get(&(i as u32));
        touched.patches += copy(table, &small, &index.slots, to, from, own, &mut touched.changed.control);
    }
    touched.changed.control.sort_unstable();
    touched.changed.control.dedup();
    touched
}

/// Copies what one face is drawn with; number of its patches.
fn copy(
    table: &mut PatchTable,
    small: &PatchTable,
    slots: &Slots,
    to: u32,
    from: &Face,
    small_parts: Option<&[u32; 4]>,
    changed: &mut Vec<u32>,
) -> usize {
    let level = from.level as u8;
    let (places, count, stride) = slots.places(table, to);
    let small_places = small_parts.copied().unwrap_or([from.first, NONE, NONE, NONE]);
    for (&at, from) in places.iter().zip(small_places).take(count) {
        for k in 0..stride {
            let to = table.indices[at as usize + k];
            // Corners that a coarser face made are its own to change.
            if slots.level[to as usize] >= level {
                let new = &small.control[small.indices[from as usize + k] as usize];
                let old = &mut table.control[to as usize];
                if old.map(f64::to_bits) != new.map(f64::to_bits) {
                    *old = *new;
                    changed.push(to);
                }
            }
        }
    }
    count
}

/// Puts the patches of faces that came into the table and takes those of faces that went out of it; those whose points
/// or whose sharing of points may differ are made anew, too. `draw` are the faces to draw anew in any case, `changed` the
/// vertices with other values, by level.
pub(super) fn redraw(
    index: &mut Index,
    refinement: &Refinement,
    table: &mut PatchTable,
    irregular: Irregular,
    changed: &[Vec<u32>],
    changes: &mut Changes,
    draw: Vec<Vec<u32>>,
) -> Touched {
    let levels = refinement.levels.len();
    // Whoever makes a corner hands it to all around it, so all of them are made anew.
    let mut seeds: Vec<Vec<u32>> = (0..levels).map(|l| std::mem::take(&mut changes.dirty(l).corners)).collect();
    for (l, draw) in draw.iter().enumerate() {
        draw.iter().for_each(|&f| corners_of(refinement, l, f, &mut seeds));
    }
    let (mut anew, _) = incident(index, refinement, seeds);
    for (l, changed) in changed.iter().enumerate() {
        faces_near(index, refinement, l, changed, &mut anew);
    }
    for (anew, draw) in anew.iter_mut().zip(draw) {
        anew.extend(draw);
        anew.sort_unstable();
        anew.dedup();
    }
    let mut written = Written::default();
    let all = anew.iter().zip(0..).flat_map(|(faces, l)| faces.iter().map(move |&f| (l, f)));
    for (l, f) in changes.gone.iter().copied().chain(all) {
        let entry = index.levels[l as usize].drawn[f as usize];
        if entry != NONE {
            index.slots.remove(&mut index.levels, table, entry, f, &mut written);
        }
    }

    let mut seeds = vec![Vec::new(); levels];
    for (l, anew) in anew.iter().enumerate() {
        anew.iter().for_each(|&f| corners_of(refinement, l, f, &mut seeds));
    }
    let (faces, vertices) = incident(index, refinement, seeds);
    let mut cut = Cut::new(levels);
    for (l, (faces, vertices)) in faces.into_iter().zip(vertices).enumerate() {
        faces.iter().for_each(|&f| cut.add_beside(refinement, l, f));
        cut.drawn[l] = faces;
        let around = |v: u32| index.levels[l].around.of(v).iter().map(|&h| refinement.levels[l].face_of(h));
        cut.between[l].extend(vertices.into_iter().flat_map(around));
    }
    let made = cut.out(index, refinement);
    let small = build(&made.refinement, irregular);
    debug_assert_eq!(small.faces.len(), made.faces.len());
    let parts: HashMap<u32, [u32; 4]> = part_positions(&small).into_iter().collect();
    let firsts = first_points(&small, levels);
    let places = |i: usize| {
        let face = &small.faces[i];
        match parts.get(&(i as u32)) {
            None => ([face.first, NONE, NONE, NONE], 1, face.kind.points()),
            Some(at) => {
                let count = parts_of(constellation(face.transition)).len();
                (*at, count, face.kind.points() + EXTRA_POINTS)
            }
        }
    };
    // Faces that stay say which points are there already.
    let mut number = vec![NONE; small.control.len()];
    for (i, (face, f)) in small.faces.iter().zip(&made.faces).enumerate() {
        let entry = f.map_or(NONE, |f| index.levels[face.level as usize].drawn[f as usize]);
        if entry != NONE {
            let (to, count, stride) = index.slots.places(table, entry);
            for (at, to) in places(i).0.into_iter().zip(to).take(count) {
                for k in 0..stride {
                    number[small.indices[at as usize + k] as usize] = table.indices[to as usize + k];
                }
            }
        }
    }
    let mut touched = Touched::default();
    for (i, (face, f)) in small.faces.iter().zip(&made.faces).enumerate() {
        let Some(f) = *f else { continue };
        if index.levels[face.level as usize].drawn[f as usize] != NONE {
            continue;
        }
        let (at, count, stride) = places(i);
        let mut ids = Vec::with_capacity(count);
        for at in at.into_iter().take(count) {
            let mut own = Vec::with_capacity(stride);
            for &point in &small.indices[at as usize..at as usize + stride] {
                let known = &mut number[point as usize];
                if *known == NONE {
                    let level = firsts.partition_point(|&first| first <= point) - 1;
                    *known = index.slots.point(table, small.control[point as usize], level as u8, &mut written);
                } else {
                    // A corner that a finer face shares, which stays as it is but for that.
                    let (new, old) = (&small.control[point as usize], &mut table.control[*known as usize]);
                    if old.map(f64::to_bits) != new.map(f64::to_bits) {
                        *old = *new;
                        written.control.push(*known);
                    }
                }
                own.push(*known);
            }
            ids.push(own);
        }
        let entry = index.slots.add(table, *face, f, &ids, &mut written);
        index.levels[face.level as usize].drawn[f as usize] = entry;
        touched.faces += 1;
        touched.patches += count;
    }
    index.slots.settle(table, &mut written);
    let indices = written.indices.into_iter().map(|[at, n]| at..at + n).collect();
    touched.changed = Changed::together([Changed { control: written.control, indices }].iter());
    touched
}

/// Adds the vertices of a drawn face, and those in the middle of its split edges, to those of each level.
fn corners_of(refinement: &Refinement, l: usize, f: u32, vertices: &mut [Vec<u32>]) {
    let level = &refinement.levels[l];
    vertices[l].extend(level.of_face(f).map(|h| level.origin[h as usize]));
    let mask = refinement.fates[l][f as usize] >> fate::TRANSITION;
    if mask != 0 {
        let next = &refinement.levels[l + 1];
        let split = level.of_face(f).enumerate().filter(|(i, _)| mask >> i & 1 == 1);
        let middle = |(_, h): (usize, u32)| next.origin[4 * level.child[h as usize] as usize + 1];
        vertices[l + 1].extend(split.map(middle));
    }
}

/// Drawn faces of all levels that touch one of the vertices, and those vertices on every level that has them.
fn incident(index: &mut Index, refinement: &Refinement, seeds: Vec<Vec<u32>>) -> (Vec<Vec<u32>>, Vec<Vec<u32>>) {
    let epoch = index.next_epoch();
    let mut queue: Vec<(usize, u32)> =
        seeds.into_iter().enumerate().flat_map(|(l, vertices)| vertices.into_iter().map(move |v| (l, v))).collect();
    let mut faces = vec![Vec::new(); refinement.levels.len()];
    let mut vertices = faces.clone();
    while let Some((l, v)) = queue.pop() {
        if std::mem::replace(&mut index.levels[l].vertex_mark[v as usize], epoch) == epoch {
            continue;
        }
        vertices[l].push(v);
        let level = &refinement.levels[l];
        for i in 0..index.levels[l].around.of(v).len() {
            let own = &index.levels[l];
            let h = own.around.of(v)[i];
            let mut f = level.face_of(h);
            let mut of = l;
            let mut fate = refinement.fates[l][f as usize];
            if l > 0 {
                let parent = own.parent[f as usize];
                if h & 3 == 0 {
                    queue.push((l - 1, refinement.levels[l - 1].origin[parent as usize]));
                }
                if fate == 0 {
                    // Padding: what is drawn there is above.
                    (of, f) = (l - 1, refinement.levels[l - 1].face_of(parent));
                    fate = refinement.fates[of][f as usize];
                }
            }
            if fate & fate::AFFECTED != 0 && of == l {
                queue.push((l + 1, refinement.levels[l + 1].origin[4 * level.child[h as usize] as usize]));
            } else if fate & fate::DRAWN != 0
                && refinement.levels[of].valence(f) == 4
                && std::mem::replace(&mut index.levels[of].face_mark[f as usize], epoch) != epoch
            {
                faces[of].push(f);
            }
        }
    }
    (faces, vertices)
}

/// Adds the drawn faces that touch a face of one of the vertices of level `l` to those of each level, and the transition
/// faces of the level above whose edges are split there.
fn faces_near(index: &mut Index, refinement: &Refinement, l: usize, vertices: &[u32], near: &mut [Vec<u32>]) {
    if vertices.is_empty() {
        return;
    }
    let epochs = [index.next_epoch(), index.next_epoch()];
    let (above, rest) = index.levels.split_at_mut(l);
    let own = &mut rest[0];
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
    for f in found {
        if std::mem::replace(&mut own.face_mark[f as usize], epochs[1]) == epochs[1] {
            continue;
        }
        if own.drawn[f as usize] != NONE {
            near[l].push(f);
        } else if let Some(above) = above.last().filter(|_| refinement.fates[l][f as usize] == 0) {
            // Padding of a face whose edges may be split.
            let parent = refinement.levels[l - 1].face_of(own.parent[f as usize]);
            let is_split = refinement.fates[l - 1][parent as usize] >> fate::TRANSITION != 0;
            if is_split && above.drawn[parent as usize] != NONE {
                near[l - 1].push(parent);
            }
        }
    }
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
    /// Number in its level of each face that is drawn, `None` where its points are not wanted.
    faces: Vec<Option<u32>>,
}

impl Cut {
    fn new(levels: usize) -> Cut {
        let none = || vec![Vec::new(); levels];
        Cut { drawn: none(), beside: none(), makers: none(), between: none() }
    }

    /// The halves of a transition face's edges are those of the children beside them.
    fn add_beside(&mut self, refinement: &Refinement, l: usize, f: u32) {
        let mask = refinement.fates[l][f as usize] >> fate::TRANSITION;
        if mask != 0 && refinement.rules == Rules::Gradtess {
            let level = &refinement.levels[l];
            for h in level.of_face(f).enumerate().filter(|(i, _)| mask >> i & 1 == 1).map(|i| i.1) {
                for h in [h, level.next(h)] {
                    self.beside[l + 1].push(level.child[h as usize]);
                }
            }
        }
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
                if lent || (needs && usize::from(index.slots.level[point as usize]) < l) {
                    wanted.push((v, point, lent));
                }
            }
        }
        for (v, point, lent) in wanted {
            let (mut l, mut v) = (l, v);
            while l > 0 && (lent || usize::from(index.slots.level[point as usize]) < l) {
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
    fn out(mut self, index: &mut Index, refinement: &Refinement) -> Piece {
        // In slot order, so that sums run in the same order as in the whole level.
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
            faces.sort_unstable_by_key(|&f| level.face[f as usize]);
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
            drawn.sort_unstable();
            makers.sort_unstable();
            let mut fates = Vec::with_capacity(faces.len());
            for f in faces {
                let fate = refinement.fates[l][*f as usize];
                if drawn.binary_search(f).is_ok() {
                    fates.push(fate);
                    piece.faces.push(Some(*f));
                } else if makers.binary_search(f).is_ok() {
                    // Its corners are wanted, not its parts.
                    fates.push(fate & ((1 << fate::TRANSITION) - 1));
                    piece.faces.push(None);
                } else {
                    fates.push(0);
                }
            }
            let names = refinement.levels.get(l + 1).map_or(&[][..], |next| &next.face);
            piece.refinement.levels.push(part_of(&refinement.levels[l], faces, below, names));
            piece.refinement.fates.push(fates);
        }
        piece
    }
}

/// The given faces of a level, in slot order, as a level of their own; `below` are those of the next level, whose faces
/// have these `names`.
fn part_of(level: &Level, faces: &[u32], below: &[u32], names: &[u64]) -> Level {
    let local = |f: u32| faces.binary_search_by_key(&level.face[f as usize], |&f| level.face[f as usize]).ok();
    let local = |f: u32| local(f).map(|f| f as u32);
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
        half_edges().map(|h| level.tint[h as usize]).filter(|t| vertices.binary_search(t).is_err()).collect();
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
            part.tint.push(match tints.binary_search(&t) {
                _ if t == v => own,
                Ok(tint) => (vertices.len() + tint) as u32,
                Err(_) => number(t),
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
                Some(&c) if c < CUT => {
                    let name = |c: u32| names[c as usize];
                    below.binary_search_by_key(&name(c), |&c| name(c)).map_or(NONE, |c| c as u32)
                }
                _ => NONE,
            });
        }
    }
    part
}
