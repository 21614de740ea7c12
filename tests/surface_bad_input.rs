//! Surfaces that are wrong or odd: told with a line number, or drawn; never a panic. `GRADTESS_FUZZ_SECONDS` sets how long
//! spoiled files are tried, 2 s unless given.

mod mutate;

use gradtess::mesh;
use gradtess::scene::surface::SurfaceScene;
use gradtess::surface::adaptive::Depth;
use gradtess::surface::level::{Level, Scheme};
use gradtess::surface::patches::{first_level, patches};
use gradtess::surface::refine::levels;
use gradtess::surface::shade::{limit_positions, shade, Settings};
use gradtess::surface::triangulate::triangulate;
use std::process::Command;
use std::time::{Duration, Instant};

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1.1 0\nv 0 1 0\nv 0 0 1\nv 1 0.2 1\nv 1 1 1.3\nv 0 1 1\nvn 0 0 -1\n\
    f 1//1 4//1 3//1 2//1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf -5 -8 -4 -1\n\
    fs 0 1 2.5 99\nas 2 0 1 0 0\nt crease 5/1/0 0 1 5 4 0 10\nt corner 1/1/0 6 1.5\n";
const OPEN: &str = "v 0 0 0\nv 1 0 1\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 1 2 0\n\
    f 1 2 5 4\nf 2 3 6 5\nf 4 5 7\nf 5 6 7\nt crease 2/1/0 1 4 3\nt interpolateboundary 1/0/0 1\n";

/// Whether `bytes` are a surface. What is one is subdivided and shaded both ways.
fn examine(bytes: &[u8]) -> bool {
    let scene = match SurfaceScene::parse(bytes, "fuzz") {
        Ok(scene) => scene,
        Err(error) => {
            mutate::assert_clear(&error, bytes);
            return false;
        }
    };
    if scene.corners.len() > 200 {
        return true;
    }
    let (triangles, _) = triangulate(&scene);
    let mut drawn = false;
    for (scene, scheme) in [(&scene, Scheme::CatmullClark), (&triangles, Scheme::Loop)] {
        let Ok(mesh) = mesh::build(&scene.polygons()) else { continue };
        let Ok(levels) = levels(scene, &mesh, scheme, 2) else { continue };
        drawn = true;
        let shaded = shade(&levels, &scene.normals, &Settings::default());
        for n in shaded.blended.iter().chain(&shaded.geometric) {
            assert!(n.length() < 1.0 + 1e-9, "{n}");
        }
        assert!(shaded.weight.iter().all(|w| (0.0..=1.0).contains(w)));
        assert!(limit_positions(&levels[2]).iter().all(|p| p.is_finite()));
        let control = Level::new(scene, &mesh, scheme).unwrap();
        if first_level(&control) <= 4 {
            let settings = Settings::default();
            let depth = Depth::adaptive(first_level(&control).max(3), &settings);
            let (_, made) = patches(&control, &scene.normals, &settings, depth);
            assert!((0..made.points() as u32).flat_map(|i| made.control(i)).all(f64::is_finite));
        }
    }
    drawn
}

#[test]
fn two_triangles_back_to_back_have_valence_2_and_finite_patches() {
    assert!(examine(b"v 0 0 0\nv 1 0 1\nv 0 1 0\nf 1 2 3\nf 1 3 2\n"));
}

#[test]
fn spoiled_surfaces_survive() {
    let seconds = std::env::var("GRADTESS_FUZZ_SECONDS").ok().and_then(|s| s.parse().ok()).unwrap_or(2);
    let documents: Vec<Vec<u8>> = vec![CUBE.into(), OPEN.into()];
    assert!(documents.iter().all(|d| examine(d)));
    let mut random = mutate::Random::new(5);
    let (start, mut inputs, mut drawn) = (Instant::now(), 0u64, 0u64);
    while start.elapsed() < Duration::from_secs(seconds) {
        let original = random.below(documents.len());
        let input = mutate::spoil(&documents[original], &documents, &mut random);
        inputs += 1;
        match std::panic::catch_unwind(|| examine(&input)) {
            Ok(good) => drawn += u64::from(good),
            Err(_) => panic!("input {inputs}: {}", String::from_utf8_lossy(&input)),
        }
    }
    println!("{inputs} inputs, {drawn} of them subdivided");
    assert!(drawn > 0 && drawn < inputs);
}

#[test]
fn faults_end_with_status_2_and_a_line() {
    let folder = std::env::temp_dir().join(format!("gradtess-surface-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("bad.obj");
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 0\nf 1 2 3 4\n";
    let cases = [
        ("v 0 0 0\nv 1 0 0\nv 1 1 nan\nf 1 2 3\n".to_string(), ":3:", vec![]),
        (format!("{square}f 1 2 9\n"), ":6:", vec![]),
        (format!("{square}v 5 5 5\n"), ":6:", vec![]),
        (format!("{square}f 1 2 3\n"), ":6:", vec![]),
        (format!("{square}f 1 1 3\n"), ":6:", vec![]),
        (format!("{square}fs -1 0 0 0\n"), ":6:", vec![]),
        (format!("{square}t crease 2/1/0 0 2 1\n"), ":6:", vec![]),
        (square.to_string(), ":5:", vec!["--scheme", "loop"]),
        (square.to_string(), "too many half-edges", vec!["--level", "29"]),
        (square.to_string(), "--power", vec!["--power", "0"]),
    ];
    for (text, place, extra) in cases {
        std::fs::write(&file, &text).unwrap();
        let mut args = vec!["mesh", file.to_str().unwrap()];
        if !extra.contains(&"--level") {
            args.extend(["--level", "1"]);
        }
        args.extend(extra);
        let ran = Command::new(env!("CARGO_BIN_EXE_gradtess")).args(&args).output().unwrap();
        let err = String::from_utf8(ran.stderr).unwrap();
        assert_eq!(ran.status.code(), Some(2), "{args:?} {text}: {err}");
        let place = if place == "too many half-edges" { "half-edges; ask for a lower level" } else { place };
        assert!(err.contains(place) && !err.contains("panicked"), "{text}: {err}");
    }
    let _ = std::fs::remove_dir_all(folder);
}
