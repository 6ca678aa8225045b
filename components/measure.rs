//! Measures of a scene beside its axial and lateral strain and stress: what each reads, and the
//! readings of the last increment.

use bevy_ecs::prelude::*;
#[cfg(feature = "reflect")]
use bevy_ecs::reflect::ReflectResource;
use serde::{Deserialize, Serialize};

use crate::body::BodyId;
use crate::bond::RuptureMode;
use crate::observation::{MeasureArea, StrainMeasure, StressMeasure};

/// What a measure reads. Strain and stress have the signs of [`crate::observation`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Quantity {
    /// Strain since the start of the reference stage.
    Strain(StrainMeasure),
    /// Stress, Pa.
    Stress(StressMeasure),
    /// One minus the area of all disks over this area.
    Porosity(MeasureArea),
    /// Mean number of contacts and bonds with force per particle. A contact of two particles counts
    /// for each of them, a contact with a wall once.
    Coordination {
        /// Whether particles with less than two such contacts count. Without them it is the
        /// mechanical coordination number (2 N_c - N_1) / (N - N_0 - N_1) of Thornton (2000,
        /// Geotechnique 50, 43-53).
        rattlers: bool,
    },
    /// Bonds that broke so far.
    Broken {
        /// Only in this mode; `None` for all.
        mode: Option<RuptureMode>,
        /// Whether it is the share of the bonds that broke or are intact, instead of their number.
        share: bool,
    },
    /// Kinetic energy of the particles, J.
    KineticEnergy,
    /// Elastic energy of contacts and bonds, J: the sum of C f^2 / 2 over their springs.
    ElasticEnergy,
    /// Kinetic over elastic energy. It is not defined without elastic energy.
    KineticOverElastic,
    /// Force that a wall exerts on the specimen, N.
    WallForce {
        /// The wall.
        wall: Entity,
        /// Its component.
        along: ForceComponent,
    },
    /// Force or moment of the contacts and bonds that cross the boundary of a group, on the group,
    /// N or N m.
    GroupForce {
        /// Its particles, in the order of identities.
        members: Vec<BodyId>,
        /// 0 and 1 for the force along x and y, 2 for the moment about the centre of mass.
        component: usize,
    },
    /// Time, s.
    Time,
    /// The value that a plugin provides under this name.
    Custom(String),
}

/// Component of the force of a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum ForceComponent {
    /// Along the inward normal: positive where the wall presses.
    Normal,
    /// Along the way from start to end.
    Tangent,
    /// Along x.
    X,
    /// Along y.
    Y,
}

/// The measures in the order of the scene. `None` for a measure on a body that is not there.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct NamedMeasures {
    /// Name and quantity.
    pub list: Vec<(String, Option<Quantity>)>,
    /// Distances of the strains at the start of the reference stage, m, in the same order.
    pub references: Vec<Option<f64>>,
}

/// Readings of the last increment, in the order of [`NamedMeasures::list`].
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Readings(pub Vec<Option<f64>>);
