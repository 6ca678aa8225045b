//! Tables of numbers and short texts in one file that numpy reads: arrays by name, in a `.npz`
//! archive (a zip of `.npy` files). The bytes depend on the content alone.
//!
//! ```
//! use clastic::tables::{Array, Tables};
//!
//! let mut tables = Tables::default();
//! tables.put("radius_m", Array::f64(vec![1.0e-3, 2.0e-3]));
//! tables.put("name", Array::text(["sand".to_owned()]));
//! # #[cfg(feature = "npz")] {
//! let read = Tables::decode(&tables.encode()?)?;
//! assert_eq!(read.f64("radius_m", &[2])?, [1.0e-3, 2.0e-3]);
//! # }
//! # Ok::<(), clastic::tables::TableError>(())
//! ```

mod array;
mod column;
#[cfg(feature = "npz")]
mod npy;
mod npz;

pub(crate) use column::Column;

pub use array::{Array, Data};

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
    /// The program was built without the feature `npz`.
    #[error("this program is built without the feature `npz`, which reads and writes .npz files")]
    Unsupported,
}

impl TableError {
    /// Error of one array.
    pub fn at(name: &str, what: impl Into<String>) -> Self {
        Self::Array { name: name.to_owned(), what: what.into() }
    }
}

/// Arrays by name, in the order in which they were added.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tables(Vec<(String, Array)>);

impl Tables {
    /// Adds an array, or replaces the array of this name.
    pub fn put(&mut self, name: &str, array: Array) {
        match self.0.iter_mut().find(|(known, _)| known == name) {
            Some((_, old)) => *old = array,
            None => self.0.push((name.to_owned(), array)),
        }
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
        let found = self.iter().find(|(known, _)| *known == name);
        found.map(|(_, array)| array).ok_or_else(|| TableError::Missing(name.to_owned()))
    }

    /// Whether an array of this name exists.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.get(name).is_ok()
    }

    /// Number of rows of an array: its first dimension; 1 for a single value.
    ///
    /// # Errors
    /// If there is no such array.
    pub fn rows(&self, name: &str) -> Result<usize, TableError> {
        Ok(self.get(name)?.shape.first().copied().unwrap_or(1))
    }
}

/// A getter for one type of values.
macro_rules! getter {
    ($name:ident, $variant:ident, $type:ty, $says:literal) => {
        /// The values of an array of this type and shape, row by row.
        ///
        /// # Errors
        /// If the array is missing or has another type or shape.
        pub fn $name(&self, name: &str, shape: &[usize]) -> Result<&[$type], TableError> {
            let array = self.get(name)?;
            let Data::$variant(values) = &array.data else {
                let what = format!("type `{}` where `{}` is expected", array.data.name(), $says);
                return Err(TableError::at(name, what));
            };
            if array.shape != shape {
                let what = format!("shape {:?} where {shape:?} is expected", array.shape);
                return Err(TableError::at(name, what));
            }
            Ok(values)
        }
    };
}

impl Tables {
    getter!(f64, F64, f64, "float64");
    getter!(f32, F32, f32, "float32");
    getter!(u32, U32, u32, "uint32");
    getter!(u64, U64, u64, "uint64");
    getter!(u8, U8, u8, "uint8");
    getter!(bool, Bool, bool, "bool");
    getter!(text, Text, String, "str");

    /// Rows of `N` numbers each: an array of the shape (`rows`, `N`).
    ///
    /// # Errors
    /// If the array is missing or has another type or shape.
    pub fn vectors<const N: usize>(
        &self,
        name: &str,
        rows: usize,
    ) -> Result<Vec<[f64; N]>, TableError> {
        Ok(self.f64(name, &[rows, N])?.as_chunks().0.to_vec())
    }

    /// Rows of `N` numbers of single precision each: an array of the shape (`rows`, `N`).
    ///
    /// # Errors
    /// If the array is missing or has another type or shape.
    pub fn f32_rows<const N: usize>(
        &self,
        name: &str,
        rows: usize,
    ) -> Result<Vec<[f32; N]>, TableError> {
        Ok(self.f32(name, &[rows, N])?.as_chunks().0.to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tables() -> Tables {
        let mut tables = Tables::default();
        tables.put("time_s", Array::value(0.1 + 0.2));
        tables.put("x_m", Array::vectors([[f64::NAN, -0.0], [f64::MIN_POSITIVE / 3.0, 1e300]]));
        tables.put("id", Array::u32(vec![0, u32::MAX]));
        tables.put("force_n", Array::f32_rows(&[[1.0 / 3.0, -0.0], [f32::MIN_POSITIVE, 1e38]]));
        tables.put("increment", Array::count(u64::MAX));
        tables.put("held", Array::bool(vec![true, false, true]));
        tables.put("kind", Array::u8(vec![0, 255]));
        tables.put("group", Array::text(["", "Sand", "Kornöfen 砂"].map(str::to_owned)));
        tables.put("nothing", Array::f64(Vec::new()));
        tables.put("no name", Array::text([]));
        tables
    }

    #[test]
    fn values_of_another_type_or_shape_are_named() {
        let tables = tables();
        let said = |error: Result<&[f64], TableError>| error.unwrap_err().to_string();
        assert_eq!(said(tables.f64("y_m", &[2])), "no array `y_m`");
        let type_ = "array `id`: type `uint32` where `float64` is expected";
        assert_eq!(said(tables.f64("id", &[2])), type_);
        let shape = "array `x_m`: shape [2, 2] where [3, 2] is expected";
        assert_eq!(said(tables.f64("x_m", &[3, 2])), shape);
        assert_eq!(tables.rows("held").unwrap(), 3);
        assert_eq!(tables.rows("time_s").unwrap(), 1);
    }

    #[cfg(feature = "npz")]
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
    #[cfg(feature = "npz")]
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

    #[cfg(feature = "npz")]
    #[test]
    fn what_is_no_archive_of_arrays_is_refused() {
        for bytes in [&b""[..], b"x_m,y_m,radius_m\n", b"PK\x03\x04 and no more"] {
            let said = Tables::decode(bytes).unwrap_err().to_string();
            assert!(said.starts_with("not a .npz archive of numpy arrays: "), "{said}");
        }
    }
}
