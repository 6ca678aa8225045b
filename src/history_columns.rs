//! Columns that every `history.csv` has. The output writes them, and measures of a scene have other
//! names.

use clastic_components::attempt::IncrementStatus;
use clastic_components::energy::EnergyLedger;
use clastic_components::observation::{Observation, ProbeReading};

use crate::output::csv_file::{Column, Field, names};

/// Columns before those of the probes.
pub const COLUMNS: [Column<Observation>; 28] = [
    ("increment", |o| o.increment.into()),
    ("stage", |o| o.stage.as_str().into()),
    ("time_s", |o| o.time.into()),
    ("axial_strain", |o| o.axial_strain.into()),
    ("lateral_strain", |o| o.lateral_strain.into()),
    ("volumetric_strain", |o| o.volumetric_strain.into()),
    ("axial_stress_pa", |o| o.axial_stress.into()),
    ("lateral_stress_pa", |o| o.lateral_stress.into()),
    ("contacts", |o| Field::Count(o.contacts as u64)),
    ("bonds", |o| Field::Count(o.bonds as u64)),
    ("broken_tension", |o| Field::Count(o.broken[0] as u64)),
    ("broken_shear", |o| Field::Count(o.broken[1] as u64)),
    ("broken_rolling", |o| Field::Count(o.broken[2] as u64)),
    ("solver_iterations", |o| Field::Count(o.iterations.into())),
    ("residual_balance", |o| of_solution(o, o.residuals.balance)),
    ("residual_kinematics", |o| of_solution(o, o.residuals.kinematics)),
    ("residual_cone", |o| of_solution(o, o.residuals.cone)),
    ("residual_complementarity", |o| of_solution(o, o.residuals.complementarity)),
    ("imbalance_at_end", |o| of_solution(o, o.imbalance)),
    ("idle_motion", |o| o.idle_motion.into()),
    ("status", |o| o.status.name().into()),
    ("fraction", |o| o.fraction.into()),
    ("potential_contacts", |o| Field::Count(o.potential_contacts as u64)),
    ("solves", |o| Field::Count(o.solves.into())),
    ("motion_steps", |o| Field::Count(o.motion_steps.into())),
    ("kinetic_energy_j", |o| o.kinetic_energy.into()),
    ("coulomb_residual", |o| o.coulomb_residual.into()),
    ("caps", |o| o.caps.as_str().into()),
];

/// A collapse has no solution and therefore no residuals.
fn of_solution(o: &Observation, residual: f64) -> Field<'static> {
    Some(residual).filter(|_| o.status != IncrementStatus::Collapsed).into()
}

/// Columns after those of the probes, if the scene requests the energy ledger. All are sums since
/// the start except the elastic energy, which is the current value.
pub const ENERGY_COLUMNS: [Column<EnergyLedger>; 14] = [
    ("energy_external_j", |e| e.total.external.into()),
    ("energy_gravity_j", |e| e.total.gravity.into()),
    ("energy_exchange_j", |e| e.total.exchange.into()),
    ("energy_kinetic_change_j", |e| e.total.kinetic.into()),
    ("energy_elastic_j", |e| e.stored.unwrap_or_default().into()),
    ("energy_friction_j", |e| e.total.friction.into()),
    ("energy_rolling_j", |e| e.total.rolling.into()),
    ("energy_dilation_j", |e| e.total.dilation.into()),
    ("energy_collision_j", |e| e.total.collision.into()),
    ("energy_rupture_j", |e| e.total.rupture.into()),
    ("energy_motion_j", |e| e.total.motion.into()),
    ("energy_turning_j", |e| e.total.turning.into()),
    ("energy_numerical_j", |e| e.total.numerical.into()),
    ("energy_error_j", |e| e.total.error().into()),
];

/// Columns of each probe, after its name: displacement since the start of the stage list, and force
/// and moment of the outside world on the body.
pub const PROBE_COLUMNS: [Column<ProbeReading>; 6] = [
    (".x_m", |probe| probe.motion[0].into()),
    (".y_m", |probe| probe.motion[1].into()),
    (".rotation_rad", |probe| probe.motion[2].into()),
    (".force_x_n", |probe| probe.force[0].into()),
    (".force_y_n", |probe| probe.force[1].into()),
    (".moment_nm", |probe| probe.force[2].into()),
];

/// Whether a column before or after those of the probes has this name.
pub fn has(name: &str) -> bool {
    names(&COLUMNS).chain(names(&ENERGY_COLUMNS)).any(|column| column == name)
}
