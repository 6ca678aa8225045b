//! Frames for ParaView: VTK XML. `docs/export.md` has the fields.

mod tables;
mod vtp;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::frames::Frame;
use crate::output::OutputError;
use crate::output::atomic::write_atomic;

/// Writes the frames of a run as VTK files, and a series for ParaView (`.pvd`) for each kind.
///
/// # Errors
/// If a file cannot be written.
pub fn vtk(frames: &[Frame], folder: &Path) -> Result<(), OutputError> {
    fs::create_dir_all(folder).map_err(OutputError::at(folder))?;
    let times = times(frames);
    let mut series: BTreeMap<&str, String> = BTreeMap::new();
    for (frame, time) in frames.iter().zip(&times) {
        for (kind, data) in tables::of(frame) {
            let file = format!("{kind}_{:06}.vtp", frame.increment);
            write_atomic(&folder.join(&file), data.encode(*time, frame.cell_m))?;
            *series.entry(kind).or_default() +=
                &format!("<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{file}\"/>\n");
        }
    }
    for (kind, series) in series {
        let text = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" \
             byte_order=\"LittleEndian\">\n<Collection>\n{series}</Collection>\n</VTKFile>\n"
        );
        write_atomic(&folder.join(kind).with_extension("pvd"), text)?;
    }
    Ok(())
}

/// Times of a series: s, or numbers of increments where time does not pass.
fn times(frames: &[Frame]) -> Vec<f64> {
    let passes = frames.windows(2).any(|pair| pair[0].time_s < pair[1].time_s);
    let time = |frame: &Frame| if passes { frame.time_s } else { frame.increment as f64 };
    frames.iter().map(time).collect()
}
