//! What figures read from the directory of a run, by the code of the program.

use std::path::{Path, PathBuf};

use clastic::frames::{self, Disk, Strain};
use clastic::output::directory;
use clastic::output::drive::Drive;
use clastic::output::marks::marks as marks_of;
use clastic::output::read_history::History;
use glam::DVec2;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;

use crate::arrays::shaped;

/// Disks of a frame: identities, places, radii, and displacements since the start of the run.
type Disks<'py> = (
    PyReadonlyArray1<'py, u32>,
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray2<'py, f64>,
);

fn disks((ids, places, radii, moved): &Disks) -> PyResult<Vec<Disk>> {
    let (ids, places) = (ids.as_slice()?, places.as_array());
    let (radii, moved) = (radii.as_slice()?, moved.as_array());
    let n = ids.len();
    if places.dim() != (n, 2) || moved.dim() != (n, 2) || radii.len() != n {
        return Err(PyValueError::new_err("the arrays of a frame have different lengths"));
    }
    let disk = |k: usize| Disk {
        id: ids[k],
        position: DVec2::new(places[[k, 0]], places[[k, 1]]),
        radius: radii[k],
        displacement: DVec2::new(moved[[k, 0]], moved[[k, 1]]),
    };
    Ok((0..n).map(disk).collect())
}

/// Volumetric and maximum shear strain of every disk between two frames, an array (n, 2). Not a
/// number where a disk has none.
#[pyfunction]
pub fn strains<'py>(
    py: Python<'py>,
    now: Disks<'py>,
    from: Disks<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let strains = frames::strains(&disks(&now)?, &disks(&from)?);
    let n = strains.len();
    let pair = |strain: Option<Strain>| {
        strain.map_or([f64::NAN; 2], |strain| [strain.volumetric, strain.shear])
    };
    shaped(py, strains.into_iter().flat_map(pair).collect(), &[n, 2])
}

fn history(run: &Path) -> PyResult<History> {
    History::of_run(run).map_err(|error| PyOSError::new_err(error.to_string()))
}

/// Points (n, 2) of a column of the history against the axial strain, from the initial state on.
#[pyfunction]
pub fn curve<'py>(py: Python<'py>, run: PathBuf, column: &str) -> PyResult<Bound<'py, PyAny>> {
    let points = history(&run)?.curve(column);
    let n = points.len();
    shaped(py, points.into_iter().flat_map(|(x, y)| [x, y]).collect(), &[n, 2])
}

/// The probes on which the outside world works: name, direction, and points (n, 3) of increment,
/// motion (m, rad) and force (N, N m), both positive in the direction.
#[pyfunction]
pub fn drives<'py>(
    py: Python<'py>,
    run: PathBuf,
) -> PyResult<Vec<(String, String, Bound<'py, PyAny>)>> {
    let drives = Drive::all(&history(&run)?).into_iter().map(|drive| {
        let n = drive.points.len();
        let rows = drive.points.iter().flat_map(|p| [p.increment as f64, p.motion, p.force]);
        let points = shaped(py, rows.collect(), &[n, 3])?;
        Ok((drive.probe, drive.direction.to_owned(), points))
    });
    drives.collect()
}

/// Reasons to doubt a run.
#[pyfunction]
pub fn marks(run: PathBuf) -> PyResult<Vec<String>> {
    let record = directory::record(&run).map_err(|e| PyOSError::new_err(e.to_string()))?;
    Ok(marks_of(&record))
}
