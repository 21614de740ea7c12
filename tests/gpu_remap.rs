//! Transition faces in one piece: as the CPU twin says, the same bits as the finer neighbours, and no crack anywhere.

mod gpu_support;

use gpu_support::*;
use gradtess::check::seams::{seams, Seams};
use gradtess::gpu::{Format, Frame, Gpu, Pixels};
use gradtess::patch::build::build;
use gradtess::patch::points::Irregular;
use gradtess::patch::remap::{half, mask, pack, remapped, vertex, Split, POINTS};
use gradtess::patch::tess::TessRule;
use gradtess::patch::{eval, ControlPoint, DrawRange, Kind, PatchTable};
use gradtess::refine::{refine, Options};
use gradtess::scene::Scene;
use gradtess::timing::triangles;
use std::path::Path;

const SCALE: [f64; 2] = [113.0, 89.0];
const RULES: [TessRule; 8] = [
    TessRule::Fixed(1.0),
    TessRule::Fixed(2.0),
    TessRule::Fixed(7.0),
    TessRule::Fixed(32.0),
    TessRule::Base(12.0),
    TessRule::Base(20.0),
    TessRule::Pixels(4.0),
    TessRule::Pixels(30.0),
];

/// Patches of both kinds with every set of split edges; halves of an edge are of different lengths.
fn synthetic() -> PatchTable {
    let mut random = Random::new(31);
    let mut table = PatchTable::default();
    for (kind, remapped) in [(Kind::Bicubic, Kind::RemappedBicubic), (Kind::Gregory, Kind::RemappedGregory)] {
        let first = table.indices.len() as u32;
        for number in 0..32u8 {
            let bits = number / 2;
            let face = random_face(kind, &mut random, [0.0, 0.0, 1.0, 1.0], 0.4);
            let splits: [Option<Split>; 4] = std::array::from_fn(|e| {
                let spread = 0.1 + 0.2 * e as f64;
                (bits >> e & 1 == 1).then(|| std::array::from_fn(|i| random.point(0.3 * i as f64, 0.5, spread)))
            });
            let at = table.control.len() as u32;
            let mut packed = pack(&face, &splits);
            // Every other one follows its own curve.
            packed[12][2] += f64::from(number % 2) * 16.0;
            table.control.extend(packed.map(|p| p.map(|x| f64::from(x as f32))));
            table.indices.extend(at..at + POINTS as u32);
        }
        table.ranges.push(DrawRange { kind: remapped, part: None, level: 1, first, count: 32 });
    }
    table
}

/// Segments of the first half of each side, as the control shader finds them.
fn first_halves(points: &[ControlPoint], rule: TessRule) -> [f64; 4] {
    std::array::from_fn(|e| {
        let levels = rule.levels_to(1, 32.0);
        if mask(points) >> e & 1 == 0 || levels.pixels == 0.0 {
            return f64::from(levels.half);
        }
        let mut face = vec![[0.0; 8]; 16];
        for (slot, p) in eval::FACE_EDGES[0].into_iter().zip(half(points, e, 0)) {
            face[slot] = p;
        }
        eval::pixel_level(Kind::Bicubic, None, &face, 0, SCALE, f64::from(levels.pixels)).min(32.0)
    })
}

#[test]
fn vertices_are_those_of_the_cpu_twin() {
    with_gpu(|gpu| {
        let table = synthetic();
        let device = gpu.upload(&table).unwrap();
        let mut split = 0;
        for rule in RULES {
            let points = gpu.evaluate(&device, rule, SCALE).unwrap();
            for patch in by_patch(&points) {
                let range = &table.ranges[patch[0].range as usize];
                let first = range.first as usize + POINTS * patch[0].patch as usize;
                let control: Vec<ControlPoint> =
                    table.indices[first..first + POINTS].iter().map(|&i| table.control[i as usize]).collect();
                let halves = first_halves(&control, rule);
                for p in patch {
                    let outer = p.outer.map(f64::from);
                    let expected = vertex(range.kind, &control, outer, halves, p.coord.map(f64::from));
                    for (c, (a, b)) in p.value.iter().zip(expected).enumerate() {
                        assert!((f64::from(*a) - b).abs() < 2e-5, "{rule:?} {:?} channel {c}: {a}, {b}", p.coord);
                    }
                }
                split += (0..4).filter(|&e| mask(&control) >> e & 1 == 1).count();
            }
        }
        assert_eq!(split, RULES.len() * 2 * 64);
    });
}

