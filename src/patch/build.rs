//! From refined levels to a [`PatchTable`]: 16 Bezier points a regular face, 20 a Gregory face, parts for
//! transition faces. Time linear in the patches; the levels are only read. Large levels are built by several cores
//! (`runs.rs`), with the same result.

use super::points::{Account, Irregular, Points, Style, CORNER, FAR, INNER, NEAR};
use super::pool::{Pool, LENT};
use super::transition::{parts_of, standard_position, Side, EXTRA_POINTS, PARTS};
use super::{eval, gregory, ControlPoint, DrawRange, Face, Kind, PatchTable};
use crate::refine::{fate, Refinement, Rules};
use crate::subdiv::level::Level;
use crate::threads;
use std::ops::Range;

/// Builds the patches of all drawn faces.
pub fn build(refinement: &Refinement, irregular: Irregular) -> PatchTable {
    rebuild(refinement, irregular, PatchTable::default())
}

/// The same in the memory of a table that is not needed any more. Fresh memory costs more than all arithmetic once a table
/// outgrows what the allocator keeps (32 MiB, about 60,000 patches), because the system clears every page of it.
pub fn rebuild(refinement: &Refinement, irregular: Irregular, old: PatchTable) -> PatchTable {
    let faces = refinement.fates.iter().map(Vec::len).sum();
    threads::crew(faces, || rebuild_levels(refinement, irregular, old))
}

fn rebuild_levels(refinement: &Refinement, irregular: Irregular, old: PatchTable) -> PatchTable {
    let style = Style { corners: refinement.corners, rules: refinement.rules, irregular };
    let mut out = Builder::new(refinement, irregular, old);
    let mut above: Option<Account> = None;
    let mut waiting = Vec::new();
    let parts = std::mem::take(&mut out.parts);
    for ((level, fates), parts) in refinement.levels.iter().zip(&refinement.fates).zip(&parts) {
        let account = Account::new(level, fates, style);
        if let Some(coarse) = &above {
            account.inherit(coarse);
            // Transition faces of the level above meet the children of their neighbours here.
            out.transitions(&std::mem::take(&mut waiting), coarse.level, &account);
        }
        out.faces(&account, parts);
        waiting = std::mem::take(&mut out.waiting);
        above = Some(account);
    }
    out.finish()
}

/// A transition face until the level below is there.
#[derive(Clone, Copy)]
pub(super) struct Waiting {
    /// Index in the table's faces.
    pub index: usize,
    /// Half-edges in patch order: the first leaves corner A.
    pub half_edges: [u32; 4],
    /// Control points of the face, 16 or 20.
    pub points: [u32; 20],
    pub kind: Kind,
    /// Bit i: edge i in patch order is a transition edge.
    pub mask: u8,
}

impl Waiting {
    /// Points that its parts add to those of the face.
    pub fn new_points(&self) -> usize {
        5 * self.mask.count_ones() as usize + usize::from(self.mask == 0b1111)
    }
}

/// The new points of a face's transition edges in patch order, if they have any: near and far point of the first half,
/// the middle, near and far of the second.
pub(super) type Splits = [[u32; 5]; 4];

pub(super) const BUCKETS: usize = 2 + 2 * PARTS.len();

fn bucket(kind: Kind, part: Option<usize>) -> usize {
    let kind = kind as usize;
    part.map_or(kind, |p| 2 + kind * PARTS.len() + p)
}

/// Indices by bucket.
pub(super) type Counts = [u32; BUCKETS];

/// Adds what a face of this kind and turned mask is drawn with.
pub(super) fn count_face(counts: &mut Counts, kind: Kind, mask: u8, faces: u32) {
    if mask == 0 {
        counts[bucket(kind, None)] += faces * kind.points() as u32;
    } else {
        for part in parts_of(super::transition::constellation(mask)) {
            counts[bucket(kind, Some(part))] += faces * (kind.points() + EXTRA_POINTS) as u32;
        }
    }
}

/// A transition mask in standard position.
fn turned(mask: u8, turn: u8) -> u8 {
    (mask >> turn | mask << (4 - turn)) & 0b1111
}

