//! The methods by which one program is solved, in order: Newton iteration, interior point, polish.

use super::interior::{self, Interior};
use super::local;
use super::matrix::{BodyMatrix, places};
use super::newton::Newton;
use super::parallel::in_pool;
use super::scaled::Scaled;
use super::settings::CondensedSettings;
use super::warm::raised;
use super::{ROUND_OFF, checked};
use crate::lowering::{Lowered, lower, polish, units};
use crate::polish::Point;
use crate::program::{ConeProgram, ConeSolution, SolveStatus};
use crate::residuals::{MAX_BALANCE, regularised_residuals};

/// Requirements on a solution.
#[derive(Clone, Copy, Debug)]
pub struct Demand {
    /// Maximum residual.
    pub tolerance: f64,
    /// Whether the tolerance is loose.
    pub loose: bool,
    /// Whether the program is large.
    pub large: bool,
    /// Whether the first point within the tolerance suffices. It does not suffice in statics, where
    /// grains without load drift further the less exact the solution is. With a
    /// tight tolerance it does not suffice with bonds either, because only exact forces show which
    /// bonds are at a limit.
    pub at_once: bool,
}

impl Demand {
    pub fn of(program: &ConeProgram, settings: &CondensedSettings) -> Self {
        let tolerance = settings.tolerance_of(program);
        let loose = tolerance > settings.loose_tolerance;
        let large = program.interactions.len() > settings.large;
        let at_once = program.is_dynamic() && (loose || (large && !program.has_bonds()));
        Self { tolerance, loose, large, at_once }
    }
}

/// Where the interior point begins, in units and order of the matrix.
pub struct Start {
    /// Displacements by body.
    pub displacements: Vec<[f64; 3]>,
    /// Forces by interaction; `None` for forces that follow from the displacements.
    pub forces: Option<Vec<[f64; 3]>>,
}

impl Start {
    /// A start with these displacements.
    pub fn at(displacements: Vec<[f64; 3]>) -> Self {
        Self { displacements, forces: None }
    }
}

/// A program in the units and the order of the matrix.
pub struct Attempt<'a> {
    program: &'a ConeProgram,
    settings: &'a CondensedSettings,
    matrix: &'a mut BodyMatrix,
    demand: Demand,
    order: Vec<usize>,
    is_shared: bool,
    /// The program in the units of its scales.
    pub scaled: Scaled,
    /// Whether the program is static with some bodies that are not regularised. A later attempt
    /// regularises them all.
    is_undamped: bool,
}

impl<'a> Attempt<'a> {
    /// An attempt with a matrix that has the pattern of the program.
    pub fn new(
        program: &'a ConeProgram,
        settings: &'a CondensedSettings,
        matrix: &'a mut BodyMatrix,
        demand: Demand,
    ) -> Self {
        let order = matrix.order().to_vec();
        let is_shared = matrix.is_shared();
        let scaled = Scaled::new(program, &order);
        matrix.set_images(&scaled.images);
        let is_undamped = !scaled.is_damped() && !program.is_dynamic();
        Self { program, settings, matrix, demand, order, is_shared, scaled, is_undamped }
    }

    /// Displacements as a start, in units and order of the matrix; zero for bodies that are too
    /// far.
    pub fn in_units(&self, start: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let (du, _) = units(self.program);
        let is_near = |u: &[f64; 3]| u[0].hypot(u[1]) <= self.settings.max_start * du[0];
        let in_units =
            |u: &[f64; 3]| if is_near(u) { [0, 1, 2].map(|k| u[k] / du[k]) } else { [0.0; 3] };
        self.order.iter().map(|i| in_units(&start[*i])).collect()
    }

    /// The solution with these displacements and forces in units and order of the matrix.
    fn solution(
        &self,
        u: &[[f64; 3]],
        s: &[[f64; 3]],
        iterations: u32,
        message: &str,
    ) -> ConeSolution {
        solution(self.program, &self.order, self.demand.tolerance, u, s, iterations, message)
    }

    /// The residual that a method aims at.
    fn goal(&self, margin: f64) -> f64 {
        (self.demand.tolerance / margin).max(ROUND_OFF)
    }

