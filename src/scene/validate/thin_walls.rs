//! Thin walls: their points, and the particles beside them at the start.

use glam::DVec2;

use super::findings::Findings;
use super::places::length;
use clastic_components::domain;

use crate::run::particles::ParticleSeed;
use crate::run::wall_pieces::{CUT, is_cut, pieces};
use crate::scene::diagnostic::MAX_SHOWN;
use crate::scene::format::{Specimen, Wall, WallShape};

/// Minimum height of the point of an arc above the chord, over the length of the chord: the radius
/// is then at most 1e5 chords, and the contact with the arc is exact to 1e-11 chords.
const FLAT: f64 = 1e-6;

/// Checks the points of a wall, whose ends are finite.
pub(super) fn shape(i: usize, wall: &Wall, findings: &mut Findings) {
    match &wall.shape {
        WallShape::Line | WallShape::Segment => {
            if length(wall) <= 0.0 {
                let message = format!("a wall of zero length ({:?} to {:?})", wall.start, wall.end);
                findings.add(format_args!("walls[{i}].end"), message, "move its end");
            }
        }
        WallShape::Polyline(corners) => polyline(i, wall, corners, findings),
        WallShape::Arc { through } => arc(i, wall, *through, findings),
    }
}

fn polyline(i: usize, wall: &Wall, corners: &[(f64, f64)], findings: &mut Findings) {
    let mut fine = true;
    for (k, corner) in corners.iter().enumerate() {
        fine &= findings.vector(format_args!("walls[{i}].shape[{k}]"), *corner, domain::PLACE.what);
    }
    if !fine {
        return;
    }
    if corners.is_empty() {
        let help = "give the corners between start and end, or write `Segment`";
        findings.add(format_args!("walls[{i}].shape"), "a polyline without a corner", help);
    }
    let points: Vec<_> = [wall.start].iter().chain(corners).chain([&wall.end]).copied().collect();
    let twice = points.windows(2).position(|ends| ends[0] == ends[1]);
    if let Some(k) = twice.filter(|_| !corners.is_empty()) {
        let message = format!("a piece of zero length at {:?}", points[k]);
        let help = "leave one of the two points out";
        if k < corners.len() {
            findings.add(format_args!("walls[{i}].shape[{k}]"), message, help);
        } else {
            findings.add(format_args!("walls[{i}].end"), message, help);
        }
    }
}

fn arc(i: usize, wall: &Wall, through: (f64, f64), findings: &mut Findings) {
    let path = format_args!("walls[{i}].shape.through");
    if !findings.vector(path, through, domain::PLACE.what) {
        return;
    }
    let [start, through, end] = [wall.start, through, wall.end].map(DVec2::from);
    let (chord, from) = (end - start, through - start);
    if through == start || through == end {
        let help = "give a point between the ends; of a whole circle, the one opposite of start";
        findings.add(path, "an end of the arc", help);
    } else if start != end && chord.perp_dot(from).abs() < FLAT * chord.length_squared() {
        let place = (through.x, through.y);
        let message = format!("on one line with start and end {place:?}");
        findings.add(path, message, "give a point off the line, or write `shape: Segment`");
    }
}

/// Help where a control needs a wall of one piece.
pub(super) const ONE_PIECE: &str = "name a wall of one piece";

/// A wall that a control or a measure needs as one straight or curved piece. The pair completes
/// "has no one ..." and says what helps.
pub(super) fn one_piece(
    path: std::fmt::Arguments,
    name: &str,
    (what, help): (&str, &str),
    findings: &mut Findings,
) {
    let wall = findings.context.wall(name);
    if wall.is_some_and(|wall| matches!(wall.shape, WallShape::Polyline(_))) {
        let message = format!("wall `{name}` is a polyline, which has no one {what}");
        findings.add(path, message, help);
    }
}

/// Checks the particles at the start: none is cut by a thin wall, and none is too large for the
/// hollow side of an arc.
pub(super) fn check(findings: &mut Findings) {
    let context = findings.context;
    let scene = context.scene;
    let thin = || scene.walls.iter().enumerate().filter(|(_, wall)| !wall.shape.is_line());
    if thin().next().is_none() || !context.is_read() || !findings.are_sound(&["specimen", "walls"])
    {
        return;
    }
    let seeds = context.at_start();
    for (i, wall) in thin() {
        if let WallShape::Arc { .. } = wall.shape {
            hollow(i, wall, &seeds, findings);
        }
    }
    let mut shown = 0;
    for (i, seed) in seeds.iter().enumerate() {
        let cut = thin().find(|(_, wall)| wall.present && is_cut(wall, seed.position, seed.radius));
        let Some((_, wall)) = cut else { continue };
        let place = (seed.position.x, seed.position.y);
        let message = format!("wall `{}` cuts through particle {i} at {place:?}", wall.name);
        let help = format!(
            "its centre is within {CUT:?} radii of the wall, so that its side is not clear: move it"
        );
        match scene.specimen {
            Specimen::Particles(_) => {
                findings.add(format_args!("specimen[{i}].position"), message, &help);
            }
            Specimen::File { .. } => findings.add(format_args!("specimen.path"), message, &help),
            _ => findings.add(format_args!("specimen"), message, &help),
        }
        shown += 1;
        if shown == MAX_SHOWN {
            return;
        }
    }
}

/// A particle touches an arc at one point. On its hollow side it would touch both ends at once if
/// it were larger than the arc, or larger than the mouth of an arc of more than half a circle.
fn hollow(i: usize, wall: &Wall, seeds: &[ParticleSeed], findings: &mut Findings) {
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
        findings.add(format_args!("walls[{i}].shape"), message, help);
    }
}
