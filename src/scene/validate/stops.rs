//! Stop conditions of a stage.

use crate::run::disks::ends;
use crate::scene::format::{
    Amount, Area, Fragments, Length, Quantity, ROLES, Scene, Stage, Stop, Strain, Stress,
};

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
fn walls<'a>(scene: &'a Scene, of: &'a Quantity) -> Vec<&'a String> {
    match of {
        Quantity::VolumetricStrain | Quantity::DilationAngle { .. } => {
            let strains = ROLES.iter().filter_map(|role| scene.strain(role));
            let pairs = strains.filter_map(|of| match of {
                Strain::Walls(a, b) => Some([a, b]),
                _ => None,
            });
            pairs.flatten().collect()
        }
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

/// Minimum and maximum of a measure in the stage that is checked.
fn range(at: &At, of: &Quantity) -> (f64, f64) {
    let far = f64::INFINITY;
    let scene = at.context.scene;
    let adds = |stage: &Stage| stage.pours() || matches!(stage, Stage::Custom(_));
    let particles = at.context.particles.filter(|_| !scene.stages.iter().any(adds));
    let particles = particles.map_or(far, |count| count as f64);
    // Linear between points, and constant after the last.
    let scaled = |value: f64, points: &Option<Vec<(f64, f64)>>| {
        let factors = points.iter().flatten().map(|(_, factor)| factor.abs() * value);
        ends(factors.map(|factor| (factor, 0.0))).unwrap_or((value, value))
    };
    let load = scene.stages[at.stage].load();
    match of {
        Quantity::Porosity(_) => (-far, 1.0),
        Quantity::Broken(_) | Quantity::BrokenShare(_) | Quantity::Cracks { .. }
            if !scene.has_bonds(at.stage) =>
        {
            (0.0, 0.0)
        }
        Quantity::BrokenShare(_)
        | Quantity::Fragments(Fragments::LargestShare)
        | Quantity::Grains { amount: Amount::Share, .. } => (0.0, 1.0),
        Quantity::Fragments(_) | Quantity::Grains { amount: Amount::Number, .. } => {
            (0.0, particles)
        }
        Quantity::Gravity => load.map_or((0.0, far), |load| {
            let (x, y) = load.gravity.unwrap_or(scene.gravity);
            scaled(x.hypot(y), &load.scale.gravity)
        }),
        Quantity::StrengthFactor => {
            load.map_or((0.0, far), |load| scaled(1.0, &load.scale.strength))
        }
        _ => (-far, far),
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
    if let Some(wall) = walls(scene, of).iter().find(|name| at.is_there(name) == Some(false)) {
        let message =
            format!("it can never hold: wall `{wall}`, on which it is measured, is not there");
        at.add("", message, "measure on walls of this stage, or leave it out");
    }
    let message = "it can never hold: a static stage has no time";
    let help = "use a dynamic analysis";
    at.refuse(at.is_timeless() && matches!(of, Quantity::Time), "", message, help);
    let (low, high) = range(at, of);
    let unmet = match *stop {
        Stop::Above(_, value) | Stop::Until(_, value) if value > high => Some(("most", high)),
        Stop::Below(_, value) | Stop::Until(_, value) if value < low => Some(("least", low)),
        _ => None,
    };
    if let Some((least, bound)) = unmet {
        let message =
            format!("it can never hold: the measure is at {least} {bound:?} in this stage");
        at.add("[1]", message, "give a value that it comes to; 12 % is 0.12");
    }
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
