//! What a unit fills: commands to run, and the pictures, plots and tables that come of them.

use super::record::{Item, Origin, Record, SCHEMA};
use super::{scenes, Figure, ReproError};
use crate::image::Picture;
use crate::scene::write_atomically;
use crate::timing::host::iso8601;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Instant, SystemTime};

/// In commands, stands for the folder of the authors' models.
const MODELS: &str = "$MODELS/";

/// What all figures of a run share.
pub struct Setting {
    /// Output folder; commands run in it.
    pub output: PathBuf,
    /// Folder of the authors' models, and the files in it, relative.
    pub models: Option<(PathBuf, Vec<String>)>,
    /// Flags for every command: device, validation.
    pub flags: Vec<String>,
    /// What makes the figures.
    pub origin: Origin,
}

/// The sheet of one figure.
pub struct Sheet<'a> {
    setting: &'a Setting,
    begun: Instant,
    record: Record,
}

impl<'a> Sheet<'a> {
    /// An empty sheet in an empty folder.
    pub(super) fn new(figure: &Figure, setting: &'a Setting) -> Result<Sheet<'a>, ReproError> {
        let sheet = Sheet {
            setting,
            begun: Instant::now(),
            record: Record {
                schema: SCHEMA.to_owned(),
                id: figure.id.to_owned(),
                paper: figure.paper.to_owned(),
                place: figure.place.to_owned(),
                title: figure.title.to_owned(),
                caption: String::new(),
                notes: Vec::new(),
                commands: Vec::new(),
                items: Vec::new(),
                origin: setting.origin.clone(),
                utc: String::new(),
                seconds: 0.0,
            },
        };
        let folder = sheet.path("");
        if folder.exists() {
            std::fs::remove_dir_all(&folder).map_err(|e| ReproError::file(&folder, e))?;
        }
        std::fs::create_dir_all(&folder).map_err(|e| ReproError::file(&folder, e))?;
        Ok(sheet)
    }

    /// Writes `figure.json`, which finishes the figure.
    pub(super) fn finish(mut self) -> Result<(), ReproError> {
        self.record.utc = iso8601(SystemTime::now());
        self.record.seconds = self.begun.elapsed().as_secs_f64();
        let text = serde_json::to_string_pretty(&self.record).map_err(|e| ReproError::Figure(e.to_string()))?;
        Ok(write_atomically(&self.path("figure.json"), (text + "\n").as_bytes())?)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.setting.output.join(self.file(name))
    }

    /// Whether timings follow the whole protocol.
    pub fn full(&self) -> bool {
        self.setting.origin.full
    }

    /// Timed frames of a repeat that were asked for.
    pub fn frames(&self) -> Option<u32> {
        self.setting.origin.frames
    }

    /// The name by which commands call `name` in the figure's folder.
    pub fn file(&self, name: &str) -> String {
        format!("figures/{}/{name}", self.record.id)
    }

    /// The name by which commands call a scene of the project, such as `unit/sharp_dart.json`; the scene is put there.
    pub fn scene(&self, name: &str) -> Result<String, ReproError> {
        let bytes = scenes::content(name).ok_or_else(|| ReproError::Figure(format!("there is no scene {name}")))?;
        let file = format!("scenes/{name}");
        let path = self.setting.output.join(&file);
        if std::fs::read(&path).is_ok_and(|there| there == bytes) {
            return Ok(file);
        }
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|e| ReproError::file(folder, e))?;
        }
        write_atomically(&path, bytes)?;
        Ok(file)
    }

    /// The name by which commands call the authors' model whose path ends with `name`; `None` without such a model.
    pub fn model(&self, name: &str) -> Option<String> {
        let (_, files) = self.setting.models.as_ref()?;
        let ends = |file: &&String| file.strip_suffix(name).is_some_and(|rest| rest.is_empty() || rest.ends_with('/'));
        files.iter().find(ends).map(|file| format!("{MODELS}{file}"))
    }

    /// All files of the authors' models, as commands call them, relative to the folder given.
    pub fn models(&self) -> Vec<String> {
        self.setting.models.iter().flat_map(|(_, files)| files).map(|file| format!("{MODELS}{file}")).collect()
    }

    /// Puts a file of the unit's own into the figure's folder, and returns the name by which commands call it.
    pub fn write(&self, name: &str, text: &str) -> Result<String, ReproError> {
        write_atomically(&self.path(name), text.as_bytes())?;
        Ok(self.file(name))
    }

    /// Runs `gradtess COMMAND` in the output folder, notes it for the report, and returns what it prints as JSON. Words
    /// are parted by blanks outside of single quotes, as a shell does it. A check that falls short (exit status 3) is a result like others.
    pub fn run(&mut self, command: &str) -> Result<Value, ReproError> {
        let shown = format!("gradtess {command}");
        self.record.commands.push(shown.clone());
        let failed = |status, message: String| ReproError::Command { command: shown.clone(), status, message };
        let program = std::env::current_exe().map_err(|e| failed(1, e.to_string()))?;
        let words = words(command).into_iter().map(|word| match (word.strip_prefix(MODELS), &self.setting.models) {
            (Some(rest), Some((folder, _))) => folder.join(rest).into_os_string(),
            _ => word.into(),
        });
        let done = Command::new(program)
            .current_dir(&self.setting.output)
            .args(words)
            .args(["--json", "--quiet"])
            .args(&self.setting.flags)
            .stdin(Stdio::null())
            .output()
            .map_err(|e| failed(1, e.to_string()))?;
        let status = done.status.code().unwrap_or(1);
        if status != 0 && status != 3 {
            let text = String::from_utf8_lossy(&done.stderr);
            let line = text.lines().rev().find_map(|line| line.strip_prefix("error: "));
            let message = line.map_or_else(|| format!("ended with {}", done.status), str::to_owned);
            return Err(failed(u8::try_from(status).unwrap_or(1), message));
        }
        serde_json::from_slice(&done.stdout).map_err(|e| failed(1, format!("printed no JSON: {e}")))
    }

    /// The figure's caption.
    pub fn caption(&mut self, text: impl Into<String>) {
        self.record.caption = text.into();
    }

    /// Something to know before believing the numbers.
    pub fn note(&mut self, text: impl Into<String>) {
        let text = text.into();
        if !self.record.notes.contains(&text) {
            self.record.notes.push(text);
        }
    }

    /// Shows a picture that a command has put into the figure's folder.
    pub fn picture(&mut self, name: &str, caption: impl Into<String>) {
        self.record.items.push(Item::Picture { file: name.to_owned(), caption: caption.into() });
    }

    /// Puts a picture into the figure's folder and shows it.
    pub fn paint(&mut self, name: &str, picture: &Picture, caption: impl Into<String>) -> Result<(), ReproError> {
        picture.write_png(&self.path(name), &[("Software", "gradtess")])?;
        self.picture(name, caption);
        Ok(())
    }

    /// Reads a picture of the figure's folder.
    pub fn read_picture(&self, name: &str) -> Result<Picture, ReproError> {
        Ok(Picture::read_png(&self.path(name))?)
    }

    /// Puts an SVG into the figure's folder and shows it.
    pub fn plot(&mut self, name: &str, svg: &str, caption: impl Into<String>) -> Result<(), ReproError> {
        self.write(name, svg)?;
        self.record.items.push(Item::Plot { file: name.to_owned(), caption: caption.into() });
        Ok(())
    }

    /// Puts a table into the figure's folder as CSV and shows it.
    ///
    /// # Panics
    /// When a row has not as many cells as there are columns.
    pub fn table(
        &mut self,
        name: &str,
        columns: &[&str],
        rows: Vec<Vec<String>>,
        caption: impl Into<String>,
    ) -> Result<(), ReproError> {
        assert!(rows.iter().all(|row| row.len() == columns.len()), "{name}: {columns:?}");
        let columns: Vec<String> = columns.iter().map(|&c| c.to_owned()).collect();
        let line = |cells: &Vec<String>| cells.iter().map(|c| csv_cell(c)).collect::<Vec<_>>().join(",") + "\n";
        let text: String = std::iter::once(&columns).chain(&rows).map(line).collect();
        self.write(name, &text)?;
        self.record.items.push(Item::Table { file: name.to_owned(), caption: caption.into(), columns, rows });
        Ok(())
    }
}

