//! The last lines of a run.

use std::path::Path;

use crate::output::drive::PeakForce;
use crate::output::found::Settled;
use crate::output::run_record::RunRecord;
use crate::run::key_results::{PEAK_ERROR, RIGID, Results};
use crate::run::stages::Script;
use crate::run::{Collapse, EndedBy, Outcome, StageEnd};
use crate::scene::format::{Analysis, RuptureOrder, Scene, Stage};
use crate::scene::one_round::one_round;
use crate::text::shown::label;

/// Text of the summary: how the run ended after `increment` increments, key results, directory.
pub fn summary(
    outcome: Option<&Outcome>,
    increment: u64,
    script: &Script,
    record: &RunRecord,
    directory: &Path,
) -> String {
    let said = match outcome {
        None => format!(
            "interrupted after increment {increment}; `clastic resume {}` goes on",
            directory.display()
        ),
        Some(Outcome::Completed) => {
            let capped = match script.ends.iter().map(|end| end.capped).sum::<u64>() {
                0 => String::new(),
                n if n == increment => ", all of them capped".to_owned(),
                n => format!(", {n} of them capped"),
            };
            format!("completed in {increment} increments{capped}")
        }
        Some(Outcome::Collapsed(Collapse { stage, increment, reason, .. })) => {
            format!("collapsed in increment {increment}, in stage {}: {reason}", label(stage))
        }
        Some(Outcome::Undecided { increment, .. }) => {
            format!("undecided at increment {increment}")
        }
        Some(Outcome::Halted(message)) => {
            format!("stopped after increment {increment}: {message}")
        }
        Some(Outcome::Refused { stage, .. }) => {
            format!("stopped after increment {increment}: stage {} cannot begin", label(stage))
        }
    };
    let r = &record.results;
    let mut parts = Vec::new();
    parts.extend(r.youngs_modulus_pa.map(|e| format!("E = {}", stress(e))));
    if let (Some(peak), Some(strain)) = (r.peak_stress_pa, r.strain_at_peak) {
        // The strength is the peak of a test that has passed it.
        let name = if r.strength_pa.is_some() { "strength (peak stress)" } else { "peak stress" };
        let capped = if r.peak_is_capped { " (capped)" } else { "" };
        // An unloading after the test would be the reference stage without a word.
        let loads = script.scene.stages.iter().filter(|stage| stage.load().is_some());
        let reference = script.scene.stages.get(script.reference_stage());
        let of = reference.filter(|_| loads.count() > 1);
        let of = of.map_or(String::new(), |of| format!(" of stage {}", label(of.name())));
        parts.push(format!(
            "{name}{capped} {} at a strain of {:.4} %{of}",
            stress(peak),
            100.0 * strain
        ));
    }
    parts.extend(record.peak_force.as_ref().map(PeakForce::line));
    parts.extend(r.residual_strength_pa.map(|s| format!("residual strength {}", stress(s))));
    let angle = r.friction_angle_rad.map(f64::to_degrees);
    parts.extend(angle.map(|phi| format!("friction angle {phi:.2} degrees")));
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
        if r.avalanches > 0 {
            let largest = number(r.largest_avalanche, "bond");
            parts.push(format!("{}, the largest of {largest}", number(r.avalanches, "avalanche")));
        }
    }
    let mut lines = vec![said];
    lines.extend(script.ends.iter().filter_map(stage));
    lines.extend(warnings(script));
    lines.extend(after_collapse(script));
    let reason = one_round(&script.scene).filter(|_| r.bonds_created > 0);
    lines.extend(reason.map(|reason| format!("note: {}", in_one_round(&reason))));
    lines.extend(peak_error(&script.scene, r));
    lines.extend(record.sanity.warnings.iter().map(|warning| format!("WARNING: {warning}")));
    lines.extend(not_defined(script, outcome, r));
    if !parts.is_empty() {
        lines.push(parts.join("; "));
    }
    lines.extend(record.settled.map(|Settled { porosity_before, porosity_after }| {
        format!(
            "note: the packing was not jammed and settled in the first increment after its \
             compaction: porosity {porosity_before:.4} before, {porosity_after:.4} after"
        )
    }));
    lines.extend(Some(record.sanity.line()).filter(|line| !line.is_empty()));
    lines.extend(record.specimen_csv.as_ref().map(|moment| {
        let moment = label(moment);
        format!("specimen.csv holds the particles {moment}; final_particles.csv those at the end")
    }));
    lines.push(format!("results in {}", directory.display()));
    lines.join("\n")
}

