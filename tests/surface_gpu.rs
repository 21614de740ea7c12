//! Surfaces in space on the device: no cracks, weights and sides as the CPU has them, nothing that validation minds.

mod gpu_support;

use glam::DVec3;
use gpu_support::with_gpu;
use gradtess::camera::{Camera, Projection};
use gradtess::check::sheet::Sheet;
use gradtess::check::solid_cracks::{look_around, triangles_of};
use gradtess::gpu::{Pixels, SolidFrame, SolidShow, Tessellation};
use gradtess::mesh;
use gradtess::patch::solid::{Primitive, Segments, SolidTable};
use gradtess::patch::tessellator;
use gradtess::scene::surface::SurfaceScene;
use gradtess::surface::adaptive::Depth;
use gradtess::surface::drawing;
use gradtess::surface::level::{Level, Scheme};
use gradtess::surface::patch_eval::point;
use gradtess::surface::patches::{patches, Form};
use gradtess::surface::refine::levels;
use gradtess::surface::shade::{shade, Settings};

/// A cube with a sharp bottom, a semi-sharp edge and a dart.
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1.1 0\nv 0 1 0\nv 0 0 1\nv 1 0.2 1\nv 1 1 1.3\nv 0 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n\
    t crease 5/1/0 0 1 5 4 0 10\nt crease 2/1/0 2 6 1.5\n";
const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.2 0.1 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n\
    t crease 4/1/0 0 1 2 0 10\n";

fn levels_of(text: &str, scheme: Scheme, depth: u32) -> Vec<Level> {
    let scene = SurfaceScene::parse(text.as_bytes(), "test").unwrap();
    levels(&scene, &mesh::build(&scene.polygons()).unwrap(), scheme, depth).unwrap()
}

fn table(levels: &[Level]) -> SolidTable {
    let shaded = shade(levels, &[], &Settings::default());
    let last = levels.last().unwrap();
    drawing::triangles(last, &shaded, &last.position, &shaded.blended)
}

fn frame(camera: Camera, show: SolidShow, samples: u32) -> SolidFrame {
    SolidFrame {
        width: 96,
        height: 96,
        camera,
        show,
        stripes: 30.0,
        background: None,
        samples,
        tessellation: Tessellation::default(),
    }
}

#[test]
fn no_cracks_whole_and_cracks_when_triangles_are_missing() {
    with_gpu(|gpu| {
        for (text, scheme) in [(CUBE, Scheme::CatmullClark), (TETRAHEDRON, Scheme::Loop)] {
            let mut table = table(&levels_of(text, scheme, 4));
            let triangles = Sheet::weld(&triangles_of(&table));
            let found = look_around(gpu, &table, &triangles, Tessellation::default(), [6, 96], 3).unwrap();
            assert!(found.cracks == 0 && found.covered > 5000, "{found:?}");
            // Every ninth triangle turns into nothing.
            for t in table.indices.chunks_exact_mut(3).step_by(9) {
                t[1] = t[0];
            }
            let found = look_around(gpu, &table, &triangles, Tessellation::default(), [6, 96], 3).unwrap();
            assert!(found.cracks > 20, "{found:?}");
        }
    });
}

#[test]
fn an_extraordinary_vertex_is_red_and_a_far_regular_one_blue() {
    with_gpu(|gpu| {
        let text: String = CUBE.lines().filter(|l| !l.starts_with('t')).map(|l| format!("{l}\n")).collect();
        let levels = levels_of(&text, Scheme::CatmullClark, 4);
        let settings = Settings { weights_from: 3, ..Settings::default() };
        let last = levels.last().unwrap();
        let shaded = shade(&levels, &[], &settings);
        let table = drawing::triangles(last, &shaded, &last.position, &shaded.blended);
        // Level 0 vertex 7 is a corner; the first face point of level 1 is regular and keeps its number.
        for (v, red, blue) in [(7usize, 255, 0), (8, 0, 255)] {
            let wedge = v as u32;
            assert_eq!(shaded.wedges.first[v], last.spoke[v]);
            let (p, n) = (last.position[v], shaded.geometric[wedge as usize]);
            let camera = Camera {
                eye: p + n * 0.5,
                target: p,
                up: n.any_orthonormal_vector(),
                projection: Projection::Orthographic { height: 0.01 },
            };
            for samples in [1, 4] {
                let prepared = gpu.prepare_solid(&table, &frame(camera, SolidShow::Weights, samples)).unwrap();
                prepared.run(true).unwrap();
                let picture = prepared.pixels().unwrap().into_picture(96, 96);
                let [r, g, b, a] = picture.pixel(48, 48);
                assert!(r.abs_diff(red) < 6 && g == 0 && b.abs_diff(blue) < 6 && a == 255, "{v}: {r} {g} {b} {a}");
            }
        }
    });
}

