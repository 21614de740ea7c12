//! Refinement patterns on the device: the CPU's positions, edges without cracks, the same picture by every draw method.

mod gpu_support;

use glam::{DVec3, Vec3};
use gpu_support::with_gpu;
use gradtess::camera::{Camera, Projection};
use gradtess::check::flight::{background_inside, flight, greatest_change, slow_zoom};
use gradtess::gpu::{PatternFrame, PatternMethod, PatternScene as Drawn, PatternShow};
use gradtess::image::{compare, Picture};
use gradtess::pattern::detail::{levels, place, Scope, View};
use gradtess::pattern::displace::{HeightMap, Noise, Sine};
use gradtess::pattern::evaluate::evaluate;
use gradtess::pattern::{CoarseMesh, Control, Detail, Displacement, Evaluator, NormalField, RefinementPattern};
use gradtess::scene::pattern::PatternScene;
use std::path::Path;

const BOUNDS: [DVec3; 2] = [DVec3::new(-0.7, -1.1, -0.7), DVec3::new(0.7, 1.1, 0.7)];

fn character() -> PatternScene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/pattern/character.json");
    let mut scene = PatternScene::parse(&std::fs::read(path).unwrap(), "character.json").unwrap();
    let square = |p: &DVec3| glam::DVec2::new(0.51 + 0.37 * p.x, 0.513 + 0.41 * p.y);
    scene.mesh.uv = scene.mesh.positions.iter().map(square).collect();
    scene
}

fn frame(method: PatternMethod) -> PatternFrame {
    PatternFrame {
        width: 160,
        height: 120,
        camera: Camera::orbit(BOUNDS, 30.0, 20.0, Projection::Perspective { fov: 30.0 }, 4.0 / 3.0),
        bounds: BOUNDS,
        show: PatternShow::Shaded,
        method,
        detail: None,
        background: None,
        samples: 1,
    }
}

fn displacements() -> [Displacement; 4] {
    let heights = (0..35).map(|i| (i * 11 % 17) as f32 / 16.0).collect();
    [
        Displacement::None,
        Displacement::Sine(Sine { amplitude: 0.05, frequency: 20.0 }),
        Displacement::Noise(Noise { amplitude: 0.1, frequency: 3.0, octaves: 4, time: 0.6, ..Noise::default() }),
        Displacement::Height(HeightMap { size: [7, 5], heights, amplitude: 0.2, middle: 0.5 }),
    ]
}

#[test]
fn the_device_evaluates_as_the_cpu_and_edges_have_the_same_bits() {
    let scene = character();
    let n = 6;
    let pattern = RefinementPattern::triangle(n).unwrap();
    let each = pattern.weights.len();
    with_gpu(|gpu| {
        for evaluator in [Evaluator::Linear, Evaluator::Pn, Evaluator::St] {
            let controls: Vec<Control> = (0..scene.mesh.triangles.len())
                .map(|t| Control::new(&scene.mesh, t, evaluator, scene.normal_field))
                .collect();
            for displacement in &displacements() {
                let drawn = Drawn { controls: &controls, evaluator, displacement, pattern: &pattern, coarse: None };
                let found = gpu.evaluate_pattern(&drawn, &frame(PatternMethod::Instanced)).unwrap();
                assert_eq!(found.len(), each * controls.len());
                let mut at_corner = std::collections::HashMap::new();
                for (t, control) in controls.iter().enumerate() {
                    for (k, w) in pattern.weights.iter().enumerate() {
                        let point = evaluate(control, evaluator, displacement, w.map(f64::from));
                        let [p, normal] = found[t * each + k];
                        let (p, normal) = (Vec3::from(p).as_dvec3(), Vec3::from(normal).as_dvec3());
                        assert!((p - point.position).length() < 1e-5, "{evaluator:?} {displacement:?}: {p} {point:?}");
                        assert!((normal - point.normal).length() < 1e-3, "{evaluator:?} {displacement:?}");
                        // A point on an edge by its ends and the part of the way.
                        if let Some(zero) = w.iter().position(|&x| x == 0.0) {
                            let v = scene.mesh.triangles[t];
                            let (mut a, mut b) =
                                ((v[(zero + 1) % 3], w[(zero + 1) % 3]), (v[(zero + 2) % 3], w[(zero + 2) % 3]));
                            if a.0 > b.0 {
                                std::mem::swap(&mut a, &mut b);
                            }
                            let key = if a.1 == 0.0 || b.1 == 0.0 {
                                let corner = if a.1 == 0.0 { b.0 } else { a.0 };
                                (corner, corner, 0)
                            } else {
                                (a.0, b.0, a.1.to_bits())
                            };
                            let bits = found[t * each + k][0].map(f32::to_bits);
                            let first = *at_corner.entry(key).or_insert(bits);
                            assert_eq!(first, bits, "{evaluator:?} {displacement:?} parts at {key:?}");
                        }
                    }
                }
            }
        }
    });
}