/// Warnings about the ends of the stages.
fn warnings(script: &Script) -> Vec<String> {
    let ends = &script.ends;
    let of_ends = ends.iter().filter_map(StageEnd::warning);
    let mut lines: Vec<_> = of_ends.map(|warning| format!("WARNING: {warning}")).collect();
    let capped = || ends.iter().filter(|end| end.capped > 0);
    if capped().next().is_some() {
        let mut line = "a capped increment has not converged: it satisfies Coulomb's law to a residual of 1e-4 only"
            .to_owned();
        if capped().any(|end| is_dynamic(script, end)) {
            line += "; in dynamic stages a `normal_stiffness` of the grains of at most 50 m/dt^2, with m the mass of \
                     the mean disk, mostly helps; a smaller `dt` allows stiffer grains";
        }
        if capped().any(|end| !is_dynamic(script, end)) {
            line += "; in static stages Coulomb's law may have no solution near the last state";
        }
        line += "; a larger `acceptance.residual`, where the test allows it, or `friction_law: Associated` may \
                 help. Tangent modulus and Poisson's ratio leave it out";
        lines.push(line);
    }
    lines
}

/// Warning about stages that were solved after a collapse.
fn after_collapse(script: &Script) -> Option<String> {
    let collapsed = &script.collapse.as_ref()?.stage;
    let after = script.ends.iter().skip_while(|end| end.stage != *collapsed).skip(1);
    let is_solved = |end: &&StageEnd| {
        end.rows > 0 && matches!(end.ended_by, Some(EndedBy::AllIncrements | EndedBy::Stop))
    };
    let solved: Vec<_> = after.filter(is_solved).map(|end| label(&end.stage)).collect();
    (!solved.is_empty()).then(|| {
        format!(
            "WARNING: stage {} collapsed; what came after it ({}) was solved from the last equilibrium before \
             that, which the collapse would have left",
            label(collapsed),
            solved.join(", ")
        )
    })
}

fn is_dynamic(script: &Script, end: &StageEnd) -> bool {
    let stage = script.scene.stages.iter().find(|stage| stage.name() == end.stage);
    let analysis = stage.and_then(Stage::analysis);
    matches!(analysis.unwrap_or(script.scene.analysis), Analysis::Dynamic { .. })
}

/// Warning that `rupture.order: Events` does not hold for a scene.
pub(super) fn in_one_round(reason: &str) -> String {
    format!(
        "`rupture.order: Events` does not hold here: {reason}; bonds break as with `OneRound`, and the strength \
         depends on the size of the increments"
    )
}

/// Key results that the measured strain and stress should define but do not, with reasons.
fn not_defined(script: &Script, outcome: Option<&Outcome>, results: &Results) -> Vec<String> {
    let scene = &script.scene;
    if scene.strain("axial_strain").is_none() || scene.stress("axial_stress").is_none() {
        return Vec::new();
    }
    let reason = |name: &str| results.not_defined.get(name);
    if let Some(reason) = reason("peak_stress_pa") {
        let stage = label(scene.stages.get(script.reference_stage()).map_or("", Stage::name));
        return vec![format!(
            "no modulus and no peak stress: {reason} (the reference stage is {stage}; `reference_stage` sets it)"
        )];
    }
    let mut lines = Vec::new();
    // A rigid specimen has a limit load and no modulus, so this is no warning.
    let modulus = reason("youngs_modulus_pa").filter(|reason| *reason != RIGID);
    lines.extend(modulus.map(|reason| format!("E is not defined: {reason}")));
    if matches!(outcome, Some(Outcome::Collapsed(_))) {
        let limit = reason("limit_load_pa");
        lines.extend(limit.map(|reason| format!("the limit load is not defined: {reason}")));
    }
    lines
}

/// Warning about a peak that depends on the size of the increments, with what helps under the rule by
/// which bonds broke.
fn peak_error(scene: &Scene, results: &Results) -> Option<String> {
    let estimate = results.peak_error_estimate.filter(|e| *e > PEAK_ERROR)?;
    results.peak_stress_pa?;
    let events = scene.rupture.order == RuptureOrder::Events;
    let (why, remedy) = if events && one_round(scene).is_none() {
        (
            "many bonds broke together at the end of an increment",
            "let each bond break at its own load, `rupture: (density: 21.0, brittleness: 0.0)`, \
             which takes several solves a bond",
        )
    } else if events {
        ("bonds broke late", "remove the reason for which `Events` does not hold here")
    } else {
        (
            "bonds broke late",
            "`rupture: (order: Events)` (it holds for static stages and elastic bonds with strength that \
             do not break in rolling)",
        )
    };
    Some(format!(
        "WARNING: the peak depends on the size of the increments, by about {:.0} %: {why}; give smaller \
         increments, or {remedy}",
        100.0 * estimate
    ))
}

