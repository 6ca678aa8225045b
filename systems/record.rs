//! Measures the increment. Measuring changes nothing: all other results are equal without this
//! plugin.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::prelude::*;

use crate::gather_bodies::gather_bodies;
use crate::measures::cracks::follow_cracks;
use crate::measures::kept::{Moving, kinetic_energy};
use crate::measures::strain::{StrainTables, follow_path};
use crate::measures::stress::StressTables;
use crate::measures::{NAMED, NamedState, read_end, read_start};
use crate::membranes::renew_shapes;
use crate::rupture::events;
use crate::schedule::{Increment, IncrementSystems, lap};
use crate::solved::{Solved, SolvedTables};
use crate::state::RegisterState;
use clastic_cone::residuals::Carrying;

/// Adds the systems of the record.
pub struct RecordPlugin;

impl Plugin for RecordPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<RuptureCount>()
            .add_systems(Increment, forget_ruptures.in_set(IncrementSystems::Draft));
        app.register_component::<BodyId, Probe>("probe")
            .register_resource::<Observation>(OBSERVATION)
            .register_resource::<RuptureCount>("rupture_count")
            // Reference lengths of the strains; their definitions are settings.
            .register_part(
                "measures.reference",
                |world| world.get_resource::<Measures>().map(|measures| measures.reference),
                |lengths, world| world.get_resource_or_init::<Measures>().reference = lengths,
            )
            .register_state::<NamedState>(NAMED)
            .register_resource::<StrainReference>("measures.start")
            .register_resource::<StrainPath>("measures.path")
            .register_resource::<CrackSums>("measures.cracks")
            .init_resource::<NamedMeasures>()
            .init_resource::<Readings>();
        app.init_resource::<Observation>().init_resource::<Measures>().add_systems(
            Increment,
            (
                // Stress refers to the geometry at the start of the increment, which `BodyTable`
                // still holds. Readers of the record need the geometry at its end, so `BodyTable`
                // is gathered again.
                (record_stress, read_start),
                gather_bodies,
                renew_shapes,
                record_strain,
                record_ruptures,
                follow_cracks,
                record_state,
                follow_path,
                record_probes,
                read_end,
                lap(|t| &mut t.record),
            )
                .chain()
                .in_set(IncrementSystems::Record),
        );
    }
}

/// Name of [`Observation`] in a state.
pub const OBSERVATION: &str = "observation";

/// Empties the list to which the rule of rupture adds.
fn forget_ruptures(mut out: ResMut<Observation>) {
    out.ruptures.clear();
}

/// Records the stresses. Average stresses refer to the geometry at the start of the increment.
fn record_stress(tables: StressTables, measures: Res<Measures>, mut out: ResMut<Observation>) {
    let stress = |measure: &Option<StressMeasure>| tables.stress(measure.as_ref()?);
    out.axial_stress = stress(&measures.axial_stress);
    out.lateral_stress = stress(&measures.lateral_stress);
}

/// Records the strains, which exist from the reference stage on.
fn record_strain(tables: StrainTables, measures: Res<Measures>, mut out: ResMut<Observation>) {
    let strain = |measure: &Option<StrainMeasure>, k: usize| {
        tables.strain(measure.as_ref()?, Some(measures.reference?[k]))
    };
    out.axial_strain = strain(&measures.axial_strain, 0);
    out.lateral_strain = strain(&measures.lateral_strain, 1);
    let strains = out.axial_strain.zip(out.lateral_strain);
    out.volumetric_strain = strains.map(|(a, l)| 1.0 - (1.0 - a) * (1.0 - l));
}