#[test]
fn normals_are_seen_from_either_side_and_lines_lie_on_faces() {
    with_gpu(|gpu| {
        let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nfs 0 0 0 0\n";
        let levels = levels_of(square, Scheme::CatmullClark, 2);
        let table = table(&levels);
        for (side, blue) in [(1.0, 255), (-1.0, 0)] {
            let camera = Camera {
                eye: DVec3::new(0.5, 0.5, 2.0 * side),
                target: DVec3::new(0.5, 0.5, 0.0),
                up: DVec3::Y,
                projection: Projection::Perspective { fov: 20.0 },
            };
            let prepared = gpu.prepare_solid(&table, &frame(camera, SolidShow::Normals, 1)).unwrap();
            prepared.run(true).unwrap();
            let Pixels::Rgba8(pixels) = prepared.pixels().unwrap() else { panic!("8 bits") };
            let at = 4 * (48 * 96 + 48);
            assert_eq!([pixels[at], pixels[at + 1], pixels[at + 2]], [128, 128, blue]);
            // The mesh: its middle line is drawn over the faces, blue edges round it.
            let mesh = drawing::mesh(&levels[1], &levels[1].position);
            let prepared = gpu.prepare_solid(&mesh, &frame(camera, SolidShow::Plain, 1)).unwrap();
            prepared.run(true).unwrap();
            let picture = prepared.pixels().unwrap().into_picture(96, 96);
            let dark = (40..56).filter(|&x| picture.pixel(x, 30)[0] < 100).count();
            assert!((1..=2).contains(&dark), "{dark} dark pixels across the middle line");
        }
    });
}

#[test]
fn patches_have_no_cracks_and_the_sides_of_triangles() {
    with_gpu(|gpu| {
        let quads = [CUBE.to_string(), CUBE.replace("t crease", "t creased")].map(|text| (text, Scheme::CatmullClark));
        let semi = TETRAHEDRON.replace(" 10\n", " 1.5\n");
        let triangles = [TETRAHEDRON.to_string(), semi].map(|text| (text, Scheme::Loop));
        for (text, scheme) in quads.into_iter().chain(triangles) {
            let control = &levels_of(&text, scheme, 0)[0];
            let (_, made) = patches(control, &[], &Settings::default(), Depth::adaptive(3, &Settings::default()));
            assert!(made.transitions() > 0);
            let bounds = gradtess::camera::bounds(control.position.iter().copied()).unwrap();
            let table = drawing::patches(&made, bounds);
            for segments in [Segments::Fixed(1), Segments::Fixed(5), Segments::Base(12)] {
                let tessellation = Tessellation { segments, ..Tessellation::default() };
                let triangles = Sheet::weld(&drawing::tessellated(&made, segments));
                assert_eq!(triangles.open_edges(), 0);
                let found = look_around(gpu, &table, &triangles, tessellation, [3, 96], 7).unwrap();
                assert!(found.cracks == 0 && found.covered > 2000, "{segments:?}: {found:?}");
            }
            // A closed surface: its front is what is seen, by triangles and by patches.
            let camera = Camera::orbit(bounds, 40.0, 25.0, Projection::Perspective { fov: 30.0 }, 1.0);
            let sides = frame(camera, SolidShow::Sides, 1);
            let uniform = self::table(&levels_of(&text, scheme, 5));
            let see = |table: &SolidTable| {
                let prepared = gpu.prepare_solid(table, &sides).unwrap();
                prepared.run(true).unwrap();
                prepared.pixels().unwrap().into_picture(96, 96).pixel(48, 48)
            };
            assert_eq!(see(&table), [255; 4]);
            assert_eq!(see(&uniform), [255; 4]);
        }
    });
}

