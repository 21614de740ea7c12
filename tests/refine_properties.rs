//! What must hold of refinement whatever the scene: local equals global to the last bit, the drawn faces tile the mesh,
//! neighbours differ by one level, and no finer edit reaches a drawn face.

mod random_scene;

use gradtess::check::exact::{into_child, quarter, ExactFace};
use gradtess::mesh::HalfEdgeMesh;
use gradtess::patch::build::{build, rebuild};
use gradtess::patch::pack::{pack, repack, PackedTable};
use gradtess::patch::points::Irregular;
use gradtess::patch::PatchTable;
use gradtess::refine::forest::first_slot;
use gradtess::refine::{fate, refine, Mode, Options, Refinement, Rules};
use gradtess::scene::{CornerRule, Scene};
use gradtess::subdiv::fan::{colour_fan, position_fan, Fan};
use gradtess::subdiv::index_map::IndexMap;
use gradtess::subdiv::level::{Level, CUT};
use gradtess::subdiv::limit;
use random_scene::for_random_scenes;
use std::cell::RefCell;
use std::collections::{HashMap, HashSet};

fn refined(scene: &Scene, mesh: &HalfEdgeMesh, rules: Rules, mode: Mode) -> Refinement {
    refine(scene, mesh, Options { rules, mode }).unwrap()
}

const ADAPTIVE: Mode = Mode::Adaptive { isolate: 0 };

/// Faces by name.
fn names(level: &Level) -> HashMap<u64, u32> {
    level.face.iter().enumerate().map(|(f, &name)| (name, f as u32)).collect()
}

fn drawn(r: &Refinement) -> impl Iterator<Item = (usize, u32)> + '_ {
    r.fates.iter().enumerate().flat_map(|(l, fates)| {
        let of_level = fates.iter().enumerate().filter(|f| f.1 & fate::DRAWN != 0);
        of_level.map(move |(f, _)| (l, f as u32))
    })
}

/// The bits of a corner's position and colour.
fn bits(level: &Level, h: u32) -> [u64; 6] {
    let (p, c) = (level.position(h), level.corner_colour(h));
    [p.x, p.y, c.x, c.y, c.z, c.w].map(f64::to_bits)
}

/// A boundary vertex whose first sector is painted from both sides while settling begins in its second.
const TWO_SECTORS: &str = r#"{ "gradtess": 1, "technique": "subdivision",
    "vertices": [[-0.13, 0.09], [1.13, -0.08], [0.42, 0.9], [-0.35, 0.79], [-0.88, -0.05], [-0.45, -0.75]],
    "faces": [[2, 1, 0], [5, 4, 3, 0], [0, 3, 2]],
    "colour": [{ "level": 0, "half_edge": 0, "colour": [0.6, 0.57, 0.3] },
               { "level": 1, "half_edge": 288, "colour": [1, 1, 0.6] },
               { "level": 1, "half_edge": 108, "colour": [1, 1, 0.6] }] }"#;

#[test]
fn corners_of_a_sector_have_one_tint() {
    let one_tint = |scene: &Scene, mesh: &HalfEdgeMesh| {
        for rules in [Rules::Gradtess, Rules::Authors] {
            for level in refined(scene, mesh, rules, ADAPTIVE).levels {
                for h in 0..level.half_edges() as u32 {
                    if let Some(before) = level.spoke_before(h).filter(|_| !level.colour_border(h)) {
                        let (own, other) = (level.tint[h as usize], level.tint[before as usize]);
                        assert_eq!(own, other, "{rules:?}, level {}, half-edge {h}", level.level);
                    }
                }
            }
        }
    };
    let scene = Scene::parse(TWO_SECTORS.as_bytes(), "two sectors").unwrap();
    one_tint(&scene, &gradtess::mesh::build(&scene.mesh).unwrap());
    for_random_scenes(100, one_tint);
}

