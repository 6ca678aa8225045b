//! Loads by a function in Python, which is called once per trial: for every tried fraction of an
//! increment, and after every step of a followed motion.

use bevy_app::App;
use bevy_ecs::prelude::*;
use clastic::components::contact::BodyTable;
use clastic::components::increment::{AnalysisKind, ClasticAnalysis, ClasticProgress};
use clastic::components::loads::TrialLoads;
use clastic::prelude::{AddTrialLoads, ClasticHalted};
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::arrays::shaped;

/// The function.
#[derive(Resource)]
pub struct LoadFunction(pub Py<PyAny>);

/// The exception with which the function ended.
#[derive(Resource)]
pub struct FailedFunction(pub PyErr);

/// Adds the system that calls the function.
pub fn add(app: &mut App) {
    app.add_systems(AddTrialLoads, ask.run_if(resource_exists::<LoadFunction>));
}

fn ask(
    function: Res<LoadFunction>,
    bodies: Res<BodyTable>,
    progress: Res<ClasticProgress>,
    analysis: Res<ClasticAnalysis>,
    mut loads: ResMut<TrialLoads>,
    mut commands: Commands,
) {
    let answer = Python::attach(|py| {
        let given = function.0.call1(py, (trial(py, &bodies, &progress, analysis.kind)?,))?;
        given.bind(py).extract_loads(&bodies, &mut loads)
    });
    if let Err(error) = answer {
        commands.insert_resource(ClasticHalted(error.to_string()));
        commands.insert_resource(FailedFunction(error));
    }
}

/// The particles at the start of the trial.
fn trial<'py>(
    py: Python<'py>,
    bodies: &BodyTable,
    progress: &ClasticProgress,
    kind: AnalysisKind,
) -> PyResult<Bound<'py, PyAny>> {
    let n = bodies.particles;
    let pairs = |v: &[glam::DVec2]| v[..n].iter().flat_map(|x| x.to_array()).collect();
    let trial = PyDict::new(py);
    let ids = bodies.ids[..n].iter().map(|id| id.0).collect();
    trial.set_item("ids", shaped::<u32>(py, ids, &[n])?)?;
    trial.set_item("positions", shaped::<f64>(py, pairs(&bodies.positions), &[n, 2])?)?;
    trial.set_item("velocities", shaped::<f64>(py, pairs(&bodies.velocities), &[n, 2])?)?;
    trial.set_item("rotations", shaped(py, bodies.rotations[..n].to_vec(), &[n])?)?;
    trial.set_item("radii", shaped(py, bodies.radii[..n].to_vec(), &[n])?)?;
    trial.set_item("masses", shaped(py, bodies.masses[..n].to_vec(), &[n])?)?;
    trial.set_item("increments_done", progress.done)?;
    trial.set_item("fraction", progress.fraction)?;
    trial.set_item("time", progress.time)?;
    let dt = kind.dt().unwrap_or(0.0);
    trial.set_item("time_end", progress.time + dt * progress.fraction)?;
    py.import("types")?.getattr("SimpleNamespace")?.call((), Some(&trial))
}

/// What a function may return.
trait Loads {
    fn extract_loads(&self, bodies: &BodyTable, loads: &mut TrialLoads) -> PyResult<()>;
}

impl Loads for Bound<'_, PyAny> {
    fn extract_loads(&self, bodies: &BodyTable, loads: &mut TrialLoads) -> PyResult<()> {
        if self.is_none() {
            return Ok(());
        }
        let n = bodies.particles;
        let (forces, stiffness) = match self.cast::<PyTuple>() {
            Ok(both) if both.len() == 2 => {
                (columns(&both.get_item(0)?, n)?, Some(columns(&both.get_item(1)?, n)?))
            }
            _ => (columns(self, n)?, None),
        };
        for (row, force) in forces.iter().enumerate() {
            match &stiffness {
                None => loads.add(bodies.ids[row], *force),
                Some(stiffness) => {
                    for k in 0..3 {
                        loads.add_spring(bodies.ids[row], k, force[k], stiffness[row][k]);
                    }
                }
            }
        }
        Ok(())
    }
}

/// An array (n, 2) or (n, 3) by rows; a moment that is left out is 0.
fn columns(array: &Bound<PyAny>, n: usize) -> PyResult<Vec<[f64; 3]>> {
    let numpy = array.py().import("numpy")?;
    let array = numpy.getattr("ascontiguousarray")?.call1((array, "float64"))?;
    let array: PyReadonlyArrayDyn<f64> = array.extract()?;
    let columns = match *array.shape() {
        [rows, columns @ (2 | 3)] if rows == n => columns,
        ref shape => {
            return Err(PyValueError::new_err(format!(
                "a function of loads gave an array of the shape {shape:?}; give ({n}, 2) for forces, or ({n}, 3) \
                 with moments, and a pair of such arrays for forces and stiffnesses"
            )));
        }
    };
    let values = array.as_slice()?;
    let row = |row: &[f64]| [row[0], row[1], row.get(2).copied().unwrap_or(0.0)];
    Ok(values.chunks_exact(columns).map(row).collect())
}