#[test]
fn every_method_draws_the_same_picture() {
    let scene = character();
    let pattern = RefinementPattern::triangle(8).unwrap();
    let controls: Vec<Control> = (0..scene.mesh.triangles.len())
        .map(|t| Control::new(&scene.mesh, t, scene.evaluator, scene.normal_field))
        .collect();
    with_gpu(|gpu| {
        let draw = |method| -> Picture {
            let drawn = Drawn {
                controls: &controls,
                evaluator: scene.evaluator,
                displacement: &scene.displacement,
                pattern: &pattern,
                coarse: None,
            };
            let prepared = gpu.prepare_pattern(&drawn, &frame(method)).unwrap();
            prepared.run(true).unwrap();
            prepared.pixels().unwrap().into_picture(160, 120)
        };
        let first = draw(PatternMethod::Instanced);
        assert!(first.rgba.chunks(4).filter(|p| p[3] > 0).count() > 1000);
        for (method, most) in
            [(PatternMethod::Draws, 0.0), (PatternMethod::Static, 0.002), (PatternMethod::Hardware, 0.02)]
        {
            let difference = compare(&first, &draw(method)).unwrap();
            assert!(difference.fraction_beyond(3) <= most, "{method:?}: {}", difference.fraction_beyond(3));
        }
    });
}

/// Controls of a scene by an evaluator.
fn controls(mesh: &CoarseMesh, evaluator: Evaluator, field: NormalField) -> Vec<Control> {
    (0..mesh.triangles.len()).map(|t| Control::new(mesh, t, evaluator, field)).collect()
}

#[test]
fn coefficients_made_on_the_device_are_those_of_the_cpu_and_share_edges() {
    let scene = character();
    let n = 5;
    let pattern = RefinementPattern::triangle(n).unwrap();
    let each = pattern.weights.len();
    with_gpu(|gpu| {
        for evaluator in [Evaluator::Linear, Evaluator::Pn, Evaluator::St] {
            for field in [NormalField::Vlachos, NormalField::Boubekeur, NormalField::Linear] {
                let controls = controls(&scene.mesh, evaluator, field);
                let displacement = &displacements()[if field == NormalField::Vlachos { 3 } else { 0 }];
                let drawn = Drawn {
                    controls: &controls,
                    evaluator,
                    displacement,
                    pattern: &pattern,
                    coarse: Some((&scene.mesh, field)),
                };
                let found = gpu.evaluate_pattern(&drawn, &frame(PatternMethod::Instanced)).unwrap();
                let mut seen = std::collections::HashMap::new();
                for (t, control) in controls.iter().enumerate() {
                    for (k, w) in pattern.weights.iter().enumerate() {
                        let point = evaluate(control, evaluator, displacement, w.map(f64::from));
                        let [p, normal] = found[t * each + k];
                        let (position, normal) = (Vec3::from(p).as_dvec3(), Vec3::from(normal).as_dvec3());
                        let place = format!("{evaluator:?} {field:?} triangle {t}");
                        assert!((position - point.position).length() < 1e-5, "{place}: {position} {point:?}");
                        assert!((normal - point.normal).length() < 1e-3, "{place}: {normal} {point:?}");
                        // Inner points of edges, by their ends.
                        let Some(zero) = w.iter().position(|&x| x == 0.0).filter(|_| !w.contains(&1.0)) else {
                            continue;
                        };
                        let ends =
                            [1, 2].map(|i| (scene.mesh.triangles[t][(zero + i) % 3], w[(zero + i) % 3].to_bits()));
                        let key = (ends[0].min(ends[1]), ends[0].max(ends[1]));
                        let bits = p.map(f32::to_bits);
                        assert_eq!(*seen.entry(key).or_insert(bits), bits, "{place} parts from its neighbour");
                    }
                }
            }
        }
    });
}

