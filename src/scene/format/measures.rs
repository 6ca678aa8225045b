//! How a rig defines strain and stress, and what else is measured.

use std::fmt;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};

use super::{CellStrain, Select};

/// Definitions of strain and stress, and of further measures.
///
/// Version 1 has `(axial_strain: ..., ...)`, version 2 a list of measures with names. The measures
/// of a list that have the names in [`ROLES`] define the strains and stresses.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Measures {
    /// Stage at whose start strains are zero; the last stage if left out.
    pub reference_stage: Option<String>,
    /// Axial strain.
    pub axial_strain: Option<Strain>,
    /// Lateral strain.
    pub lateral_strain: Option<Strain>,
    /// Axial stress.
    pub axial_stress: Option<Stress>,
    /// Lateral stress.
    pub lateral_stress: Option<Stress>,
    /// The list of version 2 as written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub list: Option<Vec<Measure>>,
}

/// Names of the measures that define strain and stress.
pub const ROLES: [&str; 4] = ["axial_strain", "lateral_strain", "axial_stress", "lateral_stress"];

impl Measures {
    /// Measures of a list. Of two with the same name the first counts.
    #[must_use]
    pub fn of_list(list: Vec<Measure>) -> Self {
        let find = |name: &str| list.iter().find(|measure| measure.name == name);
        let strain = |name| match find(name).map(|measure| &measure.of) {
            Some(Quantity::Strain(strain)) => Some(strain.clone()),
            _ => None,
        };
        let stress = |name| match find(name).map(|measure| &measure.of) {
            Some(Quantity::Stress(stress)) => Some(stress.clone()),
            _ => None,
        };
        let [axial_strain, lateral_strain] = [ROLES[0], ROLES[1]].map(strain);
        let [axial_stress, lateral_stress] = [ROLES[2], ROLES[3]].map(stress);
        Self {
            reference_stage: None,
            axial_strain,
            lateral_strain,
            axial_stress,
            lateral_stress,
            list: Some(list),
        }
    }

    /// The measures of the list that define no strain or stress of [`ROLES`].
    pub fn further(&self) -> impl Iterator<Item = &Measure> {
        self.list.iter().flatten().filter(|measure| !ROLES.contains(&measure.name.as_str()))
    }
}

/// The fields of version 1.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, default, rename = "Measures")]
#[derive(Default)]
struct Fields {
    reference_stage: Option<String>,
    axial_strain: Option<Strain>,
    lateral_strain: Option<Strain>,
    axial_stress: Option<Stress>,
    lateral_stress: Option<Stress>,
}

impl From<Fields> for Measures {
    fn from(fields: Fields) -> Self {
        Self {
            reference_stage: fields.reference_stage,
            axial_strain: fields.axial_strain,
            lateral_strain: fields.lateral_strain,
            axial_stress: fields.axial_stress,
            lateral_stress: fields.lateral_stress,
            list: None,
        }
    }
}

// By hand: the two versions have different shapes.
impl<'de> Deserialize<'de> for Measures {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(MeasuresVisitor)
    }
}

struct MeasuresVisitor;

impl<'de> Visitor<'de> for MeasuresVisitor {
    type Value = Measures;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a list of measures")
    }

    fn visit_unit<E>(self) -> Result<Measures, E> {
        Ok(Measures::default())
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Measures, A::Error> {
        Fields::deserialize(MapAccessDeserializer::new(map)).map(Measures::from)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Measures, A::Error> {
        let list = Vec::deserialize(SeqAccessDeserializer::new(list))?;
        // `ron` reads brackets with nothing but space in them as a list too.
        Ok(if list.is_empty() { Measures::default() } else { Measures::of_list(list) })
    }

    // The second reading leaves the choice of the shape to the text.
    fn visit_newtype_struct<D: Deserializer<'de>>(self, fields: D) -> Result<Measures, D::Error> {
        Fields::deserialize(fields).map(Measures::from)
    }
}

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

/// Modes in which bonds break.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Modes {
    /// All modes.
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

/// A strain: decrease of a distance over its value at the start of the reference stage.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum Strain {
    /// Distance between two walls.
    Walls(String, String),
    /// Distance between the centres of two particles, by index.
    Particles(u32, u32),
    /// Mean width of a membrane that covers both sides.
    Membrane(String),
    /// Strain of the periodic cell. Version 2.
    Cell(CellStrain),
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
    /// Traction along x on a face whose outward normal is y: -sigma_xy. Version 2.
    Shear,
}
