//! A small fuzz loop over the scene parsers that needs no extra tool.
//!
//! Runs two seconds by default and `GRADTESS_FUZZ_SECONDS` when set, for example
//! `GRADTESS_FUZZ_SECONDS=600 cargo test --test fuzz_parsers -- --nocapture`. Inputs depend on the seed alone; a
//! failure prints the seed and the number of the input, and `GRADTESS_FUZZ_SEED` repeats it.

use gradtess::scene::{native, Scene};
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::time::{Duration, Instant};

mod mutate;

fn variable(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|value| value.parse().ok()).unwrap_or(default)
}

#[test]
fn parsers_survive() {
    let seconds = variable("GRADTESS_FUZZ_SECONDS", 2);
    let seed = variable("GRADTESS_FUZZ_SEED", 1);
    let mut random = mutate::Random::new(seed);
    let mut documents = mutate::documents();
    let kept = documents.len();
    let (start, mut inputs, mut loaded) = (Instant::now(), 0u64, 0u64);
    while start.elapsed() < Duration::from_secs(seconds) {
        let original = random.below(documents.len());
        let input = mutate::spoil(&documents[original], &documents, &mut random);
        let outcome = catch_unwind(AssertUnwindSafe(|| examine(&input)));
        inputs += 1;
        match outcome {
            // Documents that still load are the way to inputs with several faults; a few are enough.
            Ok(true) => {
                loaded += 1;
                let slot = kept + random.below(64);
                if input.len() < 10_000 && slot < documents.len() {
                    documents[slot] = input;
                } else if input.len() < 10_000 {
                    documents.push(input);
                }
            }
            Ok(false) => {}
            Err(_) => panic!("seed {seed}, input {inputs}: {:?}", String::from_utf8_lossy(&input)),
        }
    }
    println!("{inputs} inputs in {seconds} s, {loaded} of them loaded, seed {seed}");
    assert!(loaded > 0 && loaded < inputs);
}

/// Whether `input` loads. What loads has to survive a round trip, what does not has to be explained.
fn examine(input: &[u8]) -> bool {
    match Scene::parse(input, "fuzz") {
        Ok(mut scene) => {
            if scene.mesh.corners.len() > 10_000 {
                return true;
            }
            let again = Scene::parse(native::write(&scene).as_bytes(), "fuzz");
            let mut again = again.unwrap_or_else(|error| panic!("{error}"));
            scene.mesh.face_line.clear();
            again.mesh.face_line.clear();
            assert_eq!(again, scene);
            true
        }
        Err(error) => {
            mutate::assert_clear(&error, input);
            false
        }
    }
}
