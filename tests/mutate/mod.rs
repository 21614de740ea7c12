//! Spoils documents for the parser tests: seeded, so that every failure can be repeated.

use gradtess::scene::SceneError;
pub use gradtess::timing::random::Random;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::time::{Duration, Instant};

/// Small documents in both formats that use every feature.
#[allow(dead_code)] // not every test that spoils documents starts from these
pub fn documents() -> Vec<Vec<u8>> {
    let model = "v -0.5 -0.5\nv 0.5 -0.5 0.25\nv 0.5 0.5\nv -0.5 0.5\nv 0 1.37\ns off\nf 1 2 3 4\nf 4/1 3/2/3 5\n\
                 ve 0 12 4 0.2 0.15 0\nve 0 4 0 0.5 0.05 1\nve 2 48 140 -11580 -1.5e3 0\nce 0 0 0 1 1\nce 1 35 1 1 0\n";
    let json = r#"{
  "$schema": "schema.json", "gradtess": 1, "technique": "subdivision", "name": "all \u00e9 \"kinds\"",
  "corners": "smooth",
  "vertices": [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 2e0]],
  "faces": [[0, 1, 2, 3], [3, 2, 4]],
  "corner_colours": [[1, 0, 0], [0, 1, 0, 0.5], [0, 0, 1], [1, 1, 0], [1, 0, 1], [0, 1, 1], [0.5, 0.5, 0.5]],
  "sharp": [3], "handles": [{ "half_edge": 0, "at": [0.1, 0.7] }], "face_points": [{ "half_edge": 2, "at": [0.7, 0.7] }],
  "geometry": [{ "level": 0, "half_edge": 4, "vertex": 12, "a": 0.2, "b": 0.15 },
               { "level": 1, "half_edge": 3, "a": 0.2, "b": -1.5e-3, "frame": "boundary" }],
  "colour": [{ "level": 2, "half_edge": 144, "colour": [1, 0.5, 0.25] }]
}"#;
    let builtin =
        r#"{ "gradtess": 1, "builtin": "triangle", "vertex_colours": [[0.1, 0.2, 0.3], [1, 0, 0], [0, 1, 0, 0.5]] }"#;
    vec![model.into(), json.into(), builtin.into()]
}

/// Spoils documents for two seconds or `GRADTESS_FUZZ_SECONDS` and gives them to `examine`, which says whether one still
/// loads; those that do are spoiled further. A panic ends it with the input.
#[allow(dead_code)] // not every test that spoils documents goes on for long
pub fn survive(what: &str, mut documents: Vec<Vec<u8>>, examine: impl Fn(&[u8]) -> bool) {
    let variable = |name: &str, default: u64| std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default);
    let (seconds, seed) = (variable("GRADTESS_FUZZ_SECONDS", 2), variable("GRADTESS_FUZZ_SEED", 1));
    let (kept, mut random) = (documents.len(), Random::new(seed));
    let (start, mut inputs, mut loaded) = (Instant::now(), 0u64, 0u64);
    while start.elapsed() < Duration::from_secs(seconds) {
        let input = spoil(&documents[random.below(documents.len())], &documents, &mut random);
        inputs += 1;
        match catch_unwind(AssertUnwindSafe(|| examine(&input))) {
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
    println!("{inputs} {what} in {seconds} s, {loaded} of them loaded, seed {seed}");
    assert!(loaded > 0 && loaded < inputs);
}

/// Pieces that tend to find weak spots: limits of number types, brackets, line ends, keys.
const PIECES: [&str; 30] = [
    "0",
    "-1",
    "1",
    "20",
    "21",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "18446744073709551616",
    "1e39",
    "1e-320",
    "1e999",
    "nan",
    "-inf",
    "0x10",
    "1/2/3",
    "\n",
    "\r\n",
    "\t",
    " ",
    "\"",
    "[",
    "]",
    "{",
    "}",
    ",",
    "null",
    "\nve 0 0 0 0 0 0\n",
    "\nf 1 1 1\n",
    "\"builtin\": \"grid:9999999x9999999\",",
];

/// A copy of `original` with one to four faults; `others` lend pieces.
pub fn spoil(original: &[u8], others: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut bytes = original.to_vec();
    for _ in 0..1 + random.below(4) {
        let at = random.below(bytes.len() + 1);
        let end = (at + random.below(24)).min(bytes.len());
        match random.below(9) {
            0 => bytes.truncate(at),
            1 => drop(bytes.drain(at..end)),
            2 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            3 if at < bytes.len() => bytes[at] = random.bits() as u8,
            4 => {
                let piece = PIECES[random.below(PIECES.len())];
                bytes.splice(at..at, piece.bytes());
            }
            5 | 6 => replace_token(&mut bytes, at, PIECES[random.below(PIECES.len())]),
            7 => {
                let copy = bytes[at..end].to_vec();
                bytes.splice(at..at, copy);
            }
            _ => {
                let other = &others[random.below(others.len())];
                let from = random.below(other.len() + 1);
                let piece = &other[from..(from + random.below(60)).min(other.len())];
                bytes.splice(at..at, piece.iter().copied());
            }
        }
    }
    bytes
}

/// Replaces the number or word around `at`, which reaches deeper than a random byte does.
fn replace_token(bytes: &mut Vec<u8>, at: usize, piece: &str) {
    let inside = |byte: &u8| byte.is_ascii_alphanumeric() || b"+-._".contains(byte);
    let start = bytes[..at].iter().rposition(|b| !inside(b)).map_or(0, |p| p + 1);
    let end = bytes[at..].iter().position(|b| !inside(b)).map_or(bytes.len(), |p| at + p);
    bytes.splice(start..end, piece.bytes());
}

/// A refusal has to be one line with a place inside the document and advice.
pub fn assert_clear(error: &SceneError, document: &[u8]) {
    let text = error.to_string();
    let shown = String::from_utf8_lossy(document);
    let SceneError::Content { line, column, what, fix, .. } = error else { panic!("{text}\n{shown}") };
    assert!(!text.contains(['\n', '\r']) && text.len() < 900, "{text}\n{shown}");
    assert!(!what.is_empty() && !fix.is_empty(), "{text}\n{shown}");
    let lines = document.iter().filter(|&&b| b == b'\n').count() + 1;
    assert!(*line >= 1 && *line <= lines && *column >= 1 && *column <= document.len() + 2, "{text}\n{shown}");
}
