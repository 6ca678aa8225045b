//! Stop conditions of a stage.

use std::fmt::Arguments;

use crate::scene::format::{Area, Length, Quantity, Stop, Strain, Stress};

use super::findings::Findings;

pub(super) fn check(path: Arguments, stop: &Stop, findings: &mut Findings) {
    let number = format_args!("{path}[0]");
    let scene = findings.context.scene;
    let sure = findings.is_sure_of("measures");
    match stop {
        Stop::StressDrop(fraction) => {
            let allowed = |value| value > 0.0 && value < 1.0;
            findings.number(number, *fraction, allowed, "a fraction between 0 and 1");
            if scene.measure("axial_stress").is_none() && sure {
                let help = "add `axial_stress` to `measures`";
                findings.add(path, "no axial stress is measured", help);
            }
        }
        Stop::Full(time) => {
            findings.positive(number, *time, "a time in s");
        }
        Stop::Rest(speed) => {
            findings.positive(number, *speed, "a speed in m/s");
        }
        Stop::Below(name, value) | Stop::Above(name, value) | Stop::Until(name, value) => {
            let names: Vec<_> =
                scene.measures.iter().map(|measure| measure.name.as_str()).collect();
            findings.reference(number, name, ("measure", "measures"), &names);
            let number = format_args!("{path}[1]");
            match scene.measure(name) {
                Some(Quantity::Strain(_)) => {
                    let allowed = |value: f64| value.abs() < 1.0;
                    let what = "a strain as a fraction: 0.12 is 12 %";
                    findings.number(number, *value, allowed, what);
                }
                _ => {
                    findings.finite(number, *value, "a finite value");
                }
            }
        }
    }
    if findings.is_timeless() && matches!(stop, Stop::Rest(_)) && findings.is_sure_of("analysis") {
        let message = "a stop by speed in a static stage, which has no time";
        findings.add(path, message, "use a dynamic analysis");
    }
}

/// Walls on which a measure is taken.
fn walls(of: &Quantity) -> Vec<&String> {
    match of {
        Quantity::Strain(Strain::Walls(a, b)) => vec![a, b],
        Quantity::Stress(Stress::Walls { walls, length }) => {
            let between = match length {
                Length::Between(a, b) => vec![a, b],
                Length::Fixed(_) | Length::Membrane(_) => Vec::new(),
            };
            walls.iter().chain(between).collect()
        }
        Quantity::Stress(Stress::Average { area: Area::Box((a, b), (c, d)), .. })
        | Quantity::Porosity(Area::Box((a, b), (c, d))) => vec![a, b, c, d],
        Quantity::WallForce { wall, .. } => vec![wall],
        _ => Vec::new(),
    }
}

/// Finds stop conditions on measures that are not defined in their stage, which could never be met.
pub(super) fn never(path: Arguments, stop: &Stop, findings: &mut Findings) {
    let context = findings.context;
    if !findings.are_sure_of(&["measures", "stages", "walls"]) {
        return;
    }
    let scene = context.scene;
    let Some(of) = stop.measure().and_then(|name| scene.measure(name)) else { return };
    if let Some(wall) = walls(of).iter().find(|name| findings.is_there(name) == Some(false)) {
        let message =
            format!("it can never hold: wall `{wall}`, on which it is measured, is not there");
        findings.add(path, message, "measure on walls of this stage, or leave it out");
    }
    if findings.is_timeless() && matches!(of, Quantity::Time) && findings.is_sure_of("analysis") {
        let message = "it can never hold: a static stage has no time";
        findings.add(path, message, "use a dynamic analysis");
    }
    let last = context.stages.len().saturating_sub(1);
    let reference = match &scene.reference_stage {
        Some(name) => context.stages.iter().position(|stage| *stage == name).unwrap_or(0),
        None => scene.reference_stage(),
    };
    let counts = matches!(
        of,
        Quantity::Strain(_)
            | Quantity::VolumetricStrain
            | Quantity::DilationAngle { .. }
            | Quantity::Ring { .. }
    ) || matches!(of, Quantity::Grains { moved, .. } if *moved > 0.0);
    if counts && findings.stage < reference {
        let name = context.stages[reference];
        let the_last = if reference == last { ", the last one" } else { "" };
        let message =
            format!("it can never hold: strains count from the start of stage `{name}`{the_last}");
        findings.add(path, message, "set `reference_stage` to this stage or an earlier one");
    }
}