/// Words of a command.
fn words(command: &str) -> Vec<String> {
    let mut words = Vec::new();
    for (i, part) in command.split('\'').enumerate() {
        if i % 2 == 1 {
            words.push(part.to_owned());
        } else {
            words.extend(part.split_whitespace().map(str::to_owned));
        }
    }
    words
}

fn csv_cell(cell: &str) -> String {
    if cell.contains(['"', ',', '\n', '\r']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_owned()
    }
}

/// The number at `pointer` (RFC 6901) of what a command has printed, as it stands there; `NA` where there is none.
pub fn cell(value: &Value, pointer: &str) -> String {
    match value.pointer(pointer) {
        Some(Value::Number(n)) => n.to_string(),
        Some(Value::String(s)) => s.clone(),
        Some(Value::Bool(b)) => b.to_string(),
        _ => "NA".to_owned(),
    }
}

/// The number at `pointer`; NaN where there is none.
pub fn number(value: &Value, pointer: &str) -> f64 {
    value.pointer(pointer).and_then(Value::as_f64).unwrap_or(f64::NAN)
}

/// Files under a folder, relative, in order; not deeper than the trees of the authors' repositories.
pub fn files_under(folder: &Path) -> Result<Vec<String>, ReproError> {
    fn walk(folder: &Path, prefix: &str, depth: u32, found: &mut Vec<String>) -> Result<(), ReproError> {
        for entry in std::fs::read_dir(folder).map_err(|e| ReproError::file(folder, e))? {
            let entry = entry.map_err(|e| ReproError::file(folder, e))?;
            let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
            // A command's words are parted by blanks.
            if name.contains(char::is_whitespace) || name.contains("/.") || name.starts_with('.') {
                continue;
            }
            if entry.path().is_dir() {
                if depth > 0 {
                    walk(&entry.path(), &format!("{name}/"), depth - 1, found)?;
                }
            } else {
                found.push(name);
            }
        }
        Ok(())
    }
    let mut found = Vec::new();
    walk(folder, "", 6, &mut found)?;
    found.sort();
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quoted_words_keep_their_blanks() {
        assert_eq!(words("bench a  b --pair '--tess 2' -o c"), ["bench", "a", "b", "--pair", "--tess 2", "-o", "c"]);
        assert_eq!(csv_cell("a,\"b\""), "\"a,\"\"b\"\"\"");
    }
}