/// Records counters, residuals, energy and status.
fn record_state(
    tables: SolvedTables,
    progress: Res<ClasticProgress>,
    attempt: Res<Attempt>,
    (ruptures, corrections, sliding): (Res<Ruptures>, Res<Corrections>, Res<Sliding>),
    (rules, search): (Res<RuptureRules>, Res<EventSearch>),
    count: Res<RuptureCount>,
    moving: Query<Moving>,
    mut out: ResMut<Observation>,
) {
    out.increment = progress.increment;
    out.stage.clone_from(&progress.stage_name);
    out.fraction = progress.fraction;
    out.time = progress.time;
    let Solved { bodies, contacts, program, solution } = tables.get();
    let carrying = Carrying::new(program, solution);
    // Ties of taut bonds and interactions of plugins come after the contacts.
    let listed = 0..solution.forces.len().min(contacts.0.len());
    out.contacts = listed.filter(|k| carrying.is_carrying(*k)).count();
    out.potential_contacts = contacts.0.len();
    out.bonds = bodies.bonds.len();
    out.broken = count.0;
    out.kinetic_energy = kinetic_energy(moving.iter());
    out.solves = attempt.solves;
    out.motion_steps = attempt.motion_steps;
    out.iterations = attempt.iterations;
    out.residuals = solution.residuals;
    out.imbalance = corrections.imbalance;
    out.idle_motion = corrections.idle_motion;
    out.in_avalanche = search.in_avalanche;
    out.coulomb_residual = sliding.natural_map;
    out.rupture_lag = if ruptures.list.is_empty() {
        0.0
    } else {
        let change = events::change(program, solution);
        match (rules.order, search.active) {
            (RuptureOrder::Events, true) => (search.overload - 1.0).max(rules.tolerance),
            _ if search.dense => search.late * change,
            _ => change,
        }
    };
    let caps = [(corrections.capped, "geometry"), (sliding.capped, "coulomb")];
    let caps: Vec<_> = caps.iter().filter(|(capped, _)| *capped).map(|(_, name)| *name).collect();
    out.caps = caps.join("+");
    out.status = attempt.status;
}

/// Sorts the ruptures of the increment, and counts all broken bonds, whatever rule broke them.
fn record_ruptures(
    bonds: Query<&BondState>,
    mut count: ResMut<RuptureCount>,
    mut out: ResMut<Observation>,
) {
    out.ruptures.sort_unstable_by_key(|r| r.bond);
    *count = RuptureCount::default();
    for state in &bonds {
        if let BondState::Broken(mode) = state {
            count.0[*mode as usize] += 1;
        }
    }
}

/// Records the probes: displacement since the start of the stage list, and the external force.
fn record_probes(
    probes: Query<(
        &BodyId,
        &Probe,
        &BodyPosition,
        &BodyOrigin,
        Option<&BodyRotation>,
        Option<&WallRotation>,
        &BodyExternalForce,
        Option<&ContactForce>,
    )>,
    mut out: ResMut<Observation>,
) {
    let mut rows: Vec<(BodyId, ProbeReading, DVec2)> = probes
        .iter()
        .map(|(id, probe, x, origin, rotation, of_wall, force, of_contacts)| {
            // A group records the force on its boundary.
            let force = of_contacts.map_or(force.0, |force| force.0);
            let d = x.0 - origin.0;
            let turned = rotation.map(|r| r.0).or(of_wall.map(|r| r.0));
            let motion = [d.x, d.y, turned.unwrap_or(0.0)];
            (*id, ProbeReading { name: probe.0.clone(), motion, force }, x.0)
        })
        .collect();
    rows.sort_unstable_by_key(|(id, ..)| *id);
    out.probes.clear();
    let mut first = DVec2::ZERO;
    for (_, reading, x) in rows {
        match out.probes.last_mut().filter(|last| last.name == reading.name) {
            // The pieces of a polyline have one name. Their moment is about the middle of the
            // first.
            Some(sum) => {
                let [fx, fy, moment] = reading.force;
                sum.force[0] += fx;
                sum.force[1] += fy;
                sum.force[2] += moment + (x - first).perp_dot(DVec2::new(fx, fy));
            }
            None => {
                first = x;
                out.probes.push(reading);
            }
        }
    }
}
