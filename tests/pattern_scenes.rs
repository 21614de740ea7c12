//! Scenes of technique `pattern`: the schema, what bad input becomes, and spoiled documents.

mod gpu_support;
mod json_schema;
mod mutate;

use glam::DVec3;
use gpu_support::with_gpu;
use gradtess::camera::{Camera, Projection};
use gradtess::gpu::{PatternFrame, PatternMethod, PatternScene as Drawn, PatternShow};
use gradtess::pattern::evaluate::evaluate;
use gradtess::pattern::{Control, Detail, Evaluator, RefinementPattern};
use gradtess::scene::pattern::PatternScene;
use json_schema::validate;
use serde_json::{json, Value};
use std::path::Path;

fn schema() -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/schema.json");
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

fn fits(document: &Value, schema: &Value) -> Vec<String> {
    validate(document, schema, schema, "")
}

fn controls(scene: &PatternScene) -> Vec<Control> {
    (0..scene.mesh.triangles.len()).map(|t| Control::new(&scene.mesh, t, scene.evaluator, scene.normal_field)).collect()
}

#[test]
fn the_schema_knows_the_scenes() {
    let schema = schema();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/pattern");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let bytes = std::fs::read(&path).unwrap();
        let document: Value = serde_json::from_slice(&bytes).unwrap();
        assert_eq!(fits(&document, &schema), [""; 0], "{}", path.display());
        let scene = PatternScene::parse(&bytes, &path.display().to_string()).unwrap();
        assert!(!scene.mesh.triangles.is_empty());
        count += 1;
    }
    assert!(count >= 4);
}

#[test]
fn the_schema_refuses_what_the_reader_refuses() {
    let schema = schema();
    let sound = json!({
        "gradtess": 1, "technique": "pattern", "name": "sound", "level": 8, "evaluator": "st", "normal_field": "linear",
        "positions": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.5]], "normals": [[0, 0, 1], [0, 0, 1], [0, 0, 0], [0, 1, 1]],
        "colours": [[1, 0, 0], [0, 1, 0, 0.5], [0, 0, 1], [1, 1, 1]], "uv": [[0, 0], [1, 0], [0, 1], [1, 1]],
        "faces": [[0, 1, 3, 2]],
        "tags": [{ "vertex": 1, "tension": 0.5, "sharpness": 1, "bias": -1, "deviation": [1, 0, 0] }],
        "displacement": { "kind": "noise", "amplitude": 0.1, "frequency": 3, "octaves": 4, "gain": 0.5, "lacunarity": 2, "speed": 1, "time": 0, "seed": 7 }
    });
    let both = |document: &Value| {
        let bytes = document.to_string().into_bytes();
        [fits(document, &schema).is_empty(), PatternScene::parse(&bytes, "x.json").is_ok()]
    };
    assert_eq!(both(&sound), [true; 2]);
    for (pointer, value) in [
        ("/gradtess", json!(2)),
        ("/level", json!(0)),
        ("/level", json!(129)),
        ("/evaluator", json!("spline")),
        ("/normal_field", json!("cubic")),
        ("/positions/0", json!([0, 0])),
        ("/normals/1", json!([0])),
        ("/colours/0", json!([1, 0])),
        ("/uv/2", json!([1, 2, 3])),
        ("/faces", json!([])),
        ("/faces/0", json!([0, 1])),
        ("/faces/0/0", json!(-1)),
        ("/tags/0", json!({ "tension": 1 })),
        ("/tags/0/sharpness", json!(1.5)),
        ("/tags/0/bias", json!(11)),
        ("/tags/0/deviation", json!([1, 0])),
        ("/displacement/kind", json!("waves")),
        ("/displacement/octaves", json!(17)),
        ("/displacement/gain", json!(-1)),
        ("/displacement", json!({ "kind": "sine", "amplitude": 1 })),
        ("/displacement", json!({ "kind": "height", "amplitude": 1 })),
    ] {
        let mut document = sound.clone();
        *document.pointer_mut(pointer).unwrap() = value;
        assert_eq!(both(&document), [false; 2], "{pointer}: {document}");
    }
    let mut unknown = sound;
    unknown["colour"] = json!(1);
    assert_eq!(both(&unknown), [false; 2]);
}

