//! `clastic compare`: the curves of several runs in one picture, and their key results in a table.

use std::fs;
use std::path::{Path, PathBuf};

use crate::output::OutputError;
use crate::output::atomic::write_atomic;
use crate::output::directory;
use crate::output::plots::history::History;
use crate::output::plots::{self, compare};

use serde_json::Value;

use super::exit::{Exit, Failure, say};

/// A run in the table and the legends.
struct Run {
    /// End of the path, long enough to distinguish it from the other paths.
    name: String,
    /// Content of its `run.json`.
    record: Value,
}

impl Run {
    fn status(&self) -> &str {
        self.record["outcome"]["status"].as_str().unwrap_or("not ended")
    }

    /// Name of the run, with a mark if the run has not ended.
    fn label(&self) -> String {
        match self.status() {
            "completed" | "collapsed" => self.name.clone(),
            status => format!("{} ({status})", self.name),
        }
    }
}

/// Compares runs.
pub fn compare(directories: &[PathBuf], out: &Path) -> Result<Exit, Failure> {
    let mut runs = Vec::new();
    for (directory, name) in directories.iter().zip(names(directories)) {
        runs.push(Run { name, record: directory::record(directory)? });
    }
    let mut read = Vec::new();
    for (directory, run) in directories.iter().zip(&runs) {
        read.push((run.label(), History::of_run(directory)?));
    }
    say(format_args!("{}", table(&runs)))?;
    if !plots::DRAWN {
        say("no picture: this build of clastic lacks the feature `plots`")?;
        return Ok(Exit::Ok);
    }
    fs::create_dir_all(out).map_err(OutputError::at(out))?;
    let charts =
        [("stress.svg", compare::stress(&read)), ("volumetric.svg", compare::volumetric(&read))];
    let mut drawn = false;
    for (file, chart) in charts {
        let path = out.join(file);
        let Some(chart) = chart else {
            // The picture may come from an earlier comparison of other runs.
            directory::remove_if_there(&path)?;
            continue;
        };
        write_atomic(&path, chart.svg().map_err(OutputError::at(&path))?)?;
        say(format_args!("drawn: {}", path.display()))?;
        drawn = true;
    }
    if !drawn {
        say(format_args!("no picture: none of the runs defines an axial strain with a stress"))?;
    }
    Ok(Exit::Ok)
}

/// Ends of paths, each long enough to distinguish it from the others. A path that is given twice is
/// numbered.
pub(super) fn names(paths: &[PathBuf]) -> Vec<String> {
    // `..` and `.` are not names of directories.
    let whole = |path: &PathBuf| fs::canonicalize(path).unwrap_or_else(|_| path.clone());
    let paths: Vec<PathBuf> = paths.iter().map(whole).collect();
    let end = |path: &Path, parts: usize| -> String {
        let all: Vec<_> = path.iter().map(|part| part.to_string_lossy()).collect();
        all[all.len().saturating_sub(parts)..].join("/")
    };
    let mut names: Vec<String> = Vec::new();
    for path in &paths {
        let clashes = |parts: &usize| {
            let name = end(path, *parts);
            paths.iter().any(|other| other != path && end(other, *parts) == name)
        };
        let most = path.iter().count().max(1);
        let parts = (1..most).find(|parts| !clashes(parts)).unwrap_or(most);
        let name = end(path, parts);
        let earlier = paths[..names.len()].iter().filter(|other| *other == path).count();
        names.push(if earlier == 0 { name } else { format!("{name} ({})", earlier + 1) });
    }
    names
}

/// Columns of the table: name in `run.json`, heading, factor, digits.
const COLUMNS: [(&str, &str, f64, usize); 6] = [
    ("youngs_modulus_pa", "E, MPa", 1e-6, 3),
    ("first_crack_stress_pa", "first crack, MPa", 1e-6, 4),
    ("peak_stress_pa", "peak, MPa", 1e-6, 4),
    ("strain_at_peak", "at strain, %", 100.0, 4),
    ("limit_load_pa", "limit load, MPa", 1e-6, 4),
    ("porosity", "porosity", 1.0, 4),
];

fn table(runs: &[Run]) -> String {
    let width = runs.iter().map(|run| run.name.chars().count()).max().unwrap_or(0).max(3);
    let mut text = format!("{:width$}", "run");
    for (_, heading, ..) in COLUMNS {
        text += &format!("  {heading:>16}");
    }
    text += "  outcome";
    for run in runs {
        text += &format!("\n{:width$}", run.name);
        for (key, _, factor, digits) in COLUMNS {
            let value = run.record["results"][key].as_f64();
            let value =
                value.map_or_else(|| "-".to_owned(), |v| format!("{:.digits$}", v * factor));
            text += &format!("  {value:>16}");
        }
        text += &format!("  {}", run.status());
        if let Some(capped) = run.record["capped_increments"].as_u64().filter(|n| *n > 0) {
            text += &format!(", {capped} of {} increments capped", run.record["increments"]);
        }
    }
    if runs.iter().any(|run| run.status() == "running") {
        text += "\nrunning: not at its end yet, or killed";
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_as_long_as_it_takes() {
        let named = |paths: &[&str]| names(&paths.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(named(&["no/runs/a", "no/runs/b"]), ["a", "b"]);
        assert_eq!(named(&["no/old/a", "no/new/a", "no/new/b"]), ["old/a", "new/a", "b"]);
        assert_eq!(named(&["no/x/old/a", "no/y/old/a"]), ["x/old/a", "y/old/a"]);
        assert_eq!(named(&["no/a", "no/a", "a"]), ["no/a", "no/a (2)", "a"]);
    }
}
