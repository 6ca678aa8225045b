//! Work on several threads leaves the same bytes as on one.

mod common;

use std::path::Path;

use clastic::bench::rigs::Scenes;
use clastic::components::program::ConeProgram;
use clastic::run::Simulation;
use clastic::scene::LoadedScene;
use clastic::scene::format::WallControl::Displacement;
use clastic::systems::solve_program::condensed::matrix::BodyMatrix;
use rayon::ThreadPoolBuilder;

use common::{State, next, stage, states};

fn scenes() -> Scenes {
    Scenes::new(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"))
}

/// States after so many increments on so many threads; the program of the last one must have branches.
fn states_after(loaded: &LoadedScene, increments: usize, threads: usize) -> Vec<State> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
        let taken = std::iter::from_fn(|| next(&mut simulation)).take(increments).count();
        assert_eq!(taken, increments);
        let program = simulation.world().resource::<ConeProgram>();
        let pairs: Vec<_> = program.interactions.iter().map(|c| (c.a, c.b)).collect();
        let matrix = BodyMatrix::new(program.bodies.len(), &pairs).unwrap();
        assert!(matrix.branches().len() > 1, "nothing to do for a second thread");
        states(&mut simulation)
    })
}

/// Elastic rock beyond its peak in large increments: Newton iteration, local elimination, interior point,
/// settling.
#[test]
fn rock_that_breaks() {
    let mut loaded = scenes().uniaxial(true, 7).unwrap();
    let Some(Displacement(_, top)) = stage(&mut loaded.scene, "load").walls.get_mut("top") else {
        panic!("the platen is driven");
    };
    *top *= 10.0;
    let one = states_after(&loaded, 7, 1);
    for threads in [2, 3] {
        assert!(states_after(&loaded, 7, threads) == one, "{threads} threads");
    }
}

/// Rigid rock: the interior point alone.
#[test]
fn rigid_rock() {
    let loaded = scenes().load("uniaxial_rigid", &[]).unwrap();
    let one = states_after(&loaded, 1, 1);
    for threads in [2, 5] {
        assert!(states_after(&loaded, 1, threads) == one, "{threads} threads");
    }
}
