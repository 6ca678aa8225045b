//! The solution of a program: forces and displacements, their residuals, and the proof of a
//! collapse.

#[cfg(all(feature = "bevy", feature = "reflect"))]
use bevy_ecs::reflect::ReflectResource;
use serde::{Deserialize, Serialize};

use crate::interaction::SlidingLaw;

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum SolveStatus {
    /// Optimal to the residuals that stand beside it.
    Solved,
    /// No forces balance the loads within the limits: the certificate is the mechanism.
    Collapsed,
    /// Rigid bodies with no feasible motion: the forces are unbounded.
    Locked,
    /// Neither was reached.
    #[default]
    Stalled,
}

/// KKT residuals of a solution: the maximum over all rows of each kind, without dimension.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Residuals {
    /// |balance row| over the maximum force (moments: over force x mean radius).
    pub balance: f64,
    /// |stationarity row| over the maximum displacement.
    pub kinematics: f64,
    /// Violation of a limit over the maximum force.
    pub cone: f64,
    /// Slack x multiplier over force x displacement.
    pub complementarity: f64,
}

impl Residuals {
    /// Maximum of the four; NaN if any of them is not finite.
    pub fn worst(&self) -> f64 {
        let all = [self.balance, self.kinematics, self.cone, self.complementarity];
        // f64::max drops NaN, which would turn a broken solution into a perfect one.
        if all.iter().any(|r| !r.is_finite()) {
            f64::NAN
        } else {
            all.iter().copied().fold(0.0, f64::max)
        }
    }
}

/// Proof that no forces balance the loads: a mechanism along which the loads do more work than
/// the limits can dissipate.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Certificate {
    /// Displacements of the mechanism by body, in the bodies' own axes; the maximum component is 1.
    pub mechanism: Vec<[f64; 3]>,
    /// Work of the loads less the maximum dissipation, over the work of the loads. A positive
    /// margin proves the collapse, up to the defect.
    pub margin: f64,
    /// Maximum violation of the mechanism's kinematic conditions over its maximum motion.
    pub defect: f64,
}

/// The solution of a program.
#[cfg_attr(feature = "bevy", derive(bevy_ecs::prelude::Resource))]
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
#[cfg_attr(all(feature = "bevy", feature = "reflect"), reflect(Resource))]
pub struct ConeSolution {
    /// How it ended.
    pub status: SolveStatus,
    /// The law that the forces and displacements solve.
    pub law: SlidingLaw,
    /// Maximum residual with which it counts as a solution.
    pub tolerance: f64,
    /// The solver's own words about how it ended.
    pub message: String,
    /// Iterations of the solver.
    pub iterations: u32,
    /// Residuals that our own code computed from the forces and displacements.
    pub residuals: Residuals,
    /// (p, q, tau) of every interaction, N, N, N m.
    pub forces: Vec<[f64; 3]>,
    /// Displacements by body in the bodies' own axes, m, m, rad.
    pub displacements: Vec<[f64; 3]>,
    /// Mechanism of a collapse.
    pub certificate: Option<Certificate>,
}
