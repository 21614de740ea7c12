//! A patch table whose patches come and go in place.
//!
//! Ranges stay dense: a patch that goes leaves its place to the last one of its sort. A patch that comes is put behind the
//! others of its sort, where there is room left by one that went, or into a new range with room for a quarter more than
//! there are. Nothing that stays is moved but that one patch. Control points count who draws with them; those that nobody
//! needs are given to the next that come.

use super::index::LevelIndex;
use super::memory::{extend_to, push, with_room, zeros};
use crate::mesh::NONE;
use crate::patch::remap::part_positions;
use crate::patch::transition::{constellation, parts_of, EXTRA_POINTS, PARTS};
use crate::patch::{ControlPoint, DrawRange, Face, Kind, PatchTable};
use std::collections::HashMap;

/// Least room of a new range, patches.
const LEAST_ROOM: usize = 64;
/// Greatest: all of it goes to the device with its first patch.
const MOST_ROOM: usize = 4096;

/// First control point that each level made, and the end. Faces stand by level; a level's points follow those of the
/// level above.
pub(super) fn first_points(table: &PatchTable, levels: usize) -> Vec<u32> {
    let mut first = 0;
    let mut faces = table.faces.iter().peekable();
    let mut firsts = Vec::with_capacity(levels);
    for l in 0..levels {
        firsts.push(first);
        while let Some(face) = faces.next_if(|f| f.level == l as u32) {
            let at = face.first as usize;
            let last = table.indices[at..at + face.kind.points()].iter().max().expect("a face has points");
            first = first.max(last + 1);
        }
    }
    firsts
}

/// What [`PatchTable`] does not say of its patches and points.
#[derive(Clone)]
pub struct Slots {
    /// Level that made each control point.
    pub(super) level: Vec<u8>,
    /// How often each is drawn with.
    uses: Vec<u32>,
    /// Those that are not.
    free: Vec<u32>,
    /// Owner of each patch of each range: its face and, for parts, which one.
    owners: Vec<Vec<Owner>>,
    /// Patches that each range has room for.
    room: Vec<u32>,
    /// First entries in the table's indices of the parts of transition faces.
    pub(super) parts: HashMap<u32, [u32; 4]>,
}

/// Face by its number in its level, level, part.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Owner {
    face: u32,
    level: u8,
    part: u8,
}

/// What an update changes in a table.
#[derive(Default)]
pub(super) struct Written {
    /// Control points, in no order.
    pub control: Vec<u32>,
    /// First entries and lengths of runs of indices, in no order.
    pub indices: Vec<[u32; 2]>,
    /// Points that lost a user.
    left: Vec<u32>,
}

impl Slots {
    /// Slots of a table as it was built; `numbers` are the faces' numbers in their levels. Time and memory linear.
    pub(super) fn new(table: &PatchTable, levels: usize, numbers: &[u32]) -> Slots {
        let mut slots = Slots {
            level: with_room(table.control.len()),
            uses: zeros(table.control.len()),
            free: Vec::new(),
            owners: table.ranges.iter().map(|r| Vec::with_capacity(r.count as usize)).collect(),
            room: table.ranges.iter().map(|r| r.count).collect(),
            parts: part_positions(table).into_iter().collect(),
        };
        let mut firsts = first_points(table, levels);
        firsts.push(u32::MAX);
        for (l, first) in firsts.windows(2).enumerate() {
            let end = (first[1] as usize).min(table.control.len());
            slots.level.resize(end.max(slots.level.len()), l as u8);
        }
        for range in &table.ranges {
            let first = range.first as usize;
            for &i in &table.indices[first..first + range.count as usize * range.stride()] {
                slots.uses[i as usize] += 1;
            }
        }
        // Patches of a range stand in the order of their faces.
        let at: HashMap<_, _> = table.ranges.iter().zip(0..).map(|(r, i)| ((r.kind, r.part, r.level), i)).collect();
        let mut whole = (None, 0);
        for (face, &number) in table.faces.iter().zip(numbers) {
            if face.transition == 0 {
                // Most faces follow one of their sort.
                let sort = (face.kind, None, face.level);
                if whole.0 != Some(sort) {
                    whole = (Some(sort), at[&sort]);
                }
                let owners: &mut Vec<Owner> = &mut slots.owners[whole.1];
                owners.push(Owner { face: number, level: face.level as u8, part: 0 });
                continue;
            }
            for (k, part) in parts(face).enumerate() {
                let owner = Owner { face: number, level: face.level as u8, part: k as u8 };
                let range: usize = at[&(face.kind, part, face.level)];
                slots.owners[range].push(owner);
            }
        }
        slots
    }

