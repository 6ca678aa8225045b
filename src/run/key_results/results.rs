//! Key results as `run.json` holds them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// A larger estimated error of the peak is worth a warning.
pub const PEAK_ERROR: f64 = 0.02;

/// Key results as in `run.json`; `None` for those that the run does not define.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Tangent modulus at the start of the reference stage: the slope over the first rise of the
    /// stress by a thousandth of the peak, between two points of the curve with different strains.
    /// Before, a platen may not have touched the specimen. `None` for a rigid specimen, and, as all
    /// elastic constants, where inertia carries a part of the load.
    pub youngs_modulus_pa: Option<f64>,
    /// Secant modulus from the start of the reference stage to half the peak.
    pub youngs_modulus_secant_half_peak_pa: Option<f64>,
    /// Poisson's ratio in the plane: minus the change of the lateral over that of the axial strain,
    /// from the first of the two points of the modulus to half the peak. The
    /// lateral stress must be constant.
    pub poissons_ratio: Option<f64>,
    /// Axial stress with the maximum difference from that at the start of the reference stage.
    pub peak_stress_pa: Option<f64>,
    /// Whether the increment of the peak is capped: its residual is then up to 1e-4.
    pub peak_is_capped: bool,
    /// Axial strain at the peak.
    pub strain_at_peak: Option<f64>,
    /// Strength: the peak, once the test has passed it under a constant lateral stress. Either the
    /// stress fell by a hundredth of the rise to the peak at a larger strain, or by a tenth at the
    /// same, or the specimen collapsed.
    pub strength_pa: Option<f64>,
    /// Residual strength: mean of the axial stress over the last fifth of the axial strain, if that
    /// lies beyond twice the strain at the peak and is level (Fairhurst and Hudson 1999, Int. J.
    /// Rock Mech. Min. Sci. 36, 279-289).
    pub residual_strength_pa: Option<f64>,
    /// Friction angle of one test on a specimen without bonds, at its strength, rad:
    /// `sin phi = (sigma_1 - sigma_3) / (sigma_1 + sigma_3)`.
    pub friction_angle_rad: Option<f64>,
    /// Estimate of the relative error of the peak due to the size of the increments. It is the
    /// delay of ruptures, as a relative change of force, in the last increment up to the peak with
    /// ruptures. `None` without ruptures. It does not include the effect of another order.
    pub peak_error_estimate: Option<f64>,
    /// Number of avalanches: ruptures at constant load, from the first to an equilibrium in which
    /// all bonds hold. 0 unless bonds break from event to event.
    pub avalanches: usize,
    /// Number of bonds broken in the largest avalanche.
    pub largest_avalanche: usize,
    /// Limit load: axial stress of the last increment before the first collapse. For a rigid
    /// specimen, which is at its limit whenever it carries load, it is the peak.
    pub limit_load_pa: Option<f64>,
    /// Mechanism of the first collapse that has one: its increment, margin and defect.
    pub mechanism: Option<MechanismRecord>,
    /// Porosity at the start of the reference stage.
    pub porosity: Option<f64>,
    /// Axial stress of the increment in which the first bond broke.
    pub first_crack_stress_pa: Option<f64>,
    /// Crack initiation: axial stress at which a hundredth of the bonds had broken that are broken
    /// at the strength (Potyondy and Cundall 2004, Int. J. Rock Mech. Min. Sci. 41, 1329-1364),
    /// counted from the start of the reference stage. Not defined where these are less than a
    /// hundred.
    pub crack_initiation_stress_pa: Option<f64>,
    /// Crack damage: axial stress at which the volume is at its minimum before the strength (Martin
    /// and Chandler 1994, Int. J. Rock Mech. Min. Sci. 31, 643-659).
    pub crack_damage_stress_pa: Option<f64>,
    /// Number of bonds ever created. Bonds that are neither intact nor broken were removed together
    /// with a wall.
    pub bonds_created: usize,
    /// Number of intact bonds.
    pub bonds_intact: usize,
    /// Number of broken bonds.
    pub bonds_broken: BrokenBonds,
    /// Maximum residuals of the run.
    pub worst_residuals: WorstResiduals,
    /// Solver iterations in all increments.
    pub solver_iterations: u64,
    /// Reasons for undefined key results, by their names.
    pub not_defined: BTreeMap<String, String>,
}

/// Quality of a mechanism, as in `run.json`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MechanismRecord {
    /// Increment of the collapse.
    pub increment: u64,
    /// Work of the loads minus maximum dissipation, over the work of the loads. A positive margin
    /// proves the collapse.
    pub margin: f64,
    /// Maximum violation of the kinematic conditions of the mechanism over its maximum motion.
    pub defect: f64,
}

/// Number of broken bonds by mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BrokenBonds {
    /// In tension.
    pub tension: usize,
    /// In shear.
    pub shear: usize,
    /// In rolling.
    pub rolling: usize,
}

/// Maximum residuals over all increments that have a solution (not collapsed or locked).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WorstResiduals {
    /// Residual of the balance.
    pub balance: Worst,
    /// Residual of the kinematics.
    pub kinematics: Worst,
    /// Residual of the limits.
    pub cone: Worst,
    /// Residual of the complementarity.
    pub complementarity: Worst,
}

/// A maximum and its increment (0 if none).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Worst {
    /// The value. NaN counts as larger than all numbers and is null in JSON.
    pub value: f64,
    /// The first increment with this value.
    pub increment: u64,
}

impl Worst {
    pub(super) fn see(&mut self, value: f64, increment: u64) {
        let worse = value > self.value || (value.is_nan() && !self.value.is_nan());
        if self.increment == 0 || worse {
            *self = Self { value, increment };
        }
    }
}
