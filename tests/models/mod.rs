//! Where the models made by others are, beside the project.

use std::path::{Path, PathBuf};

/// The folder of `kind` ("paper", "surface", "svg"), or `None` after saying that `test` goes without it.
pub fn folder(kind: &str, test: &str) -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models").join(kind);
    if folder.is_dir() {
        return Some(folder);
    }
    println!("{test}: skipped, the models of {kind} are not here");
    None
}
