//! The condensed solver: the forces of every interaction are eliminated in closed form, which
//! leaves one sparse symmetric positive definite matrix with three unknowns per body.
//!
//! A solve goes through these steps:
//!
//! 1. Bodies at rest keep their forces and are left out (`sleeping`, `reduced`).
//! 2. A dynamic program that may end with the first point within the tolerance is swept from the last
//!    forces (`sweeps`); where that is not enough, the interior point starts there.
//! 3. A program in which every force has a compliance goes to a Newton iteration from the last
//!    displacements (`newton`, `local`): near a solution it takes two factorisations.
//! 4. The [`interior`] point decides all else: solved, collapsed with its mechanism, locked with
//!    its forces, or stalled at the limit of arithmetic.
//!
//! [`settings`] has the numbers that steer these steps, `sweeps` its own.

mod images;
pub mod interior;
mod local;
pub mod matrix;
mod newton;
mod parallel;
mod posed;
mod reduced;
pub mod response;
pub mod scaled;
pub mod settings;
pub mod sleeping;
mod spring;
pub mod sweeps;
#[cfg(test)]
mod tests;

use crate::program::{ConeProgram, ConeSolution, SlidingLaw, SolveStatus};

use self::matrix::BodyMatrix;
use self::posed::{Demand, Posed};
use self::reduced::Reduced;
use self::scaled::forces_in_units;
pub use self::settings::CondensedSettings;
use super::residuals::settle;
use super::solver::{ConeSolver, MalformedProgram};

/// Minimum residual that the Newton iteration and the interior point can reach.
const ROUND_OFF: f64 = 1e-14;

/// Minimum force that residuals of the methods are relative to. Where no contact carries a force the
/// loads count, and these are of the order of 1.
const MIN_FORCE: f64 = 1e-3;

/// The condensed solver. It keeps the matrix of the last pairs and the last solution.
#[derive(Default)]
pub struct Condensed {
    settings: CondensedSettings,
    matrix: BodyMatrix,
    /// Displacements of the last solution by body, m and rad: the start of the next solve.
    last: Vec<[f64; 3]>,
}

impl Condensed {
    /// A solver with these settings.
    pub fn new(settings: CondensedSettings) -> Self {
        Self { settings, ..Self::default() }
    }
}

impl ConeSolver for Condensed {
    fn solve(
        &mut self,
        program: &ConeProgram,
        tolerance: f64,
    ) -> Result<ConeSolution, MalformedProgram> {
        if self.last.len() != program.bodies.len() {
            self.last = vec![[0.0; 3]; program.bodies.len()];
        }
        let asleep = sleeping::find(program, &self.last);
        let awake = asleep.map(|asleep| self.solve_awake(program, tolerance, asleep));
        let mut solution = awake.unwrap_or_default();
        if solution.status != SolveStatus::Solved {
            let spent = solution.iterations;
            solution = self.solve_reduced(program, tolerance, vec![false; program.bodies.len()]);
            solution.iterations += spent;
        }
        if solution.status == SolveStatus::Solved {
            self.last.clone_from(&solution.displacements);
        }
        Ok(solution)
    }

    fn first_point_suffices(&self, program: &ConeProgram, tolerance: f64) -> bool {
        Demand::of(program, tolerance, &self.settings).at_once
    }

    // The matrix follows from the pairs alone: its order and pattern are no memory.
    fn memory(&self) -> &[[f64; 3]] {
        &self.last
    }

    fn remember(&mut self, memory: &[[f64; 3]]) {
        self.last = memory.to_vec();
    }
}

impl Condensed {
    /// Solves the program with the bodies `asleep` left out. The result is solved if it is a
    /// solution of the whole program.
    fn solve_awake(
        &mut self,
        program: &ConeProgram,
        tolerance: f64,
        asleep: Vec<bool>,
    ) -> ConeSolution {
        let mut bodies = program.bodies.iter().zip(&asleep);
        let mut solution = if bodies.all(|(body, asleep)| *asleep || !body.is_free()) {
            let mut forces = program.last_forces.clone();
            forces.resize(program.interactions.len(), [0.0; 3]);
            let displacements = program.imposed();
            let message = "at rest".to_owned();
            let status = SolveStatus::Solved;
            ConeSolution { status, forces, displacements, message, ..Default::default() }
        } else {
            self.solve_reduced(program, tolerance, asleep)
        };
        if solution.status == SolveStatus::Solved {
            // The committed motion follows from the forces, and the forces of bodies at rest are
            // not exact.
            let tolerance = Demand::of(program, tolerance, &self.settings).tolerance;
            settle(program, &mut solution, tolerance);
        }
        solution
    }

    /// Solves a program without bodies at rest and without interactions whose forces are known.
    fn solve_reduced(
        &mut self,
        program: &ConeProgram,
        tolerance: f64,
        at_rest: Vec<bool>,
    ) -> ConeSolution {
        match Reduced::new(program, at_rest) {
            Some(part) => {
                let start: Vec<_> = part.bodies.iter().map(|i| self.last[*i]).collect();
                part.expand(program, self.solve_part(&part.program, tolerance, &start))
            }
            None => self.solve_part(program, tolerance, &self.last.clone()),
        }
    }

    /// Solves a program from the displacements `start`, m and rad.
    fn solve_part(
        &mut self,
        program: &ConeProgram,
        tolerance: f64,
        start: &[[f64; 3]],
    ) -> ConeSolution {
        let demand = Demand::of(program, tolerance, &self.settings);
        // Without momentum the last forces do not belong to a continuing motion.
        let continues = !program.last_forces.is_empty() && program.has_momentum();
        let mut swept = (demand.at_once && continues && sweeps::applies(program))
            .then(|| sweeps::sweep(program, SlidingLaw::Associated, demand.tolerance));
        if let Some(solution) = swept.take_if(|s| s.status == SolveStatus::Solved) {
            return solution;
        }
        let mut posed = Posed::new(program, &self.settings, &mut self.matrix, demand);
        if let Some(swept) = swept {
            // The program is dynamic: no proof of a collapse is sought.
            let start = posed.in_units(&swept.displacements);
            let forces = forces_in_units(program, &swept.forces);
            let solution = posed.interior(&start, Some(&forces), false, "interior after sweeps");
            if solution.status == SolveStatus::Solved {
                return solution;
            }
        }
        let (mut start, mut forces) = (posed.in_units(start), None);
        if newton::applies(&posed.scaled) {
            let (result, solution) = posed.newton(&start);
            if solution.status == SolveStatus::Solved {
                return solution;
            }
            // The point where the iteration gave up is mostly a better start than the last
            // solution.
            start = result.u;
        } else if is_elastic_step(program, demand) {
            // The last step of the motion has moved the bodies to their present places: its forces
            // belong to a displacement of zero.
            start.fill([0.0; 3]);
            forces = Some(forces_in_units(program, &program.last_forces));
        }
        let seeks_proofs = posed.needs_proofs();
        posed.interior(&start, forces.as_deref(), seeks_proofs, "interior")
    }
}

/// Whether a program is an elastic step of a followed motion: static, with a weight on every degree
/// of freedom and a loose tolerance. The last forces are those after the preceding step.
/// Elastic interactions carry them at zero displacement, so that only the balance is violated
/// there. Forces of rigid interactions need not be unique.
fn is_elastic_step(program: &ConeProgram, demand: Demand) -> bool {
    demand.loose
        && !program.last_forces.is_empty()
        && !program.is_dynamic()
        && program.is_damped()
        && program.interactions.iter().all(|c| c.normal_compliance > 0.0)
}
