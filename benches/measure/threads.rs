//! One thread against two: wall time of whole runs, and whether their results are the same bytes.
//! Work of the longest path of the tree of fronts, which no number of threads shortens.

use std::fs;
use std::path::{Path, PathBuf};

use clastic::cone::condensed::matrix::BodyMatrix;
use clastic::cone::program::ConeProgram;
use clastic::output::read_history::History;
use clastic::output::{OutputError, directory};
use clastic::run::{Simulation, Step};
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
        the scene was read, `solve_s` the sum of all solves of the last run. The solve of \
        a small specimen uses one thread. The table of paths has no times: its work is counted, and \
        is the same on every machine. `tasks` is the number of tasks of a factorisation. `path` is \
        the work of the longest path of the tree of fronts over that of the whole tree, and `limit` \
        the speed-up that no number of threads exceeds with it; in `shared_path` 16 threads share the \
        work on each large front, and `limit_of_16` is the speed-up of the factorisation that they \
        cannot exceed.";
    let tables = vec![table, paths(scenes)?];
    Ok(Part { name: "threads", text: text.to_owned(), tables, charts: Vec::new() })
}

/// The longest path of the tree of fronts, for rock of several sizes. Work is counted, so that one
/// increment suffices.
fn paths(scenes: &Scenes) -> Result<Table, BenchError> {
    let mut table = Table::new(
        "threads_path",
        "Longest path of the tree of fronts of bonded rock",
        &["bodies", "tasks", "path", "limit", "shared_path", "limit_of_16"],
    );
    for (columns, rows) in [(1, 1), (2, 2), (5, 3)] {
        let boxed = scenes.rock(true)?.tiled(columns, rows);
        let loaded = scenes.compression_of(boxed, 1)?;
        let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
        if simulation.step() != Step::Increment {
            return Err(BenchError::Run("threads: no increment".to_owned()));
        }
        let program = simulation.world().resource::<ConeProgram>();
        let pairs: Vec<_> = program.interactions.iter().map(|c| (c.a, c.b)).collect();
        let matrix = BodyMatrix::new(program.bodies.len(), &pairs);
        let (alone, shared) = (matrix.longest_path(1), matrix.longest_path(16));
        table.rows.push(vec![
            program.bodies.len().into(),
            matrix.tasks().into(),
            alone.into(),
            (1.0 / alone).into(),
            shared.into(),
            (1.0 / shared).min(16.0).into(),
        ]);
    }
    Ok(table)
}

/// Whether two directories hold the same files, timings apart, and the same folders.
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
        let (a, b) = (a.join(name.clone()), b.join(name));
        let read = |path: &Path| fs::read(path).map_err(OutputError::at(path));
        let is_same = if a.is_dir() { same_results(&a, &b)? } else { read(&a)? == read(&b)? };
        if !is_same {
            return Ok(false);
        }
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs have folders, of frames for example: they are compared file by file, and a folder that
    /// one of the two lacks is a difference.
    #[test]
    fn folders_of_a_run_are_compared_file_by_file() -> Result<(), Box<dyn std::error::Error>> {
        let runs = tempfile::tempdir()?;
        let [a, b] = ["a", "b"].map(|name| runs.path().join(name));
        for run in [&a, &b] {
            fs::create_dir_all(run.join("frames"))?;
            fs::write(run.join("history.csv"), "increment")?;
            fs::write(run.join("frames/0.bin"), "grains")?;
        }
        fs::write(a.join(directory::TIMINGS), "1 s")?;
        assert!(same_results(&a, &b)?);
        fs::write(b.join("frames/0.bin"), "others")?;
        assert!(!same_results(&a, &b)?);
        fs::remove_dir_all(b.join("frames"))?;
        assert!(!same_results(&a, &b)?);
        Ok(())
    }
}
