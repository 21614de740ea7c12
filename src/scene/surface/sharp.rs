//! Sharpness lists: `fs D1 D2 ...` for one face, `as N D1 D2 ...` for the next N faces.
//!
//! The i-th entry belongs to the i-th `f` line wherever the lines stand. For `f v1 ... vn` the first digit is the edge
//! from `v(n-1)` to `vn`, the second the one from `vn` to `v1`, the k-th the one into `v(k-1)`: in the order of the
//! face, as the authors' tool has it; ZBK23 3.5 says clockwise.

use super::obj::{fields, sharpness, Field};
use super::SurfaceScene;
use crate::scene::error::{quoted, Fault};
use crate::scene::SceneError;

/// One list, for a run of faces.
struct List {
    faces: usize,
    digits: Vec<f64>,
    line: usize,
}

/// The lists of a file, in its order.
#[derive(Default)]
pub(super) struct Lists {
    lists: Vec<List>,
}

impl Lists {
    /// Takes an `fs` or `as` line.
    pub fn line(&mut self, first: Field, rest: &[Field]) -> Result<(), Fault> {
        let (faces, digits) = match (first.text, rest) {
            ("as", [count, digits @ ..]) => {
                let n = count.text.parse::<u32>().ok().filter(|&n| n > 0).ok_or_else(|| {
                    let what = format!("{} is not a number of faces", quoted(count.text));
                    Fault::new(count.place, what, "write `as FACES S1 S2 ...`")
                })?;
                (n as usize, digits)
            }
            ("as", []) => {
                return Err(Fault::new(first.place, "the number of faces is missing", "write `as FACES S1 S2 ...`"))
            }
            (_, digits) => (1, digits),
        };
        let digits = digits.iter().map(|&f| sharpness(f)).collect::<Result<_, _>>()?;
        self.lists.push(List { faces, digits, line: first.place.0 });
        Ok(())
    }

    /// Sharpness of every half-edge. Too few digits leave the rest of a face smooth; too many go round it once more and the
    /// larger counts, as in the authors' tool; both are noted, as are lists past the last face.
    pub fn resolve(self, face_start: &[u32], notes: &mut Vec<String>) -> Vec<f64> {
        let corners = face_start.last().copied().unwrap_or(0) as usize;
        let mut sharp = vec![0.0f64; corners];
        let faces = face_start.len().saturating_sub(1);
        let mut face = 0usize;
        for list in self.lists {
            let mut odd = 0;
            let end = faces.min(face.saturating_add(list.faces));
            if face.saturating_add(list.faces) > faces {
                notes.push(format!("line {}: the sharpness list reaches past the last face; ignored there", list.line));
            }
            for f in face..end {
                let (start, n) = (face_start[f] as usize, (face_start[f + 1] - face_start[f]) as usize);
                odd += usize::from(list.digits.len() != n);
                for (k, &s) in list.digits.iter().enumerate() {
                    let slot = &mut sharp[start + (k + n - 1) % n];
                    *slot = slot.max(s);
                }
            }
            if odd > 0 {
                notes.push(format!(
                    "line {}: {} digits do not fit {odd} of its faces; missing ones count 0, surplus ones go round again",
                    list.line,
                    list.digits.len()
                ));
            }
            face = end;
        }
        sharp
    }
}

/// Replaces all sharpness of `scene` by the `fs` and `as` lines in `bytes`; every other line is ignored.
///
/// # Errors
/// The first fault found, with file, line, column and what to do.
pub fn sharp(scene: &mut SurfaceScene, bytes: &[u8], file: &str) -> Result<(), SceneError> {
    let text = String::from_utf8_lossy(bytes);
    let mut lists = Lists::default();
    for (index, line) in text.lines().enumerate() {
        let all: Vec<Field> = fields(line, index + 1).collect();
        if let [first, rest @ ..] = all.as_slice() {
            if matches!(first.text, "fs" | "as") {
                lists.line(*first, rest).map_err(|fault| fault.in_file(file))?;
            }
        }
    }
    let mut notes = Vec::new();
    scene.edge_sharpness = lists.resolve(&scene.face_start, &mut notes);
    scene.notes.extend(notes.into_iter().map(|note| format!("{file}: {note}")));
    scene.creases.clear();
    scene.corner_sharpness.clear();
    Ok(())
}
