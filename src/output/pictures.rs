//! Names of the pictures of a run directory.

/// Stress and broken bonds against strain.
pub const CURVES: &str = "curves.svg";
/// Volumetric against axial strain.
pub const VOLUMETRIC: &str = "volumetric.svg";
/// Probes: force against displacement, or motion against time.
pub const PROBES: &str = "probes.svg";
/// All pictures.
pub const FILES: [&str; 3] = [CURVES, VOLUMETRIC, PROBES];
