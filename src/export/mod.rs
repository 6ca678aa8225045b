//! Frames for other programs: VTK XML for ParaView, and CSV. `docs/export.md` has the fields.

mod tables;
mod vtp;

use std::fs;
use std::path::{Path, PathBuf};

use crate::frames::Frame;
use crate::output::OutputError;
use crate::output::atomic::write_atomic;

/// Kinds of files, one of each for every frame.
pub const KINDS: [&str; 6] = ["bodies", "contacts", "bonds", "walls", "cracks", "membranes"];

/// Writes the frames of a run as VTK files, and a series for ParaView (`.pvd`) for each kind.
///
/// # Errors
/// If a file cannot be written.
pub fn vtk(frames: &[Frame], folder: &Path) -> Result<(), OutputError> {
    fs::create_dir_all(folder).map_err(OutputError::at(folder))?;
    let times = times(frames);
    let mut series = KINDS.map(|_| String::new());
    for (frame, time) in frames.iter().zip(&times) {
        let all = tables::of(frame);
        for ((kind, data), series) in KINDS.into_iter().zip(all).zip(&mut series) {
            let name = file(kind, frame.increment, "vtp");
            *series += &format!(
                "<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{}\"/>\n",
                name.display()
            );
            write_atomic(&folder.join(&name), data.encode(*time, frame.cell_m))?;
        }
    }
    for (kind, series) in KINDS.into_iter().zip(series) {
        let text = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" \
             byte_order=\"LittleEndian\">\n<Collection>\n{series}</Collection>\n</VTKFile>\n"
        );
        write_atomic(&folder.join(kind).with_extension("pvd"), text)?;
    }
    Ok(())
}

/// Writes the frames of a run as CSV files.
///
/// # Errors
/// If a file cannot be written.
pub fn csv(frames: &[Frame], folder: &Path) -> Result<(), OutputError> {
    fs::create_dir_all(folder).map_err(OutputError::at(folder))?;
    for frame in frames {
        for (kind, data) in KINDS.into_iter().zip(tables::of(frame)) {
            let path = folder.join(file(kind, frame.increment, "csv"));
            write_atomic(&path, tables::csv(&data))?;
        }
    }
    Ok(())
}

fn file(kind: &str, increment: u64, ending: &str) -> PathBuf {
    format!("{kind}_{increment:06}.{ending}").into()
}

/// Times of a series: s, or numbers of increments where time does not pass.
fn times(frames: &[Frame]) -> Vec<f64> {
    let passes = frames.windows(2).any(|pair| pair[0].time_s < pair[1].time_s);
    let time = |frame: &Frame| if passes { frame.time_s } else { frame.increment as f64 };
    frames.iter().map(time).collect()
}
