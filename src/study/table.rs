//! `study.csv`: one row per run, with its values, how it ended, and its key results.

use std::path::Path;

use csv::StringRecord;
use serde_json::Value;

use super::planned::{Plan, label};
use crate::output::OutputError;
use crate::output::atomic::write_atomic;
use crate::output::csv_file::{self, Field, Row};
use crate::output::directory;
use crate::output::marks::marks;

/// Name of the table in the directory of a study.
pub const FILE: &str = "study.csv";

/// Results of `run.json` that are columns, after the values.
pub const RESULTS: [&str; 20] = [
    "youngs_modulus_pa",
    "youngs_modulus_secant_half_peak_pa",
    "peak_stress_pa",
    "strain_at_peak",
    "peak_error_estimate",
    "limit_load_pa",
    "first_crack_stress_pa",
    "porosity",
    "avalanches",
    "largest_avalanche",
    "bonds_created",
    "bonds_intact",
    "poissons_ratio",
    "strength_pa",
    "residual_strength_pa",
    "friction_angle_rad",
    "crack_initiation_stress_pa",
    "crack_damage_stress_pa",
    "peak_force_n",
    "peak_moment_nm",
];

/// One of these results of a run; null if the run has none.
pub fn result<'r>(record: &'r Value, name: &str) -> &'r Value {
    match name {
        "peak_force_n" => &record["peak_force"]["force_n"],
        "peak_moment_nm" => &record["peak_force"]["moment_nm"],
        _ => &record["results"][name],
    }
}

/// Outcome of a run that was not made.
const NOT_RUN: &str = "not run";

/// The `run.json` of every run of a plan in `folder`; null for a run that was not made.
pub fn records(plan: &Plan, folder: &Path) -> Vec<Value> {
    let record = |name: &String| directory::record(&folder.join(name)).unwrap_or(Value::Null);
    plan.runs.iter().map(|run| record(&run.directory)).collect()
}

/// Writes the table. `records` are those of the runs, in the order of the plan. The column `marks`
/// holds the reasons to doubt a run, and is empty otherwise.
pub fn write(path: &Path, plan: &Plan, records: &[Value]) -> Result<(), OutputError> {
    let header = Row::default()
        .with("run")
        .and(plan.names.iter().map(String::as_str))
        .and(["status", "marks", "increments", "capped_increments"])
        .and(RESULTS);
    let mut text = header.line();
    for (run, record) in plan.runs.iter().zip(records) {
        let row = Row::default()
            .with(&*run.directory)
            .and(run.values.iter().map(String::as_str))
            .with(record["outcome"]["status"].as_str().unwrap_or(NOT_RUN))
            .with(&*marks(record).join("; "))
            .and(["increments", "capped_increments"].map(|name| number(&record[name])))
            .and(RESULTS.map(|name| number(result(record, name))));
        text.push_str(&row.line());
    }
    write_atomic(path, text)
}

/// Directory and values of every run of a table that was made, the values as text:
/// `mu 0.2, seed 1`.
pub fn read(path: &Path) -> Result<Vec<(String, String)>, OutputError> {
    let (header, rows) = csv_file::read(path)?;
    // The values are between the directory and the outcome.
    let end = header.iter().position(|name| name == "status").unwrap_or(1);
    let inner = |row: &StringRecord| row.iter().take(end).skip(1).map(str::to_owned).collect();
    let names: Vec<String> = inner(&header);
    let made = rows.iter().filter(|row| row.get(end) != Some(NOT_RUN));
    Ok(made.map(|row| (row[0].to_owned(), label(&names, &inner(row)))).collect())
}

fn number(value: &Value) -> Field<'static> {
    value.as_u64().map_or_else(|| value.as_f64().into(), Field::Count)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::study::PlannedRun;

    #[test]
    fn a_run_that_was_not_made_has_a_row() -> Result<(), Box<dyn std::error::Error>> {
        let run = |value: &str, directory: &str| PlannedRun {
            values: vec![value.to_owned()],
            directory: directory.to_owned(),
            ..PlannedRun::default()
        };
        let plan = Plan {
            names: vec!["mu".to_owned()],
            runs: vec![run("0.2", "a"), run("0.4", "b")],
            ..Plan::default()
        };
        let record = json!({ "outcome": { "status": "completed" }, "increments": 4,
            "capped_increments": 0, "results": { "peak_stress_pa": 2.5, "bonds_intact": 3 },
            "peak_force": { "force_n": 7.5 } });
        let dir = tempfile::tempdir()?;
        let path = dir.path().join("study.csv");
        write(&path, &plan, &[record, Value::Null])?;
        let text = std::fs::read_to_string(&path)?;
        let lines: Vec<_> = text.lines().collect();
        assert!(lines[0].starts_with("run,mu,status,marks,increments,capped_increments,youngs"));
        assert_eq!(lines[1], "a,0.2,completed,,4,0,,,2.5,,,,,,,,,3,,,,,,,7.5,");
        assert_eq!(lines[2], "b,0.4,not run,not run,,,,,,,,,,,,,,,,,,,,,,");
        assert_eq!(read(&path)?, [("a".to_owned(), "mu 0.2".to_owned())]);
        Ok(())
    }
}