#[test]
fn local_refinement_is_global_refinement_restricted_bit_for_bit() {
    for_random_scenes(150, |scene, mesh| {
        for rules in [Rules::Authors, Rules::Gradtess] {
            let r = refined(scene, mesh, rules, ADAPTIVE);
            for (level, fates) in r.levels.iter().zip(&r.fates) {
                let whole = refined(scene, mesh, rules, Mode::Global(level.level));
                let global = whole.levels.last().unwrap();
                let named = names(global);
                let drawn = |f: u32| fates[f as usize] & fate::DRAWN != 0;
                for f in (0..level.faces() as u32).filter(|&f| drawn(f)) {
                    let g = named[&level.face[f as usize]];
                    for (h, k) in level.of_face(f).zip(global.of_face(g)) {
                        let at = (rules, level.level, level.face[f as usize], h);
                        assert_eq!(bits(level, h), bits(global, k), "{at:?}");
                        assert_eq!(level.colour_border(h), global.colour_border(k), "{at:?}");
                        let (own, other) = (level.origin[h as usize], global.origin[k as usize]);
                        assert_eq!(level.bits[own as usize], global.bits[other as usize], "{at:?}");
                        // The faces around: what the surface over this face depends on.
                        let mut ring = Vec::new();
                        level.around(h, |s| ring.push(s));
                        let mut there = Vec::new();
                        global.around(k, |s| there.push(s));
                        assert_eq!(ring.len(), there.len(), "{at:?}");
                        for (s, t) in ring.into_iter().zip(there) {
                            let (a, b) = (level.face_of(s), global.face_of(t));
                            assert_eq!(level.face[a as usize], global.face[b as usize], "{at:?}");
                            for (s, t) in level.of_face(a).zip(global.of_face(b)) {
                                assert_eq!(bits(level, s), bits(global, t), "ring of {at:?}");
                            }
                        }
                    }
                }
            }
        }
    });
}

#[test]
fn drawn_faces_tile_the_mesh() {
    for_random_scenes(250, |scene, mesh| {
        let map = IndexMap::new(mesh);
        for rules in [Rules::Authors, Rules::Gradtess] {
            let r = refined(scene, mesh, rules, ADAPTIVE);
            // Areas in units of 4^-12 of a face of M^0, whose n-gons have n children of level 1.
            let mut area = vec![0u64; map.faces(0) as usize];
            let mut seen = HashSet::new();
            for (l, f) in drawn(&r) {
                let name = r.levels[l].face[f as usize];
                assert!(seen.insert((l, name)));
                let mut up = name;
                for m in (1..l).rev() {
                    up >>= 2;
                    assert!(!seen.contains(&(m, up)), "face {name} of level {l} lies over another");
                }
                let slot = if l == 0 { first_slot(&map, 0, name) } else { up };
                let root = map.face(0, slot);
                area[root as usize] += match (l, map.face_valence(0, slot)) {
                    (0, _) => 1 << 24,
                    (l, 4) => 1 << (24 - 2 * l),
                    (l, _) => 1 << (24 - 2 * (l - 1)),
                };
            }
            for root in 0..map.faces(0) {
                let whole = match map.face_valence(0, first_slot(&map, 0, root)) {
                    4 => 1u64,
                    n => u64::from(n),
                };
                assert_eq!(area[root as usize], whole << 24, "{rules:?}: face {root} of M^0");
            }
        }
    });
}

