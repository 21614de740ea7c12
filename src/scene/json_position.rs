//! Finds where a value stands in a JSON text, for messages about values that parsed well but make no sense.
//!
//! `serde_json` reports places only while it parses. Scanning again when something is wrong costs nothing otherwise
//! and keeps the document types free of bookkeeping.

/// One step from a value into it.
#[derive(Clone, Copy, Debug)]
pub(super) enum Step<'a> {
    /// The member of an object.
    Key(&'a str),
    /// The element of an array, from 0.
    Index(usize),
}

/// Byte offset of the value at `path` in `text`, or of the last value on the way that exists. `None` when `text` is
/// no JSON up to there.
pub(super) fn offset(text: &str, path: &[Step]) -> Option<usize> {
    let mut scan = Scan { bytes: text.as_bytes(), at: 0 };
    scan.blanks();
    let mut start = scan.at;
    for step in path {
        if !scan.enter(step)? {
            return Some(start);
        }
        start = scan.at;
    }
    Some(start)
}

/// Line and column, both from 1, of the value at `path`; (1, 1) when it cannot be found.
pub(super) fn place(text: &str, path: &[Step]) -> (usize, usize) {
    offset(text, path).map_or((1, 1), |offset| line_column(text, offset))
}

/// Line of every element of the array at `path`, from 1.
pub(super) fn element_lines(text: &str, path: &[Step]) -> Vec<u32> {
    let mut lines = Vec::new();
    let Some(start) = offset(text, path) else {
        return lines;
    };
    let mut scan = Scan { bytes: text.as_bytes(), at: start };
    let (mut counted, mut line) = (0, 1);
    if scan.take(b'[').is_none() {
        return lines;
    }
    loop {
        scan.blanks();
        if scan.peek().is_none_or(|byte| byte == b']') {
            return lines;
        }
        line += newlines(&scan.bytes[counted..scan.at]);
        counted = scan.at;
        lines.push(line);
        if scan.skip_value().is_none() || scan.comma().is_none() {
            return lines;
        }
    }
}

/// Line and column (in characters), both from 1, of a byte offset.
pub(super) fn line_column(text: &str, offset: usize) -> (usize, usize) {
    let before = &text.as_bytes()[..offset.min(text.len())];
    let start = before.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
    (newlines(before) as usize + 1, String::from_utf8_lossy(&before[start..]).chars().count() + 1)
}

fn newlines(bytes: &[u8]) -> u32 {
    bytes.iter().filter(|&&byte| byte == b'\n').count() as u32
}

struct Scan<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Scan<'_> {
    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    fn blanks(&mut self) {
        while self.peek().is_some_and(|byte| byte.is_ascii_whitespace()) {
            self.at += 1;
        }
    }

    fn take(&mut self, byte: u8) -> Option<()> {
        self.blanks();
        (self.peek() == Some(byte)).then(|| self.at += 1)
    }

    /// A comma: `Some`; anything else: `None`.
    fn comma(&mut self) -> Option<()> {
        self.take(b',')
    }

    /// Moves to the value that `step` leads to from the value here. `Some(false)` when there is none.
    fn enter(&mut self, step: &Step) -> Option<bool> {
        match *step {
            Step::Key(wanted) => {
                if self.take(b'{').is_none() {
                    return Some(false);
                }
                loop {
                    self.blanks();
                    if self.peek() == Some(b'}') {
                        return Some(false);
                    }
                    let key = self.skip_string()?;
                    let found = self.bytes[key.clone()] == *wanted.as_bytes();
                    self.take(b':')?;
                    self.blanks();
                    if found {
                        return Some(true);
                    }
                    self.skip_value()?;
                    if self.comma().is_none() {
                        return Some(false);
                    }
                }
            }
            Step::Index(wanted) => {
                if self.take(b'[').is_none() {
                    return Some(false);
                }
                for _ in 0..wanted {
                    self.skip_value()?;
                    if self.comma().is_none() {
                        return Some(false);
                    }
                }
                self.blanks();
                Some(self.peek() != Some(b']'))
            }
        }
    }

    /// The bytes between the quotes of the string here.
    fn skip_string(&mut self) -> Option<std::ops::Range<usize>> {
        self.take(b'"')?;
        let start = self.at;
        loop {
            match self.peek()? {
                b'"' => break,
                b'\\' => self.at += 2,
                _ => self.at += 1,
            }
        }
        self.at += 1;
        Some(start..self.at - 1)
    }

    /// Passes one value of any kind. Brackets are only counted: the text has been, or will be, parsed properly.
    fn skip_value(&mut self) -> Option<()> {
        let mut depth = 0usize;
        loop {
            self.blanks();
            match self.peek()? {
                b'"' => {
                    self.skip_string()?;
                }
                b'[' | b'{' => {
                    depth += 1;
                    self.at += 1;
                    continue;
                }
                b']' | b'}' => {
                    depth = depth.checked_sub(1)?;
                    self.at += 1;
                }
                b',' | b':' if depth > 0 => {
                    self.at += 1;
                    continue;
                }
                b',' | b':' => return None,
                _ => {
                    while self.peek().is_some_and(|byte| !byte.is_ascii_whitespace() && !b",:]}[{\"".contains(&byte)) {
                        self.at += 1;
                    }
                }
            }
            if depth == 0 {
                return Some(());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Step::{Index, Key};

    const TEXT: &str =
        "{\n  \"a\\\"\": [1, {\"b\": \"}]\"}],\n  \"ü\": {\"faces\": [[0,1],\n [2],\n\n [3, [4]] ]}, \"n\": -1.5e3\n}";

    #[test]
    fn values_are_found_by_path() {
        let at = |path: &[Step]| &TEXT[offset(TEXT, path).unwrap()..];
        assert!(at(&[Key("a\\\""), Index(1), Key("b")]).starts_with("\"}]\""));
        assert!(at(&[Key("ü"), Key("faces"), Index(2), Index(1), Index(0)]).starts_with("4]"));
        assert!(at(&[Key("n")]).starts_with("-1.5e3"));
        assert_eq!(place(TEXT, &[Key("ü"), Key("faces"), Index(1)]), (4, 2));
        assert_eq!(place(TEXT, &[Key("ü")]), (3, 8));
    }

    #[test]
    fn a_missing_value_gives_the_place_of_what_would_hold_it() {
        assert_eq!(offset(TEXT, &[Key("x")]), Some(0));
        assert_eq!(place(TEXT, &[Key("ü"), Key("faces"), Index(9)]), place(TEXT, &[Key("ü"), Key("faces")]));
    }

    #[test]
    fn elements_know_their_lines() {
        assert_eq!(element_lines(TEXT, &[Key("ü"), Key("faces")]), [3, 4, 6]);
        assert_eq!(element_lines("[]", &[]), [0u32; 0]);
        assert_eq!(element_lines("[1,", &[]), [1]);
    }

    #[test]
    fn broken_texts_end_the_search() {
        for text in ["", "{", "{\"a", "{\"a\":", "{\"a\" 1}", "[[[", "]", "{\"b\":]", "{\"\\"] {
            let _ = place(text, &[Key("a"), Index(3)]);
            let _ = element_lines(text, &[Key("a")]);
        }
    }
}
