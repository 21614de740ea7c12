//! Scene files: exact round trips, and no input that does anything but load or fail with a clear message.

use glam::{DVec2, DVec4};
use gradtess::scene::{
    authors, native, shapes, ColourEdit, CornerRule, Frame, GeometryEdit, Handle, Reference, Scene, SceneError,
};
use gradtess::{mesh::build, subdiv::index_map::IndexMap};
use proptest::prelude::*;
use std::path::{Path, PathBuf};

mod mutate;

/// The models of the authors of ZHHK22, where they are at hand.
fn authors_models() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models/paper");
    let mut found = Vec::new();
    let mut folders = vec![root];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "obj") {
                found.push(path);
            }
        }
    }
    found.sort();
    if found.is_empty() {
        println!("skipped: the authors' models (../shared/models/paper) are not here");
    }
    found
}

/// Source lines differ from file to file; everything else has to be equal.
fn without_lines(mut scene: Scene) -> Scene {
    scene.mesh.face_line.clear();
    scene
}

fn through_native(scene: &Scene) -> Scene {
    let text = native::write(scene);
    Scene::parse(text.as_bytes(), "scene.json").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

#[test]
fn authors_models_survive_both_formats() {
    for path in authors_models() {
        let scene = Scene::load(&path).unwrap();
        assert!(!scene.mesh.positions.is_empty());
        let written = authors::write(&scene).unwrap();
        assert_eq!(written.losses, Vec::<String>::new(), "{}", path.display());
        let name = path.display().to_string();
        let again = Scene::parse(written.text.as_bytes(), &name).unwrap();
        assert_eq!(without_lines(again), without_lines(scene.clone()), "{}", path.display());
        assert_eq!(without_lines(through_native(&scene)), without_lines(scene), "{}", path.display());
    }
}

#[test]
fn authors_models_hold_what_their_lines_say() {
    for path in authors_models() {
        let text = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
        let lines = |token: &str| text.lines().filter(|l| l.split(' ').next() == Some(token)).count();
        let scene = Scene::load(&path).unwrap();
        // None of the published files repeats a key, so nothing is replaced.
        let read =
            [scene.mesh.positions.len(), scene.mesh.face_start.len() - 1, scene.geometry.len(), scene.colours.len()];
        assert_eq!(read, [lines("v"), lines("f"), lines("ve"), lines("ce")], "{}", path.display());
    }
}

/// The scenes of this project.
fn our_scenes() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut found = Vec::new();
    for folder in [root.clone(), root.join("unit")] {
        let entries = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
        found.extend(entries.filter(|p| p.extension().is_some_and(|e| e == "json") && !p.ends_with("schema.json")));
    }
    found.sort();
    assert!(found.len() >= 20, "only {} scenes", found.len());
    found
}

#[test]
fn our_scenes_load_and_survive() {
    for path in our_scenes() {
        let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(without_lines(through_native(&scene)), without_lines(scene), "{}", path.display());
    }
}

/// The vertex numbers that files give are those of the vertices that their half-edges move, and colour edits stand at
/// vertices whose colour may be edited.
#[test]
fn edits_name_the_vertices_they_mean() {
    for path in our_scenes().into_iter().chain(authors_models()) {
        let scene = Scene::load(&path).unwrap();
        let mesh = build(&scene.mesh).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let map = IndexMap::new(&mesh);
        let slot = |level, id| map.from_app_a(level, id).unwrap();
        for edit in &scene.geometry {
            let l = edit.level;
            let ends_in = |id| map.vertex(l, map.next(l, slot(l, id)));
            let moved = match (edit.frame, map.boundary_twin_app_a(l, edit.half_edge)) {
                (Frame::Sector, None) => map.vertex(l, slot(l, edit.half_edge)),
                (Frame::Sector, Some(inside)) => ends_in(inside),
                (Frame::Boundary, _) => {
                    let d = slot(l, edit.half_edge);
                    assert!(map.twin(l, d).is_none(), "{}: {edit:?} is not on the boundary", path.display());
                    ends_in(edit.half_edge)
                }
            };
            assert!(edit.vertex.is_none_or(|v| v == moved), "{}: {edit:?} moves {moved}", path.display());
        }
        for edit in &scene.colours {
            let editable = map.is_colour_vertex(edit.level, slot(edit.level, edit.half_edge));
            assert!(editable, "{}: {edit:?}", path.display());
        }
    }
}

