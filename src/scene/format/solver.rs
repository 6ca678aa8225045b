//! The solver and its settings.

use std::cell::Cell;
use std::fmt;

use clastic_cone::condensed::CondensedSettings;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserialize, Deserializer, EnumAccess, MapAccess, VariantAccess, Visitor};
use serde::ser::{Serialize, SerializeStructVariant, Serializer};

/// The variant that may be written without brackets: all its fields have defaults.
pub(in crate::scene) const WITHOUT_BRACKETS: &str = "Condensed";

/// What serde reads of [`CondensedSettings`].
pub(in crate::scene) const CONDENSED_FIELDS: [&str; 7] = [
    "tolerance",
    "loose_tolerance",
    "newton_margin",
    "loose_newton_margin",
    "interior_margin",
    "large",
    "max_start",
];

/// The solver and its settings.
#[derive(Clone, Debug, PartialEq)]
pub enum Solver {
    /// The engine's own condensed solver: `Condensed`, or
    /// `Condensed(...)` with some of its settings.
    Condensed(Box<CondensedSettings>),
    /// The interior-point solver Clarabel.
    Clarabel {
        /// Feasibility and gap tolerance that Clarabel is asked for.
        tolerance: f64,
        /// Cap on its iterations.
        max_iterations: u32,
    },
}

impl Default for Solver {
    fn default() -> Self {
        Self::Condensed(Box::default())
    }
}

/// The variants by name.
#[derive(serde::Deserialize)]
#[serde(variant_identifier)]
enum Name {
    Condensed,
    Clarabel,
}

/// Fields of [`Solver::Clarabel`].
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
struct ClarabelFields {
    tolerance: f64,
    max_iterations: u32,
}

impl Default for ClarabelFields {
    fn default() -> Self {
        Self { tolerance: 1e-10, max_iterations: 200 }
    }
}

// By hand: a derived enum reads a variant either without brackets or with them.
impl<'de> Deserialize<'de> for Solver {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_enum("Solver", &[WITHOUT_BRACKETS, "Clarabel"], SolverVisitor)
    }
}

struct SolverVisitor;

impl<'de> Visitor<'de> for SolverVisitor {
    type Value = Solver;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a solver")
    }

    fn visit_enum<A: EnumAccess<'de>>(self, access: A) -> Result<Solver, A::Error> {
        match access.variant()? {
            (Name::Condensed, variant) => {
                let opened = Cell::new(false);
                match variant.struct_variant(&CONDENSED_FIELDS, CondensedVisitor(&opened)) {
                    Ok(settings) => Ok(Solver::Condensed(settings)),
                    // No bracket was found, and nothing was read.
                    Err(_) if !opened.get() => Ok(Solver::default()),
                    Err(error) => Err(error),
                }
            }
            (Name::Clarabel, variant) => {
                variant.struct_variant(&["tolerance", "max_iterations"], ClarabelVisitor)
            }
        }
    }
}

/// Reads settings, and tells whether it came to that.
struct CondensedVisitor<'a>(&'a Cell<bool>);

impl<'de> Visitor<'de> for CondensedVisitor<'_> {
    type Value = Box<CondensedSettings>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("settings of the condensed solver")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        self.0.set(true);
        Deserialize::deserialize(MapAccessDeserializer::new(map))
    }
}

struct ClarabelVisitor;

impl<'de> Visitor<'de> for ClarabelVisitor {
    type Value = Solver;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("settings of Clarabel")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Solver, A::Error> {
        let ClarabelFields { tolerance, max_iterations } =
            Deserialize::deserialize(MapAccessDeserializer::new(map))?;
        Ok(Solver::Clarabel { tolerance, max_iterations })
    }
}

impl Serialize for Solver {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            // Records of scenes that set nothing say no more than these.
            Self::Condensed(settings) if **settings == CondensedSettings::default() => {
                serializer.serialize_unit_variant("Solver", 0, WITHOUT_BRACKETS)
            }
            Self::Condensed(settings) => {
                serializer.serialize_newtype_variant("Solver", 0, WITHOUT_BRACKETS, settings)
            }
            Self::Clarabel { tolerance, max_iterations } => {
                let mut fields = serializer.serialize_struct_variant("Solver", 1, "Clarabel", 2)?;
                fields.serialize_field("tolerance", tolerance)?;
                fields.serialize_field("max_iterations", max_iterations)?;
                fields.end()
            }
        }
    }
}
