//! A body of the program, and its degrees of freedom.

use glam::DVec2;
use serde::{Deserialize, Serialize};

/// One degree of freedom of a body of the program.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Dof {
    /// Its displacement is known: imposed, held, or zero because no force acts on it.
    Fixed(f64),
    /// Its displacement is unknown and its balance is a row of the program.
    Free(FreeDof),
}

/// A degree of freedom with a balance row `inertia u + proximal (u - reference) + G f = load`.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct FreeDof {
    /// Load: applied force plus gravity plus, in dynamics, `inertia v_0 dt`; N or N m.
    pub load: f64,
    /// The part `inertia v_0 dt` of the load. It stands for the motion at the start of the
    /// increment and counts as no force in the residuals.
    pub momentum: f64,
    /// Inertia `m / (theta dt^2)`, N/m (moments: N m/rad); 0 in static analysis.
    pub inertia: f64,
    /// Weight of the regularisation of a motion without stiffness, N/m (N m/rad); 0 otherwise.
    /// Its force is an error of the balance and is counted as such in the residuals.
    pub proximal: f64,
    /// Motion that the regularisation pulls to, m (rad).
    pub reference: f64,
}

/// A body of the program. Its translations are along `axis` and along `axis` turned by +90
/// degrees, so that a wall that moves along its normal has one translation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct ProgramBody {
    /// Unit vector of the first translation.
    pub axis: DVec2,
    /// First translation, second translation, rotation.
    pub dofs: [Dof; 3],
}

impl ProgramBody {
    /// Whether any of its displacements is unknown.
    pub fn is_free(&self) -> bool {
        self.free().next().is_some()
    }

    /// Its degrees of freedom whose displacements are unknown, with their numbers.
    pub fn free(&self) -> impl Iterator<Item = (usize, &FreeDof)> {
        let dofs = self.dofs.iter().enumerate();
        dofs.filter_map(|(k, dof)| if let Dof::Free(free) = dof { Some((k, free)) } else { None })
    }

    /// A displacement in the body's own axes turned into (x, y, rotation).
    pub fn to_global(&self, local: [f64; 3]) -> [f64; 3] {
        let v = self.axis * local[0] + self.axis.perp() * local[1];
        [v.x, v.y, local[2]]
    }
}
