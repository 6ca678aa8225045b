//! Names of the pictures of a run directory.

/// Stress and broken bonds against strain.
pub const CURVES: &str = "curves.svg";
/// Volumetric against axial strain.
pub const VOLUMETRIC: &str = "volumetric.svg";
/// Probes: force against displacement, or motion against time.
pub const PROBES: &str = "probes.svg";
/// The specimen at the end.
pub const SPECIMEN: &str = "specimen.svg";
/// The specimen at the peak of the axial stress.
pub const SPECIMEN_PEAK: &str = "specimen_peak.svg";
/// The specimen at the end without its broken bonds, if it has any.
pub const FIELD: &str = "specimen_field.svg";
/// The specimen at the peak of the axial stress without its broken bonds.
pub const FIELD_PEAK: &str = "specimen_peak_field.svg";
/// The mechanism of the first collapse, drawn when it happens.
pub const MECHANISM: &str = "mechanism.svg";
/// All pictures.
pub const FILES: [&str; 8] =
    [CURVES, VOLUMETRIC, PROBES, SPECIMEN, SPECIMEN_PEAK, FIELD, FIELD_PEAK, MECHANISM];
