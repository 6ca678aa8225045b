//! One thread against two: wall time of whole runs, and whether their results are
//! the same bytes.

use std::fs;
use std::path::{Path, PathBuf};

use clastic::output::plots::history::History;
use clastic::output::{OutputError, directory};
use rayon::ThreadPoolBuilder;

use crate::clock::{Repetitions, median, time};
use crate::rigs::Scenes;
use crate::table::{Part, Table};
use crate::written::written_run;
use crate::{BenchError, Extent};

/// Runs this part. Runs are written below `scratch` and removed again.
///
/// # Errors
/// Where a scene is not there, a run fails, or results depend on the number of threads.
pub fn run(scenes: &Scenes, extent: Extent, scratch: &Path) -> Result<Part, BenchError> {
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
    let repetitions = Repetitions { minimum: if quick { 1 } else { 3 }, maximum: 3, seconds: 60.0 };
    for (name, increments) in runs {
        let increments = format!("stages.load.increments={increments}");
        // No pictures, nor frames of increments that may not come.
        let sets = [increments.as_str(), "output.plots=false", "stages.load.record=()"];
        let mut first: Option<(f64, PathBuf)> = None;
        for threads in [1, 2] {
            let out = scratch.join(format!("threads_{threads}"));
            let pool = ThreadPoolBuilder::new().num_threads(threads).build();
            let pool = pool.map_err(|e| BenchError::Run(format!("cannot start threads: {e}")))?;
            let mut failed = None;
            let wall = median(&repetitions, || {
                let (seconds, done) = time(|| {
                    let loaded = scenes.load(name, &sets)?;
                    pool.install(|| written_run(&loaded, &out).map(drop))
                });
                failed = done.err();
                seconds
            });
            if let Some(error) = failed {
                return Err(error);
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
    let text = "Whole runs with all output but pictures. `wall_s` is the median wall time after \
        the scene was read, `solve_s` the sum of all solves of the last run. Below a \
        thousand disks the matrix has no branches.";
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
