//! Tables as a `.npz` archive, and back.

use super::{TableError, Tables};

/// Maximum size of an unpacked archive, bytes: the state of five million bonded disks has a third
/// of it. A hostile archive may unpack to any size.
#[cfg(feature = "npz")]
const MAX_BYTES: u64 = 16_000_000_000;

#[cfg(feature = "npz")]
impl Tables {
    /// The archive.
    ///
    /// # Errors
    /// If an array does not fit into an archive.
    pub fn encode(&self) -> Result<Vec<u8>, TableError> {
        use std::io::{Cursor, Write};
        use zip::write::SimpleFileOptions;

        let failed = |error: &dyn std::fmt::Display| TableError::Archive(error.to_string());
        // Dates of 1980 and these permissions stand for the clock and the machine. Numbers of a
        // simulation shrink by 1 % more at level 6.
        let options = SimpleFileOptions::default()
            .compression_method(zip::CompressionMethod::Deflated)
            .compression_level(Some(1))
            .last_modified_time(zip::DateTime::DEFAULT)
            .unix_permissions(0o644);
        let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (name, array) in self.iter() {
            let bytes = super::npy::encode(array);
            let options = options.large_file(bytes.len() as u64 >= u64::from(u32::MAX));
            archive.start_file(format!("{name}.npy"), options).map_err(|e| failed(&e))?;
            archive.write_all(&bytes).map_err(|e| failed(&e))?;
        }
        Ok(archive.finish().map_err(|e| failed(&e))?.into_inner())
    }

    /// The tables of an archive.
    ///
    /// # Errors
    /// If it is no archive, is damaged (every array has a checksum), or holds something else than
    /// arrays.
    pub fn decode(bytes: &[u8]) -> Result<Self, TableError> {
        use std::io::{Cursor, Read};

        let failed = |error: &dyn std::fmt::Display| TableError::Archive(error.to_string());
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(|e| failed(&e))?;
        let mut tables = Self::default();
        let mut left = MAX_BYTES;
        for index in 0..archive.len() {
            let file = archive.by_index(index).map_err(|e| failed(&e))?;
            let full = file.name().map_err(|e| failed(&e))?.into_owned();
            let Some(name) = full.strip_suffix(".npy") else {
                return Err(TableError::Archive(format!("it has a file `{full}`")));
            };
            let mut values = Vec::new();
            let read = file.take(left + 1).read_to_end(&mut values);
            read.map_err(|error| TableError::at(name, error.to_string()))?;
            left = left.checked_sub(values.len() as u64).ok_or_else(|| {
                TableError::Archive(format!("it unpacks to more than {MAX_BYTES} bytes"))
            })?;
            if tables.has(name) {
                return Err(TableError::at(name, "there twice"));
            }
            let array = super::npy::decode(&values).map_err(|what| TableError::at(name, what))?;
            tables.put(name, array);
        }
        Ok(tables)
    }
}

#[cfg(not(feature = "npz"))]
impl Tables {
    /// The archive; this build has none.
    ///
    /// # Errors
    /// Always, since the program is built without the feature `npz`.
    pub fn encode(&self) -> Result<Vec<u8>, TableError> {
        Err(TableError::Unsupported)
    }

    /// The tables of an archive; this build reads none.
    ///
    /// # Errors
    /// Always, since the program is built without the feature `npz`.
    pub fn decode(_: &[u8]) -> Result<Self, TableError> {
        Err(TableError::Unsupported)
    }
}
