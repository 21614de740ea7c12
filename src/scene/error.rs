//! What can go wrong between a file and a [`Scene`](super::Scene), always as one line a user can act on.

use std::fmt::Display;
use std::path::Path;

/// Why a scene could not be read or written. `Display` is one line without the leading `error: `.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The content is wrong. Lines and columns count from 1; columns count characters.
    #[error("{file}:{line}:{column}: {what}; {fix}")]
    Content {
        /// The file as the user named it.
        file: String,
        /// Line of the fault, from 1.
        line: usize,
        /// Column of the fault, from 1.
        column: usize,
        /// What is wrong.
        what: String,
        /// What to do about it.
        fix: String,
    },
    /// The file cannot be opened or read.
    #[error("{file}: cannot be read ({source}); check the path and its permissions")]
    Read {
        /// The file as the user named it.
        file: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file cannot be written. The file that stood there before is untouched.
    #[error("{file}: cannot be written ({source}); check the folder, its permissions and the free space")]
    Write {
        /// The file as the user named it.
        file: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The scene holds something the chosen format has no words for, and leaving it out is not possible.
    #[error("{file}: {what}; {fix}")]
    Format {
        /// The file as the user named it.
        file: String,
        /// What cannot be written.
        what: String,
        /// What to do about it.
        fix: String,
    },
}

impl SceneError {
    /// An error in the content of `file` at `line` and `column` (both from 1): also for later rooms, which know
    /// the line of a face from [`InputMesh::face_line`](super::InputMesh::face_line).
    pub fn content(file: &str, line: usize, column: usize, what: impl Display, fix: impl Display) -> SceneError {
        SceneError::Content {
            file: file.to_owned(),
            line,
            column,
            what: one_line(&what.to_string()),
            fix: one_line(&fix.to_string()),
        }
    }

    /// True when the machine failed rather than the input: an output that cannot be written.
    pub fn is_machine_failure(&self) -> bool {
        matches!(self, SceneError::Write { .. })
    }

    pub(super) fn write(path: &Path, source: std::io::Error) -> SceneError {
        SceneError::Write { file: path.display().to_string(), source }
    }
}

/// A fault in a text whose file name is not known yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Fault {
    pub line: usize,
    pub column: usize,
    pub what: String,
    pub fix: String,
}

impl Fault {
    pub fn new(place: (usize, usize), what: impl Display, fix: impl Display) -> Fault {
        Fault { line: place.0, column: place.1, what: what.to_string(), fix: fix.to_string() }
    }

    pub fn in_file(self, file: &str) -> SceneError {
        SceneError::content(file, self.line, self.column, self.what, self.fix)
    }
}

/// `text` in quotes for a message: escaped, and cut when a hostile file makes it long.
pub(super) fn quoted(text: &str) -> String {
    const LONGEST: usize = 40;
    match text.char_indices().nth(LONGEST) {
        None => format!("{text:?}"),
        Some((cut, _)) => format!("{:?}...", &text[..cut]),
    }
}

/// Control characters would break the one-line promise of every message.
fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_is_one_line_with_place_and_advice() {
        let error = SceneError::content("a.obj", 3, 7, "vertex\n9 does not exist", "there are 4");
        assert_eq!(error.to_string(), "a.obj:3:7: vertex 9 does not exist; there are 4");
    }

    #[test]
    fn long_tokens_are_cut() {
        assert!(quoted(&"x".repeat(10_000)).len() < 60);
        assert_eq!(quoted("a\tb"), "\"a\\tb\"");
    }
}
