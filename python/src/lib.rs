//! The engine for Python: the module `clastic._engine`, above which `clastic/` puts its functions.
//!
//! | file | content |
//! |---|---|
//! | `worker.rs` | a world on a thread of its own, so that Python's lock is free while it solves |
//! | `model.rs` | the world, its scene and its output |
//! | `simulation.rs` | the class that Python sees |
//! | `changes.rs` | changes of laws, loads, walls, bodies and bonds between two increments |
//! | `loads.rs` | loads by a function in Python |
//! | `state.rs` | states of a simulation as bytes |
//! | `arrays.rs` | tables as numpy arrays, rows as dictionaries |
//! | `errors.rs` | errors as exceptions |
//! | `results.rs` | what figures read from the directory of a run |

mod arrays;
mod changes;
mod errors;
mod loads;
mod model;
mod results;
mod simulation;
mod state;
mod worker;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command line of the program. `program` are the words that begin it in another process.
/// Wrong arguments end the process. Returns the exit code.
#[pyfunction]
fn call(py: Python, program: Vec<OsString>, arguments: Vec<OsString>) -> i32 {
    py.detach(|| clastic::cli::call(&program, arguments, ()) as i32)
}

/// The module.
#[pymodule]
fn _engine(module: &Bound<PyModule>) -> PyResult<()> {
    module.add_class::<simulation::Simulation>()?;
    module.add_function(wrap_pyfunction!(call, module)?)?;
    module.add_function(wrap_pyfunction!(simulation::check, module)?)?;
    module.add_function(wrap_pyfunction!(results::strains, module)?)?;
    module.add_function(wrap_pyfunction!(results::curve, module)?)?;
    module.add_function(wrap_pyfunction!(results::drives, module)?)?;
    module.add_function(wrap_pyfunction!(results::marks, module)?)?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))
}
