//! The journal of a session with a surface in space: enough to restore everything after a crash but the last moment.
//!
//! One JSON document a line. The first is the surface as the session found it, as OBJ; then the edges and the sharpness of
//! every step, undo and redo, and `live` lines with what a gesture does. A journal that begins late, because the surface was
//! saved in between, begins with all steps since it was opened.

use super::surface::{Solid, Step};
use crate::edit::journal_file::{self, fault, lines};
use crate::scene::surface::{write, SurfaceScene, INFINITE};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Version of the format.
const VERSION: u32 = 1;

/// Edges by their lower half-edges; a sharpness of [`INFINITE`] is for ever, since JSON has no infinity.
#[derive(Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Line {
    BeginSurface { version: u32, file: Option<PathBuf>, source: String },
    Step { edges: Vec<u32>, sharpness: f64 },
    Undo,
    Redo,
    Live { edges: Vec<u32>, sharpness: f64 },
    GivenUp,
}

pub(super) type Keeper = journal_file::Keeper<Line, f64>;

pub(super) fn line_of(step: &Step) -> Line {
    Line::Step { edges: step.edges.clone(), sharpness: step.after.min(INFINITE) }
}

/// A step taken back or done again.
pub(super) fn line_of_move(forward: bool) -> Line {
    if forward {
        Line::Redo
    } else {
        Line::Undo
    }
}

impl Solid {
    /// Brings the journal up to date, if anything has happened; it begins with the first step. Where it lies:
    /// [`JournalFile::create`](journal_file::JournalFile::create).
    ///
    /// # Errors
    /// It cannot be written, and is given up until the next step.
    pub fn keep_journal(&mut self, scene: Option<&Path>, state: Option<&Path>) -> std::io::Result<()> {
        if let Some(step) = &self.gesture {
            let sharpness = step.after.min(INFINITE);
            self.keeper.goes_on(sharpness, || Line::Live { edges: step.edges.clone(), sharpness });
        }
        let Some((begins, last)) = self.keeper.news() else { return Ok(()) };
        let whole = begins.then(|| self.all_lines(scene, last));
        self.keeper.write(whole, scene, state)
    }

    /// A whole journal as of now; `last` is what happened last.
    fn all_lines(&self, scene: Option<&Path>, last: &Line) -> Vec<Line> {
        let file = scene.map(|f| std::path::absolute(f).unwrap_or_else(|_| f.to_path_buf()));
        let mut all = vec![Line::BeginSurface { version: VERSION, file, source: write(&self.as_opened()) }];
        all.extend(self.done.iter().chain(self.undone.iter().rev()).map(line_of));
        all.extend(self.undone.iter().map(|_| Line::Undo));
        all.extend(matches!(last, Line::Live { .. }).then(|| last.clone()));
        all
    }

    /// Removes the journal: the surface is given up, or another scene is opened.
    pub fn end_journal(&mut self) {
        self.keeper.end();
    }

    /// Where the journal is, if there is one.
    pub fn journal(&self) -> Option<&Path> {
        self.keeper.path()
    }

    /// Selects edges and gives them a sharpness in one step; `false` if there is no such edge.
    fn redo_step(&mut self, edges: Vec<u32>, sharpness: f64) -> bool {
        let known = |&h: &u32| self.is_edge(h) && !self.on_boundary(h);
        if !edges.iter().all(known) || !sharpness.is_finite() {
            return false;
        }
        self.selected = edges.into_iter().collect();
        self.sharpen(sharpness);
        self.commit();
        true
    }
}

/// What a journal holds.
pub struct Restored {
    /// The journal's own file.
    pub path: PathBuf,
    /// The OBJ file it belongs to.
    pub file: Option<PathBuf>,
    /// The surface as it was last, with its steps.
    pub solid: Solid,
    /// Lines read after the first.
    pub steps: usize,
}

/// Whether a journal is one of a surface.
pub fn is_one(path: &Path) -> bool {
    let first = lines(path).ok().and_then(|mut lines| lines.next()).unwrap_or_default();
    matches!(serde_json::from_slice(&first), Ok(Line::BeginSurface { .. }))
}

/// Reads a journal as far as it is whole.
///
/// # Errors
/// What is wrong, in one line, when not even its beginning can be read.
pub fn restore(path: &Path) -> Result<Restored, String> {
    let mut lines = lines(path)?;
    let first = lines.next().unwrap_or_default();
    let Ok(Line::BeginSurface { version: VERSION, file, source }) = serde_json::from_slice(&first) else {
        return Err(fault(path, "this is no journal of this version"));
    };
    let scene = SurfaceScene::parse(source.as_bytes(), "its surface").map_err(|e| fault(path, e))?;
    let mut solid = Solid::new(scene).map_err(|e| fault(path, e))?;
    let mut steps = 0;
    let mut live = None;
    for line in lines {
        let Ok(line) = serde_json::from_slice::<Line>(&line) else { break };
        steps += 1;
        let fine = match line {
            Line::BeginSurface { .. } => false,
            Line::Live { edges, sharpness } => {
                live = Some((edges, sharpness));
                continue;
            }
            Line::GivenUp => true,
            Line::Step { edges, sharpness } => solid.redo_step(edges, sharpness),
            Line::Undo => solid.step(false),
            Line::Redo => solid.step(true),
        };
        live = None;
        if !fine {
            break;
        }
    }
    if let Some((edges, sharpness)) = live {
        solid.redo_step(edges, sharpness);
    }
    // Nothing on the disk is this surface.
    solid.saved_at = None;
    Ok(Restored { path: path.to_path_buf(), file, solid, steps })
}

