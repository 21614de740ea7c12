//! Scenes as they come out of refinement: wherever two patches or parts have four equal control points along a side, the
//! GPU puts both at the same bits there; and where they are the very same points, the colours are the same bits too.

mod gpu_support;
mod models;

use gpu_support::*;
use gradtess::patch::points::Irregular;
use gradtess::patch::tess::TessRule;
use gradtess::patch::{build, eval};
use gradtess::refine::{refine, Options};
use gradtess::scene::Scene;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Positions of a side's four control points, x and y as bits.
type Places = [[u64; 2]; 4];
/// Evaluated values along a side, as bits.
type Values = Vec<[u32; 8]>;

fn scenes() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut all: Vec<PathBuf> = std::fs::read_dir(root.join("scenes"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "json") && !path.ends_with("schema.json"))
        .collect();
    if let Some(models) = models::folder("paper", "edges of the authors' models") {
        all.push(models.join("cherry/cherry_editAtSubd3.obj"));
        all.push(models.join("bolling/bolling_Subd3.obj"));
    }
    all.sort();
    all
}

#[test]
fn sides_with_the_same_control_points_have_the_same_bits() {
    with_gpu(|gpu| {
        for path in scenes() {
            let Ok(scene) = Scene::load(&path) else {
                println!("{}: no scene of this technique", path.display());
                continue;
            };
            let mesh = gradtess::mesh::build(&scene.mesh).unwrap();
            let refinement = refine(&scene, &mesh, Options::default()).unwrap();
            let table = build::build(&refinement, Irregular::default());
            let uploaded = gpu.upload(&table).unwrap();
            for rule in [TessRule::Fixed(3.0), TessRule::Fixed(4.0), TessRule::Base(10.0), TessRule::Pixels(9.0)] {
                let points = gpu.evaluate(&uploaded, rule, [1.7, 1.7]).unwrap();
                let mut sides: HashMap<Places, ([u32; 4], Values)> = HashMap::new();
                let (mut shared, mut all) = (0, 0);
                for patch in by_patch(&points) {
                    let range = &table.ranges[patch[0].range as usize];
                    let first = range.first as usize + patch[0].patch as usize * range.stride();
                    let indices = &table.indices[first..first + range.stride()];
                    for side in 0..eval::sides(range.part) {
                        let Some(q) = eval::side_points(range.kind, range.part, side) else {
                            continue;
                        };
                        let mut ids = q.map(|i| indices[i]);
                        let place = |i: u32| [0, 1].map(|c| table.control[i as usize][c].to_bits());
                        let mut values = side_values(patch, side);
                        if place(ids[0]) > place(ids[3]) {
                            ids.reverse();
                            values.reverse();
                        }
                        all += 1;
                        let Some((others, met)) = sides.insert(ids.map(place), (ids, values.clone())) else {
                            continue;
                        };
                        shared += 1;
                        let channels = if others == ids { 8 } else { 2 };
                        for (a, b) in met.iter().zip(&values) {
                            let name = path.display();
                            assert_eq!(a[..channels], b[..channels], "{name}: {rule:?}, {range:?} side {side}");
                        }
                        assert_eq!(met.len(), values.len());
                    }
                }
                println!("{}: {rule:?}: {shared} of {all} sides met another", path.display());
                assert!(shared > 0 || table.ranges.iter().map(|r| r.count).sum::<u32>() < 4);
            }
        }
    });
}
