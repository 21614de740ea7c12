//! Patches against the surface they stand for: regular ones are the limit itself, Gregory patches come near it.

mod models;
mod random_scene;

use gradtess::check::exact::{into_child, quarter, ExactFace};
use gradtess::mesh;
use gradtess::patch::build::{build, face_control};
use gradtess::patch::points::Irregular;
use gradtess::patch::{eval, Face, Kind, PatchTable};
use gradtess::refine::{refine, Mode, Options, Refinement, Rules};
use gradtess::scene::{CornerRule, Frame, GeometryEdit, Scene};
use gradtess::subdiv::index_map::IndexMap;
use gradtess::subdiv::level::{vertex_bits, Value};
use random_scene::for_random_scenes;
use std::path::{Path, PathBuf};

const ADAPTIVE: Mode = Mode::Adaptive { isolate: 0 };

fn parse(text: &str) -> Scene {
    Scene::parse(text.as_bytes(), "test").unwrap_or_else(|e| panic!("{e}"))
}

fn refined(scene: &Scene, mode: Mode) -> Refinement {
    let mesh = mesh::build(&scene.mesh).unwrap();
    refine(scene, &mesh, Options { rules: Rules::Gradtess, mode }).unwrap()
}

/// From a patch's own domain to that of its face, whose first half-edge leaves corner `4 - turn`.
fn unturned(turn: u8, u: f64, v: f64) -> [f64; 2] {
    match turn {
        0 => [u, v],
        1 => [1.0 - v, u],
        2 => [1.0 - u, 1.0 - v],
        _ => [v, 1.0 - u],
    }
}

/// A patch at (u, v) of its own domain.
fn patch_at(table: &PatchTable, face: &Face, u: f64, v: f64) -> Value {
    let c = eval::face(face.kind, &face_control(table, face), u, v);
    Value { p: glam::DVec2::new(c[0], c[1]), c: glam::DVec4::new(c[4], c[5], c[6], c[7]) }
}

fn error(a: Value, b: Value) -> f64 {
    (a.p - b.p).abs().max_element().max((a.c - b.c).abs().max_element())
}

/// Greatest coordinate or colour: what errors are relative to.
fn size(table: &PatchTable) -> f64 {
    table.control.iter().flatten().fold(1.0f64, |most, x| most.max(x.abs()))
}

/// Local number of each drawn face in its level.
fn local(r: &Refinement, face: &Face) -> u32 {
    r.levels[face.level as usize].face.iter().position(|&name| name == face.name).unwrap() as u32
}

fn scenes() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    for folder in ["scenes", "scenes/unit"] {
        let entries = std::fs::read_dir(root.join(folder)).unwrap().map(|e| e.unwrap().path());
        found.extend(entries.filter(|p| p.extension().is_some_and(|e| e == "json") && !p.ends_with("schema.json")));
    }
    if let Some(models) = models::folder("paper", "exactness of the authors' models") {
        found.extend(["Quad_edits.obj", "House.obj", "cherry/cherry_editAtSubd2.obj"].map(|name| models.join(name)));
    }
    found.sort();
    found
}

/// How far patches are from the limit, relative to the scene's size.
#[derive(Debug, Default)]
struct Errors {
    /// Of regular patches anywhere, and how many there are.
    regular: f64,
    regular_faces: usize,
    /// Of all patches at their corners, and how many there are.
    corner: f64,
    faces: usize,
    /// Of colours at darts.
    dart: f64,
    darts: usize,
}

fn against_the_limit(r: &Refinement) -> Errors {
    let table = build(r, Irregular::Gregory);
    let size = size(&table);
    let mut errors = Errors { faces: table.faces.len(), ..Errors::default() };
    for face in &table.faces {
        let level = &r.levels[face.level as usize];
        let f = local(r, face);
        let mut exact = ExactFace::new(r, face.level as usize, f);
        for (i, (u, v)) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].into_iter().enumerate() {
            let h = level.first(f) + ((i as u32 + u32::from(face.turn)) & 3);
            let [eu, ev] = unturned(face.turn, u, v);
            let (a, b) = (patch_at(&table, face, u, v), exact.at(eu, ev));
            if level.bits[level.origin[h as usize] as usize] & vertex_bits::DART != 0 {
                errors.dart = errors.dart.max((a.c - b.c).abs().max_element() / size);
                errors.darts += 1;
            }
            errors.corner = errors.corner.max(error(a, b) / size);
        }
        if !face.irregular {
            errors.regular_faces += 1;
            for (u, v) in [(0.5, 0.0), (1.0, 0.3), (0.7, 1.0), (0.0, 0.1), (0.35, 0.6), (0.9, 0.2)] {
                let [eu, ev] = unturned(face.turn, u, v);
                errors.regular = errors.regular.max(error(patch_at(&table, face, u, v), exact.at(eu, ev)) / size);
            }
        }
    }
    assert!(errors.regular < 1e-12 && errors.corner < 1e-12 && errors.dart < 1e-12, "{errors:?}");
    errors
}

