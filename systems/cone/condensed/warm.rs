//! The warm start of dynamic programs whose interactions are contacts without strength: sweeps from
//! the forces of the last increment, and the interior point from there, on the contacts that are
//! near. Elastic steps of a motion that is followed start from the last forces as well, without
//! sweeps and with all contacts.

use crate::program::{ConeProgram, ConeSolution, SlidingLaw, SolveStatus};

use super::interior::{self, Interior};
use super::parallel::in_pool;
use super::posed::Demand;
use super::scaled::{Local, Scaled};
use super::settings::WarmSettings;
use super::{Condensed, checked, prepare, sweeps};

impl Condensed {
    /// Solves the program from the forces of the last increment. `None` where that does not apply
    /// or does not lead to a solution. Adds the factorisations to `iterations` in any case.
    pub(super) fn try_warm(
        &mut self,
        program: &ConeProgram,
        demand: Demand,
        iterations: &mut u32,
    ) -> Option<ConeSolution> {
        // Without momentum the last forces do not belong to a continuing motion. Sweeps do not
        // handle images.
        if program.last_forces.is_empty() || !program.has_momentum() || program.cell.is_some() {
            return None;
        }
        let natural: Vec<usize> = (0..program.bodies.len()).collect();
        let scaled = Scaled::new(program, &natural);
        if !sweeps::applies(&scaled) {
            return None;
        }
        let evaluate = |s: &[[f64; 3]], iterations: u32, message: &str| {
            let u = program.imposed();
            let solution = checked(program, s, u, demand.tolerance, iterations, message);
            (solution.status == SolveStatus::Solved).then_some(solution)
        };
        let (mut s, mut u) = sweeps::sweep(&scaled, SlidingLaw::Associated, &last_forces(program));
        if let Some(solution) = evaluate(&s, *iterations, "sweeps") {
            return Some(solution);
        }
        let gaps =
            |u: &[[f64; 3]]| -> Vec<f64> { scaled.locals.iter().map(|l| gap(l, u)).collect() };
        let far =
            self.settings.warm.max_gap * u.iter().map(|u| u[0].hypot(u[1])).fold(0.0, f64::max);
        let mut keep: Vec<bool> =
            gaps(&u).iter().zip(&s).map(|(gap, s)| s[0] > 0.0 || *gap < far).collect();
        for _ in 0..=self.settings.warm.max_returns {
            let is_enough = |s: &[[f64; 3]]| evaluate(s, 0, "").is_some();
            *iterations += self.solve_kept(program, demand, &keep, &mut s, &mut u, is_enough)?;
            if let Some(solution) = evaluate(&s, *iterations, "warm") {
                return Some(solution);
            }
            // Solve again with the contacts that were left out and have closed.
            let gaps = gaps(&u);
            if !keep.iter().zip(&gaps).any(|(keep, gap)| !keep && *gap < 0.0) {
                return None;
            }
            for (keep, gap) in keep.iter_mut().zip(&gaps) {
                *keep |= *gap < far;
            }
        }
        None
    }

    /// Sets the forces of all interactions and the displacements of all bodies to those of the
    /// interior point of the kept interactions. Other interactions have no force. Returns the
    /// number of factorisations.
    fn solve_kept(
        &mut self,
        program: &ConeProgram,
        demand: Demand,
        keep: &[bool],
        s: &mut Vec<[f64; 3]>,
        u: &mut [[f64; 3]],
        is_enough: impl Fn(&[[f64; 3]]) -> bool + Sync,
    ) -> Option<u32> {
        let kept: Vec<usize> = (0..keep.len()).filter(|k| keep[*k]).collect();
        let part = ConeProgram {
            bodies: program.bodies.clone(),
            interactions: kept.iter().map(|k| program.interactions[*k]).collect(),
            scales: program.scales,
            last_forces: Vec::new(),
            cell: None,
        };
        let matrix = prepare(&mut self.matrix, &mut self.pairs, &part)?;
        let order = matrix.order().to_vec();
        let is_shared = matrix.is_shared();
        let own = Scaled::new(&part, &order);
        let start: Vec<[f64; 3]> = order.iter().map(|i| u[*i]).collect();
        let forces: Vec<[f64; 3]> = kept.iter().map(|k| s[*k]).collect();
        let expand = |own: &[[f64; 3]]| {
            let mut all = vec![[0.0; 3]; keep.len()];
            for (f, k) in own.iter().zip(&kept) {
                all[*k] = *f;
            }
            all
        };
        let goal = interior::Goal::enough(demand.goal(self.settings.interior_margin));
        let warm = Some(raised(&forces, &self.settings.warm));
        let judge = |point: &Interior| is_enough(&expand(&point.s));
        let (_, result) = in_pool(is_shared, || {
            interior::solve(&own, matrix, &start, warm, &self.settings.interior, goal, &judge)
        });
        *s = expand(&result.s);
        for (place, displacement) in order.iter().zip(&result.u) {
            u[*place] = *displacement;
        }
        Some(result.iterations)
    }
}

/// The start of the interior point with these forces, in units of the scales.
pub(super) fn raised<'a>(forces: &'a [[f64; 3]], settings: &WarmSettings) -> interior::Warm<'a> {
    interior::Warm { forces, product: settings.product }
}

/// Whether a program is an elastic step of a followed motion: static, with a weight on every degree
/// of freedom and a loose tolerance. The last forces are those after the preceding step.
/// Elastic interactions carry them at zero displacement, so that only the balance is violated
/// there. Forces of rigid interactions need not be unique.
pub(super) fn is_elastic_step(program: &ConeProgram, demand: Demand, scaled: &Scaled) -> bool {
    let is_elastic = || program.interactions.iter().all(|c| c.normal_compliance > 0.0);
    demand.loose
        && !program.last_forces.is_empty()
        && !program.is_dynamic()
        && scaled.is_damped()
        && is_elastic()
}

/// Forces that the interactions carried at the end of the last increment, in units of the scales; 0
/// where there was none.
pub fn last_forces(program: &ConeProgram) -> Vec<[f64; 3]> {
    let (_, df) = program.scales.units();
    let in_units = |f: &[f64; 3]| [f[0] / df[0], f[1] / df[0], f[2] / df[2]];
    let mut out: Vec<_> = program.last_forces.iter().map(in_units).collect();
    out.resize(program.interactions.len(), [0.0; 3]);
    out
}

/// Gap of a contact under the associated law, in units of displacement.
fn gap(local: &Local, u: &[[f64; 3]]) -> f64 {
    let e = Scaled::kinematics(local, u);
    let opened: f64 = (0..local.count)
        .map(|q| local.limits[q])
        .map(|row| {
            -row[0]
                * (row[1] * (e[1] - local.linear[1]) + row[2] * (e[2] - local.linear[2])).max(0.0)
        })
        .sum();
    local.linear[0] - e[0] - opened
}
