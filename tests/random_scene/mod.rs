//! Random scenes for property tests: manifold polygon meshes with holes and several components, and edits of every
//! sort. A [`Recipe`] is plain numbers that all mean something, so that proptest can shrink it.
#![allow(dead_code)] // each test file uses its own part

use glam::{DVec2, DVec4};
use gradtess::mesh::{self, HalfEdgeMesh};
use gradtess::scene::{ColourEdit, CornerRule, Frame, GeometryEdit, Handle, InputMesh, Scene};
use gradtess::subdiv::index_map::{IndexMap, Slot};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};
use std::collections::HashSet;
use std::f64::consts::{PI, TAU};

/// Deepest edit level of a recipe.
pub const DEEPEST: u32 = 3;

/// One component before anything is merged or removed.
#[derive(Clone, Copy, Debug)]
pub enum Piece {
    /// Squares.
    Grid(u32, u32),
    /// Quads around a vertex.
    Fan(u32),
    /// Triangles around a vertex.
    Umbrella(u32),
}

/// A geometry or colour edit before it has found its half-edge.
#[derive(Clone, Copy, Debug)]
pub struct EditRecipe {
    level: u32,
    pick: u32,
    sort: u32,
    a: f64,
    b: f64,
}

/// How a random scene is made.
#[derive(Clone, Debug)]
pub struct Recipe {
    pieces: Vec<Piece>,
    /// Edges to dissolve, faces to cut in two, faces to remove.
    changes: Vec<(u8, u32)>,
    jitter: u32,
    clockwise: bool,
    smooth_corners: bool,
    /// 0: white; 1: all corners of a vertex alike; 2: every corner its own.
    colours: u32,
    sharp: Vec<u32>,
    handles: Vec<(u32, f64, f64)>,
    moves: Vec<EditRecipe>,
    paints: Vec<EditRecipe>,
}

fn edits(most: usize) -> impl Strategy<Value = Vec<EditRecipe>> {
    let one = (0..=DEEPEST, any::<u32>(), 0..8u32, -0.4..0.4f64, -0.4..0.4f64);
    prop::collection::vec(one.prop_map(|(level, pick, sort, a, b)| EditRecipe { level, pick, sort, a, b }), 0..=most)
}

/// All recipes.
pub fn recipe() -> impl Strategy<Value = Recipe> {
    let piece = prop_oneof![
        (1..=3u32, 1..=2u32).prop_map(|(w, h)| Piece::Grid(w, h)),
        (3..=6u32).prop_map(Piece::Fan),
        (3..=7u32).prop_map(Piece::Umbrella),
    ];
    let mesh = (
        prop::collection::vec(piece, 1..=2),
        prop::collection::vec((0..4u8, any::<u32>()), 0..=4),
        0..1000u32,
        any::<bool>(),
        prop::bool::weighted(0.2),
    );
    let colour = (0..3u32, prop::collection::vec(any::<u32>(), 0..=3));
    let handles = prop::collection::vec((any::<u32>(), -0.1..0.1f64, -0.1..0.1f64), 0..=2);
    (mesh, colour, handles, edits(3), edits(4)).prop_map(|(mesh, (colours, sharp), handles, moves, paints)| {
        let (pieces, changes, jitter, clockwise, smooth_corners) = mesh;
        Recipe { pieces, changes, jitter, clockwise, smooth_corners, colours, sharp, handles, moves, paints }
    })
}

/// Runs a property over recipes, the same ones every time. `GRADTESS_CASES` sets how many, `GRADTESS_SEED` which.
pub fn for_random_scenes(cases: u32, property: impl Fn(&Scene, &HalfEdgeMesh)) {
    let variable = |name: &str| std::env::var(name).ok().and_then(|value| value.parse::<u32>().ok());
    let cases = variable("GRADTESS_CASES").unwrap_or(cases);
    let mut seed = [7u8; 32];
    seed[..4].copy_from_slice(&variable("GRADTESS_SEED").unwrap_or(1).to_le_bytes());
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &seed);
    let config = Config { cases, failure_persistence: None, max_shrink_iters: 3000, ..Config::default() };
    let result = TestRunner::new_with_rng(config, rng).run(&recipe(), |recipe| {
        let scene = scene(&recipe);
        let mesh = mesh::build(&scene.mesh).unwrap();
        let run = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| property(&scene, &mesh)));
        run.map_err(|panic| {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(|s| s.to_string()));
            TestCaseError::fail(text.unwrap_or_default())
        })
    });
    if let Err(failure) = result {
        if let proptest::test_runner::TestError::Fail(_, recipe) = &failure {
            println!("{}", gradtess::scene::native::write(&scene(recipe)));
        }
        panic!("{failure}");
    }
    println!("{cases} random scenes");
}

