//! Whatever the number of cores, levels, patches and what the device gets have the same bits in the same order.

mod random_scene;

use gradtess::patch::build::{build, rebuild};
use gradtess::patch::pack::pack;
use gradtess::patch::points::Irregular;
use gradtess::patch::PatchTable;
use gradtess::refine::{refine, Mode, Options, Refinement, Rules};
use gradtess::threads::set_least;
use random_scene::for_random_scenes;
use std::cell::Cell;

fn on<R: Send>(cores: usize, work: impl FnOnce() -> R + Send) -> R {
    rayon::ThreadPoolBuilder::new().num_threads(cores).build().unwrap().install(work)
}

fn assert_same(one: &(Refinement, PatchTable), other: &(Refinement, PatchTable), what: &str) {
    assert_eq!(one.0.fates, other.0.fates, "{what}");
    for (a, b) in one.0.levels.iter().zip(&other.0.levels) {
        // Numbers of vertices too: tests compare what is drawn elsewhere.
        assert!(a == b, "{what}: level {}", a.level);
    }
    assert_eq!(one.1.faces, other.1.faces, "{what}");
    assert_eq!(one.1.ranges, other.1.ranges, "{what}");
    assert_eq!(one.1.indices, other.1.indices, "{what}");
    let bits = |t: &PatchTable| t.control.iter().map(|c| c.map(f64::to_bits)).collect::<Vec<_>>();
    assert_eq!(bits(&one.1), bits(&other.1), "{what}");
}

#[test]
fn levels_and_patches_do_not_depend_on_the_number_of_cores() {
    // Even the smallest meshes in several pieces.
    set_least(3);
    let pools = [1, 2, 3, 8].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap());
    let faces = Cell::new(0);
    for_random_scenes(80, |scene, mesh| {
        for (rules, irregular, mode) in [
            (Rules::Gradtess, Irregular::Gregory, Mode::Adaptive { isolate: 0 }),
            (Rules::Authors, Irregular::Gregory, Mode::Adaptive { isolate: 0 }),
            (Rules::Gradtess, Irregular::Bicubic, Mode::Adaptive { isolate: 2 }),
            (Rules::Gradtess, Irregular::Gregory, Mode::Global(2)),
        ] {
            let make = || {
                let refined = refine(scene, mesh, Options { rules, mode }).unwrap();
                let table = build(&refined, irregular);
                (refined, table)
            };
            let one = pools[0].install(make);
            faces.set(faces.get() + one.1.faces.len());
            let packed = pack(&one.1);
            for (pool, n) in pools.iter().zip([1, 2, 3, 8]).skip(1) {
                let other = pool.install(make);
                let what = format!("{n} cores, {rules:?}, {irregular:?}, {mode:?}");
                assert_same(&one, &other, &what);
                assert_eq!(packed, pool.install(|| pack(&other.1)), "{what}");
                // In the memory of a table that was longer, and of one that was shorter.
                let (refined, table) = other;
                let mut longer = table.clone();
                longer.control.extend_from_within(..);
                longer.indices.extend_from_within(..);
                for old in [longer, PatchTable { control: table.control[..1].to_vec(), ..PatchTable::default() }] {
                    let again = pool.install(|| rebuild(&refined, irregular, old));
                    assert!(again.control == table.control && again.indices == table.indices, "{what}");
                }
            }
        }
    });
    println!("{} faces drawn", faces.get());
}

#[test]
fn a_large_sheet_is_the_same_on_one_core_and_two() {
    let mesh = gradtess::scene::shapes::builtin("grid:60x60").unwrap();
    let scene = gradtess::scene::Scene { mesh, ..Default::default() };
    let mesh = gradtess::mesh::build(&scene.mesh).unwrap();
    let make = || {
        let refined = refine(&scene, &mesh, Options::default()).unwrap();
        let table = build(&refined, Irregular::Gregory);
        (refined, table)
    };
    let [one, two] = [1, 2].map(|n| on(n, make));
    assert_same(&one, &two, "two cores");
}
