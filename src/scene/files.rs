//! Reads the files of a scene: its text, and the stored specimen that it names.

use std::fs::{self, FileType};
use std::io::{self, Read};
use std::path::Path;

use super::shipped;
use crate::text::diagnostic::{Finding, Placed};

/// Reads a regular file. Returns `None` if it is larger than `most` bytes, and reads at most one
/// byte more than that.
pub(crate) fn read_at_most(path: &Path, most: u64) -> io::Result<Option<Vec<u8>>> {
    if let Some(text) = shipped::content(path) {
        return Ok(Some(text.to_vec()));
    }
    let kind = fs::metadata(path)?.file_type();
    if !kind.is_file() {
        let message = format!("it is {}, not a regular file", name(kind));
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    let mut bytes = Vec::new();
    fs::File::open(path)?.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    Ok(Some(bytes).filter(|bytes| bytes.len() as u64 <= most))
}

/// Text of a file. A text that is no UTF-8 comes with its first mistake, for which `help` is the
/// remedy.
pub(super) fn decode(bytes: Vec<u8>, help: &str) -> Result<String, (String, Placed)> {
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let byte = error.as_bytes().get(at).copied().unwrap_or_default();
        let message = format!("not UTF-8 text (byte 0x{byte:02x})");
        let finding = Finding::new("", message, help);
        (String::from_utf8_lossy(error.as_bytes()).into_owned(), Placed { at, finding })
    })
}

/// Name of the kind of a file that is not regular.
fn name(kind: FileType) -> &'static str {
    #[cfg(unix)]
    use std::os::unix::fs::FileTypeExt as _;

    match kind {
        _ if kind.is_dir() => "a directory",
        #[cfg(unix)]
        _ if kind.is_fifo() => "a named pipe",
        #[cfg(unix)]
        _ if kind.is_socket() => "a socket",
        _ => "a device",
    }
}
