//! What checks the solvers of [`clastic_cone`]: the reference solver, and programs as JSON for other
//! solvers.
//!
//! [`Clarabel`] is a general interior-point solver, whose solutions are polished. It reads a program
//! in the standard form of a quadratic program, [`ProgramSize`] being its size. A [`dump`] holds a
//! program and its solution.

mod clarabel;
pub mod dump;
mod polish;
mod size;
mod standard_form;

pub use self::clarabel::Clarabel;
pub use self::polish::PolishSettings;
pub use self::size::{ProgramSize, size};