#[test]
fn neighbours_differ_by_one_level_and_know_it() {
    for_random_scenes(250, |scene, mesh| {
        let map = IndexMap::new(mesh);
        let r = refined(scene, mesh, Rules::Gradtess, ADAPTIVE);
        let fates: HashMap<(u32, u64), u8> = r
            .levels
            .iter()
            .zip(&r.fates)
            .flat_map(|(level, fates)| level.face.iter().zip(fates).map(|(&name, &f)| ((level.level, name), f)))
            .collect();
        for (l, f) in drawn(&r) {
            let level = l as u32;
            let name = r.levels[l].face[f as usize];
            let first = first_slot(&map, level, name);
            let mut d = first;
            for i in 0.. {
                if let Some(t) = map.twin(level, d) {
                    let across = map.face(level, t);
                    let there = fates.get(&(level, across)).copied().unwrap_or(0);
                    let transition = fates[&(level, name)] >> (fate::TRANSITION + i) & 1 == 1;
                    assert_eq!(transition, there & fate::AFFECTED != 0, "face {name} of level {level}, edge {i}");
                    if there & (fate::AFFECTED | fate::DRAWN) == 0 {
                        let parent = map.face(level - 1, across);
                        let above = fates.get(&(level - 1, parent)).copied().unwrap_or(0);
                        assert!(above & fate::DRAWN != 0, "face {name} of level {level}: two levels across edge {i}");
                    }
                }
                d = map.next(level, d);
                if d == first {
                    break;
                }
            }
        }
    });
}

/// The face of level `to` of a global refinement that (u, v) of a face lies in, and where.
fn deep(global: &Refinement, mut l: usize, mut f: u32, to: usize, uv: [f64; 2]) -> (u32, [f64; 2]) {
    let [mut u, mut v] = uv;
    while l < to {
        let s = quarter(u, v);
        [u, v] = into_child(s, u, v);
        f = global.levels[l].child[(global.levels[l].first(f) + s) as usize];
        assert!(f < CUT);
        l += 1;
    }
    (f, [u, v])
}

#[test]
fn no_finer_edit_reaches_a_drawn_face() {
    // The limit over every drawn face, from the level it is drawn at, against the limit of the mesh that was refined
    // everywhere to the level of the deepest edit.
    for_random_scenes(120, |scene, mesh| {
        let r = refined(scene, mesh, Rules::Gradtess, ADAPTIVE);
        let to = (r.edit_level as usize).max(1);
        let global = refined(scene, mesh, Rules::Gradtess, Mode::Global(to as u32));
        let places: Vec<HashMap<u64, u32>> = global.levels.iter().map(names).collect();
        // One corner, one edge, two inside.
        let samples = [[0.0, 0.0], [1.0, 0.37], [0.31, 0.57], [0.83, 0.91]];
        for (l, f) in drawn(&r) {
            if l >= to {
                continue;
            }
            let g = places[l][&r.levels[l].face[f as usize]];
            let mut here = ExactFace::new(&r, l, f);
            for uv in samples {
                let (deep_face, at) = deep(&global, l, g, to, uv);
                let a = here.at(uv[0], uv[1]);
                let b = ExactFace::new(&global, to, deep_face).at(at[0], at[1]);
                let error = (a.p - b.p).abs().max_element().max((a.c - b.c).abs().max_element());
                assert!(
                    error < 1e-9,
                    "face {} of level {l} at {uv:?} misses an edit: {a:?} is {b:?}",
                    r.levels[l].face[f as usize]
                );
            }
        }
    });
}

#[test]
fn limits_of_random_meshes_are_inverted() {
    for_random_scenes(100, |scene, mesh| {
        let mut level = refined(scene, mesh, Rules::Gradtess, Mode::Global(0)).levels.pop().unwrap();
        let (mut p, mut c) = (Fan::default(), Fan::default());
        for h in (0..level.half_edges() as u32).step_by(3) {
            position_fan(&level, h, &mut p);
            let valences: Vec<u32> = p.half_edge.iter().map(|&s| level.valence(level.face_of(s))).collect();
            let wanted = limit::limit(&p, scene.corners) + glam::DVec2::new(0.125, -0.25);
            let v = level.origin[h as usize] as usize;
            let old = level.value[v].p;
            level.value[v].p = limit::control_for_limit(&p, &valences, wanted, scene.corners);
            position_fan(&level, h, &mut p);
            assert!((limit::limit(&p, scene.corners) - wanted).length() < 1e-12, "half-edge {h}");
            level.value[v].p = old;

            colour_fan(&level, h, &mut c);
            let valences: Vec<u32> = c.half_edge.iter().map(|&s| level.valence(level.face_of(s))).collect();
            let wanted = glam::DVec4::new(0.1, 0.9, 0.4, 1.0);
            let tint = level.tint[h as usize] as usize;
            let old = level.value[tint].c;
            level.value[tint].c = limit::control_for_limit(&c, &valences, wanted, scene.corners);
            colour_fan(&level, h, &mut c);
            assert!((limit::limit(&c, scene.corners) - wanted).length() < 1e-12, "colour at half-edge {h}");
            level.value[tint].c = old;
        }
    });
}

