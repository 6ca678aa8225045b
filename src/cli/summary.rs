//! The last lines of a run.

use std::path::Path;

use clastic::output::{Ending, Results};
use clastic::run::{Collapse, Outcome, StageEnd};

/// How the run ended, what came out, where it is.
pub fn summary(
    ending: &Ending,
    increment: u64,
    stages: &[StageEnd],
    results: &Results,
    directory: &Path,
) -> String {
    let outcome = match ending {
        Ending::Interrupted => format!(
            "interrupted after increment {increment}; `clastic resume {}` goes on",
            directory.display()
        ),
        Ending::Finished(Outcome::Completed) => format!("completed in {increment} increments"),
        Ending::Finished(Outcome::Collapsed(Collapse { stage, increment, reason })) => {
            format!("collapsed in increment {increment} of stage {stage}: {reason}")
        }
        Ending::Finished(Outcome::Stalled { increment, .. }) => {
            format!("stalled at increment {increment}")
        }
    };
    let r = results;
    let mut parts = Vec::new();
    parts.extend(r.youngs_modulus_pa.map(|e| format!("E = {}", stress(e))));
    if let (Some(peak), Some(strain)) = (r.peak_stress_pa, r.strain_at_peak) {
        parts.push(format!("peak stress {} at a strain of {:.4} %", stress(peak), 100.0 * strain));
    }
    parts.extend(r.limit_load_pa.map(|s| format!("limit load {}", stress(s))));
    if r.peak_stress_pa.is_some() {
        parts.extend(r.porosity.map(|n| format!("porosity {n:.4}")));
    }
    if r.bonds_created > 0 {
        let b = r.bonds_broken;
        parts.push(format!(
            "{} of {} bonds broken ({} tension, {} shear, {} rolling)",
            b.tension + b.shear + b.rolling,
            r.bonds_created,
            b.tension,
            b.shear,
            b.rolling,
        ));
    }
    let mut lines = vec![outcome];
    lines.extend(stages.iter().filter_map(stage));
    if !parts.is_empty() {
        lines.push(parts.join("; "));
    }
    lines.push(format!("results in {}", directory.display()));
    lines.join("\n")
}

/// What ended a stage before its last increment; nothing of one that ran to its end.
fn stage(end: &StageEnd) -> Option<String> {
    let StageEnd { stage, increments, .. } = end;
    let n = if *increments == 1 { "increment" } else { "increments" };
    let stop = end.stop.map(|stop| format!("{stop:?}"));
    stop.map(|stop| format!("stage {stage}: stopped by {stop} after {increments} {n}"))
}

/// A stress in the unit that suits it.
pub fn stress(pascals: f64) -> String {
    let (unit, size) = match pascals.abs() {
        s if s >= 1e9 => ("GPa", 1e9),
        s if s >= 1e6 => ("MPa", 1e6),
        s if s >= 1e3 => ("kPa", 1e3),
        _ => ("Pa", 1.0),
    };
    // Adding zero turns -0 into 0.
    format!("{:.4} {unit}", pascals / size + 0.0)
}

#[cfg(test)]
mod tests {
    use clastic::run::EndedBy;
    use clastic::scene::format::Stop;

    use super::*;

    #[test]
    fn stresses_are_said_in_a_suitable_unit() {
        let said = [1.14e9, -2.5e5, 0.0].map(stress);
        assert_eq!(said, ["1.1400 GPa", "-250.0000 kPa", "0.0000 Pa"]);
    }

    #[test]
    fn a_summary_says_only_what_is_defined() {
        let ending = Ending::Finished(Outcome::Completed);
        let end = |stage: &str, ended_by, stop| StageEnd {
            stage: stage.to_owned(),
            increments: 7,
            ended_by: Some(ended_by),
            stop,
        };
        let stages = [
            end("confine", EndedBy::AllIncrements, None),
            end("shear", EndedBy::Stop, Some(Stop::AxialStrain(0.02))),
        ];
        let text = summary(&ending, 35, &stages, &Results::default(), Path::new("runs/tension"));
        assert_eq!(
            text,
            "completed in 35 increments\n\
             stage shear: stopped by AxialStrain(0.02) after 7 increments\n\
             results in runs/tension"
        );
    }
}
