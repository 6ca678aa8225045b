//! An array: a shape, and values row by row.

use super::{TableError, Tables};

/// Values of an array.
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// `float64`.
    F64(Vec<f64>),
    /// `float32`.
    F32(Vec<f32>),
    /// `uint32`.
    U32(Vec<u32>),
    /// `uint64`.
    U64(Vec<u64>),
    /// `uint8`.
    U8(Vec<u8>),
    /// `bool`.
    Bool(Vec<bool>),
    /// Short texts: numpy's `str`, which pads all texts of an array to one length and drops NUL
    /// characters at their end.
    Text(Vec<String>),
}

/// A type of the values of an array.
pub trait Value: Clone {
    /// Values as those of an array.
    fn data(values: Vec<Self>) -> Data;
    /// The values of an array, if they have this type.
    fn values(data: &Data) -> Option<&[Self]>;
    /// Name of the type in numpy.
    const NAME: &'static str;
}

/// Types with their variants of [`Data`] and their names in numpy.
macro_rules! values {
    ($($type:ty: $variant:ident $name:literal),*) => {
        $(impl Value for $type {
            const NAME: &'static str = $name;

            fn data(values: Vec<Self>) -> Data {
                Data::$variant(values)
            }

            fn values(data: &Data) -> Option<&[Self]> {
                if let Data::$variant(values) = data { Some(values) } else { None }
            }
        })*

        impl Data {
            /// Name of the type in numpy.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$variant(_) => $name),* }
            }
        }
    };
}

values!(f64: F64 "float64", f32: F32 "float32", u32: U32 "uint32", u64: U64 "uint64", u8: U8 "uint8",
    bool: Bool "bool", String: Text "str");

/// An array of any shape; the last index varies fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Length of every dimension; none for a single value.
    pub shape: Vec<usize>,
    /// The values.
    pub data: Data,
}

impl Array {
    /// A column of values.
    pub fn column<T: Value>(values: impl IntoIterator<Item = T>) -> Self {
        let values: Vec<T> = values.into_iter().collect();
        Self { shape: vec![values.len()], data: T::data(values) }
    }

    /// A table with `N` values a row.
    pub fn vectors<T: Value, const N: usize>(rows: impl IntoIterator<Item = [T; N]>) -> Self {
        let values: Vec<T> = rows.into_iter().flatten().collect();
        Self { shape: vec![values.len() / N, N], data: T::data(values) }
    }

    /// A single value.
    pub fn single<T: Value>(value: T) -> Self {
        Self { shape: Vec::new(), data: T::data(vec![value]) }
    }
}

/// Values of one type that are an array.
pub(crate) trait Column: Sized {
    /// The values as an array.
    fn array(&self) -> Array;
    /// Reads the array `name`, which must have this number of rows.
    fn read(tables: &Tables, name: &str, rows: usize) -> Result<Self, TableError>;
}

impl<T: Value> Column for Vec<T> {
    fn array(&self) -> Array {
        Array::column(self.iter().cloned())
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