#[test]
fn regular_patches_of_scenes_are_the_limit() {
    for path in scenes() {
        let Ok(scene) = Scene::load(&path) else { continue };
        let r = refined(&scene, ADAPTIVE);
        let e = against_the_limit(&r);
        println!(
            "{}: {} regular patches within {:.1e}, corners of all {} within {:.1e}, colours at {} corners on darts within {:.1e}",
            path.file_stem().unwrap().to_string_lossy(),
            e.regular_faces,
            e.regular,
            e.faces,
            e.corner,
            e.darts,
            e.dart
        );
    }
}

#[test]
fn regular_patches_of_random_scenes_are_the_limit() {
    let worst = std::cell::Cell::new(0.0f64);
    for_random_scenes(60, |scene, _| worst.set(worst.get().max(against_the_limit(&refined(scene, ADAPTIVE)).dart)));
    println!("colours at darts within {:.1e}", worst.get());
}

#[test]
fn the_limit_does_not_depend_on_the_level_it_is_asked_at() {
    for_random_scenes(40, |scene, _| {
        let to = 2;
        let mut scene = scene.clone();
        scene.geometry.retain(|e| e.level <= 1);
        scene.colours.retain(|e| e.level <= 1);
        let r = refined(&scene, Mode::Global(to));
        let coarse = &r.levels[1];
        for f in (0..coarse.faces() as u32).step_by(5) {
            let mut above = ExactFace::new(&r, 1, f);
            for (u, v) in [(0.0, 0.0), (0.5, 0.5), (0.2, 0.9), (0.77, 0.13), (1.0, 0.4)] {
                let s = quarter(u, v);
                let [cu, cv] = into_child(s, u, v);
                let child = coarse.child[(coarse.first(f) + s) as usize];
                let below = ExactFace::new(&r, 2, child).at(cu, cv);
                let off = error(above.at(u, v), below);
                assert!(off < 1e-11, "face {f} at {u}, {v}: {off:e}");
            }
        }
    });
}

/// Uniform bicubic B-splines over a grid of control values, written down once more: phantom rows by linear
/// extrapolation make the border interpolate its own curve and the corners.
struct Spline {
    width: usize,
    height: usize,
    value: Vec<Value>,
}

impl Spline {
    fn at(&self, i: i64, j: i64) -> Value {
        let (w, h) = (self.width as i64, self.height as i64);
        if i < 0 {
            return self.at(0, j) * 2.0 - self.at(1, j);
        }
        if i >= w {
            return self.at(w - 1, j) * 2.0 - self.at(w - 2, j);
        }
        if j < 0 {
            return self.at(i, 0) * 2.0 - self.at(i, 1);
        }
        if j >= h {
            return self.at(i, h - 1) * 2.0 - self.at(i, h - 2);
        }
        self.value[(j * w + i) as usize]
    }

    /// At (x, y) in steps of the grid.
    fn limit(&self, x: f64, y: f64) -> Value {
        let (i, j) = (x.floor().min(self.width as f64 - 2.0), y.floor().min(self.height as f64 - 2.0));
        let weights = |t: f64| {
            let s = 1.0 - t;
            [s.powi(3), 3.0 * t.powi(3) - 6.0 * t * t + 4.0, 3.0 * s.powi(3) - 6.0 * s * s + 4.0, t.powi(3)]
                .map(|w| w / 6.0)
        };
        let (wx, wy) = (weights(x - i), weights(y - j));
        let mut sum = Value::default();
        for (dj, wy) in (-1..).zip(wy) {
            for (di, wx) in (-1..).zip(wx) {
                sum = sum + self.at(i as i64 + di, j as i64 + dj) * (wx * wy);
            }
        }
        sum
    }

