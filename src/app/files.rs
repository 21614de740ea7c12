//! Files that belong to no scene: where state is kept, and what was opened lately.

use std::path::{Path, PathBuf};

/// Folder for state: `$XDG_STATE_HOME/gradtess`, or `~/.local/state/gradtess`.
pub fn state_folder() -> Option<PathBuf> {
    let set = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let base = set("XDG_STATE_HOME").filter(|p| p.is_absolute());
    base.or_else(|| set("HOME").map(|home| home.join(".local/state"))).map(|base| base.join("gradtess"))
}

/// Files opened lately, the last first; those that are gone are left out.
pub fn recent(state: Option<&Path>) -> Vec<PathBuf> {
    let Some(state) = state else { return Vec::new() };
    let text = std::fs::read_to_string(state.join("recent.json")).unwrap_or_default();
    let all: Vec<PathBuf> = serde_json::from_str(&text).unwrap_or_default();
    all.into_iter().filter(|f| f.is_file()).collect()
}

/// Keeps the list. That it cannot be kept is no matter.
pub fn write_recent(state: Option<&Path>, files: &[PathBuf]) {
    let Some(state) = state else { return };
    if let Ok(text) = serde_json::to_vec(files) {
        let _ = std::fs::create_dir_all(state);
        let _ = crate::scene::write_atomically(&state.join("recent.json"), &text);
    }
}

/// What a folder holds: folders first, then files with one of the extensions, by name.
pub fn list(folder: &Path, extensions: &[&str]) -> (Vec<String>, Vec<String>) {
    let (mut folders, mut files) = (vec!["..".to_owned()], Vec::new());
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with('.') {
            continue;
        }
        let path = entry.path();
        if path.is_dir() {
            folders.push(name);
        } else if path.extension().is_some_and(|e| extensions.iter().any(|x| e.eq_ignore_ascii_case(x))) {
            files.push(name);
        }
    }
    folders.sort();
    files.sort();
    (folders, files)
}
