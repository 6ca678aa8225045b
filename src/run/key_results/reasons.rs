//! Reasons why a key result is not defined, and the threshold that they share.

/// Changes of stress below this fraction of the maximum stress count as round-off.
pub(super) const RESOLVED: f64 = 1e-6;

/// Reason where no increment comes to half the peak.
pub(super) const NO_HALF: &str = "no increment comes to half the peak";
pub(super) const NO_GAIN: &str =
    "the strain does not change where the stress gains a thousandth of the peak";
/// Reason why a rigid specimen has no modulus.
pub const RIGID: &str = "nothing is elastic";
pub(super) const CAPPED_BEFORE: &str = "an increment that it would come from is capped";
/// Reason where the response is not that of the springs alone.
pub(super) const INERTIA: &str = "inertia carries a part of the load there: the kinetic energy is above a hundredth \
                                  of the work; load more slowly, or in a static stage";
/// Reason where the lateral stress changes.
pub(super) const LATERAL_CHANGES: &str = "the lateral stress changes during the test";
