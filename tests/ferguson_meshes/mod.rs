//! Small gradient meshes and random operations for the tests of technique `ferguson`.
#![allow(dead_code)] // each test program uses some of them

use glam::{DVec2, DVec4};
use gradtess::ferguson::mesh::{HalfEdge, Mesh};
use gradtess::ferguson::split::Axis;
pub use gradtess::timing::random::Random;

pub fn close(a: DVec2, b: DVec2, by: f64) -> bool {
    (a - b).abs().max_element() < by
}

fn hue(i: u32) -> DVec4 {
    let t = f64::from(i) * 0.9;
    DVec4::new(0.5 + 0.5 * t.cos(), 0.5 + 0.5 * (t + 2.1).cos(), 0.5 + 0.5 * (t + 4.2).cos(), 1.0)
}

/// Bends all handles by fixed amounts, mirrored nowhere, and gives every corner a twist: the worst case for exactness.
pub fn bend(mesh: &mut Mesh, by: f64) {
    let mut random = Random::new(5);
    let mut offset = |by: f64| DVec2::new(random.unit() - 0.5, random.unit() - 0.5) * by;
    for curve in &mut mesh.curves {
        curve.handles = curve.handles.map(|h| h + offset(by));
    }
    for patch in &mut mesh.patches {
        for corner in &mut patch.corners {
            corner.twist = offset(by);
        }
    }
}

/// A bent grid over the unit square.
pub fn wavy(columns: u32, rows: u32) -> Mesh {
    let mut mesh = Mesh::grid(columns, rows, [0.0, 0.0, 1.0, 1.0], |i, j| hue(3 * i + 5 * j)).unwrap();
    bend(&mut mesh, 0.2 / f64::from(columns.max(rows)));
    mesh.take_journal();
    mesh
}

/// A genuine radial mesh round a hole: a closed loop of patches, with one branch outside.
pub fn ring(sectors: u32, rings: u32) -> Mesh {
    let mut points = Vec::new();
    for r in 0..=rings {
        for s in 0..sectors {
            let a = std::f64::consts::TAU * f64::from(s) / f64::from(sectors);
            let radius = 0.15 + 0.2 * f64::from(r);
            points.push(DVec2::new(0.5 + radius * a.cos(), 0.5 + radius * a.sin()));
        }
    }
    let id = |r: u32, s: u32| r * sectors + s % sectors;
    let mut quads = Vec::new();
    for r in 0..rings {
        for s in 0..sectors {
            quads.push([id(r, s), id(r + 1, s), id(r + 1, s + 1), id(r, s + 1)]);
        }
    }
    let (a, b) = (id(rings, 0), id(rings, 1));
    let first = points.len() as u32;
    points.push(points[a as usize] + DVec2::new(0.3, -0.1));
    points.push(points[b as usize] + DVec2::new(0.3, 0.1));
    quads.push([a, first, first + 1, b]);
    let colours: Vec<[DVec4; 4]> = quads.iter().map(|q| q.map(hue)).collect();
    let mut mesh = Mesh::from_quads(&points, &quads, &colours).unwrap();
    bend(&mut mesh, 0.05);
    mesh.take_journal();
    mesh
}

/// Splits one random patch, at the middle or anywhere.
pub fn random_split(mesh: &mut Mesh, random: &mut Random, dyadic: bool) {
    let live: Vec<u32> = mesh.live().collect();
    let p = live[random.below(live.len())];
    // Down to widths where parameters are still far from rounding.
    let axis = if random.below(2) == 0 { Axis::U } else { Axis::V };
    if mesh.patch(p).extent().iter().any(|&e| e < 1e-4) {
        return;
    }
    let at = if dyadic { 0.5 } else { 0.2 + 0.6 * random.unit() };
    mesh.split(p, axis, at).unwrap();
}

/// The patch that holds (u, v) of a root, and where in it.
pub fn find(mesh: &Mesh, root: u32, u: f64, v: f64) -> (u32, f64, f64) {
    let inside = |p: &u32| {
        let q = mesh.patch(*p);
        q.root == root && (q.rect[0]..=q.rect[2]).contains(&u) && (q.rect[1]..=q.rect[3]).contains(&v)
    };
    let p = mesh.live().find(inside).expect("roots are covered");
    let r = mesh.patch(p).rect;
    (p, (u - r[0]) / (r[2] - r[0]), (v - r[1]) / (r[3] - r[1]))
}

/// Greatest change of a position, in parts of the canvas, and of a colour between a mesh and what it is after splits.
pub fn change(before: &Mesh, after: &Mesh, random: &mut Random) -> [f64; 2] {
    let live: Vec<u32> = before.live().collect();
    let all = || live.iter().flat_map(|&p| before.geometry(p));
    let (low, high) = (all().reduce(DVec2::min).unwrap(), all().reduce(DVec2::max).unwrap());
    let canvas = (high - low).max_element();
    let mut worst = [0.0f64; 2];
    for _ in 0..4000 {
        let p = live[random.below(live.len())];
        let (u, v) = (random.unit(), random.unit());
        let (x, c) = before.evaluate(p, u, v);
        let (r, root) = (before.patch(p).rect, before.patch(p).root);
        let (q, qu, qv) = find(after, root, r[0] + u * (r[2] - r[0]), r[1] + v * (r[3] - r[1]));
        let (y, d) = after.evaluate(q, qu, qv);
        worst[0] = worst[0].max((x - y).abs().max_element() / canvas);
        worst[1] = worst[1].max((c - d).abs().max_element());
    }
    worst
}

/// A corner of a patch.
pub fn corner(p: u32, i: usize) -> HalfEdge {
    HalfEdge::new(p, i)
}