fn kind_of(fate: u8, irregular: Irregular) -> Kind {
    match fate & fate::IRREGULAR != 0 && irregular == Irregular::Gregory {
        true => Kind::Gregory,
        false => Kind::Bicubic,
    }
}

/// Faces of one level, and what draws them.
pub(super) struct Part {
    pub faces: Range<usize>,
    pub drawn: usize,
    /// Indices of its whole faces, and of its transition faces, which come with the level below.
    pub whole: Counts,
    pub transitions: Counts,
}

impl Part {
    fn new(level: &Level, fates: &[u8], irregular: Irregular, faces: Range<usize>) -> Part {
        let mut alike = [0u32; 256];
        for &fate in &fates[faces.start..faces.end.min(level.quads as usize).max(faces.start)] {
            alike[fate as usize] += 1;
        }
        for f in faces.start.max(level.quads as usize)..faces.end {
            alike[fates[f] as usize] += u32::from(level.valence(f as u32) == 4);
        }
        let mut part = Part { faces, drawn: 0, whole: [0; BUCKETS], transitions: [0; BUCKETS] };
        for (fate, &faces) in (0..=u8::MAX).zip(&alike).filter(|(fate, n)| fate & fate::DRAWN != 0 && **n > 0) {
            let mask = fate >> fate::TRANSITION;
            let counts = if mask == 0 { &mut part.whole } else { &mut part.transitions };
            count_face(counts, kind_of(fate, irregular), turned(mask, standard_position(mask).1), faces);
            part.drawn += faces as usize;
        }
        part
    }
}

/// A run's room in one bucket.
#[derive(Default)]
pub(super) struct Place<'t> {
    /// Number of the first index, and how many there are by now.
    first: u32,
    made: usize,
    list: &'t mut [u32],
}

/// What a run of faces is drawn with, each in its place in the table.
pub(super) struct Drawn<'t> {
    pub places: [Place<'t>; BUCKETS],
    pub faces: &'t mut [Face],
    pub faces_made: usize,
    pub faces_first: usize,
    pub waiting: Vec<Waiting>,
    /// First and end of indices among which some are lent.
    pub lent: Vec<(u32, u32)>,
}

impl Drawn<'_> {
    /// Adds the indices of one patch. Their number is a constant, since a call of `memcpy` costs more than they do.
    #[inline(always)]
    fn emit<P: Pool, const N: usize>(&mut self, bucket: usize, ids: &[u32; N]) -> u32 {
        let place = &mut self.places[bucket];
        let at = place.made;
        *place.list[at..].first_chunk_mut::<N>().expect("what was counted") = *ids;
        place.made += N;
        let first = place.first + at as u32;
        if P::SHARED && ids.iter().fold(0, |all, i| all | i) & LENT != 0 {
            self.lent.push((first, first + N as u32));
        }
        first
    }

    /// Adds the indices of a face, or of a part of one with its extra points behind.
    #[inline(always)]
    fn emit_face<P: Pool>(&mut self, kind: Kind, part: Option<usize>, ids: &[u32; 20 + EXTRA_POINTS]) -> u32 {
        let bucket = bucket(kind, part);
        match (kind == Kind::Gregory, part) {
            (false, None) => self.emit::<P, 16>(bucket, front_of(ids)),
            (true, None) => self.emit::<P, 20>(bucket, front_of(ids)),
            (false, Some(_)) => self.emit::<P, { 16 + EXTRA_POINTS }>(bucket, front_of(ids)),
            (true, Some(_)) => self.emit::<P, { 20 + EXTRA_POINTS }>(bucket, ids),
        }
    }

    #[inline(always)]
    fn push(&mut self, face: Face) {
        self.faces[self.faces_made] = face;
        self.faces_made += 1;
    }

    /// Whether everything that was counted is there.
    pub fn is_full(&self) -> bool {
        self.faces_made == self.faces.len() && self.places.iter().all(|p| p.made == p.list.len())
    }
}

