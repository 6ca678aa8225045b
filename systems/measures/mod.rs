//! Reads the named measures of a scene. A scene without any costs nothing here.

pub mod cracks;
pub mod fabric;
pub mod fragments;
mod front;
pub mod groups;
pub mod kept;
pub mod principal;
mod ring;
pub mod strain;
pub mod stress;

use std::f64::consts::PI;

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use clastic_components::prelude::*;
use clastic_cone::program::Interaction;
use clastic_cone::residuals::Carrying;

use crate::moved::Moved;
use crate::solved::Solved;
use crate::state::StateOf;
use strain::StrainTables;
use stress::{StressTables, area_of, as_it_carried};

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

/// Elastic energy of the contacts and bonds at the end of an increment,
/// `1/2 sum (C_N p^2 + C_T q^2 + C_R tau^2)`, J. The program has the forces at the point theta of
/// the increment, and compliances and offsets over theta. `bodies` are at its end, other tables
/// those of the solve.
pub(crate) fn elastic_energy(solved: Solved, corrections: &Corrections, theta: f64) -> f64 {
    stored(solved, theta, (theta < 1.0).then(|| force_at_end(solved, corrections, theta)))
}

/// Elastic energy that a static increment leaves to the next one, J. Normal forces are those of the
/// gaps: what the opening by associated friction adds ends with the increment.
pub fn elastic_energy_left(solved: Solved, corrections: &Corrections) -> f64 {
    stored(solved, 1.0, Some(force_at_end(solved, corrections, 1.0)))
}

/// Normal force of an elastic interaction at the end, N, by its place in the program. That of a contact or a
/// bond follows from the gap there: along the normal of the start, two bodies that pass each other would
/// seem to overlap, and a bond that turns far would seem to be stretched.
fn force_at_end(
    solved: Solved<'_>,
    corrections: &Corrections,
    theta: f64,
) -> impl Fn(usize, &Interaction) -> f64 {
    let Solved { bodies, contacts, program, solution } = solved;
    let end = Moved::not(bodies);
    move |k, c| {
        let overlap = match contacts.0.get(k) {
            Some(contact) => {
                let [turned, lag] = corrections.shift(contact);
                let start = theta * (c.offset - turned - lag);
                let born = contact.bond.map_or(0.0, |_| contact.gap - start);
                born - end.gap(bodies, contact.a, contact.b)
            }
            None => program.kinematics(c, &solution.displacements)[0] - theta * c.offset,
        };
        overlap / (theta * c.normal_compliance)
    }
}

/// Elastic energy at the end of the increment, J. `at_end` gives the normal forces of elastic
/// interactions from their gaps there; without it they are those of the solution.
fn stored(
    Solved { program, solution, .. }: Solved,
    theta: f64,
    at_end: Option<impl Fn(usize, &Interaction) -> f64>,
) -> f64 {
    let interactions = program.interactions.iter().zip(&solution.forces).enumerate();
    let energies = interactions.map(|(k, (c, &[p, q, tau]))| {
        let p = match &at_end {
            Some(force) if c.normal_compliance > 0.0 => {
                let p = force(k, c);
                if c.limits.has_strength() { p } else { p.max(0.0) }
            }
            _ => p,
        };
        let at_end = |force: f64, before: f64| before + (force - before) / theta;
        let (q, tau) = (at_end(q, c.previous_shear), at_end(tau, c.previous_moment));
        0.5 * theta
            * (c.normal_compliance * p * p
                + c.tangential_compliance * q * q
                + c.rolling_compliance * tau * tau)
    });
    energies.sum()
}

/// Reads stresses and forces on groups, which refer to the geometry at the start of the increment.
pub(crate) fn read_start(
    tables: StressTables,
    named: Res<NamedMeasures>,
    mut out: ResMut<Readings>,
) {
    if named.list.is_empty() {
        return;
    }
    let carries = tables.carries();
    let read = |quantity: &Option<Quantity>| {
        quantity.as_ref().filter(|_| carries).and_then(|quantity| tables.reading_now(quantity))
    };
    out.0.clear();
    out.0.extend(named.list.iter().map(|(_, quantity)| read(quantity)));
}

/// Tables from which the readings at the end of an increment follow.
#[derive(SystemParam)]
pub(crate) struct EndTables<'w, 's> {
    stresses: StressTables<'w, 's>,
    observation: Res<'w, Observation>,
    strains: StrainTables<'w, 's>,
    corrections: Res<'w, Corrections>,
    path: Option<Res<'w, StrainPath>>,
    cracks: Option<Res<'w, CrackSums>>,
    poured: Option<Res<'w, Poured>>,
    particles: Query<'w, 's, ring::ParticleForce, With<Particle>>,
}

