//! Numerical stress: random scenes, balances, invariance, extremes, long runs, Coulomb's fixed
//! point. A part of the cases runs with every `cargo test`; `CLASTIC_CASES=10000` sets how many
//! random scenes, `CLASTIC_FULL=1` makes long runs long, and `-- --include-ignored` adds the slow
//! ones.

#[path = "../common/mod.rs"]
mod common;

mod coulomb;
mod energy;
mod extremes;
mod invariance;
mod long_runs;
mod momentum;
mod objectivity;
mod oracle;
mod random_rigs;
mod random_scenes;
mod remedies;

use common::random;
