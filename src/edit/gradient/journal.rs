//! The journal of a session with a gradient mesh: enough to restore everything after a crash but the last moment.
//!
//! One JSON document a line. The first is the text that the mesh was read from; then the operations, which do the same to
//! the same mesh, undo and redo, and `live` lines with what a gesture does. A journal that begins late, because the scene
//! was saved in between, begins with all steps since the text was read, so that the numbers of points and curves that
//! the operations name are those of the session.

use super::{Gradient, Op};
use crate::edit::journal_file::{fault, lines, Keeper as Lines};
use crate::ferguson::inherit::Continuity;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Version of the format.
const VERSION: u32 = 1;

#[derive(Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Line {
    BeginGradient { version: u32, file: Option<PathBuf>, name: String, source: String },
    Step { op: Op, continuity: Continuity },
    Undo,
    Redo,
    Live { op: Op, continuity: Continuity },
    GivenUp,
}

/// The journal of a mesh.
pub(super) struct Keeper {
    /// What the mesh was read from.
    source: String,
    name: String,
    lines: Lines<Line, Op>,
}

impl Keeper {
    pub(super) fn new(source: String, name: String) -> Keeper {
        Keeper { source, name, lines: Lines::default() }
    }

    pub(super) fn step(&mut self, op: Op, continuity: Continuity) {
        self.lines.step(Line::Step { op, continuity });
    }

    pub(super) fn moved(&mut self, forward: bool) {
        self.lines.moved(if forward { Line::Redo } else { Line::Undo });
    }

    pub(super) fn gave_up(&mut self) {
        self.lines.gave_up(Line::GivenUp);
    }

    pub(super) fn end(&mut self) {
        self.lines.end();
    }
}

impl Gradient {
    /// Brings the journal up to date, if anything has happened; it begins with the first step. Where it lies:
    /// [`JournalFile::create`](crate::edit::journal_file::JournalFile::create).
    ///
    /// # Errors
    /// It cannot be written, and is given up until the next step.
    pub fn keep_journal(&mut self, scene: Option<&Path>, state: Option<&Path>) -> std::io::Result<()> {
        if let Some(gesture) = &self.gesture {
            let (op, continuity) = (gesture.op, gesture.continuity);
            self.keeper.lines.goes_on(op, || Line::Live { op, continuity });
        }
        let Some((begins, last)) = self.keeper.lines.news() else { return Ok(()) };
        let whole = begins.then(|| self.all_lines(scene, last));
        self.keeper.lines.write(whole, scene, state)
    }

    /// A whole journal as of now; `last` is what happened last.
    fn all_lines(&self, scene: Option<&Path>, last: &Line) -> Vec<Line> {
        let file = scene.map(|f| std::path::absolute(f).unwrap_or_else(|_| f.to_path_buf()));
        let (name, source) = (self.keeper.name.clone(), self.keeper.source.clone());
        let mut all = vec![Line::BeginGradient { version: VERSION, file, name, source }];
        all.extend(self.done.iter().map(|s| Line::Step { op: s.op, continuity: s.continuity }));
        all.extend(self.undone.iter().rev().map(|&(op, continuity)| Line::Step { op, continuity }));
        all.extend(self.undone.iter().map(|_| Line::Undo));
        all.extend(matches!(last, Line::Live { .. }).then(|| last.clone()));
        all
    }

    /// Removes the journal: the mesh is given up, or another one is opened.
    pub fn end_journal(&mut self) {
        self.keeper.end();
    }

    /// Where the journal is, if there is one.
    pub fn journal(&self) -> Option<&Path> {
        self.keeper.lines.path()
    }
}

/// What a journal holds.
pub struct Restored {
    /// The journal's own file.
    pub path: PathBuf,
    /// The scene file it belongs to, if it was ever saved.
    pub file: Option<PathBuf>,
    /// The mesh as it was last, with its steps.
    pub gradient: Gradient,
    /// Lines read after the first.
    pub steps: usize,
}

/// Whether a journal is one of a gradient mesh.
pub fn is_one(path: &Path) -> bool {
    let first = lines(path).ok().and_then(|mut lines| lines.next()).unwrap_or_default();
    matches!(serde_json::from_slice(&first), Ok(Line::BeginGradient { .. }))
}

