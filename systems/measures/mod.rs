//! Reads the named measures of a scene. A scene without any costs nothing here.

pub mod groups;
pub mod stress;

use std::f64::consts::PI;

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use clastic_components::attempt::{Attempt, IncrementStatus};
use clastic_components::body::{ExternalForce, Position};
use clastic_components::bond::RuptureMode;
use clastic_components::cell::PeriodicCell;
use clastic_components::contact::{Bodies, Contacts};
use clastic_components::increment::{Analysis, AnalysisKind};
use clastic_components::measure::{
    ForceComponent, MembraneValue, NamedMeasures, Quantity, Readings,
};
use clastic_components::membrane::MembraneShape;
use clastic_components::observation::{MeasureArea, Observation, StrainMeasure};
use clastic_components::particle::Particle;
use clastic_components::wall::Wall;
use clastic_cone::program::{ConeProgram, ConeSolution};
use clastic_cone::residuals::Carrying;

use crate::control_walls::wall_distance;
use crate::state::StateOf;
use stress::StressTables;

/// Name of [`NamedState`] in a state.
pub const NAMED: &str = "measures.named";

/// Reference distances and last readings of the named measures. A world without such measures has
/// no such state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NamedState {
    references: Vec<Option<f64>>,
    readings: Readings,
}

impl NamedState {
    /// The state with these readings.
    #[must_use]
    pub fn with(named: &NamedMeasures, readings: &Readings) -> Self {
        Self { references: named.references.clone(), readings: readings.clone() }
    }
}

impl StateOf for NamedState {
    fn take(world: &mut World) -> Option<Self> {
        let named = world.get_resource::<NamedMeasures>()?;
        let readings = world.get_resource::<Readings>()?;
        (!named.list.is_empty()).then(|| Self::with(named, readings))
    }

    fn put(self, world: &mut World) {
        world.get_resource_or_init::<NamedMeasures>().references = self.references;
        world.insert_resource(self.readings);
    }
}

/// Elastic energy of the contacts and bonds of a solution, `1/2 sum (C_N p^2 + C_T q^2)`, J.
#[must_use]
pub fn elastic_energy(program: &ConeProgram, solution: &ConeSolution) -> f64 {
    let interactions = program.interactions.iter().zip(&solution.forces);
    let energies = interactions.map(|(c, [p, q, _])| {
        0.5 * (c.normal_compliance * p * p + c.tangential_compliance * q * q)
    });
    energies.sum()
}

/// Strain since the reference value `then` of a measure.
#[must_use]
pub fn strain_since(measure: &StrainMeasure, then: f64, now: f64) -> f64 {
    match measure {
        StrainMeasure::CellShear => now - then,
        _ => (then - now) / then,
    }
}

/// Current value of the distance of a strain measure, m; of a shear the strain itself.
#[must_use]
pub fn strain_distance(
    measure: &StrainMeasure,
    walls: &Query<(&Wall, &Position)>,
    particles: &Query<&Position, With<Particle>>,
    membranes: &Query<&MembraneShape>,
    cell: Option<&PeriodicCell>,
) -> Option<f64> {
    let distance = match *measure {
        StrainMeasure::CellWidth => cell?.width,
        StrainMeasure::CellHeight => cell?.height,
        StrainMeasure::CellShear => cell?.shear,
        // Between walls of which one is gone there is no distance.
        StrainMeasure::Walls(a, b) if walls.contains(a) && walls.contains(b) => {
            wall_distance(a, b, walls)
        }
        StrainMeasure::Walls(..) => return None,
        StrainMeasure::Particles(a, b) => {
            particles.get(a).ok()?.0.distance(particles.get(b).ok()?.0)
        }
        StrainMeasure::Membrane(membrane) => membranes.get(membrane).ok()?.width()?,
    };
    Some(distance)
}

/// Reads stresses and forces on groups, which refer to the geometry at the start of the increment.
pub fn read_start(tables: StressTables, named: Res<NamedMeasures>, mut out: ResMut<Readings>) {
    if named.list.is_empty() {
        return;
    }
    let read = |quantity: &Option<Quantity>| match quantity {
        Some(Quantity::Stress(measure)) => tables.stress(measure),
        Some(Quantity::GroupForce { members, component }) => {
            tables.force_on(members).map(|force| force[*component])
        }
        _ => None,
    };
    out.0.clear();
    out.0.extend(named.list.iter().map(|(_, quantity)| read(quantity)));
}

/// What the readings at the end of an increment follow from.
#[derive(SystemParam)]
pub struct EndTables<'w, 's> {
    bodies: Res<'w, Bodies>,
    contacts: Res<'w, Contacts>,
    program: Res<'w, ConeProgram>,
    solution: Res<'w, ConeSolution>,
    analysis: Res<'w, Analysis>,
    attempt: Res<'w, Attempt>,
    observation: Res<'w, Observation>,
    walls: Query<'w, 's, (&'static Wall, &'static Position)>,
    particles: Query<'w, 's, &'static Position, With<Particle>>,
    forces: Query<'w, 's, (&'static Wall, &'static ExternalForce)>,
    membranes: Query<'w, 's, &'static MembraneShape>,
    cell: Option<Res<'w, PeriodicCell>>,
}

