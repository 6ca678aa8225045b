//! Walls, and the names under which walls and particles are recorded.

use std::collections::BTreeMap;

use crate::scene::format::{Particle, Stage, Wall};
use crate::scene::spans::join;

use super::findings::At;
use super::materials::{bond_of_wall, contact};
use super::places::is_behind;
use super::references::index_exists;
use super::thin_walls;

pub(super) fn check(at: &mut At) {
    let context = at.context;
    let walls = &context.scene.walls;
    for (i, wall) in walls.iter().enumerate() {
        let at = &mut at.item("walls", i);
        if at.place("start", wall.start) & at.place("end", wall.end) {
            thin_walls::shape(at, wall);
        }
        touching(at, wall);
        contact(&mut at.field("contact"), wall.contact);
        bond_of_wall(&mut at.field("bond"), wall.bond);
    }
    let walls = || walls.iter().enumerate();
    if at.is_sure_of("walls") {
        let names = walls().map(|(i, wall)| (format!("walls[{i}].name"), wall.name.as_str()));
        at.unique("name of a wall", names);
    }
    let particles = context.listed();
    let of_particles = particles.iter().enumerate().filter_map(|(i, particle)| {
        Some((format!("specimen[{i}].probe"), particle.probe.as_deref()?))
    });
    let named = context.scene.probes.keys();
    let named = named.map(|name| (join("probes", name), name.as_str()));
    let of_walls =
        walls().filter_map(|(i, wall)| Some((format!("walls[{i}].probe"), wall.probe.as_deref()?)));
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
    if wall.present {
        let help = "add `present: false`, and let a stage add it (`add_walls`)";
        let what = "a wall that comes at the outermost particles is there from the start";
        at.add("touching", what, help);
    }
    if wall.start == wall.end {
        let help =
            "give an end that is not the start: it comes along the normal of the line between them";
        at.add("touching", "a closed wall has no direction", help);
    }
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
        if !seeds.is_empty() && seeds.iter().all(behind) {
            let message = format!(
                "the whole specimen is behind this wall, which stage `{}` adds",
                stage.name
            );
            let help = "exchange start and end: a wall has its inside on the left of start to end";
            at.add(format_args!("walls[{i}]"), message, help);
        }
    }
}
