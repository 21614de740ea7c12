//! After any edit, undo or redo the state that followed it is that of a fresh rebuild: the same table, bit for bit.

mod gpu_support;
mod models;
mod random_scene;
mod same_table;

use glam::{DVec2, DVec4};
use gradtess::incremental::{delta, Outcome, State, Whole};
use gradtess::patch::pack::pack;
use gradtess::patch::points::Irregular;
use gradtess::patch::PatchTable;
use gradtess::refine::{Mode, Options, Rules};
use gradtess::scene::{ColourEdit, Frame, GeometryEdit, Handle, Scene};
use gradtess::subdiv::index_map::IndexMap;
use gradtess::subdiv::level::Level;
use random_scene::for_random_scenes;
use std::cell::Cell;
use std::collections::BTreeMap;

/// A stream of numbers.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// -0.2 to 0.2.
    fn small(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64 * 0.4 - 0.2
    }

    fn step(&mut self) -> DVec2 {
        DVec2::new(self.small(), self.small())
    }

    /// Few different ones, so that neighbours are equal now and then.
    fn colour(&mut self) -> DVec4 {
        let n = self.below(6) as f64;
        DVec4::new(n / 5.0, 1.0 - n / 7.0, 0.3, 1.0)
    }
}

/// Something that a user might do; most often a change of values.
fn edit(scene: &mut Scene, random: &mut Random) {
    let mesh = gradtess::mesh::build(&scene.mesh).unwrap();
    let map = IndexMap::new(&mesh);
    match random.below(16) {
        0 | 1 => {
            let v = random.below(scene.mesh.positions.len());
            scene.mesh.positions[v] += random.step();
        }
        2 | 3 if !scene.handles.is_empty() => {
            let i = random.below(scene.handles.len());
            scene.handles[i].at += random.step();
        }
        4 if !scene.face_points.is_empty() => {
            let i = random.below(scene.face_points.len());
            scene.face_points[i].at += random.step();
        }
        5 | 6 if !scene.geometry.is_empty() => {
            let i = random.below(scene.geometry.len());
            let step = random.step();
            let e = &mut scene.geometry[i];
            (e.a, e.b) = (e.a + step.x, e.b + step.y);
        }
        7 | 8 if !scene.colours.is_empty() => {
            let i = random.below(scene.colours.len());
            scene.colours[i].colour = random.colour();
        }
        9 if !scene.corner_colours.is_empty() => {
            let i = random.below(scene.corner_colours.len());
            scene.corner_colours[i] = random.colour();
        }
        // The others change the plan.
        10 => {
            let level = random.below(3) as u32;
            let half_edge = random.next() % map.half_edges(level);
            let vertex = Some(map.vertex(level, map.from_app_a(level, half_edge).unwrap()));
            let step = random.step();
            if scene.geometry.iter().all(|e| (e.level, e.half_edge) != (level, half_edge)) {
                let e = GeometryEdit { level, half_edge, vertex, a: step.x, b: step.y, frame: Frame::Sector };
                scene.geometry.push(e);
            }
        }
        11 => {
            let level = random.below(3) as u32;
            let half_edge = random.next() % map.half_edges(level);
            let colour = random.colour();
            let free = scene.colours.iter().all(|e| (e.level, e.half_edge) != (level, half_edge));
            if free && map.is_colour_vertex(level, map.from_app_a(level, half_edge).unwrap()) {
                scene.colours.push(ColourEdit { level, half_edge, colour });
            }
        }
        // One colour all around a vertex, or none any more.
        14 | 15 => {
            let level = random.below(4) as u32;
            let slot = map.from_app_a(level, random.next() % map.half_edges(level)).unwrap();
            if !map.is_colour_vertex(level, slot) {
                return;
            }
            let mut names = Vec::new();
            map.around(level, slot, |s| names.push(map.to_app_a(level, s)));
            let before = scene.colours.len();
            scene.colours.retain(|e| e.level != level || !names.contains(&e.half_edge));
            if before == scene.colours.len() {
                let colour = random.colour();
                let edits = names.into_iter().map(|half_edge| ColourEdit { level, half_edge, colour });
                let at = if random.below(4) == 0 { random.below(before + 1) } else { before };
                scene.colours.splice(at..at, edits);
            }
        }
        12 => {
            let half_edge = random.below(mesh.half_edges() as usize) as u32;
            match random.below(3) {
                0 if random.below(2) == 0 && !scene.sharp.is_empty() => {
                    scene.sharp.remove(random.below(scene.sharp.len()));
                }
                0 => scene.sharp.push(half_edge),
                1 => {
                    let at = mesh.positions[mesh.origin[half_edge as usize] as usize] + random.step();
                    scene.face_points.push(Handle { half_edge, at });
                }
                _ => {
                    let at = mesh.positions[mesh.origin[half_edge as usize] as usize] + random.step();
                    scene.handles.push(Handle { half_edge, at });
                }
            }
        }
        _ => {
            if !scene.geometry.is_empty() && random.below(2) == 0 {
                scene.geometry.remove(random.below(scene.geometry.len()));
            } else if !scene.colours.is_empty() {
                scene.colours.remove(random.below(scene.colours.len()));
            }
        }
    }
}

