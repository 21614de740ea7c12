//! Refinement patterns on the device: the CPU's positions, edges without cracks, the same picture by every draw method.

mod gpu_support;

use glam::{DVec3, Vec3};
use gpu_support::with_gpu;
use gradtess::camera::{Camera, Projection};
use gradtess::gpu::{PatternFrame, PatternMethod, PatternScene as Drawn, PatternShow};
use gradtess::image::{compare, Picture};
use gradtess::pattern::displace::{HeightMap, Noise, Sine};
use gradtess::pattern::evaluate::evaluate;
use gradtess::pattern::{Control, Displacement, Evaluator, RefinementPattern};
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
                let drawn = Drawn { controls: &controls, evaluator, displacement, pattern: &pattern };
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
