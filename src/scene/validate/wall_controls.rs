//! Controls of walls in a stage.

use clastic_components::domain;

use crate::scene::format::{Analysis, LidLoad, Slide, Table, WallControl};
use crate::text::suggest;

use super::findings::At;
use super::parts::{ONE_PIECE, are_apart, bounds, needs_time, one_piece, straight, wall_there};

/// Maximum rotation of a wall in an increment, rad. Gaps are those of the rotation to first order
/// for a disk that moves with the wall, whose error is that share squared of its motion.
const MAX_TURN: f64 = 0.2;

/// Checks the control of a wall in a stage, which may have no time.
pub(super) fn control_of_wall(at: &mut At, name: &str, control: &WallControl, increments: u32) {
    let dt = if let Analysis::Dynamic { dt, .. } = at.analysis { Some(dt) } else { None };
    let walls = &at.context.walls;
    if walls.contains(&name) {
        wall_there(at, "", name);
    } else if at.is_sure_of("walls") {
        let help = suggest::help(name, walls, "walls");
        at.add_at_key(format!("unknown wall (`{name}`)"), help);
    }
    match control {
        WallControl::Fixed | WallControl::Custom => {}
        WallControl::Displacement(x, y) => {
            at.vector("", (*x, *y), "a displacement in m");
        }
        WallControl::Velocity(x, y) => {
            at.vector("", (*x, *y), domain::VELOCITY.what);
            needs_time(at, "", "a velocity", "Displacement");
        }
        WallControl::Rotation { about, angle } => {
            at.place("about", *about);
            let what = "an angle of one increment in rad, at most 0.2 (11 degrees)";
            at.number("angle", *angle, |angle: f64| angle.abs() <= MAX_TURN, what);
        }
        WallControl::Spin { about, angular_velocity } => {
            at.place("about", *about);
            at.finite("angular_velocity", *angular_velocity, "an angular velocity in rad/s");
            if let Some(dt) = dt.filter(|dt| (angular_velocity * dt).abs() > MAX_TURN) {
                let message = format!("a turn of {:?} rad in a time step", angular_velocity * dt);
                let help = "give a smaller one, or a smaller dt: at most 0.2 rad in a time step";
                at.add("angular_velocity", message, help);
            }
            needs_time(at, "", "an angular velocity", "Rotation");
        }
        WallControl::Force(force) => {
            one_piece(at, "", name, ("normal", ONE_PIECE));
            at.finite("[0]", *force, "a force in N");
        }
        WallControl::Stress { stress, between } => {
            one_piece(at, "", name, ("normal", ONE_PIECE));
            at.finite("stress", *stress, "a stress in Pa");
            loaded_between(at, name, between.as_ref());
        }
        WallControl::Lid { load, slide } => lid(at, name, load, *slide),
        WallControl::Follow(table) => {
            // Part of a table that an increment takes.
            let step = dt.unwrap_or(1.0 / f64::from(increments.max(1)));
            follow(at, name, table, step);
        }
    }
}

/// Checks that no increment, which takes `step` of a table of angles, turns a wall too far.
fn turns(at: &mut At, angle: &[(f64, f64)], step: f64) {
    for (k, pair) in angle.windows(2).enumerate() {
        let [(s, a), (t, b)] = [pair[0], pair[1]];
        // Of an interval an increment takes its step or the whole of it.
        let turn = (b - a).abs() * (step / (t - s)).min(1.0);
        if t > s && turn > MAX_TURN {
            let message = format!("a turn of {turn:?} rad in an increment");
            let help = "give more increments, or a smaller dt: at most 0.2 rad in an increment";
            at.add(format_args!("[{}][1]", k + 1), message, help);
        }
    }
}

/// Checks the two walls that bound the loaded length of a stress.
fn loaded_between(at: &mut At, name: &str, between: Option<&(String, String)>) {
    let Some((a, b)) = between else { return };
    for (field, other) in [("between[0]", a), ("between[1]", b)] {
        wall_there(at, field, other);
        one_piece(at, field, other, ("place and normal", ONE_PIECE));
        let help = "name the two walls that bound its loaded length";
        at.refuse(other == name, field, format!("the wall itself (`{name}`)"), help);
    }
    at.pair("between", (a, b), "wall");
    are_apart(at, "between", (a, b));
    if a != b && a != name {
        bounds(at, "between", (a, name));
    }
}

fn lid(at: &mut At, name: &str, load: &LidLoad, slide: Slide) {
    let wall = at.context.wall(name);
    straight(at, "", wall, "a lid is a straight wall: it slides along itself");
    match load {
        LidLoad::Force(force) => {
            at.finite("load[0]", *force, "a force in N");
        }
        LidLoad::Stress { stress, between } => {
            at.finite("load.stress", *stress, "a stress in Pa");
            loaded_between(&mut at.field("load"), name, between.as_ref());
        }
    }
    match slide {
        Slide::Displacement(u) => {
            at.finite("slide[0]", u, "a displacement in m");
        }
        Slide::Velocity(v) => {
            at.finite("slide[0]", v, domain::VELOCITY.what);
            needs_time(at, "slide[0]", "a velocity", "Displacement");
        }
    }
}

fn follow(at: &mut At, name: &str, table: &Table, step: f64) {
    match table {
        Table::Displacement(points) => {
            let points = points.iter().map(|(s, x, y)| (*s, [*x, *y]));
            points_of(at, points, "a displacement in m");
        }
        Table::Force(force) => {
            one_piece(at, "", name, ("normal", ONE_PIECE));
            graph(at, force, "a force in N");
        }
        Table::Rotation { about, angle } => {
            graph(&mut at.field("angle"), angle, "an angle in rad");
            at.place("about", *about);
            turns(&mut at.field("angle"), angle, step);
        }
        Table::Stress { stress, between } => {
            loaded_between(at, name, between.as_ref());
            one_piece(at, "stress", name, ("normal", ONE_PIECE));
            graph(&mut at.field("stress"), stress, "a stress in Pa");
        }
    }
}

/// Checks a table of one value.
pub(super) fn graph(at: &mut At, points: &[(f64, f64)], what: &str) {
    points_of(at, points.iter().map(|(s, value)| (*s, [*value])), what);
}

/// Checks the points of a table: a time or a part of the stage, and values then.
fn points_of<const N: usize>(
    at: &mut At,
    points: impl ExactSizeIterator<Item = (f64, [f64; N])>,
    what: &str,
) {
    let help = "give two or more, in order of time or progress";
    at.refuse(points.len() < 2, "", "a table of fewer than two points", help);
    let mut last = None;
    for (k, (s, values)) in points.enumerate() {
        let at = &mut at.item("", k);
        let sound = if at.is_timeless() {
            let what = "the part of the stage that is done, 0 to 1, as the stage is static";
            at.number("[0]", s, |s| (0.0..=1.0).contains(&s), what)
        } else {
            at.not_negative("[0]", s, "a time in s")
        };
        if sound && last.is_some_and(|last| s <= last) {
            let message = format!("not after the point before ({s:?})");
            at.add("[0]", message, "give the points in ascending order");
        }
        if sound && k == 0 && s > 0.0 {
            let help = "begin with a point at 0.0, the start of the stage";
            at.add("[0]", format!("a table that begins later ({s:?})"), help);
        }
        last = Some(s);
        for (j, value) in values.into_iter().enumerate() {
            at.finite(format_args!("[{}]", j + 1), value, what);
        }
    }
}