fn bits(table: &PatchTable) -> Vec<[u64; 8]> {
    table.control.iter().map(|c| c.map(f64::to_bits)).collect()
}

fn fates(state: &State) -> Vec<BTreeMap<u64, u8>> {
    let level = |(level, fates): (&Level, &Vec<u8>)| {
        let there = level.face.iter().zip(fates).filter(|(_, &fate)| fate != 0);
        there.map(|(&name, &fate)| (name, fate)).collect()
    };
    state.refinement.levels.iter().zip(&state.refinement.fates).map(level).collect()
}

fn assert_equal(state: &State, options: Options, irregular: Irregular, what: &str) {
    let fresh = State::new(state.scene.clone(), options, irregular).unwrap();
    assert_eq!(fates(state), fates(&fresh), "{what}");
    same_table::assert_same(&state.table, &fresh.table, what);
    assert_eq!(state.points(), fresh.points(), "{what}: control points");
    assert_eq!(state.refinement.edit_level, fresh.refinement.edit_level, "{what}");
    assert_eq!(state.refinement.levels.len(), fresh.refinement.levels.len(), "{what}");
}

/// Someone who edits a scene, and now and then takes an edit back or makes it again.
struct Hand {
    random: Random,
    undo: Vec<Scene>,
    redo: Vec<Scene>,
}

impl Hand {
    fn new(random: Random) -> Hand {
        Hand { random, undo: Vec::new(), redo: Vec::new() }
    }

    /// The scene after the next edit, undo or redo.
    fn next(&mut self, now: &Scene) -> Scene {
        match self.random.below(6) {
            0 if !self.undo.is_empty() => {
                self.redo.push(now.clone());
                self.undo.pop().unwrap()
            }
            1 if !self.redo.is_empty() => {
                self.undo.push(now.clone());
                self.redo.pop().unwrap()
            }
            _ => {
                let mut next = now.clone();
                edit(&mut next, &mut self.random);
                self.undo.push(now.clone());
                self.redo.clear();
                next
            }
        }
    }
}

const WAYS: [(Rules, Irregular, Mode); 4] = [
    (Rules::Gradtess, Irregular::Gregory, Mode::Adaptive { isolate: 0 }),
    (Rules::Authors, Irregular::Gregory, Mode::Adaptive { isolate: 0 }),
    (Rules::Gradtess, Irregular::Bicubic, Mode::Adaptive { isolate: 2 }),
    (Rules::Gradtess, Irregular::Gregory, Mode::Global(2)),
];

