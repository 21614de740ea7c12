//! Reading and writing whole files: bounded, and never half-written.

use super::SceneError;
use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

/// Largest scene file that is read, in bytes.
pub const LARGEST_FILE: u64 = 1 << 30;

/// The bytes of the file at `path`.
///
/// # Errors
/// [`SceneError::Read`] when it cannot be read, [`SceneError::Content`] when it is larger than [`LARGEST_FILE`].
pub fn read_bounded(path: &Path) -> Result<Vec<u8>, SceneError> {
    let name = path.display().to_string();
    let read = |source| SceneError::Read { file: name.clone(), source };
    let mut bytes = Vec::new();
    // A pipe or a growing file has no reliable length beforehand, so the reading itself is bounded.
    File::open(path).map_err(read)?.take(LARGEST_FILE + 1).read_to_end(&mut bytes).map_err(read)?;
    if bytes.len() as u64 > LARGEST_FILE {
        let what = format!("the file is larger than {LARGEST_FILE} bytes");
        return Err(SceneError::content(&name, 1, 1, what, "split the scene into smaller ones"));
    }
    Ok(bytes)
}

/// Puts `bytes` at `path`: they go to a temporary name in the same folder, which is then renamed, so that a reader
/// sees either the old file or the new one.
///
/// # Errors
/// [`SceneError::Write`]; the temporary file is removed and the old file stays.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), SceneError> {
    let temporary = temporary_beside(path);
    let written = File::create(&temporary)
        .and_then(|mut file| {
            file.write_all(bytes)?;
            file.sync_all()
        })
        .and_then(|()| std::fs::rename(&temporary, path));
    written.map_err(|source| {
        // The first failure is the one to report; a left-over temporary file is the lesser evil.
        let _ = std::fs::remove_file(&temporary);
        SceneError::write(path, source)
    })
}

/// A name beside `path` that no other process or thread uses.
fn temporary_beside(path: &Path) -> PathBuf {
    use std::sync::atomic::{AtomicU32, Ordering};
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.{}.part", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed)));
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replaces_the_old_file_and_leaves_nothing_else() {
        let folder = std::env::temp_dir().join(format!("gradtess-file-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.json");
        write_atomically(&path, b"old").unwrap();
        write_atomically(&path, b"new").unwrap();
        assert_eq!(read_bounded(&path).unwrap(), b"new");
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn failures_name_the_file_and_whose_fault_it_is() {
        let missing = Path::new("no/such/folder/a.json");
        let error = write_atomically(missing, b"").unwrap_err();
        assert!(error.is_machine_failure() && error.to_string().starts_with("no/such/folder/a.json: "));
        assert!(!read_bounded(missing).unwrap_err().is_machine_failure());
    }
}
