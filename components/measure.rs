//! Measures of a scene beside its axial and lateral strain and stress: the quantity of each, and
//! the readings of the last increment.

use std::ops::Range;

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::body::BodyId;
use crate::observation::{MeasureArea, StrainComponent, StrainMeasure, StressMeasure};

/// What a measure reads. Strain and stress have the signs of [`crate::observation`].
///
/// `W` refers to a wall or a membrane, `P` to a particle, `G` to a group of particles: in a world
/// by entities and identities, in a scene by name, index and selection.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Quantity<W = Entity, P = Entity, G = Vec<BodyId>> {
    /// Strain since the start of the reference stage.
    Strain(StrainMeasure<W, P>),
    /// Stress, Pa.
    Stress(StressMeasure<W>),
    /// One minus the area of all disks over this area.
    Porosity(MeasureArea<W>),
    /// Mean number of contacts and bonds with force per particle. A contact of two particles counts
    /// for each of them, a contact with a wall once.
    Coordination {
        /// Whether particles with fewer than two such contacts count. Without them the measure is
        /// the mechanical coordination number (2 N_c - N_1) / (N - N_0 - N_1) of Thornton (2000,
        /// Geotechnique 50, 43-53).
        #[serde(default = "yes")]
        rattlers: bool,
    },
    /// Number of bonds that broke so far.
    Broken(Modes),
    /// Their share of all bonds.
    BrokenShare(Modes),
    /// Volumetric strain, from axial and lateral strain, as the history records it.
    VolumetricStrain,
    /// Angle of dilation psi, rad: `sin psi = -(d e_a + d e_l) / |d e_a - d e_l|` with the
    /// logarithmic increments of axial and lateral strain, contraction positive (Bolton 1986,
    /// Geotechnique 36, 65-78, for plane strain).
    DilationAngle {
        /// Change of the axial strain over which the increments are taken; 0 for those of the last
        /// increment.
        #[serde(default)]
        over: f64,
    },
    /// Component of the fabric tensor of the contacts of particles with each other.
    Fabric {
        /// Component.
        component: FabricComponent,
        /// Contacts that count.
        #[serde(default)]
        network: Network,
    },
    /// Fragments: sets of particles that intact bonds or rigid groups connect. A particle without
    /// bonds and groups is a fragment.
    Fragments(FragmentPart),
    /// Cracks: each bond that breaks leaves one as long as the diameter of its smaller particle,
    /// across the line between the two centres at the start of the increment in which it breaks.
    Cracks {
        /// The value.
        part: CrackPart,
        /// Modes in which the bonds broke.
        #[serde(default)]
        mode: Modes,
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
        wall: W,
        /// Its component.
        #[serde(default)]
        along: ForceComponent,
    },
    /// Force or moment of the contacts and bonds that cross the boundary of a group, on the group,
    /// N or N m.
    GroupForce {
        /// Its particles; in a world in the order of identities.
        select: G,
        /// Component of the force, or the moment.
        #[serde(default)]
        along: GroupAlong,
        /// Whether the particles are selected anew in every increment, and not only when a stage
        /// begins.
        #[serde(default)]
        live: bool,
    },
    /// Number of the grains that stages have poured in so far, or their mass in kg.
    Poured(GrainAmount),
    /// Grains with centres in a rectangle.
    Grains {
        /// How they are counted.
        amount: GrainAmount,
        /// Lower left corner, m; without it the rectangle is unbounded to the left and below.
        min: Option<(f64, f64)>,
        /// Upper right corner, m; without it the rectangle is unbounded to the right and above.
        max: Option<(f64, f64)>,
        /// Minimum displacement since the start of the reference stage, m; 0 counts all.
        #[serde(default)]
        moved: f64,
    },
    /// Front of a flow: the coordinate up to which a share of the mass of all particles lies, by
    /// their centres, m.
    Front {
        /// Direction of the coordinate.
        along: Axis,
        /// The share, above 0; with 1 it is the coordinate of the last particle.
        share: f64,
    },
    /// Value of the particles whose centres were in a ring at the start of the reference stage.
    Ring {
        /// Centre of the ring, m.
        centre: (f64, f64),
        /// Inner and outer radius, m.
        radii: (f64, f64),
        /// The value.
        value: RingValue,
    },
    /// Value of a membrane.
    Membrane {
        /// The membrane.
        membrane: W,
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

fn yes() -> bool {
    true
}

/// Modes in which bonds break.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Modes {
    /// All modes.
    #[default]
    All,
    /// Tension.
    Tension,
    /// Shear.
    Shear,
    /// Rolling.
    Rolling,
}

impl Modes {
    /// Their places in a table by [`RuptureMode`](crate::bond::RuptureMode).
    pub fn places(self) -> Range<usize> {
        match self {
            Self::All => 0..3,
            Self::Tension => 0..1,
            Self::Shear => 1..2,
            Self::Rolling => 2..3,
        }
    }
}

/// Component of the force on a group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum GroupAlong {
    /// Along x.
    #[default]
    X,
    /// Along y.
    Y,
    /// Moment about the centre of mass.
    Moment,
}

impl<W, P, G> Quantity<W, P, G> {
    /// Unit of the readings; empty for a pure number, and for the value of a plugin.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Stress(_) | Self::Ring { value: RingValue::Support, .. } => "Pa",
            Self::Ring { value: RingValue::Closure, .. } | Self::Front { .. } => "m",
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
            Self::GroupForce { along: GroupAlong::Moment, .. } => "N m",
            Self::WallForce { .. } | Self::GroupForce { .. } => "N",
            Self::Poured(GrainAmount::Mass) | Self::Grains { amount: GrainAmount::Mass, .. } => {
                "kg"
            }
            Self::Gravity => "m/s^2",
            Self::Time => "s",
            _ => "",
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

/// An axis of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Axis {
    /// The x axis.
    X,
    /// The y axis.
    Y,
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
        let grains = |amount| Quantity::Grains { amount, min: None, max: None, moved: 0.0 };
        let force = |along| Quantity::GroupForce { select: Vec::new(), along, live: false };
        let cracks = |part| Quantity::Cracks { mode: Modes::All, part };
        let membrane = |value| Quantity::Membrane { membrane: Entity::PLACEHOLDER, value };
        let expected: [(Quantity, &str); 12] = [
            (grains(GrainAmount::Mass), "kg"),
            (grains(GrainAmount::Share), ""),
            (force(GroupAlong::Y), "N"),
            (force(GroupAlong::Moment), "N m"),
            (cracks(CrackPart::Length), "m"),
            (cracks(CrackPart::Direction), "rad"),
            (cracks(CrackPart::Alignment), ""),
            (membrane(MembraneValue::Grains), ""),
            (membrane(MembraneValue::OuterArea), "m^2"),
            (membrane(MembraneValue::OuterWidth), "m"),
            (Quantity::Strain(StrainMeasure::Cell(CellStrain::Width)), ""),
            (Quantity::Poured(GrainAmount::Mass), "kg"),
        ];
        for (quantity, unit) in expected {
            assert_eq!(quantity.unit(), unit, "{quantity:?}");
        }
    }
}
