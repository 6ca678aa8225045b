//! Walls, the particles beside them at the start, and the names under which walls and particles are
//! recorded.

use std::collections::BTreeMap;

use glam::DVec2;

use crate::run::wall_pieces::{CUT, is_cut, pieces};
use crate::scene::format::{Particle, Specimen, Stage, Wall, WallShape};
use crate::text::diagnostic::MAX_SHOWN;
use crate::text::spans::join;

use super::findings::At;
use super::materials::{bond_of_wall, contact};
use super::parts::index_exists;
use super::places::{is_behind, length};

/// Minimum height of the point of an arc above the chord, over the length of the chord: the radius
/// is then at most 1e5 chords, and the contact with the arc is exact to 1e-11 chords.
const FLAT: f64 = 1e-6;

pub(super) fn check(at: &mut At) {
    let context = at.context;
    let walls = &context.scene.walls;
    for (i, wall) in walls.iter().enumerate() {
        let at = &mut at.item("walls", i);
        if at.place("start", wall.start) & at.place("end", wall.end) {
            shape(at, wall);
        }
        touching(at, wall);
        contact(&mut at.field("contact"), wall.contact);
        bond_of_wall(&mut at.field("bond"), wall.bond);
    }
    at.names("walls", "name of a wall", &context.walls);
    let particles = context.listed();
    let of_particles = particles.iter().enumerate().filter_map(|(i, particle)| {
        Some((format!("specimen[{i}].probe"), particle.probe.as_deref()?))
    });
    let named = context.scene.probes.keys();
    let named = named.map(|name| (join("probes", name), name.as_str()));
    let of_walls = walls
        .iter()
        .enumerate()
        .filter_map(|(i, wall)| Some((format!("walls[{i}].probe"), wall.probe.as_deref()?)));
    // The history records rigid groups under their names.
    let mut made: Vec<(String, &str)> = Vec::new();
    let at_start = context.scene.rigid_at_start.iter();
    made.extend(at_start.map(|name| ("specimen".to_owned(), name.as_str())));
    for (i, stage) in context.scene.stages.iter().enumerate() {
        let Some(load) = stage.load() else { continue };
        for (name, _) in load.rigid.iter().filter(|(_, control)| control.makes()) {
            if made.iter().all(|(_, other)| other != name) {
                made.push((join(&format!("stages[{i}].rigid"), name), name));
            }
        }
    }
    let bodies = of_particles.chain(named).chain(of_walls);
    at.unique("name of a probe", bodies.chain(made));
    probes(at, particles);
}

/// Checks a wall that comes at the outermost particles: a stage adds it, and it has an inside.
fn touching(at: &mut At, wall: &Wall) {
    if !wall.touching || at.context.takes_walls() {
        return;
    }
    let help = "add `present: false`, and let a stage add it (`add_walls`)";
    let what = "a wall that comes at the outermost particles is there from the start";
    at.refuse(wall.present, "touching", what, help);
    let help =
        "give an end that is not the start: it comes along the normal of the line between them";
    at.refuse(wall.start == wall.end, "touching", "a closed wall has no direction", help);
}

/// Checks the particles that `probes` names: each has one name.
fn probes(at: &mut At, particles: &[Particle]) {
    let listed = particles.iter().zip(0..).filter_map(|(p, i)| Some((i, p.probe.as_deref()?)));
    let mut names: BTreeMap<u32, &str> = listed.collect();
    for (name, index) in &at.context.scene.probes {
        let at = &mut at.entry("probes", name);
        if index_exists(at, "", *index)
            && let Some(other) = names.insert(*index, name)
        {
            let message = format!("particle {index} is the probe `{other}` already");
            at.add("", message, "give it one name");
        }
    }
}

/// Checks that no stage adds a wall with the whole specimen behind it: such a wall is drawn from its
/// end to its start. Particles that pour in or that a plugin moves may be elsewhere by then.
pub(super) fn added(at: &mut At) {
    let context = at.context;
    let scene = context.scene;
    let comes = |name: &str| {
        let is_known = |stage: &&Stage| !matches!(stage, Stage::Pour(_) | Stage::Custom(_));
        let mut loads = scene.stages.iter().take_while(is_known).filter_map(Stage::load);
        loads.find(|load| load.add_walls.iter().any(|wall| wall == name))
    };
    let absent = scene.walls.iter().enumerate().filter(|(_, wall)| !wall.present);
    let added: Vec<_> =
        absent.filter_map(|(i, wall)| Some((i, wall, comes(&wall.name)?))).collect();
    let sound = at.are_sound(&["specimen", "walls", "stages"]);
    if added.is_empty() || !context.is_read() || context.is_resumed() || !sound {
        return;
    }
    let seeds = context.at_start();
    for (i, wall, stage) in added {
        let behind = |seed: &Particle| is_behind(wall, seed.position, seed.radius);
        let is_behind = !seeds.is_empty() && seeds.iter().all(behind);
        let message =
            format!("the whole specimen is behind this wall, which stage `{}` adds", stage.name);
        let help = "exchange start and end: a wall has its inside on the left of start to end";
        at.refuse(is_behind, format_args!("walls[{i}]"), message, help);
    }
}

