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

impl Data {
    /// Number of values.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::F64(v) => v.len(),
            Self::F32(v) => v.len(),
            Self::U32(v) => v.len(),
            Self::U64(v) => v.len(),
            Self::U8(v) => v.len(),
            Self::Bool(v) => v.len(),
            Self::Text(v) => v.len(),
        }
    }

    /// Whether it has no values.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Name of the type in numpy.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::F64(_) => "float64",
            Self::F32(_) => "float32",
            Self::U32(_) => "uint32",
            Self::U64(_) => "uint64",
            Self::U8(_) => "uint8",
            Self::Bool(_) => "bool",
            Self::Text(_) => "str",
        }
    }
}

/// An array of any shape; the last index varies fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Length of every dimension; none for a single value.
    pub shape: Vec<usize>,
    /// The values.
    pub data: Data,
}

impl Array {
    fn column(data: Data) -> Self {
        Self { shape: vec![data.len()], data }
    }

    /// A column of numbers.
    #[must_use]
    pub fn f64(values: Vec<f64>) -> Self {
        Self::column(Data::F64(values))
    }

    /// A column of numbers of single precision.
    #[must_use]
    pub fn f32(values: Vec<f32>) -> Self {
        Self::column(Data::F32(values))
    }

    /// A table with `N` numbers of single precision a row.
    #[must_use]
    pub fn f32_rows<const N: usize>(rows: &[[f32; N]]) -> Self {
        Self { shape: vec![rows.len(), N], data: Data::F32(rows.as_flattened().to_vec()) }
    }

    /// A column of 32-bit counts.
    #[must_use]
    pub fn u32(values: Vec<u32>) -> Self {
        Self::column(Data::U32(values))
    }

    /// A column of bytes.
    #[must_use]
    pub fn u8(values: Vec<u8>) -> Self {
        Self::column(Data::U8(values))
    }

    /// A column of truth values.
    #[must_use]
    pub fn bool(values: Vec<bool>) -> Self {
        Self::column(Data::Bool(values))
    }

    /// A column of texts.
    #[must_use]
    pub fn text(values: impl IntoIterator<Item = String>) -> Self {
        Self::column(Data::Text(values.into_iter().collect()))
    }

    /// A table with `N` numbers a row.
    #[must_use]
    pub fn vectors<const N: usize>(rows: impl IntoIterator<Item = [f64; N]>) -> Self {
        let values: Vec<f64> = rows.into_iter().flatten().collect();
        Self { shape: vec![values.len() / N, N], data: Data::F64(values) }
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
