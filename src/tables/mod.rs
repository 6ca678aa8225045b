//! Tables of numbers and short texts in one file that numpy reads: arrays by name, in a `.npz`
//! archive (a zip of `.npy` files). The bytes depend on the content alone.
//!
//! ```
//! use clastic::tables::{Array, Tables};
//!
//! let mut tables = Tables::default();
//! tables.put("radius_m", Array::column([1.0e-3, 2.0e-3]));
//! tables.put("name", Array::column(["sand".to_owned()]));
//! let read = Tables::decode(&tables.encode()?)?;
//! assert_eq!(read.values::<f64>("radius_m", &[2])?, [1.0e-3, 2.0e-3]);
//! # Ok::<(), clastic::tables::TableError>(())
//! ```

mod array;
mod npy;
mod npz;

use indexmap::IndexMap;

pub(crate) use array::Column;
pub use array::{Array, Data, Value};

/// Why tables cannot be written or read. The message names the array; the caller adds the file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TableError {
    /// The file is no archive of arrays, or it is damaged.
    #[error("not a .npz archive of numpy arrays: {0}")]
    Archive(String),
    /// An array has another type or shape, or is damaged.
    #[error("array `{name}`: {what}")]
    Array {
        /// Name of the array.
        name: String,
        /// What is wrong with it.
        what: String,
    },
    /// The file has no such array.
    #[error("no array `{0}`")]
    Missing(String),
    /// The arrays hold another kind of data, or that of another version of a format.
    #[error("{0}")]
    Foreign(String),
}

impl TableError {
    /// Error of one array.
    pub fn at(name: &str, what: impl Into<String>) -> Self {
        Self::Array { name: name.to_owned(), what: what.into() }
    }
}

/// Arrays by name, in the order in which they were added.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tables(IndexMap<String, Array>);

impl Tables {
    /// Adds an array, or replaces the array of this name.
    pub fn put(&mut self, name: &str, array: Array) {
        self.0.insert(name.to_owned(), array);
    }

    /// Names and arrays, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Array)> {
        self.0.iter().map(|(name, array)| (name.as_str(), array))
    }

    /// The array of this name.
    ///
    /// # Errors
    /// If there is none.
    pub fn get(&self, name: &str) -> Result<&Array, TableError> {
        self.0.get(name).ok_or_else(|| TableError::Missing(name.to_owned()))
    }

    /// Number of rows of an array: its first dimension; 1 for a single value.
    ///
    /// # Errors
    /// If there is no such array.
    pub fn rows(&self, name: &str) -> Result<usize, TableError> {
        Ok(self.get(name)?.shape.first().copied().unwrap_or(1))
    }

    /// The values of an array of this type and shape, row by row.
    ///
    /// # Errors
    /// If the array is missing or has another type or shape.
    pub fn values<T: Value>(&self, name: &str, shape: &[usize]) -> Result<&[T], TableError> {
        let array = self.get(name)?;
        let values = T::values(&array.data).ok_or_else(|| {
            let (found, expected) = (array.data.name(), T::NAME);
            TableError::at(name, format!("type `{found}` where `{expected}` is expected"))
        })?;
        if array.shape != shape {
            let what = format!("shape {:?} where {shape:?} is expected", array.shape);
            return Err(TableError::at(name, what));
        }
        Ok(values)
    }

    /// The value of an array without dimensions.
    ///
    /// # Errors
    /// As of [`values`](Self::values).
    pub fn single<T: Value>(&self, name: &str) -> Result<T, TableError> {
        Ok(self.values::<T>(name, &[])?[0].clone())
    }

    /// Rows of `N` numbers each: an array of the shape (`rows`, `N`).
    ///
    /// # Errors
    /// As of [`values`](Self::values).
    pub fn vectors<const N: usize>(
        &self,
        name: &str,
        rows: usize,
    ) -> Result<Vec<[f64; N]>, TableError> {
        Column::read(self, name, rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tables() -> Tables {
        let mut tables = Tables::default();
        tables.put("time_s", Array::single(0.1 + 0.2));
        tables.put("x_m", Array::vectors([[f64::NAN, -0.0], [f64::MIN_POSITIVE / 3.0, 1e300]]));
        tables.put("id", Array::column([0, u32::MAX]));
        tables.put("force_n", Array::vectors([[1.0 / 3.0, -0.0], [f32::MIN_POSITIVE, 1e38]]));
        tables.put("increment", Array::single(u64::MAX));
        tables.put("held", Array::column([true, false, true]));
        tables.put("kind", Array::column([0_u8, 255]));
        tables.put("group", Array::column(["", "Sand", "Kornöfen 砂"].map(str::to_owned)));
        tables.put("nothing", Array::column::<f64>([]));
        tables.put("no name", Array::column::<String>([]));
        tables
    }

    #[test]
    fn values_of_another_type_or_shape_are_named() {
        let tables = tables();
        let said = |error: Result<&[f64], TableError>| error.unwrap_err().to_string();
        assert_eq!(said(tables.values::<f64>("y_m", &[2])), "no array `y_m`");
        let type_ = "array `id`: type `uint32` where `float64` is expected";
        assert_eq!(said(tables.values::<f64>("id", &[2])), type_);
        let shape = "array `x_m`: shape [2, 2] where [3, 2] is expected";
        assert_eq!(said(tables.values::<f64>("x_m", &[3, 2])), shape);
        assert_eq!(tables.rows("held").unwrap(), 3);
        assert_eq!(tables.rows("time_s").unwrap(), 1);
    }

    #[test]
    fn every_value_reads_back_to_the_bit_and_the_bytes_depend_on_nothing_else() {
        let (tables, bytes) = (tables(), tables().encode().unwrap());
        let read = Tables::decode(&bytes).unwrap();
        let names: Vec<_> = read.iter().map(|(name, _)| name).collect();
        assert_eq!(names, tables.iter().map(|(name, _)| name).collect::<Vec<_>>());
        for (name, array) in tables.iter() {
            let again = read.get(name).unwrap();
            assert_eq!(again.shape, array.shape, "{name}");
            match (&again.data, &array.data) {
                (Data::F64(a), Data::F64(b)) => {
                    let bits = |v: &[f64]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                    assert_eq!(bits(a), bits(b), "{name}");
                }
                (a, b) => assert_eq!(a, b, "{name}"),
            }
        }
        std::thread::sleep(std::time::Duration::from_millis(2100)); // Zip counts in two seconds.
        assert!(read.encode().unwrap() == bytes, "other bytes");
    }

    /// A changed byte of an archive is detected, unless it lies in a part that is not read.
    #[test]
    fn a_cut_or_damaged_archive_is_refused_or_reads_the_same() {
        let bytes = tables().encode().unwrap();
        for length in 0..bytes.len() {
            let cut = Tables::decode(&bytes[..length]);
            assert!(matches!(cut, Err(TableError::Archive(_))), "{length}: {cut:?}");
        }
        let sound = tables().get("group").unwrap().clone();
        for at in 0..bytes.len() {
            let mut bytes = bytes.clone();
            bytes[at] ^= 0x10;
            if let Ok(read) = Tables::decode(&bytes)
                && let Ok(group) = read.get("group")
            {
                assert_eq!(*group, sound, "byte {at}");
            }
        }
    }

    #[test]
    fn what_is_no_archive_of_arrays_is_refused() {
        for bytes in [&b""[..], b"x_m,y_m,radius_m\n", b"PK\x03\x04 and no more"] {
            let said = Tables::decode(bytes).unwrap_err().to_string();
            assert!(said.starts_with("not a .npz archive of numpy arrays: "), "{said}");
        }
    }
}
