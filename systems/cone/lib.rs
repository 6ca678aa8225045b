//! The cone program of one increment and its solvers: plain data in, plain data out, no ECS.
//!
//! A [`solver`] reads a [`program::ConeProgram`] and returns a [`program::ConeSolution`], whose
//! status says how the solve ended. [`residuals`] and [`certificate`] are computed from the forces
//! and displacements alone and check that status.
//!
//! To find the algorithm, read
//!
//! 1. [`program`]: the problem;
//! 2. [`condensed`]: the order in which methods are tried on it;
//! 3. [`condensed::interior`]: the method that decides every program: embedding, step and test; and
//!    its `local_system`, by which the forces are eliminated;
//! 4. [`condensed::matrix`]: the linear system that is left, and its factorisation;
//! 5. [`coulomb`]: the same under Coulomb's law;
//! 6. [`residuals`] and [`certificate`]: what counts as a solution and as a proof.
//!
//! ```
//! use clastic_cone::condensed::Condensed;
//! use clastic_cone::program::{ConeProgram, Dof, FreeDof, Interaction, Limits, ProgramBody};
//! use clastic_cone::program::SolveStatus;
//! use clastic_cone::solver::ConeSolver;
//! use glam::DVec2;
//!
//! // A disk of 1 N on a fixed floor; the contact has a compliance of 1e-6 m/N.
//! let still = [Dof::Fixed(0.0); 3];
//! let weight = Dof::Free(FreeDof { load: -1.0, ..FreeDof::default() });
//! let program = ConeProgram {
//!     bodies: vec![
//!         ProgramBody { axis: DVec2::X, dofs: still },
//!         ProgramBody { axis: DVec2::X, dofs: [still[0], weight, still[2]] },
//!     ],
//!     interactions: vec![Interaction {
//!         normal: DVec2::Y,
//!         normal_compliance: 1.0e-6,
//!         limits: Limits::new(0.0, 0.5, 0.0, 0.0),
//!         ..Interaction::between(0, 1)
//!     }],
//!     ..ConeProgram::default()
//! };
//! let solution = Condensed::default().solve(&program, 0.0)?;
//! assert_eq!(solution.status, SolveStatus::Solved);
//! assert!((solution.forces[0][0] - 1.0).abs() < 1.0e-9);
//! assert!((solution.displacements[1][1] + 1.0e-6).abs() < 1.0e-15);
//! # Ok::<(), clastic_cone::solver::MalformedProgram>(())
//! ```

pub mod adjacency;
pub mod certificate;
pub mod condensed;
pub mod coulomb;
mod interaction;
pub mod program;
pub mod residuals;
pub mod solver;
