//! Stages that pour grains in.

use clastic_components::domain;

use crate::scene::format::{Opening, Pour, Rate, Stream};

use super::findings::At;
use super::parts::material_of;
use super::places::is_behind;
use super::select::name_of_group;
use super::sizes::check_sizes;

/// Checks what a stage has beside a loading stage.
pub(super) fn check(at: &mut At, stage: &Pour) {
    let Stream { through, rate, minerals, velocity, group, .. } = &stage.stream;
    let help = "give `analysis: Dynamic(dt: ...)` to the stage";
    at.refuse(at.is_timeless(), "", "a static stage that pours: it has no time", help);
    match *rate {
        Rate::Number(rate) => at.positive("rate[0]", rate, "a number per second"),
        Rate::Mass(rate) => at.positive("rate[0]", rate, "a mass per second in kg/s"),
        Rate::MassOverStage(mass) => at.positive("rate[0]", mass, "a mass in kg"),
        Rate::NumberOverStage(number) => at.at_least_one("rate[0]", number, "a number"),
    };
    at.vector("velocity", *velocity, domain::VELOCITY.what);
    let limits = check_sizes(&mut at.field("sizes"), &stage.stream.sizes);
    let all: f64 = minerals.values().sum();
    if minerals.is_empty() || all < 1.0 {
        material_of(at, stage.stream.material.as_deref());
    }
    for (name, share) in minerals {
        let at = &mut at.entry("minerals", name);
        at.material("", name);
        let allowed = |share| share > 0.0 && share <= 1.0;
        at.number("", *share, allowed, "a share of the grains above 0 and up to 1");
    }
    let message = format!("shares of more than 1 together ({all:?})");
    let help = "give shares of all grains";
    at.refuse(
        all > 1.0 + 1e-12 && at.are_sound(&[&at.path("minerals")]),
        "minerals",
        message,
        help,
    );
    name_of_group(at, group.as_deref());
    let groups = &at.context.scene.groups;
    if let Some(group) = group.as_ref().filter(|group| groups.contains_key(*group)) {
        let message = format!("the scene has a group `{group}` too");
        at.add("group", message, "give it another name");
    }
    opening(&mut at.field("through"), *through, limits);
}

fn opening(at: &mut At, through: Opening, limits: Option<(f64, f64)>) {
    let (fine, corners, sides) = match through {
        Opening::Segment { start, end } => {
            let fine = at.place("start", start) & at.place("end", end);
            (fine, vec![start, end], (end.0 - start.0).hypot(end.1 - start.1))
        }
        Opening::Box { min, max } => {
            let corners = vec![min, (max.0, min.1), max, (min.0, max.1)];
            (at.rectangle(min, max), corners, (max.0 - min.0).min(max.1 - min.1))
        }
    };
    let Some((_, maximum)) = limits.filter(|_| fine) else { return };
    // Round-off of a width that is written as twice a radius.
    if sides < 2.0 * maximum * (1.0 - 1e-9) {
        let message = format!("an opening of {sides:?} m, too narrow for the largest grain");
        let help = format!("give a length, width and height of {:?} m or more", 2.0 * maximum);
        at.add("", message, help);
        return;
    }
    if !at.are_sure_of(&["walls", "stages"]) {
        return;
    }
    let walls = at.context.scene.walls.iter().zip(&at.present).filter(|(_, there)| **there);
    let behind = corners.iter().find_map(|corner| {
        let mut walls = walls.clone();
        Some((corner, walls.find(|(wall, _)| is_behind(wall, *corner, maximum))?.0))
    });
    if let Some((corner, wall)) = behind {
        let message = format!("it reaches behind wall `{}` {corner:?}", wall.name);
        let help = "move it inside; a wall has its inside on the left of start to end";
        at.add("", message, help);
    }
}
