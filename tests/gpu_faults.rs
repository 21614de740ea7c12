//! Memory that runs out and a device that is lost: the scene is what it was, the message says what happened, and what is
//! on the device is the old table or nothing.

mod gpu_support;

use glam::DVec2;
use gpu_support::{frame, with_gpu};
use gradtess::gpu::{DeviceTable, Gpu, GpuError};
use gradtess::incremental::{Outcome, State, ValueEdit};
use gradtess::patch::pack::pack;
use gradtess::patch::points::Irregular;
use gradtess::patch::PatchTable;
use gradtess::refine::Options;
use gradtess::scene::Scene;

fn state(name: &str) -> State {
    let mesh = gradtess::scene::shapes::builtin(name).unwrap();
    State::new(Scene { mesh, ..Scene::default() }, Options::default(), Irregular::Gregory).unwrap()
}

fn assert_holds(gpu: &Gpu, device: &mut DeviceTable, table: &PatchTable) {
    assert_eq!(device.ranges(), table.ranges);
    let packed = pack(table);
    let (control, indices) = gpu.read_table(device).unwrap();
    assert!(packed.control.iter().flatten().flat_map(|x| x.to_le_bytes()).eq(control));
    assert!(packed.indices.iter().flat_map(|i| i.to_le_bytes()).eq(indices));
}

/// A failure of the machine, with exit status 1, that names these.
fn assert_says(error: &GpuError, what: &[&str]) {
    let text = error.to_string();
    assert!(!error.is_request() && !text.contains('\n'), "{text}");
    assert!(what.iter().all(|w| text.contains(w)), "{text}");
}

#[test]
fn a_table_that_cannot_grow_stays_drawable() {
    with_gpu(|gpu| {
        let (small, large) = (state("quad").table, state("grid:12x12").table);
        let mut device = gpu.upload(&small).unwrap();
        gpu.update(&mut device, &small).unwrap();
        let before = gpu.allocated();
        // Staging and device memory, control points and indices: each of the four may be the one that fails.
        let mut failed = Vec::new();
        for extra in (0..).map(|i| i * 16384) {
            gpu.limit_memory(Some(before + extra));
            match gpu.update(&mut device, &large) {
                Ok(()) => break,
                Err(e) => {
                    assert_says(&e, &["memory for ", "limit of"]);
                    failed.push(e.to_string().split(':').next().unwrap().to_owned());
                }
            }
            assert_eq!(gpu.allocated(), before, "what was allocated on the way is free again");
        }
        failed.dedup();
        assert_eq!(failed.len(), 4, "{failed:?}");
        gpu.limit_memory(None);
        assert_holds(gpu, &mut device, &large);
        // Once more a failure, and the picture of what is there.
        gpu.limit_memory(Some(gpu.allocated()));
        assert!(gpu.update(&mut device, &state("grid:30x30").table).is_err());
        gpu.limit_memory(None);
        assert_holds(gpu, &mut device, &large);
        gpu.render(&device, &frame(16)).unwrap();
    });
}

#[test]
fn a_failed_partial_upload_is_made_good_by_a_whole_one() {
    with_gpu(|gpu| {
        let mut state = state("grid:12x12");
        let mut device = gpu.upload(&state.table).unwrap();
        let old = state.table.clone();
        let step = ValueEdit::Position(20, state.scene.mesh.positions[20] + DVec2::new(0.01, 0.02));
        let Outcome::Local(touched) = state.apply(&[step]) else { panic!("a drag keeps the plan") };
        for lost in [false, true] {
            gpu.limit_memory((!lost).then(|| gpu.allocated()));
            gpu.pretend_lost(lost);
            let error = gpu.update_points(&mut device, &state.table, &touched.control).unwrap_err();
            match lost {
                false => assert_says(&error, &["memory for changed points staging"]),
                true => assert_says(&error, &["vkQueueSubmit of changed points", "lost"]),
            }
            gpu.limit_memory(None);
            gpu.pretend_lost(false);
            if !lost {
                assert_holds(gpu, &mut device, &old);
                gpu.update_points(&mut device, &old, &[0]).unwrap();
            }
        }
        // The host has the edit, whatever became of the copy.
        let fresh = State::new(state.scene.clone(), Options::default(), Irregular::Gregory).unwrap();
        assert!(fresh.table.control == state.table.control && fresh.table.indices == state.table.indices);
        gpu.update(&mut device, &state.table).unwrap();
        assert_holds(gpu, &mut device, &state.table);
    });
}

#[test]
fn a_lost_device_is_named_and_leaves_an_empty_table() {
    with_gpu(|gpu| {
        let table = state("grid:4x4").table;
        let mut device = gpu.upload(&table).unwrap();
        gpu.pretend_lost(true);
        let error = gpu.update(&mut device, &table).unwrap_err();
        assert_says(&error, &["vkQueueSubmit of upload", "lost"]);
        assert!(device.ranges().is_empty() && device.bytes() == 0);
        assert_says(&gpu.render(&device, &frame(16)).map(drop).unwrap_err(), &["lost"]);
        gpu.pretend_lost(false);
        gpu.render(&device, &frame(16)).unwrap();
        gpu.update(&mut device, &table).unwrap();
        assert_holds(gpu, &mut device, &table);
    });
}
