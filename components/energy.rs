//! The energy ledger of a run.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

/// Energy balance of an increment, or of several, J.
///
/// ```text
/// external + gravity + exchange = kinetic + elastic + friction + rolling + dilation + collision + rupture
///                                 + motion + turning + numerical
/// ```
///
/// up to [`error`](Self::error), which comes from the residuals of the solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Energies {
    /// Work of walls, imposed motion and applied loads.
    pub external: f64,
    /// Work of gravity.
    pub gravity: f64,
    /// Energy that added bodies bring minus energy that removed bodies take: kinetic energy, and
    /// elastic energy of their contacts. Particles that become a rigid group take the kinetic
    /// energy of their motion relative to the group, and the elastic energy of the contacts within
    /// it.
    pub exchange: f64,
    /// Change of the kinetic energy.
    pub kinetic: f64,
    /// Change of the elastic energy of contacts and bonds at the true geometry.
    pub elastic: f64,
    /// Work of sliding: shear force times slip.
    pub friction: f64,
    /// Work of rolling: moment times relative rotation.
    pub rolling: f64,
    /// Work of opening gaps by the dilation of the associated law, minus the work of closing them
    /// again. It is negative where gaps close. 0 under Coulomb's law, and for rigid contacts in
    /// dynamics.
    pub dilation: f64,
    /// Energy dissipated by normal impulses: impulse times the mean of the closing velocities
    /// before and after.
    pub collision: f64,
    /// Energy dissipated by bonds: work at the tension limit, and the stored energy that rupture
    /// releases.
    pub rupture: f64,
    /// Kinetic energy that static analysis removes: that of followed motions, and that of the jump
    /// to equilibrium after a rupture or a sudden load.
    pub motion: f64,
    /// Work that contact forces seem to do because an increment holds normals constant that turn.
    /// It tends to zero with the size of the increment.
    pub turning: f64,
    /// Energy dissipated by the time integration: damping with theta > 1/2, contacts that open,
    /// close or begin to slide within an increment, and cementing.
    pub numerical: f64,
}

impl Energies {
    /// Error of the balance: supplied energy minus all the terms that receive it.
    pub fn error(&self) -> f64 {
        let [external, gravity, exchange, received @ ..] = self.to_array();
        external + gravity + exchange - received.iter().sum::<f64>()
    }

    /// Sum of the absolute values of all terms, to which the error is compared.
    pub fn throughput(&self) -> f64 {
        self.to_array().iter().map(|e| e.abs()).sum()
    }

    /// All terms, J, in the order of the fields.
    pub fn to_array(&self) -> [f64; 13] {
        let mut terms = *self;
        terms.terms_mut().map(|term| *term)
    }

    fn terms_mut(&mut self) -> [&mut f64; 13] {
        [
            &mut self.external,
            &mut self.gravity,
            &mut self.exchange,
            &mut self.kinetic,
            &mut self.elastic,
            &mut self.friction,
            &mut self.rolling,
            &mut self.dilation,
            &mut self.collision,
            &mut self.rupture,
            &mut self.motion,
            &mut self.turning,
            &mut self.numerical,
        ]
    }
}

impl std::ops::AddAssign for Energies {
    fn add_assign(&mut self, other: Self) {
        for (own, other) in self.terms_mut().into_iter().zip(other.to_array()) {
            *own += other;
        }
    }
}

/// The ledger. Energies are computed only in a world that has this resource.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct EnergyLedger {
    /// Energies of the last increment.
    pub increment: Energies,
    /// Energies since the start, or since the last compaction. A compaction has no energies.
    pub total: Energies,
    /// Elastic energy now, J; `None` before the first increment.
    pub stored: Option<f64>,
    /// Kinetic energy now, J; `None` before the first increment.
    pub kinetic: Option<f64>,
    /// Bodies that have come or gone since the last increment.
    pub changed: Changed,
    /// Forces that the ruptures of the last increment removed, sorted by pair.
    pub released: Vec<Released>,
}

/// Bodies that have come or gone between two increments.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Changed {
    /// None.
    #[default]
    Nothing,
    /// Some have come, and none has gone.
    Came,
    /// Some bodies have gone, so that others are out of balance.
    Went,
}

/// The force that a pair lost when its bond broke.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Released {
    /// Row of the first body.
    pub a: u32,
    /// Row of the second body.
    pub b: u32,
    /// (p, q, tau) of the bond minus those of the remaining contact, N, N, N m.
    pub forces: [f64; 3],
}

/// Energies of the motions that were followed in the current increment. The ledger takes them over
/// when the increment is committed.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct MotionEnergies {
    /// Sum over the steps of the motions.
    pub energies: Energies,
    /// Elastic energy after the last step, J; `None` before the first.
    pub stored: Option<f64>,
}
