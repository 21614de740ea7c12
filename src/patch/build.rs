//! From refined levels to a [`PatchTable`]: 16 Bezier points a regular face, 20 a Gregory face, parts for
//! transition faces. Time linear in the patches; the levels are only read.

use super::points::{Irregular, Points, Style, CORNER, FAR, INNER, NEAR};
use super::transition::{parts_of, standard_position, Side, EXTRA_POINTS, PARTS};
use super::{eval, gregory, ControlPoint, DrawRange, Face, Kind, PatchTable};
use crate::refine::{fate, Refinement, Rules};
use crate::subdiv::level::Level;

/// Builds the patches of all drawn faces.
pub fn build(refinement: &Refinement, irregular: Irregular) -> PatchTable {
    rebuild(refinement, irregular, PatchTable::default())
}

/// The same in the memory of a table that is not needed any more. Fresh memory costs more than all arithmetic once a table
/// outgrows what the allocator keeps (32 MiB, about 60,000 patches), because the system clears every page of it.
pub fn rebuild(refinement: &Refinement, irregular: Irregular, old: PatchTable) -> PatchTable {
    let style = Style { corners: refinement.corners, rules: refinement.rules, irregular };
    let mut out = Builder::new(refinement, style, old);
    let mut above: Option<Points> = None;
    let mut waiting = Vec::new();
    for (level, fates) in refinement.levels.iter().zip(&refinement.fates) {
        let mut points = Points::new(level, style);
        if let Some(coarse) = &above {
            points.inherit(coarse);
            // Transition faces of the level above meet the children of their neighbours here.
            for face in waiting.drain(..) {
                out.transition(&face, coarse.level(), &mut points);
            }
        }
        for f in 0..level.faces() as u32 {
            let fate = fates[f as usize];
            if fate & fate::DRAWN != 0 && level.valence(f) == 4 {
                waiting.extend(out.face(f, fate, &mut points));
            }
        }
        above = Some(points);
    }
    out.finish()
}

/// A transition face until the level below is there.
struct Waiting {
    /// Index in the table's faces.
    index: usize,
    /// Half-edges in patch order: the first leaves corner A.
    half_edges: [u32; 4],
    /// Control points of the face, 16 or 20.
    points: [u32; 20],
}

/// Index arrays by what a range draws, in draw order: whole bicubic, whole Gregory, bicubic parts, Gregory parts.
struct Builder {
    style: Style,
    table: PatchTable,
    buckets: Vec<Vec<u32>>,
    /// Per bucket: (level, first index) wherever the level changes.
    starts: Vec<Vec<(u32, u32)>>,
    /// Bucket of each face's first patch.
    face_bucket: Vec<u8>,
}

const BUCKETS: usize = 2 + 2 * PARTS.len();

fn bucket(kind: Kind, part: Option<usize>) -> usize {
    let kind = kind as usize;
    part.map_or(kind, |p| 2 + kind * PARTS.len() + p)
}

impl Builder {
    fn new(refinement: &Refinement, style: Style, old: PatchTable) -> Self {
        let drawn: usize = refinement.fates.iter().flatten().filter(|&f| f & fate::DRAWN != 0).count();
        let mut table = PatchTable { colour: Default::default(), ..old };
        table.control.clear();
        table.indices.clear();
        table.ranges.clear();
        table.faces.clear();
        table.control.reserve(12 * drawn);
        table.faces.reserve(drawn);
        let mut buckets = vec![Vec::new(); BUCKETS];
        buckets[0] = std::mem::take(&mut table.indices);
        buckets[0].reserve(16 * drawn);
        Builder { style, table, buckets, starts: vec![Vec::new(); BUCKETS], face_bucket: Vec::with_capacity(drawn) }
    }

    /// Makes a face's control points; draws it, or returns it if it has to wait for the level below.
    fn face(&mut self, f: u32, fate: u8, points: &mut Points) -> Option<Waiting> {
        let level = points.level();
        let mask = fate >> fate::TRANSITION;
        if mask == 0 && points.is_plain(f) {
            // Most faces of most scenes.
            let ids = points.plain_face(f, &mut self.table.control);
            self.table.faces.push(Face {
                level: level.level,
                name: level.face[f as usize],
                turn: 0,
                kind: Kind::Bicubic,
                irregular: false,
                transition: 0,
                first: 0,
            });
            self.emit(self.table.faces.len() - 1, Kind::Bicubic, None, level.level, &ids);
            return None;
        }
        let (_, turn) = standard_position(mask);
        let first = level.first(f);
        let half_edges = [0, 1, 2, 3].map(|i| first + ((i + u32::from(turn)) & 3));
        let gregory = fate & fate::IRREGULAR != 0 && self.style.irregular == Irregular::Gregory;
        let kind = if gregory { Kind::Gregory } else { Kind::Bicubic };

        let mut ids = [0u32; 20];
        if points.is_plain(f) {
            let plain = points.plain_face(f, &mut self.table.control);
            for i in 0..4 {
                let from = (i + turn as usize) & 3;
                for slots in [CORNER, NEAR, FAR, INNER] {
                    ids[slots[i]] = plain[slots[from]];
                }
            }
        } else {
            for (i, &h) in half_edges.iter().enumerate() {
                ids[CORNER[i]] = points.corner(h, &mut self.table.control);
                [ids[NEAR[i]], ids[FAR[i]]] = points.edge(h, &mut self.table.control);
            }
            if gregory {
                self.gregory_points(&half_edges, &mut ids, points);
            } else {
                for (i, &h) in half_edges.iter().enumerate() {
                    let inner = points.inner(h);
                    ids[INNER[i]] = self.push(inner);
                }
            }
        }

        self.table.faces.push(Face {
            level: level.level,
            name: level.face[f as usize],
            turn,
            kind,
            irregular: fate & fate::IRREGULAR != 0,
            transition: (mask >> turn | mask << (4 - turn)) & 0b1111,
            first: 0,
        });
        let index = self.table.faces.len() - 1;
        if mask == 0 {
            self.emit(index, kind, None, level.level, &ids[..kind.points()]);
            return None;
        }
        self.face_bucket.push(u8::MAX);
        Some(Waiting { index, half_edges, points: ids })
    }

