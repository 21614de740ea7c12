//! Shared edges have the same bits from both sides: whole against whole, transition part against finer patch, part
//! against part; in both directions; at even and odd levels.

mod gpu_support;

use gpu_support::*;
use gradtess::gpu::{EvaluatedPoint, Gpu};
use gradtess::patch::tess::TessRule;
use gradtess::patch::transition::{parts_of, Side, PARTS};
use gradtess::patch::{eval, ControlPoint, Kind, PatchTable};

const LEVELS: [f32; 7] = [1.0, 2.0, 3.0, 5.0, 7.0, 16.0, 64.0];

fn evaluate(gpu: &Gpu, table: &PatchTable, tess: TessRule) -> Vec<EvaluatedPoint> {
    gpu.evaluate(&gpu.upload(table).unwrap(), tess, [113.0, 89.0]).unwrap()
}

/// Corners that a side runs between, in halves of the face's domain.
type Ends = [[u8; 2]; 2];

fn reversed<T: Clone>(values: &[T]) -> Vec<T> {
    values.iter().rev().cloned().collect()
}

/// A random face whose edge `e` runs along `cubic`.
fn face_along(kind: Kind, random: &mut Random, e: usize, cubic: [ControlPoint; 4]) -> Vec<ControlPoint> {
    let mut face = random_face(kind, random, [0.0, 0.0, 1.0, 1.0], 0.5);
    for (index, point) in eval::FACE_EDGES[e].into_iter().zip(cubic) {
        face[index] = point;
    }
    face
}

fn backwards([a, b, c, d]: [ControlPoint; 4]) -> [ControlPoint; 4] {
    [d, c, b, a]
}

#[test]
fn whole_patches_of_any_kind_meet_in_any_turn_and_direction() {
    with_gpu(|gpu| {
        let mut random = Random::new(11);
        let mut builder = Builder::default();
        let mut pairs = Vec::new();
        for (a, b) in [(Kind::Bicubic, Kind::Bicubic), (Kind::Bicubic, Kind::Gregory), (Kind::Gregory, Kind::Gregory)] {
            for e in 0..4 {
                for f in 0..4 {
                    for against in [true, false] {
                        let face = random_face(a, &mut random, [0.0, 0.0, 1.0, 1.0], 0.5);
                        let cubic = eval::FACE_EDGES[e].map(|i| face[i]);
                        let other = if against { backwards(cubic) } else { cubic };
                        // Level numbers keep the patches in ranges of their own, in this order.
                        builder.whole(a, 2 * pairs.len() as u32, &face);
                        builder.whole(b, 2 * pairs.len() as u32 + 1, &face_along(b, &mut random, f, other));
                        pairs.push((e, f, against));
                    }
                }
            }
        }
        for rule in LEVELS.map(TessRule::Fixed).into_iter().chain([TessRule::Pixels(4.0), TessRule::Pixels(30.0)]) {
            let points = evaluate(gpu, &builder.table, rule);
            let patches = by_patch(&points);
            for (i, &(e, f, against)) in pairs.iter().enumerate() {
                let (a, b) = (side_values(patches[2 * i], e), side_values(patches[2 * i + 1], f));
                assert_eq!(a, if against { reversed(&b) } else { b }, "{rule:?}: edge {e} to {f}");
            }
        }
    });
}

#[test]
fn transition_parts_meet_finer_patches() {
    with_gpu(|gpu| {
        let mut random = Random::new(12);
        let mut builder = Builder::default();
        // (patch number of the part, side, patch number of the finer patch, its edge, against)
        let mut seams = Vec::new();
        let mut patches = 0;
        for kind in KINDS {
            for constellation in 1..=5 {
                let face = random_face(kind, &mut random, [0.0, 0.0, 1.0, 1.0], 0.5);
                builder.transition(kind, 1, &face, constellation);
                let first = patches;
                patches += parts_of(constellation).len();
                for (number, part) in parts_of(constellation).enumerate() {
                    let n = eval::sides(Some(part as u8));
                    let corners = PARTS[part].corners;
                    for side in 0..n {
                        let whole = match PARTS[part].sides[side] {
                            Side::Inner => continue,
                            Side::Full(_) => true,
                            Side::Half(_) => false,
                        };
                        let cubic = match PARTS[part].sides[side] {
                            Side::Full(e) => eval::FACE_EDGES[e as usize].map(|i| face[i]),
                            _ => half_edge(&face, corners[side], corners[(side + 1) % n]),
                        };
                        for f in 0..4 {
                            for against in [true, false] {
                                let finer = if f % 2 == 0 { Kind::Bicubic } else { Kind::Gregory };
                                let along = if against { backwards(cubic) } else { cubic };
                                // A neighbour across a whole edge has the same level, across a half edge the finer one.
                                let level = if whole { 1 } else { 2 };
                                builder.whole(finer, level, &face_along(finer, &mut random, f, along));
                                seams.push((first + number, side, patches, f, against));
                                patches += 1;
                            }
                        }
                    }
                }
            }
        }
        let rules = LEVELS.map(TessRule::Fixed).into_iter().chain([
            TessRule::Base(12.0),
            TessRule::Base(20.0),
            TessRule::Pixels(4.0),
            TessRule::Pixels(30.0),
        ]);
        for rule in rules {
            let points = evaluate(gpu, &builder.table, rule);
            let patches = by_patch(&points);
            for &(part, side, finer, f, against) in &seams {
                let (a, b) = (side_values(patches[part], side), side_values(patches[finer], f));
                let number = patches[part][0].part;
                assert_eq!(a, if against { reversed(&b) } else { b }, "{rule:?}: part {number:?} side {side} to {f}");
            }
        }
        println!("{} seams at 11 rules", seams.len());
    });
}

#[test]
fn parts_of_a_face_meet_each_other() {
    with_gpu(|gpu| {
        let mut random = Random::new(13);
        for kind in KINDS {
            for constellation in 1..=5 {
                let mut builder = Builder::default();
                let face = random_face(kind, &mut random, [0.0, 0.0, 1.0, 1.0], 0.5);
                builder.transition(kind, 0, &face, constellation);
                let rules =
                    LEVELS.map(TessRule::Fixed).into_iter().chain([TessRule::Pixels(4.0), TessRule::Base(13.0)]);
                for rule in rules {
                    let points = evaluate(gpu, &builder.table, rule);
                    let mut open: Vec<(Ends, Vec<[u32; 8]>)> = Vec::new();
                    for patch in by_patch(&points) {
                        let part = &PARTS[patch[0].part.unwrap() as usize];
                        let n = eval::sides(patch[0].part);
                        for side in (0..n).filter(|&side| part.sides[side] == Side::Inner) {
                            let ends = [part.corners[side], part.corners[(side + 1) % n]];
                            let values = side_values(patch, side);
                            match open.iter().position(|(other, _)| *other == [ends[1], ends[0]]) {
                                Some(at) => {
                                    assert_eq!(values, reversed(&open.swap_remove(at).1), "{rule:?} {ends:?}");
                                }
                                None => open.push((ends, values)),
                            }
                        }
                    }
                    assert!(open.is_empty(), "constellation {constellation}: a side without its other");
                }
            }
        }
    });
}
