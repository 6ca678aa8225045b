//! A writer that hashes what it writes.

use std::io::{self, Write};

use sha2::{Digest, Sha256};

use super::run_record::hexadecimal;

/// Hashes bytes and writes them to the writer behind it. It keeps the first error of that writer,
/// since an encoder reports another one in its place.
pub(super) struct HashingWriter<W> {
    inner: W,
    hash: Sha256,
    error: Option<io::Error>,
}

impl<W: Write> HashingWriter<W> {
    pub(super) fn new(inner: W) -> Self {
        Self { inner, hash: Sha256::new(), error: None }
    }

    /// The SHA-256 hash of the content, in hexadecimal digits.
    pub(super) fn finish(self) -> io::Result<String> {
        match self.error {
            Some(error) => Err(error),
            None => Ok(hexadecimal(&self.hash.finalize())),
        }
    }

    fn keep(&mut self, done: io::Result<()>) -> io::Result<()> {
        done.map_err(|error| {
            let kind = error.kind();
            self.error.get_or_insert(error);
            kind.into()
        })
    }
}

impl<W: Write> Write for HashingWriter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let done = self.inner.write_all(bytes);
        self.keep(done)?;
        self.hash.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        let done = self.inner.flush();
        self.keep(done)
    }
}
