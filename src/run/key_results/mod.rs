//! Key results of a run: moduli, peak, strength, limit load, cracks, maximum residuals.
//!
//! If a result is not defined, `not_defined` gives the reason.

mod collected;
mod definitions;
mod failure;
mod observe;
mod results;

pub use self::collected::{KeyResults, Phase};
pub use self::definitions::RIGID;
pub(super) use self::observe::{count_bonds, start_from_state};
pub(crate) use self::observe::{is_undecided, observe_increment};
pub use self::results::{BrokenBonds, MechanismRecord, PEAK_ERROR, Results, Worst, WorstResiduals};

/// Name of [`KeyResults`] in a state.
pub(crate) const KEY_RESULTS: &str = "key_results";

#[cfg(test)]
mod tests;