/// OBJ or JSON, and what is said of it: repairs, or the refusal.
const BAD: [(&str, &str, &str); 8] = [
    ("no normals", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "3 of 3 vertices have no normal; it was computed"),
    ("a polygon", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", "1 polygons were cut into triangles"),
    ("no area", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\nf 4 4 4\n", "2 triangles have no area"),
    ("all one point", "v 1 1 1\nf 1 1 1\n", "have no triangle with an area"),
    (
        "two normals at a place",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvn 0 0 1\nvn 0 1 1\nf 1//1 2//1 3//1\nf 2//2 4//2 3//2\n",
        "positions have more than one normal",
    ),
    (
        "three deviations",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nst 1 0 1 0 1 0 0\nst 2 0 1 0 1 0 0\nst 3 0 1 0 1 0 0\n",
        "vertex 2 is the third with a deviation vector",
    ),
    ("two tags", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nst 2 0 1 0 1 0 0\nst 2 0 0 0 0 1 0\n", "tagged twice"),
    (
        "no height map",
        "{\"gradtess\": 1, \"technique\": \"pattern\", \"positions\": [[0,0,0],[1,0,0],[0,1,0]], \"faces\": [[0,1,2]],\n\"displacement\": {\"kind\": \"height\", \"amplitude\": 1, \"file\": \"none.png\"}}",
        "the height map \"none.png\" cannot be read",
    ),
];

#[test]
fn bad_input_is_mended_and_drawn_or_refused_and_both_are_said() {
    with_gpu(|gpu| {
        for (what, text, said) in BAD {
            let scene = match PatternScene::parse(text.as_bytes(), "bad") {
                Err(error) => {
                    assert!(error.to_string().contains(said), "{what}: {error}");
                    continue;
                }
                Ok(scene) => scene,
            };
            let notes = scene.notes.join("\n");
            assert!(notes.contains(said), "{what}: {notes}");
            let controls = controls(&scene);
            let pattern = RefinementPattern::triangle(3).unwrap();
            let bounds = [DVec3::splat(-1.0), DVec3::splat(2.0)];
            for coarse in [None, Some((&scene.mesh, scene.normal_field))] {
                let drawn = Drawn {
                    controls: &controls,
                    evaluator: scene.evaluator,
                    displacement: &scene.displacement,
                    pattern: &pattern,
                    coarse,
                };
                for (method, detail) in [
                    (PatternMethod::Draws, None),
                    (PatternMethod::Instanced, None),
                    (PatternMethod::Static, None),
                    (PatternMethod::Hardware, None),
                    (PatternMethod::Instanced, Some(Detail::default())),
                    (PatternMethod::Indirect, Some(Detail::default())),
                ] {
                    let frame = PatternFrame {
                        width: 32,
                        height: 32,
                        camera: Camera::orbit(bounds, 30.0, 20.0, Projection::Perspective { fov: 30.0 }, 1.0),
                        bounds,
                        show: PatternShow::Shaded,
                        method,
                        detail,
                        background: Some([1.0; 4]),
                        samples: 1,
                    };
                    gpu.prepare_pattern(&drawn, &frame).unwrap().run(true).unwrap();
                    if detail.is_none() {
                        let found = gpu.evaluate_pattern(&drawn, &frame).unwrap();
                        assert!(found.iter().flatten().flatten().all(|x| x.is_finite()), "{what}");
                    }
                }
            }
        }
    });
}

#[test]
fn spoiled_documents_are_read_or_refused_with_their_place() {
    let json = r#"{
  "gradtess": 1, "technique": "pattern", "name": "all", "level": 8, "evaluator": "st", "normal_field": "boubekeur",
  "positions": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.5]], "normals": [[0, 0, 1], [0, 0, 1], [0, 0, 0], [0, 1, 1]],
  "colours": [[1, 0, 0], [0, 1, 0, 0.5], [0, 0, 1], [1, 1, 1]], "uv": [[0, 0], [1, 0], [0, 1], [1, 1]],
  "faces": [[0, 1, 3, 2], [0, 1, 2]],
  "tags": [{ "vertex": 1, "tension": 0.5, "sharpness": 1, "bias": -1, "deviation": [1, 0, 0] }, { "vertex": 2 }],
  "displacement": { "kind": "noise", "amplitude": 0.1, "frequency": 3e0, "octaves": 4, "gain": 0.5, "seed": 7 }
}"#;
    let sine = r#"{ "gradtess": 1, "technique": "pattern", "positions": [[0,0,0],[1,0,0],[0,1,0]], "faces": [[0,1,2]],
  "displacement": { "kind": "sine", "amplitude": 0.1, "frequency": 3 } }"#;
    let obj = "v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.5\nvn 0 0 1\nvt 0 0\nvt 1 0.5\nf 1/1/1 2/2/1 3//1\nf -1 2 3\n\
               st 2 0.5 1 0 0 1 0\nst 3 0 0.5 -1 0 0 0\n";
    mutate::survive("pattern scenes", vec![json.into(), sine.into(), obj.into()], |input| {
        match PatternScene::parse(input, "fuzz") {
            Ok(scene) => {
                for control in controls(&scene).iter().take(100) {
                    for w in [[1.0, 0.0, 0.0], [0.2, 0.3, 0.5], [0.0, 0.5, 0.5]] {
                        for evaluator in [Evaluator::Linear, scene.evaluator] {
                            let point = evaluate(control, evaluator, &scene.displacement, w);
                            assert!(point.position.is_finite() && point.normal.is_normalized(), "{point:?}");
                        }
                    }
                }
                true
            }
            Err(error) => {
                mutate::assert_clear(&error, input);
                false
            }
        }
    });
}
