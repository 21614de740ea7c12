//! The output folder: which figures are made, kept or merged.

use super::record::{Origin, Record, SCHEMA};
use super::sheet::{files_under, Setting, Sheet};
use super::{report, Figure, ReproError, FIGURES};
use crate::scene::write_atomically;
use std::path::{Path, PathBuf};

/// One part of several: figures `index`, `index + of`, ... of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// From 0.
    pub index: usize,
    /// Parts there are.
    pub of: usize,
}

/// What to make.
pub struct Request {
    /// Folder for everything.
    pub output: PathBuf,
    /// Folder of the authors' models.
    pub models: Option<PathBuf>,
    /// Names or beginnings of names; empty: all.
    pub only: Vec<String>,
    /// A part of those.
    pub shard: Option<Shard>,
    /// Flags for every command.
    pub flags: Vec<String>,
    /// What makes the figures.
    pub origin: Origin,
}

/// What was made.
pub struct Outcome {
    /// Figures made now.
    pub made: Vec<&'static str>,
    /// Figures that were there already.
    pub kept: Vec<&'static str>,
    /// Figures that could not be made.
    pub failed: Vec<(&'static str, ReproError)>,
    /// The report.
    pub report: PathBuf,
}

/// The figures that a request names.
///
/// # Errors
/// A name that no figure has.
pub fn plan(only: &[String], shard: Option<Shard>) -> Result<Vec<&'static Figure>, ReproError> {
    // `zhhk22-fig20`, `fig20`, or `zhhk22` for all of a paper.
    let matches = |figure: &Figure, name: &str| {
        let name = name.to_lowercase();
        figure.id == name || figure.id.split_once('-').is_some_and(|(paper, rest)| paper == name || rest == name)
    };
    for name in only {
        if !FIGURES.iter().any(|figure| matches(figure, name)) {
            let ids: Vec<&str> = FIGURES.iter().map(|figure| figure.id).collect();
            return Err(ReproError::Request(format!("there is no figure {name:?}; choose from {}", ids.join(", "))));
        }
    }
    let chosen = FIGURES.iter().filter(|figure| only.is_empty() || only.iter().any(|name| matches(figure, name)));
    let part = |i: usize| shard.is_none_or(|shard| i % shard.of == shard.index);
    Ok(chosen.enumerate().filter(|(i, _)| part(*i)).map(|(_, figure)| figure).collect())
}

/// Makes the figures that are not there yet, then the report of all that are. `progress` hears of each figure before it
/// is made. A figure that fails does not keep the others from being made.
///
/// # Errors
/// The request makes no sense, or the folder cannot be written.
pub fn run(request: Request, mut progress: impl FnMut(&Figure, usize, usize)) -> Result<Outcome, ReproError> {
    let figures = plan(&request.only, request.shard)?;
    let models = match request.models {
        None => None,
        Some(folder) => {
            let shown = folder.display().to_string();
            let folder = folder.canonicalize().map_err(|e| ReproError::Request(format!("--models {shown}: {e}")))?;
            if !folder.is_dir() {
                return Err(ReproError::Request(format!("--models {shown}: this is no folder; give one with models")));
            }
            let files = files_under(&folder)?;
            Some((folder, files))
        }
    };
    let setting = Setting { output: request.output, models, flags: request.flags, origin: request.origin };
    make_folder(&setting.output.join("figures"))?;
    let mut outcome =
        Outcome { made: Vec::new(), kept: Vec::new(), failed: Vec::new(), report: setting.output.join("report.html") };
    for (i, figure) in figures.iter().enumerate() {
        let folder = setting.output.join("figures").join(figure.id);
        if read(&folder).is_some_and(|record| record.origin == setting.origin) {
            outcome.kept.push(figure.id);
            continue;
        }
        progress(figure, i, figures.len());
        let made = Sheet::new(figure, &setting).and_then(|mut sheet| {
            (figure.make)(&mut sheet)?;
            sheet.finish()
        });
        match made {
            Ok(()) => {
                outcome.made.push(figure.id);
                // So that there is something to look at, and it survives an interruption.
                write_report(&setting.output)?;
            }
            Err(e) => outcome.failed.push((figure.id, e)),
        }
    }
    write_report(&setting.output)?;
    Ok(outcome)
}