/// The schema and the reader are written apart; every key the reader knows has to stand in the schema and back.
#[test]
fn schema_names_the_keys_of_the_reader() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/schema.json");
    let schema: serde_json::Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let mut known: Vec<&str> =
        schema["$defs"]["subdivision"]["properties"].as_object().unwrap().keys().map(String::as_str).collect();
    let error = Scene::parse(br#"{"gradtess": 1, "?": 0}"#, "x.json").unwrap_err().to_string();
    let mut expected: Vec<&str> = error.split('`').skip(3).step_by(2).collect();
    known.sort_unstable();
    expected.sort_unstable();
    assert_eq!(known, expected, "{error}");
}

#[test]
fn format_is_told_by_content() {
    let model = b"v 0 0\nv 1 0\nv 0 1\nf 1 2 3\n";
    let json = br#" {"gradtess": 1, "builtin": "quad"}"#;
    assert_eq!(Scene::parse(model, "folder/three.json").unwrap().name, "three");
    assert_eq!(Scene::parse(json, "four.obj").unwrap().mesh.positions.len(), 4);
    assert_eq!(Scene::parse(b"\xEF\xBB\xBF{\"gradtess\": 1, \"builtin\": \"quad\"}", "bom").unwrap().name, "bom");
    for (bytes, word) in [
        (&b""[..], "empty"),
        (b"  \n ", "empty"),
        (b"<svg/>", "technique ferguson"),
        (b"\x89PNG\r\n\x1a\n\0\0", "binary"),
        (b"hello", "no face"),
        (b"[1]", "no face"),
    ] {
        let error = Scene::parse(bytes, "x").unwrap_err().to_string();
        assert!(error.starts_with("x:1:1: ") && error.contains(word), "{error}");
    }
}

