//! Colours of a level: what its edits paint, which edges that makes sharp, and the sectors into which sharp edges part a
//! vertex. The same as [`crate::subdiv::edit::paint`], but of some vertices only, and whatever was there before.
//!
//! Who makes an edge sharp is kept apart: the level above (or a tag of the input), and the groups of colour edits whose
//! colours differ across one of their spokes. So one that goes takes only its own share away.

use super::index::{Index, LevelIndex, Source};
use crate::mesh::{HalfEdgeMesh, NONE};
use crate::scene::{CornerRule, Scene};
use crate::subdiv::gather::{self, Around};
use crate::subdiv::level::{vertex_bits, Level, Value};
use glam::{DVec2, DVec4};
use std::collections::{HashMap, HashSet};
use vertex_bits::{BOUNDARY, DART, SECTORS};

/// The colour edits of one vertex at one level.
#[derive(Clone, Default)]
pub(super) struct Group {
    /// Sectors in the order of the scene: of several edits of one the last holds.
    pub paints: Vec<(u32, Source)>,
    /// Half-edges, both sides, that it makes sharp.
    pub chain: Vec<u32>,
}

/// What is to be looked at in a level, with repetitions.
#[derive(Default)]
pub(super) struct Todo {
    /// Vertices whose colours may be others.
    pub colours: Vec<u32>,
    /// Vertices whose sectors may be others, too.
    pub sectors: Vec<u32>,
    /// Groups whose colours may be others.
    pub groups: Vec<u32>,
}

/// What came of it.
#[derive(Default)]
pub(super) struct Done {
    /// Vertices with another colour.
    pub changed: Vec<u32>,
    /// Vertices with other sharp edges or sectors.
    pub parted: Vec<u32>,
}

/// The level above one, and the way back to it.
pub(super) struct Above<'a> {
    pub level: &'a Level,
    pub around: &'a Around,
    /// Of the level itself.
    pub parent: &'a [u32],
}

impl Above<'_> {
    /// Position of the vertex that `h` leaves before the edits of its level.
    pub fn position(&self, h: u32, corners: CornerRule) -> DVec2 {
        gather::position(self.level, self.around, self.parent[h as usize >> 2], h & 3, corners)
    }

    /// Colour of the corner at the origin of `h` before the edits of its level.
    fn colour(&self, h: u32, corners: CornerRule) -> DVec4 {
        gather::colour(self.level, self.around, self.parent[h as usize >> 2], h & 3, corners)
    }

    fn is_sharp(&self, h: u32) -> bool {
        let parent = self.parent[h as usize >> 2];
        match h & 3 {
            0 => self.has_sharp(parent),
            3 => self.has_sharp(self.level.prev(parent)),
            _ => false,
        }
    }

    fn has_sharp(&self, h: u32) -> bool {
        !self.level.sharp.is_empty() && self.level.sharp[h as usize]
    }

    /// How the level above parts the colours around the origin of `h`.
    fn bits(&self, h: u32) -> u8 {
        let parent = self.parent[h as usize >> 2];
        let edge = match h & 3 {
            0 => return self.level.bits[self.level.origin[parent as usize] as usize] & (DART | SECTORS),
            1 => parent,
            2 => return 0,
            _ => self.level.prev(parent),
        };
        if self.has_sharp(edge) {
            SECTORS
        } else {
            0
        }
    }
}

/// What colours follow from.
struct Rules<'a> {
    scene: &'a Scene,
    mesh: &'a HalfEdgeMesh,
    above: Option<Above<'a>>,
    /// Tags of each input half-edge; of no edge that has none.
    tags: &'a HashMap<u32, u32>,
    corners: CornerRule,
}

impl Rules<'_> {
    /// Colour of a corner before the edits of its level.
    fn plain(&self, h: u32) -> DVec4 {
        self.above.as_ref().map_or(DVec4::ONE, |above| above.colour(h, self.corners))
    }

    /// Whether an edge is sharp before the colours of its level.
    fn is_sharp(&self, h: u32) -> bool {
        match &self.above {
            Some(above) => above.is_sharp(h),
            None if self.tags.is_empty() => false,
            None => input_edge(self.mesh, h).is_some_and(|e| self.tags.contains_key(&e)),
        }
    }

    /// Spokes and colours around the vertex of a group, and whether each is edited.
    fn sectors(&self, level: &Level, around: &Around, paints: &[(u32, Source)]) -> Vec<(u32, DVec4, bool)> {
        let of = |&h: &u32| match paints.iter().rev().find(|p| p.0 == h) {
            Some(&(_, Source::Edit(i))) => (h, self.scene.colours[i as usize].colour, true),
            Some(&(_, Source::Corner(i))) => (h, self.scene.corner_colours[i as usize], true),
            None => (h, self.plain(h), false),
        };
        around.of(level.origin[paints[0].0 as usize]).iter().map(of).collect()
    }
}

/// Input half-edge, the lesser of both sides, that a half-edge of M^0 lies along.
fn input_edge(mesh: &HalfEdgeMesh, h: u32) -> Option<u32> {
    let edge = match (h < 8 * mesh.half_edges(), h & 7) {
        (true, 0 | 4) => h >> 3,
        (true, 3) => mesh.prev(h >> 3),
        _ => return None,
    };
    Some(edge.min(mesh.twin[edge as usize]))
}

