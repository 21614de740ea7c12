//! Memory that runs out and a device that is lost: the scene is what it was, the message says what happened, and what is
//! on the device is the old table or nothing.

mod gpu_support;

use glam::DVec2;
use gpu_support::{frame, with_gpu};
use gradtess::gpu::{DeviceTable, Gpu, GpuError};
use gradtess::incremental::{delta, Delta, Outcome, Splice, State, ValueEdit};
use gradtess::patch::pack::pack;
use gradtess::patch::points::Irregular;
use gradtess::patch::PatchTable;
use gradtess::refine::Options;
use gradtess::scene::{Frame, GeometryEdit, Scene};
use gradtess::subdiv::index_map::IndexMap;

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
        let Ok(Outcome::Local(touched)) = state.apply(&Delta::of(vec![step])) else { panic!("a drag keeps the plan") };
        for lost in [false, true] {
            gpu.limit_memory((!lost).then(|| gpu.allocated()));
            gpu.pretend_lost(lost);
            let error = gpu.update_points(&mut device, &state.table, &touched.changed.control).unwrap_err();
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

/// A new handle on a level that is not there yet.
fn handle(state: &State) -> Delta {
    let level = 2;
    let mesh = gradtess::mesh::build(&state.scene.mesh).unwrap();
    let map = IndexMap::new(&mesh);
    // Inside, two steps from the border at least.
    let inside = |&h: &u64| map.from_app_a(level, h).is_some_and(|d| map.twin(level, d).is_some());
    let half_edge = (0..).step_by(17).find(inside).unwrap();
    let edit = GeometryEdit { level, half_edge, vertex: None, a: 0.1, b: 0.05, frame: Frame::Sector };
    let mut next = state.scene.clone();
    next.geometry.push(edit);
    delta(&state.scene, &next).unwrap()
}

#[test]
fn an_edit_that_refines_is_uploaded_in_parts_or_leaves_the_old_table() {
    with_gpu(|gpu| {
        let mut state = state("grid:6x6");
        // Without spare room: the edit makes the table grow.
        let mut device = gpu.upload(&state.table).unwrap();
        let old = state.table.clone();
        let Ok(Outcome::Local(touched)) = state.apply(&handle(&state)) else { panic!("followed in place") };
        assert!(touched.came > 0 && state.table.control.len() > old.control.len());
        let changed = touched.changed;
        gpu.limit_memory(Some(gpu.allocated()));
        let error = gpu.update_parts(&mut device, &state.table, &changed.control, &changed.indices).unwrap_err();
        gpu.limit_memory(None);
        assert_says(&error, &["memory for ", "limit of"]);
        assert_holds(gpu, &mut device, &old);
        gpu.update_parts(&mut device, &state.table, &changed.control, &changed.indices).unwrap();
        assert_holds(gpu, &mut device, &state.table);

        // Now there is room for the next one.
        gpu.update(&mut device, &state.table).unwrap();
        let old = state.table.clone();
        let whole = device.bytes();
        let undo = Splice { at: state.scene.geometry.len() - 1, removed: 1, added: Vec::new() };
        let undo = Delta { geometry: undo, ..Delta::of(Vec::new()) };
        let Ok(Outcome::Local(touched)) = state.apply(&undo) else { panic!("followed in place") };
        assert!(touched.went > 0);
        let changed = touched.changed;
        for lost in [false, true] {
            gpu.limit_memory((!lost).then(|| gpu.allocated()));
            gpu.pretend_lost(lost);
            let error = gpu.update_parts(&mut device, &state.table, &changed.control, &changed.indices).unwrap_err();
            match lost {
                false => assert_says(&error, &["memory for changed points staging"]),
                true => assert_says(&error, &["vkQueueSubmit of changed points", "lost"]),
            }
            gpu.limit_memory(None);
            gpu.pretend_lost(false);
            assert_holds(gpu, &mut device, &old);
            if !lost {
                gpu.update_points(&mut device, &old, &[0]).unwrap();
            }
        }
        let done = gpu.update_parts(&mut device, &state.table, &changed.control, &changed.indices).unwrap();
        assert!(done.bytes < whole / 2, "{} of {whole} bytes", done.bytes);
        assert_holds(gpu, &mut device, &state.table);
        // Parts of another table, or of one that has more than they say.
        let other = self::state("grid:2x2").table;
        let beyond = 0..u32::MAX;
        assert!(gpu.update_parts(&mut device, &state.table, &changed.control, &[beyond]).is_err());
        assert!(gpu.update_parts(&mut device, &other, &[other.control.len() as u32], &[]).is_err());
        assert_holds(gpu, &mut device, &state.table);
    });
}
