//! Drags step by step: what is followed in place is what a fresh build gives, and the fold watch, which looks only at what
//! changed, decides as a test of all patches does.

mod random_scene;
mod same_table;

use glam::{DVec2, DVec4};
use gradtess::check::folds::{base_face, gd01, jacobian_sign, orientations, JacobianSign};
use gradtess::edit::drag::{size_of, Drag};
use gradtess::edit::folds::{drag_within, Cost, Watch};
use gradtess::edit::handle::{Id, Kind, Stage};
use gradtess::edit::model::{Drawing, Model};
use gradtess::edit::overlay::{overlay, Look};
use gradtess::edit::paint;
use gradtess::edit::place::exact_limit;
use gradtess::patch::build::face_control;
use gradtess::patch::{ControlPoint, Face};
use gradtess::refine::Mode;
use gradtess::scene::{Frame, GeometryEdit, Scene};
use random_scene::for_random_scenes;
use std::cell::Cell;

fn model(name: &str) -> Model {
    let file = format!("{}/scenes/{name}.json", env!("CARGO_MANIFEST_DIR"));
    Model::new(Scene::load(file).unwrap(), Drawing::default()).unwrap()
}

fn handles(model: &Model, stage: Stage) -> Vec<Id> {
    let look = Look { stage, view: [-1e4, -1e4, 1e4, 1e4], pixel: 0.01, control: false };
    let seen = overlay(&model.scene, &model.mesh, &model.refinement, &look).unwrap();
    seen.handles.iter().map(|h| h.id).collect()
}

fn assert_fresh(model: &Model, what: &str) {
    let fresh = Model::new(model.scene.clone(), model.drawing).unwrap();
    same_table::assert_same(&model.table, &fresh.table, what);
}

#[test]
fn every_step_of_a_scripted_drag_has_the_bits_of_a_fresh_build() {
    let (mut local, mut all) = (0, 0);
    for (name, stage) in [
        ("unit/mixed_polygons", Stage::Input),
        ("unit/geometry_level_2", Stage::Level(0)),
        ("unit/geometry_level_2", Stage::Level(2)),
        ("unit/colour_level_2", Stage::Level(1)),
        ("unit/sharp_dart", Stage::Level(1)),
    ] {
        let mut model = model(name);
        let size = size_of(&model.scene);
        let ids = handles(&model, stage);
        let moved: Vec<Id> = ids.iter().copied().filter(|id| id.kind.is_geometry()).collect();
        for &id in moved.iter().step_by(1 + moved.len() / 4) {
            let drag = Drag::begin(&model.scene, &model.mesh, id).unwrap();
            let (mut watch, mut at) = (Watch::new(&model), drag.start());
            for step in 1..=5 {
                let target = drag.start() + f64::from(step) * 0.004 * size * DVec2::new(0.8, 0.6);
                let (mut next, mut cost) = (model.scene.clone(), Cost::default());
                let ways = [at, target];
                at = drag_within(&mut watch, &drag, &model, &mut next, ways, 1e-5 * size, &mut cost).unwrap();
                let before = model.revision;
                model.set(next).unwrap();
                (all, local) = (all + 1, local + usize::from(model.changed_since(before).is_some()));
                assert_fresh(&model, &format!("{name} {id:?} step {step}"));
                let exact = exact_limit(&model.scene, &model.mesh, id.level, id.slot).unwrap();
                assert!(exact.distance(at) < 1e-11 * size, "{name} {id:?}: {at} in place of {exact}");
                assert!(model.limit(id.level, id.slot).unwrap().distance(exact) < 1e-12 * size.max(exact.length()));
            }
        }
        let painted = ids.iter().find(|id| id.kind == Kind::Colour);
        for (step, &id) in (0..5).zip(painted.iter().cycle()) {
            let mut next = model.scene.clone();
            let colour = DVec4::new(0.1 + 0.17 * f64::from(step), 0.4, 0.3, 1.0);
            paint::paint(&mut next, &model.mesh, &[(*id, colour)]).unwrap();
            let before = model.revision;
            model.set(next).unwrap();
            (all, local) = (all + 1, local + usize::from(model.changed_since(before).is_some()));
            assert_fresh(&model, &format!("{name} {id:?} paint {step}"));
        }
    }
    println!("{local} of {all} steps in place");
    assert!(3 * local > 2 * all, "most steps are followed in place: {local} of {all}");
}

