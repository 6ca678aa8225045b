//! How a rig defines strain and stress.

use serde::{Deserialize, Serialize};

/// Definitions of strain and stress.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
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
}

/// A strain: decrease of a distance over its value at the start of the reference stage.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum Strain {
    /// Distance between two walls.
    Walls(String, String),
    /// Distance between the centres of two particles, by index.
    Particles(u32, u32),
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
}

/// Length of a wall stress.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum Length {
    /// Fixed, m.
    Fixed(f64),
    /// Current distance between two walls.
    Between(String, String),
}

/// Area of an average stress.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum Area {
    /// Fixed, m^2.
    Fixed(f64),
    /// Area between two pairs of walls.
    Box((String, String), (String, String)),
}

/// Component of a stress tensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Component {
    /// sigma_xx.
    Xx,
    /// sigma_yy.
    Yy,
    /// sigma_xy.
    Xy,
}
