//! Checks that stages and controls share.

use std::fmt::Arguments;

use crate::scene::format::{Motion, Wall};

use super::Context;
use super::findings::Findings;

/// Kind of a wall, and the field that lists walls.
pub(super) const WALL: (&str, &str) = ("wall", "walls");

/// Checks a wall that a stage needs. Returns the wall if it exists.
pub(super) fn wall_there<'a>(
    context: &Context<'a>,
    path: Arguments,
    name: &str,
    present: &[bool],
    findings: &mut Findings,
) -> Option<&'a Wall> {
    if !findings.reference(path, name, WALL, &context.walls) {
        return None;
    }
    let index = context.walls.iter().position(|wall| *wall == name)?;
    if present.get(index) == Some(&true) {
        return context.scene.walls.get(index);
    }
    if findings.is_sure_of("stages") && findings.is_sure_of("walls") {
        let message = format!("wall `{name}` is not there in this stage");
        findings.add(path, message, "bring it in with `add_walls`");
    }
    None
}

/// Finds a control by time in a stage that has none.
pub(super) fn no_time(path: Arguments, what: &str, findings: &mut Findings) {
    if findings.is_sure_of("analysis") {
        let help = "use `Displacement`, in every increment, or a dynamic analysis";
        findings.add(path, format!("{what} in a static stage, which has no time"), help);
    }
}

/// Checks the motion along one degree of freedom, whose unit is m or rad.
pub(super) fn motion(
    path: Arguments,
    motion: Motion,
    unit: &str,
    timeless: bool,
    findings: &mut Findings,
) {
    match motion {
        Motion::Free | Motion::Held => {}
        Motion::Displacement(value) => {
            let what = format!("a displacement in {unit}");
            findings.finite(format_args!("{path}[0]"), value, &what);
        }
        Motion::Velocity(value) => {
            findings.finite(format_args!("{path}[0]"), value, &format!("a velocity in {unit}/s"));
            if timeless {
                no_time(path, "a velocity", findings);
            }
        }
    }
}
