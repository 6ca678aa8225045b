//! The energy ledger of a run.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

/// Where the energy of an increment, or of many, came from and went to, J.
///
/// ```text
/// external + gravity = kinetic + elastic + friction + rolling + dilation + collision + rupture + motion + turning
///                      + numerical
/// ```
///
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
    /// Work of sliding: shear force times slip.
    pub friction: f64,
    /// Work of rolling: moment times relative rotation.
    pub rolling: f64,
    /// Work of the gaps that associated friction opens, less what it takes to close them again: negative where they
    /// give back. 0 under Coulomb's law, and for rigid contacts in dynamics.
    pub dilation: f64,
    /// Taken by normal impulses: impulse times the mean of the closing velocities before and after.
    pub collision: f64,
    /// Taken by bonds: at their tension limit, and what was stored when they broke.
    pub rupture: f64,
    /// Kinetic energy that static analysis takes out: of motions that were followed, and of the jumps to the
    /// equilibrium that a rupture or a sudden load calls for.
    pub motion: f64,
    /// Work of forces on normals that turn within an increment, in which they are frozen. It vanishes with the
    /// increment.
    pub turning: f64,
    /// Taken by the scheme: damping of theta > 1/2, contacts that open, close or begin to slide within an increment,
    /// cementing.
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
                + self.collision
                + self.rupture
                + self.motion
                + self.turning
                + self.numerical)
    }

    /// The sum of the absolute values, by which errors are measured.
    #[must_use]
    pub fn throughput(&self) -> f64 {
        self.all().iter().map(|e| e.abs()).sum()
    }

    fn all(&self) -> [f64; 12] {
        [
            self.external,
            self.gravity,
            self.kinetic,
            self.elastic,
            self.friction,
            self.rolling,
            self.dilation,
            self.collision,
            self.rupture,
            self.motion,
            self.turning,
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
        self.collision += other.collision;
        self.rupture += other.rupture;
        self.motion += other.motion;
        self.turning += other.turning;
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
    /// Forces that ended with the bonds which the last increment broke, sorted by pair.
    pub released: Vec<Released>,
}

/// The force that a contact lost when its bond broke.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Released {
    /// Row of the first body.
    pub a: u32,
    /// Row of the second body.
    pub b: u32,
    /// (p, q, tau) of the bond less those of the contact that is left, N, N, N m.
    pub forces: [f64; 3],
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