    /// The same surface over a grid of half the step: knots inserted along x, then along y.
    fn finer(&self) -> Spline {
        let along_x = |j: i64| -> Vec<Value> {
            (0..2 * self.width as i64 - 1)
                .map(|i| {
                    let k = i / 2;
                    match i % 2 {
                        0 => (self.at(k - 1, j) + self.at(k, j) * 6.0 + self.at(k + 1, j)) * 0.125,
                        _ => (self.at(k, j) + self.at(k + 1, j)) * 0.5,
                    }
                })
                .collect()
        };
        let (width, height) = (2 * self.width - 1, 2 * self.height - 1);
        let rows: Vec<Vec<Value>> = (-1..=self.height as i64).map(along_x).collect();
        let row = |j: i64, i: usize| rows[(j + 1) as usize][i];
        let mut value = Vec::new();
        for j in 0..height as i64 {
            let k = j / 2;
            value.extend((0..width).map(|i| match j % 2 {
                0 => (row(k - 1, i) + row(k, i) * 6.0 + row(k + 1, i)) * 0.125,
                _ => (row(k, i) + row(k + 1, i)) * 0.5,
            }));
        }
        Spline { width, height, value }
    }
}

/// A grid of 4 by 3 bent squares with a colour for every vertex; `right` is added to the colours seen from right of
/// x = 2. Returns its scene and M^0 as a grid, seen from the left.
fn bent_grid(right: f64) -> (Scene, Spline, Spline) {
    let mut scene = parse(r#"{ "gradtess": 1, "builtin": "grid:4x3" }"#);
    for (i, p) in scene.mesh.positions.iter_mut().enumerate() {
        let (x, y) = ((i % 5) as f64, (i / 5) as f64);
        *p = glam::DVec2::new(x + 0.2 * (y * 1.3).sin() + 0.05 * x * y, y - 0.15 * (x * 2.1).cos());
    }
    let colour = |v: u32| {
        let (x, y) = (f64::from(v % 5), f64::from(v / 5));
        glam::DVec4::new(0.2 + 0.1 * x, 0.9 - 0.2 * y, 0.5 + 0.3 * (x * y).sin(), 1.0)
    };
    let mesh = mesh::build(&scene.mesh).unwrap();
    let beyond = |h: u32| mesh.face[h as usize] % 4 >= 2;
    let shift = glam::DVec4::new(right, -right, 0.5 * right, 0.0);
    scene.corner_colours = (0..mesh.half_edges())
        .map(|h| colour(mesh.origin[h as usize]) + if beyond(h) { shift } else { Default::default() })
        .collect();
    // Positions by the ternary step; colours spread over the one-ring of each vertex.
    let spline = |shift: glam::DVec4| {
        let point = |x: usize, y: usize| scene.mesh.positions[y * 5 + x];
        let mut value = Vec::new();
        for j in 0..10 {
            for i in 0..13 {
                let near = |k: usize| if k % 3 == 2 { k / 3 + 1 } else { k / 3 };
                let far = |k: usize| if k % 3 == 2 { k / 3 } else { k / 3 + 1 };
                let (x, y) = (near(i), near(j));
                let p = match (i % 3, j % 3) {
                    (0, 0) => point(x, y),
                    (_, 0) => (2.0 * point(x, y) + point(far(i), y)) / 3.0,
                    (0, _) => (2.0 * point(x, y) + point(x, far(j))) / 3.0,
                    _ => {
                        let (a, b, c) = (point(far(i), y), point(x, far(j)), point(far(i), far(j)));
                        let centre = (point(x, y) + a + b + c) / 4.0;
                        (3.0 * point(x, y) + a + b + 4.0 * centre) / 9.0
                    }
                };
                value.push(Value { p, c: colour((y * 5 + x) as u32) + shift });
            }
        }
        Spline { width: 13, height: 10, value }
    };
    let (left, beyond) = (spline(glam::DVec4::ZERO), spline(shift));
    (scene, left, beyond)
}

/// Half of the columns as a surface of its own: what a sharp edge makes of the colours.
fn columns(spline: &Spline, from: usize, to: usize) -> Spline {
    let width = to - from;
    let row = |j: usize| spline.value[j * spline.width + from..j * spline.width + to].to_vec();
    Spline { width, height: spline.height, value: (0..spline.height).flat_map(row).collect() }
}

/// Greatest error of the patches against closed-form splines by level: `[left, right]` hold positions of the whole and
/// colours of each side.
fn against_splines(r: &Refinement, whole: &[Spline], left: &[Spline], right: &[Spline]) -> (f64, usize) {
    let table = build(r, Irregular::Gregory);
    let mut greatest = 0.0f64;
    for face in &table.faces {
        assert!(!face.irregular && face.kind == Kind::Bicubic);
        let l = face.level as usize;
        let level = &r.levels[l];
        let f = local(r, face);
        // Where the face's corners are in the grid of its level, by position alone.
        let grid = level.of_face(f).map(|h| {
            let p = level.position(h);
            let k = whole[l].value.iter().position(|v| (v.p - p).length() < 1e-9).expect("a point of the grid");
            glam::DVec2::new((k % whole[l].width) as f64, (k / whole[l].width) as f64)
        });
        let corner: Vec<glam::DVec2> = grid.collect();
        let middle = corner.iter().map(|c| c.x).sum::<f64>() / 4.0;
        let seam = (whole[l].width - 1) as f64 / 2.0;
        for (u, v) in (0..=4).flat_map(|i| (0..=4).map(move |j| (f64::from(i) / 4.0, f64::from(j) / 4.0))) {
            let [fu, fv] = unturned(face.turn, u, v);
            let at = corner[0] + (corner[1] - corner[0]) * fu + (corner[3] - corner[0]) * fv;
            let colour = if middle < seam { left[l].limit(at.x, at.y) } else { right[l].limit(at.x - seam, at.y) };
            let want = Value { p: whole[l].limit(at.x, at.y).p, c: colour.c };
            greatest = greatest.max(error(patch_at(&table, face, u, v), want));
        }
    }
    (greatest, table.faces.len())
}

#[test]
fn smooth_grids_are_closed_form_splines_with_boundaries_and_corners() {
    let (scene, grid, _) = bent_grid(0.0);
    assert_eq!(build(&refined(&scene, ADAPTIVE), Irregular::Gregory).faces.len(), 12 * 9);
    let mut greatest = 0.0f64;
    for to in 0..3 {
        let r = refined(&scene, Mode::Global(to));
        let mut whole = vec![columns(&grid, 0, 13)];
        for _ in 0..to {
            whole.push(whole.last().unwrap().finer());
        }
        let table = build(&r, Irregular::Gregory);
        for face in &table.faces {
            let level = &r.levels[face.level as usize];
            let spline = &whole[face.level as usize];
            let corner: Vec<glam::DVec2> = level
                .of_face(local(&r, face))
                .map(|h| {
                    let p = level.position(h);
                    let k = spline.value.iter().position(|v| (v.p - p).length() < 1e-9).expect("a point of the grid");
                    glam::DVec2::new((k % spline.width) as f64, (k / spline.width) as f64)
                })
                .collect();
            for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.5, 0.0), (0.0, 0.3), (0.6, 0.8)] {
                let at = corner[0] + (corner[1] - corner[0]) * u + (corner[3] - corner[0]) * v;
                greatest = greatest.max(error(patch_at(&table, face, u, v), spline.limit(at.x, at.y)));
            }
        }
    }
    println!("smooth grid, levels 0 to 2: within {greatest:.1e} of the closed form");
    assert!(greatest < 1e-12 * 6.0, "{greatest:e}");
}