#[test]
fn edits_undos_and_redos_give_the_tables_of_fresh_rebuilds() {
    let (local, all, isolated) = (Cell::new([0; 2]), Cell::new([0; 2]), Cell::new(0));
    for_random_scenes(60, |scene, _| {
        let seed =
            scene.mesh.positions.iter().fold(scene.colours.len() as u64, |s, p| s.rotate_left(7) ^ p.x.to_bits());
        let mut hand = Hand::new(Random(seed));
        for (rules, irregular, mode) in WAYS {
            let options = Options { rules, mode };
            let mut state = State::new(scene.clone(), options, irregular).unwrap();
            (hand.undo, hand.redo) = (Vec::new(), Vec::new());
            // Whether the numbers of points may be others than those of a fresh table.
            let mut replanned = false;
            for step in 0..12 {
                let before = state.scene.clone();
                let next = hand.next(&before);
                let edits = delta(&before, &next);
                let planned = edits.as_ref().is_none_or(|d| !d.is_values());
                let outcome = state.set(next).unwrap();
                // Nothing else is made anew as a whole.
                let may = matches!(
                    (rules, mode, &outcome),
                    (Rules::Authors, Mode::Adaptive { .. }, Outcome::Rebuilt(Whole::Cascade))
                        | (_, Mode::Adaptive { isolate: 2 }, Outcome::Rebuilt(Whole::Isolation))
                        | (.., Outcome::Local(_))
                );
                assert!(may, "{edits:?}: {outcome:?}");
                let [of_values, of_plans] = all.get();
                all.set([of_values + usize::from(!planned), of_plans + usize::from(planned)]);
                if matches!(outcome, Outcome::Local(_)) {
                    let more = usize::from(planned && mode == (Mode::Adaptive { isolate: 2 }));
                    isolated.set(isolated.get() + more);
                    let [of_values, of_plans] = local.get();
                    local.set([of_values + usize::from(!planned), of_plans + usize::from(planned)]);
                }
                // Colours that become equal to others, or stop being so, move patches, too.
                replanned |= matches!(&outcome, Outcome::Local(touched) if !touched.changed.indices.is_empty());
                if let (Outcome::Local(touched), false) = (&outcome, planned || replanned) {
                    let old = State::new(before, options, irregular).unwrap();
                    let changed: Vec<u32> = bits(&old.table)
                        .iter()
                        .zip(bits(&state.table))
                        .zip(0..)
                        .filter(|((a, b), _)| *a != b)
                        .map(|(_, i)| i)
                        .collect();
                    assert_eq!(touched.changed.control, changed, "what is said to have changed did, and nothing else");
                }
                replanned |= planned;
                replanned &= matches!(outcome, Outcome::Local(_));
                let what = format!("step {step}, {rules:?}, {irregular:?}, {mode:?}: {edits:?}, {outcome:?}");
                assert_equal(&state, options, irregular, &what);
            }
        }
    });
    println!(
        "in place: {:?} changes of values and of the plan of {:?}; {} of these isolated",
        local.get(),
        all.get(),
        isolated.get()
    );
    assert!(isolated.get() > 10);
    let ([values, plans], [all_values, all_plans]) = (local.get(), all.get());
    assert!(20 * values > 19 * all_values && 2 * plans > all_plans, "most edits are followed in place");
}

/// Who else asks for a face is looked up only when an edit goes that was there from the beginning.
#[test]
fn edits_of_real_models_go_and_come_back() {
    let Some(folder) = models::folder("paper", "edits of real models") else { return };
    let (mut folders, mut files) = (vec![folder], Vec::new());
    while let Some(folder) = folders.pop() {
        let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let (inner, own): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
        folders.extend(inner);
        files.extend(own);
    }
    files.retain(|file| file.extension().is_some_and(|e| e == "obj"));
    files.sort();
    let (options, irregular) = (Options::default(), Irregular::Gregory);
    let mut random = Random(8);
    let mut went = 0;
    for file in &files {
        let Ok(scene) = Scene::load(file) else { continue };
        let Ok(mut state) = State::new(scene.clone(), options, irregular) else { continue };
        let mut undo = vec![scene];
        for _ in 0..10 {
            let mut next = state.scene.clone();
            let (moves, paints) = (next.geometry.len(), next.colours.len());
            match random.below((moves + paints).max(1)) {
                i if i < moves => drop(next.geometry.remove(i)),
                i if i < moves + paints => drop(next.colours.remove(i - moves)),
                _ => break,
            }
            undo.push(next);
            assert!(matches!(state.set(undo.last().unwrap().clone()).unwrap(), Outcome::Local(_)), "{file:?}");
            assert_equal(&state, options, irregular, &format!("{file:?}: edits that go"));
            went += 1;
        }
        for scene in undo.into_iter().rev().skip(1) {
            state.set(scene).unwrap();
        }
        assert_equal(&state, options, irregular, &format!("{file:?}: all edits are back"));
    }
    println!("{went} edits of {} models", files.len());
}