/// What ended a stage before its last increment, or where a packing is jammed; `None` for a stage
/// that ran to its end.
fn stage(end: &StageEnd) -> Option<String> {
    let stop = end.stop.as_ref().filter(|_| end.ended_by == Some(EndedBy::Stop));
    let what = match (end.jammed_at, stop) {
        (Some(porosity), _) => format!("jammed at a porosity of {porosity:.4}"),
        (None, Some(stop)) => format!("stopped by {stop:?}"),
        (None, None) => return None,
    };
    let made = number(end.increments as usize, "increment");
    Some(format!("stage {}: {what} after {made}", label(&end.stage)))
}

/// A number of things, such as `2 walls`.
pub fn number(n: usize, of: &str) -> String {
    format!("{n} {of}{}", if n == 1 { "" } else { "s" })
}

/// A stress in a suitable unit.
pub fn stress(pascals: f64) -> String {
    let (unit, size) = match pascals.abs() {
        s if s >= 1e9 => ("GPa", 1e9),
        s if s >= 1e6 => ("MPa", 1e6),
        s if s >= 1e3 => ("kPa", 1e3),
        _ => ("Pa", 1.0),
    };
    // Adding zero changes -0 to 0.
    format!("{:.4} {unit}", pascals / size + 0.0)
}

#[cfg(test)]
mod tests {
    use crate::output::run_record::RunFacts;
    use crate::run::CollapsedBy;
    use crate::run::key_results::KeyResults;
    use crate::scene::format::Stop;
    use crate::scene::from_str;

    use super::*;

    #[test]
    fn stresses_are_said_in_a_suitable_unit() {
        let said = [1.14e9, -2.5e5, 0.0].map(stress);
        assert_eq!(said, ["1.1400 GPa", "-250.0000 kPa", "0.0000 Pa"]);
    }

