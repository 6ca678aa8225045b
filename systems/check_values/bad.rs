//! A value that has no meaning, and what it should be.

use std::fmt::{Debug, Display};

use clastic_components::domain::Domain;

/// A value that has no meaning.
pub(super) struct Bad {
    field: String,
    value: String,
    /// What it should be.
    wanted: String,
}

impl Bad {
    /// The value of a field that is wrong as it is.
    pub(super) fn new(field: &str, value: impl Debug, wanted: impl Into<String>) -> Self {
        Self { field: field.to_owned(), value: format!("{value:?}"), wanted: wanted.into() }
    }

    /// The value as that of a part.
    pub(super) fn of(self, part: &str) -> Self {
        Self { field: format!("{part}{}", self.field), ..self }
    }

    pub(super) fn in_words(&self, owner: impl Display) -> String {
        let Self { field, value, wanted } = self;
        format!(
            "{owner} has {field} = {value}: give {wanted}, then remove `ClasticHalted` and insert `ClasticRunning::Always`"
        )
    }
}

/// The value if it does not satisfy the condition, which NaN does not.
pub(super) fn bad(field: &str, value: f64, is_fine: bool, wanted: &str) -> Option<Bad> {
    (!is_fine).then(|| Bad::new(field, value, wanted))
}

/// The value if it is outside of the domain.
pub(super) fn outside(field: &str, value: f64, domain: Domain) -> Option<Bad> {
    bad(field, value, domain.has(value), domain.what)
}

pub(super) fn finite(field: &str, value: f64, wanted: &str) -> Option<Bad> {
    bad(field, value, value.is_finite(), wanted)
}

pub(super) fn not_negative(field: &str, value: f64, wanted: &str) -> Option<Bad> {
    bad(field, value, value >= 0.0 && value.is_finite(), wanted)
}