impl EndTables<'_, '_> {
    fn read(&self, quantity: &Quantity, reference: Option<f64>) -> Option<f64> {
        let Self { stresses, observation, .. } = self;
        let (solved, analysis) = (stresses.solved(), &stresses.analysis);
        let bodies = solved.bodies;
        let broken = |modes: Modes| observation.broken[modes.places()].iter().sum::<usize>();
        let carrying = || stresses.carries().then_some(solved);
        let elastic =
            || Some(elastic_energy(carrying()?, &self.corrections, analysis.kind.theta()));
        match quantity {
            Quantity::Strain(measure) => self.strains.strain(measure, reference),
            // These are read at the start, by the stages, or by the plugin.
            Quantity::Stress(_) | Quantity::GroupForce { .. } | Quantity::Custom(_) => None,
            Quantity::Porosity(MeasureArea::Membrane(membrane)) => {
                porosity_within(bodies, stresses.membranes.get(*membrane).ok()?)
            }
            Quantity::Porosity(area) => {
                let area = area_of(area, bodies.cell, |a, b| self.strains.between(a, b))?;
                let disks: f64 = bodies.radii.iter().map(|r| PI * r * r).sum();
                Some(1.0 - disks / area)
            }
            Quantity::Coordination { rattlers } => coordination(carrying()?, *rattlers),
            Quantity::Broken(modes) => Some(broken(*modes) as f64),
            Quantity::BrokenShare(modes) => {
                let bonds = broken(Modes::All) + observation.bonds;
                (bonds > 0).then(|| broken(*modes) as f64 / bonds as f64)
            }
            Quantity::VolumetricStrain => observation.volumetric_strain,
            Quantity::DilationAngle { over } => {
                strain::dilation_angle(&self.path.as_ref()?.0, *over)
            }
            Quantity::Fabric { component, network } => {
                fabric::fabric(carrying()?, *component, *network)
            }
            Quantity::Fragments(part) => fragments::read(bodies, *part),
            Quantity::Cracks { part, mode } => cracks::read(self.cracks.as_ref()?, *mode, *part),
            Quantity::KineticEnergy => Some(observation.kinetic_energy),
            Quantity::ElasticEnergy => elastic(),
            Quantity::KineticOverElastic => {
                let elastic = elastic().filter(|elastic| *elastic > 0.0)?;
                Some(observation.kinetic_energy / elastic)
            }
            Quantity::WallForce { wall, along } => {
                let (wall, force, motion, _) = stresses.forces.get(*wall).ok()?;
                let wall = as_it_carried(wall, motion);
                let force = DVec2::new(force.0[0], force.0[1]);
                Some(match along {
                    ForceComponent::Normal => force.dot(wall.inward()),
                    ForceComponent::Tangent => force.dot(wall.tangent),
                    ForceComponent::X => force.x,
                    ForceComponent::Y => force.y,
                })
            }
            Quantity::Membrane { membrane, value } => {
                let shape = stresses.membranes.get(*membrane).ok()?;
                match value {
                    MembraneValue::Grains => Some(shape.grains() as f64),
                    MembraneValue::Area => shape.area(),
                    MembraneValue::Width => shape.width(),
                    MembraneValue::OuterArea => shape.outer_area(),
                    MembraneValue::OuterWidth => shape.outer_width(),
                }
            }
            Quantity::Poured(amount) => {
                let poured = self.poured.as_ref().map_or((0.0, 0.0), |p| (p.number as f64, p.mass));
                Some(if *amount == GrainAmount::Mass { poured.1 } else { poured.0 })
            }
            Quantity::Grains { amount, min, max, moved } => {
                let min = min.map_or(DVec2::NEG_INFINITY, DVec2::from);
                let max = max.map_or(DVec2::INFINITY, DVec2::from);
                let mut mass = 0.0;
                let (mut number, mut counted) = (0.0, 0.0);
                for (i, of_grain) in bodies.masses.iter().enumerate().take(bodies.particles) {
                    let x = bodies.positions[i];
                    mass += of_grain;
                    if min.cmple(x).all()
                        && x.cmple(max).all()
                        && (*moved == 0.0 || self.strains.motion(bodies.ids[i], x)? >= *moved)
                    {
                        number += 1.0;
                        counted += of_grain;
                    }
                }
                Some(match amount {
                    GrainAmount::Number => number,
                    GrainAmount::Mass => counted,
                    GrainAmount::Share if mass > 0.0 => counted / mass,
                    GrainAmount::Share => return None,
                })
            }
            Quantity::Front { along, share } => front::read(bodies, *along, *share),
            Quantity::Ring { centre, radii, value } => {
                let ring = ((*centre).into(), *radii, analysis.thickness);
                ring::read(&self.particles, self.strains.starts()?, ring, *value)
            }
            Quantity::Gravity => Some(analysis.gravity.length()),
            Quantity::StrengthFactor => Some(analysis.strength),
            Quantity::Time => Some(observation.time),
        }
    }
}

/// Porosity of the outer area of a membrane. Disks that have left the specimen do not count.
fn porosity_within(bodies: &BodyTable, shape: &MembraneShape) -> Option<f64> {
    let area = shape.outer_area()?;
    let particles = bodies.ids.iter().zip(&bodies.positions).zip(&bodies.radii);
    let holds = shape.holds();
    let held = particles.filter(|((id, x), _)| holds(**id, **x));
    Some(1.0 - held.map(|(_, r)| PI * r * r).sum::<f64>() / area)
}

/// Mean number of contacts with force per particle.
fn coordination(solved: Solved, rattlers: bool) -> Option<f64> {
    let mut counts = vec![0_u32; solved.bodies.particles];
    let carrying = Carrying::new(solved.program, solved.solution);
    // Interactions of plugins come after those of the contacts.
    for (k, contact) in solved.contacts.0.iter().enumerate() {
        if carrying.is_carrying(k) {
            for body in [contact.a, contact.b] {
                if let Some(count) = counts.get_mut(body as usize) {
                    *count += 1;
                }
            }
        }
    }
    counts.retain(|count| rattlers || *count >= 2);
    let sum: u32 = counts.iter().sum();
    (!counts.is_empty()).then(|| f64::from(sum) / counts.len() as f64)
}

/// Reads all other measures except those of plugins.
pub(crate) fn read_end(tables: EndTables, named: Res<NamedMeasures>, mut out: ResMut<Readings>) {
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
