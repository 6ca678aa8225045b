//! Files that are either complete or absent.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

use super::OutputError;

/// Suffix of an incomplete file.
pub const PART: &str = ".part";

/// Lets `write` fill a temporary file beside `path` and renames it to `path` when it is complete.
///
/// # Errors
/// If the file cannot be written. A file that was at `path` before is unchanged.
pub fn atomically(
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

/// Writes a whole file, see [`atomically`].
///
/// # Errors
/// If the file cannot be written.
pub fn write_atomic(path: &Path, content: impl AsRef<[u8]>) -> Result<(), OutputError> {
    atomically(path, |temporary| fs::write(temporary, content))
}

/// Writes a whole file so that it survives a crash of the machine, see [`durably`].
///
/// # Errors
/// If the file cannot be written.
pub fn write_durable(path: &Path, content: impl AsRef<[u8]>) -> Result<(), OutputError> {
    durably(path, |file| file.write_all(content.as_ref()))
}

/// Lets `write` fill a file so that it survives a crash of the machine. Without this, the name may
/// reach the disk before the content, which leaves an empty file. It takes some milliseconds.
///
/// # Errors
/// If the file cannot be written. A file that was at `path` before is unchanged.
pub fn durably(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> Result<(), OutputError> {
    atomically(path, |temporary| {
        let mut file = File::create(temporary)?;
        write(&mut file)?;
        file.sync_all()
    })
}

/// Forces the content of a file to the disk.
///
/// # Errors
/// If the system reports an error.
pub fn sync(path: &Path) -> io::Result<()> {
    OpenOptions::new().write(true).open(path)?.sync_all()
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