/// Both sides of the edges that colours which differ make sharp, ascending.
fn chain(level: &Level, sectors: &[(u32, DVec4, bool)]) -> Vec<u32> {
    let mut chain = Vec::new();
    for &(h, colour, edited) in sectors {
        let Some(before) = level.spoke_before(h) else { continue };
        let Some(&(_, other, also)) = sectors.iter().find(|s| s.0 == before) else { continue };
        if (edited || also) && colour != other {
            straight(level, h, |e| chain.extend([Some(e), level.across(e)].into_iter().flatten()));
        }
    }
    chain.sort_unstable();
    chain.dedup();
    chain
}

/// The three edges straight on.
pub(super) fn straight(level: &Level, h: u32, mut visit: impl FnMut(u32)) {
    let mut e = h;
    for step in 0..3 {
        visit(e);
        match level.across(level.next(e)) {
            Some(t) if step < 2 => e = level.next(t),
            _ => return,
        }
    }
}

/// Calls `visit` with every corner that the sector of spoke `h` paints: its quad, the corners of its neighbours on the same
/// side of the spokes, and all corners of the vertex across.
fn painted_corners(level: &Level, around: &Around, h: u32, mut visit: impl FnMut(u32)) {
    let a = level.next(h);
    let (c, d) = (level.next(a), level.prev(h));
    let beyond = level.across(a).map(|t| level.next(t));
    [Some(h), Some(a), Some(d), beyond, level.across(c)].into_iter().flatten().for_each(&mut visit);
    around.of(level.origin[c as usize]).iter().copied().for_each(visit);
}

impl Index {
    /// Chain of a group that was just placed, its level being as it was refined.
    pub(super) fn chain_of(&self, scene: &Scene, mesh: &HalfEdgeMesh, levels: &[Level], l: usize, g: u32) -> Vec<u32> {
        let own = &self.levels[l];
        let above =
            l.checked_sub(1).map(|a| Above { level: &levels[a], around: &self.levels[a].around, parent: &own.parent });
        let rules = Rules { scene, mesh, above, tags: &self.tags, corners: scene.corners };
        chain(&levels[l], &rules.sectors(&levels[l], &own.around, &own.groups[g as usize].paints))
    }

    /// Follows colours and sharp edges in level `l`.
    pub(super) fn recolour(
        &mut self,
        scene: &Scene,
        mesh: &HalfEdgeMesh,
        coarser: &[Level],
        level: &mut Level,
        todo: Todo,
    ) -> Done {
        let l = coarser.len();
        let epochs = [self.next_epoch(), self.next_epoch()];
        let (finer, rest) = self.levels.split_at_mut(l);
        let own = &mut rest[0];
        let mut mark = std::mem::take(&mut own.vertex_mark);
        let mut groups = std::mem::take(&mut own.groups);
        let mut chained = std::mem::take(&mut own.chained);
        let mut free = std::mem::take(&mut own.free_values);
        let own = &*own;
        let above = coarser.last().zip(finer.last());
        let above = above.map(|(level, index)| Above { level, around: &index.around, parent: &own.parent });
        let rules = Rules { scene, mesh, above, tags: &self.tags, corners: scene.corners };
        let group_of = |v: u32| own.painted.get(v as usize).copied().filter(|&g| g != NONE);

        let Todo { mut colours, mut sectors, groups: mut waiting } = todo;
        sectors.retain(|&v| {
            !own.around.of(v).is_empty() && std::mem::replace(&mut mark[v as usize], epochs[0]) != epochs[0]
        });
        waiting.extend(colours.iter().chain(&sectors).filter_map(|&v| group_of(v)));
        let mut painted: HashMap<u32, DVec4> = HashMap::new();
        let mut seen = HashSet::new();
        while let Some(g) = waiting.pop() {
            if !seen.insert(g) || groups[g as usize].paints.is_empty() {
                continue;
            }
            let group = &mut groups[g as usize];
            let around = rules.sectors(level, &own.around, &group.paints);
            for &(h, colour, _) in &around {
                painted_corners(level, &own.around, h, |g| {
                    painted.insert(g, colour);
                    colours.push(level.origin[g as usize]);
                });
            }
            let chain = chain(level, &around);
            if chain == group.chain {
                continue;
            }
            for &h in &group.chain {
                uncount(&mut chained, h);
            }
            chain.iter().for_each(|&h| *chained.entry(h).or_insert(0) += 1);
            for &h in group.chain.iter().chain(&chain) {
                let v = level.origin[h as usize];
                if std::mem::replace(&mut mark[v as usize], epochs[0]) != epochs[0] {
                    sectors.push(v);
                    waiting.extend(group_of(v));
                }
            }
            group.chain = chain;
        }

        let mut done = Done::default();
        let mut pen = Pen { rules: &rules, painted: &painted, chained: &chained, free: &mut free };
        for &v in &sectors {
            let [changed, parted] = pen.settle(level, own, v);
            if changed {
                done.changed.push(v);
            }
            if parted {
                done.parted.push(v);
            }
        }
        for v in colours {
            let before = std::mem::replace(&mut mark[v as usize], epochs[1]);
            if before == epochs[0] {
                // Settled already; stays marked as such.
                mark[v as usize] = epochs[0];
            } else if before != epochs[1] && pen.colour(level, own, v) {
                done.changed.push(v);
            }
        }
        let own = &mut self.levels[l];
        (own.vertex_mark, own.groups, own.chained, own.free_values) = (mark, groups, chained, free);
        done
    }
}

