//! Stop conditions of a stage.

use crate::scene::format::{Area, Length, Quantity, Stage, Stop, Strain, Stress};

use super::findings::At;

/// Checks a stop condition, and that its measure is defined in the stage.
pub(super) fn check(at: &mut At, stop: &Stop) {
    let scene = at.context.scene;
    match stop {
        Stop::StressDrop(fraction) => {
            let allowed = |value| value > 0.0 && value < 1.0;
            at.number("[0]", *fraction, allowed, "a fraction between 0 and 1");
            if scene.measure("axial_stress").is_none() && at.is_sure_of("measures") {
                at.add("", "no axial stress is measured", "add `axial_stress` to `measures`");
            }
        }
        Stop::Full(time) => {
            at.positive("[0]", *time, "a time in s");
            let message = "it can never hold: this stage pours nothing";
            let help = "leave it out, or make the stage a `Pour`";
            at.refuse(!scene.stages[at.stage].pours(), "", message, help);
        }
        Stop::Rest(speed) => {
            at.positive("[0]", *speed, "a speed in m/s");
            let message = "a stop by speed in a static stage, which has no time";
            at.refuse(at.is_timeless(), "", message, "use a dynamic analysis");
        }
        Stop::Below(name, value) | Stop::Above(name, value) | Stop::Until(name, value) => {
            at.reference("[0]", name, ("measure", "measures"), &at.context.measures);
            if let Some(Quantity::Strain(_)) = scene.measure(name) {
                let allowed = |value: f64| value.abs() < 1.0;
                at.number("[1]", *value, allowed, "a strain as a fraction: 0.12 is 12 %");
            } else {
                at.finite("[1]", *value, "a finite value");
            }
        }
    }
    never(at, stop);
}

/// Walls on which a measure is taken.
fn walls(of: &Quantity) -> Vec<&String> {
    match of {
        Quantity::Strain(Strain::Walls(a, b)) => vec![a, b],
        Quantity::Stress(Stress::Walls { walls, length: Length::Between(a, b) }) => {
            walls.iter().chain([a, b]).collect()
        }
        Quantity::Stress(Stress::Walls { walls, .. }) => walls.iter().collect(),
        Quantity::Stress(Stress::Average { area: Area::Box((a, b), (c, d)), .. })
        | Quantity::Porosity(Area::Box((a, b), (c, d))) => vec![a, b, c, d],
        Quantity::WallForce { wall, .. } => vec![wall],
        _ => Vec::new(),
    }
}

/// Finds a stop condition on a measure that is not defined in its stage, which could never be met.
fn never(at: &mut At, stop: &Stop) {
    let context = at.context;
    if !at.are_sure_of(&["measures", "stages", "walls"]) {
        return;
    }
    let scene = context.scene;
    let Some(of) = stop.measure().and_then(|name| scene.measure(name)) else { return };
    if let Some(wall) = walls(of).iter().find(|name| at.is_there(name) == Some(false)) {
        let message =
            format!("it can never hold: wall `{wall}`, on which it is measured, is not there");
        at.add("", message, "measure on walls of this stage, or leave it out");
    }
    let message = "it can never hold: a static stage has no time";
    let help = "use a dynamic analysis";
    at.refuse(at.is_timeless() && matches!(of, Quantity::Time), "", message, help);
    let is_compaction = matches!(scene.stages[at.stage], Stage::Compact(_));
    let needs_forces = matches!(
        of,
        Quantity::Stress(_)
            | Quantity::GroupForce { .. }
            | Quantity::WallForce { .. }
            | Quantity::Coordination { .. }
            | Quantity::Fabric { .. }
            | Quantity::ElasticEnergy
            | Quantity::KineticOverElastic
    );
    let message = "it can never hold: a compaction has no forces";
    let help = "stop at a porosity, or compact to `Jammed` and load the packing in a next stage";
    at.refuse(is_compaction && needs_forces, "", message, help);
    let last = context.stages.len().saturating_sub(1);
    let reference = match &scene.reference_stage {
        Some(name) => context.stages.iter().position(|stage| *stage == name).unwrap_or(0),
        None => scene.reference_stage(),
    };
    let counts = match of {
        Quantity::Strain(_)
        | Quantity::VolumetricStrain
        | Quantity::DilationAngle { .. }
        | Quantity::Ring { .. } => true,
        Quantity::Grains { moved, .. } => *moved > 0.0,
        _ => false,
    };
    let name = context.stages[reference];
    let the_last = if reference == last { ", the last one" } else { "" };
    let message =
        format!("it can never hold: strains count from the start of stage `{name}`{the_last}");
    let help = "set `reference_stage` to this stage or an earlier one";
    at.refuse(counts && at.stage < reference, "", message, help);
}
