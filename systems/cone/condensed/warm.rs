//! The warm start of dynamic programs whose interactions are contacts without strength: sweeps from
//! the forces of the last increment, and the interior point from there. Elastic steps of a motion
//! that is followed start from the last forces as well, without sweeps.

use crate::program::{ConeProgram, ConeSolution, SlidingLaw, SolveStatus};

use super::interior::{self, Interior, Warm};
use super::parallel::in_pool;
use super::posed::Demand;
use super::{Condensed, checked, sweeps};

impl Condensed {
    /// Solves the program from the forces of the last increment. `None` where that does not apply
    /// or does not lead to a solution. Adds the factorisations to `iterations` in any case.
    pub(super) fn try_warm(
        &mut self,
        program: &ConeProgram,
        demand: Demand,
        iterations: &mut u32,
    ) -> Option<ConeSolution> {
        // Without momentum the last forces do not belong to a continuing motion.
        let continues = !program.last_forces.is_empty() && program.has_momentum();
        if !continues || !sweeps::applies(program) {
            return None;
        }
        let evaluate = |s: &[[f64; 3]], iterations: u32, message: &str| {
            let u = program.imposed();
            let solution = checked(program, s, u, demand.tolerance, iterations, message);
            (solution.status == SolveStatus::Solved).then_some(solution)
        };
        let (s, u) = sweeps::sweep(program, SlidingLaw::Associated);
        if let Some(solution) = evaluate(&s, *iterations, "sweeps") {
            return Some(solution);
        }
        let matrix = self.matrix.of(program)?;
        let is_shared = matrix.is_shared();
        let own = matrix.pose(program);
        let start: Vec<[f64; 3]> = matrix.order().iter().map(|i| u[*i]).collect();
        let goal = interior::Goal::enough(demand.goal_of_interior(&self.settings));
        let warm = Some(Warm { forces: &s, product: self.settings.warm_product });
        let judge = |point: &Interior| evaluate(&point.s, 0, "").is_some();
        let (_, result) = in_pool(is_shared, || {
            interior::solve(&own, matrix, &start, warm, &self.settings.interior, goal, &judge)
        });
        *iterations += result.iterations;
        evaluate(&result.s, *iterations, "warm")
    }
}

/// Whether a program is an elastic step of a followed motion: static, with a weight on every degree
/// of freedom and a loose tolerance. The last forces are those after the preceding step.
/// Elastic interactions carry them at zero displacement, so that only the balance is violated
/// there. Forces of rigid interactions need not be unique.
pub(super) fn is_elastic_step(program: &ConeProgram, demand: Demand) -> bool {
    let is_elastic = || program.interactions.iter().all(|c| c.normal_compliance > 0.0);
    demand.loose
        && !program.last_forces.is_empty()
        && !program.is_dynamic()
        && program.is_damped()
        && is_elastic()
}

/// Forces that the interactions carried at the end of the last increment, in units of the scales; 0
/// where there was none.
pub fn last_forces(program: &ConeProgram) -> Vec<[f64; 3]> {
    let (_, df) = program.scales.units();
    let in_units = |s: &[f64; 3]| [0, 1, 2].map(|f| s[f] / df[f]);
    let mut out: Vec<_> = program.last_forces.iter().map(in_units).collect();
    out.resize(program.interactions.len(), [0.0; 3]);
    out
}
