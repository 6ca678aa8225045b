//! Measures of a scene beside its axial and lateral strain and stress: the quantity of each, and
//! the readings of the last increment.

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::body::BodyId;
use crate::bond::RuptureMode;
use crate::observation::{MeasureArea, StrainComponent, StrainMeasure, StressMeasure};

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
        /// Whether the value is the number of broken bonds over that of all bonds, instead of their
        /// number.
        share: bool,
    },
    /// The record's volumetric strain, from axial and lateral strain.
    VolumetricStrain,
    /// Angle of dilation psi, rad: `sin psi = -(d e_a + d e_l) / |d e_a - d e_l|` with the
    /// logarithmic increments of axial and lateral strain, contraction positive (Bolton 1986,
    /// Geotechnique 36, 65-78, for plane strain).
    DilationAngle {
        /// Change of the axial strain over which the increments are taken; 0 for those of the last
        /// increment.
        over: f64,
    },
    /// Component of the fabric tensor of the contacts of particles with each other.
    Fabric {
        /// Component.
        component: FabricComponent,
        /// Contacts that count.
        network: Network,
    },
    /// Fragments: sets of particles that intact bonds or rigid groups connect. A particle without
    /// bonds and groups is a fragment.
    Fragments(FragmentPart),
    /// Cracks: each bond that breaks leaves one as long as the diameter of its smaller particle,
    /// across the line between the two centres at the start of the increment in which it breaks.
    Cracks {
        /// Only those that broke in this mode; `None` for all.
        mode: Option<RuptureMode>,
        /// The value.
        part: CrackPart,
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
    /// Number of the grains that stages have poured in so far, or their mass in kg.
    Poured {
        /// Whether it is the mass.
        mass: bool,
    },
    /// Grains with centres in a rectangle.
    Grains {
        /// How they are counted.
        amount: GrainAmount,
        /// Lower left corner, m.
        min: DVec2,
        /// Upper right corner, m.
        max: DVec2,
        /// Minimum displacement since the start of the reference stage, m.
        moved: f64,
    },
    /// Value of the particles whose centres were in a ring at the start of the reference stage.
    Ring {
        /// Centre of the ring, m.
        centre: DVec2,
        /// Inner and outer radius, m.
        radii: [f64; 2],
        /// The value.
        value: RingValue,
    },
    /// Value of a membrane.
    Membrane {
        /// The membrane.
        membrane: Entity,
        /// The value.
        value: MembraneValue,
    },
    /// Magnitude of gravity, m/s^2.
    Gravity,
    /// Factor on cohesion, tensile strength and friction.
    StrengthFactor,
    /// Time, s.
    Time,
    /// The value that a plugin provides under this name.
    Custom(String),
}

impl Quantity {
    /// Unit of the readings; empty for a pure number, and for the value of a plugin.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Stress(_) | Self::Ring { value: RingValue::Support, .. } => "Pa",
            Self::Ring { value: RingValue::Closure, .. } => "m",
            Self::Membrane { value: MembraneValue::Area | MembraneValue::OuterArea, .. } => "m^2",
            Self::Cracks { part: CrackPart::Length, .. }
            | Self::Membrane { value: MembraneValue::Width | MembraneValue::OuterWidth, .. } => "m",
            Self::DilationAngle { .. }
            | Self::Strain(StrainMeasure::Region {
                component: StrainComponent::Rotation, ..
            })
            | Self::Fabric { component: FabricComponent::Direction, .. }
            | Self::Cracks { part: CrackPart::Direction, .. } => "rad",
            Self::KineticEnergy | Self::ElasticEnergy => "J",
            Self::GroupForce { component: 2, .. } => "N m",
            Self::WallForce { .. } | Self::GroupForce { .. } => "N",
            Self::Poured { mass: true } | Self::Grains { amount: GrainAmount::Mass, .. } => "kg",
            Self::Gravity => "m/s^2",
            Self::Time => "s",
            Self::Strain(_)
            | Self::Porosity(_)
            | Self::Coordination { .. }
            | Self::Broken { .. }
            | Self::VolumetricStrain
            | Self::Fabric { .. }
            | Self::Fragments(_)
            | Self::Cracks { .. }
            | Self::KineticOverElastic
            | Self::Poured { .. }
            | Self::Grains { .. }
            | Self::Membrane { .. }
            | Self::StrengthFactor
            | Self::Custom(_) => "",
        }
    }
}

/// How grains are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum GrainAmount {
    /// Their number.
    Number,
    /// Their mass, kg.
    Mass,
    /// Their share of the mass of all grains.
    Share,
}

/// Value of the particles in a ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum RingValue {
    /// Mean of their displacements towards the centre since the start of the reference stage, m.
    Closure,
    /// Sum of the forces of the outside world on them away from the centre, over the area of the inner
    /// circle, Pa.
    Support,
}

