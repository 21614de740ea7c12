//! From refined levels to a [`PatchTable`]: 16 Bezier points a regular face, 20 a Gregory face, parts for
//! transition faces. Time linear in the patches; the levels are only read. Large levels are built by several cores
//! (`runs.rs`), with the same result.

use super::points::{Irregular, Points, Style, CORNER, FAR, INNER, NEAR};
use super::pool::Pool;
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
    let mut out = Builder::new(refinement, old);
    let mut above: Option<Points> = None;
    let mut waiting = Vec::new();
    for (level, fates) in refinement.levels.iter().zip(&refinement.fates) {
        let mut points = Points::new(level, fates, style);
        if let Some(coarse) = &above {
            points.inherit(coarse);
            // Transition faces of the level above meet the children of their neighbours here.
            out.transitions(&std::mem::take(&mut waiting), coarse.level(), &mut points);
        }
        out.faces(&mut points);
        waiting = std::mem::take(&mut out.waiting);
        above = Some(points);
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

/// Bucket of a transition face whose parts are still to come.
pub(super) const NO_BUCKET: u8 = u8::MAX;

/// What a run of faces is drawn with. The first bucket and the faces have their places in the table already.
pub(super) struct Drawn<'t> {
    /// Whole bicubics: indices, how many there are, and the number of the first in its bucket.
    pub plain: &'t mut [u32],
    pub plain_made: usize,
    pub plain_first: usize,
    /// Faces, and the bucket of each one's first patch; a face's first index counts within the bucket until the end.
    pub faces: &'t mut [Face],
    pub face_bucket: &'t mut [u8],
    pub faces_made: usize,
    pub faces_first: usize,
    /// Index arrays by what they draw, in draw order: whole bicubic (not here), whole Gregory, bicubic parts, Gregory parts.
    pub buckets: Vec<Vec<u32>>,
    pub waiting: Vec<Waiting>,
}

impl Drawn<'_> {
    fn emit(&mut self, kind: Kind, part: Option<usize>, ids: &[u32]) -> (u8, u32) {
        let b = bucket(kind, part);
        if b == 0 {
            let at = self.plain_made;
            self.plain[at..at + 16].copy_from_slice(ids);
            self.plain_made += 16;
            return (0, (self.plain_first + at) as u32);
        }
        let at = self.buckets[b].len() as u32;
        self.buckets[b].extend_from_slice(ids);
        (b as u8, at)
    }

    fn push(&mut self, face: Face, (bucket, first): (u8, u32)) {
        self.faces[self.faces_made] = Face { first, ..face };
        self.face_bucket[self.faces_made] = bucket;
        self.faces_made += 1;
    }
}

/// The table so far. Of the arrays as much is in use as `used` says; the rest is memory.
pub(super) struct Builder {
    pub control: Vec<ControlPoint>,
    pub indices: Vec<u32>,
    pub faces: Vec<Face>,
    pub face_bucket: Vec<u8>,
    /// Control points, indices of whole bicubics, and faces. Of control points it does not count those of a single run.
    pub used: [usize; 3],
    /// Whether several cores build.
    pub several: bool,
    /// As in [`Drawn`].
    pub buckets: Vec<Vec<u32>>,
    pub waiting: Vec<Waiting>,
    /// Per bucket: (level, first index) wherever the level changes.
    starts: Vec<Vec<(u32, u32)>>,
    ranges: Vec<DrawRange>,
}

impl Builder {
    fn new(refinement: &Refinement, old: PatchTable) -> Self {
        let drawn = |fates: &Vec<u8>| fates.iter().filter(|&f| f & fate::DRAWN != 0).count();
        let drawn: usize = refinement.fates.iter().map(drawn).sum();
        let PatchTable { mut control, mut indices, mut ranges, mut faces, .. } = old;
        let several = threads::several(drawn);
        if !several {
            control.clear();
            control.reserve(12 * drawn);
        } else if control.capacity() < 9 * drawn {
            // Zeros from the system come page by page to the core that writes there first.
            control = vec![[0.0; 8]; 12 * drawn];
        }
        if indices.len() < 16 * drawn {
            indices = vec![0; 16 * drawn];
        }
        let nothing =
            Face { level: 0, name: 0, turn: 0, kind: Kind::Bicubic, irregular: false, transition: 0, first: 0 };
        faces.resize(drawn, nothing);
        ranges.clear();
        Builder {
            control,
            indices,
            faces,
            face_bucket: vec![0; drawn],
            used: [0; 3],
            several,
            buckets: vec![Vec::new(); BUCKETS],
            waiting: Vec::new(),
            starts: vec![Vec::new(); BUCKETS],
            ranges,
        }
    }

