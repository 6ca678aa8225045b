//! Columns by the type of their values.

use super::{Array, TableError, Tables};

/// Values of one type that are an array.
pub(crate) trait Column: Sized {
    /// The values as an array.
    fn array(&self) -> Array;
    /// Reads the array `name`, which must have this number of rows.
    fn read(tables: &Tables, name: &str, rows: usize) -> Result<Self, TableError>;
}

/// A column of single values.
macro_rules! single {
    ($($type:ty: $name:ident),*) => {$(
        impl Column for Vec<$type> {
            fn array(&self) -> Array {
                Array::$name(self.clone())
            }

            fn read(tables: &Tables, name: &str, rows: usize) -> Result<Self, TableError> {
                Ok(tables.$name(name, &[rows])?.to_vec())
            }
        }
    )*};
}

single!(u32: u32, u8: u8, f32: f32, bool: bool, String: text);

impl<const N: usize> Column for Vec<[f32; N]> {
    fn array(&self) -> Array {
        Array::f32_rows(self)
    }

    fn read(tables: &Tables, name: &str, rows: usize) -> Result<Self, TableError> {
        tables.f32_rows(name, rows)
    }
}

impl<const N: usize> Column for Vec<[f64; N]> {
    fn array(&self) -> Array {
        Array::vectors(self.iter().copied())
    }

    fn read(tables: &Tables, name: &str, rows: usize) -> Result<Self, TableError> {
        tables.vectors(name, rows)
    }
}
