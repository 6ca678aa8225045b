//! Rigid groups in a stage: each is made once, and controlled while it is there.

use std::fmt::Arguments;

use crate::scene::format::{Analysis, Load, Motion, RigidControl};
use crate::scene::spans::join;
use crate::scene::suggest;

use super::Context;
use super::findings::Findings;
use super::parts::motion;
use super::select::select;

/// Checks the groups of a stage; `there` are those that exist, and afterwards those that remain.
pub(super) fn check(
    context: &Context,
    path: Arguments,
    stage: &Load,
    there: &mut Vec<String>,
    findings: &mut Findings,
) {
    for (i, name) in stage.release.iter().enumerate() {
        let path = format_args!("{path}.release[{i}]");
        is_there(path, name, there, findings);
        there.retain(|other| other != name);
    }
    let timeless = stage.analysis.unwrap_or(context.scene.analysis) == Analysis::Static;
    for (name, control) in &stage.rigid {
        let own = join(&format!("{path}.rigid"), name);
        let own = format_args!("{own}");
        if control.select.is_none() {
            let known: Vec<&str> = there.iter().map(String::as_str).collect();
            if !known.contains(&name.as_str()) && findings.is_sure_of("stages") {
                let help = if known.is_empty() {
                    "give `select` to make it".to_owned()
                } else {
                    let which = suggest::help(name, &known, "rigid groups");
                    format!("give `select` to make it, or: {which}")
                };
                findings.add_at_key(own, format!("no rigid group `{name}`"), &help);
            }
        } else if there.contains(name) {
            if findings.is_sure_of("stages") {
                let message = format!("rigid group `{name}` is there already");
                let help = "leave `select` out, or release it first";
                findings.add(format_args!("{own}.select"), message, help);
            }
        } else {
            there.push(name.clone());
        }
        control_of_group(context, own, control, timeless, findings);
    }
}

fn is_there(path: Arguments, name: &str, there: &[String], findings: &mut Findings) {
    if !there.iter().any(|other| other == name) && findings.is_sure_of("stages") {
        let known: Vec<&str> = there.iter().map(String::as_str).collect();
        let help = suggest::help(name, &known, "rigid groups");
        findings.add(path, format!("no rigid group `{name}`"), &help);
    }
}

fn control_of_group(
    context: &Context,
    path: Arguments,
    control: &RigidControl,
    timeless: bool,
    findings: &mut Findings,
) {
    if let Some(wanted) = &control.select {
        select(context, format_args!("{path}.select"), wanted, findings);
    }
    if let Some(about) = control.about {
        let path = format_args!("{path}.about");
        findings.vector(path, about, "a place in m");
        if control.select.is_none() {
            let help = "give it where the group is made";
            findings.add(path, "the pivot of a group that exists", help);
        }
    }
    for (field, wanted, unit) in control.motions() {
        motion(format_args!("{path}.{field}"), wanted, unit, timeless, findings);
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
