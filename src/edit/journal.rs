//! The journal of a session: enough to restore everything after a crash but the last moment.
//!
//! One JSON document a line. The first is the scene as the session found it; then every step, undo and redo, and a
//! `live` line with what a gesture has done so far, with an `abandoned` one if it is given up. A reader stops at the first
//! line that is spoiled.

use super::change::Change;
use super::history::{History, Step};
use super::journal_file::{fault, lines, JournalFile};
use crate::scene::{native, Scene};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

pub use super::journal_file::left_behind;

/// Version of the journal's format.
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Line {
    Begin { version: u32, file: Option<PathBuf>, scene: String },
    Step { label: String, change: Change },
    Undo,
    Redo,
    Live { change: Change },
    Abandoned,
}

/// An open journal.
pub struct Journal {
    file: JournalFile,
    // Steps in it that can be undone and redone, since it last held an undo or redo of a step from before it.
    done: usize,
    undone: usize,
    // Whether the last line is that of a gesture that goes on.
    live: bool,
}

/// What a journal holds.
#[derive(Debug)]
pub struct Restored {
    /// The journal's own file.
    pub path: PathBuf,
    /// The scene file it belongs to, if it was ever saved.
    pub file: Option<PathBuf>,
    /// The scene as it was last.
    pub scene: Scene,
    /// Its steps, so that they can still be undone.
    pub history: History,
    /// Steps read.
    pub steps: usize,
}

