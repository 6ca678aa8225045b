//! Stop conditions of a stage.

use std::fmt::Arguments;

use crate::scene::format::{Area, Length, Measures, Quantity, ROLES, Stop, Strain, Stress};

use super::Context;
use super::findings::Findings;

pub(super) fn check(
    context: &Context,
    path: Arguments,
    stop: &Stop,
    timeless: bool,
    findings: &mut Findings,
) {
    let number = format_args!("{path}[0]");
    let measures = &context.scene.measures;
    let sure = findings.is_sure_of("measures");
    match stop {
        Stop::AxialStrain(strain) => {
            // Negative values are permitted and mean extension.
            let allowed = |size: f64| size > 0.0 && size < 1.0;
            let what = "a strain as a fraction: 0.12 is 12 %";
            findings.number(number, strain.abs(), allowed, what);
            if measures.axial_strain.is_none() && sure {
                let help = "add `axial_strain` to `measures`";
                findings.add(path, "no axial strain is measured", help);
            }
        }
        Stop::StressDrop(fraction) => {
            let allowed = |value| value > 0.0 && value < 1.0;
            findings.number(number, *fraction, allowed, "a fraction between 0 and 1");
            if measures.axial_stress.is_none() && sure {
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
                measures.list.iter().flatten().map(|measure| measure.name.as_str()).collect();
            if context.scene.version != 1 {
                findings.reference(number, name, ("measure", "measures"), &names);
            }
            let number = format_args!("{path}[1]");
            match of(measures, name) {
                Some(Of::Strain(_)) => {
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
    if timeless && matches!(stop, Stop::Rest(_)) && findings.is_sure_of("analysis") {
        let message = "a stop by speed in a static stage, which has no time";
        findings.add(path, message, "use a dynamic analysis");
    }
}

/// The quantity that a measure of this name reads.
enum Of<'a> {
    Strain(&'a Strain),
    Stress(&'a Stress),
    Other(&'a Quantity),
}

fn of<'a>(measures: &'a Measures, name: &str) -> Option<Of<'a>> {
    let Measures { axial_strain, lateral_strain, axial_stress, lateral_stress, .. } = measures;
    match ROLES.iter().position(|role| *role == name) {
        Some(0) => axial_strain.as_ref().map(Of::Strain),
        Some(1) => lateral_strain.as_ref().map(Of::Strain),
        Some(2) => axial_stress.as_ref().map(Of::Stress),
        Some(_) => lateral_stress.as_ref().map(Of::Stress),
        None => {
            measures.further().find(|measure| measure.name == name).map(|measure| {
                match &measure.of {
                    Quantity::Strain(of) => Of::Strain(of),
                    Quantity::Stress(of) => Of::Stress(of),
                    of => Of::Other(of),
                }
            })
        }
    }
}

/// Walls on which a measure is taken.
fn walls<'a>(of: &Of<'a>) -> Vec<&'a String> {
    let area = |area: &'a Area| match area {
        Area::Box((a, b), (c, d)) => vec![a, b, c, d],
        Area::Fixed(_) | Area::Cell | Area::Membrane(_) => Vec::new(),
    };
    match *of {
        Of::Strain(Strain::Walls(a, b)) => vec![a, b],
        Of::Stress(Stress::Walls { walls, length }) => {
            let between = match length {
                Length::Between(a, b) => vec![a, b],
                Length::Fixed(_) | Length::Membrane(_) => Vec::new(),
            };
            walls.iter().chain(between).collect()
        }
        Of::Stress(Stress::Average { area: over, .. }) => area(over),
        Of::Other(Quantity::Porosity(over)) => area(over),
        Of::Other(Quantity::WallForce { wall, .. }) => vec![wall],
        Of::Strain(_) | Of::Stress(_) | Of::Other(_) => Vec::new(),
    }
}

/// Finds stop conditions on measures that are not defined in their stage, which could never be met.
pub(super) fn never(
    context: &Context,
    path: Arguments,
    (here, stop): (usize, &Stop),
    (present, timeless): (&[bool], bool),
    findings: &mut Findings,
) {
    if !["measures", "stages", "walls"].iter().all(|part| findings.is_sure_of(part)) {
        return;
    }
    let measures = &context.scene.measures;
    let Some(of) = stop.measure().and_then(|name| of(measures, name)) else { return };
    let there = |name: &&&String| {
        let index = context.walls.iter().position(|wall| *wall == name.as_str());
        index.is_none_or(|index| present.get(index) == Some(&true))
    };
    if let Some(wall) = walls(&of).iter().find(|name| !there(name)) {
        let message =
            format!("it can never hold: wall `{wall}`, on which it is measured, is not there");
        findings.add(path, message, "measure on walls of this stage, or leave it out");
    }
    if timeless && matches!(of, Of::Other(Quantity::Time)) && findings.is_sure_of("analysis") {
        let message = "it can never hold: a static stage has no time";
        findings.add(path, message, "use a dynamic analysis");
    }
    let last = context.stages.len().saturating_sub(1);
    let reference = match context.scene.strains_from() {
        Some(name) => context.stages.iter().position(|stage| *stage == name).unwrap_or(0),
        None => context.scene.reference_stage(),
    };
    let counts = match of {
        Of::Strain(_) => true,
        Of::Other(of) => {
            matches!(of, Quantity::VolumetricStrain | Quantity::DilationAngle { .. })
        }
        Of::Stress(_) => false,
    };
    if counts && here < reference {
        let name = context.stages[reference];
        let the_last = if reference == last { ", the last one" } else { "" };
        let message =
            format!("it can never hold: strains count from the start of stage `{name}`{the_last}");
        let field =
            if context.scene.version == 1 { "measures.reference_stage" } else { "reference_stage" };
        let help = format!("set `{field}` to this stage or an earlier one");
        findings.add(path, message, &help);
    }
}