impl EndTables<'_, '_> {
    /// Whether the last solution has physical forces. Those of a compaction come from its
    /// regularisation.
    fn carries(&self) -> bool {
        !matches!(self.analysis.kind, AnalysisKind::LeastMotion { .. })
            && matches!(self.attempt.status, IncrementStatus::Solved | IncrementStatus::Capped)
    }

    fn read(&self, quantity: &Quantity, reference: Option<f64>) -> Option<f64> {
        let elastic = || self.carries().then(|| elastic_energy(&self.program, &self.solution));
        match quantity {
            Quantity::Strain(measure) => {
                let reference = reference?;
                let cell = self.cell.as_deref();
                let now =
                    strain_distance(measure, &self.walls, &self.particles, &self.membranes, cell)?;
                Some(strain_since(measure, reference, now))
            }
            // Read at the start, and by the plugin.
            Quantity::Stress(_) | Quantity::GroupForce { .. } | Quantity::Custom(_) => None,
            Quantity::Porosity(area) => {
                let distance = |a: Entity, b: Entity| {
                    let there = self.walls.contains(a) && self.walls.contains(b);
                    there.then(|| wall_distance(a, b, &self.walls))
                };
                let area = match area {
                    MeasureArea::Fixed(area) => *area,
                    MeasureArea::Cell => self.cell.as_ref()?.area(),
                    MeasureArea::Box([a, b, c, d]) => distance(*a, *b)? * distance(*c, *d)?,
                    MeasureArea::Membrane(membrane) => {
                        self.membranes.get(*membrane).ok()?.area()?
                    }
                };
                let disks: f64 = self.bodies.radii.iter().map(|r| PI * r * r).sum();
                Some(1.0 - disks / area)
            }
            Quantity::Coordination { rattlers } => self.coordination(*rattlers),
            Quantity::Broken { mode, share } => {
                let broken = |mode: RuptureMode| self.observation.broken[mode as usize];
                let all: usize = self.observation.broken.iter().sum();
                let count = mode.map_or(all, broken) as f64;
                let bonds = (all + self.observation.bonds) as f64;
                if *share { (bonds > 0.0).then(|| count / bonds) } else { Some(count) }
            }
            Quantity::KineticEnergy => Some(self.observation.kinetic_energy),
            Quantity::ElasticEnergy => elastic(),
            Quantity::KineticOverElastic => {
                let elastic = elastic().filter(|elastic| *elastic > 0.0)?;
                Some(self.observation.kinetic_energy / elastic)
            }
            Quantity::WallForce { wall, along } => {
                let (wall, force) = self.forces.get(*wall).ok()?;
                let force = DVec2::new(force.0[0], force.0[1]);
                Some(match along {
                    ForceComponent::Normal => force.dot(wall.inward()),
                    ForceComponent::Tangent => force.dot(wall.tangent),
                    ForceComponent::X => force.x,
                    ForceComponent::Y => force.y,
                })
            }
            Quantity::Membrane { membrane, value } => {
                let shape = self.membranes.get(*membrane).ok()?;
                match value {
                    MembraneValue::Grains => Some(shape.grains() as f64),
                    MembraneValue::Area => shape.area(),
                    MembraneValue::Width => shape.width(),
                }
            }
            Quantity::Time => Some(self.observation.time),
        }
    }

    fn coordination(&self, rattlers: bool) -> Option<f64> {
        if !self.carries() {
            return None;
        }
        let mut contacts = vec![0_u32; self.bodies.particles];
        let carrying = Carrying::new(&self.program, &self.solution);
        // Interactions of plugins come after those of the contacts.
        for (k, contact) in self.contacts.0.iter().enumerate() {
            if carrying.is_carrying(k) {
                for body in [contact.a, contact.b] {
                    if let Some(count) = contacts.get_mut(body as usize) {
                        *count += 1;
                    }
                }
            }
        }
        contacts.retain(|count| rattlers || *count >= 2);
        let sum: u32 = contacts.iter().sum();
        (!contacts.is_empty()).then(|| f64::from(sum) / contacts.len() as f64)
    }
}

/// Reads all other measures but those of plugins.
pub fn read_end(tables: EndTables, named: Res<NamedMeasures>, mut out: ResMut<Readings>) {
    for (k, (_, quantity)) in named.list.iter().enumerate() {
        let Some(quantity) = quantity else { continue };
        if matches!(quantity, Quantity::Stress(_) | Quantity::GroupForce { .. }) {
            continue;
        }
        let reference = named.references.get(k).copied().flatten();
        if let Some(reading) = out.0.get_mut(k) {
            *reading = tables.read(quantity, reference);
        }
    }
}