#[cfg(test)]
mod tests {
    use super::super::habits::Folder;
    use super::*;
    use crate::edit::journal_file::{left_behind, LIVE};
    use crate::timing::random::Random;

    /// Half a cube: four of its edges are boundary.
    const BOX: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
        f 1 4 3 2\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nt crease 2/1/0 0 1 2\n";

    fn solid() -> Solid {
        Solid::new(SurfaceScene::parse(BOX.as_bytes(), "test").unwrap()).unwrap()
    }

    #[test]
    fn whatever_is_done_is_restored_exactly_with_its_steps() {
        let folder = Folder::new("surface-journal");
        let file = folder.0.join("box.obj");
        let mut random = Random::new(5);
        let mut s = solid();
        let opened = s.scene.edge_sharpness.clone();
        let edges: Vec<u32> = s.edges().collect();
        let (mut saves, mut checked) = (0, 0);
        for k in 0..300 {
            match random.unit() {
                x if x < 0.6 => {
                    s.pick(Some(edges[(random.unit() * edges.len() as f64) as usize]), random.unit() < 0.6);
                    s.sharpen([0.0, 0.25, 1.5, 3.125, INFINITE][(random.unit() * 5.0) as usize]);
                    s.commit();
                }
                x if x < 0.85 => drop(s.step(false)),
                x if x < 0.96 => drop(s.step(true)),
                _ => {
                    // After a save the journal begins anew, in the middle of the session.
                    s.saved();
                    assert!(s.journal().is_none());
                    saves += 1;
                }
            }
            s.keep_journal(Some(&file), None).unwrap();
            if let (Some(path), 0) = (s.journal(), k % 7) {
                let mut read = restore(path).unwrap();
                assert_eq!(read.file.as_deref(), Some(&*file));
                assert_eq!(read.solid.scene.edge_sharpness, s.scene.edge_sharpness, "after {k}");
                assert_eq!((read.solid.steps(), read.solid.undone.len()), (s.steps(), s.undone.len()));
                assert!(read.solid.unsaved());
                while read.solid.step(false) {}
                assert_eq!(read.solid.scene.edge_sharpness, opened, "its steps can be taken back");
                checked += 1;
            }
        }
        assert!(saves > 3 && checked > 20 && s.steps() > 20, "{saves} {checked} {}", s.steps());
    }

    #[test]
    fn a_gesture_that_goes_on_comes_back_and_a_torn_line_does_not() {
        let folder = Folder::new("surface-live");
        let mut s = solid();
        let inner = s.edges().find(|&h| !s.on_boundary(h) && s.sharpness(h) == 0.0).unwrap();
        let later = |s: &mut Solid| {
            std::thread::sleep(LIVE);
            s.keep_journal(None, Some(&folder.0)).unwrap();
        };
        s.pick(Some(inner), false);
        s.sharpen(1.0);
        s.keep_journal(None, Some(&folder.0)).unwrap();
        assert!(s.journal().is_none(), "a gesture that has only begun");
        later(&mut s);
        let path = s.journal().unwrap().to_path_buf();
        s.sharpen(2.5);
        later(&mut s);
        assert_eq!(restore(&path).unwrap().solid.sharpness(inner), 2.5);
        // It comes to nothing in the end.
        s.sharpen(0.0);
        s.commit();
        s.keep_journal(None, Some(&folder.0)).unwrap();
        let read = restore(&path).unwrap();
        assert_eq!((read.solid.sharpness(inner), read.solid.steps()), (0.0, 0));
        s.sharpen(4.0);
        s.commit();
        s.keep_journal(None, Some(&folder.0)).unwrap();
        let mut torn = std::fs::OpenOptions::new().append(true).open(&path).unwrap();
        std::io::Write::write_all(&mut torn, b"{\"step\":{\"edges\":[0],\"sha").unwrap();
        assert_eq!(restore(&path).unwrap().solid.sharpness(inner), 4.0);
        assert!(left_behind(None, Some(&folder.0)).is_empty(), "its session lives");
        drop(s);
        assert_eq!(left_behind(None, Some(&folder.0)), vec![path.as_path()]);
        assert!(is_one(&path));
    }

    #[test]
    fn what_is_no_journal_is_refused_and_nonsense_in_one_stops_it() {
        let folder = Folder::new("surface-bad");
        let path = folder.0.join("x");
        let begin = |version: u32, source: &str| {
            format!("{{\"begin_surface\":{{\"version\":{version},\"file\":null,\"source\":{source:?}}}}}\n")
        };
        for text in [String::new(), "{}\n".into(), begin(9, BOX), begin(1, "f 1 2 3\n"), begin(1, "")] {
            std::fs::write(&path, &text).unwrap();
            let error = restore(&path).err().unwrap();
            assert!(!error.contains('\n') && error.contains("; "), "{error}");
        }
        let edge = solid().edges().find(|&h| !solid().on_boundary(h)).unwrap();
        let good = format!("{{\"step\":{{\"edges\":[{edge}],\"sharpness\":3}}}}\n");
        for nonsense in ["\"redo\"\n", "{\"step\":{\"edges\":[4000000000],\"sharpness\":2}}\n", "\u{0}\n"] {
            std::fs::write(&path, format!("{}{good}{nonsense}{good}", begin(1, BOX))).unwrap();
            let read = restore(&path).unwrap();
            assert_eq!((read.solid.steps(), read.solid.sharpness(edge)), (1, 3.0), "{nonsense:?}");
        }
    }
}
