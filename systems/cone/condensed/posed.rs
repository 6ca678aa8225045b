//! A program in the units and the order of the matrix, and the methods that solve it there: the
//! Newton iteration and the interior point.

use super::ROUND_OFF;
use super::interior::{self, Goal, Interior, Judge};
use super::local;
use super::matrix::BodyMatrix;
use super::newton::Newton;
use super::parallel::in_pool;
use super::scaled::Scaled;
use super::settings::{CondensedSettings, DEFAULT_RESIDUAL};
use crate::certificate::{certificate, locks, proves};
use crate::program::{Certificate, ConeProgram, ConeSolution, Residuals, SolveStatus};
use crate::residuals::{MAX_BALANCE, settle};

/// Requirements on a solution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Demand {
    /// Maximum residual.
    pub tolerance: f64,
    /// Whether the tolerance is looser than that of increments by default: active limits are not
    /// decided, and dynamic programs end with the first point within the tolerance. This saves an
    /// eighth of the iterations in dynamics; in statics it threw grains in 129 of 169 increments
    /// (decision 006).
    pub loose: bool,
    /// Whether the program is large.
    pub large: bool,
    /// Whether the first point within the tolerance suffices. It does not suffice in statics, where
    /// grains without load drift further the less exact the solution is. With a tight tolerance it
    /// does not suffice with bonds either, because only exact forces show which bonds are at a
    /// limit, nor in small programs, where an exact solution costs little.
    pub at_once: bool,
}

impl Demand {
    /// The requirements on the solution of a program that is asked for with this tolerance.
    pub fn of(program: &ConeProgram, tolerance: f64, settings: &CondensedSettings) -> Self {
        let tolerance = settings.tolerance.max(settings.safety * tolerance);
        let loose = tolerance > settings.safety * DEFAULT_RESIDUAL;
        let large = program.interactions.len() > settings.large;
        let at_once = program.is_dynamic() && (loose || (large && !program.has_bonds()));
        Self { tolerance, loose, large, at_once }
    }

    /// The residual that a method aims at.
    pub fn goal(&self, margin: f64) -> f64 {
        (self.tolerance / margin).max(ROUND_OFF)
    }
}

/// A program in the units and the order of the matrix.
pub struct Posed<'a> {
    settings: &'a CondensedSettings,
    matrix: &'a mut BodyMatrix,
    units: Units<'a>,
    iterations: u32,
    /// The program in the units of its scales.
    pub scaled: Scaled,
}

impl<'a> Posed<'a> {
    pub fn new(
        program: &'a ConeProgram,
        settings: &'a CondensedSettings,
        matrix: &'a mut BodyMatrix,
        demand: Demand,
    ) -> Self {
        let scaled = matrix.pose(program);
        let units = Units {
            program,
            order: matrix.order().to_vec(),
            demand,
            is_held: program.is_damped(),
            is_elastic: program.interactions.iter().all(|c| c.normal_compliance > 0.0),
        };
        Self { settings, matrix, units, iterations: 0, scaled }
    }

    /// Displacements as a start, in units and order of the matrix; zero for bodies that are too
    /// far.
    pub(crate) fn in_units(&self, start: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let Units { program, order, .. } = &self.units;
        let (du, _) = program.scales.units();
        let is_near = |u: &[f64; 3]| u[0].hypot(u[1]) <= self.settings.max_start * du[0];
        let in_units =
            |u: &[f64; 3]| if is_near(u) { [0, 1, 2].map(|k| u[k] / du[k]) } else { [0.0; 3] };
        order.iter().map(|i| in_units(&start[*i])).collect()
    }

    /// The Newton iteration with local elimination. Near rest, displacements of the iteration solve
    /// the program, but displacements that follow from its forces do not. The iteration then
    /// continues until the balance conserves momentum.
    pub fn newton(&mut self, start: &[[f64; 3]]) -> (Newton, ConeSolution) {
        let margin = self.settings.margin;
        let goal = self.units.demand.goal(margin);
        let (result, solution) = self.newton_to(start, goal);
        let is_enough = solution.status == SolveStatus::Solved || !result.converged;
        if is_enough || !self.units.program.is_dynamic() {
            return (result, solution);
        }
        self.newton_to(&result.u, goal.min(MAX_BALANCE / margin))
    }

    fn newton_to(&mut self, start: &[[f64; 3]], goal: f64) -> (Newton, ConeSolution) {
        let Self { scaled, matrix, settings, units, .. } = self;
        let result = in_pool(matrix.is_shared(), || {
            local::solve(scaled, matrix, start, &settings.newton, &settings.local, goal)
        });
        self.iterations += result.iterations;
        let mut solution = units.solution(&result.u, &result.s, "newton");
        solution.iterations = self.iterations;
        (result, solution)
    }

