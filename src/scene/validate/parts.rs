//! Checks that stages and controls share.

use std::fmt::Arguments;

use crate::scene::format::{Motion, Wall};

use super::ASKEW;
use super::findings::Findings;
use super::places::length;

/// Kind of a wall, and the field that lists walls.
pub(super) const WALL: (&str, &str) = ("wall", "walls");

/// Checks a wall that a stage needs. Returns the wall if it exists.
pub(super) fn wall_there<'a>(
    path: Arguments,
    name: &str,
    findings: &mut Findings<'a>,
) -> Option<&'a Wall> {
    let context = findings.context;
    if !findings.reference(path, name, WALL, &context.walls) {
        return None;
    }
    if findings.is_there(name) == Some(true) {
        return context.wall(name);
    }
    if findings.are_sure_of(&["stages", "walls"]) {
        let message = format!("wall `{name}` is not there in this stage");
        findings.add(path, message, "bring it in with `add_walls`");
    }
    None
}

/// Checks that a wall, if it exists, is straight.
pub(super) fn straight(path: Arguments, wall: Option<&Wall>, help: &str, findings: &mut Findings) {
    if let Some(wall) = wall.filter(|wall| !wall.shape.is_straight()) {
        findings.add(path, format!("wall `{}` is not straight", wall.name), help);
    }
}

/// Checks that two walls, if they exist, are parallel, with their insides towards each other. One
/// without a length is an error of its own.
pub(super) fn face(path: Arguments, walls: [Option<&Wall>; 2], findings: &mut Findings) {
    let [Some(a), Some(b)] = walls else { return };
    let along = |wall: &Wall| (wall.end.0 - wall.start.0, wall.end.1 - wall.start.1);
    let (t, u) = (along(a), along(b));
    let lengths = length(a) * length(b);
    if lengths > 0.0 && (t.0 * u.0 + t.1 * u.1) / lengths > ASKEW - 1.0 {
        let message = format!("wall `{}` does not face wall `{}`", b.name, a.name);
        let help = "the two walls must be parallel, with their insides towards each other";
        findings.add(path, message, help);
    }
}

/// Finds a control by time in a stage that has none.
pub(super) fn needs_time(path: Arguments, what: &str, findings: &mut Findings) {
    if findings.is_timeless() && findings.is_sure_of("analysis") {
        let help = "use `Displacement`, in every increment, or a dynamic analysis";
        findings.add(path, format!("{what} in a static stage, which has no time"), help);
    }
}

/// Checks the motion along one degree of freedom, whose unit is m or rad.
pub(super) fn motion(path: Arguments, motion: Motion, unit: &str, findings: &mut Findings) {
    match motion {
        Motion::Free | Motion::Held => {}
        Motion::Displacement(value) => {
            let what = format!("a displacement in {unit}");
            findings.finite(format_args!("{path}[0]"), value, &what);
        }
        Motion::Velocity(value) => {
            findings.finite(format_args!("{path}[0]"), value, &format!("a velocity in {unit}/s"));
            needs_time(path, "a velocity", findings);
        }
    }
}
