//! How many increments with sliding contacts Coulomb's law solves in whole scenes, and at what
//! cost beside the associated law. The table is in `docs/decisions/004-coulomb-friction.md`.

use std::collections::BTreeMap;

use clastic::components::attempt::IncrementStatus;
use clastic::cone::program::{ConeProgram, ConeSolution};
use clastic::cone::residuals::{Carrying, displacement_scale, multipliers};
use clastic::run::Simulation;
use clastic::scene::LoadedScene;
use clastic::scene::format::{FrictionLaw, Specimen, Stage};

use crate::common::{load_with_specimen, step};

/// Slip or rotation of a contact that slides or rolls, over the maximum displacement.
const SLIP: f64 = 1e-6;

/// Whether a contact without strength that carries a force slides or rolls in a solution.
pub fn slides(program: &ConeProgram, solution: &ConeSolution) -> bool {
    let carrying = Carrying::new(program, solution);
    let unit = displacement_scale(program, &solution.displacements);
    program.interactions.iter().enumerate().any(|(k, c)| {
        let e = program.kinematics(c, &solution.displacements);
        let m = multipliers(solution.law, c, &e, &solution.forces[k]);
        !c.limits.has_strength()
            && carrying.is_carrying(k)
            && m.slip.abs().max(m.rotation.abs() * program.scales.length) > SLIP * unit
    })
}

/// A scene of `scenes/`; `biaxial` is the small biaxial test without cement and with a friction of
/// 0.5.
pub fn scene(name: &str) -> LoadedScene {
    let file = if name == "biaxial" { "biaxial_small" } else { name };
    let mut loaded = load_with_specimen(file);
    if name == "biaxial" {
        loaded.scene.stages.retain(|stage| !matches!(stage, Stage::Cement(_)));
        let contact = &mut loaded.scene.materials.get_mut("sand").unwrap().contact;
        (contact.friction, contact.rolling_friction) = (0.5, 0.0);
    }
    loaded
}

/// The scenes of the table, with the stiffness of elastic grains, N/m, in the dynamic ones: 50 m/dt^2
/// with m the mass of the mean disk. Rigid grains have none.
const SCENES: [(&str, Option<f64>); 6] = [
    ("column_collapse_small", Some(2.6e6)),
    ("shear_box", None),
    ("biaxial", None),
    ("hopper", Some(3.9e6)),
    ("rotating_drum_small", Some(1.5e6)),
    ("angle_of_repose", Some(2.6e6)),
];

/// Increments of a stage.
#[derive(Debug, Default)]
struct Count {
    increments: usize,
    sliding: usize,
    /// Of those with sliding contacts: solved without halving, capped, parts of halved increments.
    solved: usize,
    capped: usize,
    parts: usize,
    failed: usize,
    factorisations: u64,
    seconds: f64,
}

/// Processor time of this process, s.
fn processor_time() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    let ticks = |k: usize| after_name.split_whitespace().nth(k).and_then(|x| x.parse::<f64>().ok());
    let ticks: f64 = [11, 12].into_iter().filter_map(ticks).sum();
    ticks / 100.0
}

fn measure(name: &str, law: FrictionLaw, stiffness: Option<f64>) -> BTreeMap<String, Count> {
    measure_scene(scene(name), law, stiffness)
}

fn measure_scene(
    mut loaded: LoadedScene,
    law: FrictionLaw,
    stiffness: Option<f64>,
) -> BTreeMap<String, Count> {
    for material in loaded.scene.materials.values_mut() {
        material.contact.normal_stiffness = material.contact.normal_stiffness.or(stiffness);
        material.contact.tangential_stiffness = material.contact.tangential_stiffness.or(stiffness);
    }
    loaded.scene.friction_law = law;
    loaded.scene.acceptance.residual = 1e-8;
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    let mut stages: BTreeMap<String, Count> = BTreeMap::new();
    let mut before = processor_time();
    while let Some(record) = step(&mut simulation) {
        let count = stages.entry(record.stage.clone()).or_default();
        let world = simulation.world();
        count.increments += 1;
        count.factorisations += u64::from(record.iterations);
        let now = processor_time();
        count.seconds += now - std::mem::replace(&mut before, now);
        if slides(world.resource::<ConeProgram>(), world.resource::<ConeSolution>()) {
            count.sliding += 1;
            let whole = record.fraction == 1.0;
            count.parts += usize::from(!whole);
            match record.status {
                IncrementStatus::Solved => count.solved += usize::from(whole),
                IncrementStatus::Capped => count.capped += 1,
                _ => count.failed += 1,
            }
        }
    }
    stages
}

