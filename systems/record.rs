//! Measures the increment. Measuring changes nothing: all other results are equal without this
//! plugin.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use clastic_components::attempt::{Attempt, IncrementStatus};
use clastic_components::body::{
    AngularVelocity, BodyId, ExternalForce, Origin, Position, Probe, Rotation, Velocity,
};
use clastic_components::bond::{BondState, Rupture};
use clastic_components::contact::{Bodies, Contact, Contacts};
use clastic_components::findings::{Corrections, EventSearch, Ruptures, Sliding};
use clastic_components::increment::{
    Acceptance, Analysis, AnalysisKind, Progress, RuptureOrder, RuptureRules,
};
use clastic_components::observation::{
    MeasureArea, MeasureLength, Measures, Observation, ProbeReading, RuptureCount, StrainMeasure,
    StressComponent, StressMeasure,
};
use clastic_components::particle::Particle;
use clastic_components::rigid_group::ContactForce;
use clastic_components::wall::Wall;
use clastic_cone::program::{ConeProgram, ConeSolution};

use crate::attempt::events;
use crate::control_walls::wall_distance;
use crate::gather_bodies::gather_bodies;
use crate::schedule::{Increment, IncrementSystems, lap};
use crate::state::{RegisterState, StateOf};
use clastic_cone::residuals::{Carrying, displacement_scale, force_scale};

/// Adds the systems of the record.
pub struct RecordPlugin;

impl Plugin for RecordPlugin {
    fn build(&self, app: &mut App) {
        // A plugin with its own rupture rule writes the messages that are read here.
        app.init_resource::<RuptureCount>().init_resource::<Messages<Rupture>>();
        app.add_systems(Increment, update_messages.before(IncrementSystems::Controls));
        app.register_component::<BodyId, Probe>("probe")
            .register_resource::<Observation>(OBSERVATION)
            .register_resource::<RuptureCount>("rupture_count")
            .register_state::<ReferenceLengths>("measures.reference");
        app.init_resource::<Observation>().init_resource::<Measures>().add_systems(
            Increment,
            (
                // Stress refers to the geometry at the start of the increment, which `Bodies` still
                // holds. Readers of the record need the geometry at its end, so `Bodies` is
                // gathered again.
                record_stress,
                gather_bodies,
                record_strain,
                record_ruptures,
                record_state,
                record_probes,
                lap(|t| &mut t.record),
            )
                .chain()
                .in_set(IncrementSystems::Record),
        );
    }
}

/// Name of [`Observation`] in a state.
pub const OBSERVATION: &str = "observation";

/// Removes messages of ruptures after two increments. This works without an app as well.
fn update_messages(mut messages: ResMut<Messages<Rupture>>) {
    messages.update();
}

/// Reference lengths of the strains, m: axial and lateral. The definitions of the strains are
/// settings.
#[derive(Serialize, Deserialize)]
struct ReferenceLengths(Option<[f64; 2]>);

impl StateOf for ReferenceLengths {
    fn take(world: &mut World) -> Option<Self> {
        world.get_resource::<Measures>().map(|measures| Self(measures.reference))
    }

    fn put(self, world: &mut World) {
        world.get_resource_or_init::<Measures>().reference = self.0;
    }
}

/// Average stress tensor `sum (p n + q t) (x) l / V` of Love and Weber, Pa, compression positive.
/// The branch l goes from centre to centre, and at a wall from the centre to the line of the wall.
/// The stress then equals that of the wall forces, whatever the gap or overlap at the walls. `area`
/// is in m^2.
#[must_use]
pub fn average_stress(
    bodies: &Bodies,
    contacts: &Contacts,
    solution: &ConeSolution,
    area: f64,
    thickness: f64,
) -> [[f64; 2]; 2] {
    let mut sum = [[0.0; 2]; 2];
    for (contact, f) in contacts.0.iter().zip(&solution.forces) {
        let (a, b) = (contact.a as usize, contact.b as usize);
        let branch = bodies.radii[a] + contact.gap + bodies.radii.get(b).copied().unwrap_or(0.0);
        let (force, l) =
            (contact.normal * f[0] + contact.normal.perp() * f[1], contact.normal * branch);
        for i in 0..2 {
            for j in 0..2 {
                sum[i][j] += force[i] * l[j];
            }
        }
    }
    sum.map(|row| row.map(|s| s / (area * thickness)))
}

type Geometry<'w, 's> = Query<'w, 's, (&'static Wall, &'static Position)>;