#[test]
fn the_tessellator_joins_vertices_as_its_twin_says() {
    with_gpu(|gpu| {
        let mut random = gpu_support::Random::new(5);
        // Crumpled nets: their triangles hide each other, so that any other diagonal shows.
        let mut net = |corners: usize| -> Vec<[f64; 8]> {
            let at = match corners {
                4 => (0..16).map(|i| [f64::from(i % 4) / 3.0, f64::from(i / 4) / 3.0]).collect::<Vec<_>>(),
                _ => (0..5)
                    .flat_map(|j| (0..5 - j).map(move |i| [f64::from(i), f64::from(j)].map(|x| x / 4.0)))
                    .collect(),
            };
            at.iter().map(|[x, y]| [*x, *y, 2.0 * random.next(), 0.0, 0.0, 0.0, 1.0, 0.0]).collect()
        };
        for (form, primitive) in [(Form::Bicubic, Primitive::Bicubic), (Form::Quartic, Primitive::Quartic)] {
            let control = net(form.sides());
            let mut table = SolidTable::new([DVec3::ZERO, DVec3::new(1.0, 1.0, 2.0)]);
            for c in &control {
                let i = table.vertex(DVec3::new(c[0], c[1], c[2]), 0.0, DVec3::Z);
                table.indices.push(i);
            }
            table.part(primitive);
            for n in (1..=11).chain([24, 39, 64]) {
                let domain = match form.sides() {
                    3 => tessellator::triangle([n; 3], n),
                    _ => tessellator::quad([n; 4], n),
                };
                let at = |i: u32| {
                    let [u, v] = domain.points[i as usize];
                    point(form, &control, u, v, 1.0).position
                };
                let drawn: Vec<_> = domain.triangles.iter().map(|t| t.map(at)).collect();
                let tessellation = Tessellation { segments: Segments::Fixed(n), ..Tessellation::default() };
                let found = |triangles: &[[DVec3; 3]]| {
                    look_around(gpu, &table, &Sheet::weld(triangles), tessellation, [4, 128], 11).unwrap()
                };
                let seen = found(&drawn);
                assert!(seen.cracks == 0 && seen.covered > 4000, "{form:?} {n}: {seen:?}");
                if n == 7 {
                    // Two triangles beside each other, cut by the other diagonal.
                    let swapped = (0..drawn.len()).filter_map(|k| other_diagonal(&drawn, k)).map(|t| found(&t).cracks);
                    assert!(swapped.filter(|&cracks| cracks > 0).count() > 10, "{form:?}");
                }
            }
        }
    });
}

/// `triangles`, but triangle `k` and the next, which share an edge, are cut by the other diagonal.
fn other_diagonal(triangles: &[[DVec3; 3]], k: usize) -> Option<Vec<[DVec3; 3]>> {
    let (p, q) = (triangles.get(k)?, triangles.get(k + 1)?);
    let [a] = p.iter().filter(|x| !q.contains(x)).collect::<Vec<_>>()[..] else { return None };
    let [b] = q.iter().filter(|x| !p.contains(x)).collect::<Vec<_>>()[..] else { return None };
    let at = p.iter().position(|x| x == a)?;
    let (from, to) = (p[(at + 1) % 3], p[(at + 2) % 3]);
    let mut out = triangles.to_vec();
    out[k] = [*a, from, *b];
    out[k + 1] = [*a, *b, to];
    Some(out)
}