    /// Indices of the patches of a face: where each begins, and its length.
    pub(super) fn places(&self, table: &PatchTable, entry: u32) -> ([u32; 4], usize, usize) {
        let face = &table.faces[entry as usize];
        let points = face.kind.points();
        match face.transition {
            0 => ([face.first, NONE, NONE, NONE], 1, points),
            mask => (self.parts[&entry], parts_of(constellation(mask)).len(), points + EXTRA_POINTS),
        }
    }

    /// Takes a face out of the table.
    pub(super) fn remove(
        &mut self,
        index: &mut [LevelIndex],
        table: &mut PatchTable,
        entry: u32,
        number: u32,
        written: &mut Written,
    ) {
        let level = table.faces[entry as usize].level;
        // One at a time, since a face's own patches may be the last of their ranges.
        let count = self.places(table, entry).1;
        for k in 0..count {
            let (at, _, stride) = self.places(table, entry);
            let at = at[k];
            for &i in &table.indices[at as usize..at as usize + stride] {
                self.uses[i as usize] -= 1;
                written.left.push(i);
            }
            let range = self.range_at(table, at);
            let key = sort_of(&table.ranges[range]);
            let same = |r: &&usize| sort_of(&table.ranges[**r]) == key && table.ranges[**r].count > 0;
            let all: Vec<usize> = (0..table.ranges.len()).collect();
            let last = *all.iter().rev().find(same).expect("the face's own at least");
            let from = table.ranges[last].first + (table.ranges[last].count - 1) * stride as u32;
            let owner = self.owners[last].pop().expect("one for each patch");
            table.ranges[last].count -= 1;
            if from != at {
                table.indices.copy_within(from as usize..from as usize + stride, at as usize);
                written.indices.push([at, stride as u32]);
                let place = (at - table.ranges[range].first) as usize / stride;
                self.owners[range][place] = owner;
                let moved = index[owner.level as usize].drawn[owner.face as usize];
                if owner.part == 0 {
                    table.faces[moved as usize].first = at;
                }
                if let Some(parts) = self.parts.get_mut(&moved) {
                    parts[owner.part as usize] = at;
                }
            }
        }
        index[level as usize].drawn[number as usize] = NONE;
        self.parts.remove(&entry);
        table.faces.swap_remove(entry as usize);
        let moved = table.faces.len() as u32;
        if moved != entry {
            if let Some(parts) = self.parts.remove(&moved) {
                self.parts.insert(entry, parts);
            }
            let at = self.places(table, entry).0[0];
            let range = self.range_at(table, at);
            let place = (at - table.ranges[range].first) as usize / table.ranges[range].stride();
            let owner = self.owners[range][place];
            index[owner.level as usize].drawn[owner.face as usize] = entry;
        }
    }

    /// Puts a face into the table, with the indices of its patches one after another; its entry.
    pub(super) fn add(
        &mut self,
        table: &mut PatchTable,
        face: Face,
        number: u32,
        indices: &[Vec<u32>],
        written: &mut Written,
    ) -> u32 {
        let entry = table.faces.len() as u32;
        let mut at = [NONE; 4];
        for (k, (part, ids)) in parts(&face).zip(indices).enumerate() {
            let like = DrawRange { kind: face.kind, part, level: face.level, first: 0, count: 0 };
            let range = self.range_with_room(table, like, written);
            let r = &mut table.ranges[range];
            at[k] = r.first + r.count * r.stride() as u32;
            r.count += 1;
            debug_assert_eq!(ids.len(), r.stride());
            table.indices[at[k] as usize..at[k] as usize + ids.len()].copy_from_slice(ids);
            written.indices.push([at[k], ids.len() as u32]);
            push(&mut self.owners[range], Owner { face: number, level: face.level as u8, part: k as u8 });
            ids.iter().for_each(|&i| self.uses[i as usize] += 1);
        }
        push(&mut table.faces, Face { first: at[0], ..face });
        if face.transition != 0 {
            self.parts.insert(entry, at);
        }
        entry
    }

