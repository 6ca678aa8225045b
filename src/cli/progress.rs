//! Progress of the run: a bar on a terminal, and plain lines otherwise.

use std::io::{self, IsTerminal};
use std::time::{Duration, Instant};

use crate::components::increment::ClasticProgress;
use crate::components::observation::Observation;
use crate::text::shown::label;
use indicatif::{ProgressBar, ProgressStyle};

use super::exit::complain;
use super::summary::stress;

/// Minimum time between plain lines, except at the start of a stage.
const PAUSE: Duration = Duration::from_secs(1);

pub struct Progress {
    quiet: bool,
    stages: usize,
    /// A bar for the current stage, on a terminal.
    bar: Option<ProgressBar>,
    /// Stage and time of the last line, or of the start of the bar.
    last: Option<(usize, Instant)>,
}

impl Progress {
    /// Starts the output for a run with this number of stages.
    pub fn new(quiet: bool, stages: usize) -> Self {
        let bar = bar(quiet, "{prefix} [{bar:24}] {pos}/{len}, {msg}, {eta} left");
        bar.iter().for_each(|bar| bar.enable_steady_tick(Duration::from_millis(200)));
        Self { quiet, stages, bar, last: None }
    }

    pub fn show(&mut self, place: &ClasticProgress, o: &Observation) {
        let stage = place.stage;
        let begins = self.last.is_none_or(|(last, _)| last != stage);
        let title = || format!("stage {}/{} {}", stage + 1, self.stages, label(&place.stage_name));
        if let Some(bar) = &self.bar {
            if begins {
                bar.reset();
                bar.set_prefix(title());
                self.last = Some((stage, Instant::now()));
            }
            // Increments may be fractions, and the bar counts whole ones.
            bar.set_length(place.total.ceil() as u64);
            bar.set_position(place.done as u64);
            bar.set_message(state(o));
        } else if !self.quiet
            && (begins || self.last.is_some_and(|(_, time)| time.elapsed() >= PAUSE))
        {
            let (done, total) = (place.done.floor(), place.total.ceil());
            complain(format_args!("{} {done}/{total}, {}", title(), state(o)));
            self.last = Some((stage, Instant::now()));
        }
    }

    pub fn end(self) {
        self.bar.iter().for_each(ProgressBar::finish_and_clear);
    }
}

/// A bar of this form on a terminal, unless it is to be quiet.
pub fn bar(quiet: bool, template: &str) -> Option<ProgressBar> {
    if quiet || !io::stderr().is_terminal() {
        return None;
    }
    let bar = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.progress_chars("=> "));
    }
    Some(bar)
}

/// Strain, stress and broken bonds of an increment, if they are defined, and whether bonds break at
/// constant load.
fn state(o: &Observation) -> String {
    let mut parts = vec![format!("increment {}", o.increment)];
    parts.extend(o.axial_strain.map(|e| format!("strain {:.3} %", 100.0 * e)));
    parts.extend(o.axial_stress.map(|s| format!("stress {}", stress(s))));
    let broken: usize = o.broken.iter().sum();
    if o.bonds + broken > 0 {
        parts.push(format!("{broken} of {} bonds broken", o.bonds + broken));
    }
    // The increments of an avalanche do not move the bar.
    if o.in_avalanche {
        parts.push("in an avalanche".to_owned());
    }
    parts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_avalanche_is_told_from_loading() {
        let loading =
            Observation { increment: 7, bonds: 8, broken: [1, 1, 0], ..Default::default() };
        assert_eq!(state(&loading), "increment 7, 2 of 10 bonds broken");
        let breaking = Observation { in_avalanche: true, ..loading };
        assert_eq!(state(&breaking), "increment 7, 2 of 10 bonds broken, in an avalanche");
    }
}
