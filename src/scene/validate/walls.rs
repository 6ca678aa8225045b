//! Walls, and the names under which walls and particles are recorded.

use crate::scene::format::{Specimen, Wall};

use super::Context;
use super::findings::Findings;
use super::materials::{bond, contact};

pub(super) fn check(context: &Context, findings: &mut Findings) {
    let walls = &context.scene.walls;
    for (i, wall) in walls.iter().enumerate() {
        let start = findings.vector(format_args!("walls[{i}].start"), wall.start, "a place in m");
        let end = findings.vector(format_args!("walls[{i}].end"), wall.end, "a place in m");
        if start && end && length(wall) <= 0.0 {
            let message = format!("a wall of zero length ({:?} to {:?})", wall.start, wall.end);
            findings.add(format_args!("walls[{i}].end"), message, "move its end");
        }
        contact(format_args!("walls[{i}].contact"), wall.contact, findings);
        bond(format_args!("walls[{i}].bond"), wall.bond, findings);
    }
    if findings.is_sure_of("walls") {
        let names = walls.iter().enumerate();
        let names = names.map(|(i, wall)| (format!("walls[{i}].name"), wall.name.as_str()));
        findings.unique("name of a wall", names);
    }
    let particles = match &context.scene.specimen {
        Specimen::Particles(list) => list.as_slice(),
        _ => &[],
    };
    let of_particles = particles.iter().enumerate().filter_map(|(i, particle)| {
        Some((format!("specimen[{i}].probe"), particle.probe.as_deref()?))
    });
    let of_walls = walls
        .iter()
        .enumerate()
        .filter_map(|(i, wall)| Some((format!("walls[{i}].probe"), wall.probe.as_deref()?)));
    findings.unique("name of a probe", of_particles.chain(of_walls));
}

/// Length of the drawn segment, m.
pub(super) fn length(wall: &Wall) -> f64 {
    (wall.end.0 - wall.start.0).hypot(wall.end.1 - wall.start.1)
}
