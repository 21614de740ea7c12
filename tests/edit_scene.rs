//! The editor's operations on scenes, without a window: limits, influence, regions, colours, folds.

mod random_scene;

use glam::{DVec2, DVec4};
use gradtess::check::exact::ExactFace;
use gradtess::edit::drag::{size_of, Drag};
use gradtess::edit::folds::{drag_within, shift_within, Cost, Watch};
use gradtess::edit::handle::{Id, Kind, Stage};
use gradtess::edit::influence::influence;
use gradtess::edit::model::{Drawing, Model};
use gradtess::edit::overlay::{overlay, Look};
use gradtess::edit::paint;
use gradtess::edit::place::{exact_limit, finest};
use gradtess::edit::together::{Together, MOST_SOLVED};
use gradtess::mesh;
use gradtess::patch::build::face_control;
use gradtess::refine::region::region;
use gradtess::refine::{refine, Mode, Options, Rules};
use gradtess::scene::{Frame, Scene};
use gradtess::subdiv::index_map::IndexMap;
use random_scene::for_random_scenes;

fn scene(name: &str) -> Scene {
    Scene::load(format!("{}/scenes/{name}.json", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn model(name: &str) -> Model {
    Model::new(scene(name), Drawing::default()).unwrap()
}

/// The limit at the vertex of a slot by the checker's road: a corner of a face of the adaptive levels.
fn independent_limit(model: &Model, id: Id) -> DVec2 {
    let r = &model.refinement;
    let map = IndexMap::new(&model.mesh);
    // Global refinement to the id's level or deeper, where every vertex is the corner of a quad.
    let deepest = model.scene.geometry.iter().map(|e| e.level).max().unwrap_or(0);
    let level = id.level.max(deepest).max(1);
    let all = refine(&model.scene, &model.mesh, Options { rules: r.rules, mode: Mode::Global(level) }).unwrap();
    let h = id.slot << (2 * (level - id.level));
    assert!(h < map.half_edges(level));
    let corner = h & 3;
    let (u, v) = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)][corner as usize];
    ExactFace::new(&all, level as usize, (h >> 2) as u32).at(u, v).p
}

fn whole(model: &Model, stage: Stage) -> Look {
    let _ = model;
    Look { stage, view: [-1e4, -1e4, 1e4, 1e4], pixel: 0.01, control: false }
}

#[test]
fn every_kind_of_handle_goes_where_it_is_dragged_whatever_finer_edits_say() {
    let mut dragged = std::collections::BTreeMap::new();
    for name in [
        "unit/valence_3",
        "unit/valence_5",
        "unit/mixed_polygons",
        "unit/hole",
        "unit/corners_smooth",
        "unit/handles",
        "unit/face_point",
        "unit/geometry_level_2",
        "unit/geometry_boundary",
        "triangle",
    ] {
        let model = model(name);
        let size = size_of(&model.scene);
        for stage in [Stage::Input, Stage::Level(0), Stage::Level(1), Stage::Level(2)] {
            let seen = overlay(&model.scene, &model.mesh, &model.refinement, &whole(&model, stage)).unwrap();
            assert!(!seen.crowded && !seen.handles.is_empty());
            let movable: Vec<_> = seen.handles.iter().filter(|h| h.id.kind.is_geometry()).collect();
            // All of the coarse stages' handles take long: every seventh of the finer ones.
            let every = 1 + movable.len() / 7;
            for (i, handle) in movable.into_iter().step_by(every).enumerate() {
                let drag = Drag::begin(&model.scene, &model.mesh, handle.id).unwrap();
                assert!(drag.start().distance(handle.at) < 1e-12 * size, "{name} {:?}", handle.id);
                assert!(drag.start().distance(independent_limit(&model, handle.id)) < 1e-12 * size);
                let target = handle.at + DVec2::from_angle(i as f64) * 0.07 * size;
                let mut moved = model.scene.clone();
                drag.to(&mut moved, &model.mesh, target).unwrap();
                let after = Model::new(moved, Drawing::default()).unwrap();
                let off = independent_limit(&after, handle.id).distance(target);
                assert!(off < 1e-10 * size, "{name} {:?}: {off:e}", handle.id);
                *dragged.entry(handle.id.kind).or_insert(0) += 1;
            }
        }
    }
    assert_eq!(dragged.len(), 4, "{dragged:?}");
    assert!(dragged.values().all(|&n| n > 10), "{dragged:?}");
}

#[test]
fn handles_held_together_have_their_limits_moved_by_one_step() {
    for (name, stage, take) in [
        ("unit/valence_5", Stage::Level(1), 7),
        ("unit/mixed_polygons", Stage::Level(0), 12),
        ("unit/geometry_level_2", Stage::Level(1), 5),
        ("unit/handles", Stage::Input, 9),
        ("quad", Stage::Input, MOST_SOLVED),
    ] {
        let model = model(name);
        let size = size_of(&model.scene);
        let seen = overlay(&model.scene, &model.mesh, &model.refinement, &whole(&model, stage)).unwrap();
        // Gradient handles first: what a vertex carries along must not be moved twice.
        let mut ids: Vec<Id> = seen.handles.iter().map(|h| h.id).filter(|id| id.kind.is_geometry()).collect();
        ids.sort_by_key(|id| id.kind == Kind::Input);
        if stage == Stage::Input {
            ids.rotate_right(take / 2);
        }
        ids.truncate(take);
        let drags = ids.iter().map(|&id| Drag::begin(&model.scene, &model.mesh, id).unwrap()).collect();
        let together = Together::begin(&model.scene, &model.mesh, drags).unwrap();
        let step = DVec2::new(0.021, -0.013) * size;
        let mut moved = model.scene.clone();
        // In two strides, as a pointer goes.
        together.shift(&mut moved, &model.mesh, step * 0.4);
        together.shift(&mut moved, &model.mesh, step);
        let after = Model::new(moved, Drawing::default()).unwrap();
        for drag in together.drags() {
            let off = independent_limit(&after, drag.id()).distance(drag.start() + step);
            assert!(off < 1e-9 * size, "{name} {:?}: {off:e}", drag.id());
        }
    }
}

#[test]
fn handles_held_together_stop_at_the_last_place_where_nothing_folds() {
    let model = model("pentagon");
    let size = size_of(&model.scene);
    let seen = overlay(&model.scene, &model.mesh, &model.refinement, &whole(&model, Stage::Level(1))).unwrap();
    let ids = seen.handles.iter().map(|h| h.id).filter(|id| id.kind == Kind::Vertex).take(3);
    let drags = ids.map(|id| Drag::begin(&model.scene, &model.mesh, id).unwrap()).collect();
    let together = Together::begin(&model.scene, &model.mesh, drags).unwrap();
    let start = together.drags()[0].start();
    let target = start + DVec2::new(-0.9, -0.8) * size;
    let mut free = model.scene.clone();
    together.shift(&mut free, &model.mesh, target - start);
    assert!(least_jacobian(&Model::new(free, Drawing::default()).unwrap(), 64) < 0.0, "it folds when nothing stops it");
    let mut held = model.scene.clone();
    let (mut watch, mut cost) = (Watch::new(&model), Cost::default());
    let ways = [start, target];
    let end = shift_within(&mut watch, &together, &model, &mut held, ways, 1e-5 * size, &mut cost).unwrap();
    assert!(end != start && end != target, "{end}");
    assert!(least_jacobian(&Model::new(held, Drawing::default()).unwrap(), 64) > 0.0);
    // A little further nothing is allowed.
    let further = end + (target - start).normalize() * 1e-3 * size;
    let mut beyond = model.scene.clone();
    together.shift(&mut beyond, &model.mesh, further - start);
    assert!(!watch.allows(&beyond).unwrap().0);
}

#[test]
fn a_drag_is_one_edit_and_back_to_the_start_is_none() {
    let mut model = model("unit/mixed_polygons");
    let before = model.scene.clone();
    let seen = overlay(&model.scene, &model.mesh, &model.refinement, &whole(&model, Stage::Level(1))).unwrap();
    let id = seen.handles.iter().find(|h| h.id.kind == Kind::Vertex).unwrap().id;
    let drag = Drag::begin(&model.scene, &model.mesh, id).unwrap();
    for i in 1..10 {
        drag.to(&mut model.scene, &model.mesh, drag.start() + DVec2::new(0.01, 0.02) * f64::from(i)).unwrap();
        assert_eq!(model.scene.geometry.len(), before.geometry.len() + 1);
    }
    assert!(gradtess::edit::drag::reset(&mut model.scene, &model.mesh, id));
    assert_eq!(model.scene, before);
}

#[test]
fn a_step_beyond_the_boundary_is_written_as_angle_and_length() {
    let model = model("quad");
    let seen = overlay(&model.scene, &model.mesh, &model.refinement, &whole(&model, Stage::Level(1))).unwrap();
    let size = size_of(&model.scene);
    let mut frames = std::collections::HashSet::new();
    for handle in seen.handles.iter().filter(|h| h.id.kind == Kind::Vertex) {
        let drag = Drag::begin(&model.scene, &model.mesh, handle.id).unwrap();
        for angle in 0..8 {
            let mut moved = model.scene.clone();
            let target = handle.at + DVec2::from_angle(0.3 + 0.8 * f64::from(angle)) * 0.05 * size;
            drag.to(&mut moved, &model.mesh, target).unwrap();
            frames.insert(moved.geometry[0].frame == Frame::Boundary);
            // The paper's search: inside, the step lies between the two edges of its sector.
            let e = moved.geometry[0];
            assert!(e.a >= -1e-12 && e.b >= -1e-12, "{e:?}");
        }
    }
    assert_eq!(frames.len(), 2);
}

#[test]
fn a_region_has_the_very_bits_of_the_whole_level() {
    for_random_scenes(24, |scene, mesh| {
        let level = 2;
        let options = Options { rules: Rules::Gradtess, mode: Mode::Global(level) };
        let Ok(all) = refine(scene, mesh, options) else { return };
        let whole = &all.levels[level as usize];
        // Around one face of M^0.
        for wanted in [0, all.levels[0].faces() as u64 / 2] {
            let part = region(scene, mesh, level, &[], |l, f| {
                let name = l.face[f as usize];
                match l.level {
                    0 => name == wanted,
                    _ => IndexMap::new(mesh).face(0, name >> (2 * (l.level - 1))) == wanted,
                }
            })
            .unwrap();
            let last = part.last();
            let mut compared = 0;
            for f in 0..last.faces() as u32 {
                let name = last.face[f as usize];
                if IndexMap::new(mesh).face(0, name >> 2) != wanted {
                    continue;
                }
                compared += 1;
                for (h, g) in last.of_face(f).zip(4 * name as u32..) {
                    assert_eq!(last.at(h), whole.at(g));
                    assert_eq!(last.colour_border(h), whole.colour_border(g));
                }
            }
            assert!(compared > 0);
        }
    });
}

/// Limit position and colour at 3 x 3 points of every face of M^level.
fn samples(model: &Model, level: u32) -> Vec<Vec<gradtess::subdiv::level::Value>> {
    let options = Options { rules: Rules::Gradtess, mode: Mode::Global(level.max(2)) };
    let all = refine(&model.scene, &model.mesh, options).unwrap();
    let last = all.levels.len() - 1;
    let map = IndexMap::new(&model.mesh);
    let mut out = vec![Vec::new(); map.faces(level) as usize];
    for f in 0..all.levels[last].faces() as u32 {
        let name = all.levels[last].face[f as usize];
        let up = last as u32 - level;
        let at = match up {
            0 => f as usize,
            _ => map.face(level, name >> (2 * (up - 1))) as usize,
        };
        let mut exact = ExactFace::new(&all, last, f);
        for i in 0..9 {
            out[at].push(exact.at(0.2 + 0.3 * f64::from(i % 3), 0.2 + 0.3 * f64::from(i / 3)));
        }
    }
    out
}

#[test]
fn influence_is_what_changes_and_nothing_else() {
    for name in ["unit/mixed_polygons", "unit/valence_5", "unit/sharp_two_meet", "unit/sharp_dart", "unit/hole"] {
        let model = model(name);
        for stage in [Stage::Input, Stage::Level(0), Stage::Level(1)] {
            let level = stage.level();
            let before = samples(&model, level);
            let seen = overlay(&model.scene, &model.mesh, &model.refinement, &whole(&model, stage)).unwrap();
            let kinds = [Kind::Vertex, Kind::Input, Kind::Gradient, Kind::FacePoint, Kind::Colour, Kind::Sector];
            for kind in kinds {
                let all: Vec<Id> = seen.handles.iter().map(|h| h.id).filter(|id| id.kind == kind).collect();
                for &id in all.iter().step_by(1 + all.len() / 2) {
                    let mut scene = model.scene.clone();
                    if kind.is_geometry() {
                        let drag = Drag::begin(&scene, &model.mesh, id).unwrap();
                        drag.to(&mut scene, &model.mesh, drag.start() + DVec2::new(0.013, 0.017)).unwrap();
                    } else {
                        paint::paint(&mut scene, &model.mesh, &[(id, DVec4::new(0.11, 0.93, 0.47, 1.0))]).unwrap();
                    }
                    let after = Model::new(scene, Drawing::default()).unwrap();
                    let said = &influence(&model.scene, &model.mesh, &[id]).unwrap()[usize::from(!kind.is_geometry())];
                    let now = samples(&after, level);
                    for (face, (a, b)) in before.iter().zip(&now).enumerate() {
                        let changed =
                            a.iter().zip(b).any(|(a, b)| (a.p - b.p).length() > 1e-12 || (a.c - b.c).length() > 1e-12);
                        let inside = said.faces.contains(&(face as u64));
                        assert!(inside || !changed, "{name} {id:?}: face {face} changes");
                        if kind == Kind::Vertex {
                            assert!(changed || !inside, "{name} {id:?}: face {face} does not change");
                        }
                    }
                    assert!(!said.outline.is_empty() || said.faces.len() == before.len());
                }
            }
        }
    }
}

#[test]
fn painted_colours_are_on_the_surface() {
    for_random_scenes(16, |scene, _| {
        let Ok(model) = Model::new(scene.clone(), Drawing::default()) else { return };
        let seen = overlay(&model.scene, &model.mesh, &model.refinement, &whole(&model, Stage::Level(1))).unwrap();
        let colour = DVec4::new(0.2, 0.9, 0.4, 1.0);
        let ids: Vec<Id> = seen.handles.iter().map(|h| h.id).filter(|id| id.kind == Kind::Colour).step_by(5).collect();
        let mut painted = model.scene.clone();
        let list: Vec<_> = ids.iter().map(|&id| (id, colour)).collect();
        paint::paint(&mut painted, &model.mesh, &list).unwrap();
        let after = Model::new(painted, Drawing::default()).unwrap();
        let seen = overlay(&after.scene, &after.mesh, &after.refinement, &whole(&after, Stage::Level(1))).unwrap();
        for id in &ids {
            let shown = seen.handles.iter().find(|h| h.id == *id).unwrap();
            assert_eq!(shown.colour, colour);
        }
    });
}

#[test]
fn sharp_tags_come_and_go() {
    let mut model = model("unit/valence_3");
    let mesh = model.mesh.clone();
    let h = (0..mesh.half_edges()).find(|&h| mesh.twin[h as usize] != mesh::NONE).unwrap();
    let before = model.scene.clone();
    paint::set_sharp(&mut model.scene, &mesh, h, true).unwrap();
    assert!(paint::is_sharp(&model.scene, &mesh, mesh.twin[h as usize]));
    assert!(refine(&model.scene, &mesh, Options::default()).unwrap().levels[0].sharp.iter().any(|&s| s));
    // Two colours at one end, told apart by the edge.
    let id = Id { kind: Kind::Sector, level: 0, slot: 8 * u64::from(h) };
    paint::paint(&mut model.scene, &mesh, &[(id, DVec4::new(1.0, 0.0, 0.0, 1.0))]).unwrap();
    paint::set_sharp(&mut model.scene, &mesh, h, false).unwrap();
    assert_eq!(model.scene.sharp, before.sharp);
    let boundary = (0..mesh.half_edges()).find(|&h| mesh.twin[h as usize] == mesh::NONE).unwrap();
    assert!(paint::set_sharp(&mut model.scene, &mesh, boundary, true).is_err());
}

/// Least signed Jacobian at n x n samples of each drawn patch, times the sign of its first sample.
fn least_jacobian(model: &Model, n: usize) -> f64 {
    let mut least = f64::INFINITY;
    for face in &model.table.faces {
        let points = face_control(&model.table, face);
        for i in 0..n * n {
            let at = |k: usize| (k as f64 + 0.5) / n as f64;
            let s = gradtess::patch::eval::face_sample(face.kind, &points, at(i % n), at(i / n));
            least = least.min(s.du[0] * s.dv[1] - s.du[1] * s.dv[0]);
        }
    }
    least
}

#[test]
fn a_drag_into_a_fold_stops_short_and_without_the_watch_it_folds() {
    for (name, stage) in [
        ("unit/valence_5", Stage::Level(1)),
        ("unit/valence_3", Stage::Level(0)),
        ("pentagon", Stage::Level(1)),
        ("quad", Stage::Input),
    ] {
        let model = model(name);
        assert!(least_jacobian(&model, 16) > 0.0, "{name} is counter-clockwise and sound");
        let size = size_of(&model.scene);
        let seen = overlay(&model.scene, &model.mesh, &model.refinement, &whole(&model, stage)).unwrap();
        let mut watch = Watch::new(&model);
        assert_eq!(watch.folded(), 0);
        let movable: Vec<_> = seen.handles.iter().filter(|h| h.id.kind.is_geometry()).collect();
        let (mut stopped, mut cost) = (0, Cost::default());
        for (i, handle) in movable.iter().enumerate().step_by(1 + movable.len() / 4) {
            let drag = Drag::begin(&model.scene, &model.mesh, handle.id).unwrap();
            let target = handle.at + DVec2::from_angle(1.0 + i as f64) * 0.8 * size;
            let mut free = model.scene.clone();
            drag.to(&mut free, &model.mesh, target).unwrap();
            let folds = least_jacobian(&Model::new(free, Drawing::default()).unwrap(), 64) < 0.0;
            let mut held = model.scene.clone();
            let tolerance = 1e-5 * size;
            let ways = [drag.start(), target];
            let end = drag_within(&mut watch, &drag, &model, &mut held, ways, tolerance, &mut cost).unwrap();
            let held = Model::new(held, Drawing::default()).unwrap();
            assert!(least_jacobian(&held, 64) > 0.0, "{name} {:?}", handle.id);
            assert!(
                exact_limit(&held.scene, &held.mesh, handle.id.level, handle.id.slot).unwrap().distance(end) < 1e-9
            );
            if folds {
                assert!(end != target);
                assert!(end != drag.start(), "{name} {:?}: it can move a little", handle.id);
                stopped += 1;
            }
        }
        assert!(stopped > 0, "{name}");
        assert!(cost.tries > 0 && cost.patches > 0);
    }
}

#[test]
fn finer_levels_are_found_where_they_are() {
    let model = model("unit/geometry_level_2");
    let map = IndexMap::new(&model.mesh);
    let found = (0..map.half_edges(1)).filter(|&d| finest(&model.refinement, 1, d).is_some()).count();
    assert!(found > 0 && found < map.half_edges(1) as usize);
}
