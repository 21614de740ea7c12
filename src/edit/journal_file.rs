//! A journal on the disk: lines that are only appended, so that a crash spoils the last one at worst.
//!
//! It lies beside its scene (`.NAME.PID.N.gradtess-journal`) or, without a scene's folder that can be written to, in the
//! state folder, is locked as long as its session lives, and goes when the scene is saved or given up. What the lines say
//! is up to [`super::journal`] and [`super::gradient::journal`].

use serde::Serialize;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};

/// Name of journals: `.NAME.PID.N.gradtess-journal`.
const EXTENSION: &str = "gradtess-journal";

/// An open journal.
#[derive(Debug)]
pub struct JournalFile {
    path: PathBuf,
    file: File,
}

impl JournalFile {
    /// Makes an empty journal beside `scene`, or in `state` where there is no scene file or its folder cannot be written
    /// to.
    ///
    /// # Errors
    /// Neither folder can be written to.
    pub fn create(scene: Option<&Path>, state: Option<&Path>) -> std::io::Result<JournalFile> {
        let name = name_of(scene);
        let beside = scene.map(folder_of);
        let mut failed = std::io::Error::new(std::io::ErrorKind::NotFound, "there is no folder for the journal");
        for folder in beside.as_deref().into_iter().chain(state) {
            if Some(folder) == state {
                let _ = std::fs::create_dir_all(folder);
            }
            for n in 0..100 {
                let path = folder.join(format!(".{name}.{}.{n}.{EXTENSION}", std::process::id()));
                match OpenOptions::new().append(true).create_new(true).open(&path) {
                    Ok(file) => {
                        lock(&file);
                        return Ok(JournalFile { path, file });
                    }
                    Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => {}
                    Err(e) => {
                        failed = e;
                        break;
                    }
                }
            }
        }
        Err(failed)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Adds lines, which are on the disk when this returns.
    ///
    /// # Errors
    /// The disk is full or gone.
    pub fn append(&mut self, lines: &[impl Serialize]) -> std::io::Result<()> {
        let mut text = Vec::new();
        for line in lines {
            serde_json::to_writer(&mut text, line).map_err(std::io::Error::other)?;
            text.push(b'\n');
        }
        self.file.write_all(&text)?;
        self.file.sync_data()
    }

    /// Removes it.
    pub fn end(self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

fn name_of(scene: Option<&Path>) -> String {
    scene.and_then(Path::file_name).map_or("untitled".into(), |n| n.to_string_lossy().into_owned())
}

fn folder_of(file: &Path) -> PathBuf {
    match file.parent() {
        Some(folder) if folder != Path::new("") => folder.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

/// Holds the file for this process; the system lets go of it however the process ends.
fn lock(file: &File) -> bool {
    rustix::fs::flock(file, rustix::fs::FlockOperation::NonBlockingLockExclusive).is_ok()
}

/// Journals that sessions which no longer run have left beside `file`, or in `state` for scenes without one; the newest
/// first.
pub fn left_behind(file: Option<&Path>, state: Option<&Path>) -> Vec<PathBuf> {
    let start = format!(".{}.", name_of(file));
    let mut found = Vec::new();
    for folder in file.map(folder_of).into_iter().chain(state.map(Path::to_path_buf)) {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            let ours = path.extension().is_some_and(|e| e == EXTENSION)
                && entry.file_name().to_string_lossy().starts_with(&start);
            if ours && File::open(&path).is_ok_and(|f| lock(&f)) {
                let time = entry.metadata().and_then(|m| m.modified()).ok();
                found.push((time, path));
            }
        }
    }
    found.sort();
    found.into_iter().rev().map(|(_, path)| path).collect()
}

/// The lines of a journal as far as they can be read.
///
/// # Errors
/// What is wrong, in one line.
pub fn lines(path: &Path) -> Result<impl Iterator<Item = Vec<u8>>, String> {
    let file = File::open(path).map_err(|e| fault(path, format_args!("the journal cannot be read ({e})")))?;
    Ok(BufReader::new(file.take(crate::scene::LARGEST_FILE)).split(b'\n').map_while(Result::ok))
}

/// A message on a journal that cannot be used.
pub fn fault(path: &Path, what: impl std::fmt::Display) -> String {
    format!("{}: {what}; remove it if it is of no use", path.display())
}
