//! CSV files, which are written row by row.

use std::fmt::{self, Display, Write as _};
use std::fs::{File, OpenOptions};
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use csv::StringRecord;

use super::error::OutputError;

/// A CSV file that contains complete rows only.
#[derive(Debug)]
pub(crate) struct CsvFile {
    path: PathBuf,
    pub file: File,
    /// Size of the complete rows, bytes.
    pub length: u64,
}

impl CsvFile {
    pub(crate) fn create(path: PathBuf, header: Row) -> Result<Self, OutputError> {
        let file = File::create(&path).map_err(OutputError::at(&path))?;
        Self::begin(path, file, header)
    }

    /// Writes the header into an open and empty file.
    pub fn begin(path: PathBuf, file: File, header: Row) -> Result<Self, OutputError> {
        let mut csv = Self { path, file, length: 0 };
        csv.push(header)?;
        Ok(csv)
    }

    /// Opens a file whose first `length` bytes are kept. The file does not change before
    /// [`cut`](Self::cut). Refuses a file that is shorter, or has no end of a row at this position.
    pub fn open(path: PathBuf, length: u64) -> Result<Self, OutputError> {
        let at = || OutputError::at(&path);
        let cut = |what: &str| {
            OutputError::at(&path)(format!("{what}; run the scene again, with --force"))
        };
        let mut file = OpenOptions::new().read(true).write(true).open(&path).map_err(at())?;
        let found = file.metadata().map_err(at())?.len();
        if found < length {
            let what = format!("{found} bytes, but {length} when the checkpoint was written");
            return Err(cut(&what));
        }
        let mut last = [0];
        file.seek(SeekFrom::Start(length.saturating_sub(1))).map_err(at())?;
        if length == 0 || file.read_exact(&mut last).is_err() || last != *b"\n" {
            return Err(cut("its rows differ from those when the checkpoint was written"));
        }
        Ok(Self { path, file, length })
    }

    /// Drops the rows that were written after the checkpoint.
    pub fn cut(&mut self) -> Result<(), OutputError> {
        let end = SeekFrom::Start(self.length);
        let done = self.file.set_len(self.length).and_then(|()| self.file.seek(end).map(|_| ()));
        done.map_err(OutputError::at(&self.path))
    }

    pub fn sync(&self) -> Result<(), OutputError> {
        self.file.sync_data().map_err(OutputError::at(&self.path))
    }

    /// Verifies that the file still exists under its name. The rows written to a file whose
    /// directory was removed would be lost.
    pub fn is_there(&self) -> Result<(), OutputError> {
        let gone = || OutputError::at(&self.path)("removed or moved while the run was writing it");
        let is_there = self.path.try_exists().map_err(OutputError::at(&self.path))?;
        is_there.then_some(()).ok_or_else(gone)
    }

    /// Appends a row, in one write. If that fails, the file ends with the previous row.
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

/// A field of a CSV file.
#[derive(Clone, Copy, Debug)]
pub enum Field<'a> {
    /// A text, quoted if necessary.
    Text(&'a str),
    /// An integer.
    Count(u64),
    /// A number, with the fewest digits that give it back on reading.
    Number(f64),
    /// A value that is not defined.
    Empty,
}

impl Display for Field<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) if text.contains([',', '"', '\n', '\r']) => {
                write!(f, "\"{}\"", text.replace('"', "\"\""))
            }
            Self::Text(text) => f.write_str(text),
            Self::Count(count) => count.fmt(f),
            // Adding zero changes -0 to 0, whose sign has no meaning.
            Self::Number(number) => write!(f, "{:?}", number + 0.0),
            Self::Empty => Ok(()),
        }
    }
}

impl<'a> From<&'a str> for Field<'a> {
    fn from(text: &'a str) -> Self {
        Self::Text(text)
    }
}

impl From<u64> for Field<'_> {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl From<f64> for Field<'_> {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<Option<f64>> for Field<'_> {
    fn from(number: Option<f64>) -> Self {
        number.map_or(Self::Empty, Self::Number)
    }
}

/// A column of a table: its name, and its field in the row that describes a `T`.
pub type Column<T> = (&'static str, for<'a> fn(&'a T) -> Field<'a>);

/// The row that describes `of`.
pub fn row<T>(columns: &[Column<T>], of: &T) -> Row {
    Row::default().and(columns.iter().map(|(_, field)| field(of)))
}

/// The header of a table.
pub fn header<T>(columns: &[Column<T>]) -> Row {
    Row::default().and(names(columns))
}

/// Names of columns.
pub fn names<T>(columns: &[Column<T>]) -> impl Iterator<Item = &'static str> {
    columns.iter().map(|(name, _)| *name)
}

/// Reads the header and the rows of a CSV file.
pub(crate) fn read(path: &Path) -> Result<(StringRecord, Vec<StringRecord>), OutputError> {
    let mut reader = csv::Reader::from_path(path).map_err(OutputError::at(path))?;
    let header = reader.headers().map_err(OutputError::at(path))?.clone();
    let rows = reader.records().collect::<Result<_, _>>().map_err(OutputError::at(path))?;
    Ok((header, rows))
}

/// A row of a CSV file.
#[derive(Clone, Debug, Default)]
pub struct Row(String);

impl Row {
    /// Adds a field.
    pub fn with<'a>(mut self, field: impl Into<Field<'a>>) -> Self {
        // Every field ends with a comma. Writing to a string cannot fail.
        let _ = write!(self.0, "{},", field.into());
        self
    }

    /// Adds several fields.
    pub fn and<'a>(self, fields: impl IntoIterator<Item: Into<Field<'a>>>) -> Self {
        fields.into_iter().fold(self, Self::with)
    }

    /// The row as a line of text.
    pub fn line(mut self) -> String {
        // The last comma becomes the end of the line.
        self.0.pop();
        self.0.push('\n');
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_plain_csv_and_numbers_read_back() -> Result<(), Box<dyn std::error::Error>> {
        let row =
            Row::default().with(3_u64).with("a, \"b\"").with(Field::Empty).and([0.1, -0.0, 1e-9]);
        assert_eq!(row.line(), "3,\"a, \"\"b\"\"\",,0.1,0.0,1e-9\n");
        let third = 1.0 / 3.0;
        assert_eq!(
            Row::default().with(third).line().trim().parse::<f64>()?.to_bits(),
            third.to_bits()
        );
        Ok(())
    }

    #[test]
    fn an_empty_last_field_stays_a_field() {
        assert_eq!(Row::default().with(1.0).with(Field::Empty).line(), "1.0,\n");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_disk_is_an_error_that_names_the_file() {
        let full = CsvFile::create("/dev/full".into(), Row::default().with("a"));
        assert!(full.is_err_and(|e| e.to_string().starts_with("/dev/full: ")));
    }
}
