//! Checks that stages and controls share.

use std::fmt::Display;

use crate::scene::format::{Motion, Wall, WallShape};
use crate::scene::suggest;

use super::findings::At;
use super::places::{are_askew, are_opposite, length};

/// Checks a wall that a stage needs. Returns the wall if it exists.
pub(super) fn wall_there<'a>(
    at: &mut At<'_, 'a>,
    field: impl Display,
    name: &str,
) -> Option<&'a Wall> {
    if !at.wall(&field, name) {
        return None;
    }
    if at.is_there(name) == Some(true) {
        return at.context.wall(name);
    }
    if at.are_sure_of(&["stages", "walls"]) {
        let message = format!("wall `{name}` is not there in this stage");
        at.add(field, message, "bring it in with `add_walls`");
    }
    None
}

/// Checks that a wall, if it exists, is straight.
pub(super) fn straight(at: &mut At, field: impl Display, wall: Option<&Wall>, help: &str) {
    if let Some(wall) = wall.filter(|wall| !wall.shape.is_straight()) {
        at.add(field, format!("wall `{}` is not straight", wall.name), help);
    }
}

/// Help where a control needs a wall of one piece.
pub(super) const ONE_PIECE: &str = "name a wall of one piece";

/// Checks a wall that a control or a measure needs as one straight or curved piece. `what` completes
/// "has no one ...".
pub(super) fn one_piece(at: &mut At, field: impl Display, name: &str, (what, help): (&str, &str)) {
    let wall = at.context.wall(name);
    if wall.is_some_and(|wall| matches!(wall.shape, WallShape::Polyline(_))) {
        let message = format!("wall `{name}` is a polyline, which has no one {what}");
        at.add(field, message, help);
    }
}

/// Checks that two walls, if they exist, are parallel, with their insides towards each other. One
/// without a length is an error of its own.
pub(super) fn face(at: &mut At, field: &str, walls: [Option<&Wall>; 2]) {
    if let [Some(a), Some(b)] = walls
        && at.is_sure_of("walls")
        && length(a) > 0.0
        && length(b) > 0.0
        && !are_opposite(a, b)
    {
        let message = format!("wall `{}` does not face wall `{}`", b.name, a.name);
        let help = "the two walls must be parallel, with their insides towards each other";
        at.add(field, message, help);
    }
}

/// Two walls, if they exist and are straight with a length.
pub(super) fn both_straight<'a>(
    at: &At<'_, 'a>,
    (a, b): (&str, &str),
) -> Option<(&'a Wall, &'a Wall)> {
    let find = |name: &str| {
        let wall = at.context.wall(name);
        wall.filter(|wall| wall.shape.is_straight() && length(wall) > 0.0)
    };
    Some((find(a)?, find(b)?))
}

/// Checks that two walls, if they exist, have a distance that is the size of something between them.
pub(super) fn are_apart(at: &mut At, field: &str, (a, b): (&str, &str)) {
    if let Some((first, second)) = both_straight(at, (a, b))
        && at.is_sure_of("walls")
        && are_askew(first, second)
    {
        let message = format!("walls `{a}` and `{b}` do not lie opposite each other");
        at.add(field, message, "name two walls on opposite sides, as left and right");
    }
}

/// Finds a control by time in a stage that has none. `instead` is one by increments.
pub(super) fn needs_time(at: &mut At, field: &str, what: &str, instead: &str) {
    if at.is_timeless() {
        let message = format!("{what} in a static stage, which has no time");
        let help = format!("use `{instead}`, in every increment, or a dynamic analysis");
        at.add(field, message, help);
    }
}

/// Checks the motion along one degree of freedom, whose unit is m or rad.
pub(super) fn motion(at: &mut At, field: &str, motion: Motion, unit: &str) {
    let number = format_args!("{field}[0]");
    match motion {
        Motion::Free | Motion::Held => {}
        Motion::Displacement(value) => {
            at.finite(number, value, &format!("a displacement in {unit}"));
        }
        Motion::Velocity(value) => {
            at.finite(number, value, &format!("a velocity in {unit}/s"));
            needs_time(at, field, "a velocity", "Displacement");
        }
    }
}

/// Checks the load at the end of a stage.
pub(super) fn load(at: &mut At, force: Option<(f64, f64)>, moment: Option<f64>) {
    at.vector("force", force, "a force in N");
    at.finite("moment", moment, "a moment in N m");
}

/// Checks the name of something that is to go and must be there, as `known` are.
pub(super) fn is_known<'n>(
    at: &mut At,
    name: &str,
    known: impl Iterator<Item = &'n str>,
    kind: &str,
) {
    let known: Vec<&str> = known.collect();
    if !known.contains(&name) && at.is_sure_of("stages") {
        let help = suggest::help(name, &known, &format!("{kind}s"));
        at.add("", format!("no {kind} `{name}`"), help);
    }
}
