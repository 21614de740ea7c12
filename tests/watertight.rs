//! No cracks: what only one patch has is the boundary of the mesh and nothing else, and no picture of any part of a scene
//! at any tessellation shows background inside.

mod gpu_support;
mod models;
mod random_scene;

use gpu_support::{frame, with_gpu};
use gradtess::check::cracks;
use gradtess::gpu::{Format, Frame, Gpu, Pixels};
use gradtess::mesh::{self, HalfEdgeMesh};
use gradtess::patch::build::{build, face_control};
use gradtess::patch::points::Irregular;
use gradtess::patch::tess::TessRule;
use gradtess::patch::{eval, Face, PatchTable};
use gradtess::refine::forest::first_slot;
use gradtess::refine::{refine, Mode, Options, Rules};
use gradtess::scene::Scene;
use gradtess::subdiv::index_map::IndexMap;
use random_scene::for_random_scenes;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Positions of an edge's four control points as bits.
type Places = [[u64; 2]; 4];

const MODES: [(&str, bool, Irregular); 4] = [
    ("adaptive, Gregory", false, Irregular::Gregory),
    ("adaptive, bicubic", false, Irregular::Bicubic),
    ("global, Gregory", true, Irregular::Gregory),
    ("global, bicubic", true, Irregular::Bicubic),
];

fn with_extension(folder: &Path, extension: &str, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() && !["ferguson", "pattern"].iter().any(|other| path.ends_with(other)) {
            with_extension(&path, extension, found);
        } else if path.extension().is_some_and(|e| e == extension) && !path.ends_with("schema.json") {
            found.push(path);
        }
    }
}

fn all_scenes() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    with_extension(&root.join("scenes"), "json", &mut found);
    if let Some(models) = models::folder("paper", "outlines of the authors' models") {
        with_extension(&models, "obj", &mut found);
    }
    found
}

/// Deepest edit level, at least 1 where M^0 has faces that no patch draws.
fn global_level(scene: &Scene, mesh: &HalfEdgeMesh) -> u32 {
    let edits = scene.geometry.iter().map(|e| e.level).chain(scene.colours.iter().map(|e| e.level));
    edits.max().unwrap_or(0).max(u32::from((0..mesh.faces()).any(|f| mesh.valence(f) != 4)))
}

fn table(scene: &Scene, mesh: &HalfEdgeMesh, global: bool, irregular: Irregular) -> PatchTable {
    let mode = if global { Mode::Global(global_level(scene, mesh)) } else { Mode::Adaptive { isolate: 0 } };
    build(&refine(scene, mesh, Options { rules: Rules::Gradtess, mode }).unwrap(), irregular)
}

/// An edge's key whichever way it runs, and 1 or -1 for its direction; `None` if it is the same both ways.
fn key(places: Places) -> Option<(Places, i32)> {
    let mut back = places;
    back.reverse();
    match places.cmp(&back) {
        std::cmp::Ordering::Less => Some((places, 1)),
        std::cmp::Ordering::Equal => None,
        std::cmp::Ordering::Greater => Some((back, -1)),
    }
}

/// Sums up directions; what is left open has a sum other than 0.
fn open(edges: impl Iterator<Item = (Places, u32)>) -> HashMap<(Places, u32), i32> {
    let mut sums = HashMap::new();
    for (places, level) in edges {
        if let Some((key, sign)) = key(places) {
            *sums.entry((key, level)).or_insert(0) += sign;
        }
    }
    sums.retain(|_, sum| *sum != 0);
    sums
}

/// Edges of drawn faces that lie on the boundary of the mesh, by names alone, with their levels.
fn boundary<'a>(table: &'a PatchTable, map: &'a IndexMap) -> impl Iterator<Item = (Places, u32)> + 'a {
    let edges_of = move |face: &'a Face| {
        let points = face_control(table, face);
        let mut d = first_slot(map, face.level, face.name);
        for _ in 0..face.turn {
            d = map.next(face.level, d);
        }
        let mut found = Vec::new();
        for (i, edge) in eval::FACE_EDGES.into_iter().enumerate() {
            if map.twin(face.level, d).is_none() {
                assert!(face.transition >> i & 1 == 0);
                found.push((edge.map(|k| [0, 1].map(|c| points[k][c].to_bits())), face.level));
            }
            d = map.next(face.level, d);
        }
        found
    };
    table.faces.iter().flat_map(edges_of)
}

