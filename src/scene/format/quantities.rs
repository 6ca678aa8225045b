//! Quantities that a measure can read.

use serde::{Deserialize, Serialize};

use super::{CellStrain, Select};

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
    /// Fragments: what intact bonds connect.
    Fragments(Fragments),
    /// Cracks that broken bonds leave.
    Cracks {
        /// What of them.
        part: Cracks,
        /// Mode in which the bonds broke.
        #[serde(default)]
        mode: Modes,
    },
    /// Term of the energy ledger, J. It needs `output: (energy: true)`.
    Energy(Energy),
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
    /// Value of a membrane.
    Membrane {
        /// The membrane.
        membrane: String,
        /// The value.
        value: MembraneValue,
    },
    /// Time, s.
    Time,
    /// The value that a plugin provides under this name.
    Custom(String),
}

/// How grains are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Amount {
    /// Their number.
    Number,
    /// Their mass, kg.
    Mass,
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

/// Value of a membrane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum MembraneValue {
    /// Number of grains in its chains.
    Grains,
    /// Area that it encloses, m^2.
    Area,
    /// Area over the distance of its two walls, m.
    Width,
}

/// Component of the force of a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Along {
    /// Along the inward normal.
    #[default]
    Normal,
    /// Along the way from start to end.
    Tangent,
    /// Along x.
    X,
    /// Along y.
    Y,
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
    /// Strain of the periodic cell. Version 2.
    Cell(CellStrain),
    /// Of the displacement gradient that fits best the displacements of the particles whose centres
    /// lie in a rectangle at the start of the reference stage. Version 2.
    Region {
        /// Component.
        component: StrainComponent,
        /// Lower left corner, m.
        min: (f64, f64),
        /// Upper right corner, m.
        max: (f64, f64),
    },
}

/// Component of a strain in a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
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
    /// Sum of the two.
    Volumetric,
    /// Mean rotation, rad.
    Rotation,
}

/// Component of a fabric tensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum FabricComponent {
    /// F_xx.
    Xx,
    /// F_yy.
    Yy,
    /// F_xy.
    Xy,
    /// Anisotropy 2 (F_1 - F_2).
    Anisotropy,
    /// Angle of the major principal direction, rad.
    Direction,
}

/// Contacts that count in a fabric tensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Network {
    /// All that carry force.
    #[default]
    All,
    /// Those with a normal force above the mean.
    Strong,
}

/// What of the fragments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Fragments {
    /// Their number.
    Number,
    /// Maximum number of particles in one.
    Largest,
    /// Share of the largest in the mass.
    LargestShare,
    /// Number of those with one particle.
    Single,
}

/// What of the cracks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Cracks {
    /// Sum of their lengths, m.
    Length,
    /// Mean direction, rad.
    Direction,
    /// How far they are parallel, 0 to 1.
    Alignment,
}

/// Term of the energy ledger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Energy {
    /// Work of walls, imposed motion and loads.
    External,
    /// Work of gravity.
    Gravity,
    /// Change of the kinetic energy.
    Kinetic,
    /// Work of sliding.
    Friction,
    /// Work of rolling.
    Rolling,
    /// Work of the gaps that associated friction opens.
    Dilation,
    /// Taken by impacts.
    Collision,
    /// Taken by bonds that break.
    Rupture,
    /// Taken out of motions by static analysis.
    Motion,
    /// Work of forces whose normals turn.
    Turning,
    /// Taken by the scheme.
    Numerical,
    /// Error of the balance.
    Error,
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
    /// branch inside. Version 2.
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
    /// The periodic cell. Version 2.
    Cell,
}

/// Component of a stress tensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Component {
    /// sigma_xx.
    Xx,
    /// sigma_yy.
    Yy,
    /// sigma_xy, which is negative where the top is pushed along x.
    Xy,
    /// Mean of the principal stresses.
    Mean,
    /// Maximum principal stress.
    Major,
    /// Minimum principal stress.
    Minor,
    /// Traction along x on a face whose outward normal is y: -sigma_xy. Version 2.
    Shear,
}
