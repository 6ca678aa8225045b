//! Observations of an increment: plain data between the systems that measure and those that write.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::attempt::IncrementStatus;
use crate::bond::Rupture;
use clastic_cone::program::Residuals;

/// What a strain measure compares with the start of the reference stage. Contraction is positive.
///
/// `W` stands for a wall or a membrane, `P` for a particle: their entities in a world, their names
/// and indices in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename = "Strain", deny_unknown_fields)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum StrainMeasure<W = Entity, P = Entity> {
    /// Engineering strain of the distance between two walls along the normal of the first wall.
    Walls(W, W),
    /// Engineering strain of the distance between the centres of two particles.
    Particles(P, P),
    /// Engineering strain of the mean width of a membrane that covers both sides.
    Membrane(W),
    /// Strain of the periodic cell.
    Cell(CellStrain),
    /// Linear strain of the displacement gradient `H` that fits the displacements of particles
    /// best, by least squares: `u = u_0 + H (x - x_0)`.
    Region {
        /// Component.
        component: StrainComponent,
        /// Lower left corner of the rectangle in which the centres of the particles lie at the
        /// start of the reference stage, m.
        min: (f64, f64),
        /// Upper right corner, m.
        max: (f64, f64),
    },
}

/// Strain of a periodic cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum CellStrain {
    /// Engineering strain of the width.
    Width,
    /// Engineering strain of the height.
    Height,
    /// Shear, the sum of `du_x/dy` over the increments.
    Shear,
}

/// Component of a strain `-(H + H^T) / 2`, or of the rotation that belongs to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum StrainComponent {
    /// `-du_x/dx`.
    Xx,
    /// `-du_y/dy`.
    Yy,
    /// `-(du_x/dy + du_y/dx) / 2`.
    Xy,
    /// Maximum principal strain.
    Major,
    /// Minimum principal strain.
    Minor,
    /// Sum of `Xx` and `Yy`.
    Volumetric,
    /// Mean rotation `(du_y/dx - du_x/dy) / 2`, rad, anticlockwise.
    Rotation,
}

/// Source of a stress measure. Compression is positive. `W` as in [`StrainMeasure`].
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename = "Stress", deny_unknown_fields)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum StressMeasure<W = Entity> {
    /// Mean normal force on the named walls divided by length times thickness.
    Walls {
        /// The walls whose forces are averaged.
        walls: Vec<W>,
        /// The length.
        length: MeasureLength<W>,
    },
    /// Component of the average stress `sum f (x) l / V` (Love, Weber), wall branches included.
    Average {
        /// Component.
        component: StressComponent,
        /// Area of the average, m^2.
        area: MeasureArea<W>,
    },
    /// Average stress in a rectangle. Every contact counts by the part of its branch that lies
    /// inside.
    Region {
        /// Component.
        component: StressComponent,
        /// Lower left corner, m.
        min: (f64, f64),
        /// Upper right corner, m.
        max: (f64, f64),
    },
    /// Pressure of a membrane.
    Membrane(W),
}

/// Length in a wall stress.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename = "Length")]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum MeasureLength<W = Entity> {
    /// A fixed length, m.
    Fixed(f64),
    /// Current distance between two walls.
    Between(W, W),
    /// Mean width of a membrane that covers both sides, at the start of the increment.
    Membrane(W),
}

/// Area of an average stress.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename = "Area")]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum MeasureArea<W = Entity> {
    /// A fixed area, m^2.
    Fixed(f64),
    /// Product of the distances of two pairs of walls at the start of the increment.
    Box((W, W), (W, W)),
    /// Area that a membrane encloses, through the centres of its grains.
    Membrane(W),
    /// The periodic cell at the start of the increment.
    Cell,
}

/// Component of a plane stress tensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum StressComponent {
    /// sigma_xx.
    Xx,
    /// sigma_yy.
    Yy,
    /// Mean of sigma_xy and sigma_yx.
    Xy,
    /// Mean of the two principal stresses.
    Mean,
    /// Maximum principal stress.
    Major,
    /// Minimum principal stress.
    Minor,
    /// Traction along x on a face whose outward normal is y: -sigma_xy.
    Shear,
}

/// The strains and stresses of a rig.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Measures {
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

/// Reading of a recorded body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct ProbeReading {
    /// Name of the probe.
    pub name: String,
    /// Displacement since the start of the stage list, m, m, rad.
    pub motion: [f64; 3],
    /// Force and moment that the outside world exerts on the body, N, N, N m.
    pub force: [f64; 3],
}

/// Record of the last increment. Quantities that the scene does not define are `None`, and empty in
/// the history.
///
/// If [`status`](Self::status) is
/// [committed](crate::attempt::IncrementStatus::is_committed), the record is of the state of the
/// world. Otherwise nothing was committed: strains, probes and the kinetic energy are those of the
/// unchanged state, stresses are `None`, and contacts and residuals are those of the last attempt.
/// After a collapse bonds may be broken all the same; [`ruptures`](Self::ruptures) has them.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Observation {
    /// Number of the increment, from 1.
    pub increment: u64,
    /// Name of the stage.
    pub stage: String,
    /// Fraction of the increment: below 1 if it was halved or ended with an event, 0 after an
    /// avalanche.
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
    /// Number of contacts (bonded or not) whose normal force exceeds 1e-9 of the maximum force.
    pub contacts: usize,
    /// Number of potential contacts in the program.
    pub potential_contacts: usize,
    /// Number of intact bonds.
    pub bonds: usize,
    /// Number of bonds broken so far in tension, shear and rolling.
    pub broken: [usize; 3],
    /// Kinetic energy, J.
    pub kinetic_energy: f64,
    /// Number of solves in the increment.
    pub solves: u32,
    /// Number of steps of followed motions before the equilibrium of the increment was found.
    pub motion_steps: u32,
    /// Number of solver iterations in the increment.
    pub iterations: u32,
    /// KKT residuals.
    pub residuals: Residuals,
    /// Maximum out-of-balance force where the increment ends, over the maximum force.
    pub imbalance: f64,
    /// Motion that solving a static increment again about its own end would add, over the motion of
    /// the increment. `None` where contacts slide.
    pub idle_motion: Option<f64>,
    /// Whether the state lies within an avalanche: bonds are above their limits, so it is no
    /// equilibrium.
    pub in_avalanche: bool,
    /// Delay with which bonds broke in this increment: the relative change of the contact forces
    /// over the increment, `sum|f - f_0| / sum|f|`. If bonds break from event to event it is the
    /// maximum overload minus 1, or the tolerance of the search if that is larger. 0 without
    /// ruptures.
    pub rupture_lag: f64,
    /// Loops that reached their maximum number of passes: `geometry`, `coulomb`, joined by `+`.
    pub caps: String,
    /// Maximum of the natural map of the contacts under Coulomb's law, without dimension; 0 with
    /// the associated law.
    pub coulomb_residual: f64,
    /// Status of the increment.
    pub status: IncrementStatus,
    /// Readings of bodies with a probe name, in the order of identities.
    pub probes: Vec<ProbeReading>,
    /// Bonds that broke in this increment, in the order of identities.
    pub ruptures: Vec<Rupture>,
}

/// Number of bonds broken so far in tension, shear and rolling.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct RuptureCount(pub [usize; 3]);

/// Wall-clock seconds for each part of the last increment. Results never depend on them.
#[derive(Resource, Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
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
