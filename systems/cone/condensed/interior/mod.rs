//! The interior-point method: a homogeneous embedding of the program, which always decides.
//!
//! **The problem.** With the forces s of all interactions and the displacements u of all bodies, a
//! solution fulfils
//!
//! ```text
//! M u + G s = f                        balance
//! l + C s - G'u + A'lambda = 0         kinematics
//! A s + w = b,  w, lambda >= 0         limits
//! w lambda = 0                         complementarity, limit by limit
//! ```
//!
//! Then the duality gap `f'u - l's - b'lambda - u'M u - s'C s` vanishes. Where no solution exists
//! the iterates of a plain interior point grow without bound and prove nothing.
//!
//! **The embedding** (Ye, Todd, Mizuno 1994; Andersen, Ye 1999 for the quadratic terms) multiplies
//! all constants by a variable tau >= 0 and lets the gap be kappa >= 0. It always has a
//! solution, with tau kappa = 0:
//!
//! - tau > 0: the variables over tau solve the program;
//! - kappa > 0: the program has no solution, and the variables prove it: a *mechanism* u on which the
//!   loads do more work than the limits dissipate (`f'u > b'lambda`), or forces s that *lock* rigid
//!   bodies (`-l's > 0`).
//!
//! **The variables** here are those of the embedding over tau, and `k = kappa/tau`. A step of tau,
//! `rho = dtau/tau`, then is a factor in right sides: a step takes `1 + rho` times the residuals
//! and `c + 2 rho w lambda` in place of the products c away, and changes the variables by
//! `dx = y/(1 + rho)` with y its solution. Near a solution rho vanishes and the step is that of the
//! plain method; no large numbers cancel.
//!
//! **The step.** An interaction's forces and multipliers are eliminated through its own small system
//! (`local_system`): `ds = T (G'du) + ds_0`, which leaves `(M + G T G') du = r` for the bodies. One
//! factorisation an iteration serves three right sides: the response A to the residuals, the
//! response B to the products, and the corrector of Mehrotra (1992). The step is
//! `y = (1 + rho) A + (1 + 2 rho) B + corrector`, with rho from the linearised gap.
//!
//! **The test.** A point ends the method if it solves the program within its tolerance. Once kappa >
//! tau, point and step are tested as mechanism and as lock. All three tests are those that the
//! engine makes of a result from any solver.
//!
//! **Limits that are just reached.** Where slack and multiplier of a limit both vanish, both are the
//! root of its product at a point that solves the program. Newton steps that follow decide them: with
//! x the slack less the multiplier, slack and multiplier become the positive and the negative part of
//! x, and the step takes the residuals that this leaves, without regard to the boundary. They use the
//! same elimination and factorisation as an iteration.

mod cell;
mod ending;
mod groups;
mod iteration;
mod law;
mod local_system;
mod point;
mod sums;

use self::ending::Ending;
use self::iteration::Iteration;
pub(crate) use self::law::Variables;
pub use self::point::{Goal, Interior, Judge};
pub(crate) use self::point::{max_magnitude, part_of_way};
use super::matrix::BodyMatrix;
use super::scaled::Scaled;
use super::settings::InteriorSettings;
use crate::program::SolveStatus;

/// Runs the method from displacements and forces, without forces from the elastic trial at the
/// displacements, until the judge accepts a point near the goal or a proof, or the residual no
/// longer falls: the end is then stalled, and the point the best one.
pub fn solve(
    program: &Scaled,
    matrix: &mut BodyMatrix,
    start: &[[f64; 3]],
    forces: Option<&[[f64; 3]]>,
    settings: &InteriorSettings,
    goal: Goal,
    judge: &impl Judge,
) -> (SolveStatus, Interior) {
    let mut iteration = Iteration::new(program, matrix, settings, start, forces, goal.seeks_proofs);
    let mut ending = Ending::new(program, settings, goal, judge);
    let end = loop {
        if let Some(end) = ending.consider(&mut iteration) {
            break end;
        }
        iteration.assemble();
        if !(iteration.respond() && iteration.correct()) {
            break ending.limit();
        }
        iteration.update_residuals();
    };
    let end = match (end, goal.decided) {
        (SolveStatus::Solved, _) if goal.in_middle => end,
        (SolveStatus::Solved | SolveStatus::Stalled, Some(size)) => {
            ending.decide(&mut iteration, size)
        }
        _ => end,
    };
    (end, ending.into_point(end))
}