    const SCENE: &str = r#"(version: 1, title: "t", materials: {"m": ()},
        specimen: Particles([(position: (0.0, 0.0), radius: 1.0), (position: (0.0, 2.0), radius: 1.0)]),
        stages: [Load(name: "confine", increments: 1), Load(name: "shear", increments: 1)],
        measures: [(name: "axial_strain", of: Strain(Particles(0, 1))), (name: "axial_stress", of: Stress(Average(component: Yy, area: Fixed(1.0))))])"#;

    /// Summary of a run of two stages, each with its number of increments and of capped increments.
    fn said(stages: [(u64, u64); 2], measured: bool, results: &Results) -> String {
        let mut loaded = from_str(SCENE, Path::new("t.ron"), Path::new(""), &[]).unwrap();
        if !measured {
            loaded.scene.measures = Default::default();
        }
        let stop = Some(Stop::Above("axial_strain".to_owned(), 0.02));
        let ends = [("confine", None), ("shear", stop)].into_iter().zip(stages);
        let ends = ends.map(|((stage, stop), (increments, capped))| StageEnd {
            stage: stage.to_owned(),
            increments,
            rows: increments,
            capped,
            ended_by: Some(stop.as_ref().map_or(EndedBy::AllIncrements, |_| EndedBy::Stop)),
            stop,
            ..StageEnd::default()
        });
        let mut script = Script::new(&loaded.scene);
        script.ends = ends.collect();
        let mut record = RunRecord::new(&loaded, &RunFacts::new(&loaded, &[]).unwrap());
        record.results = results.clone();
        summary(Some(&Outcome::Completed), 35, &script, &record, Path::new("runs/tension"))
    }

    #[test]
    fn a_summary_says_only_what_is_defined() {
        assert_eq!(
            said([(28, 0), (7, 0)], false, &Results::default()),
            "completed in 35 increments\nstage shear: stopped by Above(\"axial_strain\", 0.02) after 7 \
             increments\nresults in runs/tension"
        );
    }

    #[test]
    fn a_summary_warns_of_capped_increments() {
        let some = said([(28, 5), (7, 0)], false, &Results::default());
        assert!(some.starts_with("completed in 35 increments, 5 of them capped\n"), "{some}");
        assert!(
            some.contains("\nWARNING: 5 of 28 increments of stage confine are capped\n"),
            "{some}"
        );
        let all = said([(28, 0), (7, 7)], false, &Results::default());
        assert!(all.contains("\nWARNING: all 7 increments of stage shear are capped\n"), "{all}");
        assert!(
            all.contains("has not converged") && all.contains("`acceptance.residual`"),
            "{all}"
        );
        assert!(all.contains("in static stages") && !all.contains("in dynamic stages"), "{all}");
    }

    #[test]
    fn a_summary_marks_a_peak_at_a_capped_increment() {
        let results = Results {
            peak_stress_pa: Some(2.5e5),
            strain_at_peak: Some(0.01),
            peak_is_capped: true,
            ..Results::default()
        };
        let said = said([(28, 0), (7, 7)], true, &results);
        assert!(!said.contains("E = ") && said.contains("peak stress (capped) "), "{said}");
    }

    /// A slope that collapsed at one weight was "solved" at the next.
    #[test]
    fn a_summary_names_what_was_solved_after_a_collapse() {
        let scene = from_str(SCENE, Path::new("t.ron"), Path::new(""), &[]).unwrap().scene;
        let end = |stage: &str, ended_by| StageEnd {
            stage: stage.to_owned(),
            rows: 3,
            ended_by: Some(ended_by),
            ..StageEnd::default()
        };
        let said = |last| {
            let collapse = Collapse {
                stage: "confine".to_owned(),
                increment: 3,
                by: CollapsedBy::Motion,
                reason: String::new(),
            };
            let ends = vec![end("confine", EndedBy::Collapse), end("shear", last)];
            let mut script = Script::new(&scene);
            (script.ends, script.collapse) = (ends, Some(collapse));
            after_collapse(&script)
        };
        let line = said(EndedBy::AllIncrements).unwrap();
        assert!(
            line.contains("stage confine collapsed; what came after it (shear) was solved"),
            "{line}"
        );
        assert_eq!(said(EndedBy::Collapse), None);
    }

    #[test]
    fn remedies_for_capped_increments_follow_the_analysis() {
        let scene = SCENE.replace("version: 1,", "version: 1, analysis: Dynamic(dt: 1.0e-3),");
        let scene = from_str(&scene, Path::new("t.ron"), Path::new(""), &[]).unwrap().scene;
        let end = StageEnd {
            stage: "confine".to_owned(),
            rows: 3,
            capped: 1,
            ended_by: Some(EndedBy::AllIncrements),
            ..StageEnd::default()
        };
        let mut script = Script::new(&scene);
        script.ends = vec![end];
        let lines = warnings(&script);
        assert_eq!(lines.len(), 2);
        assert!(lines[1].contains("in dynamic stages"), "{lines:?}");
        assert!(!lines[1].contains("in static stages"), "{lines:?}");
    }

    /// A stage that should land on a value and ran out of increments, and one that passed its value:
    /// neither has capped increments, so that no remedy for these stands there.
    #[test]
    fn a_summary_warns_of_an_until_that_was_not_reached() {
        let scene = from_str(SCENE, Path::new("t.ron"), Path::new(""), &[]).unwrap().scene;
        let end = |ended_by, passed| StageEnd {
            stage: "confine".to_owned(),
            increments: 1,
            passed,
            ended_by: Some(ended_by),
            stop: Some(Stop::Until("q".to_owned(), 3.0e5)),
            ..StageEnd::default()
        };
        let said = |end| {
            let mut script = Script::new(&scene);
            script.ends = vec![end];
            warnings(&script)
        };
        let missed = end(EndedBy::AllIncrements, None);
        assert_eq!(stage(&missed), None);
        assert_eq!(
            said(missed),
            [
                "WARNING: stage confine ended with the last of its increments and did not reach Until(\"q\", 300000.0)"
            ]
        );
        let passed = said(end(EndedBy::Stop, Some(4.0e5)));
        assert!(passed.len() == 1 && passed[0].contains("beyond"), "{passed:?}");
    }

    #[test]
    fn a_summary_says_why_a_measured_rig_has_no_results() {
        let results = KeyResults::new(false).results();
        let text = said([(28, 0), (0, 0)], true, &results);
        let line = text.lines().find(|line| line.starts_with("no modulus")).unwrap_or_default();
        for what in ["no increment from the start", "reference stage is shear", "`reference_stage`"]
        {
            assert!(line.contains(what), "no `{what}` in {text}");
        }
    }

    fn of_peak(rupture: &str) -> String {
        let text = include_str!("../../scenes/uniaxial_small.ron");
        assert!(text.contains("rupture: (order: OneRound)"));
        let text = text.replacen("rupture: (order: OneRound)", &format!("rupture: {rupture}"), 1);
        let scene = from_str(&text, "s.ron".as_ref(), ".".as_ref(), &[]).unwrap().scene;
        let results = Results {
            peak_stress_pa: Some(1e6),
            peak_error_estimate: Some(0.03),
            ..Results::default()
        };
        peak_error(&scene, &results).unwrap()
    }

    #[test]
    fn the_warning_of_a_peak_does_not_advise_the_order_that_is_in_use() {
        let of_events = of_peak("(order: Events, rolling: Yields)");
        assert!(!of_events.contains("order: Events"), "{of_events}");
        assert!(of_events.contains("density: 21.0, brittleness: 0.0"), "{of_events}");
        assert!(of_peak("(order: OneRound)").contains("rupture: (order: Events)"));
    }
}
