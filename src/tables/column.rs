//! Columns by the type of their values.

use super::{Array, TableError, Tables, Value};

/// Values of one type that are an array.
pub(crate) trait Column: Sized {
    /// The values as an array.
    fn array(&self) -> Array;
    /// Reads the array `name`, which must have this number of rows.
    fn read(tables: &Tables, name: &str, rows: usize) -> Result<Self, TableError>;
}

impl<T: Value> Column for Vec<T> {
    fn array(&self) -> Array {
        Array::column(self.clone())
    }

    fn read(tables: &Tables, name: &str, rows: usize) -> Result<Self, TableError> {
        Ok(tables.values(name, &[rows])?.to_vec())
    }
}

impl<T: Value, const N: usize> Column for Vec<[T; N]> {
    fn array(&self) -> Array {
        Array::vectors(self.iter().cloned())
    }

    fn read(tables: &Tables, name: &str, rows: usize) -> Result<Self, TableError> {
        Ok(tables.values(name, &[rows, N])?.as_chunks().0.to_vec())
    }
}
