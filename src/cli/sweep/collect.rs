//! The results of a sweep as tables and as a page.

use crate::output::directory;
use crate::output::marks::marks;
use crate::study::{means, planned, table};
use crate::text::shown;

use super::Sweep;
use crate::cli::exit::{Exit, Failure, say};

const MEANS: &str = "study_means.csv";

/// Lock of the two tables.
const LOCK: &str = "study.lock";

/// Writes tables and page, and prints how many runs can be trusted. A failed run has a mark.
pub fn collect(sweep: &Sweep) -> Result<Exit, Failure> {
    let Sweep { plan, folder, .. } = sweep;
    // Two sweeps in one folder may end at the same moment: one writes after the other.
    let lock = directory::open_lock(&folder.join(LOCK))?;
    // A file system without locks has no other holder to wait for.
    let _ = lock.lock();
    let records = table::records(plan, folder);
    let path = folder.join(table::FILE);
    table::write(&path, plan, &records)?;
    say(shown::label(&sweep.study.title))?;
    say(format_args!("written: {}", path.display()))?;
    average(sweep, &records)?;
    #[cfg(feature = "report")]
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
    Ok(match (failed, missing) {
        (true, _) => Exit::Solver,
        (false, 0) => Exit::Ok,
        (false, _) => Exit::Files,
    })
}

/// Writes and prints the means, if the study asks for them.
fn average(sweep: &Sweep, records: &[serde_json::Value]) -> Result<(), Failure> {
    let path = sweep.folder.join(MEANS);
    let over = &sweep.study.average_over;
    if over.is_empty() {
        // The existing table may come from an earlier form of the study.
        return Ok(directory::remove_if_there(&path)?);
    }
    let names = means::names(&sweep.plan, over);
    let groups = means::groups(&sweep.plan, records, over);
    means::write(&path, &names, &groups)?;
    say(format_args!("written: {}", path.display()))?;
    let peak = table::RESULTS.iter().position(|name| *name == "peak_stress_pa");
    for group in &groups {
        let label = planned::label(&names, &group.values);
        let spread = peak.map(|peak| group.results[peak]).unwrap_or_default();
        let megapascals = |stress: Option<f64>| stress.map(|stress| rounded(1e-6 * stress));
        let stress = match (megapascals(spread.mean), megapascals(spread.deviation)) {
            (Some(mean), Some(sd)) => format!("peak {mean} MPa, standard deviation {sd} MPa"),
            (Some(mean), None) => format!("peak {mean} MPa"),
            (None, _) => "no peak".to_owned(),
        };
        let marked = match group.marked {
            0 => String::new(),
            n => format!("; {n} with marks left out"),
        };
        say(format_args!("  {label}: {stress}, {} runs{marked}", group.runs))?;
    }
    Ok(())
}

/// Writes the page with the curves of the runs that were made.
#[cfg(feature = "report")]
fn draw(Sweep { plan, folder, .. }: &Sweep, records: &[serde_json::Value]) -> Result<(), Failure> {
    let made = plan.runs.iter().zip(records).filter(|(_, record)| !record.is_null());
    let named = made.map(|(run, _)| (run.label(&plan.names), folder.join(&run.directory)));
    let runs: Vec<_> = named.collect();
    let path = folder.join(directory::REPORT);
    if runs.is_empty() {
        // The page may come from an earlier sweep of other runs.
        return Ok(directory::remove_if_there(&path)?);
    }
    crate::output::report::write(&runs, &path)?;
    say(format_args!("written: {}", path.display()))
}

/// A number with four significant digits.
fn rounded(value: f64) -> String {
    let digits = if value == 0.0 { 0.0 } else { 3.0 - value.abs().log10().floor() };
    // Digits after many zeros are hard to read.
    if digits > 8.0 {
        return format!("{value:.3e}");
    }
    format!("{value:.0$}", digits.max(0.0) as usize)
}
