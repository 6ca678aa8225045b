//! Progress of the run: a bar on a terminal, and plain lines otherwise.

use std::io::{self, IsTerminal};
use std::time::{Duration, Instant};

use crate::components::increment::ClasticProgress;
use crate::components::observation::Observation;
use crate::scene::shown::label;
use indicatif::{ProgressBar, ProgressStyle};

use super::exit::complain;
use super::summary::stress;

/// Minimum time between plain lines, except at the start of a stage.
const PAUSE: Duration = Duration::from_secs(1);

/// Output during a run.
pub enum Progress {
    /// No output.
    Quiet,
    /// A bar for the current stage.
    Bar {
        /// The bar.
        bar: ProgressBar,
        /// Stage of the bar.
        stage: Option<usize>,
        /// Number of stages.
        stages: usize,
    },
    /// Lines on standard error.
    Lines {
        /// Stage and time of the last line.
        last: Option<(usize, Instant)>,
        /// Number of stages.
        stages: usize,
    },
}

impl Progress {
    /// Starts the output for a run with this number of stages.
    pub fn new(quiet: bool, stages: usize) -> Self {
        if quiet {
            return Self::Quiet;
        }
        if !io::stderr().is_terminal() {
            return Self::Lines { last: None, stages };
        }
        let bar = ProgressBar::new(0);
        let template = "{prefix} [{bar:24}] {pos}/{len}, {msg}, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        Self::Bar { bar, stage: None, stages }
    }

    /// Shows the progress after an increment.
    pub fn show(&mut self, place: &ClasticProgress, o: &Observation) {
        let name = label(&place.stage_name);
        let title = |stages| format!("stage {}/{stages} {name}", place.stage + 1);
        match self {
            Self::Quiet => {}
            Self::Bar { bar, stage, stages } => {
                if *stage != Some(place.stage) {
                    *stage = Some(place.stage);
                    bar.reset();
                    bar.set_prefix(title(*stages));
                }
                // Increments may be fractions, and the bar counts whole ones.
                bar.set_length(place.total.ceil() as u64);
                bar.set_position(place.done as u64);
                bar.set_message(state(o));
            }
            Self::Lines { last, stages } => {
                let due = last
                    .is_none_or(|(stage, time)| stage != place.stage || time.elapsed() >= PAUSE);
                if due {
                    *last = Some((place.stage, Instant::now()));
                    let (done, total) = (place.done.floor(), place.total.ceil());
                    complain(format_args!("{} {done}/{total}, {}", title(*stages), state(o)));
                }
            }
        }
    }

    /// Clears the bar.
    pub fn end(self) {
        if let Self::Bar { bar, .. } = self {
            bar.finish_and_clear();
        }
    }
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