/// Reads a journal as far as it is whole.
///
/// # Errors
/// What is wrong, in one line, when not even its beginning can be read.
pub fn restore(path: &Path) -> Result<Restored, String> {
    let mut lines = lines(path)?;
    let first = lines.next().unwrap_or_default();
    let Ok(Line::BeginGradient { version: VERSION, file, name, source }) = serde_json::from_slice(&first) else {
        return Err(fault(path, "this is no journal of this version"));
    };
    let (mut gradient, _) = Gradient::read(source.into_bytes(), name).map_err(|e| fault(path, e))?;
    let mut steps = 0;
    let mut live = None;
    for line in lines {
        let Ok(line) = serde_json::from_slice::<Line>(&line) else { break };
        steps += 1;
        let fine = match line {
            Line::BeginGradient { .. } => false,
            Line::Live { op, continuity } => {
                live = Some((op, continuity));
                continue;
            }
            Line::GivenUp => true,
            Line::Step { op, continuity } => {
                gradient.continuity = continuity;
                gradient.act(op).is_ok()
            }
            Line::Undo => gradient.step(false).is_some(),
            Line::Redo => gradient.step(true).is_some(),
        };
        live = None;
        if !fine {
            break;
        }
    }
    if let Some((op, continuity)) = live {
        gradient.continuity = continuity;
        let _ = gradient.act(op);
    }
    // Nothing on the disk is this mesh.
    gradient.saved_at = None;
    Ok(Restored { path: path.to_path_buf(), file, gradient, steps })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edit::gradient::pick::Pick;
    use crate::edit::journal_file::{left_behind, LIVE};
    use crate::ferguson::mesh::HalfEdge;
    use crate::ferguson::split::Axis;
    use crate::ferguson::Mesh;
    use crate::scene::ferguson::write;
    use crate::timing::random::Random;
    use glam::{DVec2, DVec4};
    use std::io::Write;

    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Folder {
            let path = std::env::temp_dir().join(format!("gradtess-gradient-{name}-{}", std::process::id()));
            let _ = std::fs::remove_dir_all(&path);
            std::fs::create_dir_all(&path).unwrap();
            Folder(path)
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    fn grid() -> Gradient {
        let colour = |i: u32, j: u32| DVec4::new(f64::from(i) / 3.0, f64::from(j) / 3.0, 0.5, 1.0);
        Gradient::new(Mesh::grid(3, 3, [0.0, 0.0, 1.0, 1.0], colour).unwrap())
    }

    /// An operation on something, which may be refused.
    fn random_op(g: &Gradient, random: &mut Random) -> Op {
        let mut below = |n: usize| (random.unit() * n as f64) as usize;
        let live: Vec<u32> = g.mesh.live().collect();
        let p = live[below(live.len())];
        let h = HalfEdge::new(p, below(4));
        let by = DVec2::new(0.01 * below(5) as f64 - 0.02, 0.01 * below(5) as f64 - 0.02);
        let (point, curve) = (g.mesh.corner(h).point, g.mesh.side(h).curve);
        let colour = DVec4::new(0.1 * below(10) as f64, 0.3, 0.1 * below(10) as f64, 1.0);
        match below(8) {
            0 | 1 => Op::Split(p, [Axis::U, Axis::V][below(2)], [0.5, 0.3][below(2)]),
            2 => Op::Remove(curve),
            3 => Op::Point(point, g.mesh.at(point) + by),
            4 => Op::Handle(curve, below(2), g.mesh.curve(curve).handles[0] + by),
            5 => Op::Twist(h, by),
            6 => Op::Colour(point, colour),
            _ => Op::Sector(h, colour),
        }
    }

    #[test]
    fn whatever_is_done_is_restored_exactly_with_its_steps() {
        let folder = Folder::new("all");
        let file = folder.0.join("mesh.json");
        let mut random = Random::new(11);
        let mut g = grid();
        let (mut refused, mut undone, mut saves) = (0, 0, 0);
        for k in 0..400 {
            g.continuity = if random.unit() < 0.5 { Continuity::C0 } else { Continuity::C1 };
            match random.unit() {
                x if x < 0.6 => {
                    let op = random_op(&g, &mut random);
                    refused += usize::from(g.act(op).is_err());
                }
                x if x < 0.85 => undone += usize::from(g.step(false).is_some()),
                x if x < 0.97 => drop(g.step(true)),
                _ => {
                    // After a save the journal begins anew, in the middle of the session.
                    g.saved();
                    assert!(g.journal().is_none());
                    saves += 1;
                }
            }
            g.keep_journal(Some(&file), None).unwrap();
            if let (Some(path), 0) = (g.journal(), k % 9) {
                let mut read = restore(path).unwrap();
                assert_eq!(read.file.as_deref(), Some(&*file));
                assert!(write(&read.gradient.mesh) == write(&g.mesh) && read.gradient.mesh == g.mesh, "after {k}");
                assert_eq!((read.gradient.steps(), read.gradient.undone.len()), (g.steps(), g.undone.len()));
                assert!(read.gradient.unsaved());
                // Its steps can be taken back, too.
                while read.gradient.step(false).is_some() {}
                assert_eq!(write(&read.gradient.mesh), write(&grid().mesh));
            }
        }
        assert!(refused > 5 && undone > 50 && saves > 5 && g.steps() > 20, "{refused} {undone} {saves} {}", g.steps());
    }

    #[test]
    fn a_gesture_that_goes_on_comes_back_unless_it_was_given_up() {
        let folder = Folder::new("live");
        let mut g = grid();
        let pick = g.at(DVec2::splat(1.0 / 3.0), 1e-6).unwrap();
        assert!(matches!(pick, Pick::Point(_)));
        let later = |g: &mut Gradient| {
            std::thread::sleep(LIVE);
            g.keep_journal(None, Some(&folder.0)).unwrap();
        };
        g.drag(pick, DVec2::splat(0.3), None).unwrap();
        g.keep_journal(None, Some(&folder.0)).unwrap();
        assert!(g.journal().is_none(), "a drag that has only begun");
        later(&mut g);
        let path = g.journal().unwrap().to_path_buf();
        g.drag(pick, DVec2::splat(0.31), None).unwrap();
        later(&mut g);
        let read = restore(&path).unwrap().gradient;
        assert_eq!((read.place(pick), read.steps()), (DVec2::splat(0.31), 1));
        g.cancel();
        g.keep_journal(None, Some(&folder.0)).unwrap();
        assert_eq!(restore(&path).unwrap().gradient.place(pick), DVec2::splat(1.0 / 3.0));
        // A line that the crash cut in half is left out.
        g.act(Op::Split(0, Axis::U, 0.5)).unwrap();
        g.keep_journal(None, Some(&folder.0)).unwrap();
        let mut torn = std::fs::OpenOptions::new().append(true).open(&path).unwrap();
        torn.write_all(b"{\"step\":{\"op\":{\"spl").unwrap();
        assert!(restore(&path).unwrap().gradient.mesh == g.mesh);
        // While its session lives it is nobody else's; afterwards it is left behind, unless the session ended well.
        assert!(left_behind(None, Some(&folder.0)).is_empty());
        drop(g);
        assert_eq!(left_behind(None, Some(&folder.0)), vec![path.as_path()]);
        assert!(is_one(&path));
    }

    #[test]
    fn what_is_no_journal_is_refused_and_nonsense_in_one_stops_it() {
        let folder = Folder::new("bad");
        let path = folder.0.join("x");
        let begin = |version: u32, source: &str| {
            format!(
                "{{\"begin_gradient\":{{\"version\":{version},\"file\":null,\"name\":\"a\",\"source\":{source:?}}}}}\n"
            )
        };
        for text in [String::new(), "{}\n".into(), begin(9, "{}"), begin(1, "{}"), begin(1, "<svg")] {
            std::fs::write(&path, &text).unwrap();
            let error = restore(&path).err().unwrap();
            assert!(!error.contains('\n') && error.contains("; "), "{error}");
        }
        let (half, mesh) =
            ("{\"step\":{\"op\":{\"split\":[0,\"u\",0.5]},\"continuity\":\"c1\"}}\n", write(&grid().mesh));
        for line in [
            "{\"step\":{\"op\":{\"split\":[99,\"u\",0.5]},\"continuity\":\"c1\"}}",
            "{\"step\":{\"op\":{\"twist\":[4294967295,[0,0]]},\"continuity\":\"c0\"}}",
            "{\"step\":{\"op\":{\"handle\":[70000,7,[0,0]]},\"continuity\":\"c1\"}}",
            "{\"step\":{\"op\":{\"point\":[4294967295,[0,0]]},\"continuity\":\"c1\"}}",
            "\"redo\"",
        ] {
            std::fs::write(&path, begin(1, &mesh) + half + line + "\n" + half).unwrap();
            let read = restore(&path).unwrap();
            assert_eq!((read.gradient.steps(), read.steps), (1, 2), "{line}");
        }
    }
}
