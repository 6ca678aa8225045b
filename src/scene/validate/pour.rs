//! Stages that pour grains in.

use std::fmt::Arguments;

use clastic_components::domain;

use crate::scene::format::{Load, Opening, Pour, Rate, Stop, Stream};
use crate::scene::spans::join;

use super::findings::Findings;
use super::places::is_behind;
use super::references::material_of;
use super::sizes::check_sizes;

/// Checks what a stage has beside a loading stage.
pub(super) fn check(path: Arguments, stage: &Pour, findings: &mut Findings) {
    let context = findings.context;
    let Stream { through, rate, minerals, velocity, group, .. } = &stage.stream;
    let sure = findings.is_sure_of("analysis")
        && findings.is_sure_of_part(format_args!("{path}.analysis"));
    if findings.is_timeless() && sure {
        let help = "give `analysis: Dynamic(dt: ...)` to the stage";
        findings.add(path, "a static stage that pours: it has no time", help);
    }
    let of = format_args!("{path}.rate[0]");
    match *rate {
        Rate::Number(rate) => findings.positive(of, rate, "a number per second"),
        Rate::Mass(rate) => findings.positive(of, rate, "a mass per second in kg/s"),
        Rate::MassOverStage(mass) => findings.positive(of, mass, "a mass in kg"),
        Rate::NumberOverStage(number) => {
            findings.at_least_one(of, number, "a number");
            true
        }
    };
    findings.vector(format_args!("{path}.velocity"), *velocity, domain::VELOCITY.what);
    let limits = check_sizes(format_args!("{path}.sizes"), &stage.stream.sizes, findings);
    let all: f64 = minerals.values().sum();
    if minerals.is_empty() || all < 1.0 {
        material_of(path, stage.stream.material.as_deref(), findings);
    }
    for (name, share) in minerals {
        let path = join(&format!("{path}.minerals"), name);
        let path = format_args!("{path}");
        findings.reference(path, name, ("material", "materials"), &context.materials);
        let allowed = |share| share > 0.0 && share <= 1.0;
        findings.number(path, *share, allowed, "a share of the grains above 0 and up to 1");
    }
    if all > 1.0 + 1e-12 && findings.is_sound(&format!("{path}.minerals")) {
        let message = format!("shares of more than 1 together ({all:?})");
        findings.add(format_args!("{path}.minerals"), message, "give shares of all grains");
    }
    let of = format_args!("{path}.group");
    if group.as_ref().is_some_and(|group| group.trim().is_empty()) {
        findings.add(of, "empty name of a group", "give a name");
    }
    if let Some(group) = group.as_ref().filter(|group| context.scene.groups.contains_key(*group)) {
        let message = format!("the scene has a group `{group}` too");
        findings.add(of, message, "give it another name");
    }
    opening(format_args!("{path}.through"), (*through, limits), findings);
}

fn opening(
    path: Arguments,
    (through, limits): (Opening, Option<(f64, f64)>),
    findings: &mut Findings,
) {
    let (corners, sides) = match through {
        Opening::Segment { start, end } => {
            let fine = findings.vector(format_args!("{path}.start"), start, domain::PLACE.what)
                & findings.vector(format_args!("{path}.end"), end, domain::PLACE.what);
            let length = (end.0 - start.0).hypot(end.1 - start.1);
            (fine.then(|| vec![start, end]), length)
        }
        Opening::Box { min, max } => {
            let fine = findings.rectangle(path, min, max);
            let corners = vec![min, (max.0, min.1), max, (min.0, max.1)];
            (fine.then_some(corners), (max.0 - min.0).min(max.1 - min.1))
        }
    };
    let (Some(corners), Some((_, maximum))) = (corners, limits) else { return };
    // Round-off of a width that is written as twice a radius.
    if sides < 2.0 * maximum * (1.0 - 1e-9) {
        let message = format!("an opening of {sides:?} m, too narrow for the largest grain");
        let help = format!("give a length, width and height of {:?} m or more", 2.0 * maximum);
        findings.add(path, message, &help);
        return;
    }
    if !findings.are_sure_of(&["walls", "stages"]) {
        return;
    }
    let walls =
        findings.context.scene.walls.iter().zip(&findings.present).filter(|(_, there)| **there);
    let behind = |corner: &&(f64, f64)| {
        let mut walls = walls.clone();
        walls.find(|(wall, _)| is_behind(wall, **corner, maximum)).map(|(wall, _)| wall)
    };
    if let Some((corner, wall)) = corners.iter().find_map(|c| Some((*c, behind(&c)?))) {
        let message = format!("it reaches behind wall `{}` {corner:?}", wall.name);
        let help = "move it inside; a wall has its inside on the left of start to end";
        findings.add(path, message, help);
    }
}

/// Finds stops for a full opening where nothing is poured.
pub(super) fn none_is_full(path: Arguments, stage: &Load, findings: &mut Findings) {
    for (k, stop) in stage.stop.iter().enumerate() {
        if matches!(stop, Stop::Full(_)) {
            let message = "it can never hold: this stage pours nothing";
            let help = "leave it out, or make the stage a `Pour`";
            findings.add(format_args!("{path}.stop[{k}]"), message, help);
        }
    }
}
