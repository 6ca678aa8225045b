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

pub mod interior;
pub mod local;
pub mod matrix;
pub mod newton;
mod parallel;
pub mod reduced;
pub mod rest;
pub mod scaled;
pub mod settings;
mod sweeps;
mod warm;

use crate::program::{ConeProgram, ConeSolution, SolveStatus};

use self::matrix::{BodyMatrix, places};
use self::parallel::in_pool;
use self::reduced::Reduced;
use self::scaled::Scaled;
pub use self::settings::CondensedSettings;
use super::clarabel::Clarabel;
use super::lowering::{lower, polish, units};
use super::polish::Point;
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

    /// Residual that is accepted of a program: what the program says is good enough, if that is more than
    /// the solver's own.
    fn tolerance(&self, program: &ConeProgram) -> f64 {
        self.settings.tolerance.max(self.settings.safety * program.tolerance)
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
        let tolerance = self.tolerance(program);
        let settings = self.settings;
        let loose = tolerance > settings.loose_tolerance;
        let goal = |margin: f64| (tolerance / margin).max(ROUND_OFF);
        let newton_margin =
            if loose { settings.loose_newton_margin } else { settings.newton_margin };
        let large = program.interactions.len() > settings.large;
        // Which bonds are at a limit is seen of exact forces only, a polish begins with them, and far from
        // them static grains without load float far about. Where there is nothing of that, what is accepted
        // is all that is needed.
        let is_bonded = || program.interactions.iter().any(|c| c.limits.has_strength());
        let at_once = program.is_dynamic() && (loose || (large && !is_bonded()));
        if at_once && let Some(solution) = self.try_warm(program, iterations) {
            return Some(solution);
        }
        self.prepare(program)?;
        let residual = goal(settings.interior_margin);
        let interior_goal = if at_once {
            interior::Goal::enough(residual, tolerance)
        } else {
            interior::Goal::exact(residual)
        };
        let matrix = self.matrix.as_mut()?;
        let order = matrix.order().to_vec();
        let has_branches = !matrix.branches().is_empty();
        let scaled = Scaled::new(program, &order);
        let (du, _) = units(program);
        // A start far away (a grain that settled, another increment) is worse than none.
        let near = |u: &[f64; 3]| u[0].hypot(u[1]) <= settings.max_start * du[0];
        let in_units =
            |u: &[f64; 3]| if near(u) { [0, 1, 2].map(|k| u[k] / du[k]) } else { [0.0; 3] };
        let start: Vec<[f64; 3]> = order.iter().map(|i| in_units(&start[*i])).collect();
        let back = |u: &[[f64; 3]], s: &[[f64; 3]], iterations: u32, message: &str| {
            let mut displacements = vec![[0.0; 3]; order.len()];
            for (u, &i) in u.iter().zip(&order) {
                displacements[i] = [0, 1, 2].map(|k| u[k] * du[k]);
            }
            checked(program, s, displacements, tolerance, iterations, message)
        };
        let mut starts = vec![start];
        if newton::applies(&scaled) {
            let result = in_pool(has_branches, || {
                newton::solve(
                    &scaled,
                    matrix,
                    &starts[0],
                    &settings.newton,
                    &settings.local,
                    goal(newton_margin),
                )
            });
            *iterations += result.iterations;
            let solution = back(&result.u, &result.s, *iterations, "newton");
            if solution.status == SolveStatus::Solved {
                return Some(solution);
            }
            // Where it gave up is a good place for the interior point to begin, mostly.
            starts.insert(0, result.u);
        }
        // Whether a later attempt regularises it.
        let undamped = !scaled.is_damped() && !program.is_dynamic();
        let mut last = None;
        for start in &starts {
            let solved = |point: &interior::Interior| {
                back(&point.u, &point.s, 0, "interior").status == SolveStatus::Solved
            };
            let result = in_pool(has_branches, || {
                interior::solve(&scaled, matrix, start, &settings.interior, interior_goal, solved)
            });
            let Some(result) = result else {
                continue;
            };
            *iterations += result.iterations;
            if result.merit > settings.max_polished_residual && !(large && undamped) {
                continue;
            }
            let solution = back(&result.u, &result.s, *iterations, "interior");
            let solved = solution.status == SolveStatus::Solved;
            let better = |(last, _): &(interior::Interior, _)| result.merit < last.merit;
            if solved || last.as_ref().is_none_or(better) {
                last = Some((result, solution));
            }
            if solved {
                break;
            }
        }
        let (result, mut solution) = last?;
        let enough = large || loose || is_rigid_plastic(program);
        if enough && solution.status == SolveStatus::Solved {
            return Some(solution);
        }
        if large && undamped {
            return Some(solution);
        }
        let low = lower(program);
        let point = lowered_point(&scaled, &order, &low, &result);
        let mut low = low;
        let (rows, variables) = (low.right.len(), low.linear.len());
        let a = std::mem::take(&mut low.matrix).matrix(rows, variables);
        polish(program, &low, &a, point, &settings.polish, &mut solution);
        let r = regularised_residuals(program, &solution.forces, &solution.displacements).worst();
        if r <= tolerance {
            solution.status = SolveStatus::Solved;
            return Some(solution);
        }
        None
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

/// Whether bonds without compliance make forces and mechanism a matter of choice. The interior point
/// converges to the middle of all choices, where a limit is active only if it is so in all of them:
/// those are the bonds that break. A polish would take it to a corner.
fn is_rigid_plastic(program: &ConeProgram) -> bool {
    program.interactions.iter().any(|c| c.limits.tension > 0.0 && c.normal_compliance == 0.0)
        && !program.is_dynamic()
}

/// The interior point in the numbering of the lowered program.
fn lowered_point(
    scaled: &Scaled,
    order: &[usize],
    low: &super::lowering::Lowered,
    result: &interior::Interior,
) -> Point {
    let mut x = vec![0.0; low.linear.len()];
    let mut z = vec![0.0; low.right.len()];
    let mut row = low.balance_rows;
    for (k, local) in scaled.locals.iter().enumerate() {
        for (column, f) in (low.columns[k]..).zip((0..3).filter(|f| local.has[*f])) {
            x[column] = result.s[k][f];
        }
        for q in 0..local.count {
            z[row] = result.lambda[k][q];
            row += 1;
        }
    }
    let mut column = low
        .columns
        .last()
        .map_or(0, |_| scaled.locals.iter().map(|l| l.has.iter().filter(|h| **h).count()).sum());
    for (rows, i) in low.rows.iter().zip(places(order)) {
        for k in 0..3 {
            if let Some(r) = rows[k] {
                z[r] = -result.u[i][k];
                if scaled.weight[i][k] > 0.0 {
                    x[column] = scaled.weight[i][k].sqrt() * result.u[i][k];
                    column += 1;
                }
            }
        }
    }
    Point { x, z }
}
