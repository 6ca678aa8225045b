//! The energy ledger of a run.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

/// Where the energy of an increment, or of many, came from and went to, J.
///
/// `external + gravity = kinetic + elastic + friction + rolling + dilation + rupture + motion + numerical`
/// up to [`error`](Self::error), which is what the solver's residuals leave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies {
    /// Work of walls, imposed motion and applied loads.
    pub external: f64,
    /// Work of gravity.
    pub gravity: f64,
    /// Change of the kinetic energy.
    pub kinetic: f64,
    /// Change of the elastic energy of contacts and bonds at the true geometry.
    pub elastic: f64,
    /// Dissipated by slip, `q s_t`.
    pub friction: f64,
    /// Dissipated by rolling, `tau s_r`.
    pub rolling: f64,
    /// `-p (mu |s_t| + mu_r r |s_r|)`, what the opening of associated friction gives back; 0 under
    /// Coulomb's law.
    pub dilation: f64,
    /// Taken by bonds: at their tension limit, and what was stored when they broke.
    pub rupture: f64,
    /// Kinetic energy that was taken out of motions that were followed within static increments.
    pub motion: f64,
    /// Taken by the scheme: time integration and impact, frozen normals, changes of the
    /// specimen between increments.
    pub numerical: f64,
}

impl Energies {
    /// What does not add up.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.external + self.gravity
            - (self.kinetic
                + self.elastic
                + self.friction
                + self.rolling
                + self.dilation
                + self.rupture
                + self.motion
                + self.numerical)
    }

    /// The sum of the absolute values, by which errors are measured.
    #[must_use]
    pub fn throughput(&self) -> f64 {
        self.all().iter().map(|e| e.abs()).sum()
    }

    fn all(&self) -> [f64; 10] {
        [
            self.external,
            self.gravity,
            self.kinetic,
            self.elastic,
            self.friction,
            self.rolling,
            self.dilation,
            self.rupture,
            self.motion,
            self.numerical,
        ]
    }
}

impl std::ops::AddAssign for Energies {
    fn add_assign(&mut self, other: Self) {
        self.external += other.external;
        self.gravity += other.gravity;
        self.kinetic += other.kinetic;
        self.elastic += other.elastic;
        self.friction += other.friction;
        self.rolling += other.rolling;
        self.dilation += other.dilation;
        self.rupture += other.rupture;
        self.motion += other.motion;
        self.numerical += other.numerical;
    }
}

/// The ledger. It is kept where this resource is in the world, and costs nothing elsewhere.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyLedger {
    /// Of the last increment.
    pub increment: Energies,
    /// Since the start, or since the last compaction, which has no energies.
    pub total: Energies,
    /// Elastic energy now, J; `None` before the first increment.
    pub stored: Option<f64>,
}

/// Energies of the motions that were followed in the increment under way. They join the ledger when it is
/// committed.
#[derive(Resource, Clone, Debug, Default)]
pub struct MotionEnergies {
    /// Sum over the steps.
    pub energies: Energies,
    /// Elastic energy after the last step, J; `None` before the first.
    pub stored: Option<f64>,
}