/// Tables of scenes with every constellation.
fn scenes() -> Vec<(String, PatchTable)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    ["unit/geometry_level_2.json", "unit/colour_level_2.json", "unit/valence_5.json", "pentagon.json", "unit/hole.json"]
        .into_iter()
        .map(|name| {
            let scene = Scene::load(folder.join(name)).unwrap();
            let mesh = gradtess::mesh::build(&scene.mesh).unwrap();
            let refinement = refine(&scene, &mesh, Options::default()).unwrap();
            (name.to_owned(), build(&refinement, Irregular::Gregory))
        })
        .collect()
}

fn seams_of(gpu: &Gpu, table: &PatchTable, rule: TessRule) -> Seams {
    seams(&gpu.evaluate(&gpu.upload(table).unwrap(), rule, SCALE).unwrap())
}

#[test]
fn split_edges_have_the_bits_of_the_finer_neighbours() {
    with_gpu(|gpu| {
        let mut faces = 0;
        for (name, table) in scenes() {
            let whole = remapped(table.clone());
            faces += table.faces.iter().filter(|f| f.transition != 0).count();
            assert!(whole.ranges.iter().all(|range| range.part.is_none()));
            for rule in RULES {
                // With parts, only the boundary is open; so it must be without.
                let (parts, pieces) = (seams_of(gpu, &table, rule), seams_of(gpu, &whole, rule));
                assert_eq!(parts.open, pieces.open, "{name}, {rule:?}");
                assert!(pieces.open < pieces.segments / 2);
            }
        }
        assert!(faces > 30, "{faces}");
    });
}

#[test]
fn levels_beyond_half_of_the_devices_are_refused() {
    with_gpu(|gpu| {
        let table = synthetic();
        let device = gpu.upload(&table).unwrap();
        let frame = Frame { tess: TessRule::Fixed(33.0), ..frame(16) };
        assert!(gpu.render(&device, &frame).unwrap_err().to_string().contains("above 32"));
        assert!(gpu.evaluate(&device, frame.tess, SCALE).is_err());
    });
}

#[test]
fn the_picture_and_the_triangles_are_as_they_should() {
    with_gpu(|gpu| {
        for (name, table) in scenes() {
            let whole = remapped(table.clone());
            let rule = TessRule::Fixed(8.0);
            let draw = |table: &PatchTable| {
                let bounds = table.faces.iter().flat_map(|f| gradtess::patch::build::face_control(table, f));
                let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
                for p in bounds {
                    for a in 0..2 {
                        (low[a], high[a]) = (low[a].min(p[a]), high[a].max(p[a]));
                    }
                }
                let view = [low[0], low[1], high[0], high[1]];
                let frame = Frame { view, tess: rule, format: Format::Rgba32f, statistics: true, ..frame(96) };
                let drawn = gpu.render(&gpu.upload(table).unwrap(), &frame).unwrap();
                let Pixels::Rgba32f(pixels) = drawn.pixels else { unreachable!() };
                (pixels, drawn.statistics.unwrap().clip_invocations)
            };
            let ((parts, _), (pieces, triangles)) = (draw(&table), draw(&whole));
            assert_eq!(triangles, triangles::count(&whole, rule).unwrap(), "{name}");
            let worst = parts.iter().zip(&pieces).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(worst < 0.02, "{name}: {worst}");
        }
    });
}
