//! A small fuzz loop over the scene parsers that needs no extra tool.
//!
//! Runs two seconds by default and `GRADTESS_FUZZ_SECONDS` when set, for example
//! `GRADTESS_FUZZ_SECONDS=600 cargo test --test fuzz_parsers -- --nocapture`. Inputs depend on the seed alone; a
//! failure prints the seed and the number of the input, and `GRADTESS_FUZZ_SEED` repeats it.

use gradtess::scene::{native, Scene};

mod mutate;

#[test]
fn parsers_survive() {
    mutate::survive("inputs", mutate::documents(), examine);
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
