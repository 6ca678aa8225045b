//! Rigid groups in a stage: each is made once, and controlled while it is there.

use std::f64::consts::PI;

use crate::scene::format::{Analysis, Load, Motion, RigidControl};
use crate::text::suggest;

use super::findings::At;
use super::parts::{is_known, load, motion, wall_there};
use super::select::select;

/// A group that exists, with those of its walls that the scene names: none of a group of the state
/// from which the scene starts, whose members the run knows.
pub(super) struct There<'a> {
    pub(super) name: &'a str,
    pub(super) walls: &'a [String],
}

/// Checks the groups of a stage; `there` are those that exist, and afterwards those that remain.
pub(super) fn check<'a>(at: &mut At, stage: &'a Load, there: &mut Vec<There<'a>>) {
    for (i, name) in stage.release.iter().enumerate() {
        let known = there.iter().map(|group| group.name);
        is_known(&mut at.item("release", i), name, known, "rigid group");
        there.retain(|other| other.name != name);
    }
    for (i, name) in stage.remove_walls.iter().enumerate() {
        of_a_group(&mut at.item("remove_walls", i), name, there);
    }
    for (name, control) in &stage.rigid {
        let at = &mut at.entry("rigid", name);
        for (i, wall) in control.walls.iter().enumerate() {
            let at = &mut at.item("walls", i);
            wall_there(at, "", wall);
            of_a_group(at, wall, there);
        }
        let is_there = there.iter().any(|group| group.name == name);
        if control.makes() && is_there && at.is_sure_of("stages") {
            let message = format!("rigid group `{name}` is there already");
            let field = if control.select.is_some() { "select" } else { "walls" };
            at.add(field, message, "leave `select` and `walls` out, or release it first");
        } else if !control.makes() && !is_there && at.is_sure_of("stages") {
            let known: Vec<&str> = there.iter().map(|group| group.name).collect();
            let mut help = "give `select` or `walls` to make it".to_owned();
            if !known.is_empty() {
                help += &format!(", or: {}", suggest::help(name, &known, "rigid groups"));
            }
            at.add_at_key(format!("no rigid group `{name}`"), help);
        }
        if control.makes() && !is_there {
            there.push(There { name, walls: &control.walls });
        }
        control_of_group(at, control);
    }
    for name in stage.walls.keys() {
        of_a_group(&mut at.entry("walls", name), name, there);
    }
}

/// Finds a wall that is a member of a group and that the stage controls otherwise.
fn of_a_group(at: &mut At, wall: &str, there: &[There]) {
    let of = there.iter().find(|group| group.walls.iter().any(|member| member == wall));
    if let Some(group) = of.filter(|_| at.is_sure_of("stages")) {
        let message = format!("wall `{wall}` is a member of the rigid group `{}`", group.name);
        let help = format!("control the group, or end it with `release: [{:?}]`", group.name);
        at.add("", message, help);
    }
}

fn control_of_group(at: &mut At, control: &RigidControl) {
    if let Some(wanted) = &control.select {
        select(&mut at.field("select"), wanted);
    }
    at.place("about", control.about);
    let is_sure = at.is_sure("walls") && at.is_sure("select");
    if control.about.is_some() && !control.makes() && is_sure {
        at.add("about", "the pivot of a group that exists", "give it where the group is made");
    }
    let help = "give `about: (x, y)`: walls have no mass, so that they have no centre of mass";
    let what = "a group with walls and without a pivot";
    at.refuse(control.about.is_none() && !control.walls.is_empty(), "walls", what, help);
    for (field, wanted, unit) in control.motions() {
        motion(at, field, wanted, unit);
    }
    let turn = match (control.rotation, at.analysis) {
        (Motion::Displacement(angle), _) => angle,
        (Motion::Velocity(rate), Analysis::Dynamic { dt, .. }) => rate * dt,
        _ => 0.0,
    };
    let message = format!("a turn of {turn:?} rad in an increment");
    // Members follow by finite rotations: beyond half a turn they end where a turn the other way ends.
    let help = "give a smaller one, or a smaller dt: at most half a turn (pi) in an increment";
    at.refuse(turn.abs() > PI, "rotation[0]", message, help);
    load(at, control.force, control.moment);
    at.vector("stress.value", control.stress.map(|stress| stress.value), "a stress in Pa");
    at.positive("stress.length", control.stress.map(|stress| stress.length), "a length in m");
    let (x, y) = control.total_force(1.0).unwrap_or_default();
    let moment = control.moment.unwrap_or_default();
    for ((field, wanted, _), load) in control.motions().into_iter().zip([x, y, moment]) {
        let message = format!("{field} is held or driven, and loaded too");
        let help = "a load has no effect there: leave it out, or leave the motion free";
        at.refuse(wanted != Motion::Free && load != 0.0, field, message, help);
    }
}
