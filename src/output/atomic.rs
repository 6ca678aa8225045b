//! Files that are either complete or absent.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io;
use std::path::Path;

use super::OutputError;

/// Suffix of an incomplete file.
pub const PART: &str = ".part";

/// Lets `write` fill a temporary file beside `path` and renames it to `path` when it is complete. A
/// file that was at `path` before is unchanged after an error.
pub(crate) fn atomically(
    path: &Path,
    write: impl FnOnce(&Path) -> io::Result<()>,
) -> Result<(), OutputError> {
    let mut name = path.file_name().map_or_else(OsString::new, OsString::from);
    name.push(PART);
    let temporary = path.with_file_name(name);
    let done = write(&temporary).and_then(|()| fs::rename(&temporary, path));
    if done.is_err() {
        // The temporary file may not exist, and only the error above matters.
        let _ = fs::remove_file(&temporary);
    }
    done.map_err(OutputError::at(path))
}

/// Writes a whole file, which is complete or absent.
///
/// # Errors
/// If the file cannot be written.
pub fn write_atomic(path: &Path, content: impl AsRef<[u8]>) -> Result<(), OutputError> {
    atomically(path, |temporary| fs::write(temporary, content))
}

/// Lets `write` fill a file so that it survives a crash of the machine. Without this, the name may
/// reach the disk before the content, which leaves an empty file. It takes some milliseconds. A file
/// that was at `path` before is unchanged after an error.
pub(crate) fn durably(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> Result<(), OutputError> {
    atomically(path, |temporary| {
        let mut file = File::create(temporary)?;
        write(&mut file)?;
        file.sync_all()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_no_litter() -> Result<(), Box<dyn std::error::Error>>
    {
        let dir = tempfile::tempdir()?;
        let path = dir.path().join("run.json");
        write_atomic(&path, "old")?;
        let failed = atomically(&path, |temporary| {
            fs::write(temporary, "half")?;
            Err(io::Error::other("disk full"))
        });
        assert!(failed.is_err_and(|e| e.to_string().ends_with("run.json: disk full")));
        assert_eq!(fs::read_to_string(&path)?, "old");
        assert_eq!(fs::read_dir(dir.path())?.count(), 1);
        write_atomic(&path, "new")?;
        assert_eq!(fs::read_to_string(&path)?, "new");
        Ok(())
    }
}