impl Journal {
    /// Starts the journal of `scene` beside `file`, or in `state` where there is no file or its folder cannot be
    /// written to.
    ///
    /// # Errors
    /// Neither folder can be written to.
    pub fn begin(file: Option<&Path>, state: Option<&Path>, scene: &Scene) -> std::io::Result<Journal> {
        let mut journal = Journal { file: JournalFile::create(file, state)?, done: 0, undone: 0, live: false };
        let file = file.map(|f| std::path::absolute(f).unwrap_or_else(|_| f.to_path_buf()));
        journal.write(&Line::Begin { version: VERSION, file, scene: native::write(scene) })?;
        Ok(journal)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// Adds a step.
    ///
    /// # Errors
    /// The disk is full or gone.
    pub fn step(&mut self, step: &Step) -> std::io::Result<()> {
        (self.done, self.undone) = (self.done + 1, 0);
        self.write(&Line::Step { label: step.label.clone(), change: step.change.clone() })
    }

    /// Adds an undo or (`forward`) a redo, which turned `before` into `after`. Of a step made before the journal began
    /// it is a step of its own.
    ///
    /// # Errors
    /// As [`Journal::step`].
    pub fn moved(&mut self, forward: bool, before: &Scene, after: &Scene) -> std::io::Result<()> {
        let from = if forward { &mut self.undone } else { &mut self.done };
        let Some(left) = from.checked_sub(1) else {
            (self.done, self.undone) = (0, 0);
            let label = if forward { "redo" } else { "undo" }.to_owned();
            return self.write(&Line::Step { label, change: Change::between(before, after) });
        };
        *from = left;
        *(if forward { &mut self.done } else { &mut self.undone }) += 1;
        self.write(if forward { &Line::Redo } else { &Line::Undo })
    }

    /// Adds what a gesture that still goes on has changed so far.
    ///
    /// # Errors
    /// As [`Journal::step`].
    pub fn live(&mut self, change: Change) -> std::io::Result<()> {
        self.write(&Line::Live { change })
    }

    /// A gesture is given up: what it had done so far did not happen.
    ///
    /// # Errors
    /// As [`Journal::step`].
    pub fn abandon(&mut self) -> std::io::Result<()> {
        match self.live {
            true => self.write(&Line::Abandoned),
            false => Ok(()),
        }
    }

    fn write(&mut self, line: &Line) -> std::io::Result<()> {
        self.live = matches!(line, Line::Live { .. });
        self.file.append(std::slice::from_ref(line))
    }

    /// Removes it: the scene is saved, or given up.
    pub fn end(self) {
        self.file.end();
    }
}

/// Reads a journal as far as it is whole.
///
/// # Errors
/// What is wrong, in one line, when not even its beginning can be read.
pub fn restore(path: &Path) -> Result<Restored, String> {
    let mut lines = lines(path)?;
    let first = lines.next().unwrap_or_default();
    let Ok(Line::Begin { version: VERSION, file, scene }) = serde_json::from_slice(&first) else {
        return Err(fault(path, "this is no journal of this version"));
    };
    let name = path.display().to_string();
    let mut scene = Scene::parse(scene.as_bytes(), &name).map_err(|e| fault(path, e))?;
    // Lines of the journal's copy mean nothing to the user.
    scene.mesh.face_line.clear();
    let mut out = Restored { path: path.to_path_buf(), file, scene, history: History::default(), steps: 0 };
    let mut live: Option<Change> = None;
    for line in lines {
        let Ok(line) = serde_json::from_slice::<Line>(&line) else { break };
        out.steps += 1;
        match line {
            Line::Begin { .. } => break,
            Line::Live { change } => {
                live = Some(change);
                continue;
            }
            Line::Step { label, change } => {
                if !change.apply(&mut out.scene, true) {
                    break;
                }
                out.history.add(Step { label, change });
            }
            Line::Abandoned => {}
            Line::Undo => {
                out.history.undo(&mut out.scene);
            }
            Line::Redo => {
                out.history.redo(&mut out.scene);
            }
        }
        live = None;
    }
    if let Some(change) = live {
        if change.apply(&mut out.scene, true) {
            out.history.add(Step { label: "unfinished gesture".to_owned(), change });
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes::builtin;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("gradtess-journal-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    fn scene() -> Scene {
        Scene { name: "a".into(), mesh: builtin("quad").unwrap(), ..Scene::default() }
    }

    /// Moves vertex 1 to x by a step.
    fn moved(scene: &mut Scene, history: &mut History, x: f64) -> Step {
        let before = scene.clone();
        scene.mesh.positions[1].x = x;
        history.push("move", &before, scene).unwrap().clone()
    }

    #[test]
    fn steps_undo_redo_and_a_gesture_come_back_and_a_torn_line_is_left_out() {
        let folder = folder("all");
        let file = folder.join("a.json");
        let mut now = scene();
        let mut history = History::default();
        let mut journal = Journal::begin(Some(&file), None, &now).unwrap();
        for i in 0..5 {
            journal.step(&moved(&mut now, &mut history, 0.1 + f64::from(i) / 3.0)).unwrap();
        }
        for forward in [false, false, true] {
            let before = now.clone();
            if forward {
                history.redo(&mut now)
            } else {
                history.undo(&mut now)
            };
            journal.moved(forward, &before, &now).unwrap();
        }
        let read = restore(journal.path()).unwrap();
        assert_eq!((&read.scene, read.file.as_deref()), (&now, Some(file.as_path())));
        assert_eq!(read.history.labels(), history.labels());

        // A gesture that goes on, and then a line that the crash cut in half.
        let before = now.clone();
        now.mesh.positions[2].y = 7.0;
        journal.live(Change::between(&before, &now)).unwrap();
        let mut torn = std::fs::OpenOptions::new().append(true).open(journal.path()).unwrap();
        std::io::Write::write_all(&mut torn, b"{\"step\":{\"label\":\"mo").unwrap();
        assert_eq!(restore(journal.path()).unwrap().scene, now);
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_gesture_that_is_given_up_leaves_nothing() {
        let folder = folder("given-up");
        let mut now = scene();
        let mut history = History::default();
        let mut journal = Journal::begin(None, Some(&folder), &now).unwrap();
        journal.step(&moved(&mut now, &mut history, 0.3)).unwrap();
        // Nothing to say while none goes on.
        let length = |journal: &Journal| std::fs::metadata(journal.path()).unwrap().len();
        let before = length(&journal);
        journal.abandon().unwrap();
        assert_eq!(length(&journal), before);
        let mut dragged = now.clone();
        dragged.mesh.positions[2].y = 7.0;
        journal.live(Change::between(&now, &dragged)).unwrap();
        assert_eq!(restore(journal.path()).unwrap().scene, dragged);
        journal.abandon().unwrap();
        let read = restore(journal.path()).unwrap();
        assert_eq!((&read.scene, read.history.labels()), (&now, history.labels()));
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn steps_made_before_the_journal_can_be_undone_in_it() {
        let folder = folder("early");
        let mut now = scene();
        let mut history = History::default();
        (0..3).for_each(|i| drop(moved(&mut now, &mut history, 2.0 + f64::from(i))));
        let mut journal = Journal::begin(None, Some(&folder), &now).unwrap();
        for (i, forward) in [false, false, true, false, true, false, true, false, false].into_iter().enumerate() {
            if i == 5 {
                journal.step(&moved(&mut now, &mut history, 9.0)).unwrap();
            }
            let before = now.clone();
            if forward {
                history.redo(&mut now)
            } else {
                history.undo(&mut now)
            };
            journal.moved(forward, &before, &now).unwrap();
            assert_eq!(restore(journal.path()).unwrap().scene, now);
        }
        journal.end();
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_live_session_keeps_its_journal_to_itself() {
        let folder = folder("lock");
        let file = folder.join("a.json");
        let journal = Journal::begin(Some(&file), None, &scene()).unwrap();
        assert!(left_behind(Some(&file), None).is_empty());
        let second = Journal::begin(Some(&file), None, &scene()).unwrap();
        assert_ne!(journal.path(), second.path());
        let path = journal.path().to_path_buf();
        drop(journal);
        assert_eq!(left_behind(Some(&file), None), [path]);
        second.end();
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn without_a_folder_beside_it_the_journal_goes_to_the_state_folder() {
        let state = folder("state").join("deep/state");
        let missing = Path::new("/no/such/folder/a.json");
        let journal = Journal::begin(Some(missing), Some(&state), &scene()).unwrap();
        assert!(journal.path().starts_with(&state));
        drop(journal);
        assert_eq!(left_behind(Some(missing), Some(&state)).len(), 1);
        assert!(Journal::begin(Some(missing), None, &scene()).is_err());
    }

    #[test]
    fn what_is_no_journal_is_refused_in_one_line() {
        let folder = folder("bad");
        let path = folder.join("x");
        for text in ["", "{}", "{\"begin\":{\"version\":9,\"file\":null,\"scene\":\"\"}}\n", "\u{0}\n"] {
            std::fs::write(&path, text).unwrap();
            let error = restore(&path).unwrap_err();
            assert!(!error.contains('\n') && error.contains("; "), "{error}");
        }
        std::fs::remove_dir_all(folder).unwrap();
    }
}