    /// Whether the program may have no solution. In statics tau also leads away from a start with the
    /// wrong limits.
    pub(crate) fn needs_proofs(&self) -> bool {
        let Units { program, is_held, is_elastic, .. } = self.units;
        !(is_held && is_elastic && program.is_dynamic())
    }

    /// The interior point from displacements and forces, which follow from the displacements if there
    /// are none: solved, collapsed, locked, or stalled at the limit of arithmetic. An exact solution
    /// of a small program decides of every limit whether it is active.
    pub(crate) fn interior(
        &mut self,
        start: &[[f64; 3]],
        forces: Option<&[[f64; 3]]>,
        seeks_proofs: bool,
        message: &str,
    ) -> ConeSolution {
        let Self { scaled, matrix, settings, units, .. } = self;
        let Demand { tolerance, loose, large, at_once } = units.demand;
        let goal = Goal {
            residual: units.demand.goal(settings.margin * settings.interior.near),
            at_once,
            decided: (!(at_once || loose || large)).then_some(tolerance),
            in_middle: is_rigid_plastic(units.program),
            seeks_proofs,
        };
        let (end, point) = in_pool(matrix.is_shared(), || {
            interior::solve(scaled, matrix, start, forces, &settings.interior, goal, units)
        });
        self.iterations += point.iterations;
        let mut found = units.solution(&point.u, &point.s, message);
        found.iterations = self.iterations;
        if end == SolveStatus::Collapsed {
            found.certificate = units.mechanism(&point.u);
            found.displacements =
                found.certificate.as_ref().map_or_else(Vec::new, |c| c.mechanism.clone());
        }
        // What is proved is not judged by residuals.
        if matches!(end, SolveStatus::Collapsed | SolveStatus::Locked) {
            (found.status, found.residuals) = (end, Residuals::default());
        }
        found
    }
}

/// Whether forces and mechanism are not unique, because bonds have no compliance. The interior
/// point converges to the middle of all solutions, where a limit is active only if it is active in
/// all of them: these bonds break. Deciding limits would move the solution away from there.
fn is_rigid_plastic(program: &ConeProgram) -> bool {
    program.interactions.iter().any(|c| c.limits.tension > 0.0 && c.normal_compliance == 0.0)
        && !program.is_dynamic()
}

/// The units and the order of the matrix, and the program that judges what is found in them.
struct Units<'a> {
    program: &'a ConeProgram,
    order: Vec<usize>,
    demand: Demand,
    /// Whether a weight on every degree of freedom excludes a collapse.
    is_held: bool,
    /// Whether a compliance of every normal force excludes that bodies are locked.
    is_elastic: bool,
}

impl Units<'_> {
    /// Displacements in SI units and the order of the program.
    fn displacements(&self, u: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let (du, _) = self.program.scales.units();
        let mut displacements = vec![[0.0; 3]; self.order.len()];
        for (u, &i) in u.iter().zip(&self.order) {
            displacements[i] = [0, 1, 2].map(|k| u[k] * du[k]);
        }
        displacements
    }

    /// Forces in SI units.
    fn forces(&self, s: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let (_, df) = self.program.scales.units();
        s.iter().map(|s| [0, 1, 2].map(|f| s[f] * df[f])).collect()
    }

    /// The solution with these displacements and forces, solved if its residual is within the
    /// tolerance. With inertia displacements follow from the forces, as those that are committed.
    fn solution(&self, u: &[[f64; 3]], s: &[[f64; 3]], message: &str) -> ConeSolution {
        let mut solution = ConeSolution {
            forces: self.forces(s),
            displacements: self.displacements(u),
            message: message.to_owned(),
            ..ConeSolution::default()
        };
        settle(self.program, &mut solution, self.demand.tolerance);
        solution
    }

    /// The proof of a collapse by these displacements.
    fn mechanism(&self, u: &[[f64; 3]]) -> Option<Certificate> {
        certificate(self.program, &self.displacements(u)).filter(proves)
    }
}

impl Judge for Units<'_> {
    fn is_solution(&self, point: &Interior) -> bool {
        self.solution(&point.u, &point.s, "").status == SolveStatus::Solved
    }

    fn proof(&self, point: &Interior) -> Option<SolveStatus> {
        if !self.is_held && self.mechanism(&point.u).is_some() {
            return Some(SolveStatus::Collapsed);
        }
        let is_lock = !self.is_elastic && locks(self.program, &self.forces(&point.s));
        is_lock.then_some(SolveStatus::Locked)
    }
}