#[test]
fn edits_are_followed_in_place_whatever_is_drawn() {
    let isolated = Mode::Adaptive { isolate: 1 };
    for (name, mode, all_in_place) in [
        ("unit/geometry_level_2", Mode::Global(2), true),
        ("unit/geometry_level_2", Mode::Global(0), true),
        ("unit/geometry_level_2", isolated, true),
        // What is isolated where sharp edges meet is looked at as a whole.
        ("unit/sharp_two_meet", isolated, false),
    ] {
        let mut model = model(name);
        if model.scene.geometry.is_empty() {
            let edit = GeometryEdit { level: 1, half_edge: 40, vertex: None, a: 0.0, b: 0.1, frame: Frame::Sector };
            model.set(Scene { geometry: vec![edit], ..model.scene.clone() }).unwrap();
        }
        model.draw(Drawing { mode, ..Drawing::default() }).unwrap();
        let first = model.scene.clone();
        let mut moved = first.clone();
        moved.mesh.positions[1] += DVec2::new(0.03, -0.02);
        moved.geometry[0].a += 0.05;
        let mut more = moved.clone();
        let edit = GeometryEdit { level: 3, half_edge: 700, vertex: None, a: 0.1, b: 0.05, frame: Frame::Sector };
        more.geometry.push(edit);
        let mut less = more.clone();
        less.geometry.remove(0);
        for (step, (next, only_values)) in
            [(&moved, true), (&more, false), (&less, false), (&more, false), (&moved, false), (&first, true)]
                .into_iter()
                .enumerate()
        {
            let before = model.revision;
            model.set(next.clone()).unwrap();
            let in_place = model.changed_since(before).is_some();
            assert_eq!(in_place, only_values || all_in_place, "{name} {mode:?} step {step}");
            let what = format!("{mode:?} step {step}");
            assert_fresh(&model, &what);
            // The levels in which handles are found.
            let fresh = Model::new(next.clone(), Drawing::default()).unwrap();
            same_table::assert_same(&model.to_try().table, &fresh.table, &what);
            assert_eq!(handles(&model, Stage::Level(2)), handles(&fresh, Stage::Level(2)), "{what}");
        }
        let room = model.compact().unwrap();
        assert_fresh(&model, &format!("{mode:?} compacted: {room}"));
        model.set(moved.clone()).unwrap();
        assert_fresh(&model, &format!("{mode:?} after that"));
    }
}

/// The verdict of a test of all patches of a fresh build.
fn full(start: &Model, scene: &Scene) -> bool {
    let zero = &start.refinement.levels[0];
    let orientations = orientations(zero);
    let sound = |f: &Face, points: &[ControlPoint]| {
        let turn = orientations[base_face(zero, f) as usize];
        gd01(f.kind, points, turn) || jacobian_sign(f.kind, points, turn, 1000) == JacobianSign::Positive
    };
    let within = |inner: &Face, outer: &Face| match outer.level {
        0 => u64::from(base_face(zero, inner)) == outer.name,
        l => inner.level >= l && inner.name >> (2 * (inner.level - l)) == outer.name,
    };
    let now = Model::new(scene.clone(), Drawing::default()).unwrap();
    now.table.faces.iter().all(|f| {
        let points = face_control(&now.table, f);
        sound(f, &points)
            || start
                .table
                .faces
                .iter()
                .any(|old| (within(f, old) || within(old, f)) && !sound(old, &face_control(&start.table, old)))
    })
}

#[test]
fn the_watch_decides_as_a_test_of_all_patches() {
    let verdicts = Cell::new([0; 2]);
    let looks = Cell::new([0; 2]);
    for_random_scenes(14, |scene, _| {
        let model = Model::new(scene.clone(), Drawing::default()).unwrap();
        let size = size_of(scene);
        for stage in [Stage::Input, Stage::Level(1)] {
            let ids: Vec<Id> = handles(&model, stage).into_iter().filter(|id| id.kind.is_geometry()).collect();
            for (i, &id) in ids.iter().enumerate().step_by(1 + ids.len() / 2) {
                let Ok(drag) = Drag::begin(scene, &model.mesh, id) else { continue };
                let mut watch = Watch::new(&model);
                // Out into a fold, back in smaller steps, in changing directions, and colours on the way.
                let mut next = scene.clone();
                for (step, reach) in [0.05, 0.4, 0.41, 0.2, 0.1, 0.02, 0.6, 0.01].into_iter().enumerate() {
                    let way = DVec2::from_angle(i as f64 + 0.3 * (step / 3) as f64);
                    drag.shift(&mut next, &model.mesh, reach * size * way);
                    if let Some(c) = next.corner_colours.first_mut() {
                        c.x = 0.1 * step as f64;
                    }
                    let (allowed, looked) = watch.allows(&next).unwrap();
                    assert_eq!(allowed, full(&model, &next), "{id:?} step {step}");
                    let mut v = verdicts.get();
                    v[usize::from(allowed)] += 1;
                    verdicts.set(v);
                    let [some, all] = looks.get();
                    looks.set([some + looked, all + model.table.faces.len()]);
                    if allowed {
                        assert_eq!(watch.allows(&next).unwrap(), (true, 0), "nothing is looked at twice");
                    }
                }
            }
        }
    });
    println!("refused, allowed: {:?}; looked at, patches: {:?}", verdicts.get(), looks.get());
    assert!(verdicts.get().into_iter().all(|n| n > 50));
}