/// Checks one table; returns boundary edges and all faces.
fn closed(table: &PatchTable, mesh: &HalfEdgeMesh) -> (usize, usize) {
    let map = IndexMap::new(mesh);
    let outline = cracks::outline(table);
    let found = open(outline.iter().map(|e| (e.points.map(|p| [p.x.to_bits(), p.y.to_bits()]), e.level)));
    let wanted = open(boundary(table, &map));
    let extra: Vec<_> = found.iter().filter(|(k, sum)| wanted.get(k) != Some(sum)).take(3).collect();
    let missing: Vec<_> = wanted.iter().filter(|(k, sum)| found.get(k) != Some(sum)).take(3).collect();
    assert!(extra.is_empty() && missing.is_empty(), "extra {extra:?}, missing {missing:?}");
    assert_eq!(outline.len(), wanted.values().map(|s| s.unsigned_abs() as usize).sum::<usize>());
    (outline.len(), table.faces.len())
}

#[test]
fn the_outline_of_every_scene_is_its_boundary_in_all_modes() {
    for path in all_scenes() {
        let scene = Scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
        let mesh = mesh::build(&scene.mesh).unwrap();
        let mut line = String::new();
        for (name, global, irregular) in MODES {
            // The deepest global meshes take a while; one kind of patches is enough there.
            if global && irregular == Irregular::Bicubic && global_level(&scene, &mesh) > 3 {
                continue;
            }
            let (edges, faces) = closed(&table(&scene, &mesh, global, irregular), &mesh);
            line += &format!("; {name}: {edges} edges of {faces} faces");
        }
        println!("{}{line}", path.file_stem().unwrap().to_string_lossy());
    }
}

#[test]
fn the_outline_of_random_scenes_is_their_boundary_in_all_modes() {
    for_random_scenes(100, |scene, mesh| {
        for (_, global, irregular) in MODES {
            closed(&table(scene, mesh, global, irregular), mesh);
        }
    });
}

#[test]
fn interior_edges_have_one_colour_unless_they_are_sharp() {
    for_random_scenes(60, |scene, mesh| {
        let refinement = refine(scene, mesh, Options::default()).unwrap();
        if refinement.levels.iter().any(|l| !l.sharp.is_empty()) {
            return;
        }
        let table = build(&refinement, Irregular::Gregory);
        let mut seen: HashMap<Places, Vec<[u64; 8]>> = HashMap::new();
        for range in table.ranges.iter() {
            for patch in
                table.indices[range.first as usize..][..range.count as usize * range.stride()].chunks(range.stride())
            {
                for side in 0..eval::sides(range.part) {
                    let Some(q) = eval::side_points(range.kind, range.part, side) else { continue };
                    let mut points = q.map(|i| table.control[patch[i] as usize].map(f64::to_bits));
                    let places = points.map(|p| [p[0], p[1]]);
                    let Some((key, sign)) = key(places) else { continue };
                    if sign < 0 {
                        points.reverse();
                    }
                    let other = seen.entry(key).or_insert_with(|| points.to_vec());
                    assert_eq!(other[..], points[..]);
                }
            }
        }
    });
}

