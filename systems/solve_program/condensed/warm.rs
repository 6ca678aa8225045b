//! The warm start of dynamic programs whose interactions are contacts without strength: sweeps from the forces of the
//! last increment, and the interior point from there, on the contacts that are near.

use clastic_components::program::{ConeProgram, ConeSolution, Dof, SolveStatus};

use super::super::displacements_from_forces;
use super::super::lowering::units;
use super::super::residuals::regularised_residuals;
use super::parallel::in_pool;
use super::scaled::Scaled;
use super::{Condensed, INTERIOR_MARGIN, ROUND_OFF, interior, sweeps};

/// Sweeps before the interior point. Measured on the collapse of 5000 disks: half of them leaves one factorisation
/// more, twice as many save none.
const SWEEPS: usize = 40;
/// A contact without force is left out where its gap is larger than this part of the largest displacement.
const FAR: f64 = 0.06;
/// Products that the interior point starts with, in units of force times displacement. Smaller ones get stuck at
/// the wrong limits, larger ones forget the start.
const PRODUCT: f64 = 3e-4;
/// Times that contacts which were left out and are needed are taken back.
const RETURNS: usize = 2;

impl Condensed {
    /// Solves the program from the forces of the last increment. `None` where that does not apply or does not lead to a
    /// solution; `iterations` were spent in any case.
    pub(super) fn try_warm(
        &mut self,
        program: &ConeProgram,
        iterations: &mut u32,
    ) -> Option<ConeSolution> {
        // What has no momentum was not on its way before: the last forces are none of its.
        if program.last_forces.is_empty() || !has_momentum(program) {
            return None;
        }
        let natural: Vec<usize> = (0..program.bodies.len()).collect();
        let scaled = Scaled::new(program, &natural);
        if !sweeps::applies(&scaled) {
            return None;
        }
        let tolerance = self.tolerance(program);
        let (_, df) = units(program);
        let unit = [df[0], df[0], df[2]];
        let evaluate = |forces: &[[f64; 3]], iterations: u32, message: &str| {
            let mut solution = ConeSolution {
                status: SolveStatus::Stalled,
                displacements: program.imposed(),
                forces: forces.iter().map(|s| [0, 1, 2].map(|f| s[f] * unit[f])).collect(),
                iterations,
                message: message.to_owned(),
                ..ConeSolution::default()
            };
            displacements_from_forces(program, &mut solution);
            let r = regularised_residuals(program, &solution.forces, &solution.displacements);
            if r.worst() <= tolerance {
                solution.status = SolveStatus::Solved;
            }
            solution
        };
        let mut last: Vec<[f64; 3]> =
            program.last_forces.iter().map(|f| [0, 1, 2].map(|k| f[k] / unit[k])).collect();
        last.resize(program.interactions.len(), [0.0; 3]);
        let (mut s, mut u) = sweeps::sweep(&scaled, &last, SWEEPS);
        let solution = evaluate(&s, *iterations, "sweeps");
        if solution.status == SolveStatus::Solved {
            return Some(solution);
        }
        let largest = u.iter().map(|u| u[0].hypot(u[1])).fold(0.0, f64::max);
        let gaps =
            |u: &[[f64; 3]]| -> Vec<f64> { scaled.locals.iter().map(|l| gap(l, u)).collect() };
        let near = |gap: &f64, s: &[f64; 3]| s[0] > 0.0 || *gap < FAR * largest;
        let mut keep: Vec<bool> = gaps(&u).iter().zip(&s).map(|(gap, s)| near(gap, s)).collect();
        for _ in 0..=RETURNS {
            let kept: Vec<usize> = (0..keep.len()).filter(|k| keep[*k]).collect();
            let part = ConeProgram {
                bodies: program.bodies.clone(),
                interactions: kept.iter().map(|k| program.interactions[*k]).collect(),
                scales: program.scales,
                tolerance: program.tolerance,
                last_forces: Vec::new(),
            };
            self.prepare(&part)?;
            let matrix = self.matrix.as_mut()?;
            let order = matrix.order().to_vec();
            let has_branches = !matrix.branches().is_empty();
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
            let residual = (tolerance / INTERIOR_MARGIN).max(ROUND_OFF);
            let goal = interior::Goal::enough(residual, tolerance);
            let is_enough = |point: &interior::Interior| {
                evaluate(&expand(&point.s), 0, "").status == SolveStatus::Solved
            };
            let warm = interior::Warm { forces: &forces, product: PRODUCT };
            let result = in_pool(has_branches, || {
                interior::solve_from(&own, matrix, &start, Some(warm), goal, is_enough)
            })?;
            *iterations += result.iterations;
            s = expand(&result.s);
            let solution = evaluate(&s, *iterations, "warm");
            if solution.status == SolveStatus::Solved {
                return Some(solution);
            }
            for (i, place) in order.iter().enumerate() {
                u[*place] = result.u[i];
            }
            // Again with what was left out and has closed.
            let closed = gaps(&u);
            if !(0..keep.len()).any(|k| !keep[k] && closed[k] < 0.0) {
                return None;
            }
            for (keep, gap) in keep.iter_mut().zip(&closed) {
                *keep |= *gap < FAR * largest;
            }
        }
        None
    }
}

/// Whether any body was in motion when the increment began.
fn has_momentum(program: &ConeProgram) -> bool {
    let moves = |dof: &Dof| matches!(dof, Dof::Free(free) if free.momentum != 0.0);
    program.bodies.iter().flat_map(|body| &body.dofs).any(moves)
}

/// Gap of a contact under the associated law, in units of displacement.
fn gap(local: &super::scaled::Local, u: &[[f64; 3]]) -> f64 {
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