    fn gregory_points(&mut self, half_edges: &[u32; 4], ids: &mut [u32; 20], points: &mut Points) {
        let valence = half_edges.map(|h| points.gregory_valence(h));
        let centroids = gregory::centroids(points.level(), points.level().face_of(half_edges[0]));
        for i in 0..4 {
            let (next, prev) = ((i + 1) & 3, (i + 3) & 3);
            let at = |slot: usize| &self.table.control[ids[slot] as usize];
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
            ids[INNER[i]] = self.push(plus);
            ids[16 + i] = self.push(minus);
        }
    }

    /// Draws a transition face as the parts of its constellation; `fine` are the points of the level below.
    fn transition(&mut self, face: &Waiting, coarse: &Level, fine: &mut Points) {
        let (kind, mask, level) = {
            let f = &self.table.faces[face.index];
            (f.kind, f.transition, f.level)
        };
        let constellation = super::transition::constellation(mask);
        let corner = CORNER.map(|slot| face.points[slot]);
        // For each transition edge: near and far point of its first half, the middle, near and far of the second.
        let mut split = [[0u32; 5]; 4];
        for i in 0..4 {
            if mask >> i & 1 == 0 {
                continue;
            }
            let h = face.half_edges[i];
            split[i] = match self.style.rules {
                Rules::Gradtess => {
                    let first = 4 * coarse.child[h as usize];
                    let second = 4 * coarse.child[coarse.next(h) as usize] + 3;
                    let [a, b] = fine.edge(first, &mut self.table.control);
                    let middle = fine.corner(first + 1, &mut self.table.control);
                    let [c, d] = fine.edge(second, &mut self.table.control);
                    [a, b, middle, c, d]
                }
                // Without grading the neighbour's own edges may not be drawn either: the face's curve is halved.
                Rules::Authors => {
                    self.halve([corner[i], face.points[NEAR[i]], face.points[FAR[i]], corner[(i + 1) & 3]])
                }
            };
        }
        let centre = (constellation == 5).then(|| {
            let points: Vec<ControlPoint> =
                face.points[..kind.points()].iter().map(|&p| self.table.control[p as usize]).collect();
            let middle = eval::face(kind, &points, 0.5, 0.5);
            self.push(middle)
        });

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
            self.emit(face.index, kind, Some(part), level, &ids[..points + EXTRA_POINTS]);
        }
    }

    /// Halves a cubic: near, far, middle, near, far. All channels.
    fn halve(&mut self, curve: [u32; 4]) -> [u32; 5] {
        let [a, b, c, d] = curve.map(|i| self.table.control[i as usize]);
        let mid = |x: ControlPoint, y: ControlPoint| std::array::from_fn(|k| (x[k] + y[k]) * 0.5);
        let (ab, bc, cd) = (mid(a, b), mid(b, c), mid(c, d));
        let (abc, bcd) = (mid(ab, bc), mid(bc, cd));
        [ab, abc, mid(abc, bcd), bcd, cd].map(|p| self.push(p))
    }

    fn push(&mut self, point: ControlPoint) -> u32 {
        self.table.control.push(point);
        self.table.control.len() as u32 - 1
    }

    fn emit(&mut self, face: usize, kind: Kind, part: Option<usize>, level: u32, ids: &[u32]) {
        let b = bucket(kind, part);
        let at = self.buckets[b].len() as u32;
        if self.starts[b].last().is_none_or(|s| s.0 != level) {
            self.starts[b].push((level, at));
        }
        if part.is_none() {
            self.face_bucket.push(b as u8);
            self.table.faces[face].first = at;
        } else if self.face_bucket[face] == u8::MAX {
            self.face_bucket[face] = b as u8;
            self.table.faces[face].first = at;
        }
        self.buckets[b].extend_from_slice(ids);
    }

    fn finish(mut self) -> PatchTable {
        let mut base = Vec::with_capacity(BUCKETS);
        for (b, (ids, starts)) in self.buckets.into_iter().zip(&self.starts).enumerate() {
            let (kind, part) = match b {
                0 => (Kind::Bicubic, None),
                1 => (Kind::Gregory, None),
                _ if b < 2 + PARTS.len() => (Kind::Bicubic, Some((b - 2) as u8)),
                _ => (Kind::Gregory, Some((b - 2 - PARTS.len()) as u8)),
            };
            let at = self.table.indices.len() as u32;
            base.push(at);
            for (i, &(level, first)) in starts.iter().enumerate() {
                let stop = starts.get(i + 1).map_or(ids.len() as u32, |s| s.1);
                let mut range = DrawRange { kind, part, level, first: at + first, count: 0 };
                range.count = (stop - first) / range.stride() as u32;
                self.table.ranges.push(range);
            }
            if b == 0 {
                // The plain bicubics are most of the table: their array becomes the table's.
                self.table.indices = ids;
            } else {
                self.table.indices.extend_from_slice(&ids);
            }
        }
        for (face, &b) in self.table.faces.iter_mut().zip(&self.face_bucket) {
            face.first += base[b as usize];
        }
        self.table
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