/// Checks the points of a wall, whose ends are finite.
fn shape(at: &mut At, wall: &Wall) {
    match &wall.shape {
        WallShape::Line | WallShape::Segment => {
            let message = format!("a wall of zero length ({:?} to {:?})", wall.start, wall.end);
            at.refuse(length(wall) <= 0.0, "end", message, "move its end");
        }
        WallShape::Polyline(corners) => polyline(at, wall, corners),
        WallShape::Arc { through } => arc(at, wall, *through),
    }
}

fn polyline(at: &mut At, wall: &Wall, corners: &[(f64, f64)]) {
    let mut fine = true;
    for (k, corner) in corners.iter().enumerate() {
        fine &= at.place(format_args!("shape[{k}]"), *corner);
    }
    if !fine {
        return;
    }
    let help = "give the corners between start and end, or write `Segment`";
    at.refuse(corners.is_empty(), "shape", "a polyline without a corner", help);
    let points: Vec<_> = [wall.start].iter().chain(corners).chain([&wall.end]).copied().collect();
    let twice = points.windows(2).position(|ends| ends[0] == ends[1]);
    if let Some(k) = twice.filter(|_| !corners.is_empty()) {
        let message = format!("a piece of zero length at {:?}", points[k]);
        let field = if k < corners.len() { format!("shape[{k}]") } else { "end".to_owned() };
        at.add(field, message, "leave one of the two points out");
    }
}

fn arc(at: &mut At, wall: &Wall, through: (f64, f64)) {
    if !at.place("shape.through", through) {
        return;
    }
    let [start, point, end] = [wall.start, through, wall.end].map(DVec2::from);
    let (chord, from) = (end - start, point - start);
    if point == start || point == end {
        let help = "give a point between the ends; of a whole circle, the one opposite of start";
        at.add("shape.through", "an end of the arc", help);
    } else if start != end && chord.perp_dot(from).abs() < FLAT * chord.length_squared() {
        let message = format!("on one line with start and end {through:?}");
        at.add("shape.through", message, "give a point off the line, or write `shape: Segment`");
    }
}

/// Checks the particles at the start: none is cut by a thin wall, and none is too large for the
/// hollow side of an arc.
pub(super) fn beside_thin(at: &mut At) {
    let context = at.context;
    let scene = context.scene;
    let thin = || scene.walls.iter().enumerate().filter(|(_, wall)| !wall.shape.is_line());
    if thin().next().is_none() || !context.is_read() || !at.are_sound(&["specimen", "walls"]) {
        return;
    }
    let seeds = context.at_start();
    for (i, wall) in thin() {
        if let WallShape::Arc { .. } = wall.shape {
            hollow(&mut at.item("walls", i), wall, &seeds);
        }
    }
    let cut = seeds.iter().enumerate().filter_map(|(i, seed)| {
        let cuts = |wall: &Wall| wall.present && is_cut(wall, seed.position.into(), seed.radius);
        Some((i, seed, thin().find(|(_, wall)| cuts(wall))?.1))
    });
    for (i, seed, wall) in cut.take(MAX_SHOWN) {
        let (wall, place) = (&wall.name, seed.position);
        let message = format!("wall `{wall}` cuts through particle {i} at {place:?}");
        let help = format!(
            "its centre is within {CUT:?} radii of the wall, so that its side is not clear: move it"
        );
        let field = match scene.specimen {
            Specimen::Particles(_) => format!("specimen[{i}].position"),
            Specimen::File { .. } => "specimen.path".to_owned(),
            _ => "specimen".to_owned(),
        };
        at.add(field, message, help);
    }
}

/// A particle touches an arc at one point. On its hollow side it would touch both ends at once if
/// it were larger than the arc, or larger than the mouth of an arc of more than half a circle.
fn hollow(at: &mut At, wall: &Wall, seeds: &[Particle]) {
    let Some(piece) = pieces(wall).first().copied() else { return };
    let Some((radius, half_angle)) = piece.shape.circle() else { return };
    let largest = seeds.iter().map(|seed| seed.radius).fold(0.0, f64::max);
    let is_whole = wall.start == wall.end;
    let mouth = if half_angle > std::f64::consts::FRAC_PI_2 {
        radius.min(piece.wall.half_length)
    } else {
        radius
    };
    let message = format!(
        "an arc of radius {radius:.3e} m: a particle of radius {largest:.3e} m could touch both of its ends at once"
    );
    let help = "draw it as a `Polyline`, or close it to a whole circle";
    at.refuse(!is_whole && largest >= mouth, "shape", message, help);
}
