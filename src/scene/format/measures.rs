//! How a rig defines strain and stress, and what else is measured.

use std::fmt;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};

use super::quantities::{Quantity, Strain, Stress};

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
