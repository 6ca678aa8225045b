//! `history.csv`: one row per increment.
//!
//! Strains and stresses are positive in contraction and compression. A field is empty if the scene
//! does not define the value, or if it does not exist yet: strains begin with the reference stage.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;
use indexmap::IndexSet;

use clastic_components::prelude::*;

use super::OutputError;
use super::csv_file::{self, Column, Field, Row, names};
use super::run_directory::RunDirectory;
use super::wanted::Wanted;
use crate::scene::format::{Scene, Specimen, Stage};

/// Columns before those of the probes.
const COLUMNS: [Column<Observation>; 28] = [
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
const ENERGY_COLUMNS: [Column<EnergyLedger>; 14] = [
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
pub(super) const PROBE_COLUMNS: [Column<ProbeReading>; 6] = [
    (".x_m", |probe| probe.motion[0].into()),
    (".y_m", |probe| probe.motion[1].into()),
    (".rotation_rad", |probe| probe.motion[2].into()),
    (".force_x_n", |probe| probe.force[0].into()),
    (".force_y_n", |probe| probe.force[1].into()),
    (".moment_nm", |probe| probe.force[2].into()),
];

/// Whether a column before or after those of the probes has this name, which no measure may have.
pub(crate) fn has_column(name: &str) -> bool {
    names(&COLUMNS).chain(names(&ENERGY_COLUMNS)).any(|column| column == name)
}

/// Names of the rigid groups of a scene: those from the start, then in the order of the stages that
/// make them.
pub fn rigid_groups(scene: &Scene) -> Vec<String> {
    let of_stages = scene.stages.iter().filter_map(Stage::load).flat_map(|load| &load.rigid);
    let made = of_stages.filter(|(_, control)| control.makes()).map(|(name, _)| name);
    let names: IndexSet<_> = scene.rigid_at_start.iter().chain(made).cloned().collect();
    names.into_iter().collect()
}

/// Names of a scene's probes: particles by index, then walls, then rigid groups.
pub fn probes(scene: &Scene) -> Vec<String> {
    let particles = match &scene.specimen {
        Specimen::Particles(list) => list.as_slice(),
        _ => &[],
    };
    let listed = particles.iter().zip(0..).filter_map(|(p, i)| Some((i, p.probe.clone()?)));
    let named = scene.probes.iter().map(|(name, i)| (*i, name.clone()));
    let of_particles: BTreeMap<u32, String> = listed.chain(named).collect();
    let of_walls = scene.walls.iter().filter_map(|w| w.probe.clone());
    let bodies: Vec<String> = of_particles.into_values().chain(of_walls).collect();
    bodies.into_iter().chain(rigid_groups(scene)).collect()
}

/// The columns of every history, with those of the probes.
fn header(probes: &[String]) -> Vec<String> {
    let of_probe = |name| names(&PROBE_COLUMNS).map(move |of| format!("{name}{of}"));
    let header = names(&COLUMNS).map(str::to_owned);
    header.chain(probes.iter().flat_map(of_probe)).collect()
}

/// All columns of the history of a scene, the last of which are its measures beside the axial and
/// lateral ones.
pub fn columns(scene: &Scene) -> Vec<String> {
    let mut header = header(&probes(scene));
    if scene.output.energy {
        header.extend(names(&ENERGY_COLUMNS).map(str::to_owned));
    }
    header.extend(scene.further_measures().map(|measure| measure.name.clone()));
    header
}

/// The row of the last increment of a world: its values of [`columns`]. `probes` are those of the
/// scene.
pub fn last_row(world: &World, probes: &[String]) -> Row {
    row(world.resource(), world.get_resource(), world.resource(), probes)
}

/// The row of an increment.
fn row(
    o: &Observation,
    ledger: Option<&EnergyLedger>,
    readings: &Readings,
    probes: &[String],
) -> Row {
    let of_probe = |name: &String| {
        // A removed wall leaves its columns empty.
        let reading = o.probes.iter().find(|reading| reading.name == *name);
        PROBE_COLUMNS.map(|(_, of)| reading.map_or(Field::Empty, of))
    };
    let energies = ledger.into_iter().flat_map(|ledger| ENERGY_COLUMNS.map(|(_, of)| of(ledger)));
    csv_file::row(&COLUMNS, o)
        .and(probes.iter().flat_map(of_probe))
        .and(energies)
        .and(readings.0.iter().copied())
}

/// System: verifies that the table still exists, before anything is written.
pub(super) fn is_there(run: Res<RunDirectory>) -> Result<(), OutputError> {
    run.tables.history.is_there()
}

/// System: writes the row of the increment, if wanted.
pub(super) fn write_wanted(
    wanted: Res<Wanted>,
    observation: Res<Observation>,
    ledger: Option<Res<EnergyLedger>>,
    readings: Res<Readings>,
    mut run: ResMut<RunDirectory>,
) -> Result<(), OutputError> {
    run.record.increments += 1;
    if !wanted.row {
        return Ok(());
    }
    let row = row(&observation, ledger.as_deref(), &readings, &run.probes);
    run.tables.history.push(row)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn header_is_the_documented_one() {
        let header = header(&["top".to_owned()]).join(",");
        let expected = "increment,stage,time_s,axial_strain,lateral_strain,volumetric_strain,\
            axial_stress_pa,lateral_stress_pa,contacts,bonds,broken_tension,broken_shear,\
            broken_rolling,solver_iterations,residual_balance,residual_kinematics,residual_cone,\
            residual_complementarity,imbalance_at_end,idle_motion,\
            status,fraction,potential_contacts,solves,motion_steps,kinetic_energy_j,\
            coulomb_residual,caps,top.x_m,top.y_m,top.rotation_rad,top.force_x_n,top.force_y_n,\
            top.moment_nm";
        assert_eq!(header, expected);
    }

    #[test]
    fn rows_match_the_header_and_absent_probes_are_empty() {
        let there =
            ProbeReading { name: "b".to_owned(), motion: [1.0, 2.0, 3.0], force: [4.0, 5.0, 6.0] };
        let observation = Observation { probes: vec![there], ..Default::default() };
        let names = ["a".to_owned(), "b".to_owned()];
        let line = row(&observation, None, &Readings::default(), &names).line();
        assert_eq!(line.split(',').count(), header(&names).len());
        assert!(line.ends_with(",,,,,,,1.0,2.0,3.0,4.0,5.0,6.0\n"), "{line}");
        assert!(line.starts_with("0,,0.0,,,,,,0,0,"), "{line}");
    }
}
