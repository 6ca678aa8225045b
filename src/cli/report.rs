//! `clastic report`: one or several runs, or those of a study, as a page for a browser, with a table
//! of several.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::output::{OutputError, directory, report};
use crate::study::table::{FILE, read};

use super::exit::{Exit, Failure, say};

/// Default page of several runs.
const OF_SEVERAL: &str = "runs/report.html";

/// Writes the page of runs, and prints the key results of several.
pub fn report(directories: &[PathBuf], out: Option<PathBuf>) -> Result<Exit, Failure> {
    let out = out.unwrap_or_else(|| match directories {
        [one] => one.join(directory::REPORT),
        _ => PathBuf::from(OF_SEVERAL),
    });
    let mut runs = Vec::new();
    for (name, directory) in names(directories).into_iter().zip(directories) {
        runs.extend(runs_of(name, directory)?);
    }
    if let (true, [first, ..]) = (runs.is_empty(), directories) {
        return Err(OutputError::NoRun(first.clone()).into());
    }
    if runs.len() > 1 {
        let record =
            |(name, path): &(String, PathBuf)| Ok((name.clone(), directory::record(path)?));
        let records: Result<Vec<_>, OutputError> = runs.iter().map(record).collect();
        say(table(&records?))?;
    }
    if let Some(folder) = out.parent().filter(|folder| *folder != Path::new("")) {
        fs::create_dir_all(folder).map_err(OutputError::at(folder))?;
    }
    report::write(&runs, &out)?;
    say(format_args!("written: {}", out.display()))?;
    Ok(Exit::Ok)
}

/// The run in a directory, or all runs of the study there, by their values.
fn runs_of(name: String, directory: &Path) -> Result<Vec<(String, PathBuf)>, OutputError> {
    let study = directory.join(FILE);
    if !study.exists() {
        return Ok(vec![(name, directory.to_owned())]);
    }
    let of_study = |(run, label): (String, String)| {
        let name = if label.is_empty() { run.clone() } else { label };
        (name, directory.join(run))
    };
    Ok(read(&study)?.into_iter().map(of_study).collect())
}

/// Ends of paths, each long enough to distinguish it from the others. A path that is given twice is
/// numbered.
fn names(paths: &[PathBuf]) -> Vec<String> {
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

/// The table of runs, given by their names and the content of their `run.json`.
fn table(runs: &[(String, Value)]) -> String {
    let width = runs.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0).max(3);
    let status =
        |record: &Value| record["outcome"]["status"].as_str().unwrap_or("not ended").to_owned();
    let mut text = format!("{:width$}", "run");
    for (_, heading, ..) in COLUMNS {
        text += &format!("  {heading:>16}");
    }
    text += "  outcome";
    for (name, record) in runs {
        text += &format!("\n{name:width$}");
        for (key, _, factor, digits) in COLUMNS {
            let value = record["results"][key].as_f64();
            let value =
                value.map_or_else(|| "-".to_owned(), |v| format!("{:.digits$}", v * factor));
            text += &format!("  {value:>16}");
        }
        text += &format!("  {}", status(record));
        if let Some(capped) = record["capped_increments"].as_u64().filter(|n| *n > 0) {
            text += &format!(", {capped} of {} increments capped", record["increments"]);
        }
    }
    if runs.iter().any(|(_, record)| status(record) == "running") {
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
