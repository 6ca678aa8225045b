//! The condensed solver: the forces of every interaction are eliminated in closed form, which
//! leaves one sparse symmetric positive definite matrix with three unknowns per body.
//!
//! A solve goes through these steps until one of them has a solution:
//!
//! 1. Bodies at rest keep their forces and are left out (`sleeping`, `reduced`).
//! 2. A dynamic program that may end with the first point within the tolerance has a warm start:
//!    sweeps from the last forces, then the interior point (`warm`, `sweeps`).
//! 3. A program in which every force has a compliance goes to a Newton iteration from the last
//!    displacements (`newton`, `local`).
//! 4. The primal-dual [`interior`] point method finds the active limits. An elastic step of a
//!    followed motion with rolling moments starts it from the last forces (`warm`).
//! 5. The [`polish`](super::polish) solves for the active limits exactly.
//! 6. A search for a mechanism proves that a static program with bonds has no solution
//!    (`collapse`).
//! 7. [Clarabel](super::clarabel) is the fallback. Its verdict on an infeasible program counts only
//!    with a certificate. It is not asked where bonded bodies move too far.
//!
//! [`settings`] has every number that steers these steps.

mod attempt;
mod collapse;
pub mod images;
pub mod interior;
mod line_search;
mod local;
pub mod matrix;
mod newton;
mod parallel;
mod reduced;
mod rolling_spring;
#[cfg(test)]
mod samples;
pub mod scaled;
pub mod settings;
pub mod sleeping;
mod spring;
mod sweeps;
mod warm;

use crate::program::{ConeProgram, ConeSolution, SolveStatus};

use self::attempt::{Attempt, Demand, Start};
use self::matrix::BodyMatrix;
use self::reduced::Reduced;
pub use self::settings::CondensedSettings;
use super::clarabel::Clarabel;
use super::lowering::units;
use super::residuals::choose_displacements;
use super::solver::{ConeSolver, MalformedProgram};

/// Minimum residual that the Newton iteration and the interior point can reach.
const ROUND_OFF: f64 = 1e-14;

/// The condensed solver. It keeps the matrix of the last pairs and the last solution.
pub struct Condensed {
    settings: CondensedSettings,
    pairs: Vec<(u32, u32)>,
    matrix: Option<BodyMatrix>,
    /// Displacements of the last solution by body, m and rad: the start of the next solve.
    last: Vec<[f64; 3]>,
    fallback: Clarabel,
}

impl Default for Condensed {
    fn default() -> Self {
        Self::new(CondensedSettings::default())
    }
}

impl Condensed {
    /// A solver with these settings.
    #[must_use]
    pub fn new(settings: CondensedSettings) -> Self {
        Self {
            settings,
            pairs: Vec::new(),
            matrix: None,
            last: Vec::new(),
            fallback: settings.fallback,
        }
    }

    /// Maximum residual of a solution of a program.
    fn tolerance(&self, program: &ConeProgram) -> f64 {
        self.settings.tolerance_of(program)
    }

    /// Brings the pattern of the matrix up to date; `None` if no order of elimination is found.
    fn prepare(&mut self, program: &ConeProgram) -> Option<()> {
        let bodies = program.bodies.len();
        let pairs = images::pairs(program);
        let known = pairs.clone().eq(self.pairs.iter().copied())
            && self.matrix.as_ref().is_some_and(|m| m.bodies() == bodies);
        if !known {
            self.pairs = pairs.collect();
            self.matrix = BodyMatrix::new(bodies, &self.pairs);
        }
        self.matrix.as_ref().map(|_| ())
    }
}