/// Records the stresses. Average stresses refer to the geometry at the start of the increment.
fn record_stress(
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    solution: Res<ConeSolution>,
    analysis: Res<Analysis>,
    attempt: Res<Attempt>,
    measures: Res<Measures>,
    geometry: Geometry,
    forces: Query<(&Wall, &ExternalForce)>,
    mut out: ResMut<Observation>,
) {
    // The forces of a compaction come from its regularisation and give no stress.
    let carried = !matches!(analysis.kind, AnalysisKind::LeastMotion { .. })
        && matches!(attempt.status, IncrementStatus::Solved | IncrementStatus::Capped);
    let start =
        |wall: Entity| bodies.entities.iter().position(|e| *e == wall).map(|i| bodies.positions[i]);
    // The load of a stress-controlled wall acts on the length at the start of the increment, so the
    // stress is measured on this length.
    let distance = |first: Entity, second: Entity| {
        let (wall, _) = geometry.get(first).ok()?;
        Some((start(second)? - start(first)?).dot(wall.inward()))
    };
    let evaluate = |measure: &StressMeasure| -> Option<f64> {
        match measure {
            StressMeasure::Walls { walls, length: l } => {
                let mut sum = 0.0;
                for wall in walls {
                    let (wall, force) = forces.get(*wall).ok()?;
                    sum += DVec2::new(force.0[0], force.0[1]).dot(wall.inward());
                }
                let length = match *l {
                    MeasureLength::Fixed(length) => length,
                    MeasureLength::Between(a, b) => distance(a, b)?,
                };
                Some(sum / walls.len() as f64 / (length * analysis.thickness))
            }
            StressMeasure::Average { component, area } => {
                let area = match area {
                    MeasureArea::Fixed(area) => *area,
                    MeasureArea::Box([a, b, c, d]) => distance(*a, *b)? * distance(*c, *d)?,
                };
                let s = average_stress(&bodies, &contacts, &solution, area, analysis.thickness);
                Some(match component {
                    StressComponent::Xx => s[0][0],
                    StressComponent::Yy => s[1][1],
                    StressComponent::Xy => 0.5 * (s[0][1] + s[1][0]),
                })
            }
        }
    };
    out.axial_stress = measures.axial_stress.as_ref().filter(|_| carried).and_then(evaluate);
    out.lateral_stress = measures.lateral_stress.as_ref().filter(|_| carried).and_then(evaluate);
}

/// The error of the axial stress of the last increment that [`Acceptance::residual`] allows, Pa.
///
/// Residuals are relative to the maximum force F and the maximum displacement U. The error of a
/// force is at most `residual F`. The error of a gap is at most `residual U`, which an elastic
/// contact converts to the force `residual U / C_N`. The result is the sum over the interactions
/// that contribute to the stress.
pub fn axial_stress_error(
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    analysis: Res<Analysis>,
    acceptance: Res<Acceptance>,
    measures: Res<Measures>,
    geometry: Geometry,
    ids: Query<&BodyId>,
) -> Option<f64> {
    let residual = acceptance.residual.max(program.tolerance);
    let force = force_scale(&program, &solution.forces);
    let motion = displacement_scale(&program, &solution.displacements);
    let errors = contacts.0.iter().zip(&program.interactions).map(|(contact, c)| {
        let elastic = if c.normal_compliance > 0.0 { motion / c.normal_compliance } else { 0.0 };
        (contact, residual * (force + elastic))
    });
    let distance = |a: Entity, b: Entity| wall_distance(a, b, &geometry);
    let (sum, area) = match measures.axial_stress.as_ref()? {
        StressMeasure::Walls { walls, length } => {
            let row = |wall: &Entity| bodies.row(*ids.get(*wall).ok()?).map(|row| row as u32);
            let walls: Vec<u32> = walls.iter().filter_map(row).collect();
            let at_walls = errors.filter(|(contact, _)| walls.contains(&contact.b));
            let length = match *length {
                MeasureLength::Fixed(length) => length,
                MeasureLength::Between(a, b) => distance(a, b),
            };
            (at_walls.map(|(_, error)| error).sum::<f64>() / walls.len() as f64, length)
        }
        StressMeasure::Average { area, .. } => {
            let branch = |contact: &Contact| {
                let radius = |body: u32| bodies.radii.get(body as usize).copied().unwrap_or(0.0);
                radius(contact.a) + contact.gap + radius(contact.b)
            };
            let area = match area {
                MeasureArea::Fixed(area) => *area,
                MeasureArea::Box([a, b, c, d]) => distance(*a, *b) * distance(*c, *d),
            };
            (errors.map(|(contact, error)| error * branch(contact).abs()).sum(), area)
        }
    };
    Some(sum / (area * analysis.thickness))
}

/// Current value of the distance of a strain measure, m.
#[must_use]
pub fn strain_distance(
    measure: &StrainMeasure,
    walls: &Query<(&Wall, &Position)>,
    particles: &Query<&Position, With<Particle>>,
) -> Option<f64> {
    let distance = match *measure {
        // Between walls of which one is gone there is no distance.
        StrainMeasure::Walls(a, b) if walls.contains(a) && walls.contains(b) => {
            wall_distance(a, b, walls)
        }
        StrainMeasure::Walls(..) => return None,
        StrainMeasure::Particles(a, b) => {
            particles.get(a).ok()?.0.distance(particles.get(b).ok()?.0)
        }
    };
    Some(distance)
}