#[test]
fn saved_files_load_again() {
    let folder = std::env::temp_dir().join(format!("gradtess-scene-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut scene = Scene { name: "q".into(), mesh: shapes::builtin("quad").unwrap(), ..Scene::default() };
    scene.save(folder.join("q.json")).unwrap();
    assert_eq!(without_lines(Scene::load(folder.join("q.json")).unwrap()), scene);
    let losses = scene.save_authors(folder.join("q.obj")).unwrap();
    assert!(losses.len() <= 1, "{losses:?}");
    assert_eq!(Scene::load(folder.join("q.obj")).unwrap().mesh.corners, scene.mesh.corners);
    scene.geometry.push(GeometryEdit { level: 0, half_edge: 0, vertex: None, a: 0.1, b: 0.0, frame: Frame::Sector });
    assert!(matches!(scene.save_authors(folder.join("q.obj")), Err(SceneError::Format { .. })));
    assert!(matches!(Scene::load(folder.join("absent.json")), Err(SceneError::Read { .. })));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn the_documents_that_are_spoiled_are_sound() {
    for document in mutate::documents() {
        Scene::parse(&document, "document").unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn a_thousand_spoiled_models_load_or_explain() {
    let mut documents: Vec<Vec<u8>> = authors_models().iter().map(|p| std::fs::read(p).unwrap()).collect();
    documents.extend(mutate::documents());
    let mut random = mutate::Random::new(0x5eed_0001);
    let (mut loaded, mut refused) = (0, 0);
    for round in 0..1000 {
        let original = &documents[round % documents.len()];
        let spoiled = mutate::spoil(original, &documents, &mut random);
        match Scene::parse(&spoiled, "spoiled") {
            Ok(_) => loaded += 1,
            Err(error) => {
                mutate::assert_clear(&error, &spoiled);
                refused += 1;
            }
        }
    }
    println!("{loaded} loaded, {refused} refused");
    assert!(loaded > 0 && refused > 200, "{loaded} loaded, {refused} refused");
}

#[test]
fn a_deep_document_does_not_overflow_the_stack() {
    let deep = format!("{{\"gradtess\": 1, \"name\": {}", "[".repeat(1_000_000));
    assert!(Scene::parse(deep.as_bytes(), "deep").is_err());
}

fn real() -> impl Strategy<Value = f64> {
    prop_oneof![-100.0..100.0f64, any::<f64>().prop_filter("finite", |v| v.is_finite()), Just(-0.0), Just(1.0 / 3.0)]
}

fn point() -> impl Strategy<Value = DVec2> {
    (real(), real()).prop_map(|(x, y)| DVec2::new(x, y))
}

fn colour() -> impl Strategy<Value = DVec4> {
    (real(), real(), real(), 0.0..=1.0f64).prop_map(|(r, g, b, a)| DVec4::new(r, g, b, a))
}

/// Any scene on a small built-in mesh.
fn scene() -> impl Strategy<Value = Scene> {
    let shapes = vec!["triangle", "hexagon", "grid:2x2", "fan:5", "ring:4"];
    prop::sample::select(shapes).prop_flat_map(|shape| {
        let mesh = shapes::builtin(shape).unwrap();
        let (vertices, half_edges) = (mesh.positions.len(), mesh.corners.len());
        let fine = 9 * half_edges as u64;
        let some = move || prop::collection::btree_set(0..half_edges as u32, 0..half_edges);
        let points = move || prop::collection::btree_map(0..half_edges as u32, point(), 0..half_edges);
        let per_corner = prop::collection::vec(colour(), half_edges);
        let geometry = (0..4u32, any::<bool>(), any::<bool>(), real(), real());
        (
            ("[a-z \"\\\\é\n]{1,12}", any::<bool>()),
            prop::collection::vec(point(), vertices),
            prop::option::of(per_corner),
            (some(), points(), points()),
            prop::collection::btree_map(0..fine, geometry, 0..6),
            prop::collection::btree_map((0..4u32, 0..fine), colour(), 0..6),
        )
            .prop_map(move |((name, smooth), positions, initial, tags, geometry, colours)| {
                let handles = |points: std::collections::BTreeMap<u32, DVec2>| {
                    points.into_iter().map(|(half_edge, at)| Handle { half_edge, at }).collect()
                };
                let mut mesh = mesh.clone();
                mesh.positions = positions;
                let reference = smooth.then(|| Reference {
                    file: name.clone(),
                    rect: [0.1, -2.0, 3.0, 1e-3],
                    opacity: 0.25,
                    locked: mesh.positions.len() % 2 == 0,
                });
                Scene {
                    name,
                    reference,
                    mesh,
                    corners: if smooth { CornerRule::Smooth } else { CornerRule::Sharp },
                    corner_colours: initial.unwrap_or_default(),
                    sharp: tags.0.into_iter().collect(),
                    handles: handles(tags.1),
                    face_points: handles(tags.2),
                    geometry: geometry
                        .into_iter()
                        .map(|(half_edge, (level, known, beyond, a, b))| GeometryEdit {
                            level,
                            half_edge,
                            vertex: known.then_some(half_edge + 7),
                            a,
                            b,
                            frame: if beyond { Frame::Boundary } else { Frame::Sector },
                        })
                        .collect(),
                    colours: colours
                        .into_iter()
                        .map(|((level, half_edge), colour)| ColourEdit { level, half_edge, colour })
                        .collect(),
                    edit_lines: Default::default(),
                }
            })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

    #[test]
    fn any_scene_reads_back_bit_for_bit(scene in scene()) {
        let again = through_native(&scene);
        prop_assert_eq!(native::write(&again), native::write(&scene));
        prop_assert_eq!(without_lines(again), scene);
    }

    #[test]
    fn random_bytes_are_no_crash(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        for head in [&b""[..], b"{\"gradtess\": 1,", b"v 0 0\nv 1 0\nv 0 1\nf 1 2 3\n"] {
            let document = [head, &bytes].concat();
            if let Err(error) = Scene::parse(&document, "random") {
                mutate::assert_clear(&error, &document);
            }
        }
    }

    #[test]
    fn random_lines_are_no_crash(
        lines in prop::collection::vec("(v|f|ve|ce|t|vn)( (-?[0-9]{1,3}(\\.[0-9])?|[0-9]/[0-9]|1e[0-9]{2}|nan|inf)){0,7}", 0..20)
    ) {
        let document = lines.join("\n");
        if let Err(error) = Scene::parse(document.as_bytes(), "lines") {
            mutate::assert_clear(&error, document.as_bytes());
        }
    }
}
