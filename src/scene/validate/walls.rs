//! Walls, and the names under which walls and particles are recorded.

use std::collections::BTreeMap;

use clastic_components::domain;

use crate::scene::format::{Particle, Specimen, Wall};
use crate::scene::spans::join;

use super::findings::Findings;
use super::materials::{bond_of_wall, contact};
use super::references::index_exists;
use super::thin_walls;

pub(super) fn check(findings: &mut Findings) {
    let context = findings.context;
    let walls = &context.scene.walls;
    for (i, wall) in walls.iter().enumerate() {
        let start =
            findings.vector(format_args!("walls[{i}].start"), wall.start, domain::PLACE.what);
        let end = findings.vector(format_args!("walls[{i}].end"), wall.end, domain::PLACE.what);
        if start && end {
            thin_walls::shape(i, wall, findings);
        }
        touching(i, wall, findings);
        contact(format_args!("walls[{i}].contact"), wall.contact, findings);
        bond_of_wall(format_args!("walls[{i}].bond"), wall.bond, findings);
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
    findings.unique("name of a probe", bodies.chain(made));
    probes(particles, findings);
}

/// Checks a wall that comes at the outermost particles: a stage adds it, and it has an inside.
fn touching(i: usize, wall: &Wall, findings: &mut Findings) {
    if !wall.touching || findings.context.takes_walls() {
        return;
    }
    if wall.present {
        let help = "add `present: false`, and let a stage add it (`add_walls`)";
        let what = "a wall that comes at the outermost particles is there from the start";
        findings.add(format_args!("walls[{i}].touching"), what, help);
    }
    if wall.start == wall.end {
        let help =
            "give an end that is not the start: it comes along the normal of the line between them";
        findings.add(format_args!("walls[{i}].touching"), "a closed wall has no direction", help);
    }
}

/// Checks the particles that `probes` names: each has one name.
fn probes(particles: &[Particle], findings: &mut Findings) {
    let listed = particles.iter().zip(0..).filter_map(|(p, i)| Some((i, p.probe.as_deref()?)));
    let mut names: BTreeMap<u32, &str> = listed.collect();
    for (name, index) in &findings.context.scene.probes {
        let path = join("probes", name);
        if !index_exists(format_args!("{path}"), *index, findings) {
            continue;
        }
        if let Some(other) = names.insert(*index, name) {
            let message = format!("particle {index} is the probe `{other}` already");
            findings.add(format_args!("{path}"), message, "give it one name");
        }
    }
}