/// Draws parts of a table at random and counts pixels inside and pixels of background among them. Levels go from 1 to 64,
/// or as far as `vertices` in a picture allow.
fn look(gpu: &Gpu, table: &PatchTable, zooms: u32, vertices: f64, random: &mut gpu_support::Random) -> (usize, usize) {
    let outline = cracks::outline(table);
    let ends = || outline.iter().flat_map(|e| e.points);
    let (low, high) = (ends().reduce(|a, b| a.min(b)).unwrap(), ends().reduce(|a, b| a.max(b)).unwrap());
    let uploaded = gpu.upload(table).unwrap();
    let most = (vertices / table.faces.len() as f64).sqrt().clamp(2.0, 65.0);
    let (mut inside, mut cracks) = (0, 0);
    for zoom in 0..=zooms {
        let magnified = if zoom == 0 { 1.0 } else { 1000f64.powf(random.next()) };
        let half = 0.5 * (high - low).max_element() / magnified;
        let centre = low + (high - low) * glam::DVec2::new(random.next(), random.next());
        let view = [centre.x - half, centre.y - half, centre.x + half, centre.y + half];
        let level = (most.powf(random.next()) as u32).clamp(1, 64);
        let tess = TessRule::Fixed(level as f32);
        let frame = Frame { view, tess, format: Format::Rgba32f, ..frame(256) };
        let Pixels::Rgba32f(pixels) = gpu.render(&uploaded, &frame).unwrap().pixels else { unreachable!() };
        let covered: Vec<bool> = pixels.chunks_exact(4).map(|p| p[3] > 0.0).collect();
        let segments = cracks::segments(&outline, tess, 64.0, view, [256; 2]);
        inside += cracks::winding(&segments, 256, 256).iter().filter(|&&n| n != 0).count();
        let found = cracks::find(&segments, &covered, 256, 256);
        assert!(found.is_empty(), "level {level}, view {view:?}: {} pixels, {:?}", found.len(), found[0]);
        cracks += found.len();
    }
    (inside, cracks)
}

#[test]
fn pictures_of_scenes_have_no_background_inside() {
    // GRADTESS_ZOOMS for a longer look; `gradtess check --random-tess` does the same with any scene.
    let asked = std::env::var("GRADTESS_ZOOMS").ok().and_then(|v| v.parse().ok());
    let (zooms, vertices) = (asked.unwrap_or(5), if asked.is_some() { f64::INFINITY } else { 5e5 });
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    with_gpu(|gpu| {
        let mut random = gpu_support::Random::new(3);
        for name in ["hexagon", "cherry", "unit/hole", "unit/concave_face", "unit/geometry_level_2", "unit/sharp_dart"]
        {
            let scene = Scene::load(root.join(format!("scenes/{name}.json"))).unwrap();
            let mesh = mesh::build(&scene.mesh).unwrap();
            for (mode, global, irregular) in MODES {
                if global && global_level(&scene, &mesh) > 2 {
                    continue;
                }
                let (inside, cracks) =
                    look(gpu, &table(&scene, &mesh, global, irregular), zooms, vertices, &mut random);
                println!("{name}, {mode}: {} views, {inside} pixels inside, {cracks} of them background", zooms + 1);
            }
        }
    });
}

#[test]
fn draws_of_more_than_65536_vertices_lose_nothing_where_they_are_clipped() {
    with_gpu(|gpu| {
        let scene = Scene::parse(br#"{ "gradtess": 1, "builtin": "grid:3x2" }"#, "grid").unwrap();
        let mesh = mesh::build(&scene.mesh).unwrap();
        let table = table(&scene, &mesh, false, Irregular::Gregory);
        assert_eq!(table.faces.len(), 54);
        let uploaded = gpu.upload(&table).unwrap();
        let outline = cracks::outline(&table);
        let centre = outline.iter().map(|e| e.points[0]).sum::<glam::DVec2>() / outline.len() as f64;
        for level in [36, 45, 64] {
            let view = [centre.x - 0.05, centre.y - 0.05, centre.x + 0.05, centre.y + 0.05];
            let frame = Frame { view, tess: TessRule::Fixed(level as f32), ..frame(64) };
            let picture = gpu.render(&uploaded, &frame).unwrap().pixels.into_picture(64, 64);
            let covered = picture.rgba.chunks_exact(4).filter(|p| p[3] > 0).count();
            assert_eq!(covered, 64 * 64, "level {level}");
        }
    });
}