    /// The Newton iteration with local elimination. Near rest, displacements of the iteration solve
    /// the program, but displacements that follow from its forces do not. The iteration then
    /// continues until the balance conserves momentum.
    pub fn newton(&mut self, start: &[[f64; 3]], iterations: &mut u32) -> (Newton, ConeSolution) {
        let settings = self.settings;
        let margin =
            if self.demand.loose { settings.loose_newton_margin } else { settings.newton_margin };
        let goal = self.goal(margin);
        let (result, solution) = self.newton_to(start, goal, iterations);
        let is_enough = solution.status == SolveStatus::Solved || !result.converged;
        if is_enough || !self.program.is_dynamic() {
            return (result, solution);
        }
        self.newton_to(&result.u, goal.min(MAX_BALANCE / margin), iterations)
    }

    /// The Newton iteration to a goal.
    fn newton_to(
        &mut self,
        start: &[[f64; 3]],
        goal: f64,
        iterations: &mut u32,
    ) -> (Newton, ConeSolution) {
        let settings = self.settings;
        let Self { scaled, matrix, .. } = self;
        let result = in_pool(self.is_shared, || {
            local::solve(scaled, matrix, start, &settings.newton, &settings.local, goal)
        });
        *iterations += result.iterations;
        let solution = self.solution(&result.u, &result.s, *iterations, "newton");
        (result, solution)
    }

    /// The first interior point from any of the starts that is solved, else the one with the
    /// minimum residual; `None` if none is worth a polish.
    pub fn best_interior(
        &mut self,
        starts: &[Start],
        iterations: &mut u32,
    ) -> Option<(Interior, ConeSolution)> {
        let settings = self.settings;
        let residual = self.goal(settings.interior_margin);
        let goal = if self.demand.at_once {
            interior::Goal::enough(residual, self.demand.tolerance)
        } else {
            interior::Goal::exact(residual)
        };
        let mut best: Option<(Interior, ConeSolution)> = None;
        for start in starts {
            let Self { program, scaled, matrix, order, .. } = self;
            let tolerance = self.demand.tolerance;
            let is_solved = |point: &Interior| {
                let found = solution(program, order, tolerance, &point.u, &point.s, 0, "");
                found.status == SolveStatus::Solved
            };
            let result = in_pool(self.is_shared, || {
                let warm = start.forces.as_deref().map(|f| raised(f, &settings.warm));
                let start = &start.displacements;
                interior::solve_from(
                    scaled,
                    matrix,
                    start,
                    warm,
                    &settings.interior,
                    goal,
                    is_solved,
                )
            });
            let Some(result) = result else { continue };
            *iterations += result.iterations;
            if result.merit > settings.max_polished_residual && !self.is_lost(&result) {
                continue;
            }
            let solution = self.solution(&result.u, &result.s, *iterations, "interior");
            let solved = solution.status == SolveStatus::Solved;
            let better = |(best, _): &(Interior, _)| result.merit < best.merit;
            if solved || best.as_ref().is_none_or(better) {
                best = Some((result, solution));
            }
            if solved {
                break;
            }
        }
        best
    }

    /// Whether the solution of an interior point is returned without a polish. A solved program is,
    /// if a polish costs more than it gains or would do harm. An unsolved program is, if Clarabel
    /// does no better.
    pub fn is_final(&self, point: &Interior, solution: &ConeSolution) -> bool {
        let Demand { loose, large, .. } = self.demand;
        let is_solved = solution.status == SolveStatus::Solved;
        (is_solved && (large || loose || is_rigid_plastic(self.program))) || self.is_lost(point)
    }

    /// Whether no other method is asked to solve a program that the interior point has not solved:
    /// it is large, or has bonds and its bodies move so far, without an imposed motion, that its
    /// constant normals do not hold. Its solution would not be accepted. Only Clarabel finds that
    /// rigid bodies are locked.
    fn is_lost(&self, point: &Interior) -> bool {
        let scales = &self.program.scales;
        let far = self.settings.max_unsolved_motion * scales.length / scales.displacement;
        let is_far = || point.u.iter().any(|u| u[0].hypot(u[1]) > far);
        let is_elastic = || self.program.interactions.iter().all(|c| c.normal_compliance > 0.0);
        let is_imposed = || self.scaled.known.as_flattened().iter().any(|u| *u != 0.0);
        let falls = || is_far() && !is_imposed() && is_elastic() && self.program.has_bonds();
        self.is_undamped && (self.demand.large || falls())
    }