    /// Draws the faces of a level but for its transition faces, which wait.
    fn faces(&mut self, points: &mut Points) {
        let before = self.lengths();
        if self.several {
            self.faces_in_runs(points);
        } else {
            let all = 0..points.level().faces();
            let (mut drawn, control) = self.all();
            Run { points, pool: control, drawn: &mut drawn }.faces(all);
            let Drawn { plain_made, faces_made, buckets, waiting, .. } = drawn;
            self.take(plain_made, faces_made, buckets, waiting);
        }
        self.note_starts(before, points.level().level);
    }

    /// Draws what has waited; `fine` are the points of the level below.
    fn transitions(&mut self, waiting: &[Waiting], coarse: &Level, fine: &mut Points) {
        let before = self.lengths();
        if self.several {
            self.transitions_in_runs(waiting, coarse, fine);
        } else {
            let (mut drawn, control) = self.all();
            let mut places = Vec::with_capacity(waiting.len());
            for face in waiting {
                let mut run = Run { points: fine, pool: control, drawn: &mut drawn };
                let (place, splits) = run.transition(face, coarse);
                places.push(place);
                note_splits(face, coarse, &splits, fine);
            }
            let Drawn { buckets, .. } = drawn;
            self.take(0, 0, buckets, Vec::new());
            for (face, place) in waiting.iter().zip(places) {
                self.place(face.index, place);
            }
        }
        self.note_starts(before, coarse.level);
    }

    /// A single run, which has all that is left.
    fn all(&mut self) -> (Drawn<'_>, &mut Vec<ControlPoint>) {
        let [_, indices, faces] = self.used;
        let drawn = Drawn {
            plain: &mut self.indices[indices..],
            plain_made: 0,
            plain_first: indices,
            faces: &mut self.faces[faces..],
            face_bucket: &mut self.face_bucket[faces..],
            faces_made: 0,
            faces_first: faces,
            buckets: std::mem::take(&mut self.buckets),
            waiting: Vec::new(),
        };
        (drawn, &mut self.control)
    }

    fn take(&mut self, indices: usize, faces: usize, buckets: Vec<Vec<u32>>, waiting: Vec<Waiting>) {
        (self.buckets, self.waiting) = (buckets, waiting);
        self.used[1] += indices;
        self.used[2] += faces;
    }

    /// Where the parts of a transition face begin.
    pub(super) fn place(&mut self, face: usize, (bucket, first): (u8, u32)) {
        self.face_bucket[face] = bucket;
        self.faces[face].first = first;
    }

    fn lengths(&self) -> [usize; BUCKETS] {
        std::array::from_fn(|b| if b == 0 { self.used[1] } else { self.buckets[b].len() })
    }

    fn note_starts(&mut self, before: [usize; BUCKETS], level: u32) {
        for (b, (before, now)) in before.into_iter().zip(self.lengths()).enumerate() {
            if now > before {
                self.starts[b].push((level, before as u32));
            }
        }
    }

    fn finish(mut self) -> PatchTable {
        // The whole bicubics are most of the table: their array becomes the table's.
        let lengths = self.lengths();
        let mut indices = self.indices;
        indices.truncate(self.used[1]);
        self.faces.truncate(self.used[2]);
        let mut base = [0; BUCKETS];
        for (b, (ids, starts)) in self.buckets.into_iter().zip(&self.starts).enumerate() {
            let (kind, part) = match b {
                0 => (Kind::Bicubic, None),
                1 => (Kind::Gregory, None),
                _ if b < 2 + PARTS.len() => (Kind::Bicubic, Some((b - 2) as u8)),
                _ => (Kind::Gregory, Some((b - 2 - PARTS.len()) as u8)),
            };
            let at = if b == 0 { 0 } else { indices.len() as u32 };
            base[b] = at;
            for (i, &(level, first)) in starts.iter().enumerate() {
                let stop = starts.get(i + 1).map_or(lengths[b] as u32, |s| s.1);
                let mut range = DrawRange { kind, part, level, first: at + first, count: 0 };
                range.count = (stop - first) / range.stride() as u32;
                self.ranges.push(range);
            }
            threads::extend(&mut indices, &ids, |i| i);
        }
        let buckets = &self.face_bucket;
        threads::update(&mut self.faces, |i, face| face.first += base[buckets[i] as usize]);
        if self.several {
            self.control.truncate(self.used[0]);
        }
        PatchTable {
            control: self.control,
            indices,
            ranges: self.ranges,
            faces: self.faces,
            colour: Default::default(),
        }
    }
}

