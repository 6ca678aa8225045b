//! Stored specimens.
/// One row.
#[derive(Clone, Debug)]
pub struct StoredParticle { /// m
pub x: f64, /// m
pub y: f64, /// m
pub r: f64, /// name
pub material: Option<String> }
/// A stored specimen.
#[derive(Clone, Debug)]
pub struct StoredSpecimen { /// rows
pub rows: Vec<StoredParticle> }
