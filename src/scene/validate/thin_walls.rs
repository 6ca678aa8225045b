//! Thin walls: their points, and the particles beside them at the start.

use glam::DVec2;

use super::findings::At;
use super::places::length;

use crate::run::wall_pieces::{CUT, is_cut, pieces};
use crate::scene::diagnostic::MAX_SHOWN;
use crate::scene::format::{Particle, Specimen, Wall, WallShape};

/// Minimum height of the point of an arc above the chord, over the length of the chord: the radius
/// is then at most 1e5 chords, and the contact with the arc is exact to 1e-11 chords.
const FLAT: f64 = 1e-6;

/// Checks the points of a wall, whose ends are finite.
pub(super) fn shape(at: &mut At, wall: &Wall) {
    match &wall.shape {
        WallShape::Line | WallShape::Segment => {
            if length(wall) <= 0.0 {
                let message = format!("a wall of zero length ({:?} to {:?})", wall.start, wall.end);
                at.add("end", message, "move its end");
            }
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
    if corners.is_empty() {
        let help = "give the corners between start and end, or write `Segment`";
        at.add("shape", "a polyline without a corner", help);
    }
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
pub(super) fn check(at: &mut At) {
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
    if !is_whole && largest >= mouth {
        let message = format!(
            "an arc of radius {radius:.3e} m: a particle of radius {largest:.3e} m could touch both of \
             its ends at once"
        );
        let help = "draw it as a `Polyline`, or close it to a whole circle";
        at.add("shape", message, help);
    }
}