#[test]
fn sharp_colour_edges_and_edits_are_closed_form_splines() {
    let (mut scene, grid, other) = bent_grid(0.3);
    let mesh = mesh::build(&scene.mesh).unwrap();
    let map = IndexMap::new(&mesh);
    // The vertical line x = 2 is sharp from border to border.
    scene.sharp = (0..mesh.half_edges())
        .filter(|&h| {
            let (a, b) = (mesh.origin[h as usize], mesh.target(h));
            a % 5 == 2 && b % 5 == 2 && mesh.twin[h as usize] != mesh::NONE
        })
        .collect();
    assert_eq!(scene.sharp.len(), 6);
    let splines = |first: &Spline, deepest: usize, edit: &dyn Fn(usize, &mut Spline)| {
        let mut all = vec![columns(first, 0, first.width)];
        edit(0, &mut all[0]);
        for l in 1..=deepest {
            let mut next = all.last().unwrap().finer();
            edit(l, &mut next);
            all.push(next);
        }
        all
    };
    let none = |_: usize, _: &mut Spline| {};
    let (left, right) = (splines(&columns(&grid, 0, 7), 2, &none), splines(&columns(&other, 6, 13), 2, &none));
    let (error, patches) = against_splines(&refined(&scene, ADAPTIVE), &splines(&grid, 0, &none), &left, &right);
    println!("sharp line: {patches} patches within {error:.1e} of the closed form");
    assert!(error < 1e-12 * 6.0, "{error:e}");

    // A level-2 edit inside and one at a corner of level 1: found by position in the grid, not by names.
    let plain = splines(&grid, 2, &none);
    for (level, i, j, a, b) in [(2usize, 17usize, 22usize, 0.7, -0.4), (1, 0, 5, 0.3, 0.2), (2, 25, 18, -0.5, 0.6)] {
        let here = &refined(&scene, Mode::Global(level as u32)).levels[level];
        let width = plain[level].width;
        let at = |i: usize, j: usize| plain[level].value[j * width + i].p;
        let h = (0..here.half_edges() as u32)
            .find(|&h| (here.position(h) - at(i, j)).length() < 1e-9)
            .expect("a half-edge that leaves the vertex");
        let (e1, e2) = (here.position(here.next(h)) - at(i, j), here.position(here.prev(h)) - at(i, j));
        let slot = 4 * here.face[here.face_of(h) as usize] + u64::from(h & 3);
        let half_edge = map.to_app_a(level as u32, slot);
        let mut edited = scene.clone();
        let frame = Frame::Sector;
        edited.geometry = vec![GeometryEdit { level: level as u32, half_edge, vertex: None, a, b, frame }];
        let whole = splines(&grid, level, &|l, spline| {
            if l == level {
                spline.value[j * width + i].p += e1 * a + e2 * b;
            }
        });
        let r = refined(&edited, ADAPTIVE);
        assert!(r.levels.len() == level + 1);
        let (error, patches) = against_splines(&r, &whole, &left, &right);
        println!("edit of level {level} at {i}, {j}: {patches} patches within {error:.1e} of the closed form");
        assert!(error < 1e-12 * 6.0, "{error:e}");
    }
}