/// Cuts the next places out of the table's indices, for runs in order.
pub(super) fn places<'t>(indices: &'t mut [u32], next: &mut Counts, counts: &[&Counts]) -> Vec<[Place<'t>; BUCKETS]> {
    let mut all: Vec<[Place; BUCKETS]> = counts.iter().map(|_| std::array::from_fn(|_| Place::default())).collect();
    let (mut rest, mut at) = (indices, 0);
    for b in 0..BUCKETS {
        for (places, counts) in all.iter_mut().zip(counts).filter(|(_, counts)| counts[b] > 0) {
            // Another level's.
            front(&mut rest, (next[b] - at) as usize);
            places[b] = Place { first: next[b], made: 0, list: front(&mut rest, counts[b] as usize) };
            next[b] += counts[b];
            at = next[b];
        }
    }
    all
}

/// The first of these indices.
#[inline(always)]
fn front_of<const N: usize>(ids: &[u32; 20 + EXTRA_POINTS]) -> &[u32; N] {
    ids.first_chunk().expect("no patch has more")
}

/// Takes the first `n` items away.
pub(super) fn front<'t, T>(items: &mut &'t mut [T], n: usize) -> &'t mut [T] {
    let (front, rest) = std::mem::take(items).split_at_mut(n);
    *items = rest;
    front
}

/// The table so far. What is counted has its place from the start; of the arrays as much is in use as was made.
pub(super) struct Builder {
    pub control: Vec<ControlPoint>,
    pub indices: Vec<u32>,
    pub faces: Vec<Face>,
    /// Control points, if several cores build, and faces so far.
    pub used: [usize; 2],
    /// Where the next index of each bucket goes.
    pub next: Counts,
    /// For each level its faces in runs: the quads and after them the shrunk faces.
    pub parts: Vec<[Vec<Part>; 2]>,
    /// Whether several cores build.
    several: bool,
    pub waiting: Vec<Waiting>,
    ranges: Vec<DrawRange>,
}

impl Builder {
    fn new(refinement: &Refinement, irregular: Irregular, old: PatchTable) -> Self {
        let several = threads::several(refinement.fates.iter().map(Vec::len).sum());
        let parts_of_level = |(level, fates): (&Level, &Vec<u8>)| {
            let (quads, faces) = (level.quads as usize, level.faces());
            // Shrunk faces touch nothing but quads, which may be in any run: those come first.
            [0..quads, quads..faces].map(|list| {
                let shifted = |r: Range<usize>| list.start + r.start..list.start + r.end;
                let runs: Vec<_> = threads::pieces(list.len()).into_iter().map(shifted).collect();
                threads::each(runs, |faces| Part::new(level, fates, irregular, faces))
            })
        };
        let parts: Vec<[Vec<Part>; 2]> = refinement.levels.iter().zip(&refinement.fates).map(parts_of_level).collect();
        let PatchTable { mut control, mut indices, mut ranges, mut faces, .. } = old;
        let drawn = parts.iter().flatten().flatten().map(|part| part.drawn).sum();
        ranges.clear();
        let next = layout(&refinement.levels, &parts, &mut ranges);
        if !several {
            control.clear();
            control.reserve(10 * drawn);
        } else if control.capacity() < 9 * drawn {
            // Zeros from the system come page by page to the core that writes there first.
            control = vec![[0.0; 8]; 12 * drawn];
        }
        let count = ranges.iter().map(|r| r.count as usize * r.stride()).sum();
        if indices.len() < count && indices.capacity() < count {
            indices = vec![0; count];
        }
        indices.resize(count, 0);
        let nothing =
            Face { level: 0, name: 0, turn: 0, kind: Kind::Bicubic, irregular: false, transition: 0, first: 0 };
        faces.resize(drawn, nothing);
        Builder { control, indices, faces, used: [0; 2], next, parts, several, waiting: Vec::new(), ranges }
    }