#[test]
fn an_edit_that_does_not_fit_leaves_all_as_it_was() {
    let mesh = gradtess::scene::shapes::builtin("grid:4x4").unwrap();
    let scene = Scene { mesh, ..Scene::default() };
    let (options, irregular) = (Options::default(), Irregular::Gregory);
    let mut state = State::new(scene, options, irregular).unwrap();
    let edit = |level, half_edge| GeometryEdit { level, half_edge, vertex: None, a: 0.1, b: 0.2, frame: Frame::Sector };
    let with = |scene: &Scene, edit| Scene { geometry: [&scene.geometry[..], &[edit]].concat(), ..scene.clone() };
    for (i, level) in [(40, 2), (200, 1), (3000, 3)] {
        let outcome = state.set(with(&state.scene, edit(level, i))).unwrap();
        assert!(matches!(outcome, Outcome::Local(ref touched) if touched.came > 0), "{outcome:?}");
        // Levels and table stand in an order of their own now, and stay usable after an error.
        assert!(state.set(with(&state.scene, edit(2, 1 << 40))).is_err());
        let colour = ColourEdit { level: 1, half_edge: 1 << 40, colour: DVec4::ONE };
        assert!(state.set(Scene { colours: vec![colour], ..state.scene.clone() }).is_err());
        assert_equal(&state, options, irregular, "after errors");
    }
    let mut moved = state.scene.clone();
    moved.mesh.positions[5] += DVec2::splat(0.05);
    assert!(matches!(state.set(moved).unwrap(), Outcome::Local(_)));
    assert_equal(&state, options, irregular, "a drag after that");
}

#[test]
fn compacting_gives_the_room_back_and_edits_go_on_in_place() {
    let mesh = gradtess::scene::shapes::builtin("grid:6x6").unwrap();
    let scene = Scene { mesh, ..Scene::default() };
    let (options, irregular) = (Options::default(), Irregular::Gregory);
    let fresh = |scene: &Scene| State::new(scene.clone(), options, irregular).unwrap();
    let mut state = fresh(&scene);
    assert!(!state.compact(), "nothing has been edited");
    let edit = |half_edge| GeometryEdit { level: 2, half_edge, vertex: None, a: 0.1, b: 0.2, frame: Frame::Sector };
    let mut next = scene;
    for i in 0..24 {
        next.geometry.push(edit(90 * i));
        assert!(matches!(state.set(next.clone()).unwrap(), Outcome::Local(_)));
    }
    next.geometry.truncate(2);
    assert!(matches!(state.set(next.clone()).unwrap(), Outcome::Local(_)));
    let lengths = |table: &PatchTable| (table.control.len(), table.indices.len());
    let (loose, tight) = (lengths(&state.table), lengths(&fresh(&next).table));
    assert!(loose.0 > tight.0 && loose.1 > tight.1, "{loose:?} {tight:?}");
    assert!(state.compact());
    assert_eq!(lengths(&state.table), tight);
    assert!(!state.compact(), "there is no room left");
    next.geometry.push(edit(700));
    assert!(matches!(state.set(next).unwrap(), Outcome::Local(_)));
    assert_equal(&state, options, irregular, "an edit after that");
}