/// The scenes of the table that the variable `REACH` names; all without it.
fn chosen_scenes() -> impl Iterator<Item = (&'static str, Option<f64>)> {
    let chosen = std::env::var("REACH").unwrap_or_default();
    SCENES.into_iter().filter(move |s| chosen.is_empty() || chosen.split(',').any(|c| c == s.0))
}

/// Prints one line for every scene, kind of grains, law and stage. `REACH=hopper,biaxial` chooses scenes.
#[test]
#[ignore = "whole scenes, minutes"]
fn sliding_increments_are_solved() {
    for (name, stiffness) in chosen_scenes() {
        let laws = [(FrictionLaw::COULOMB, "Coulomb"), (FrictionLaw::Associated, "associated")];
        let grains = [(None, "rigid")].into_iter().chain(stiffness.map(|k| (Some(k), "elastic")));
        for ((law, text), (stiffness, kind)) in
            laws.into_iter().flat_map(|law| grains.clone().map(move |grains| (law, grains)))
        {
            for (stage, count) in measure(name, law, stiffness) {
                println!("{name} | {kind} | {text} | {stage} | {count:?}");
                // What is committed has its residual within the bound.
                assert_eq!(count.failed, 0, "{name}, {stage}");
            }
        }
    }
}

/// Increments with sliding contacts of elastic grains are solved as a whole under Coulomb's law, of
/// soft and of stiff grains and with seeds that are not those of the scenes. Prints one line for
/// every dynamic scene, stiffness, seed and stage. `REACH=hopper,...` chooses scenes.
#[test]
#[ignore = "whole scenes, minutes"]
fn sliding_increments_by_stiffness() {
    for (name, stiffness) in chosen_scenes().filter_map(|(name, k)| Some((name, k?))) {
        for factor in [0.1, 1.0, 10.0, 100.0] {
            for number in [1001, 1002] {
                let mut loaded = scene(name);
                if let Specimen::Packing { seed, .. } = &mut loaded.scene.specimen {
                    *seed = number;
                }
                let law = FrictionLaw::COULOMB;
                for (stage, count) in measure_scene(loaded, law, Some(factor * stiffness)) {
                    let k = 50.0 * factor;
                    println!("{name} | k dt^2/m = {k} | seed {number} | {stage} | {count:?}");
                    assert_eq!(count.solved, count.sliding, "{name}, {k}, {number}, {stage}");
                }
            }
        }
    }
}

/// A settling and collapsing column of elastic grains under Coulomb's law: every increment with
/// sliding contacts is solved to 1e-8 as a whole. The seed is not that of the scene on which the stiffness was chosen.
#[test]
fn sliding_increments_of_elastic_grains_are_all_solved() {
    let mut loaded = scene("column_collapse_small");
    if let Specimen::Packing { seed, .. } = &mut loaded.scene.specimen {
        *seed = 77;
    }
    for stage in &mut loaded.scene.stages {
        if let Stage::Load(load) = stage {
            load.increments = load.increments.min(60);
        }
    }
    let stages = measure_scene(loaded, FrictionLaw::COULOMB, Some(2.6e6));
    for name in ["settle", "release"] {
        let count = &stages[name];
        assert!(count.sliding >= 40, "{name}: {count:?}");
        assert_eq!(count.solved, count.sliding, "{name}: {count:?}");
    }
}