/// One group less that makes an edge sharp.
pub(super) fn uncount(chained: &mut HashMap<u32, u32>, h: u32) {
    if let Some(n) = chained.get_mut(&h) {
        *n -= 1;
        if *n == 0 {
            chained.remove(&h);
        }
    }
}

/// What writes colours.
struct Pen<'a> {
    rules: &'a Rules<'a>,
    painted: &'a HashMap<u32, DVec4>,
    chained: &'a HashMap<u32, u32>,
    free: &'a mut Vec<u32>,
}

impl Pen<'_> {
    fn colour_of(&self, h: u32) -> DVec4 {
        match self.painted.is_empty() {
            true => self.rules.plain(h),
            false => self.painted.get(&h).copied().unwrap_or_else(|| self.rules.plain(h)),
        }
    }

    /// Colours of a vertex whose sectors are what they were; whether they differ from what they were.
    fn colour(&self, level: &mut Level, own: &LevelIndex, v: u32) -> bool {
        let (mut last, mut differs) = (NONE, false);
        for &h in own.around.of(v) {
            let tint = level.tint[h as usize];
            if tint != last {
                let c = self.colour_of(h);
                differs |= !same(std::mem::replace(&mut level.value[tint as usize].c, c), c);
                last = tint;
            }
        }
        differs
    }

    /// Sharp spokes, sectors and colours of a vertex; whether colours and whether sectors differ from what they were.
    fn settle(&mut self, level: &mut Level, own: &LevelIndex, v: u32) -> [bool; 2] {
        let spokes = own.around.of(v);
        let (mut sharp, mut chained, mut parted) = (0, false, false);
        for &h in spokes {
            let by_colours = !self.chained.is_empty() && self.chained.contains_key(&h);
            let is = by_colours || self.rules.is_sharp(h);
            chained |= by_colours;
            sharp += u32::from(is);
            let was = !level.sharp.is_empty() && level.sharp[h as usize];
            if is != was {
                if level.sharp.is_empty() {
                    level.sharp.resize(level.origin.len(), false);
                }
                level.sharp[h as usize] = is;
                parted = true;
            }
        }
        let bits = level.bits[v as usize];
        let now = match &self.rules.above {
            // Where faces are missing, not all sharp edges are there to be counted.
            Some(above) if !chained => above.bits(spokes[0]),
            _ => match (sharp, bits & BOUNDARY != 0) {
                (0, _) => 0,
                (1, false) => DART,
                _ => SECTORS,
            },
        };
        parted |= bits & (DART | SECTORS) != now;
        level.bits[v as usize] = bits & !(DART | SECTORS) | now;

        let old: Vec<u32> = spokes.iter().map(|&h| level.tint[h as usize]).collect();
        let before: Vec<DVec4> = old.iter().map(|&t| level.value[t as usize].c).collect();
        // First spoke and tint of each sector.
        let mut tints: Vec<(u32, u32)> = Vec::new();
        for (&h, &tint) in spokes.iter().zip(&old) {
            let first = match now & SECTORS {
                0 => spokes[0],
                _ => level.fan_start(h, |s| level.colour_border(s)),
            };
            let taken = |t: u32| tints.iter().any(|s| s.1 == t);
            let own = match tints.iter().find(|s| s.0 == first) {
                Some(s) => s.1,
                None => {
                    let own = match () {
                        _ if now & SECTORS == 0 => v,
                        _ if !taken(tint) => tint,
                        _ if !taken(v) => v,
                        _ => self.new_tint(level, v),
                    };
                    level.value[own as usize].p = level.value[v as usize].p;
                    level.value[own as usize].c = self.colour_of(first);
                    tints.push((first, own));
                    own
                }
            };
            parted |= own != tint;
            level.tint[h as usize] = own;
        }
        let changed = spokes.iter().zip(before).any(|(&h, c)| !same(level.corner_colour(h), c));
        let mut left = old;
        left.sort_unstable();
        left.dedup();
        self.free.extend(left.into_iter().filter(|&t| t != v && tints.iter().all(|s| s.1 != t)));
        [changed, parted]
    }

    fn new_tint(&mut self, level: &mut Level, v: u32) -> u32 {
        let value = Value { p: level.value[v as usize].p, c: DVec4::NAN };
        if let Some(t) = self.free.pop() {
            level.value[t as usize] = value;
            return t;
        }
        super::memory::push(&mut level.value, value);
        level.value.len() as u32 - 1
    }
}

fn same(a: DVec4, b: DVec4) -> bool {
    a.to_array().map(f64::to_bits) == b.to_array().map(f64::to_bits)
}
