//! `study_means.csv`: key results as means over some of the names of a study, such as the seeds.

use std::path::Path;

use indexmap::IndexMap;
use serde_json::Value;

use super::planned::Plan;
use super::table::{RESULTS, result};
use crate::output::OutputError;
use crate::output::atomic::write_atomic;
use crate::output::csv_file::Row;
use crate::output::marks::marks;

/// Runs that differ only in the names over which the means are taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Values of the other names, in their order; empty where the runs lack a name.
    pub values: Vec<String>,
    /// Number of runs without marks, over which the means are taken.
    pub runs: usize,
    /// Number of runs with marks, which are in no mean.
    pub marked: usize,
    /// Per result of [`RESULTS`]: mean and standard deviation.
    pub results: Vec<Spread>,
}

/// Mean and scatter of a result.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Mean; `None` if no run of the group defines the result.
    pub mean: Option<f64>,
    /// Standard deviation of the sample, with n - 1; `None` for fewer than two runs.
    pub deviation: Option<f64>,
}

impl Spread {
    /// Mean and scatter of a sample.
    pub fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let square = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        Self {
            mean: (!values.is_empty()).then_some(mean),
            deviation: (values.len() > 1).then(|| square.sqrt()),
        }
    }
}

/// Names in which the groups differ: all except `over`.
pub fn names<'a>(plan: &'a Plan, over: &[String]) -> Vec<&'a str> {
    plan.names.iter().filter(|name| !over.contains(name)).map(String::as_str).collect()
}

/// The groups of a plan in the order of their first runs. `records` are those of the runs.
pub fn groups(plan: &Plan, records: &[Value], over: &[String]) -> Vec<Group> {
    let mut groups: IndexMap<Vec<String>, Vec<&Value>> = IndexMap::new();
    for (run, record) in plan.runs.iter().zip(records) {
        let kept = plan.names.iter().zip(&run.values).filter(|(name, _)| !over.contains(name));
        let values = kept.map(|(_, value)| value.clone()).collect();
        groups.entry(values).or_default().push(record);
    }
    let group = |(values, records): (Vec<String>, Vec<&Value>)| {
        let all = records.len();
        let sound: Vec<_> = records.into_iter().filter(|r| marks(r).is_empty()).collect();
        let spread = |name: &&str| {
            let values: Vec<_> = sound.iter().filter_map(|r| result(r, name).as_f64()).collect();
            Spread::of(&values)
        };
        let results = RESULTS.iter().map(spread).collect();
        Group { values, runs: sound.len(), marked: all - sound.len(), results }
    };
    groups.into_iter().map(group).collect()
}

/// Writes the table: per group its values, the number of runs in the means, the number of marked
/// runs that they leave out, and mean and standard deviation of every key result.
pub fn write(path: &Path, names: &[&str], groups: &[Group]) -> Result<(), OutputError> {
    let mut header = Row::default().and(names.iter().copied()).and(["runs", "marked_runs"]);
    for name in RESULTS {
        header = header.with(&*format!("{name}_mean")).with(&*format!("{name}_sd"));
    }
    let row = |group: &Group| {
        let results = group.results.iter().flat_map(|spread| [spread.mean, spread.deviation]);
        let numbers = [group.runs as u64, group.marked as u64];
        Row::default().and(group.values.iter().map(String::as_str)).and(numbers).and(results).line()
    };
    write_atomic(path, header.line() + &groups.iter().map(row).collect::<String>())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::study::PlannedRun;

    /// Peaks of 1, 2 and 6 Pa of three seeds: mean 3, deviation sqrt(7). A run with marks counts
    /// apart.
    #[test]
    fn runs_with_marks_are_in_no_mean() -> Result<(), Box<dyn std::error::Error>> {
        let run = |strength: &str, seed: &str| PlannedRun {
            values: vec![strength.to_owned(), seed.to_owned()],
            ..PlannedRun::default()
        };
        let record = |status: &str, peak: f64| {
            json!({ "outcome": { "status": status }, "increments": 1, "capped_increments": 0,
                "results": { "peak_stress_pa": peak } })
        };
        let plan = Plan {
            names: vec!["strength".to_owned(), "seed".to_owned()],
            runs: ["1", "2", "3", "4"].map(|seed| run("weak", seed)).to_vec(),
            ..Plan::default()
        };
        let records = [
            record("completed", 1.0),
            record("completed", 2.0),
            record("undecided", 50.0),
            record("collapsed", 6.0),
        ];
        let over = ["seed".to_owned()];
        let found = groups(&plan, &records, &over);
        assert_eq!((found.len(), found[0].runs, found[0].marked), (1, 3, 1));
        let peak = RESULTS.iter().position(|name| *name == "peak_stress_pa").unwrap_or(0);
        let Spread { mean, deviation } = found[0].results[peak];
        assert!((mean.unwrap_or(0.0) - 3.0).abs() < 1e-12);
        assert!((deviation.unwrap_or(0.0) - 7.0_f64.sqrt()).abs() < 1e-12);
        let dir = tempfile::tempdir()?;
        let path = dir.path().join("means.csv");
        write(&path, &names(&plan, &over), &found)?;
        let text = std::fs::read_to_string(path)?;
        assert!(text.starts_with("strength,runs,marked_runs,youngs_modulus_pa_mean,"), "{text}");
        assert!(text.contains("\nweak,3,1,"), "{text}");
        Ok(())
    }
}