/// After each of `GRADTESS_EDIT_STEPS` steps: as many scenes as steps in each.
#[test]
fn the_device_has_what_the_host_and_a_fresh_rebuild_have_after_partial_uploads() {
    let steps = std::env::var("GRADTESS_EDIT_STEPS").ok().and_then(|value| value.parse::<u32>().ok()).unwrap_or(400);
    let each = steps.isqrt().max(12);
    gpu_support::with_gpu(|gpu| {
        let counts = Cell::new(Counts::default());
        for_random_scenes(steps.div_ceil(each), |scene, _| {
            let mut count = counts.get();
            let mut hand = Hand::new(Random(scene.geometry.len() as u64 + 77 * scene.colours.len() as u64));
            // Half of them in the way in which most is followed in place.
            let (rules, irregular, mode) = WAYS[hand.random.below(2 * WAYS.len() - 2).saturating_sub(WAYS.len() - 2)];
            let options = Options { rules, mode };
            let mut state = State::new(scene.clone(), options, irregular).unwrap();
            let mut device = gpu.upload(&state.table).unwrap();
            for step in 0..each {
                let next = hand.next(&state.scene);
                match state.set(next).unwrap() {
                    Outcome::Local(touched) => {
                        let (control, indices) = (&touched.changed.control, &touched.changed.indices);
                        let done = match indices.is_empty() {
                            true => gpu.update_points(&mut device, &state.table, control).unwrap(),
                            false => gpu.update_parts(&mut device, &state.table, control, indices).unwrap(),
                        };
                        count.parts += u32::from(!indices.is_empty());
                        assert_eq!(device.ranges(), state.table.ranges);
                        assert!(done.bytes >= 32 * control.len() as u64 && done.bytes <= device.bytes());
                        count.local += 1;
                        count.bytes = [count.bytes[0] + done.bytes, count.bytes[1] + device.bytes()];
                    }
                    Outcome::Rebuilt(_) => {
                        gpu.update(&mut device, &state.table).unwrap();
                        count.rebuilt += 1;
                    }
                }
                // Now and then nobody waits.
                if hand.random.below(8) == 0 && state.compact() {
                    gpu.update(&mut device, &state.table).unwrap();
                    count.compacted += 1;
                }
                assert_equal(&state, options, irregular, &format!("step {step}, {rules:?}, {irregular:?}, {mode:?}"));
                let packed = pack(&state.table);
                let (control, indices) = gpu.read_table(&mut device).unwrap();
                let same = packed.control.iter().flatten().flat_map(|x| x.to_le_bytes()).eq(control);
                assert!(same && packed.indices.iter().flat_map(|i| i.to_le_bytes()).eq(indices), "step {step}");
                count.read_back += 1;
            }
            // Copies that nobody waited for, and a table that goes while they are on their way.
            let all: Vec<u32> = (0..state.table.control.len() as u32).collect();
            for _ in 0..5 {
                gpu.update_points(&mut device, &state.table, &all).unwrap();
            }
            counts.set(count);
        });
        let count = counts.get();
        println!("{count:?}");
        assert!(count.parts > 15 && count.local > 50);
    });
}

/// What came of the steps.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    /// Followed in place; with other patches.
    local: u32,
    parts: u32,
    rebuilt: u32,
    compacted: u32,
    read_back: u32,
    /// Of partial uploads, and of whole tables in their place.
    bytes: [u64; 2],
}

#[test]
fn a_partial_upload_of_another_table_is_refused() {
    gpu_support::with_gpu(|gpu| {
        let table = |name: &str| {
            let mesh = gradtess::scene::shapes::builtin(name).unwrap();
            State::new(Scene { mesh, ..Scene::default() }, Options::default(), Irregular::Gregory).unwrap().table
        };
        let (one, other) = (table("quad"), table("grid:2x2"));
        let mut device = gpu.upload(&one).unwrap();
        assert!(gpu.update_points(&mut device, &other, &[0]).is_err());
        assert!(gpu.update_points(&mut device, &one, &[3, 2]).is_err());
        assert!(gpu.update_points(&mut device, &one, &[one.control.len() as u32]).is_err());
        assert!(gpu.update_points(&mut device, &one, &[]).is_ok_and(|done| done.bytes == 0));
        assert!(gpu.update_points(&mut device, &one, &[1]).is_ok_and(|done| done.bytes == 32));
    });
}
