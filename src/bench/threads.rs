//! One thread against two: wall time of whole runs of the program, and whether their results are
//! the same bytes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::clock::{Repetitions, median, time};
use super::table::{Part, Table};
use super::{BenchError, Extent};
use crate::output::plots::history::History;
use crate::output::{OutputError, directory};

/// Runs this part: `program` is the clastic program, `scenes` the directory of the scenes. Runs
/// are written below `scratch` and removed again.
///
/// # Errors
/// Where the program cannot be started, a run fails, or results depend on the number of threads.
pub fn run(
    program: &Path,
    scenes: &Path,
    extent: Extent,
    scratch: &Path,
) -> Result<Part, BenchError> {
    let mut table = Table::new(
        "threads",
        "Runs with one thread and two",
        &["scene", "increments", "threads", "wall_s", "solve_s", "speed_up_of_solve", "same_bytes"],
    );
    let quick = extent == Extent::Quick;
    let runs = if quick {
        [("uniaxial_small", 40), ("uniaxial_rigid", 1)]
    } else {
        [("uniaxial", 60), ("biaxial_50kPa", 10)]
    };
    let repetitions = Repetitions { least: if quick { 1 } else { 3 }, most: 3, seconds: 60.0 };
    for (name, increments) in runs {
        let mut first: Option<(f64, PathBuf)> = None;
        for threads in [1_u32, 2] {
            let out = scratch.join(format!("threads_{threads}"));
            let mut failed = None;
            let wall = median(&repetitions, || {
                let (seconds, done) = time(|| {
                    Command::new(program)
                        .args(["run", "--quiet", "--force", "--threads", &threads.to_string()])
                        .args(["--set", &format!("stages.load.increments={increments}")])
                        .args(["--set", "output.plots=false"])
                        // Pictures of increments that may not come.
                        .args(["--set", "stages.load.record=()"])
                        .arg("--out")
                        .arg(&out)
                        .arg(scenes.join(format!("{name}.ron")))
                        .output()
                });
                match done {
                    Ok(output) if output.status.success() => {}
                    Ok(output) => failed = Some(String::from_utf8_lossy(&output.stderr).into()),
                    Err(error) => failed = Some(error.to_string()),
                }
                seconds
            });
            if let Some(message) = failed {
                return Err(BenchError::Run(message));
            }
            let times = History::read(&out.join(directory::TIMINGS))?;
            let solve: f64 = times.column("solve_s").into_iter().flatten().sum();
            let (speed_up, same) = match &first {
                Some((one, dir)) => (Some(one / solve), Some(same_results(dir, &out)?)),
                None => (None, None),
            };
            if same == Some(false) {
                return Err(BenchError::Run(format!(
                    "{name}: the results of one thread and of {threads} differ"
                )));
            }
            table.rows.push(vec![
                name.into(),
                times.column("solve_s").len().into(),
                threads.into(),
                wall.into(),
                solve.into(),
                speed_up.into(),
                same.map_or("", |_| "yes").into(),
            ]);
            first.get_or_insert((solve, out));
        }
        for threads in [1, 2] {
            let out = scratch.join(format!("threads_{threads}"));
            fs::remove_dir_all(&out).map_err(OutputError::at(&out))?;
        }
    }
    let text = "Whole runs of `clastic run --threads`: `wall_s` is the median wall time with start \
        and output, `solve_s` the sum of the solves of the last of the runs. Below a thousand disks the \
        matrix has no branches.";
    Ok(Part { name: "threads", text: text.to_owned(), tables: vec![table], charts: Vec::new() })
}

/// Whether two run directories hold the same files, timings apart.
fn same_results(a: &Path, b: &Path) -> Result<bool, OutputError> {
    let names = |dir: &Path| -> Result<Vec<_>, OutputError> {
        let entries = fs::read_dir(dir).map_err(OutputError::at(dir))?;
        let mut names: Vec<_> = entries.flatten().map(|entry| entry.file_name()).collect();
        names.retain(|name| name != directory::TIMINGS);
        names.sort();
        Ok(names)
    };
    let found = names(a)?;
    if found != names(b)? {
        return Ok(false);
    }
    for name in found {
        let read =
            |dir: &Path| fs::read(dir.join(&name)).map_err(OutputError::at(&dir.join(&name)));
        if read(a)? != read(b)? {
            return Ok(false);
        }
    }
    Ok(true)
}
