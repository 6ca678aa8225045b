//! Tables as numpy arrays, and rows of the history as dictionaries. All are copies.

use clastic::tables::{Array, Data, Tables};
use numpy::{Element, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::errors::engine_error;

/// Columns of the history that are texts.
const TEXTS: [&str; 3] = ["stage", "status", "caps"];

/// Tables by name.
pub fn dictionary<'py>(py: Python<'py>, tables: Tables) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for (name, array) in tables.iter() {
        all.set_item(name, array_of(py, array)?)?;
    }
    Ok(all)
}

fn array_of<'py>(py: Python<'py>, array: &Array) -> PyResult<Bound<'py, PyAny>> {
    let shape = &array.shape;
    match &array.data {
        Data::F64(v) => shaped(py, v.clone(), shape),
        Data::F32(v) => shaped(py, v.clone(), shape),
        Data::U32(v) => shaped(py, v.clone(), shape),
        Data::U64(v) => shaped(py, v.clone(), shape),
        Data::U8(v) => shaped(py, v.clone(), shape),
        Data::Bool(v) => shaped(py, v.clone(), shape),
        Data::Text(v) => {
            let make = py.import("numpy")?.getattr("array")?;
            match (shape.as_slice(), v.as_slice()) {
                ([], [word]) => make.call1((word,)),
                // Without items numpy would take the list for one of numbers.
                (_, []) => make.call1((PyList::empty(py), "U1")),
                _ => make.call1((v.clone(),)),
            }
        }
    }
}

/// Values as an array of a shape.
pub fn shaped<'py, T: Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    Ok(PyArray1::from_vec(py, values).reshape(shape.to_vec())?.into_any())
}

/// A row of a CSV file by column. Numbers are those that the file would have, to the bit; a value
/// that is not defined is `None`.
pub fn row<'py>(py: Python<'py>, columns: &[String], line: &str) -> PyResult<Bound<'py, PyDict>> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(line.as_bytes());
    let record = reader.records().next().transpose().map_err(|e| engine_error(&e.to_string()))?;
    let record = record.unwrap_or_default();
    let row = PyDict::new(py);
    for (name, field) in columns.iter().zip(record.iter()) {
        if TEXTS.contains(&name.as_str()) {
            row.set_item(name, field)?;
        } else if let Ok(count) = field.parse::<i64>() {
            row.set_item(name, count)?;
        } else {
            row.set_item(name, field.parse::<f64>().ok())?;
        }
    }
    Ok(row)
}
