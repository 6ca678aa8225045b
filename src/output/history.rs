//! `history.csv`: one row per increment.
//!
//! Strains and stresses are positive in contraction and compression. A field is empty if the scene
//! does not define the value, or if it does not exist yet: strains begin with the reference stage.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;

use clastic_components::energy::EnergyLedger;
use clastic_components::measure::Readings;
use clastic_components::observation::Observation;

use super::csv_file::{Field, Row};
use super::run_directory::RunDirectory;
use super::wanted::Wanted;
use super::{OutputError, csv_file};
use crate::history_columns::{COLUMNS, ENERGY_COLUMNS, PROBE_COLUMNS};
use crate::scene::format::{Scene, Specimen};

/// Names of the rigid groups of a scene: those from the start, then in the order of the stages that
/// make them.
#[must_use]
pub fn rigid_groups(scene: &Scene) -> Vec<String> {
    let mut names = scene.rigid_at_start.clone();
    for stage in &scene.stages {
        let Some(load) = stage.load() else { continue };
        let made = load.rigid.iter().filter(|(_, control)| control.makes());
        for (name, _) in made {
            if !names.contains(name) {
                names.push(name.clone());
            }
        }
    }
    names
}

/// Names of a scene's probes: particles by index, then walls, then rigid groups.
#[must_use]
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

/// The header.
#[must_use]
pub fn header(probes: &[String]) -> Vec<String> {
    let of_probe = |name| csv_file::names(&PROBE_COLUMNS).map(move |of| format!("{name}{of}"));
    let header = csv_file::names(&COLUMNS).map(str::to_owned);
    header.chain(probes.iter().flat_map(of_probe)).collect()
}

/// All columns of the history of a scene, the last of which are its measures beside the axial and
/// lateral ones.
#[must_use]
pub fn columns(scene: &Scene) -> Vec<String> {
    let mut header = header(&probes(scene));
    if scene.output.energy {
        header.extend(csv_file::names(&ENERGY_COLUMNS).map(str::to_owned));
    }
    header.extend(scene.further_measures().map(|measure| measure.name.clone()));
    header
}

/// The row of the last increment of a world: its values of [`columns`]. `probes` are those of the
/// scene.
#[must_use]
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
    use clastic_components::observation::ProbeReading;

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
