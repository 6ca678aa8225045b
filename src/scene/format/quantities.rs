//! What a run measures: names, and the quantities behind them.

use serde::{Deserialize, Serialize};

use super::{
    Along, Amount, CellStrain, Component, Cracks, FabricComponent, Fragments, MembraneValue,
    Network, RingValue, Select, StrainComponent,
};

/// Names of the measures that define strain and stress. They have columns of their own in the
/// history, and key results follow from them.
pub const ROLES: [&str; 4] = ["axial_strain", "lateral_strain", "axial_stress", "lateral_stress"];

/// A measure with a name: a column of the history, and usable in `stop`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Name.
    pub name: String,
    /// What is measured.
    pub of: Quantity,
}

/// What is measured.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Quantity {
    /// A strain.
    Strain(Strain),
    /// A stress, Pa.
    Stress(Stress),
    /// Porosity: one minus the area of all disks over this area.
    Porosity(Area),
    /// Mean number of contacts with force per particle.
    Coordination {
        /// Whether particles with less than two contacts count.
        #[serde(default = "super::yes")]
        rattlers: bool,
    },
    /// Number of bonds that broke so far.
    Broken(Modes),
    /// Their share of the bonds that broke or are intact.
    BrokenShare(Modes),
    /// Volumetric strain of axial and lateral strain.
    VolumetricStrain,
    /// Angle of dilation of axial and lateral strain, rad.
    DilationAngle {
        /// Change of the axial strain over which it is taken; 0 for the last increment.
        #[serde(default)]
        over: f64,
    },
    /// Component of the fabric tensor of contacts between particles.
    Fabric {
        /// Component.
        component: FabricComponent,
        /// Contacts that count.
        #[serde(default)]
        network: Network,
    },
    /// Fragments: sets of grains that intact bonds connect.
    Fragments(Fragments),
    /// Cracks that broken bonds leave.
    Cracks {
        /// What of them.
        part: Cracks,
        /// Mode in which the bonds broke.
        #[serde(default)]
        mode: Modes,
    },
    /// Kinetic energy, J.
    KineticEnergy,
    /// Elastic energy of contacts and bonds, J.
    ElasticEnergy,
    /// Kinetic over elastic energy.
    KineticOverElastic,
    /// Force that a wall exerts on the specimen, N.
    WallForce {
        /// The wall.
        wall: String,
        /// Component of the force.
        #[serde(default)]
        along: Along,
    },
    /// Force or moment of the contacts that cross the boundary of a group, N or N m.
    GroupForce {
        /// The particles.
        select: Select,
        /// Component of the force, or the moment.
        #[serde(default)]
        along: GroupAlong,
        /// Whether the particles are selected anew in every increment, and not only when a stage
        /// begins.
        #[serde(default)]
        live: bool,
    },
    /// Number or mass (kg) of the grains that stages have poured in.
    Poured(Amount),
    /// Number or mass (kg) of the grains in a rectangle, or of those of them that have moved.
    Grains {
        /// How they are counted.
        amount: Amount,
        /// Lower left corner, m; without it the rectangle has no end there.
        min: Option<(f64, f64)>,
        /// Upper right corner, m.
        max: Option<(f64, f64)>,
        /// Displacement since the start of the reference stage, m, from which on a grain counts; 0
        /// counts all.
        #[serde(default)]
        moved: f64,
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
        membrane: String,
        /// The value.
        value: MembraneValue,
    },
    /// Magnitude of gravity, m/s^2.
    Gravity,
    /// Factor on cohesion, tensile strength and friction, see [`Scale`](super::Scale).
    StrengthFactor,
    /// Time, s.
    Time,
    /// The value that a plugin provides under this name.
    Custom(String),
}

/// Modes in which bonds break.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
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

/// Component of the force on a group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum GroupAlong {
    /// Along x.
    #[default]
    X,
    /// Along y.
    Y,
    /// Moment about the centre of mass.
    Moment,
}

/// A strain since the start of the reference stage.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Strain {
    /// Distance between two walls.
    Walls(String, String),
    /// Distance between the centres of two particles, by index.
    Particles(u32, u32),
    /// Mean width of a membrane that covers both sides.
    Membrane(String),
    /// Strain of the periodic cell.
    Cell(CellStrain),
    /// Of the displacement gradient that fits best the displacements of the particles whose centres
    /// lie in a rectangle at the start of the reference stage.
    Region {
        /// Component.
        component: StrainComponent,
        /// Lower left corner, m.
        min: (f64, f64),
        /// Upper right corner, m.
        max: (f64, f64),
    },
}

/// A stress.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Stress {
    /// Mean of the normal forces on walls divided by length times thickness.
    Walls {
        /// The walls.
        walls: Vec<String>,
        /// The length.
        length: Length,
    },
    /// Component of the average stress sum f (x) l / V (Love, Weber).
    Average {
        /// Component.
        component: Component,
        /// The area.
        area: Area,
    },
    /// Component of the average stress in a rectangle. Every contact counts by the part of its
    /// branch inside.
    Region {
        /// Component.
        component: Component,
        /// Lower left corner, m.
        min: (f64, f64),
        /// Upper right corner, m.
        max: (f64, f64),
    },
    /// Pressure of a membrane.
    Membrane(String),
}

/// Length of a wall stress.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum Length {
    /// Fixed, m.
    Fixed(f64),
    /// Current distance between two walls.
    Between(String, String),
    /// Mean width of a membrane that covers both sides.
    Membrane(String),
}

/// Area of an average stress.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum Area {
    /// Fixed, m^2.
    Fixed(f64),
    /// Area between two pairs of walls.
    Box((String, String), (String, String)),
    /// Area that a membrane encloses.
    Membrane(String),
    /// The periodic cell.
    Cell,
}
