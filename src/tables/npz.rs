//! Tables as a `.npz` archive, and back.

use std::fmt::Display;
use std::io::{Cursor, Read, Write};

use zip::write::SimpleFileOptions;

use super::{TableError, Tables, npy};

/// Maximum size of an unpacked archive, bytes: the state of five million bonded disks has a third
/// of it. A hostile archive may unpack to any size.
const MAX_BYTES: u64 = 16_000_000_000;

fn failed(error: impl Display) -> TableError {
    TableError::Archive(error.to_string())
}

impl Tables {
    /// The tables as an archive.
    ///
    /// # Errors
    /// If an array does not fit into an archive.
    pub fn encode(&self) -> Result<Vec<u8>, TableError> {
        // Dates of 1980 and these permissions stand for the clock and the machine. Numbers of a
        // simulation shrink by 1 % more at level 6.
        let options = SimpleFileOptions::default()
            .compression_method(zip::CompressionMethod::Deflated)
            .compression_level(Some(1))
            .last_modified_time(zip::DateTime::DEFAULT)
            .unix_permissions(0o644);
        let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (name, array) in self.iter() {
            let bytes = npy::encode(array);
            let options = options.large_file(bytes.len() as u64 >= u64::from(u32::MAX));
            archive.start_file(format!("{name}.npy"), options).map_err(failed)?;
            archive.write_all(&bytes).map_err(failed)?;
        }
        Ok(archive.finish().map_err(failed)?.into_inner())
    }

    /// The tables of an archive.
    ///
    /// # Errors
    /// If it is no archive, is damaged (every array has a checksum), or holds something else than
    /// arrays.
    pub fn decode(bytes: &[u8]) -> Result<Self, TableError> {
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(failed)?;
        let mut tables = Self::default();
        let mut left = MAX_BYTES;
        for index in 0..archive.len() {
            let file = archive.by_index(index).map_err(failed)?;
            let full = file.name().map_err(failed)?.into_owned();
            let Some(name) = full.strip_suffix(".npy") else {
                return Err(failed(format_args!("it has a file `{full}`")));
            };
            let mut values = Vec::new();
            let read = file.take(left + 1).read_to_end(&mut values);
            read.map_err(|error| TableError::at(name, error.to_string()))?;
            left = left
                .checked_sub(values.len() as u64)
                .ok_or_else(|| failed(format_args!("it unpacks to more than {MAX_BYTES} bytes")))?;
            if tables.get(name).is_ok() {
                return Err(TableError::at(name, "there twice"));
            }
            let array = npy::decode(&values).map_err(|what| TableError::at(name, what))?;
            tables.put(name, array);
        }
        Ok(tables)
    }
}
