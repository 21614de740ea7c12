//! Vertices where sharp edges meet so that no bicubic follows the colours of a sector (ZHHK22 4.4, Fig. 19).
//!
//! A sector of two faces is the half of a regular neighbourhood, one of one face a corner. Every other is drawn by
//! Gregory patches that miss the limit, by up to 1.5 % in the paper's Fig. 19. Once the faces around such a vertex are
//! refined, what is left of the error is small: [`LEVELS`].

use super::edits::Paint;
use crate::mesh::NONE;
use crate::scene::CornerRule;
use crate::subdiv::index_map::{IndexMap, Slot};
use std::collections::HashMap;

/// Levels that the faces around a meeting are refined in any case. One brings `scenes/unit/sharp_two_meet.json` from
/// 0.16 % to 0.02 % of the RGB cube's diagonal.
pub const LEVELS: u32 = 1;

/// A vertex where sharp edges meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Meeting {
    /// Level from which on its edges are sharp.
    pub level: u32,
    /// A slot of that level that leaves it.
    pub slot: Slot,
}

/// First level of a vertex and its least slot there.
pub(crate) type Birth = (u32, Slot);

/// The sharp spokes of a vertex, as slots of the level where it was born; the level from which on each is sharp, and how
/// many colours and tags make it so.
pub(crate) type Star = Vec<(Slot, u32, u32)>;

/// The vertices that sharp edges reach, and who makes them sharp: each group of colours and each tag adds its own share.
/// A sector that is painted beside one that is not counts as sharp, since its new colour is hardly the interpolated one.
/// Time linear in edits and tags, times the levels.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stars(HashMap<Birth, Star>);

impl Stars {
    /// Counts what colour edits make sharp, or (`more` false) does so no longer. They stand by vertex and level, all of a
    /// vertex's level together. `visit` is told the vertices that are reached, some of them several times.
    pub fn count_paints(&mut self, map: &IndexMap, paints: &[Paint], more: bool, mut visit: impl FnMut(Birth)) {
        for same in paints.chunk_by(|a, b| (a.vertex, a.level) == (b.vertex, b.level)) {
            let level = same[0].level;
            let painted = |d: Slot| same.iter().rev().find(|p| p.slot == d).map(|p| p.colour);
            for p in same {
                let own = painted(p.slot);
                if map.twin(level, p.slot).is_some_and(|t| painted(map.next(level, t)) != own) {
                    self.count_chain(map, level, p.slot, more, &mut visit);
                }
                if let Some(t) = map.spoke_after(level, p.slot).filter(|&t| painted(t) != own) {
                    self.count_chain(map, level, t, more, &mut visit);
                }
            }
        }
    }

    /// The same for the tag of an input half-edge.
    pub fn count_tag(&mut self, map: &IndexMap, h: u32, more: bool, mut visit: impl FnMut(Birth)) {
        if map.mesh().twin[h as usize] != NONE {
            self.count_chain(map, 0, 8 * u64::from(h), more, &mut visit);
        }
    }

    /// The three edges straight on from `d` become sharp ([`crate::subdiv::edit::paint`]).
    fn count_chain(&mut self, map: &IndexMap, level: u32, d: Slot, more: bool, visit: &mut impl FnMut(Birth)) {
        let mut e = d;
        // Each edge begins where the one before ends.
        let mut begin = None;
        for _ in 0..3 {
            let Some(t) = map.twin(level, e) else { return };
            for end in [e, t] {
                let (mut l, mut spoke) = (level, end);
                while l > 0 && spoke & 3 == 0 {
                    (l, spoke) = (l - 1, spoke >> 2);
                }
                let birth = begin.take().unwrap_or_else(|| map.birth(l, spoke));
                if end == t {
                    begin = Some(birth);
                }
                visit(birth);
                let star = self.0.entry(birth).or_default();
                let known = star.iter().position(|s| (s.0, s.1) == (spoke, level));
                match (known, more) {
                    (Some(i), true) => star[i].2 += 1,
                    (None, true) => star.push((spoke, level, 1)),
                    (Some(i), false) if star[i].2 > 1 => star[i].2 -= 1,
                    (Some(i), false) => drop(star.swap_remove(i)),
                    (None, false) => {}
                }
                if star.is_empty() {
                    self.0.remove(&birth);
                }
            }
            match map.twin(level, map.next(level, e)) {
                Some(t) => e = map.next(level, t),
                None => return,
            }
        }
    }