    /// Draws the faces of a level but for its transition faces, which wait.
    fn faces(&mut self, account: &Account, parts: &[Vec<Part>; 2]) {
        if self.several {
            parts.iter().for_each(|parts| self.faces_in_runs(account, parts));
            return;
        }
        for part in parts.iter().flatten() {
            let mut faces = &mut self.faces[self.used[1]..];
            let places = places(&mut self.indices, &mut self.next, &[&part.whole]).pop().expect("one run");
            let mut drawn = Drawn {
                places,
                faces: front(&mut faces, part.drawn),
                faces_made: 0,
                faces_first: self.used[1],
                waiting: Vec::new(),
                lent: Vec::new(),
            };
            let mut points = Points::new(account);
            Run { points: &mut points, pool: &mut self.control, drawn: &mut drawn }.faces(part.faces.clone());
            assert!(drawn.is_full(), "a run draws what was counted");
            self.used[1] += part.drawn;
            match self.waiting.is_empty() {
                true => self.waiting = drawn.waiting,
                false => self.waiting.append(&mut drawn.waiting),
            }
        }
    }

    /// Draws what has waited; `fine` is the account of the level below.
    fn transitions(&mut self, waiting: &[Waiting], coarse: &Level, fine: &Account) {
        if self.several {
            return self.transitions_in_runs(waiting, coarse, fine);
        }
        let counts = waiting_counts(waiting);
        let places = places(&mut self.indices, &mut self.next, &[&counts]).pop().expect("one run");
        let mut drawn =
            Drawn { places, faces: &mut [], faces_made: 0, faces_first: 0, waiting: Vec::new(), lent: Vec::new() };
        let mut points = Points::new(fine);
        for face in waiting {
            let mut run = Run { points: &mut points, pool: &mut self.control, drawn: &mut drawn };
            self.faces[face.index].first = run.transition(face, coarse);
        }
    }

    fn finish(mut self) -> PatchTable {
        if self.several {
            self.control.truncate(self.used[0]);
        }
        PatchTable {
            control: self.control,
            indices: self.indices,
            ranges: self.ranges,
            faces: self.faces,
            colour: Default::default(),
        }
    }
}

/// Indices of transition faces.
pub(super) fn waiting_counts(waiting: &[Waiting]) -> Counts {
    let mut counts = [0; BUCKETS];
    waiting.iter().for_each(|face| count_face(&mut counts, face.kind, face.mask, 1));
    counts
}

/// The draw ranges, bucket by bucket and in each level by level, and where the indices of each bucket begin.
fn layout(levels: &[Level], parts: &[[Vec<Part>; 2]], ranges: &mut Vec<DrawRange>) -> Counts {
    let mut next = [0; BUCKETS];
    let mut first = 0;
    for (b, next) in next.iter_mut().enumerate() {
        *next = first;
        let (kind, part) = match b {
            0 => (Kind::Bicubic, None),
            1 => (Kind::Gregory, None),
            _ if b < 2 + PARTS.len() => (Kind::Bicubic, Some((b - 2) as u8)),
            _ => (Kind::Gregory, Some((b - 2 - PARTS.len()) as u8)),
        };
        for (level, parts) in levels.iter().zip(parts) {
            let n: u32 = parts.iter().flatten().map(|p| p.whole[b] + p.transitions[b]).sum();
            if n > 0 {
                let mut range = DrawRange { kind, part, level: level.level, first, count: 0 };
                range.count = n / range.stride() as u32;
                ranges.push(range);
                first += n;
            }
        }
    }
    next
}

/// Half-edges of the level below along `h`.
fn halves(coarse: &Level, h: u32) -> [u32; 2] {
    [4 * coarse.child[h as usize], 4 * coarse.child[coarse.next(h) as usize] + 3]
}

/// A run of faces of one level being drawn.
pub(super) struct Run<'r, 'a, 't, P: Pool> {
    pub points: &'r mut Points<'a>,
    pub pool: &'r mut P,
    pub drawn: &'r mut Drawn<'t>,
}

