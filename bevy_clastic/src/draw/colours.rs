//! Colours, and what they mean.

use bevy::color::{LinearRgba, Srgba};

/// Legend of a field or of lines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Legend {
    /// Quantity with its unit.
    pub name: String,
    /// Colours of a scale from its lower to its upper end; empty without a scale.
    pub scale: Vec<&'static str>,
    /// Numbers at the lower end, in the middle and at the upper end of the scale.
    pub numbers: Option<[String; 3]>,
    /// Colours with a meaning of their own.
    pub samples: Vec<Sample>,
}

/// A colour and its meaning.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sample {
    /// Colour as `#rrggbb`.
    pub colour: &'static str,
    /// Meaning.
    pub text: String,
}

/// A colour of the engine's pictures, `#rrggbb`. Anything else is white.
#[must_use]
pub fn colour(hex: &str) -> LinearRgba {
    Srgba::hex(hex).map_or(LinearRgba::WHITE, LinearRgba::from)
}