impl ConeSolver for Condensed {
    fn name(&self) -> &'static str {
        "Condensed"
    }

    fn solve(&mut self, program: &ConeProgram) -> Result<ConeSolution, MalformedProgram> {
        if self.last.len() != program.bodies.len() {
            self.last = vec![[0.0; 3]; program.bodies.len()];
        }
        let asleep = sleeping::find(program, &self.last, &self.settings.sleep);
        let awake = asleep.map(|asleep| self.solve_awake(program, asleep)).transpose()?;
        let spent = awake.as_ref().map_or(0, |solution| solution.iterations);
        let solution = match awake {
            Some(solution) if solution.status == SolveStatus::Solved => solution,
            _ => {
                let whole = self.solve_reduced(program, vec![false; program.bodies.len()])?;
                ConeSolution { iterations: spent + whole.iterations, ..whole }
            }
        };
        if solution.status == SolveStatus::Solved {
            self.last.clone_from(&solution.displacements);
        }
        Ok(solution)
    }

    fn first_point_suffices(&self, program: &ConeProgram) -> bool {
        Demand::of(program, &self.settings).at_once
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
        asleep: Vec<bool>,
    ) -> Result<ConeSolution, MalformedProgram> {
        let mut bodies = program.bodies.iter().zip(&asleep);
        let mut solution = if bodies.all(|(body, asleep)| *asleep || !body.is_free()) {
            let mut forces = program.last_forces.clone();
            forces.resize(program.interactions.len(), [0.0; 3]);
            let displacements = program.imposed();
            let message = "at rest".to_owned();
            let status = SolveStatus::Solved;
            ConeSolution { status, forces, displacements, message, ..Default::default() }
        } else {
            self.solve_reduced(program, asleep)?
        };
        if solution.status == SolveStatus::Solved {
            // The committed motion follows from the forces, and the forces of bodies at rest are
            // not exact.
            let r = choose_displacements(program, &mut solution, self.tolerance(program));
            if !(r.worst() <= self.tolerance(program)) {
                solution.status = SolveStatus::Stalled;
            }
        }
        Ok(solution)
    }

    /// Solves a program without bodies at rest and without interactions whose forces are known.
    fn solve_reduced(
        &mut self,
        program: &ConeProgram,
        at_rest: Vec<bool>,
    ) -> Result<ConeSolution, MalformedProgram> {
        match Reduced::new(program, at_rest) {
            Some(part) => {
                let start: Vec<_> = part.bodies.iter().map(|i| self.last[*i]).collect();
                Ok(part.expand(program, self.solve_part(&part.program, &start)?))
            }
            None => {
                let start = std::mem::take(&mut self.last);
                let solution = self.solve_part(program, &start);
                self.last = start;
                solution
            }
        }
    }

    /// Solves a program from the displacements `start`, m and rad, with the fallback where needed.
    fn solve_part(
        &mut self,
        program: &ConeProgram,
        start: &[[f64; 3]],
    ) -> Result<ConeSolution, MalformedProgram> {
        let mut spent = 0;
        let found = self.try_condensed(program, start, &mut spent);
        let is_large = program.interactions.len() > self.settings.large;
        match found {
            Some(solution) if is_large || solution.status == SolveStatus::Solved => Ok(solution),
            unsolved => {
                if let Some(collapse) = self.try_proof(program, &mut spent) {
                    return Ok(collapse);
                }
                let solution = match unsolved {
                    Some(solution) => ConeSolution { iterations: 0, ..solution },
                    None => self.fallback.solve(program)?,
                };
                Ok(ConeSolution { iterations: spent + solution.iterations, ..solution })
            }
        }
    }

    /// Tries all methods that may solve the program, but the fallback; `None` if the fallback may
    /// solve it. Adds the factorisations to `iterations` in any case.
    fn try_condensed(
        &mut self,
        program: &ConeProgram,
        start: &[[f64; 3]],
        iterations: &mut u32,
    ) -> Option<ConeSolution> {
        if program.interactions.is_empty() {
            return None;
        }
        let demand = Demand::of(program, &self.settings);
        if demand.at_once
            && let Some(solution) = self.try_warm(program, iterations)
        {
            return Some(solution);
        }
        self.prepare(program)?;
        let mut attempt = Attempt::new(program, &self.settings, self.matrix.as_mut()?, demand);
        let mut starts = vec![Start::at(attempt.in_units(start))];
        if newton::applies(&attempt.scaled) {
            let (result, solution) = attempt.newton(&starts[0].displacements, iterations);
            if solution.status == SolveStatus::Solved {
                return Some(solution);
            }
            // The point where the iteration gave up is mostly a better start than the last
            // solution.
            starts.insert(0, Start::at(result.u));
        } else if warm::is_elastic_step(program, &attempt.scaled) {
            // The last step of the motion has moved the bodies to their present places: its forces
            // belong to a displacement of zero.
            let displacements = vec![[0.0; 3]; program.bodies.len()];
            let forces = Some(warm::last_forces(program));
            starts.insert(0, Start { displacements, forces });
        }
        let (point, solution) = attempt.best_interior(&starts, iterations)?;
        if attempt.is_final(&point, &solution) {
            Some(solution)
        } else {
            attempt.polished(&point, solution)
        }
    }
}

/// The solution with these forces, in units of the program's scales, and displacements, m and rad.
/// It is solved if its residual is within the tolerance. Displacements with inertia follow from the
/// forces, as in the motion that is committed.
fn checked(
    program: &ConeProgram,
    forces: &[[f64; 3]],
    displacements: Vec<[f64; 3]>,
    tolerance: f64,
    iterations: u32,
    message: &str,
) -> ConeSolution {
    let (_, df) = units(program);
    let mut solution = ConeSolution {
        status: SolveStatus::Stalled,
        forces: forces.iter().map(|s| [s[0] * df[0], s[1] * df[0], s[2] * df[2]]).collect(),
        displacements,
        iterations,
        message: message.to_owned(),
        ..ConeSolution::default()
    };
    if choose_displacements(program, &mut solution, tolerance).worst() <= tolerance {
        solution.status = SolveStatus::Solved;
    }
    solution
}
