//! Work on several threads leaves the same bytes as on one.

mod common;

use std::path::Path;

use clastic::components::contact_history::ContactHistory;
use clastic::components::observation::Observation;
use clastic::cone::condensed::matrix::BodyMatrix;
use clastic::cone::program::ConeProgram;
use clastic::run::Simulation;
use clastic::scene::format::WallControl::Displacement;
use clastic::scene::{self, LoadedScene};
use rayon::ThreadPoolBuilder;

use common::{State, load_with_specimen, next, stage, states};

/// The rock of `uniaxial.ron` for the scene of rigid rock, seven increments of it.
const ELASTIC: [&str; 6] = [
    "materials.rock.contact=(normal_stiffness: 3.4e10, tangential_stiffness: 3.4e10, friction: 0.4)",
    "materials.rock.bond=(normal_stiffness: 7.9e10, tangential_stiffness: 7.9e10, friction: 0.8, \
     cohesion: 195.0e6, tensile_strength: 144.0e6)",
    "walls.bottom.contact=(normal_stiffness: 3.4e10, tangential_stiffness: 3.4e10, friction: 0.4)",
    "walls.top.contact=(normal_stiffness: 3.4e10, tangential_stiffness: 3.4e10, friction: 0.4)",
    "acceptance=(turn: 1.0)",
    "stages.load.increments=7",
];

/// Result of a run: records, states, and the memory of contacts.
type Left = (Vec<Observation>, Vec<State>, ContactHistory);

/// Runs a scene for `increments` on `threads`. The matrix of the last program must have branches,
/// or the threads would have nothing to share.
fn after(loaded: &LoadedScene, increments: usize, threads: usize) -> Left {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
        let records: Vec<_> =
            std::iter::from_fn(|| next(&mut simulation)).take(increments).collect();
        assert_eq!(records.len(), increments);
        let program = simulation.world().resource::<ConeProgram>();
        let pairs: Vec<_> = program.interactions.iter().map(|c| (c.a, c.b)).collect();
        let matrix = BodyMatrix::new(program.bodies.len(), &pairs);
        assert!(matrix.branches().len() > 4, "nothing to do for a fifth thread");
        let history = simulation.world().resource::<ContactHistory>().clone();
        (records, states(&mut simulation), history)
    })
}

/// Elastic rock up to its peak in large increments: Newton iteration, local elimination, interior
/// point.
#[test]
fn rock_that_breaks() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/uniaxial_rigid.ron");
    let mut loaded = scene::load(&path, &ELASTIC.map(str::to_owned)).unwrap();
    let Some(Displacement(_, top)) = stage(&mut loaded.scene, "load").walls.get_mut("top") else {
        panic!("the platen is driven");
    };
    *top *= 30.0;
    let one = after(&loaded, 7, 1);
    let (records, ..) = &one;
    // The Newton iteration ends after 16 factorisations.
    assert!(records.iter().any(|r| r.iterations > 16 * r.solves), "no interior point");
    assert!(records.iter().any(|r| r.solves > 1), "nothing solved twice");
    for threads in [2, 5] {
        assert!(after(&loaded, 7, threads) == one, "{threads} threads");
    }
}

/// Rigid rock: the interior point alone.
#[test]
fn rigid_rock() {
    let loaded = load_with_specimen("uniaxial_rigid");
    let one = after(&loaded, 1, 1);
    for threads in [2, 5] {
        assert!(after(&loaded, 1, threads) == one, "{threads} threads");
    }
}