#[test]
fn normals_on_the_device_are_those_of_the_cpu() {
    with_gpu(|gpu| {
        for (text, scheme) in [(CUBE, Scheme::CatmullClark), (TETRAHEDRON, Scheme::Loop)] {
            let control = &levels_of(text, scheme, 0)[0];
            let (_, made) = patches(control, &[], &Settings::default(), Depth::adaptive(3, &Settings::default()));
            let bounds = gradtess::camera::bounds(control.position.iter().copied()).unwrap();
            // The same patches as triangles with normals of the CPU, each patch a lattice.
            let n = 12;
            let mut triangles = SolidTable::new(bounds);
            for patch in made.iter() {
                let corners = patch.form.sides();
                let inside = |i: u32, j: u32| corners == 4 || i + j <= n;
                let mut number = std::collections::HashMap::new();
                for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))).filter(|&(i, j)| inside(i, j)) {
                    let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(n));
                    let p = point(patch.form, &patch.control, u, v, 1.0);
                    number.insert((i, j), triangles.vertex(p.position, p.weight, p.blended));
                }
                for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).filter(|&(i, j)| inside(i + 1, j)) {
                    let [a, b, d] = [(i, j), (i + 1, j), (i, j + 1)].map(|k| number.get(&k).copied());
                    let c = number.get(&(i + 1, j + 1)).copied();
                    triangles.indices.extend([a, b, d].map(|k| k.unwrap()));
                    if let Some(c) = c {
                        triangles.indices.extend([b.unwrap(), c, d.unwrap()]);
                    }
                }
            }
            triangles.part(Primitive::Triangles);
            let camera = Camera::orbit(bounds, 40.0, 25.0, Projection::Perspective { fov: 30.0 }, 1.0);
            let tessellation = Tessellation { segments: Segments::Fixed(n), ..Tessellation::default() };
            for show in [SolidShow::Normals, SolidShow::Weights] {
                let see = |table: &SolidTable| {
                    let frame = SolidFrame { tessellation, ..frame(camera, show, 1) };
                    let prepared = gpu.prepare_solid(table, &frame).unwrap();
                    prepared.run(true).unwrap();
                    prepared.floats().unwrap()
                };
                let (cpu, gpu) = (see(&triangles), see(&drawing::patches(&made, bounds)));
                let apart: Vec<f32> = cpu.iter().zip(&gpu).map(|(a, b)| (a - b).abs()).collect();
                let mean = apart.iter().sum::<f32>() / apart.len() as f32;
                let far = apart.iter().filter(|&&d| d > 0.01).count();
                // A few pixels of the contour and of creases are covered by one only.
                assert!(mean < 1e-3 && far < 150, "{scheme:?} {show:?}: {mean}, {far} of {}", apart.len());
            }
        }
    });
}

#[test]
fn control_points_of_the_device_are_those_of_the_cpu() {
    with_gpu(|gpu| {
        for (text, scheme) in [(CUBE, Scheme::CatmullClark), (TETRAHEDRON, Scheme::Loop)] {
            let control = &levels_of(text, scheme, 0)[0];
            let (_, made) = patches(control, &[], &Settings::default(), Depth::adaptive(4, &Settings::default()));
            let (bounds, _) = made.bounds();
            let table = drawing::patches(&made, bounds);
            let camera = Camera::orbit(bounds, 40.0, 25.0, Projection::Perspective { fov: 30.0 }, 1.0);
            let prepared = gpu.prepare_solid(&table, &frame(camera, SolidShow::Normals, 1)).unwrap();
            let points = prepared.points().unwrap();
            prepared.run(true).unwrap();
            assert_eq!(prepared.points().unwrap(), points);
            let twin = table.stencils.as_ref().unwrap().points_of(&table.vertices);
            assert_eq!(points.len(), twin.len());
            let size = (bounds[1] - bounds[0]).length();
            for (i, (point, twin)) in points.iter().zip(&twin).enumerate() {
                let apart = point.iter().zip(twin).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(f64::from(apart) <= 1e-6 * size, "{scheme:?} {i}: {point:?} {twin:?}");
                // Those after them tell patches which sides have finer neighbours.
                if i < made.points() {
                    let exact = made.control(i as u32);
                    let found = DVec3::new(point[0].into(), point[1].into(), point[2].into()) + table.centre;
                    assert!((found - DVec3::from_slice(&exact)).length() < 1e-6 * size, "{scheme:?} {i}");
                    assert!((3..7).all(|c| (f64::from(point[c]) - exact[c]).abs() < 1e-6), "{scheme:?} {i}");
                }
            }
            // No triangles: nothing is made.
            let plain = self::table(&levels_of(text, scheme, 2));
            let prepared = gpu.prepare_solid(&plain, &frame(camera, SolidShow::Normals, 1)).unwrap();
            assert!(prepared.points().unwrap().is_empty());
            // What points outside never gets to the device.
            for spoil in [
                |table: &mut SolidTable| table.vertices.truncate(3),
                |table: &mut SolidTable| table.stencils.as_mut().unwrap().terms.truncate(7),
                |table: &mut SolidTable| table.stencils.as_mut().unwrap().points[2][1] = 0,
                |table: &mut SolidTable| table.stencils.as_mut().unwrap().points.truncate(9),
                |table: &mut SolidTable| table.vertices[0][1] = 2e37,
            ] {
                let mut spoilt = table.clone();
                spoil(&mut spoilt);
                assert!(gpu.prepare_solid(&spoilt, &frame(camera, SolidShow::Normals, 1)).is_err());
            }
        }
    });
}
