//! Columns that every `history.csv` has. The output writes them, and measures of a scene have other
//! names.

/// Columns before those of the probes.
pub const COLUMNS: [&str; 28] = [
    "increment",
    "stage",
    "time_s",
    "axial_strain",
    "lateral_strain",
    "volumetric_strain",
    "axial_stress_pa",
    "lateral_stress_pa",
    "contacts",
    "bonds",
    "broken_tension",
    "broken_shear",
    "broken_rolling",
    "solver_iterations",
    "residual_balance",
    "residual_kinematics",
    "residual_cone",
    "residual_complementarity",
    "imbalance_at_end",
    "idle_motion",
    "status",
    "fraction",
    "potential_contacts",
    "solves",
    "motion_steps",
    "kinetic_energy_j",
    "coulomb_residual",
    "caps",
];

/// Columns after those of the probes, if the scene requests the energy ledger. All are sums since
/// the start except the elastic energy, which is the current value.
pub const ENERGY_COLUMNS: [&str; 14] = [
    "energy_external_j",
    "energy_gravity_j",
    "energy_exchange_j",
    "energy_kinetic_change_j",
    "energy_elastic_j",
    "energy_friction_j",
    "energy_rolling_j",
    "energy_dilation_j",
    "energy_collision_j",
    "energy_rupture_j",
    "energy_motion_j",
    "energy_turning_j",
    "energy_numerical_j",
    "energy_error_j",
];

/// Columns of each probe, after its name: displacement since the start of the stage list, and force
/// and moment of the outside world on the body.
pub const PROBE_COLUMNS: [&str; 6] =
    [".x_m", ".y_m", ".rotation_rad", ".force_x_n", ".force_y_n", ".moment_nm"];
