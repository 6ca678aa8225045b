//! Controls of walls in a stage.

use std::fmt::Arguments;

use clastic_components::domain;

use crate::scene::format::{Analysis, LidLoad, Slide, Table, WallControl};
use crate::scene::suggest;

use super::findings::Findings;
use super::parts::{needs_time, straight, wall_there};
use super::thin_walls::{ONE_PIECE, one_piece};

/// Maximum rotation of a wall in an increment, rad. Gaps are those of the rotation to first order
/// for a disk that moves with the wall, whose error is that share squared of its motion.
const MAX_TURN: f64 = 0.2;

/// Checks the control of a wall in a stage, which may have no time.
pub(super) fn control_of_wall(
    path: Arguments,
    (name, control): (&str, &WallControl),
    increments: u32,
    findings: &mut Findings,
) {
    let dt = if let Analysis::Dynamic { dt, .. } = findings.analysis { Some(dt) } else { None };
    if findings.context.walls.contains(&name) {
        wall_there(path, name, findings);
    } else if findings.is_sure_of("walls") {
        let help = suggest::help(name, &findings.context.walls, "walls");
        findings.add_at_key(path, format!("unknown wall (`{name}`)"), &help);
    }
    match control {
        WallControl::Fixed | WallControl::Custom => {}
        WallControl::Displacement(x, y) => {
            findings.vector(path, (*x, *y), "a displacement in m");
        }
        WallControl::Velocity(x, y) => {
            findings.vector(path, (*x, *y), domain::VELOCITY.what);
            needs_time(path, "a velocity", findings);
        }
        WallControl::Rotation { about, angle } => {
            findings.vector(format_args!("{path}.about"), *about, domain::PLACE.what);
            let what = "an angle of one increment in rad, at most 0.2 (11 degrees)";
            let allowed = |angle: f64| angle.abs() <= MAX_TURN;
            findings.number(format_args!("{path}.angle"), *angle, allowed, what);
        }
        WallControl::Spin { about, angular_velocity } => {
            findings.vector(format_args!("{path}.about"), *about, domain::PLACE.what);
            let own = format_args!("{path}.angular_velocity");
            findings.finite(own, *angular_velocity, "an angular velocity in rad/s");
            if let Some(dt) = dt.filter(|dt| (angular_velocity * dt).abs() > MAX_TURN) {
                let message = format!("a turn of {:?} rad in a time step", angular_velocity * dt);
                let help = "give a smaller one, or a smaller dt: at most 0.2 rad in a time step";
                findings.add(own, message, help);
            }
            if findings.is_timeless() && findings.is_sure_of("analysis") {
                let message = "an angular velocity in a static stage, which has no time";
                let help = "use `Rotation`, in every increment, or a dynamic analysis";
                findings.add(path, message, help);
            }
        }
        WallControl::Force(force) => {
            one_piece(path, name, ("normal", ONE_PIECE), findings);
            findings.finite(format_args!("{path}[0]"), *force, "a force in N");
        }
        WallControl::Stress { stress, between } => {
            one_piece(path, name, ("normal", ONE_PIECE), findings);
            findings.finite(format_args!("{path}.stress"), *stress, "a stress in Pa");
            loaded_between(path, (name, between), findings);
        }
        WallControl::Lid { load, slide } => {
            lid(path, (name, load, *slide), findings);
        }
        WallControl::Follow(table) => {
            follow(path, (name, table), findings);
            if let Table::Rotation { about, angle } = table {
                findings.vector(format_args!("{path}.about"), *about, domain::PLACE.what);
                // Part of the table that an increment takes.
                let step = dt.unwrap_or(1.0 / f64::from(increments.max(1)));
                turns(format_args!("{path}.angle"), angle, step, findings);
            }
        }
    }
}

/// Checks that no increment, which takes `step` of a table of angles, turns a wall too far.
fn turns(path: Arguments, angle: &[(f64, f64)], step: f64, findings: &mut Findings) {
    for (k, pair) in angle.windows(2).enumerate() {
        let [(s, a), (t, b)] = [pair[0], pair[1]];
        // Of an interval an increment takes its step or the whole of it.
        let turn = (b - a).abs() * (step / (t - s)).min(1.0);
        if t > s && turn > MAX_TURN {
            let message = format!("a turn of {turn:?} rad in an increment");
            let help = "give more increments, or a smaller dt: at most 0.2 rad in an increment";
            findings.add(format_args!("{path}[{}][1]", k + 1), message, help);
        }
    }
}