/// The level below shares what a transition face made of its edges.
pub(super) fn note_splits(face: &Waiting, coarse: &Level, splits: &Splits, fine: &mut Points) {
    // The authors' halves are the face's own.
    if fine.style().rules == Rules::Gradtess {
        for i in (0..4).filter(|i| face.mask >> i & 1 == 1) {
            let [first, second] = halves(coarse, face.half_edges[i]);
            fine.note_split(first, second, splits[i]);
        }
    }
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
        let fates = self.points.fates();
        let level = self.points.level();
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
        let level = points.level();
        let mask = fate >> fate::TRANSITION;
        if mask == 0 && points.is_plain(f) {
            // Most faces of most scenes.
            let ids = points.plain_face(f, self.pool);
            let face = Face {
                level: level.level,
                name: level.face[f as usize],
                turn: 0,
                kind: Kind::Bicubic,
                irregular: false,
                transition: 0,
                first: 0,
            };
            let first = self.drawn.emit(Kind::Bicubic, None, &ids);
            self.drawn.push(face, first);
            return;
        }
        let (_, turn) = standard_position(mask);
        let first = level.first(f);
        let half_edges = [0, 1, 2, 3].map(|i| first + ((i + u32::from(turn)) & 3));
        let gregory = fate & fate::IRREGULAR != 0 && points.style().irregular == Irregular::Gregory;
        let kind = if gregory { Kind::Gregory } else { Kind::Bicubic };

        let mut ids = [0u32; 20];
        if points.is_plain(f) {
            let plain = points.plain_face(f, self.pool);
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
            if gregory {
                self.gregory_points(&half_edges, &mut ids);
            } else {
                for (i, &h) in half_edges.iter().enumerate() {
                    ids[INNER[i]] = self.pool.push(points.inner(h));
                }
            }
        }

        let face = Face {
            level: level.level,
            name: level.face[f as usize],
            turn,
            kind,
            irregular: fate & fate::IRREGULAR != 0,
            transition: (mask >> turn | mask << (4 - turn)) & 0b1111,
            first: 0,
        };
        if mask == 0 {
            let first = self.drawn.emit(kind, None, &ids[..kind.points()]);
            self.drawn.push(face, first);
        } else {
            let index = self.drawn.faces_first + self.drawn.faces_made;
            self.drawn.waiting.push(Waiting { index, half_edges, points: ids, kind, mask: face.transition });
            self.drawn.push(face, (NO_BUCKET, 0));
        }
    }

    fn gregory_points(&mut self, half_edges: &[u32; 4], ids: &mut [u32; 20]) {
        let points = &mut *self.points;
        let valence = half_edges.map(|h| points.gregory_valence(h));
        let centroids = gregory::centroids(points.level(), points.level().face_of(half_edges[0]));
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

    /// Draws a transition face as the parts of its constellation, `points` being those of the level below: the place of the
    /// first part, and what was made of its edges.
    pub fn transition(&mut self, face: &Waiting, coarse: &Level) -> ((u8, u32), Splits) {
        let (kind, mask) = (face.kind, face.mask);
        let constellation = super::transition::constellation(mask);
        let corner = CORNER.map(|slot| face.points[slot]);
        let mut split = [[0u32; 5]; 4];
        for i in 0..4 {
            if mask >> i & 1 == 0 {
                continue;
            }
            split[i] = match self.points.style().rules {
                Rules::Gradtess => {
                    // Nobody else asks for these before: the face's is the only coarse side of the edge.
                    let [first, second] = halves(coarse, face.half_edges[i]);
                    let [a, b] = self.points.edge_values(first, None);
                    let middle = self.points.corner_value(first + 1, None);
                    let [c, d] = self.points.edge_values(second, None);
                    [a, b, middle, c, d].map(|p| self.pool.push(p))
                }
                // Without grading the neighbour's own edges may not be drawn either: the face's curve is halved.
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
            let mut ids = [corner[0]; 20 + EXTRA_POINTS];
            ids[..points].copy_from_slice(&face.points[..points]);
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
            let first = self.drawn.emit(kind, Some(part), &ids[..points + EXTRA_POINTS]);
            place.get_or_insert(first);
        }
        (place.expect("a transition edge makes parts"), split)
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