#[test]
fn levels_chosen_on_the_device_are_those_of_the_cpu_and_seams_between_them_have_the_same_bits() {
    let scene = character();
    let pattern = RefinementPattern::triangle(1).unwrap();
    let evaluator = Evaluator::St;
    let controls = controls(&scene.mesh, evaluator, NormalField::Vlachos);
    let displacement = &displacements()[1];
    let drawn = Drawn { controls: &controls, evaluator, displacement, pattern: &pattern, coarse: None };
    with_gpu(|gpu| {
        for method in [PatternMethod::Instanced, PatternMethod::Indirect] {
            for (far, segment, morph) in [(1.0, 3.0, true), (0.3, 8.0, true), (0.3, 8.0, false), (5.0, 2.0, true)] {
                let mut frame = frame(method);
                let detail = Detail { scope: Scope::Triangle, segment, most: 5, morph };
                frame.detail = Some(detail);
                let distance = (frame.camera.eye - frame.camera.target).length();
                frame.camera = frame.camera.at_distance(distance * far);
                let view = View::new(&frame.camera, frame.height);
                let found = gpu.evaluate_detail(&drawn, &frame).unwrap();
                assert_eq!(found.len(), controls.len());
                let mut edges = std::collections::HashMap::new();
                let mut different = std::collections::HashSet::new();
                for (t, triangle) in found.iter().enumerate() {
                    assert_eq!(triangle.triangle as usize, t);
                    let expected = levels(&controls[t], &detail, &view, None);
                    let l = triangle.levels;
                    assert_eq!(l.turned, expected.turned);
                    for e in 0..3 {
                        assert!((l.edges[e] - expected.edges[e]).abs() < 1e-3, "{l:?} {expected:?}");
                        different.insert(l.edges[e].to_bits());
                    }
                    let n = 1 << l.pattern();
                    let weights = RefinementPattern::triangle(n).unwrap().weights;
                    assert_eq!(weights.len(), triangle.points.len());
                    for (&w, point) in weights.iter().zip(&triangle.points) {
                        let at = place(w, n, &l).map(f64::from);
                        let cpu = evaluate(&controls[t], evaluator, displacement, at).position;
                        assert!((Vec3::from(point[0]).as_dvec3() - cpu).length() < 1e-5, "{l:?} {w:?}");
                    }
                    for e in 0..3 {
                        let on = weights.iter().zip(&triangle.points).filter(|(w, _)| w[(e + 2) % 3] == 0.0);
                        let bits: std::collections::BTreeSet<[u32; 3]> =
                            on.map(|(_, point)| point[0].map(f32::to_bits)).collect();
                        let v = scene.mesh.triangles[t];
                        let (a, b) = (v[e], v[(e + 1) % 3]);
                        let first = edges.entry((a.min(b), a.max(b))).or_insert_with(|| bits.clone());
                        assert_eq!(*first, bits, "{method:?}: triangle {t} parts along edge {e}");
                    }
                }
                assert!(different.len() > if morph { 20 } else { 1 }, "{} levels", different.len());
            }
        }
    });
}