fn hash(x: u64) -> u64 {
    let mut z = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

fn unit(x: u64) -> f64 {
    (hash(x) >> 11) as f64 / (1u64 << 53) as f64
}

/// Four colours, so that different draws often agree.
fn colour(i: u64) -> DVec4 {
    [
        DVec4::new(0.9, 0.2, 0.1, 1.0),
        DVec4::new(0.1, 0.7, 0.3, 1.0),
        DVec4::new(0.2, 0.3, 0.8, 0.5),
        DVec4::new(1.0, 1.0, 0.6, 1.0),
    ][(hash(i) % 4) as usize]
}

/// The scene of a recipe.
pub fn scene(recipe: &Recipe) -> Scene {
    let (points, faces) = polygons(recipe);
    let input = input(&points, &faces, recipe);
    let mesh = mesh::build(&input).expect("a manifold");
    let map = IndexMap::new(&mesh);
    let corners = if recipe.smooth_corners { CornerRule::Smooth } else { CornerRule::Sharp };
    let mut scene = Scene { name: "random".into(), mesh: input, corners, ..Scene::default() };
    let s = u64::from(mesh.half_edges());
    if recipe.colours > 0 {
        scene.corner_colours = (0..s as usize)
            .map(|h| colour(if recipe.colours == 1 { u64::from(mesh.origin[h]) } else { h as u64 + 1000 }))
            .collect();
    }
    scene.sharp = recipe.sharp.iter().map(|x| x % s as u32).collect();
    scene.sharp.sort_unstable();
    scene.sharp.dedup();
    let mut taken = HashSet::new();
    for &(pick, x, y) in &recipe.handles {
        let half_edge = pick % s as u32;
        if taken.insert(half_edge) {
            let third = (2.0 * mesh.positions[mesh.origin[half_edge as usize] as usize]
                + mesh.positions[mesh.target(half_edge) as usize])
                / 3.0;
            scene.handles.push(Handle { half_edge, at: third + DVec2::new(x, y) });
        }
    }
    add_moves(&mut scene, &map, &recipe.moves);
    add_paints(&mut scene, &map, &recipe.paints);
    scene
}

fn add_moves(scene: &mut Scene, map: &IndexMap, moves: &[EditRecipe]) {
    let mut taken = HashSet::new();
    for m in moves {
        let boundary = map.boundary_half_edges(m.level);
        // Sorts 0 and 1 lie on the boundary, in either form.
        let on_boundary = m.sort < 2 && boundary > 0;
        let number = map.half_edges(m.level) + hash(u64::from(m.pick)) % boundary.max(1);
        let (half_edge, frame) = match m.sort {
            0 if on_boundary => (number, Frame::Sector),
            1 if on_boundary => (map.boundary_twin_app_a(m.level, number).unwrap(), Frame::Boundary),
            _ => (hash(u64::from(m.pick)) % map.half_edges(m.level), Frame::Sector),
        };
        let slot = match map.from_app_a(m.level, half_edge) {
            Some(d) if !on_boundary => d,
            _ => {
                let twin = map.boundary_twin_app_a(m.level, number).unwrap();
                map.next(m.level, map.from_app_a(m.level, twin).unwrap())
            }
        };
        if taken.insert((m.level, map.vertex(m.level, slot))) {
            let b = if frame == Frame::Boundary { m.b.abs() } else { m.b };
            scene.geometry.push(GeometryEdit { level: m.level, half_edge, vertex: None, a: m.a, b, frame });
        }
    }
}

fn add_paints(scene: &mut Scene, map: &IndexMap, paints: &[EditRecipe]) {
    let mut taken = HashSet::new();
    let mut last: Option<(u32, Slot)> = None;
    for p in paints {
        let level = p.level;
        let mut slot = hash(u64::from(p.pick)) % map.half_edges(level);
        while !map.is_colour_vertex(level, slot) {
            slot = (slot + 1) % map.half_edges(level);
        }
        // Sorts 5 to 7: the vertex of the edit before, at this level if it has it already.
        if let Some((coarse, d)) = last.filter(|l| p.sort >= 5 && l.0 <= level) {
            slot = d << (2 * (level - coarse));
        }
        last = Some((level, slot));
        let mut sectors = Vec::new();
        map.around(level, slot, |d| sectors.push(d));
        let keep = match p.sort % 5 {
            0 | 1 => 1,
            2 => 2,
            _ => sectors.len(),
        };
        let turn = p.pick as usize % keep % sectors.len();
        sectors.rotate_left(turn);
        for (i, &d) in sectors.iter().take(keep).enumerate() {
            let own = u64::from(p.pick) + if p.sort % 5 == 4 { i as u64 } else { 0 };
            if taken.insert((level, d)) {
                let half_edge = map.to_app_a(level, d);
                scene.colours.push(ColourEdit { level, half_edge, colour: colour(own) });
            }
        }
    }
}

fn input(points: &[DVec2], faces: &[Vec<u32>], recipe: &Recipe) -> InputMesh {
    let mut number = vec![u32::MAX; points.len()];
    let mut mesh = InputMesh { face_start: vec![0], ..InputMesh::default() };
    for face in faces {
        let mut corners = Vec::new();
        for &v in face {
            if number[v as usize] == u32::MAX {
                number[v as usize] = mesh.positions.len() as u32;
                let seed = u64::from(recipe.jitter) << 32 | u64::from(v);
                let shake = DVec2::new(unit(seed) - 0.5, unit(seed ^ 0xabcd_ef00) - 0.5);
                mesh.positions.push(points[v as usize] + 0.3 * shake);
            }
            corners.push(number[v as usize]);
        }
        if recipe.clockwise {
            corners.reverse();
        }
        mesh.corners.extend(corners);
        mesh.face_start.push(mesh.corners.len() as u32);
    }
    mesh
}

fn polygons(recipe: &Recipe) -> (Vec<DVec2>, Vec<Vec<u32>>) {
    let mut points: Vec<DVec2> = Vec::new();
    let mut faces = Vec::new();
    for (i, &piece) in recipe.pieces.iter().enumerate() {
        let first = points.len() as u32;
        let place = DVec2::new(5.0 * i as f64, 0.0);
        match piece {
            Piece::Grid(w, h) => {
                for y in 0..=h {
                    points.extend((0..=w).map(|x| place + DVec2::new(f64::from(x), f64::from(y))));
                }
                for (y, x) in (0..h).flat_map(|y| (0..w).map(move |x| (y, x))) {
                    let v = first + y * (w + 1) + x;
                    faces.push(vec![v, v + 1, v + w + 2, v + w + 1]);
                }
            }
            Piece::Fan(n) => {
                points.push(place);
                points.extend((0..2 * n).map(|k| place + DVec2::from_angle(f64::from(k) * PI / f64::from(n))));
                for k in 0..n {
                    let at = |i: u32| first + 1 + (2 * k + i) % (2 * n);
                    faces.push(vec![first, at(0), at(1), at(2)]);
                }
            }
            Piece::Umbrella(n) => {
                points.push(place);
                points.extend((0..n).map(|k| place + DVec2::from_angle(f64::from(k) * TAU / f64::from(n))));
                faces.extend((0..n).map(|k| vec![first, first + 1 + k, first + 1 + (k + 1) % n]));
            }
        }
    }
    for &(what, pick) in &recipe.changes {
        let mut changed = faces.clone();
        let f = pick as usize % faces.len();
        match what {
            0 | 1 => dissolve(&mut changed, f, (pick >> 8) as usize),
            2 => cut(&mut changed, f),
            _ if faces.len() > 1 => drop(changed.remove(f)),
            _ => {}
        }
        if mesh::build(&input(&points, &changed, recipe)).is_ok() {
            faces = changed;
        }
    }
    (points, faces)
}

/// Merges face `f` with its neighbour across edge `e`, when they share no other vertex than the edge's.
fn dissolve(faces: &mut Vec<Vec<u32>>, f: usize, e: usize) {
    let n = faces[f].len();
    let (a, b) = (faces[f][e % n], faces[f][(e + 1) % n]);
    let runs_back = |face: &Vec<u32>| (0..face.len()).position(|i| face[i] == b && face[(i + 1) % face.len()] == a);
    let Some((g, i)) = faces.iter().enumerate().find_map(|(g, face)| runs_back(face).map(|i| (g, i))) else { return };
    let shared = faces[f].iter().filter(|v| faces[g].contains(v)).count();
    if g == f || shared != 2 || n + faces[g].len() > 11 {
        return;
    }
    let m = faces[g].len();
    let mut merged: Vec<u32> = (0..n).map(|k| faces[f][(e + 1 + k) % n]).collect();
    merged.extend((2..m).map(|k| faces[g][(i + k) % m]));
    faces[f] = merged;
    faces.remove(g);
}

/// Cuts a face in two along a diagonal.
fn cut(faces: &mut Vec<Vec<u32>>, f: usize) {
    let n = faces[f].len();
    if n > 3 {
        let half = n / 2;
        let second = (half..=n).map(|k| faces[f][k % n]).collect();
        faces[f].truncate(half + 1);
        faces.push(second);
    }
}