    /// Whether sharp edges meet at a vertex now.
    pub fn meeting(&self, map: &IndexMap, birth: Birth, corners: CornerRule) -> Option<Meeting> {
        let star = self.0.get(&birth)?;
        let spokes: Vec<Slot> = star.iter().map(|s| s.0).collect();
        let level = star.iter().map(|s| s.1).max()?;
        let (own, slot) = birth;
        is_irregular(map, own, slot, &spokes, corners).then(|| Meeting { level, slot: slot << (2 * (level - own)) })
    }

    /// All meetings, by level and slot of birth.
    pub fn meetings(&self, map: &IndexMap, corners: CornerRule) -> Vec<Meeting> {
        let mut born: Vec<Birth> = self.0.keys().copied().collect();
        born.sort_unstable();
        born.into_iter().filter_map(|birth| self.meeting(map, birth, corners)).collect()
    }

    /// Takes out the vertices that `which` accepts, in order.
    pub fn take(&mut self, which: impl Fn(Birth) -> bool) -> Vec<(Birth, Star)> {
        let mut births: Vec<Birth> = self.0.keys().copied().filter(|&birth| which(birth)).collect();
        births.sort_unstable();
        births.into_iter().filter_map(|birth| self.0.remove_entry(&birth)).collect()
    }

    /// Adds what others count at a vertex.
    pub fn add(&mut self, birth: Birth, more: &Star) {
        let star = self.0.entry(birth).or_default();
        for spoke in more {
            match star.iter_mut().find(|s| (s.0, s.1) == (spoke.0, spoke.1)) {
                Some(known) => known.2 += spoke.2,
                None => star.push(*spoke),
            }
        }
    }

    /// All vertices that sharp edges reach.
    pub fn vertices(&self) -> impl Iterator<Item = Birth> + '_ {
        self.0.keys().copied()
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let entries: usize = self.0.values().map(|star| size_of::<(Slot, u32, u32)>() * star.capacity()).sum();
        (size_of::<(Birth, Star)>() + 1) * self.0.capacity() * 8 / 7 + entries
    }
}

/// Whether the sharp spokes part the faces around the vertex, and it is extraordinary or has a sector that no bicubic
/// follows. A single sharp edge inside is a dart, whose own limit rule serves.
fn is_irregular(map: &IndexMap, level: u32, d: Slot, sharp: &[Slot], corners: CornerRule) -> bool {
    let mut first = d;
    while let Some(t) = map.twin(level, first) {
        first = map.next(level, t);
        if first == d {
            break;
        }
    }
    let boundary = map.twin(level, first).is_none();
    // Faces of each sector, from the first border on; a closed fan's first sector is completed by its last.
    let mut sectors = vec![0u32];
    let mut spoke = first;
    loop {
        if spoke != first && sharp.contains(&spoke) {
            sectors.push(0);
        }
        *sectors.last_mut().expect("one at least") += 1;
        match map.spoke_after(level, spoke) {
            Some(s) if s != first => spoke = s,
            _ => break,
        }
    }
    if !boundary && !sharp.contains(&first) {
        let last = sectors.pop().expect("one at least");
        match sectors.first_mut() {
            Some(faces) => *faces += last,
            None => return false,
        }
    }
    // One sector: a dart, or no sharp edge at all.
    let faces: u32 = sectors.iter().sum();
    let extraordinary = if boundary { faces > 2 } else { faces != 4 };
    let irregular = |faces: u32| faces > 2 || (faces == 1 && corners == CornerRule::Smooth);
    sectors.len() > 1 && (extraordinary || sectors.iter().any(|&faces| irregular(faces)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh;
    use crate::scene::Scene;
    use std::path::Path;

    fn of(name: &str) -> usize {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/unit").join(name);
        let scene = Scene::load(&path).unwrap();
        let mesh = mesh::build(&scene.mesh).unwrap();
        let map = IndexMap::new(&mesh);
        let edits = crate::refine::edits::resolve(&scene, &map).unwrap();
        let mut stars = Stars::default();
        scene.sharp.iter().for_each(|&h| stars.count_tag(&map, h, true, |_| {}));
        stars.count_paints(&map, &edits.paints, true, |_| {});
        stars.meetings(&map, scene.corners).len()
    }

    #[test]
    fn two_and_three_edges_meet_once_and_a_dart_meets_nothing() {
        assert_eq!(of("sharp_two_meet.json"), 1);
        assert_eq!(of("sharp_three_meet.json"), 1);
        assert_eq!(of("sharp_dart.json"), 0);
        assert_eq!(of("sharp_edge.json"), 0);
        assert_eq!(of("valence_5.json"), 0);
    }
}