#[test]
fn names_are_bijections_on_random_meshes() {
    for_random_scenes(60, |_, mesh| {
        let map = IndexMap::new(mesh);
        for level in 0..3 {
            let mut vertices = HashSet::new();
            let mut edges = HashSet::new();
            let mut boundary = 0;
            for id in 0..map.half_edges(level) {
                let d = map.from_app_a(level, id).unwrap();
                assert_eq!(map.to_app_a(level, d), id);
                assert_eq!(map.prev(level, map.next(level, d)), d);
                match map.twin(level, d) {
                    Some(t) => assert_eq!(map.twin(level, t), Some(d)),
                    None => {
                        let b = map.boundary_app_a(level, d);
                        assert_eq!(map.boundary_twin_app_a(level, b), Some(id));
                        boundary += 1;
                    }
                }
                vertices.insert(map.vertex(level, d));
                edges.insert(map.edge_rank(level, d));
            }
            assert_eq!(boundary, map.boundary_half_edges(level));
            assert_eq!(vertices.len() as u64, map.vertices(level));
            assert_eq!(vertices.iter().max().unwrap() + 1, map.vertices(level));
            assert_eq!(edges.len() as u64, map.edges(level));
        }
    });
}

#[test]
fn the_recipes_reach_every_sort_of_scene() {
    let (seen, count) = (RefCell::new([0u32; 9]), std::cell::Cell::new(0));
    for_random_scenes(150, |scene, mesh| {
        use gradtess::subdiv::level::vertex_bits::{DART, SECTORS};
        count.set(count.get() + 1);
        let r = refined(scene, mesh, Rules::Gradtess, ADAPTIVE);
        let has = |bit: u8| r.levels.iter().any(|l| l.bits.iter().any(|b| b & bit != 0));
        let valence = |n: u32| (0..mesh.faces()).any(|f| mesh.valence(f) == n);
        let facts = [
            has(DART),
            has(SECTORS),
            (0..mesh.faces()).any(|f| mesh.valence(f) > 4),
            valence(3),
            scene.corners == CornerRule::Smooth,
            r.levels.len() > 3,
            r.fates.iter().flatten().any(|f| f >> fate::TRANSITION != 0),
            r.fates.last().unwrap().iter().any(|f| f & fate::IRREGULAR != 0),
            scene.geometry.iter().any(|g| g.frame == gradtess::scene::Frame::Boundary),
        ];
        for (n, fact) in seen.borrow_mut().iter_mut().zip(facts) {
            *n += u32::from(fact);
        }
    });
    println!("of {}: {:?}", count.get(), seen.borrow());
    assert!(seen.borrow().iter().all(|&n| n * 20 > count.get()), "{:?}", seen.borrow());
}

#[test]
fn a_table_in_old_memory_is_the_table_in_new_memory() {
    let old = RefCell::new((PatchTable::default(), PackedTable::default()));
    for_random_scenes(40, |scene, mesh| {
        let r = refined(scene, mesh, Rules::Gradtess, ADAPTIVE);
        let fresh = build(&r, Irregular::Gregory);
        let (table, packed) = &mut *old.borrow_mut();
        *table = rebuild(&r, Irregular::Gregory, std::mem::take(table));
        repack(table, packed);
        assert_eq!(fresh.control, table.control);
        assert_eq!((&fresh.indices, &fresh.ranges, &fresh.faces), (&table.indices, &table.ranges, &table.faces));
        assert_eq!(pack(&fresh), *packed);
    });
}
