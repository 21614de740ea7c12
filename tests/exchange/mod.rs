//! Shared by the tests of exchange formats: pictures of meshes, ours and by exact evaluation.
#![allow(dead_code)] // each test file uses its own part

use glam::{DVec2, DVec4};
use gradtess::ferguson::fit::Target;
use gradtess::ferguson::table::table;
use gradtess::ferguson::Mesh;
use gradtess::gpu::{Format, Frame, Gpu, Pixels, Show};
use gradtess::patch::tess::TessRule;
use gradtess::patch::PatchTable;

/// A square view around all control points, with a margin.
pub fn square(mesh: &Mesh) -> [f64; 4] {
    let all: Vec<DVec2> = mesh.live().flat_map(|p| mesh.geometry(p)).collect();
    let low = all.iter().copied().fold(DVec2::INFINITY, DVec2::min);
    let high = all.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
    let (middle, half) = ((low + high) * 0.5, 0.52 * (high - low).max_element());
    [middle.x - half, middle.y - half, middle.x + half, middle.y + half]
}

/// A float picture of `size` pixels square, straight alpha, rows from the top.
pub fn draw(gpu: &Gpu, mesh: &Mesh, view: [f64; 4], size: u32) -> Vec<DVec4> {
    let scale = [f64::from(size) / (view[2] - view[0]), f64::from(size) / (view[3] - view[1])];
    let target = Target { rule: TessRule::Pixels(0.5), scale, view: Some(view) };
    draw_table(gpu, &table(&mesh.fit(&target), &target), view, size)
}

/// The same of any table.
pub fn draw_table(gpu: &Gpu, table: &PatchTable, view: [f64; 4], size: u32) -> Vec<DVec4> {
    let uploaded = gpu.upload(table).unwrap();
    let frame = Frame {
        width: size,
        height: size,
        view,
        tess: TessRule::Pixels(0.5),
        show: Show::Surface,
        background: None,
        samples: 1,
        format: Format::Rgba32f,
        statistics: false,
    };
    let Pixels::Rgba32f(pixels) = gpu.render(&uploaded, &frame).unwrap().pixels else { panic!("a float picture") };
    pixels.chunks_exact(4).map(|p| DVec4::new(p[0].into(), p[1].into(), p[2].into(), p[3].into())).collect()
}

/// Centre of pixel `i` in the model.
pub fn centre(i: usize, size: u32, [x0, y0, x1, y1]: [f64; 4]) -> DVec2 {
    let n = size as usize;
    let (x, y) = ((i % n) as f64 + 0.5, (i / n) as f64 + 0.5);
    DVec2::new(x0 + (x1 - x0) * x / f64::from(size), y1 - (y1 - y0) * y / f64::from(size))
}

/// Colour of a mesh at a place, by Newton's method in every patch: the last patch that covers it, sRGB.
pub fn exact(mesh: &Mesh, at: DVec2) -> Option<DVec4> {
    mesh.live().filter_map(|p| exact_in(mesh, p, at)).last()
}

fn exact_in(mesh: &Mesh, p: u32, at: DVec2) -> Option<DVec4> {
    let (net, colours) = (mesh.geometry(p), mesh.colours(p));
    let low = net.iter().copied().reduce(DVec2::min)?;
    let high = net.iter().copied().reduce(DVec2::max)?;
    if at.cmplt(low).any() || at.cmpgt(high).any() {
        return None;
    }
    let size = (high - low).max_element();
    for start in 0..9 {
        let (mut u, mut v) = ([0.5, 0.2, 0.8][start % 3], [0.5, 0.2, 0.8][start / 3]);
        for _ in 0..30 {
            let (s, du, dv) = jet(&net, u, v);
            let (miss, det) = (at - s, du.perp_dot(dv));
            if miss.length() < 1e-11 * size {
                let inside = [u, v].iter().all(|x| (-1e-9..=1.0 + 1e-9).contains(x));
                return inside.then(|| mesh.colour.decode(tensor(&colours, u, v)));
            }
            u = (u + miss.perp_dot(dv) / det).clamp(-0.5, 1.5);
            v = (v + du.perp_dot(miss) / det).clamp(-0.5, 1.5);
        }
    }
    None
}

fn bernstein(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}

fn slope(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t]
}

fn sum(net: &[DVec2; 16], u: [f64; 4], v: [f64; 4]) -> DVec2 {
    (0..16).map(|i| net[i] * (u[i % 4] * v[i / 4])).sum()
}

fn jet(net: &[DVec2; 16], u: f64, v: f64) -> (DVec2, DVec2, DVec2) {
    let (a, b) = (bernstein(u), bernstein(v));
    (sum(net, a, b), sum(net, slope(u), b), sum(net, a, slope(v)))
}

fn tensor(net: &[DVec4; 16], u: f64, v: f64) -> DVec4 {
    let (a, b) = (bernstein(u), bernstein(v));
    (0..16).map(|i| net[i] * (a[i % 4] * b[i / 4])).sum()
}
