//! The cone program and its solvers: matrix, residuals, certificates, and agreement of the solvers.

#[path = "../common/mod.rs"]
mod common;

mod agreement;
mod body_matrix;
mod eccentric;
mod enumeration;
mod lemke;
mod pivoting;
mod reach;
mod settings;
mod solvers;
mod spread;