/// Sets the reference distances at the start of the reference stage. The stages run it once.
pub fn take_reference(
    walls: Query<(&Wall, &Position)>,
    particles: Query<&Position, With<Particle>>,
    mut measures: ResMut<Measures>,
) {
    let of = |m: &Option<StrainMeasure>| {
        m.as_ref().and_then(|m| strain_distance(m, &walls, &particles)).unwrap_or(f64::NAN)
    };
    measures.reference = Some([of(&measures.axial_strain), of(&measures.lateral_strain)]);
}

/// Records the engineering strains, which exist from the reference stage on.
fn record_strain(
    measures: Res<Measures>,
    walls: Query<(&Wall, &Position)>,
    particles: Query<&Position, With<Particle>>,
    mut out: ResMut<Observation>,
) {
    let strain = |measure: &Option<StrainMeasure>, k: usize| {
        let reference = measures.reference?[k];
        let now = strain_distance(measure.as_ref()?, &walls, &particles)?;
        Some((reference - now) / reference)
    };
    out.axial_strain = strain(&measures.axial_strain, 0);
    out.lateral_strain = strain(&measures.lateral_strain, 1);
    out.volumetric_strain = match (out.axial_strain, out.lateral_strain) {
        (Some(a), Some(l)) => Some(1.0 - (1.0 - a) * (1.0 - l)),
        _ => None,
    };
}

/// Records counters, residuals, energy and status.
fn record_state(
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    progress: Res<Progress>,
    attempt: Res<Attempt>,
    loops: (Res<Ruptures>, Res<Corrections>, Res<Sliding>),
    order: (Res<RuptureRules>, Res<EventSearch>),
    count: Res<RuptureCount>,
    moving: Query<(&BodyId, &Particle, &Velocity, &AngularVelocity)>,
    mut out: ResMut<Observation>,
) {
    out.increment = progress.increment;
    out.stage.clone_from(&progress.stage_name);
    out.fraction = progress.fraction;
    out.time = progress.time;
    let carrying = Carrying::new(&program, &solution);
    let interactions = 0..solution.forces.len().min(program.interactions.len());
    out.contacts = interactions.filter(|k| carrying.is_carrying(*k)).count();
    out.potential_contacts = contacts.0.len();
    out.bonds = bodies.bonds.len();
    out.broken = count.0;
    // The sum runs in the order of identities, because it depends on the order and query order may
    // vary.
    let mut energy: Vec<(BodyId, f64)> = moving
        .iter()
        .map(|(id, p, v, w)| (*id, 0.5 * (p.mass * v.0.length_squared() + p.inertia * w.0 * w.0)))
        .collect();
    energy.sort_unstable_by_key(|(id, _)| *id);
    out.kinetic_energy = energy.iter().map(|(_, e)| e).sum();
    out.solves = attempt.solves;
    out.motion_steps = attempt.motion_steps;
    out.motion_strain = attempt.motion_strain;
    out.iterations = attempt.iterations;
    out.residuals = solution.residuals;
    let (ruptures, corrections, sliding) = loops;
    out.in_avalanche = order.1.in_avalanche;
    out.coulomb_residual = sliding.natural_map;
    out.rupture_lag = if ruptures.list.is_empty() {
        0.0
    } else {
        let change = events::change(&program, &solution);
        match (order.0.order, order.1.active) {
            (RuptureOrder::Events, true) => (order.1.overload - 1.0).max(order.0.tolerance),
            _ => change,
        }
    };
    let caps = [
        (ruptures.capped, "cascade"),
        (corrections.capped, "corrector"),
        (sliding.capped, "coulomb"),
    ];
    let caps: Vec<_> = caps.iter().filter(|(capped, _)| *capped).map(|(_, name)| *name).collect();
    out.caps = caps.join("+");
    out.status = attempt.status;
}

/// Records the ruptures since the last record, and all broken bonds, whatever rule broke them.
fn record_ruptures(
    mut messages: MessageReader<Rupture>,
    bonds: Query<&BondState>,
    mut count: ResMut<RuptureCount>,
    mut out: ResMut<Observation>,
) {
    out.ruptures.clear();
    out.ruptures.extend(messages.read().copied());
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
        &Position,
        &Origin,
        Option<&Rotation>,
        &ExternalForce,
        Option<&ContactForce>,
    )>,
    mut out: ResMut<Observation>,
) {
    let mut rows: Vec<(BodyId, ProbeReading, DVec2)> = probes
        .iter()
        .map(|(id, probe, x, origin, rotation, force, of_contacts)| {
            // A group records the force on its boundary.
            let force = of_contacts.map_or(force.0, |force| force.0);
            let d = x.0 - origin.0;
            let motion = [d.x, d.y, rotation.map_or(0.0, |r| r.0)];
            (*id, ProbeReading { name: probe.0.clone(), motion, force }, x.0)
        })
        .collect();
    rows.sort_unstable_by_key(|(id, ..)| *id);
    out.probes.clear();
    let mut first = DVec2::ZERO;
    for (_, reading, x) in rows {
        match out.probes.last_mut().filter(|last| last.name == reading.name) {
            // The pieces of a polyline have one name. Their moment is about the middle of the first.
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
