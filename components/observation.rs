//! What is observed of an increment: plain data between the systems that measure and those that
//! write.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::attempt::IncrementStatus;
use crate::bond::Rupture;
use clastic_cone::program::Residuals;

/// What a strain measure compares: closing is positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StrainMeasure {
    /// Engineering strain of the distance of two walls along the first one's normal.
    Walls(Entity, Entity),
    /// Engineering strain of the distance of two particles' centres.
    Particles(Entity, Entity),
}

/// What a stress measure is taken from: compression is positive.
#[derive(Clone, Debug, PartialEq)]
pub enum StressMeasure {
    /// Mean normal force on the named walls over a length times the thickness.
    Walls {
        /// The walls; the mean of their forces counts.
        walls: Vec<Entity>,
        /// The length.
        length: MeasureLength,
    },
    /// Component of the average stress `sum f (x) l / V` (Love, Weber), wall branches included.
    Average {
        /// Component.
        component: StressComponent,
        /// Area that it is averaged over, m^2.
        area: MeasureArea,
    },
}

/// Length under a wall stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MeasureLength {
    /// A fixed length, m.
    Fixed(f64),
    /// Current distance of two walls.
    Between(Entity, Entity),
}

/// Area of an average stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MeasureArea {
    /// A fixed area, m^2.
    Fixed(f64),
    /// Product of two wall distances at the start of the increment.
    Box([Entity; 4]),
}

/// Component of a plane stress tensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StressComponent {
    /// sigma_xx.
    Xx,
    /// sigma_yy.
    Yy,
    /// sigma_xy.
    Xy,
}

/// The strains and stresses of a rig.
#[derive(Resource, Clone, Debug, Default)]
pub struct Measures {
    /// Stage at whose start the strains are zero.
    pub reference_stage: usize,
    /// Axial strain.
    pub axial_strain: Option<StrainMeasure>,
    /// Lateral strain.
    pub lateral_strain: Option<StrainMeasure>,
    /// Axial stress.
    pub axial_stress: Option<StressMeasure>,
    /// Lateral stress.
    pub lateral_stress: Option<StressMeasure>,
    /// Distances at the start of the reference stage, m: axial and lateral.
    pub reference: Option<[f64; 2]>,
}

/// A recorded body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProbeReading {
    /// Name of the probe.
    pub name: String,
    /// Displacement since the start of the stage list, m, m, rad.
    pub motion: [f64; 3],
    /// Force and moment that the outside world exerts on the body, N, N, N m.
    pub force: [f64; 3],
}

/// The record of the last committed increment. Numbers that the scene does not define are
/// `None` and stay empty in the history.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Observation {
    /// Increment, from 1.
    pub increment: u64,
    /// Name of the stage.
    pub stage: String,
    /// Fraction of the increment; below 1 where it was halved or ended with an event, 0 after an avalanche.
    pub fraction: f64,
    /// Time, s.
    pub time: f64,
    /// Axial strain, positive in contraction.
    pub axial_strain: Option<f64>,
    /// Lateral strain, positive in contraction.
    pub lateral_strain: Option<f64>,
    /// Volumetric strain `1 - (1 - e_a)(1 - e_l)`, positive in contraction.
    pub volumetric_strain: Option<f64>,
    /// Axial stress, Pa, positive in compression.
    pub axial_stress: Option<f64>,
    /// Lateral stress, Pa, positive in compression.
    pub lateral_stress: Option<f64>,
    /// Contacts (bonded or not) that carry force.
    pub contacts: usize,
    /// Potential contacts in the program.
    pub potential_contacts: usize,
    /// Intact bonds between bodies that are there.
    pub bonds: usize,
    /// Bonds broken so far in tension, shear and rolling.
    pub broken: [usize; 3],
    /// Kinetic energy, J.
    pub kinetic_energy: f64,
    /// Solves of the increment.
    pub solves: u32,
    /// Steps of motions that were followed before the equilibrium of the increment was found.
    pub motion_steps: u32,
    /// Strain of the mean field that these motions made.
    pub motion_strain: f64,
    /// Solver iterations of the increment.
    pub iterations: u32,
    /// KKT residuals.
    pub residuals: Residuals,
    /// Whether bonds are above their limits at constant load: a state within an avalanche, no equilibrium.
    pub in_avalanche: bool,
    /// How late bonds broke in this increment: relative change of the contact forces over it, `sum|f - f_0| / sum|f|`.
    /// Where they break from event to event: the maximum overload less 1, or the tolerance of the search if that is
    /// more. 0 where none broke.
    pub rupture_lag: f64,
    /// Loops that ended at their caps: `cascade`, `corrector`, `coulomb`, joined by `+`.
    pub caps: String,
    /// Coulomb's law: maximum of the natural map of the contacts, without dimension; 0 with the associated law.
    pub coulomb_residual: f64,
    /// How it ended.
    pub status: IncrementStatus,
    /// Probes: bodies with a probe name, by identity.
    pub probes: Vec<ProbeReading>,
    /// Bonds that broke in this increment, by identity.
    pub ruptures: Vec<Rupture>,
}

/// Bonds broken so far in tension, shear and rolling.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RuptureCount(pub [usize; 3]);

/// Wall-clock seconds that the parts of the last increment took. Results never depend on it.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct Timings {
    /// Contact detection.
    pub detect: f64,
    /// Assembly.
    pub assemble: f64,
    /// Solve.
    pub solve: f64,
    /// State update.
    pub update: f64,
    /// Rupture.
    pub rupture: f64,
    /// Control of walls.
    pub walls: f64,
    /// Record.
    pub record: f64,
}
