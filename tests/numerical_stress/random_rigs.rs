//! What a rig adds to random scenes: walls that come, go and are cemented, measures, stop
//! conditions, probes and tolerances.

use std::collections::{BTreeMap, BTreeSet};

use clastic::scene::format::*;

use crate::random::Random;
use crate::random_scenes::{bond, random_scene, survey};

#[test]
fn random_rigs_are_solved_or_say_why_not() {
    survey(|seed| with_rig(random_scene(seed, 40), seed));
}

/// The scene with a rig about it. The choices of the scene are kept.
fn with_rig(mut scene: Scene, seed: u64) -> Scene {
    let r = &mut Random::new(!seed);
    scene.acceptance.turn = r.pick(&[0.05, 0.3, 0.3, 3.0]);
    for wall in &mut scene.walls {
        let stiffness = r.decades(1e5, 1e9);
        wall.bond = r.maybe(0.3, |r| bond(r, stiffness));
        wall.probe = r.maybe(0.2, |_| wall.name.clone());
    }
    let compacts = matches!(scene.stages.first(), Some(Stage::Compact(_)));
    if !compacts {
        for wall in &mut scene.walls {
            wall.present = !r.chance(0.2);
        }
    }
    let Specimen::Particles(particles) = &mut scene.specimen else { unreachable!() };
    if r.chance(0.3) {
        particles[0].probe = Some("first".to_owned());
    }
    let count = particles.len() as u32;
    let boxed = scene.walls.iter().filter(|w| w.present).count() == 4;
    scene.measures = measures(r, count, boxed);
    let mut present: BTreeSet<String> =
        scene.walls.iter().filter(|w| w.present).map(|w| w.name.clone()).collect();
    let measured = scene.strain("axial_strain").cloned();
    let strain = measured.is_some();
    let stress = scene.stress("axial_stress").is_some();
    let first = scene.stages.iter().find(|s| matches!(s, Stage::Load(_)));
    scene.reference_stage = first.map(|stage| stage.name().to_owned());
    let dynamic = scene.analysis != Analysis::Static;
    let mut kept: BTreeMap<String, (String, String)> = BTreeMap::new();
    for stage in &mut scene.stages {
        let Stage::Load(load) = stage else { continue };
        for wall in &scene.walls {
            // The distance of two walls is a measure only while both are there.
            let held = matches!(&measured, Some(Strain::Walls(..)));
            if present.contains(&wall.name) && !held && r.chance(0.2) {
                present.remove(&wall.name);
                load.remove_walls.push(wall.name.clone());
            } else if !present.contains(&wall.name) && r.chance(0.5) {
                present.insert(wall.name.clone());
                load.add_walls.push(wall.name.clone());
            }
        }
        load.walls.retain(|name, control| {
            let between = match control {
                WallControl::Stress { between: Some((a, b)), .. } => {
                    present.contains(a) && present.contains(b)
                }
                _ => true,
            };
            present.contains(name) && between
        });
        // A wall whose stress acts on a distance that goes with this stage is held instead.
        kept.retain(|wall, _| present.contains(wall) && !load.walls.contains_key(wall));
        kept.retain(|wall, (a, b)| {
            let stays = present.contains(a) && present.contains(b);
            if !stays {
                load.walls.insert(wall.clone(), WallControl::Fixed);
            }
            stays
        });
        for (wall, control) in &load.walls {
            if let WallControl::Stress { between: Some(between), .. } = control {
                kept.insert(wall.clone(), between.clone());
            }
        }
        let moves = load.analysis.map_or(dynamic, |analysis| analysis != Analysis::Static);
        load.stop = stops(r, strain, stress, moves);
    }
    scene
}

fn measures(r: &mut Random, particles: u32, boxed: bool) -> Vec<Measure> {
    let walls = |a: &str, b: &str| Strain::Walls(a.to_owned(), b.to_owned());
    let area = r.decades(1e-4, 1.0);
    let average = |component| Stress::Average { component, area: Area::Fixed(area) };
    let mut measures = Vec::new();
    let mut add = |name: &str, of| measures.push(Measure { name: name.to_owned(), of });
    let by_particles = particles > 1 && r.chance(0.5);
    if boxed && r.chance(0.3) {
        add("axial_strain", Quantity::Strain(walls("bottom", "top")));
        add("lateral_strain", Quantity::Strain(walls("left", "right")));
    } else if by_particles {
        add("axial_strain", Quantity::Strain(Strain::Particles(0, particles - 1)));
    }
    if r.chance(0.5) {
        add("axial_stress", Quantity::Stress(average(Component::Yy)));
    }
    if r.chance(0.3) {
        add("lateral_stress", Quantity::Stress(average(Component::Xx)));
    }
    measures
}

fn stops(r: &mut Random, strain: bool, stress: bool, moves: bool) -> Vec<Stop> {
    let mut stops = Vec::new();
    if strain && r.chance(0.3) {
        let (strain, name) = (r.decades(1e-6, 1e-1), "axial_strain".to_owned());
        let extends = r.pick(&[true, false]);
        stops.push(if extends { Stop::Below(name, -strain) } else { Stop::Above(name, strain) });
    }
    if stress && r.chance(0.3) {
        stops.push(Stop::StressDrop(r.pick(&[0.5, 0.9])));
    }
    if moves && r.chance(0.2) {
        stops.push(Stop::Rest(r.decades(1e-6, 1.0)));
    }
    stops
}