/// Component of the force of a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum ForceComponent {
    /// Along the inward normal: positive where the wall presses.
    #[default]
    Normal,
    /// Along the direction from start to end.
    Tangent,
    /// Along x.
    X,
    /// Along y.
    Y,
}

/// Component of a fabric tensor `F = mean of n (x) n` over contacts with unit normals n.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum FabricComponent {
    /// F_xx.
    Xx,
    /// F_yy; F_xx + F_yy = 1.
    Yy,
    /// F_xy.
    Xy,
    /// `a = 2 (F_1 - F_2)` with the principal values. It is the a of the distribution of normals
    /// `E(theta) = (1 + a cos 2 (theta - theta_a)) / (2 pi)` (Rothenburg and Bathurst 1989,
    /// Geotechnique 39, 601-614).
    Anisotropy,
    /// Angle `theta_a` of the major principal direction from the x axis, rad, from 0 to below pi. It
    /// is not defined for an isotropic tensor.
    Direction,
}

/// Contacts that count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Network {
    /// All that carry force.
    #[default]
    All,
    /// Those whose normal force has a magnitude above the mean magnitude (Radjai et al. 1998, Phys.
    /// Rev. Lett. 80, 61-64).
    Strong,
}

/// Value of the fragments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum FragmentPart {
    /// Their number.
    Number,
    /// Maximum number of particles in a fragment.
    Largest,
    /// Maximum mass of a fragment over the mass of all particles.
    LargestShare,
    /// Number of fragments of one particle.
    Single,
}

/// Value of the cracks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum CrackPart {
    /// Sum of their lengths, m.
    Length,
    /// Mean direction, weighted by length, as an angle from the x axis, rad, from 0 to below pi.
    /// Directions are axes, so the mean is that of doubled angles.
    Direction,
    /// Magnitude of that mean: 1 for parallel cracks, 0 without a preferred direction.
    Alignment,
}

/// Centres of the particles at the start of the reference stage, m, by identity. The resource
/// exists from that stage on, if a measure needs a strain in a region.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct StrainReference(pub Vec<(BodyId, DVec2)>);

/// Axial and lateral strain after the last increments, oldest first. The resource exists if an
/// angle of dilation is measured.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct StrainPath(pub Vec<[f64; 2]>);

/// Sums over the bonds that broke so far, by mode: tension, shear, rolling. The resource exists if
/// cracks are measured.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct CrackSums(pub [CrackSum; 3]);

/// Sums over cracks of length l and direction theta.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct CrackSum {
    /// Sum of l, m.
    pub length: f64,
    /// Sum of l (cos 2 theta, sin 2 theta), m.
    pub doubled: DVec2,
}

/// Value of a membrane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum MembraneValue {
    /// Number of grains in its chains.
    Grains,
    /// Area that it encloses, through the centres of its grains, m^2.
    Area,
    /// Area over the distance of its two walls, m.
    Width,
    /// Area that it encloses with the outermost grains, m^2.
    OuterArea,
    /// This area over the distance of its two walls, m.
    OuterWidth,
}

/// The measures in the order of the scene. The quantity is `None` while its body is not in the
/// world.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct NamedMeasures {
    /// Name and quantity.
    pub list: Vec<(String, Option<Quantity>)>,
    /// Distance over which each strain is measured, at the start of the reference stage, m. The
    /// order is that of `list`.
    pub references: Vec<Option<f64>>,
}

/// Readings of the last increment, in the order of [`NamedMeasures::list`].
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Readings(pub Vec<Option<f64>>);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::CellStrain;

    /// What a quantity counts decides its unit.
    #[test]
    fn parts_of_a_quantity_have_units_of_their_own() {
        let grains = |amount| {
            let corner = DVec2::ZERO;
            Quantity::Grains { amount, min: corner, max: corner, moved: 0.0 }
        };
        let force = |component| Quantity::GroupForce { members: Vec::new(), component };
        let cracks = |part| Quantity::Cracks { mode: None, part };
        let membrane = |value| Quantity::Membrane { membrane: Entity::PLACEHOLDER, value };
        let expected = [
            (grains(GrainAmount::Mass), "kg"),
            (grains(GrainAmount::Share), ""),
            (force(1), "N"),
            (force(2), "N m"),
            (cracks(CrackPart::Length), "m"),
            (cracks(CrackPart::Direction), "rad"),
            (cracks(CrackPart::Alignment), ""),
            (membrane(MembraneValue::Grains), ""),
            (membrane(MembraneValue::OuterArea), "m^2"),
            (membrane(MembraneValue::OuterWidth), "m"),
            (Quantity::Strain(StrainMeasure::Cell(CellStrain::Width)), ""),
            (Quantity::Poured { mass: true }, "kg"),
        ];
        for (quantity, unit) in expected {
            assert_eq!(quantity.unit(), unit, "{quantity:?}");
        }
    }
}