/// Checks the two walls that bound the loaded length of a stress.
fn loaded_between(
    path: Arguments,
    (name, between): (&str, &Option<(String, String)>),
    findings: &mut Findings,
) {
    let Some((a, b)) = between else { return };
    for (i, other) in [a, b].into_iter().enumerate() {
        let path = format_args!("{path}.between[{i}]");
        wall_there(path, other, findings);
        one_piece(path, other, ("place and normal", ONE_PIECE), findings);
        if other == name {
            let help = "name the two walls that bound its loaded length";
            findings.add(path, format!("the wall itself (`{name}`)"), help);
        }
    }
    findings.pair(format_args!("{path}.between"), (a, b), "wall");
}

fn lid(path: Arguments, (name, load, slide): (&str, &LidLoad, Slide), findings: &mut Findings) {
    let help = "a lid is a straight wall: it slides along itself";
    straight(path, findings.context.wall(name), help, findings);
    match load {
        LidLoad::Force(force) => {
            findings.finite(format_args!("{path}.load[0]"), *force, "a force in N");
        }
        LidLoad::Stress { stress, between } => {
            let path = format_args!("{path}.load");
            findings.finite(format_args!("{path}.stress"), *stress, "a stress in Pa");
            loaded_between(path, (name, between), findings);
        }
    }
    let path = format_args!("{path}.slide[0]");
    match slide {
        Slide::Displacement(u) => {
            findings.finite(path, u, "a displacement in m");
        }
        Slide::Velocity(v) => {
            findings.finite(path, v, domain::VELOCITY.what);
            needs_time(path, "a velocity", findings);
        }
    }
}

fn follow(path: Arguments, (name, table): (&str, &Table), findings: &mut Findings) {
    let (points, path, what): (Vec<_>, _, _) = match table {
        Table::Displacement(list) => {
            let points = list.iter().map(|(s, x, y)| (*s, vec![*x, *y])).collect();
            (points, path.to_string(), "a displacement in m")
        }
        Table::Force(list) => {
            let points = list.iter().map(|(s, f)| (*s, vec![*f])).collect();
            (points, path.to_string(), "a force in N")
        }
        Table::Rotation { angle, .. } => {
            let points = angle.iter().map(|(s, a)| (*s, vec![*a])).collect();
            (points, format!("{path}.angle"), "an angle in rad")
        }
        Table::Stress { stress, between } => {
            loaded_between(path, (name, between), findings);
            let points = stress.iter().map(|(s, p)| (*s, vec![*p])).collect();
            (points, format!("{path}.stress"), "a stress in Pa")
        }
    };
    if !matches!(table, Table::Displacement(_) | Table::Rotation { .. }) {
        one_piece(format_args!("{path}"), name, ("normal", ONE_PIECE), findings);
    }
    points_of(format_args!("{path}"), &points, what, findings);
}

/// Checks the points of a table.
pub(super) fn points_of(
    path: Arguments,
    points: &[(f64, Vec<f64>)],
    what: &str,
    findings: &mut Findings,
) {
    if points.len() < 2 {
        let help = "give two or more, in order of time or progress";
        findings.add(format_args!("{path}"), "a table of fewer than two points", help);
    }
    let mut last = None;
    for (k, (s, values)) in points.iter().enumerate() {
        let first = format_args!("{path}[{k}][0]");
        let sound = if findings.is_timeless() && findings.is_sure_of("analysis") {
            let what = "the part of the stage that is done, 0 to 1, as the stage is static";
            findings.number(first, *s, |s| (0.0..=1.0).contains(&s), what)
        } else {
            findings.not_negative(first, *s, "a time in s")
        };
        if sound && last.is_some_and(|last| *s <= last) {
            let message = format!("not after the point before ({s:?})");
            findings.add(first, message, "give the points in ascending order");
        }
        if sound && k == 0 && *s > 0.0 {
            let help = "begin with a point at 0.0, the start of the stage";
            findings.add(first, format!("a table that begins later ({s:?})"), help);
        }
        last = Some(*s);
        for (j, value) in values.iter().enumerate() {
            findings.finite(format_args!("{path}[{k}][{}]", j + 1), *value, what);
        }
    }
}