#[test]
fn gregory_patches_stay_near_the_limit() {
    // One figure for each valence: distance over the length of the face's longer diagonal.
    for (n, most) in [(3, 0.04), (5, 0.04), (6, 0.07), (8, 0.1)] {
        for jitter in [0.0, 0.15] {
            let mut scene = parse(&format!(r#"{{ "gradtess": 1, "builtin": "fan:{n}" }}"#));
            for (i, p) in scene.mesh.positions.iter_mut().enumerate() {
                let t = i as f64 * 2.399;
                *p += jitter * glam::DVec2::new(t.sin(), (1.7 * t).cos());
            }
            let r = refined(&scene, Mode::Global(1));
            let table = build(&r, Irregular::Gregory);
            let acc1 = build(&r, Irregular::Bicubic);
            let (mut greatest, mut rival, mut faces) = (0.0f64, 0.0f64, 0);
            for (i, face) in table.faces.iter().enumerate().filter(|f| f.1.irregular) {
                assert_eq!(face.kind, Kind::Gregory);
                faces += 1;
                let mut exact = ExactFace::new(&r, 1, local(&r, face));
                let corner = |u: f64, v: f64| patch_at(&table, face, u, v).p;
                let diagonal = (corner(1.0, 1.0) - corner(0.0, 0.0)).length();
                let diagonal = diagonal.max((corner(1.0, 0.0) - corner(0.0, 1.0)).length());
                for (u, v) in (0..=16).flat_map(|i| (0..=16).map(move |j| (f64::from(i) / 16.0, f64::from(j) / 16.0))) {
                    let [eu, ev] = unturned(face.turn, u, v);
                    let limit = exact.at(eu, ev).p;
                    greatest = greatest.max((patch_at(&table, face, u, v).p - limit).length() / diagonal);
                    rival = rival.max((patch_at(&acc1, &acc1.faces[i], u, v).p - limit).length() / diagonal);
                }
            }
            println!("valence {n}, jitter {jitter}: {faces} Gregory patches within {:.3} % of the diagonal (bicubics: {:.3} %)", 100.0 * greatest, 100.0 * rival);
            assert!(faces >= n && greatest < most, "valence {n}: {greatest}");
        }
    }
}

#[test]
fn smooth_corners_are_followed_too() {
    let (mut scene, ..) = bent_grid(0.0);
    scene.corners = CornerRule::Smooth;
    println!("{:?}", against_the_limit(&refined(&scene, ADAPTIVE)));
}
