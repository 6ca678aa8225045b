//! Errors as exceptions of `clastic/errors.py`.

use clastic::cli::exit::{Exit, Failure};
use clastic::output::OutputError;
use clastic::run::StateError;
use clastic::saved::SavedError;
use clastic::scene::{Diagnostic, LoadError};
use pyo3::exceptions::{PyFileNotFoundError, PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// An error on the thread of a world.
pub enum Error {
    /// A scene is wrong.
    Scene(LoadError),
    /// A value that was given has no meaning.
    Value(String),
    /// A file cannot be read or written.
    Files(String),
    /// The engine cannot go on.
    Engine(String),
    /// A function in Python has failed.
    Python(PyErr),
}

impl From<LoadError> for Error {
    fn from(error: LoadError) -> Self {
        Self::Scene(error)
    }
}

impl From<OutputError> for Error {
    fn from(error: OutputError) -> Self {
        // In Python these are arguments.
        let message =
            error.to_string().replace("--out", "`out`").replace("--force", "`force=True`");
        Self::Files(message)
    }
}

impl From<StateError> for Error {
    fn from(error: StateError) -> Self {
        Self::Value(error.to_string())
    }
}

impl From<SavedError> for Error {
    fn from(error: SavedError) -> Self {
        Self::Engine(error.to_string())
    }
}

impl From<Failure> for Error {
    fn from(failure: Failure) -> Self {
        match failure.exit {
            Exit::Files => Self::Files(failure.message),
            _ => Self::Value(failure.message),
        }
    }
}

impl Error {
    /// A value without a meaning, in the words of Python: without the entity, of which the identity
    /// says which it is, and without what only a plugin in Rust can do.
    pub fn halted(message: &str) -> Self {
        let what = message.split(", then remove `ClasticHalted`").next().unwrap_or_default();
        let mut parts = what.split(", entity ");
        let mut said = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            let rest = part.trim_start_matches(|c: char| c.is_ascii_digit() || c == 'v');
            said += rest.strip_prefix(',').unwrap_or(rest);
        }
        let said = said.replace("a load of `AddTrialLoads`", "a load of the function");
        Self::Value(said.replace("`ClasticAnalysis`", "the simulation"))
    }

    /// The exception.
    pub fn raise(self, py: Python) -> PyErr {
        match self {
            Self::Scene(error) => scene_error(py, &error).unwrap_or_else(|error| error),
            Self::Value(message) => PyValueError::new_err(message),
            Self::Files(message) => PyOSError::new_err(message),
            Self::Engine(message) => engine_error(&message),
            Self::Python(error) => error,
        }
    }
}

/// An error of the engine.
pub fn engine_error(message: &str) -> PyErr {
    PyRuntimeError::new_err(message.to_owned())
}

fn scene_error(py: Python, error: &LoadError) -> PyResult<PyErr> {
    let list = PyList::empty(py);
    match error {
        LoadError::Read { path, source } => {
            let message = format!("{}: cannot read the scene: {source}", path.display());
            return Ok(PyFileNotFoundError::new_err(message));
        }
        LoadError::Set(error) => {
            let found = PyDict::new(py);
            found.set_item("set", &error.set)?;
            found.set_item("message", &error.message)?;
            found.set_item("help", &error.help)?;
            list.append(found)?;
        }
        LoadError::Scene(errors) => {
            for diagnostic in &errors.list {
                list.append(found(py, diagnostic)?)?;
            }
        }
    }
    let class = py.import("clastic.errors")?.getattr("SceneError")?;
    Ok(PyErr::from_value(class.call1((error.to_string(), list))?))
}

fn found<'py>(py: Python<'py>, diagnostic: &Diagnostic) -> PyResult<Bound<'py, PyDict>> {
    let found = PyDict::new(py);
    found.set_item("file", diagnostic.file.to_string_lossy())?;
    found.set_item("line", diagnostic.line)?;
    found.set_item("column", diagnostic.column)?;
    found.set_item("set", &diagnostic.set)?;
    found.set_item("path", &diagnostic.path)?;
    found.set_item("message", &diagnostic.message)?;
    found.set_item("help", &diagnostic.help)?;
    Ok(found)
}
