//! Meshes with T-sections on the device: the same bits along every curve, no cracks, colours of every space.

use ferguson_meshes::{random_split, ring, wavy, Random};
use glam::DVec4;
use gpu_support::{by_patch, with_gpu};
use gradtess::check::sections;
use gradtess::ferguson::fit::Target;
use gradtess::ferguson::mesh::{HalfEdge, Mesh};
use gradtess::ferguson::table::table;
use gradtess::gpu::{Format, Frame, Gpu, Pixels, Show};
use gradtess::patch::space::{Interpolation, SPACES};
use gradtess::patch::tess::TessRule;
use gradtess::patch::{stitched, ControlPoint, PatchTable};
use std::collections::HashMap;

mod ferguson_meshes;
mod gpu_support;

/// Meshes with many T-sections: dyadic and at any parameter.
fn meshes() -> Vec<(&'static str, Mesh)> {
    let mut all = Vec::new();
    for (name, base, dyadic, splits) in
        [("dyadic", wavy(2, 2), true, 60), ("any parameter", wavy(2, 2), false, 40), ("ring", ring(5, 1), true, 40)]
    {
        let (mut mesh, mut random) = (base, Random::new(9));
        for _ in 0..splits {
            random_split(&mut mesh, &mut random, dyadic);
        }
        all.push((name, mesh));
    }
    all
}

fn control(table: &PatchTable, range: usize, patch: usize) -> Vec<ControlPoint> {
    let first = table.ranges[range].first as usize + 32 * patch;
    table.indices[first..first + 32].iter().map(|&i| table.control[i as usize].map(|x| f64::from(x as f32))).collect()
}

/// Of a side along a curve: the patch, where on the curve it begins and ends, and its vertices as bits.
type Stretch = (u32, f64, f64, Vec<[u32; 2]>);

#[test]
fn vertices_are_the_twin_s_and_curves_have_the_same_bits_from_both_sides() {
    with_gpu(|gpu| {
        for (name, mesh) in meshes() {
            for target in [
                Target { rule: TessRule::Fixed(5.0), ..Target::default() },
                Target { rule: TessRule::Pixels(7.3), scale: [300.0, 300.0], view: None },
                Target { rule: TessRule::Pixels(2.0), scale: [300.0, 300.0], view: None },
            ] {
                let mesh = mesh.fit(&target);
                let table = table(&mesh, &target);
                let device = gpu.upload(&table).unwrap();
                let points = gpu.evaluate(&device, target.rule, target.scale).unwrap();
                // Of every curve: the vertices that each patch has on it, as bits.
                let mut along: HashMap<u32, Vec<Stretch>> = HashMap::new();
                for (number, patch) in by_patch(&points).into_iter().enumerate() {
                    let net = control(&table, patch[0].range as usize, patch[0].patch as usize);
                    let outer = patch[0].outer.map(f64::from);
                    let face = table.faces[number].name as u32;
                    let mut sides: [Vec<(f32, [u32; 2])>; 4] = Default::default();
                    for p in patch {
                        let [u, v, _] = p.coord;
                        let twin = stitched::vertex(&net, outer, [f64::from(u), f64::from(v)]);
                        for c in [0, 1, 4, 5, 6, 7] {
                            assert!(
                                (f64::from(p.value[c]) - twin[c]).abs() < 4e-6,
                                "{name} {face} {:?} {twin:?}",
                                p.value
                            );
                        }
                        let at = [p.value[0].to_bits(), p.value[1].to_bits()];
                        for (side, (on, t)) in [(v == 0.0, u), (u == 1.0, v), (v == 1.0, 1.0 - u), (u == 0.0, 1.0 - v)]
                            .into_iter()
                            .enumerate()
                        {
                            if on {
                                sides[side].push((t, at));
                            }
                        }
                    }
                    for (i, mut list) in sides.into_iter().enumerate() {
                        let side = *mesh.side(HalfEdge::new(face, i));
                        list.sort_by(|a, b| a.0.total_cmp(&b.0));
                        let mut bits: Vec<[u32; 2]> = list.into_iter().map(|x| x.1).collect();
                        if side.against {
                            bits.reverse();
                        }
                        along
                            .entry(2 * side.curve + u32::from(side.against))
                            .or_default()
                            .push((face, side.from, side.to, bits));
                    }
                }
                for (&key, list) in along.iter().filter(|(key, _)| *key % 2 == 0) {
                    let Some(other) = along.get(&(key + 1)) else { continue };
                    let chain = |list: &Vec<(u32, f64, f64, Vec<[u32; 2]>)>| {
                        let mut list = list.clone();
                        list.sort_by(|a, b| a.1.total_cmp(&b.1));
                        let mut all: Vec<[u32; 2]> = Vec::new();
                        for (_, _, _, bits) in list {
                            if let Some(last) = all.pop() {
                                assert_eq!(last, bits[0], "{name}: neighbours on a curve meet in one point");
                            }
                            all.extend(bits);
                        }
                        all
                    };
                    assert_eq!(chain(list), chain(other), "{name}, curve {}", key / 2);
                }
            }
        }
    });
}

