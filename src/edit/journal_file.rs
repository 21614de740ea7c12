//! A journal on the disk: lines that are only appended, so that a crash spoils the last one at worst.
//!
//! It lies beside its scene (`.NAME.PID.N.gradtess-journal`) or, without a scene's folder that can be written to, in the
//! state folder, is locked as long as its session lives, and goes when the scene is saved or given up. What the lines say
//! is up to [`super::journal`] and [`super::gradient::journal`].

use serde::Serialize;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

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

/// How often a gesture that goes on is written.
pub const LIVE: Duration = Duration::from_millis(400);

/// The journal of a session, which begins with the first step: lines `L` of what was done, and while a gesture goes on now
/// and then one of what it does, told by a `G`.
pub struct Keeper<L, G> {
    file: Option<JournalFile>,
    /// What has still to go to the disk.
    waiting: Vec<L>,
    /// When the gesture that goes on was written last, and as what.
    live: Option<(Instant, Option<G>)>,
}

impl<L, G> Default for Keeper<L, G> {
    fn default() -> Self {
        Keeper { file: None, waiting: Vec::new(), live: None }
    }
}

impl<L: Serialize, G: Copy + PartialEq> Keeper<L, G> {
    /// A step was made: the end of a gesture, if one went on.
    pub fn step(&mut self, line: L) {
        self.live = None;
        self.waiting.push(line);
    }

    /// A step was undone or done again.
    pub fn moved(&mut self, line: L) {
        self.waiting.push(line);
    }

    /// A gesture came to nothing; `line` is needed if something of it was written.
    pub fn gave_up(&mut self, line: L) {
        if self.live.take().is_some_and(|(_, written)| written.is_some()) {
            self.waiting.push(line);
        }
    }

    /// A gesture goes on: a line of it every [`LIVE`], if it has changed.
    pub fn goes_on(&mut self, gesture: G, line: impl FnOnce() -> L) {
        let (written, as_what) = self.live.get_or_insert((Instant::now(), None));
        if written.elapsed() >= LIVE && *as_what != Some(gesture) {
            (*written, *as_what) = (Instant::now(), Some(gesture));
            self.waiting.push(line());
        }
    }

    /// What is to be written last; whether that is all of a session (`true`) or goes behind what is there. `None`: nothing.
    pub fn news(&self) -> Option<(bool, &L)> {
        self.waiting.last().map(|last| (self.file.is_none(), last))
    }

    /// Writes what waits, or `whole` in its place to a new journal ([`JournalFile::create`]).
    ///
    /// # Errors
    /// It cannot be written, and is given up until the next step.
    pub fn write(&mut self, whole: Option<Vec<L>>, scene: Option<&Path>, state: Option<&Path>) -> std::io::Result<()> {
        let waiting = std::mem::take(&mut self.waiting);
        let lines = whole.unwrap_or(waiting);
        let mut file = match self.file.take() {
            Some(file) => file,
            None => JournalFile::create(scene, state)?,
        };
        file.append(&lines)?;
        self.file = Some(file);
        Ok(())
    }

    /// Removes the journal: everything is saved or given up.
    pub fn end(&mut self) {
        if let Some(file) = self.file.take() {
            file.end();
        }
        self.waiting.clear();
        self.live = None;
    }

    /// Where the journal is, if there is one.
    pub fn path(&self) -> Option<&Path> {
        self.file.as_ref().map(JournalFile::path)
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