/// Copies the finished figures of other output folders into one, and makes its report. The same figure made by another
/// program, on another device or by another protocol stands beside the first. Returns the report and how many figures
/// were copied.
///
/// # Errors
/// A folder that has no figures, or cannot be read or written.
pub fn merge(output: &Path, folders: &[PathBuf]) -> Result<(PathBuf, usize), ReproError> {
    let mut copied = 0;
    for folder in folders {
        let from = all(folder)?;
        if from.is_empty() {
            return Err(ReproError::Request(format!(
                "{}: there are no finished figures in it; give a folder that repro has written",
                folder.display()
            )));
        }
        make_folder(&output.join("figures"))?;
        for (source, record) in from {
            let Some(target) = place(output, &record) else { continue };
            copy_folder(&source, &target)?;
            copied += 1;
        }
        let scenes = folder.join("scenes");
        if scenes.is_dir() {
            copy_folder(&scenes, &output.join("scenes"))?;
        }
    }
    Ok((write_report(output)?, copied))
}

/// Where a merged figure goes; `None` when the same is there.
fn place(output: &Path, record: &Record) -> Option<PathBuf> {
    let mut n = 1;
    loop {
        let name = if n == 1 { record.id.clone() } else { format!("{}.{n}", record.id) };
        let target = output.join("figures").join(name);
        match read(&target) {
            None => return Some(target),
            Some(there) if there.origin == record.origin => return None,
            Some(_) => n += 1,
        }
    }
}

/// Copies a folder; `figure.json`, which says that it is whole, last.
fn copy_folder(from: &Path, to: &Path) -> Result<(), ReproError> {
    make_folder(to)?;
    let mut names: Vec<PathBuf> = std::fs::read_dir(from)
        .and_then(|entries| entries.map(|entry| entry.map(|e| e.path())).collect())
        .map_err(|e| ReproError::file(from, e))?;
    names.sort_by_key(|path| path.ends_with("figure.json"));
    for path in names {
        let target = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            copy_folder(&path, &target)?;
        } else {
            let bytes = std::fs::read(&path).map_err(|e| ReproError::file(&path, e))?;
            write_atomically(&target, &bytes)?;
        }
    }
    Ok(())
}

fn make_folder(folder: &Path) -> Result<(), ReproError> {
    std::fs::create_dir_all(folder).map_err(|e| ReproError::file(folder, e))
}

/// The record of a finished figure: one whose files are all there.
fn read(folder: &Path) -> Option<Record> {
    let record: Record = serde_json::from_slice(&std::fs::read(folder.join("figure.json")).ok()?).ok()?;
    let whole = record.items.iter().all(|item| folder.join(item.file()).is_file());
    (record.schema == SCHEMA && whole).then_some(record)
}

/// All finished figures of an output folder with their folders, in the order of the report.
fn all(output: &Path) -> Result<Vec<(PathBuf, Record)>, ReproError> {
    let folder = output.join("figures");
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let mut found = Vec::new();
    for entry in std::fs::read_dir(&folder).map_err(|e| ReproError::file(&folder, e))? {
        let path = entry.map_err(|e| ReproError::file(&folder, e))?.path();
        found.extend(read(&path).map(|record| (path, record)));
    }
    let number = |id: &str| FIGURES.iter().position(|figure| figure.id == id).unwrap_or(FIGURES.len());
    found.sort_by_key(|(path, record)| (number(&record.id), path.clone()));
    Ok(found)
}

fn write_report(output: &Path) -> Result<PathBuf, ReproError> {
    let path = output.join("report.html");
    let html = report::html(&all(output)?)?;
    write_atomically(&path, html.as_bytes())?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_part_the_figures_and_names_choose_them() {
        let ids = |figures: Vec<&Figure>| figures.iter().map(|figure| figure.id).collect::<Vec<_>>();
        let whole = ids(plan(&[], None).unwrap());
        assert_eq!(whole.len(), FIGURES.len());
        let mut parts: Vec<&str> =
            (0..3).flat_map(|index| ids(plan(&[], Some(Shard { index, of: 3 })).unwrap())).collect();
        parts.sort_by_key(|id| whole.iter().position(|other| other == id));
        assert_eq!(parts, whole);
        assert_eq!(ids(plan(&["ZHHK22-Fig18".to_owned()], None).unwrap()), ["zhhk22-fig18"]);
        // Of all papers that have one.
        assert!(ids(plan(&["Fig18".to_owned()], None).unwrap()).contains(&"blhk18-fig18"));
        assert!(matches!(plan(&["fig99".to_owned()], None), Err(ReproError::Request(_))));
    }

    #[test]
    fn names_are_unique_and_begin_with_the_paper() {
        for (i, figure) in FIGURES.iter().enumerate() {
            assert!(FIGURES[..i].iter().all(|other| other.id != figure.id), "{}", figure.id);
            assert!(figure.id.starts_with(&format!("{}-", figure.paper.to_lowercase())), "{}", figure.id);
        }
    }
}
