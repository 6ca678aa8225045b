//! Charts of a run, drawn at its end. Curves are read from `history.csv`, so that a picture shows
//! the content of the file. Only a build with the feature `plots` draws pictures.

pub mod chart;
pub mod compare;
pub(crate) mod force_displacement;
pub mod history;
pub mod strength;
pub(crate) mod stress_strain;

use std::path::Path;

use super::OutputError;
use super::atomic::write_atomic;
pub use super::pictures::*;
use history::History;

/// Whether this build draws pictures.
pub const DRAWN: bool = cfg!(feature = "plots");

/// Draws the curves that the history defines. Probes are drawn only if no stress is defined.
///
/// # Errors
/// If a picture cannot be written.
pub fn curves(directory: &Path, title: &str, history: &History) -> Result<(), OutputError> {
    let stress = stress_strain::stress(title, history);
    let probes = if stress.is_none() { force_displacement::probes(title, history) } else { None };
    let volumetric = stress_strain::volumetric(title, history);
    for (name, chart) in [(CURVES, stress), (VOLUMETRIC, volumetric), (PROBES, probes)] {
        if let Some(chart) = chart {
            let path = directory.join(name);
            write_atomic(&path, chart.svg().map_err(OutputError::at(&path))?)?;
        }
    }
    Ok(())
}
