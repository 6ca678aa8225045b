//! An array: a shape, and values row by row.

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
            #[must_use]
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
    #[must_use]
    pub fn column<T: Value>(values: Vec<T>) -> Self {
        Self { shape: vec![values.len()], data: T::data(values) }
    }

    /// A column of numbers.
    #[must_use]
    pub fn f64(values: Vec<f64>) -> Self {
        Self::column(values)
    }

    /// A column of 32-bit counts.
    #[must_use]
    pub fn u32(values: Vec<u32>) -> Self {
        Self::column(values)
    }

    /// A column of bytes.
    #[must_use]
    pub fn u8(values: Vec<u8>) -> Self {
        Self::column(values)
    }

    /// A column of texts.
    #[must_use]
    pub fn text(values: impl IntoIterator<Item = String>) -> Self {
        Self::column(values.into_iter().collect::<Vec<String>>())
    }

    /// A table with `N` values a row.
    #[must_use]
    pub fn vectors<T: Value, const N: usize>(rows: impl IntoIterator<Item = [T; N]>) -> Self {
        let values: Vec<T> = rows.into_iter().flatten().collect();
        Self { shape: vec![values.len() / N, N], data: T::data(values) }
    }

    /// A single number.
    #[must_use]
    pub fn value(value: f64) -> Self {
        Self { shape: Vec::new(), data: Data::F64(vec![value]) }
    }

    /// A single count.
    #[must_use]
    pub fn count(value: u64) -> Self {
        Self { shape: Vec::new(), data: Data::U64(vec![value]) }
    }

    /// A single text.
    #[must_use]
    pub fn word(value: &str) -> Self {
        Self { shape: Vec::new(), data: Data::Text(vec![value.to_owned()]) }
    }
}
