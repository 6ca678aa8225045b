//! CSV files that are written row by row.

use std::fmt::{Display, Write as _};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::PathBuf;

use super::directory::lock;
use super::error::{OutputError, ResumeError};

/// A CSV file that contains complete rows only.
#[derive(Debug)]
pub struct CsvFile {
    path: PathBuf,
    file: File,
    length: u64,
}

impl CsvFile {
    /// Creates the file with its header.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(
        path: PathBuf,
        header: impl IntoIterator<Item = impl AsRef<str>>,
    ) -> Result<Self, OutputError> {
        let file = File::create(&path).map_err(OutputError::at(&path))?;
        Self::with_header(path, file, header)
    }

    /// Starts an open and locked file anew. Its former content is dropped.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn begin(
        path: PathBuf,
        file: File,
        header: impl IntoIterator<Item = impl AsRef<str>>,
    ) -> Result<Self, OutputError> {
        file.set_len(0).map_err(OutputError::at(&path))?;
        Self::with_header(path, file, header)
    }

    fn with_header(
        path: PathBuf,
        file: File,
        header: impl IntoIterator<Item = impl AsRef<str>>,
    ) -> Result<Self, OutputError> {
        let mut csv = Self { path, file, length: 0 };
        let row = header.into_iter().fold(Row::default(), |row, name| row.text(name.as_ref()));
        csv.push(row)?;
        Ok(csv)
    }

    /// Opens a file whose first `length` bytes are kept. The file does not change before
    /// [`cut`](Self::cut).
    ///
    /// # Errors
    /// If the file cannot be opened, is shorter, or has no end of a row at this position.
    pub fn open(path: PathBuf, length: u64) -> Result<Self, ResumeError> {
        let cut = |what: String| ResumeError::Cut { path: path.clone(), what };
        let at = || OutputError::at(&path);
        let mut file = OpenOptions::new().read(true).write(true).open(&path).map_err(at())?;
        let found = file.metadata().map_err(at())?.len();
        if found < length {
            let what = format!("{found} bytes, but {length} when the checkpoint was written");
            return Err(cut(what));
        }
        let mut last = [0];
        file.seek(SeekFrom::Start(length.saturating_sub(1))).map_err(at())?;
        if length == 0 || file.read_exact(&mut last).is_err() || last != *b"\n" {
            return Err(cut(
                "its rows differ from those when the checkpoint was written".to_owned()
            ));
        }
        Ok(Self { path, file, length })
    }

    /// Drops the rows that were written after the checkpoint.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn cut(&mut self) -> Result<(), OutputError> {
        let end = SeekFrom::Start(self.length);
        let done = self.file.set_len(self.length).and_then(|()| self.file.seek(end).map(|_| ()));
        done.map_err(OutputError::at(&self.path))
    }

    /// Locks the file while it is open. Returns whether it was unlocked.
    #[must_use]
    pub fn lock(&self) -> bool {
        lock(&self.file)
    }

    /// Size of the complete rows, bytes.
    #[must_use]
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Flushes the rows to the disk.
    ///
    /// # Errors
    /// If the system reports an error.
    pub fn sync(&self) -> Result<(), OutputError> {
        self.file.sync_data().map_err(OutputError::at(&self.path))
    }

    /// Verifies that the file still exists under its name. The rows written to a file whose
    /// directory was removed would be lost.
    ///
    /// # Errors
    /// If the file does not exist.
    pub fn is_there(&self) -> Result<(), OutputError> {
        let gone = |error: io::Error| match error.kind() {
            io::ErrorKind::NotFound => {
                io::Error::new(error.kind(), "removed or moved while the run was writing it")
            }
            _ => error,
        };
        fs::metadata(&self.path).map(|_| ()).map_err(|e| OutputError::at(&self.path)(gone(e)))
    }

    /// Appends a row, in one write.
    ///
    /// # Errors
    /// If the row cannot be written. The file then ends with the previous row.
    pub fn push(&mut self, row: Row) -> Result<(), OutputError> {
        let line = row.line();
        if let Err(error) = self.file.write_all(line.as_bytes()).and_then(|()| self.file.flush()) {
            // An incomplete row would make the file unreadable.
            let _ = self.file.set_len(self.length);
            return Err(OutputError::at(&self.path)(error));
        }
        self.length += line.len() as u64;
        Ok(())
    }
}

/// A row of a CSV file.
#[derive(Clone, Debug, Default)]
pub struct Row(String);

impl Row {
    /// Adds a text, quoted if necessary.
    #[must_use]
    pub fn text(mut self, text: &str) -> Self {
        if text.contains([',', '"', '\n', '\r']) {
            self.field(format_args!("\"{}\"", text.replace('"', "\"\"")));
        } else {
            self.field(text);
        }
        self
    }

    /// Adds an integer.
    #[must_use]
    pub fn count(mut self, count: impl Into<u64>) -> Self {
        self.field(count.into());
        self
    }

    /// Adds a number with the fewest digits that give the number back on reading.
    #[must_use]
    pub fn number(mut self, number: f64) -> Self {
        // Adding zero changes -0 to 0, whose sign has no meaning.
        self.field(format_args!("{:?}", number + 0.0));
        self
    }

    /// Adds several numbers.
    #[must_use]
    pub fn numbers(self, numbers: impl IntoIterator<Item = f64>) -> Self {
        numbers.into_iter().fold(self, Self::number)
    }

    /// Adds several numbers, or empty fields for those that are not defined.
    #[must_use]
    pub fn optionals(self, numbers: impl IntoIterator<Item = Option<f64>>) -> Self {
        numbers.into_iter().fold(self, Self::optional)
    }

    /// Adds a number, or an empty field if it is not defined.
    #[must_use]
    pub fn optional(mut self, number: Option<f64>) -> Self {
        match number {
            Some(number) => self.number(number),
            None => {
                self.field("");
                self
            }
        }
    }

    /// The row as a line of text.
    #[must_use]
    pub fn line(mut self) -> String {
        // Every field ends with a comma, and the last comma becomes the end of the line.
        self.0.pop();
        self.0.push('\n');
        self.0
    }

    fn field(&mut self, value: impl Display) {
        // Writing to a string cannot fail.
        let _ = write!(self.0, "{value},");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_plain_csv_and_numbers_read_back() -> Result<(), Box<dyn std::error::Error>> {
        let row =
            Row::default().count(3_u32).text("a, \"b\"").optional(None).numbers([0.1, -0.0, 1e-9]);
        assert_eq!(row.line(), "3,\"a, \"\"b\"\"\",,0.1,0.0,1e-9\n");
        let third = 1.0 / 3.0;
        assert_eq!(
            Row::default().number(third).line().trim().parse::<f64>()?.to_bits(),
            third.to_bits()
        );
        Ok(())
    }

    #[test]
    fn an_empty_last_field_stays_a_field() {
        assert_eq!(Row::default().number(1.0).optional(None).line(), "1.0,\n");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_disk_is_an_error_that_names_the_file() {
        let full = CsvFile::create("/dev/full".into(), ["a"]);
        assert!(full.is_err_and(|e| e.to_string().starts_with("/dev/full: ")));
    }
}