/// A ball of 80 triangles in one colour.
fn ball() -> CoarseMesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/pattern/sphere.json");
    PatternScene::parse(&std::fs::read(path).unwrap(), "sphere.json").unwrap().mesh
}

const UNIT: [DVec3; 2] = [DVec3::splat(-1.05), DVec3::splat(1.05)];

#[test]
fn no_background_is_seen_along_a_flight_between_levels_of_detail() {
    let mesh = ball();
    let controls = controls(&mesh, Evaluator::Pn, NormalField::Vlachos);
    let displacement = Displacement::Sine(Sine { amplitude: 0.04, frequency: 40.0 });
    let [one, outline] = [1, 24].map(|n| RefinementPattern::triangle(n).unwrap());
    let scene = |pattern| Drawn {
        controls: &controls,
        evaluator: Evaluator::Pn,
        displacement: &displacement,
        pattern,
        coarse: None,
    };
    with_gpu(|gpu| {
        for method in [PatternMethod::Instanced, PatternMethod::Indirect] {
            let mut frame = frame(method);
            frame.bounds = UNIT;
            let mut reference = gpu
                .prepare_pattern(&scene(&outline), &PatternFrame { method: PatternMethod::Instanced, ..frame.clone() })
                .unwrap();
            frame.detail = Some(Detail { segment: 6.0, ..Detail::default() });
            let mut prepared = gpu.prepare_pattern(&scene(&one), &frame).unwrap();
            let mut covered = 0;
            for camera in flight(UNIT, 12, 4.0 / 3.0) {
                prepared.look(camera, &scene(&one)).unwrap();
                prepared.run(true).unwrap();
                let picture = prepared.pixels().unwrap().into_picture(160, 120);
                reference.look(camera, &scene(&outline)).unwrap();
                reference.run(true).unwrap();
                let whole = reference.pixels().unwrap().into_picture(160, 120);
                assert_eq!(background_inside(&picture, Some(&whole), 3), 0, "{method:?} {camera:?}");
                covered += picture.rgba.chunks(4).filter(|p| p[3] > 0).count();
            }
            assert!(covered > 12 * 4000, "{covered}");
        }
    });
}

#[test]
fn levels_melt_into_one_another_and_pop_without() {
    let mesh = ball();
    let controls = controls(&mesh, Evaluator::Pn, NormalField::Vlachos);
    let pattern = RefinementPattern::triangle(1).unwrap();
    let drawn = Drawn {
        controls: &controls,
        evaluator: Evaluator::Pn,
        displacement: &Displacement::None,
        pattern: &pattern,
        coarse: None,
    };
    with_gpu(|gpu| {
        let change = |morph| {
            let mut frame = frame(PatternMethod::Indirect);
            frame.bounds = UNIT;
            frame.show = PatternShow::Normals;
            frame.detail = Some(Detail { segment: 120.0, morph, ..Detail::default() });
            let mut prepared = gpu.prepare_pattern(&drawn, &frame).unwrap();
            let mut last: Option<Picture> = None;
            let mut most = 0;
            for camera in slow_zoom(UNIT, 240, 4.0 / 3.0) {
                prepared.look(camera, &drawn).unwrap();
                prepared.run(true).unwrap();
                let picture = prepared.pixels().unwrap().into_picture(160, 120);
                if let Some(last) = &last {
                    let (change, both) = greatest_change(last, &picture);
                    assert!(both > 160 * 100, "{both}");
                    most = most.max(change);
                }
                last = Some(picture);
            }
            most
        };
        let [melting, popping] = [true, false].map(change);
        println!("greatest change between frames: {melting} melting, {popping} popping");
        assert!(melting <= 8, "{melting}");
        assert!(popping > 2 * melting, "{popping} against {melting}");
    });
}