    /// A control point that nobody draws with yet.
    pub(super) fn point(
        &mut self,
        table: &mut PatchTable,
        point: ControlPoint,
        level: u8,
        written: &mut Written,
    ) -> u32 {
        let i = self.free.pop().unwrap_or_else(|| {
            push(&mut table.control, point);
            push(&mut self.uses, 0);
            push(&mut self.level, level);
            table.control.len() as u32 - 1
        });
        (table.control[i as usize], self.level[i as usize]) = (point, level);
        written.control.push(i);
        i
    }

    /// Frees the points that nobody draws with any more. What stands there is no number, so that nothing takes it for one.
    pub(super) fn settle(&mut self, table: &mut PatchTable, written: &mut Written) {
        written.left.sort_unstable();
        written.left.dedup();
        for i in written.left.drain(..).filter(|&i| self.uses[i as usize] == 0) {
            table.control[i as usize] = [f64::NAN; 8];
            self.free.push(i);
            written.control.push(i);
        }
    }

    /// Control points that are drawn with.
    pub fn points(&self) -> usize {
        self.uses.len() - self.free.len()
    }

    /// Whether more than half of the table is room that edits left: a fresh one is worth its while.
    pub fn is_fragmented(&self, table: &PatchTable) -> bool {
        let used: usize = table.ranges.iter().map(|r| r.count as usize * r.stride()).sum();
        let spare = LEAST_ROOM * 28 * table.ranges.len();
        2 * self.free.len() > self.uses.len() + 1024 || table.indices.len() > 2 * used + spare
    }

    /// Whether more than an eighth of the table is room that edits left: worth a fresh one when there is time for it.
    pub fn is_loose(&self, table: &PatchTable) -> bool {
        let used: usize = table.ranges.iter().map(|r| r.count as usize * r.stride()).sum();
        let spare = LEAST_ROOM * 28 * table.ranges.len();
        8 * self.free.len() > self.uses.len() || 8 * table.indices.len() > 9 * used + 8 * spare
    }

    fn range_at(&self, table: &PatchTable, at: u32) -> usize {
        let holds = |r: &DrawRange| at >= r.first && at < r.first + r.count * r.stride() as u32;
        table.ranges.iter().position(holds).expect("a patch lies in a range")
    }

    fn range_with_room(&mut self, table: &mut PatchTable, like: DrawRange, written: &mut Written) -> usize {
        let key = sort_of(&like);
        let (mut behind, mut all) = (0, 0);
        for (i, range) in table.ranges.iter().enumerate() {
            if sort_of(range) == key && range.count < self.room[i] {
                return i;
            }
            if sort_of(range) <= key {
                behind = i + 1;
            }
            all += if sort_of(range) == key { range.count as usize } else { 0 };
        }
        let room = (all / 4).clamp(LEAST_ROOM, MOST_ROOM);
        let first = table.indices.len() as u32;
        let length = table.indices.len() + room * like.stride();
        extend_to(&mut table.indices, length, 0);
        written.indices.push([first, (room * like.stride()) as u32]);
        table.ranges.insert(behind, DrawRange { first, ..like });
        self.room.insert(behind, room as u32);
        self.owners.insert(behind, Vec::new());
        behind
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let owners: usize = self.owners.iter().map(|o| size_of::<Owner>() * o.capacity()).sum();
        self.level.capacity() + 4 * (self.uses.capacity() + self.free.capacity()) + owners + 24 * self.parts.capacity()
    }
}

/// Draw order of ranges.
fn sort_of(range: &DrawRange) -> (usize, u32) {
    let kind = usize::from(range.kind != Kind::Bicubic);
    (range.part.map_or(kind, |p| 2 + kind * PARTS.len() + p as usize), range.level)
}

/// Parts that a face is drawn as; `None`: whole.
fn parts(face: &Face) -> impl Iterator<Item = Option<u8>> {
    let all = match face.transition {
        0 => vec![None],
        mask => parts_of(constellation(mask)).map(|p| Some(p as u8)).collect(),
    };
    all.into_iter()
}