impl<P: Pool> Run<'_, '_, '_, P> {
    pub fn faces(&mut self, faces: Range<usize>) {
        let fates = self.points.account.fates;
        let level = self.points.account.level;
        for f in faces {
            let fate = fates[f];
            if fate & fate::DRAWN != 0 && level.valence(f as u32) == 4 {
                self.face(f as u32, fate);
            }
        }
    }

    /// Makes a face's control points; draws it unless it has to wait for the level below.
    fn face(&mut self, f: u32, fate: u8) {
        let points = &mut *self.points;
        let level = points.account.level;
        let mask = fate >> fate::TRANSITION;
        let plain = points.account.is_plain(f).then(|| points.plain_face(f, self.pool));
        if let (0, Some(ids)) = (mask, plain) {
            // Most faces of most scenes.
            let mut face = Face {
                level: level.level,
                name: level.face[f as usize],
                turn: 0,
                kind: Kind::Bicubic,
                irregular: false,
                transition: 0,
                first: 0,
            };
            face.first = self.drawn.emit::<P, 16>(bucket(Kind::Bicubic, None), &ids);
            self.drawn.push(face);
            return;
        }
        let (_, turn) = standard_position(mask);
        let first = level.first(f);
        let half_edges = [0, 1, 2, 3].map(|i| first + ((i + u32::from(turn)) & 3));
        let kind = kind_of(fate, points.account.style.irregular);

        let mut ids = [0u32; 20 + EXTRA_POINTS];
        if let Some(plain) = plain {
            for i in 0..4 {
                let from = (i + turn as usize) & 3;
                for slots in [CORNER, NEAR, FAR, INNER] {
                    ids[slots[i]] = plain[slots[from]];
                }
            }
        } else {
            for (i, &h) in half_edges.iter().enumerate() {
                ids[CORNER[i]] = points.corner(h, self.pool);
                [ids[NEAR[i]], ids[FAR[i]]] = points.edge(h, self.pool);
            }
            if kind == Kind::Gregory {
                self.gregory_points(&half_edges, &mut ids);
            } else {
                for (i, &h) in half_edges.iter().enumerate() {
                    ids[INNER[i]] = self.pool.push(points.inner(h));
                }
            }
        }

        let mut face = Face {
            level: level.level,
            name: level.face[f as usize],
            turn,
            kind,
            irregular: fate & fate::IRREGULAR != 0,
            transition: turned(mask, turn),
            first: 0,
        };
        if mask == 0 {
            face.first = self.drawn.emit_face::<P>(kind, None, &ids);
        } else {
            let index = self.drawn.faces_first + self.drawn.faces_made;
            let points = *ids.first_chunk().expect("those of a whole face");
            self.drawn.waiting.push(Waiting { index, half_edges, points, kind, mask: face.transition });
        }
        self.drawn.push(face);
    }

    fn gregory_points(&mut self, half_edges: &[u32; 4], ids: &mut [u32; 20 + EXTRA_POINTS]) {
        let points = &mut *self.points;
        let valence = half_edges.map(|h| points.gregory_valence(h));
        let centroids = gregory::centroids(points.account.level, points.account.level.face_of(half_edges[0]));
        for i in 0..4 {
            let (next, prev) = ((i + 1) & 3, (i + 3) & 3);
            let at = |slot: usize| self.pool.at(ids[slot]);
            let plus = gregory::face_points(
                points,
                half_edges[i],
                false,
                [at(CORNER[i]), at(NEAR[i]), at(FAR[i])],
                [valence[i], valence[next]],
                &centroids,
            );
            let minus = gregory::face_points(
                points,
                half_edges[i],
                true,
                [at(CORNER[i]), at(FAR[prev]), at(NEAR[prev])],
                [valence[i], valence[prev]],
                &centroids,
            );
            ids[INNER[i]] = self.pool.push(plus);
            ids[16 + i] = self.pool.push(minus);
        }
    }

    /// Draws a transition face as the parts of its constellation, `points` being those of the level below, which shares
    /// what becomes of its edges. Where the first part is.
    pub fn transition(&mut self, face: &Waiting, coarse: &Level) -> u32 {
        let (kind, mask) = (face.kind, face.mask);
        let constellation = super::transition::constellation(mask);
        let corner = CORNER.map(|slot| face.points[slot]);
        let mut split: Splits = [[0; 5]; 4];
        for i in 0..4 {
            if mask >> i & 1 == 0 {
                continue;
            }
            split[i] = match self.points.account.style.rules {
                Rules::Gradtess => {
                    // Nobody else asks for these before: the face's is the only coarse side of the edge.
                    let [first, second] = halves(coarse, face.half_edges[i]);
                    let [a, b] = self.points.edge_values(first, None);
                    let middle = self.points.corner_value(first + 1, None);
                    let [c, d] = self.points.edge_values(second, None);
                    let split = [a, b, middle, c, d].map(|p| self.pool.push(p));
                    self.points.account.note_split(first, second, split);
                    split
                }
                // The authors' halves are the face's own. Without grading the neighbour's own edges may not be drawn either: the face's curve is halved.
                Rules::Authors => {
                    self.halve([corner[i], face.points[NEAR[i]], face.points[FAR[i]], corner[(i + 1) & 3]])
                }
            };
        }
        let centre = (constellation == 5).then(|| {
            let points: Vec<ControlPoint> = face.points[..kind.points()].iter().map(|&p| *self.pool.at(p)).collect();
            self.pool.push(eval::face(kind, &points, 0.5, 0.5))
        });

        let mut place = None;
        let points = kind.points();
        for part in parts_of(constellation) {
            let spec = &PARTS[part];
            // A Gregory face has all 20 points; those of a bicubic face end where the extra ones begin.
            let mut ids = [corner[0]; 20 + EXTRA_POINTS];
            ids[..20].copy_from_slice(&face.points);
            ids[points..points + EXTRA_POINTS].fill(corner[0]);
            for (slot, at) in ids[points..points + 4].iter_mut().zip(spec.corners) {
                *slot = match at {
                    [1, 1] => centre.expect("only C5 has a middle"),
                    [1, 0] => split[0][2],
                    [2, 1] => split[1][2],
                    [1, 2] => split[2][2],
                    [0, 1] => split[3][2],
                    _ => corner[face_corner(at)],
                };
            }
            let sides = if spec.triangle { 3 } else { 4 };
            for i in 0..sides {
                if let Side::Half(pair) = spec.sides[i] {
                    let (from, to) = (spec.corners[i], spec.corners[(i + 1) % sides]);
                    let (edge, half) =
                        if from.contains(&1) { ((face_corner(to) + 3) & 3, 3) } else { (face_corner(from), 0) };
                    let at = points + 4 + 2 * pair as usize;
                    ids[at..at + 2].copy_from_slice(&split[edge][half..half + 2]);
                }
            }
            let first = self.drawn.emit_face::<P>(kind, Some(part), &ids);
            place.get_or_insert(first);
        }
        place.expect("a transition edge makes parts")
    }

    /// Halves a cubic: near, far, middle, near, far. All channels.
    fn halve(&mut self, curve: [u32; 4]) -> [u32; 5] {
        let [a, b, c, d] = curve.map(|i| *self.pool.at(i));
        let mid = |x: ControlPoint, y: ControlPoint| std::array::from_fn(|k| (x[k] + y[k]) * 0.5);
        let (ab, bc, cd) = (mid(a, b), mid(b, c), mid(c, d));
        let (abc, bcd) = (mid(ab, bc), mid(bc, cd));
        [ab, abc, mid(abc, bcd), bcd, cd].map(|p| self.pool.push(p))
    }
}

/// Which corner of the face a domain point is.
fn face_corner(at: [u8; 2]) -> usize {
    match at {
        [0, 0] => 0,
        [2, 0] => 1,
        [2, 2] => 2,
        _ => 3,
    }
}

/// Control points of a whole face, 16 or 20 in the order of [`super`].
pub fn face_control(table: &PatchTable, face: &Face) -> Vec<ControlPoint> {
    let first = face.first as usize;
    table.indices[first..first + face.kind.points()].iter().map(|&i| table.control[i as usize]).collect()
}