fn draw(gpu: &Gpu, mesh: &Mesh, target: &Target, view: [f64; 4], size: u32) -> (Vec<f32>, Mesh) {
    let fitted = mesh.fit(target);
    let table = gpu.upload(&table(&fitted, target)).unwrap();
    let frame = Frame {
        width: size,
        height: size,
        view,
        tess: target.rule,
        show: Show::Surface,
        background: None,
        samples: 1,
        format: Format::Rgba32f,
        statistics: false,
    };
    let Pixels::Rgba32f(pixels) = gpu.render(&table, &frame).unwrap().pixels else { panic!() };
    (pixels, fitted)
}

/// Views a scene; `GRADTESS_CRACK_VIEWS` asks for more than the few that every run has time for.
#[test]
fn random_views_have_no_cracks() {
    let views: u32 = std::env::var("GRADTESS_CRACK_VIEWS").ok().and_then(|v| v.parse().ok()).unwrap_or(12);
    with_gpu(|gpu| {
        for (name, mesh) in meshes() {
            let mut random = Random::new(21);
            let (mut inside, mut most) = (0, 0);
            for view in 0..views {
                let zoom = 1000f64.powf(if view % 4 == 0 { 1.0 } else { random.unit() });
                let size = 192;
                let (x, y) = (random.unit(), random.unit());
                let d = 0.6 / zoom;
                let view = [x - d, y - d, x + d, y + d];
                let scale = [f64::from(size) / (2.0 * d); 2];
                let rule = TessRule::Pixels(3.0 + 8.0 * random.unit() as f32);
                let target = Target { rule, scale, view: Some(view) };
                let (pixels, fitted) = draw(gpu, &mesh, &target, view, size);
                most = most.max(fitted.live().count());
                let covered: Vec<bool> = pixels.chunks_exact(4).map(|p| p[3] > 0.0).collect();
                let outline = sections::outline(&fitted, &target, view, [size, size]);
                let (found, n) = sections::cracks(&outline, &covered, [size, size]);
                assert!(found.is_empty(), "{name}: {found:?} in {view:?}");
                inside += n;
            }
            println!("{name}: no background pixel among {inside} inside, {views} views, at most {most} patches");
            assert!(inside > 10_000);
        }
    });
}

#[test]
fn every_space_is_interpolated_and_turned_into_srgb_by_pixel() {
    with_gpu(|gpu| {
        for (space, name) in SPACES {
            for premultiplied in [false, true] {
                let colour = Interpolation { space, premultiplied };
                let rgb = [[1.0, 0.1, 0.0, 1.0], [0.0, 0.2, 1.0, 0.25], [1.0, 0.9, 0.1, 0.5], [0.1, 0.7, 0.3, 1.0]];
                let mut mesh = Mesh::grid(1, 1, [0.0, 0.0, 1.0, 1.0], |i, j| {
                    space.encode(DVec4::from(rgb[(i + 2 * j) as usize]), premultiplied)
                })
                .unwrap();
                mesh.colour = colour;
                let target = Target { rule: TessRule::Fixed(64.0), ..Target::default() };
                let (pixels, _) = draw(gpu, &mesh, &target, [0.0, 0.0, 1.0, 1.0], 32);
                let mut worst = 0.0f64;
                for (i, pixel) in pixels.chunks_exact(4).enumerate() {
                    let (u, v) = ((i % 32) as f64 / 32.0 + 1.0 / 64.0, 1.0 - (i / 32) as f64 / 32.0 - 1.0 / 64.0);
                    let wanted = colour.decode(mesh.evaluate(0, u, v).1);
                    for c in 0..4 {
                        worst = worst.max((f64::from(pixel[c]) - wanted[c]).abs());
                    }
                }
                // 64 segments: the chord of a colour is at most about 6 / (8 * 64^2) away, and gamma steepens it.
                assert!(worst < 3e-3, "{name} premultiplied {premultiplied}: {worst}");
            }
        }
    });
}