    /// The solution of an interior point, polished; `None` if its residual is above the tolerance.
    pub fn polished(&self, point: &Interior, mut solution: ConeSolution) -> Option<ConeSolution> {
        let program = self.program;
        let mut low = lower(program);
        let point = lowered_point(&self.scaled, &self.order, &low, point);
        let (rows, variables) = (low.right.len(), low.linear.len());
        let a = std::mem::take(&mut low.matrix).matrix(rows, variables);
        polish(program, &low, &a, point, &self.settings.polish, &mut solution);
        let r = regularised_residuals(program, &solution.forces, &solution.displacements).worst();
        (r <= self.demand.tolerance).then(|| {
            solution.status = SolveStatus::Solved;
            solution
        })
    }
}

/// The solution with displacements and forces in units and order of the matrix.
fn solution(
    program: &ConeProgram,
    order: &[usize],
    tolerance: f64,
    u: &[[f64; 3]],
    s: &[[f64; 3]],
    iterations: u32,
    message: &str,
) -> ConeSolution {
    let (du, _) = units(program);
    let mut displacements = vec![[0.0; 3]; order.len()];
    for (u, &i) in u.iter().zip(order) {
        displacements[i] = [0, 1, 2].map(|k| u[k] * du[k]);
    }
    checked(program, s, displacements, tolerance, iterations, message)
}

/// Whether forces and mechanism are not unique, because bonds have no compliance. The interior
/// point converges to the middle of all solutions, where a limit is active only if it is active in
/// all of them: these bonds break. A polish would move the solution to a corner.
fn is_rigid_plastic(program: &ConeProgram) -> bool {
    program.interactions.iter().any(|c| c.limits.tension > 0.0 && c.normal_compliance == 0.0)
        && !program.is_dynamic()
}

/// The interior point in the numbering of the lowered program.
fn lowered_point(scaled: &Scaled, order: &[usize], low: &Lowered, result: &Interior) -> Point {
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

#[cfg(test)]
mod tests {
    use super::super::samples::{column, posed};
    use super::*;
    use crate::program::Dof;

    /// Whether a program is lost with its bodies moved by this many lengths.
    fn is_lost(program: &ConeProgram, lengths: f64) -> bool {
        let (settings, (scaled, mut matrix, _)) = (CondensedSettings::default(), posed(program));
        let demand = Demand::of(program, &settings);
        let point = Interior {
            u: vec![[lengths * program.scales.length / program.scales.displacement, 0.0, 0.0]; 3],
            s: vec![[0.0; 3]; scaled.locals.len()],
            lambda: vec![[0.0; 4]; scaled.locals.len()],
            iterations: 1,
            merit: 1.0,
        };
        Attempt::new(program, &settings, &mut matrix, demand).is_lost(&point)
    }

    /// Clarabel is not asked for a static program with bonds whose bodies move further than
    /// constant normals hold, unless a motion is imposed, bodies are rigid (they may be locked) or
    /// all are regularised (a solution exists).
    #[test]
    fn bodies_that_move_far_go_to_no_other_solver() {
        let mut elastic = column(2, 1.0);
        elastic.scales.displacement = 1e-3;
        assert!(!is_lost(&elastic, 1.1));
        elastic.interactions[0].limits.tension = 1.0;
        assert!(is_lost(&elastic, 1.1) && !is_lost(&elastic, 0.9));
        let mut driven = elastic.clone();
        driven.bodies[0].dofs[1] = Dof::Fixed(1e-3);
        assert!(!is_lost(&driven, 1.1));
        let mut rigid = column(2, 0.0);
        rigid.scales.displacement = 1e-3;
        rigid.interactions[0].limits.tension = 1.0;
        assert!(!is_lost(&rigid, 1.1));
        for dof in elastic.bodies.iter_mut().flat_map(|body| &mut body.dofs) {
            if let Dof::Free(free) = dof {
                free.proximal = 1.0;
            }
        }
        assert!(!is_lost(&elastic, 1.1));
    }
}
