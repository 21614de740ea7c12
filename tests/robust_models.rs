//! A thousand spoiled copies of real models, all the way from bytes to patches: a clear error or a result, never a panic,
//! and neither time nor memory run away. `GRADTESS_MUTANTS` sets how many, `GRADTESS_FUZZ_SEED` which.

mod models;
mod mutate;

use gradtess::mesh;
use gradtess::patch::build::build;
use gradtess::patch::points::Irregular;
use gradtess::refine::{refine, Mode, Options, Rules};
use gradtess::scene::Scene;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::path::Path;
use std::time::{Duration, Instant};

fn variable(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|value| value.parse().ok()).unwrap_or(default)
}

/// The authors' models where they are, else our scenes.
fn originals() -> Vec<Vec<u8>> {
    let (folder, names) = if let Some(models) = models::folder("paper", "originals are the authors' models") {
        let names = vec![
            "Hexagon.obj",
            "Quad_edits.obj",
            "House.obj",
            "bolling/bolling_Subd1.obj",
            "bolling/bolling_Subd3.obj",
            "butterfly/butterfly_Subdi2.obj",
            "cherry/cherry_editAtSubd3.obj",
            "cherry/cherry_editAtSubd5.obj",
            "glass/1/glass2.obj",
        ];
        (models, names)
    } else {
        println!("our scenes instead");
        let ours = vec!["cherry.json", "unit/mixed_polygons.json", "unit/sharp_three_meet.json", "hexagon.json"];
        (Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"), ours)
    };
    names.iter().map(|name| std::fs::read(folder.join(name)).unwrap()).collect()
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum End {
    Parser,
    Mesh,
    Edits,
    Patches,
}

/// As far as a document comes, by both rule sets. Errors have to be one line.
fn run(document: &[u8]) -> End {
    let line = |text: String| assert!(!text.is_empty() && !text.contains('\n') && text.len() < 900, "{text}");
    let scene = match Scene::parse(document, "mutant") {
        Ok(scene) => scene,
        Err(error) => {
            mutate::assert_clear(&error, document);
            return End::Parser;
        }
    };
    let mesh = match mesh::build(&scene.mesh) {
        Ok(mesh) => mesh,
        Err(error) => {
            line(error.to_string());
            return End::Mesh;
        }
    };
    for rules in [Rules::Gradtess, Rules::Authors] {
        match refine(&scene, &mesh, Options { rules, mode: Mode::Adaptive { isolate: 0 } }) {
            Ok(refinement) => {
                let faces: usize = refinement.levels.iter().map(|l| l.faces()).sum();
                for irregular in [Irregular::Gregory, Irregular::Bicubic] {
                    let table = build(&refinement, irregular);
                    assert!(table.faces.len() <= faces && table.control.len() <= 40 * faces + 40);
                    assert!(table.indices.iter().all(|&i| (i as usize) < table.control.len()));
                }
            }
            Err(error) => {
                line(error.to_string());
                return End::Edits;
            }
        }
    }
    End::Patches
}

#[test]
fn a_thousand_spoiled_models_end_in_an_error_or_in_patches() {
    let originals = originals();
    let (mutants, seed) = (variable("GRADTESS_MUTANTS", 1000), variable("GRADTESS_FUZZ_SEED", 1));
    let mut random = mutate::Random::new(seed);
    let mut ends = [0u32; 4];
    let mut slowest = Duration::ZERO;
    let start = Instant::now();
    for number in 0..mutants {
        let mut document = originals[number as usize % originals.len()].clone();
        // One fault in three is a digit: it passes the parser more often and names another half-edge, level or place.
        if number % 3 > 0 {
            for _ in 0..1 + random.below(6) {
                let at = random.below(document.len());
                if let Some(digit) = document[at..].iter().position(u8::is_ascii_digit) {
                    document[at + digit] = b'0' + random.below(10) as u8;
                }
            }
        } else {
            document = mutate::spoil(&document, &originals, &mut random);
        }
        let begun = Instant::now();
        match catch_unwind(AssertUnwindSafe(|| run(&document))) {
            Ok(end) => ends[end as usize] += 1,
            Err(_) => {
                let file = std::env::temp_dir().join(format!("gradtess-mutant-{seed}-{number}"));
                std::fs::write(&file, &document).unwrap();
                panic!("seed {seed}, mutant {number}, kept as {}", file.display());
            }
        }
        slowest = slowest.max(begun.elapsed());
    }
    println!(
        "{mutants} mutants in {:.1} s, the slowest {:.2} s; refused by parser {}, mesh {}, edits {}; drawn {}",
        start.elapsed().as_secs_f64(),
        slowest.as_secs_f64(),
        ends[0],
        ends[1],
        ends[2],
        ends[3]
    );
    assert!(slowest < Duration::from_secs(20), "{slowest:?}");
    assert!(ends[End::Patches as usize] > 0 && ends[End::Parser as usize] > 0);
}

#[test]
fn the_deepest_edits_on_a_large_mesh_cost_what_they_touch() {
    let mut text = String::from(r#"{ "gradtess": 1, "builtin": "grid:60x60", "geometry": ["#);
    for i in 0..20u64 {
        let half_edge = (9 * (4 * (180 * i + 7)) + 3) << 24;
        text += &format!(
            r#"{}{{ "level": 12, "half_edge": {half_edge}, "a": 0.1, "b": 0.1 }}"#,
            if i > 0 { "," } else { "" }
        );
    }
    text += "] }";
    let scene = Scene::parse(text.as_bytes(), "deep").unwrap();
    let mesh = mesh::build(&scene.mesh).unwrap();
    for rules in [Rules::Gradtess, Rules::Authors] {
        let refinement = refine(&scene, &mesh, Options { rules, mode: Mode::Adaptive { isolate: 0 } }).unwrap();
        assert_eq!(refinement.levels.len(), 13);
        let faces: usize = refinement.levels.iter().map(|l| l.faces()).sum();
        println!("{rules:?}: {faces} faces for 20 edits of level 12 over {} faces", mesh.faces());
        // M^0 and some hundred faces for each edit and level.
        assert!(faces < 9 * 3600 + 20 * 12 * 300, "{faces}");
    }
    let whole = refine(&scene, &mesh, Options { rules: Rules::Gradtess, mode: Mode::Global(12) });
    assert!(whole.unwrap_err().to_string().contains("choose a lower level"));
}
