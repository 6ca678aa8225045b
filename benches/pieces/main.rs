//! The pieces of an increment, one by one: detection, assembly, ordering and symbolic
//! factorisation, numeric factorisation, and the solve of one increment of each regime.
//!
//!     cargo bench -p clastic_pieces                     1200, 7380 and 29 520 disks
//!     cargo bench -p clastic_pieces -- factorise        pieces with this in their names
//!
//! Regimes are measured on small specimens, with `CLASTIC_BENCH=full` on those of the paper too.
//!
//! Bodies are bonded rock after three elastic increments; regimes are the programs of the part
//! `precision` of `clastic_bench`. A solve comes from the increment before, as in a run.

use std::path::Path;
use std::time::Duration;

use bevy_ecs::prelude::*;
use clastic::components::contact::BodyTable;
use clastic::cone::condensed::Condensed;
use clastic::cone::condensed::matrix::BodyMatrix;
use clastic::cone::program::ConeProgram;
use clastic::cone::solver::ConeSolver;
use clastic::run::{Simulation, Step};
use clastic::scene::LoadedScene;
use clastic::systems::assemble_program::{assemble_interactions, balance_bodies};
use clastic::systems::detect_contacts::candidates::CandidatePairs;
use clastic::systems::detect_contacts::detect_contacts;
use clastic_bench::capture::{Captured, Moment, capture};
use clastic_bench::precision::problems;
use clastic_bench::rigs::Scenes;
use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use faer::Mat;
use rayon::ThreadPoolBuilder;

mod faer_cholesky;

use faer_cholesky::FaerCholesky;

