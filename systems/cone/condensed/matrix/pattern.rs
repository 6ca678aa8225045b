//! The fronts of a matrix, and the places of its values.

use super::fronts::Fronts;

/// Numbers in a block of the diagonal (its lower triangle by columns) and of a pair.
pub const DIAGONAL: usize = 6;
pub const PAIR: usize = 9;

/// The fronts, and the places of their values.
pub struct Pattern {
    pub fronts: Fronts,
    /// Start of the values of each front.
    pub starts: Vec<usize>,
    /// Place of the block of each pair, in the order of the values, in the trapezoid of its front.
    pub targets: Vec<u32>,
    /// Start of the targets of each front.
    pub target_starts: Vec<usize>,
}
