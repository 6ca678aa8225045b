//! Rigid groups in a stage: each is made once, and controlled while it is there.

use std::fmt::Arguments;

use clastic_components::domain;

use crate::scene::format::{Load, Motion, RigidControl};
use crate::scene::spans::join;
use crate::scene::suggest;

use super::findings::Findings;
use super::parts::{motion, wall_there};
use super::select::select;

/// A group that exists, with those of its walls that the scene names.
pub(super) struct There {
    name: String,
    walls: Vec<String>,
}

/// The groups of the state from which the scene starts. The run knows their members.
pub(super) fn at_start(names: &[String]) -> Vec<There> {
    names.iter().map(|name| There { name: name.clone(), walls: Vec::new() }).collect()
}

/// Checks the groups of a stage; `there` are those that exist, and afterwards those that remain.
pub(super) fn check(
    path: Arguments,
    stage: &Load,
    there: &mut Vec<There>,
    findings: &mut Findings,
) {
    for (i, name) in stage.release.iter().enumerate() {
        let path = format_args!("{path}.release[{i}]");
        is_there(path, name, there, findings);
        there.retain(|other| other.name != *name);
    }
    for (i, name) in stage.remove_walls.iter().enumerate() {
        of_a_group(format_args!("{path}.remove_walls[{i}]"), name, there, findings);
    }
    for (name, control) in &stage.rigid {
        let own = join(&format!("{path}.rigid"), name);
        let own = format_args!("{own}");
        for (i, wall) in control.walls.iter().enumerate() {
            let path = format_args!("{own}.walls[{i}]");
            wall_there(path, wall, findings);
            of_a_group(path, wall, there, findings);
        }
        if !control.makes() {
            let known: Vec<&str> = there.iter().map(|group| group.name.as_str()).collect();
            if !known.contains(&name.as_str()) && findings.is_sure_of("stages") {
                let help = if known.is_empty() {
                    "give `select` or `walls` to make it".to_owned()
                } else {
                    let which = suggest::help(name, &known, "rigid groups");
                    format!("give `select` or `walls` to make it, or: {which}")
                };
                findings.add_at_key(own, format!("no rigid group `{name}`"), &help);
            }
        } else if there.iter().any(|group| group.name == *name) {
            if findings.is_sure_of("stages") {
                let message = format!("rigid group `{name}` is there already");
                let field = if control.select.is_some() { "select" } else { "walls" };
                let help = "leave `select` and `walls` out, or release it first";
                findings.add(format_args!("{own}.{field}"), message, help);
            }
        } else {
            there.push(There { name: name.clone(), walls: control.walls.clone() });
        }
        control_of_group(own, control, findings);
    }
    for name in stage.walls.keys() {
        let path = join(&format!("{path}.walls"), name);
        of_a_group(format_args!("{path}"), name, there, findings);
    }
}

/// Finds a wall that is a member of a group and that the stage controls otherwise.
fn of_a_group(path: Arguments, wall: &str, there: &[There], findings: &mut Findings) {
    let of = there.iter().find(|group| group.walls.iter().any(|member| member == wall));
    if let Some(group) = of.filter(|_| findings.is_sure_of("stages")) {
        let message = format!("wall `{wall}` is a member of the rigid group `{}`", group.name);
        let help = format!("control the group, or end it with `release: [{:?}]`", group.name);
        findings.add(path, message, &help);
    }
}

fn is_there(path: Arguments, name: &str, there: &[There], findings: &mut Findings) {
    if !there.iter().any(|other| other.name == name) && findings.is_sure_of("stages") {
        let known: Vec<&str> = there.iter().map(|group| group.name.as_str()).collect();
        let help = suggest::help(name, &known, "rigid groups");
        findings.add(path, format!("no rigid group `{name}`"), &help);
    }
}

fn control_of_group(path: Arguments, control: &RigidControl, findings: &mut Findings) {
    if let Some(wanted) = &control.select {
        select(format_args!("{path}.select"), wanted, findings);
    }
    if let Some(about) = control.about {
        let path = format_args!("{path}.about");
        findings.vector(path, about, domain::PLACE.what);
        if !control.makes() {
            let help = "give it where the group is made";
            findings.add(path, "the pivot of a group that exists", help);
        }
    }
    if control.about.is_none() && !control.walls.is_empty() {
        let help = "give `about: (x, y)`: walls have no mass, so that they have no centre of mass";
        findings.add(format_args!("{path}.walls"), "a group with walls and without a pivot", help);
    }
    for (field, wanted, unit) in control.motions() {
        motion(format_args!("{path}.{field}"), wanted, unit, findings);
    }
    if let Some(force) = control.force {
        findings.vector(format_args!("{path}.force"), force, "a force in N");
    }
    if let Some(moment) = control.moment {
        findings.finite(format_args!("{path}.moment"), moment, "a moment in N m");
    }
    if let Some(stress) = control.stress {
        findings.vector(format_args!("{path}.stress.value"), stress.value, "a stress in Pa");
        findings.positive(format_args!("{path}.stress.length"), stress.length, "a length in m");
    }
    let (x, y) = control.total_force(1.0).unwrap_or_default();
    let moment = control.moment.unwrap_or_default();
    for ((field, wanted, _), load) in control.motions().into_iter().zip([x, y, moment]) {
        if wanted != Motion::Free && load != 0.0 {
            let message = format!("{field} is held or driven, and loaded too");
            let help = "a load has no effect there: leave it out, or leave the motion free";
            findings.add(format_args!("{path}.{field}"), message, help);
        }
    }
}
