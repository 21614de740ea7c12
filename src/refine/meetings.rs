//! Vertices where sharp edges meet so that no bicubic follows the colours of a sector (ZHHK22 4.4, Fig. 19).
//!
//! A sector of two faces is the half of a regular neighbourhood, one of one face a corner. Every other is drawn by
//! Gregory patches that miss the limit, by up to 1.5 % in the paper's Fig. 19. Once the faces around such a vertex are
//! refined, what is left of the error is small: [`LEVELS`].

use super::edits::Paint;
use crate::mesh::NONE;
use crate::scene::CornerRule;
use crate::subdiv::index_map::{IndexMap, Slot};
use std::collections::BTreeMap;

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

/// The sharp spokes of a vertex, as slots of the level where it was born.
#[derive(Default)]
struct Star {
    level: u32,
    spokes: Vec<Slot>,
}

/// All meetings, by level and slot of birth. `paints` as [`super::edits::resolve`] sorts them; `sharp` are the tagged
/// half-edges of the input. A sector that is painted beside one that is not counts as sharp, since its new colour is
/// hardly the interpolated one. Time linear in edits and tags, times the levels.
pub fn meetings(map: &IndexMap, paints: &[Paint], sharp: &[u32], corners: CornerRule) -> Vec<Meeting> {
    let mut stars = BTreeMap::new();
    for &h in sharp.iter().filter(|&&h| map.mesh().twin[h as usize] != NONE) {
        add_chain(&mut stars, map, 0, 8 * u64::from(h));
    }
    for same in paints.chunk_by(|a, b| (a.vertex, a.level) == (b.vertex, b.level)) {
        let level = same[0].level;
        let painted = |d: Slot| same.iter().rev().find(|p| p.slot == d).map(|p| p.colour);
        for p in same {
            let own = painted(p.slot);
            if map.twin(level, p.slot).is_some_and(|t| painted(map.next(level, t)) != own) {
                add_chain(&mut stars, map, level, p.slot);
            }
            if let Some(t) = map.spoke_after(level, p.slot).filter(|&t| painted(t) != own) {
                add_chain(&mut stars, map, level, t);
            }
        }
    }
    stars
        .into_iter()
        .filter(|((level, slot), star)| is_irregular(map, *level, *slot, &star.spokes, corners))
        .map(|((level, slot), star)| Meeting { level: star.level, slot: slot << (2 * (star.level - level)) })
        .collect()
}

/// The three edges straight on from `d` become sharp ([`crate::subdiv::edit::paint`]).
fn add_chain(stars: &mut BTreeMap<(u32, Slot), Star>, map: &IndexMap, level: u32, d: Slot) {
    let mut e = d;
    for _ in 0..3 {
        let Some(t) = map.twin(level, e) else { return };
        for end in [e, t] {
            let (mut l, mut spoke) = (level, end);
            while l > 0 && spoke & 3 == 0 {
                (l, spoke) = (l - 1, spoke >> 2);
            }
            let star = stars.entry(map.birth(l, spoke)).or_default();
            star.level = star.level.max(level);
            if !star.spokes.contains(&spoke) {
                star.spokes.push(spoke);
            }
        }
        match map.twin(level, map.next(level, e)) {
            Some(t) => e = map.next(level, t),
            None => return,
        }
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
        meetings(&map, &edits.paints, &scene.sharp, scene.corners).len()
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
