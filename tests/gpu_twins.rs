//! The CPU evaluator against what the GPU's shaders really computed, vertex by vertex.

mod gpu_support;

use gpu_support::*;
use gradtess::gpu::EvaluatedPoint;
use gradtess::patch::tess::{quad_vertices, triangle_vertices, TessRule};
use gradtess::patch::transition::PARTS;
use gradtess::patch::{eval, ControlPoint, PatchTable};

/// Relative to the greatest coordinate: f32 has 6e-8, a vertex takes some thirty operations.
const TOLERANCE: f64 = 1e-5;

fn patch_points(table: &PatchTable, range: u32, patch: u32) -> Vec<ControlPoint> {
    let range = &table.ranges[range as usize];
    let first = range.first as usize + patch as usize * range.stride();
    table.indices[first..first + range.stride()].iter().map(|&i| table.control[i as usize]).collect()
}

/// The greatest error of any channel of any vertex, relative to the greatest number in the table.
fn greatest_error(table: &PatchTable, points: &[EvaluatedPoint]) -> f64 {
    let size = table.control.iter().flatten().fold(1.0f64, |most, x| most.max(x.abs()));
    let mut greatest = 0.0f64;
    for patch in by_patch(points) {
        let control = patch_points(table, patch[0].range, patch[0].patch);
        let kind = table.ranges[patch[0].range as usize].kind;
        for p in patch {
            let expected = eval::vertex(kind, p.part, &control, p.outer.map(f64::from), p.coord.map(f64::from));
            for (got, expected) in p.value.iter().zip(expected) {
                greatest = greatest.max((f64::from(*got) - expected).abs() / size);
            }
        }
    }
    greatest
}

fn everything(seed: u64) -> PatchTable {
    let mut random = Random::new(seed);
    let mut builder = Builder::default();
    for kind in KINDS {
        for place in 0..3 {
            let rectangle = [f64::from(place), 0.0, 1.0, 1.0];
            builder.whole(kind, 0, &random_face(kind, &mut random, rectangle, 0.4));
        }
        for constellation in 1..=5 {
            let rectangle = [f64::from(constellation), 1.0, 1.0, 1.0];
            let face = random_face(kind, &mut random, rectangle, 0.4);
            builder.transition(kind, 1, &face, constellation);
        }
    }
    builder.table
}

#[test]
fn every_kind_and_part_agrees_with_the_cpu() {
    with_gpu(|gpu| {
        let table = everything(2);
        let uploaded = gpu.upload(&table).unwrap();
        for level in [1.0, 2.0, 3.0, 5.0, 7.0, 16.0, 64.0] {
            let points = gpu.evaluate(&uploaded, TessRule::Fixed(level), [1.0; 2]).unwrap();
            let expected: u64 = table
                .ranges
                .iter()
                .map(|range| {
                    let triangle = range.part.is_some_and(|number| PARTS[number as usize].triangle);
                    let vertices = if triangle { triangle_vertices } else { quad_vertices };
                    u64::from(range.count) * vertices(level as u64)
                })
                .sum();
            assert_eq!(points.len() as u64, expected, "level {level}");
            let error = greatest_error(&table, &points);
            println!("level {level}: {} vertices, greatest relative error {error:.2e}", points.len());
            assert!(error < TOLERANCE, "level {level}: {error}");
        }
    });
}

#[test]
fn levels_by_pixels_agree_with_the_cpu() {
    with_gpu(|gpu| {
        let table = everything(3);
        let uploaded = gpu.upload(&table).unwrap();
        let scale = [97.0, 61.0];
        for pixels in [3.0, 11.0, 40.0, 500.0] {
            let points = gpu.evaluate(&uploaded, TessRule::Pixels(pixels), scale).unwrap();
            let error = greatest_error(&table, &points);
            assert!(error < TOLERANCE, "{pixels} pixels: {error}");
            for patch in by_patch(&points) {
                let control = patch_points(&table, patch[0].range, patch[0].patch);
                let kind = table.ranges[patch[0].range as usize].kind;
                for side in 0..eval::sides(patch[0].part) {
                    let at = |p: f64| eval::pixel_level(kind, patch[0].part, &control, side, scale, p);
                    let pixels = f64::from(pixels);
                    // Rounding may tip a length that is nearly whole.
                    let (least, most) = (at(pixels * (1.0 + 1e-5)), at(pixels * (1.0 - 1e-5)));
                    let level = f64::from(patch[0].outer[side]);
                    assert!(least <= level && level <= most, "{level} not in {least}..={most}");
                }
            }
        }
    });
}

#[test]
fn base_levels_halve_from_level_to_level() {
    with_gpu(|gpu| {
        let table = everything(4);
        let uploaded = gpu.upload(&table).unwrap();
        let points = gpu.evaluate(&uploaded, TessRule::Base(12.0), [1.0; 2]).unwrap();
        assert!(greatest_error(&table, &points) < TOLERANCE);
        for p in &points {
            match p.part {
                None => assert_eq!(p.outer, [12.0; 4]),
                Some(number) => {
                    for side in 0..eval::sides(p.part) {
                        let half =
                            matches!(PARTS[number as usize].sides[side], gradtess::patch::transition::Side::Half(_));
                        assert_eq!(p.outer[side], if half { 3.0 } else { 6.0 });
                    }
                }
            }
        }
    });
}

#[test]
fn thousands_of_patches_are_told_apart() {
    with_gpu(|gpu| {
        let mut random = Random::new(5);
        let mut table = PatchTable::default();
        for kind in KINDS {
            let (first, count) = (table.indices.len() as u32, 1500);
            for patch in 0..count {
                let rectangle = [f64::from(patch % 50), f64::from(patch / 50), 1.0, 1.0];
                for point in random_face(kind, &mut random, rectangle, 0.3) {
                    table.indices.push(table.control.len() as u32);
                    table.control.push(point);
                }
            }
            table.ranges.push(gradtess::patch::DrawRange { kind, part: None, level: 0, first, count });
        }
        let uploaded = gpu.upload(&table).unwrap();
        let start = std::time::Instant::now();
        let points = gpu.evaluate(&uploaded, TessRule::Fixed(4.0), [1.0; 2]).unwrap();
        println!("3000 patches, {} vertices in {:?}", points.len(), start.elapsed());
        assert_eq!(points.len(), 3000 * 25);
        assert_eq!(by_patch(&points).len(), 3000);
        assert!(greatest_error(&table, &points) < TOLERANCE);
    });
}
