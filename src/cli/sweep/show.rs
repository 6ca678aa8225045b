//! Progress of a sweep: a bar and a line per run under way on a terminal, a line per run that has
//! ended otherwise.

use std::fs;

use indicatif::ProgressBar;

use super::Sweep;
use super::task::Task;
use crate::cli::exit::complain;
use crate::cli::progress::bar;
use crate::output::directory;

pub(crate) struct Show {
    bar: Option<ProgressBar>,
    quiet: bool,
    done: usize,
    total: usize,
}

impl Show {
    /// Progress of `total` runs, of which nothing is shown if `quiet`, apart from failures.
    pub fn new(quiet: bool, total: usize) -> Self {
        let bar = bar(quiet, "[{bar:24}] {pos}/{len} runs, {elapsed}{msg}");
        bar.iter().for_each(|bar| bar.set_length(total as u64));
        Self { bar, quiet, done: 0, total }
    }

    /// Shows the end of a run; `failed` is what it said if it failed.
    pub fn done(&mut self, sweep: &Sweep, task: Task, failed: Option<String>) {
        self.done += 1;
        let label = sweep.label(task);
        let line = match &failed {
            Some(said) => format!("{label}: failed: {}", said.trim()),
            None => format!("{label}: done"),
        };
        match &self.bar {
            Some(bar) => {
                bar.set_position(self.done as u64);
                if failed.is_some() {
                    bar.suspend(|| complain(&line));
                }
            }
            None if !self.quiet || failed.is_some() => {
                complain(format_args!("{}/{} {line}", self.done, self.total));
            }
            None => {}
        }
    }

    /// Shows the last row of each run under way.
    pub fn state(&self, sweep: &Sweep, running: impl Iterator<Item = Task>) {
        let Some(bar) = &self.bar else { return };
        let lines = running.map(|task| {
            let history = fs::read(sweep.directory(task).join(directory::HISTORY));
            let history = history.unwrap_or_default();
            format!("\n  {}: {}", sweep.label(task), last_row(&String::from_utf8_lossy(&history)))
        });
        bar.set_message(lines.collect::<String>());
        bar.tick();
    }

    pub fn end(self) {
        self.bar.iter().for_each(ProgressBar::finish_and_clear);
    }
}

/// Where a run is, from its history: number of increments, stage, axial strain and stress.
fn last_row(history: &str) -> String {
    let mut lines = history.lines();
    let names: Vec<_> = lines.next().unwrap_or_default().split(',').collect();
    // A row that is being written lacks its end.
    let whole: Vec<_> = lines.filter(|row| row.split(',').count() == names.len()).collect();
    let Some(row) = whole.last() else { return "begins".to_owned() };
    let value = |name: &str| {
        let at = names.iter().position(|known| *known == name)?;
        row.split(',').nth(at).filter(|value| !value.is_empty())
    };
    let number = |name: &str| value(name)?.parse::<f64>().ok();
    let mut text = format!("{} increments", whole.len());
    if let Some(stage) = value("stage") {
        text += &format!(", {stage}");
    }
    if let Some(strain) = number("axial_strain") {
        text += &format!(", {:.2} % strain", 100.0 * strain);
    }
    if let Some(stress) = number("axial_stress_pa") {
        text += &format!(", {:.4} MPa", 1e-6 * stress);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::last_row;

    #[test]
    fn a_run_under_way_shows_its_last_whole_row() {
        let history =
            "increment,stage,axial_strain,axial_stress_pa\n1,confine,,\n2,load,0.011,2.5e6\n3,lo";
        assert_eq!(last_row(history), "2 increments, load, 1.10 % strain, 2.5000 MPa");
        assert_eq!(last_row("increment,stage\n"), "begins");
        assert_eq!(last_row("increment,stage\n7,fall\n"), "1 increments, fall");
    }
}
