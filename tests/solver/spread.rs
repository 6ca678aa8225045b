//! Several solutions of one increment under Coulomb's law: how far they are apart in running
//! scenes. The table is in `docs/validation.md`.

use clastic::cone::condensed::Condensed;
use clastic::cone::coulomb::{Coulomb, Goal};
use clastic::cone::program::{ConeProgram, ConeSolution, Dof, SlidingLaw, SolveStatus};
use clastic::cone::solver::ConeSolver;
use clastic::run::Simulation;
use clastic::scene::format::FrictionLaw;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::common::step;
use crate::enumeration::Random;
use crate::reach::{scene, slides};

/// Scenes and the distance of the increments that are sampled.
const SCENES: [(&str, usize); 5] = [
    ("shear_box", 3),
    ("biaxial", 8),
    ("column_collapse_small", 20),
    ("hopper", 60),
    ("angle_of_repose", 40),
];

/// Starts of one program: the associated solution, the last forces at rest, no forces at rest, and
/// the associated solution with normal forces times 0.5 to 1.5 and any shear force within the limit.
fn starts(program: &ConeProgram, seed: u64) -> Option<Vec<ConeSolution>> {
    let associated = Condensed::default().solve(program, 0.0).ok()?;
    let rest = |forces: Vec<[f64; 3]>| ConeSolution {
        forces,
        displacements: program.imposed(),
        ..ConeSolution::default()
    };
    let none = vec![[0.0; 3]; program.interactions.len()];
    let mut last = program.last_forces.clone();
    last.resize(none.len(), [0.0; 3]);
    let mut all = vec![associated.clone(), rest(last), rest(none)];
    let r = &mut Random(ChaCha8Rng::seed_from_u64(seed));
    for _ in 0..5 {
        let mut start = associated.clone();
        for (c, f) in program.interactions.iter().zip(&mut start.forces) {
            f[0] *= r.between(0.5, 1.5);
            f[1] = c.limits.friction * f[0] * r.between(-1.0, 1.0);
            f[2] = c.limits.rolling * f[0] * r.between(-1.0, 1.0);
        }
        all.push(start);
    }
    Some(all)
}

/// Forces on the bodies that are held, by body and axis: the walls.
fn on_walls(program: &ConeProgram, solution: &ConeSolution) -> Vec<f64> {
    let mut rows = vec![[0.0; 3]; program.bodies.len()];
    program.add_forces(&solution.forces, &mut rows);
    let walls =
        program.bodies.iter().zip(&rows).filter(|(body, _)| matches!(body.dofs[0], Dof::Fixed(_)));
    walls.flat_map(|(_, row)| [row[0], row[1]]).collect()
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    let largest = a.iter().fold(1e-300_f64, |m, x| m.max(x.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

/// Maximum difference of contact forces, wall forces and motions, each over its maximum.
fn difference(program: &ConeProgram, a: &ConeSolution, b: &ConeSolution) -> [f64; 3] {
    let flat =
        |x: &ConeSolution| -> Vec<f64> { x.forces.iter().flat_map(|f| [f[0], f[1]]).collect() };
    let motions = |x: &ConeSolution| -> Vec<f64> {
        x.displacements.iter().flat_map(|u| [u[0], u[1], u[2] * program.scales.length]).collect()
    };
    [
        apart(&flat(a), &flat(b)),
        apart(&on_walls(program, a), &on_walls(program, b)),
        apart(&motions(a), &motions(b)),
    ]
}

/// Median and maximum.
fn middle_and_end(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    let last = values.last().copied().unwrap_or(0.0);
    [values.get(values.len() / 2).copied().unwrap_or(0.0), last]
}

/// Prints one line for every scene. `SPREAD=hopper` chooses one.
#[test]
#[ignore = "whole scenes, minutes"]
fn solutions_from_several_starts() {
    let chosen = std::env::var("SPREAD").unwrap_or_default();
    for (name, every) in SCENES.into_iter().filter(|(s, _)| chosen.is_empty() || chosen == *s) {
        let mut loaded = scene(name);
        loaded.scene.friction_law = FrictionLaw::COULOMB;
        let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
        let (mut sliding, mut programs, mut several, mut solved, mut tried) = (0, 0, 0, 0, 0);
        let mut spreads: [Vec<f64>; 3] = Default::default();
        while let Some(record) = step(&mut simulation) {
            let world = simulation.world();
            let (program, solution) =
                (world.resource::<ConeProgram>(), world.resource::<ConeSolution>());
            if solution.law == SlidingLaw::Associated || !slides(program, solution) {
                continue;
            }
            sliding += 1;
            if sliding % every != 0 {
                continue;
            }
            let Some(starts) = starts(program, record.increment) else { continue };
            tried += starts.len();
            let mut solver = Coulomb::default();
            let goal = Goal { tolerance: 0.9e-8, at_once: false };
            let found = starts.iter().map(|start| solver.solve(program, start, goal, 600));
            let found: Vec<_> = found.filter(|s| s.status == SolveStatus::Solved).collect();
            solved += found.len();
            programs += 1;
            let mut worst = [0.0_f64; 3];
            for (k, a) in found.iter().enumerate() {
                for b in &found[..k] {
                    let d = difference(program, a, b);
                    (0..3).for_each(|i| worst[i] = worst[i].max(d[i]));
                }
            }
            several += usize::from(worst[0] > 1e-4);
            (0..3).for_each(|i| spreads[i].push(worst[i]));
        }
        let [forces, walls, motions] = spreads.map(|values| {
            let [middle, end] = middle_and_end(values);
            format!("{middle:.1e} {end:.1e}")
        });
        println!(
            "{name}: {programs} programs, {solved} of {tried} starts solved, {several} with several solutions; \
             median and maximum spread of contact forces {forces}, wall forces {walls}, motions {motions}"
        );
    }
}
