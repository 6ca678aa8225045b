//! The dedicated solver: contact forces eliminated contact by contact, one sparse symmetric
//! positive definite matrix of three unknowns per body.
//!
//! Where everything is elastic a warm [`newton`] iteration in the displacements comes first: near
//! the last increment's solution it needs a few factorisations. Otherwise, and where it does not
//! converge, a primal-dual [`interior`] point method finds the active limits, and the
//! [`polish`](super::polish) makes the solution exact. Clarabel is the last resort, and its word
//! on infeasible programs stands only with a certificate.
//!
//! A large dynamic program without bonds, of which the first solution within the tolerance is enough, has a
//! warm start (`warm`) before all this: sweeps from the last forces.

mod attempt;
pub mod interior;
mod line_search;
mod local;
pub mod matrix;
mod newton;
mod parallel;
mod reduced;
mod rest;
pub mod scaled;
pub mod settings;
mod spring;
mod sweeps;
mod warm;

use crate::program::{ConeProgram, ConeSolution, SolveStatus};

use self::attempt::{Attempt, Demand};
use self::matrix::BodyMatrix;
use self::reduced::Reduced;
pub use self::settings::CondensedSettings;
use super::clarabel::Clarabel;
use super::lowering::units;
use super::residuals::regularised_residuals;
use super::solver::{ConeSolver, MalformedProgram};

/// Minimum residual that the Newton iteration and the interior point can reach.
const ROUND_OFF: f64 = 1e-14;

/// The condensed solver with what it keeps between increments.
pub struct Condensed {
    settings: CondensedSettings,
    pairs: Vec<(u32, u32)>,
    matrix: Option<BodyMatrix>,
    /// Displacements of the last solution, m and rad: a starting point.
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

    fn prepare(&mut self, program: &ConeProgram) -> Option<()> {
        let bodies = program.bodies.len();
        let known = program.interactions.iter().map(|c| (c.a, c.b)).eq(self.pairs.iter().copied())
            && self.matrix.as_ref().is_some_and(|m| m.bodies() == bodies);
        if !known {
            self.pairs = program.interactions.iter().map(|c| (c.a, c.b)).collect();
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
        let asleep = rest::find(program, &self.last, &self.settings.rest);
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

    // The matrix follows from the pairs alone: its order and pattern are no memory.
    fn memory(&self) -> &[[f64; 3]] {
        &self.last
    }

    fn remember(&mut self, memory: &[[f64; 3]]) {
        self.last = memory.to_vec();
    }
}

impl Condensed {
    /// Solves what is not at rest. Solved only if that leaves nothing of the whole program open.
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
            // What will be committed: little as they are, forces at rest leave something.
            program.displacements_from_forces(&mut solution);
            let r = regularised_residuals(program, &solution.forces, &solution.displacements);
            if !(r.worst() <= self.tolerance(program)) {
                solution.status = SolveStatus::Stalled;
            }
        }
        Ok(solution)
    }

    /// Solves a program without what is known or at rest.
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

    fn solve_part(
        &mut self,
        program: &ConeProgram,
        start: &[[f64; 3]],
    ) -> Result<ConeSolution, MalformedProgram> {
        let mut spent = 0;
        match self.try_condensed(program, start, &mut spent) {
            Some(solution) => Ok(solution),
            None => {
                let solution = self.fallback.solve(program)?;
                Ok(ConeSolution { iterations: spent + solution.iterations, ..solution })
            }
        }
    }

    /// `None` where the fallback may tell what is the matter; `iterations` were spent in any case.
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
        let mut starts = vec![attempt.in_units(start)];
        if newton::applies(&attempt.scaled) {
            let (result, solution) = attempt.newton(&starts[0], iterations);
            if solution.status == SolveStatus::Solved {
                return Some(solution);
            }
            // Where it gave up is a good place for the interior point to begin, mostly.
            starts.insert(0, result.u);
        }
        let (point, solution) = attempt.best_interior(&starts, iterations)?;
        if attempt.is_final(&solution) {
            Some(solution)
        } else {
            attempt.polished(&point, solution)
        }
    }
}

/// The solution with these forces, in units of the program's scales, and displacements, m and rad: solved if its
/// residual is within the tolerance. Displacements with inertia follow from the forces, as they do in what is committed.
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
    program.displacements_from_forces(&mut solution);
    let r = regularised_residuals(program, &solution.forces, &solution.displacements).worst();
    if r <= tolerance {
        solution.status = SolveStatus::Solved;
    }
    solution
}