fn scenes() -> Scenes {
    Scenes::new(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes"))
}

/// Bonded rock in tiles: whether they are large (7380 disks, else 400), columns, rows.
const ROCKS: [(bool, u32, u32); 3] = [(false, 3, 1), (true, 1, 1), (true, 2, 2)];

fn rock((large, columns, rows): (bool, u32, u32)) -> LoadedScene {
    let scenes = scenes();
    let boxed = scenes.rock(large).unwrap_or_else(|e| panic!("{e}")).tiled(columns, rows);
    scenes.compression_of(boxed, 5).unwrap_or_else(|e| panic!("{e}"))
}

/// A specimen after three increments.
fn loaded(rock: &LoadedScene) -> Simulation {
    let mut simulation = Simulation::new(&rock.scene, rock.specimen.as_ref());
    for _ in 0..3 {
        assert_eq!(simulation.step(), Step::Increment);
    }
    simulation
}

/// On one thread, as faer's factorisation and Clarabel beside it.
fn on_one_thread() {
    // The second to come finds it done.
    let _ = ThreadPoolBuilder::new().num_threads(1).build_global();
}

fn detection_and_assembly(c: &mut Criterion) {
    on_one_thread();
    let mut group = c.benchmark_group("pieces");
    group.sample_size(20).measurement_time(Duration::from_secs(2));
    group.warm_up_time(Duration::from_millis(500));
    for tiles in ROCKS {
        let mut simulation = loaded(&rock(tiles));
        let bodies = simulation.world().resource::<BodyTable>().clone();
        let n = bodies.particles;
        let (positions, radii) = (&bodies.positions[..n], &bodies.radii[..]);
        group.bench_function(BenchmarkId::new("candidates", n), |b| {
            b.iter(|| {
                let mut list = CandidatePairs::default();
                list.ensure(positions, radii, 0.02 * bodies.mean_radius);
                list
            });
        });
        let world = simulation.world_mut();
        let mut run = |name: &str, system: fn(&mut World)| {
            group.bench_function(BenchmarkId::new(name, n), |b| b.iter(|| system(world)));
        };
        run("detect, list kept", |world| {
            world.run_system_cached(detect_contacts).unwrap_or_else(|e| panic!("{e}"));
        });
        run("assemble", |world| {
            world.run_system_cached(assemble_interactions).unwrap_or_else(|e| panic!("{e}"));
            world.run_system_cached(balance_bodies).unwrap_or_else(|e| panic!("{e}"));
        });
        let program = world.resource::<ConeProgram>();
        let pairs: Vec<_> = program.interactions.iter().map(|c| (c.a, c.b)).collect();
        let bodies = program.bodies.len();
        let symbolic = || BodyMatrix::new(bodies, &pairs);
        group.bench_function(BenchmarkId::new("order and symbolic", n), |b| b.iter(symbolic));
        // The values do not change the time of a Cholesky factorisation as long as the matrix is
        // definite; with these springs solutions of solutions tend to their mean, not to zero.
        let mut matrix = symbolic();
        let mut values = matrix.assembly();
        for body in 0..bodies {
            (0..3).for_each(|k| values.add_diagonal(body, k, 1.0));
        }
        let spring = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let away = spring.map(|row| row.map(|x: f64| -x));
        for k in 0..pairs.len() {
            values.add(k, &[spring, away], &spring);
        }
        let order = matrix.order().to_vec();
        let load = |i: usize| 1.0 + (i % 7) as f64;
        let rows = |i: usize| [3 * i, 3 * i + 1, 3 * i + 2];
        let mut x: Vec<_> = order.iter().map(|i| rows(*i).map(load)).collect();
        assert!(matrix.factorise_and_solve(&mut x));
        let mut other = FaerCholesky::new(bodies, &pairs, 1.0);
        let mut y = Mat::from_fn(3 * bodies, 1, |i, _| load(i));
        other.factorise();
        other.solve(&mut y);
        let near = |x: f64, row: usize| (y[(row, 0)] - x).abs() < 1e-12 * x;
        assert!(x.iter().zip(&order).all(|(x, i)| (0..3).all(|k| near(x[k], rows(*i)[k]))));
        group.bench_function(BenchmarkId::new("factorise and solve", n), |b| {
            b.iter(|| assert!(matrix.factorise_and_solve(&mut x)));
        });
        group.bench_function(BenchmarkId::new("solve with factor", n), |b| {
            b.iter(|| matrix.solve(&mut x));
        });
        group.bench_function(BenchmarkId::new("factorise and solve, faer", n), |b| {
            b.iter(|| {
                other.factorise();
                other.solve(&mut y);
            });
        });
        group.bench_function(BenchmarkId::new("solve with factor, faer", n), |b| {
            b.iter(|| other.solve(&mut y));
        });
    }
    group.finish();
}

/// The solver as it comes to a program in a run.
fn warm(problem: &Captured) -> Condensed {
    let mut solver = Condensed::default();
    if let Some(before) = &problem.before {
        solver.solve(before, 0.0).unwrap_or_else(|e| panic!("{e}"));
    }
    solver
}

fn regimes(c: &mut Criterion) {
    on_one_thread();
    let mut group = c.benchmark_group("solve");
    group.sample_size(10).measurement_time(Duration::from_secs(2));
    group.warm_up_time(Duration::from_millis(200));
    let mut all: Vec<Captured> = Vec::new();
    for tiles in ROCKS {
        let third = [("elastic increment", Moment::Increment("load", 3))];
        all.extend(capture(&rock(tiles), &third).unwrap_or_else(|e| panic!("{e}")));
    }
    let full = std::env::var("CLASTIC_BENCH").is_ok_and(|extent| extent == "full");
    for full in [false, true].into_iter().filter(|f| full || !f) {
        let problems = problems(&scenes(), full).unwrap_or_else(|e| panic!("{e}"));
        // `bounce` has one size.
        let again = |p: &Captured| full && p.name == "bounce";
        all.extend(problems.into_iter().filter(|p| p.name != "elastic increment" && !again(p)));
    }
    for problem in &all {
        let id = BenchmarkId::new(&problem.name, problem.program.bodies.len());
        group.bench_function(id, |b| {
            b.iter_batched_ref(
                || warm(problem),
                |solver| solver.solve(&problem.program, 0.0),
                BatchSize::PerIteration,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, detection_and_assembly, regimes);
criterion_main!(benches);
