//! The results of a sweep: one table and one figure.

use clastic::output::OutputError;
use clastic::output::atomic::write_atomic;
use clastic::output::directory;
use clastic::output::plots::history::History;
use clastic::output::plots::{self, compare};
use clastic::study::marks::marks;
use clastic::study::table;

use super::Sweep;
use crate::cli::exit::{Exit, Failure, say};

/// Name of the table.
const TABLE: &str = "study.csv";
/// Name of the figure.
const FIGURE: &str = "study.svg";

/// Writes the table and the figure, and prints how many runs can be trusted. Runs that failed are
/// rows with marks, and curves with marks in the legend.
pub fn collect(sweep: &Sweep) -> Result<Exit, Failure> {
    let Sweep { plan, folder, .. } = sweep;
    let records = table::records(plan, folder);
    let path = folder.join(TABLE);
    table::write(&path, plan, &records)?;
    say(format_args!("written: {}", path.display()))?;
    draw(sweep, &records)?;
    let mut marked = 0;
    let mut missing = 0;
    for (run, record) in plan.runs.iter().zip(&records) {
        let marks = marks(record);
        missing += usize::from(record.is_null());
        if !marks.is_empty() {
            marked += 1;
            say(format_args!("NOT TRUSTWORTHY: {}: {}", run.label(&plan.names), marks.join("; ")))?;
        }
    }
    say(format_args!("{} of {} runs without marks", plan.runs.len() - marked, plan.runs.len()))?;
    let failed = records.iter().any(|record| {
        matches!(record["outcome"]["status"].as_str(), Some("undecided" | "refused"))
    });
    Ok(if failed {
        Exit::Solver
    } else if missing > 0 {
        Exit::Files
    } else {
        Exit::Ok
    })
}

fn draw(sweep: &Sweep, records: &[serde_json::Value]) -> Result<(), Failure> {
    if !plots::DRAWN {
        return Ok(());
    }
    let mut runs = Vec::new();
    for (run, record) in sweep.plan.runs.iter().zip(records) {
        let history = sweep.folder.join(&run.directory).join(directory::HISTORY);
        if !history.exists() {
            continue;
        }
        let mut name = run.label(&sweep.plan.names);
        let marks = marks(record);
        if !marks.is_empty() {
            name += &format!(" ({})", marks.join("; "));
        }
        runs.push((name, History::read(&history)?));
    }
    let path = sweep.folder.join(FIGURE);
    match compare::stress(&runs) {
        Some(mut chart) => {
            chart.title.clone_from(&sweep.title);
            write_atomic(&path, chart.svg().map_err(OutputError::at(&path))?)?;
            say(format_args!("drawn: {}", path.display()))
        }
        // The picture may come from an earlier sweep of other runs.
        None => Ok(directory::remove_if_there(&path)?),
    }
}
