//! Stresses: forces of walls over a length, and averages over an area (Love, Weber).

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::DVec2;

use clastic_components::prelude::*;
use clastic_cone::residuals::{displacement_scale, force_scale};

use super::groups;
use super::principal::Principal;
use crate::assemble_program::taut;
use crate::control_walls::wall_distance;
use crate::solved::{Solved, SolvedTables};

/// Average stress tensor `sum (p n + q t) (x) l / V` of Love and Weber, Pa, compression positive.
/// The branch l goes from centre to centre, and at a wall from the centre to the line of the wall.
/// The stress then equals that of the wall forces, whatever the gap or overlap at the walls. Forces
/// have the directions of the program, in which they balance, so that the sum is that of any
/// positions.
/// `area` is in m^2.
pub fn average_stress(solved: Solved, area: f64, thickness: f64) -> [[f64; 2]; 2] {
    moments(solved, |_| 1.0).map(|row| row.map(|s| s / (area * thickness)))
}

/// Sum of f (x) l over all contacts, each with a weight, N m. The force of a taut bond is that of its
/// contact and of its tie.
fn moments(solved: Solved, weight: impl Fn(&Contact) -> f64) -> [[f64; 2]; 2] {
    let Solved { bodies, contacts, program, solution } = solved;
    let mut sum = [[0.0; 2]; 2];
    let own = (0..contacts.0.len()).map(|k| (k, k));
    for (contact, k) in own.chain(taut::ties(solved)) {
        let contact = &contacts.0[contact];
        let force = program.interactions[k].force(&solution.forces[k]);
        let l = contact.normal * branch(bodies, contact);
        let weight = weight(contact);
        for i in 0..2 {
            for j in 0..2 {
                sum[i][j] += weight * force[i] * l[j];
            }
        }
    }
    sum
}

/// The wall in its direction at the start of the last increment, in which its contacts carried
/// their forces.
pub fn as_it_carried(wall: &Wall, motion: &LastMotion) -> Wall {
    let [_, _, angle] = motion.0;
    if angle == 0.0 { *wall } else { wall.turned(DVec2::from_angle(-angle)) }
}

/// Length of the branch of a contact, m.
fn branch(bodies: &BodyTable, contact: &Contact) -> f64 {
    let (a, b) = (contact.a as usize, contact.b as usize);
    bodies.radii[a] + contact.gap + bodies.radii.get(b).copied().unwrap_or(0.0)
}

/// Part of the branch of a contact that lies in a rectangle, 0 to 1.
fn part_inside(bodies: &BodyTable, contact: &Contact, min: DVec2, max: DVec2) -> f64 {
    let start = bodies.positions[contact.a as usize];
    let along = contact.normal * branch(bodies, contact);
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for k in 0..2 {
        let (x, l) = (start[k], along[k]);
        if l == 0.0 {
            if x < min[k] || x > max[k] {
                return 0.0;
            }
            continue;
        }
        let (a, b) = ((min[k] - x) / l, (max[k] - x) / l);
        (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
    }
    (to - from).max(0.0)
}

fn component(stress: [[f64; 2]; 2], component: StressComponent) -> f64 {
    let (xx, yy, xy) = (stress[0][0], stress[1][1], 0.5 * (stress[0][1] + stress[1][0]));
    match component {
        StressComponent::Xx => xx,
        StressComponent::Yy => yy,
        StressComponent::Xy => xy,
        StressComponent::Mean => 0.5 * (xx + yy),
        StressComponent::Major => Principal::of(xx, yy, xy).major,
        StressComponent::Minor => Principal::of(xx, yy, xy).minor,
        StressComponent::Shear => -xy,
    }
}

/// Part of the force of one of the two walls that the pressure on the leaning sides of a specimen
/// adds of the membrane in the mean over all sections along it, over the thickness, N/m. The
/// pressure acts on the difference of the width of a section from that at the wall.
fn leaning(shape: &MembraneShape, wall: BodyId) -> Option<f64> {
    Some(shape.pressure * (shape.width()? - shape.base(wall)?))
}

/// The area of an average, m^2, with these distances of walls, m; `None` for that of a membrane.
pub(super) fn area_of(
    area: &MeasureArea,
    cell: Option<PeriodicCell>,
    distance: impl Fn(Entity, Entity) -> Option<f64>,
) -> Option<f64> {
    match *area {
        MeasureArea::Fixed(area) => Some(area),
        MeasureArea::Cell => Some(cell?.area()),
        MeasureArea::Box((a, b), (c, d)) => Some(distance(a, b)? * distance(c, d)?),
        MeasureArea::Membrane(_) => None,
    }
}

/// Tables of the increment from which stresses follow. Average stresses refer to the geometry at
/// its start, which [`BodyTable`] holds until it is gathered anew.
#[derive(SystemParam)]
pub struct StressTables<'w, 's> {
    tables: SolvedTables<'w>,
    pub(super) analysis: Res<'w, ClasticAnalysis>,
    attempt: Res<'w, Attempt>,
    geometry: Query<'w, 's, (&'static Wall, &'static BodyPosition)>,
    pub(super) forces: Query<
        'w,
        's,
        (&'static Wall, &'static BodyExternalForce, &'static LastMotion, &'static BodyId),
    >,
    pub(super) membranes: Query<'w, 's, &'static MembraneShape>,
}

impl StressTables<'_, '_> {
    /// The bodies with the last solution.
    pub(super) fn solved(&self) -> Solved<'_> {
        self.tables.get()
    }

    /// Whether the last solution has physical forces. Those of a compaction come from its
    /// regularisation and give no stress.
    pub(super) fn carries(&self) -> bool {
        !matches!(self.analysis.kind, AnalysisKind::Compaction { .. })
            && self.attempt.status.is_committed()
    }

    /// A stress, Pa; `None` where a wall is not there or nothing carries it.
    pub fn stress(&self, measure: &StressMeasure) -> Option<f64> {
        self.carries().then(|| self.stress_now(measure)).flatten()
    }

    /// Reading of a stress, or of the force on a group, by the forces in the tables, whatever they
    /// come from; `None` for another quantity.
    pub(super) fn reading_now(&self, quantity: &Quantity) -> Option<f64> {
        match quantity {
            Quantity::Stress(measure) => self.stress_now(measure),
            Quantity::GroupForce { select: members, along, .. } => {
                groups::force_on(members, self.solved()).map(|force| force[*along as usize])
            }
            _ => None,
        }
    }

    /// A stress of the forces in the tables, whatever they come from.
    pub(super) fn stress_now(&self, measure: &StressMeasure) -> Option<f64> {
        let (solved, thickness) = (self.solved(), self.analysis.thickness);
        let distance = |first, second| self.distance(first, second);
        match measure {
            StressMeasure::Walls { walls, length } => {
                let membrane = self.membrane_of(*length);
                let mut sum = 0.0;
                for entity in walls {
                    let (wall, force, motion, id) = self.forces.get(*entity).ok()?;
                    let inward = as_it_carried(wall, motion).inward();
                    sum += DVec2::new(force.0[0], force.0[1]).dot(inward);
                    sum += thickness * membrane.and_then(|m| leaning(m, *id)).unwrap_or(0.0);
                }
                let length = self.length(*length, distance)?;
                Some(sum / walls.len() as f64 / (length * thickness))
            }
            StressMeasure::Average { component: of, area } => {
                if let MeasureArea::Membrane(membrane) = area {
                    let shape = self.membranes.get(*membrane).ok()?;
                    return Some(component(self.within(shape)?, *of));
                }
                let size = area_of(area, solved.bodies.cell, distance)?;
                let mut stress = average_stress(solved, size, thickness);
                if matches!(area, MeasureArea::Cell) {
                    // A cell imposes the shear along x on its faces across y. The other one differs
                    // where forces turn with their bonds within the increment.
                    stress[1][0] = stress[0][1];
                }
                Some(component(stress, *of))
            }
            StressMeasure::Region { component: of, min, max } => {
                let (min, max) = (DVec2::from(*min), DVec2::from(*max));
                let part = |c: &Contact| part_inside(solved.bodies, c, min, max);
                let inside = |x: &DVec2| x.cmpge(min).all() && x.cmple(max).all();
                let mut centres = solved.bodies.positions[..solved.bodies.particles].iter();
                if !centres.any(inside) && solved.contacts.0.iter().all(|c| part(c) == 0.0) {
                    return None;
                }
                let sum = moments(solved, part);
                let volume = (max - min).element_product() * thickness;
                Some(component(sum.map(|row| row.map(|s| s / volume)), *of))
            }
            StressMeasure::Membrane(membrane) => Some(self.membranes.get(*membrane).ok()?.pressure),
        }
    }

    /// Average stress within a membrane, Pa. A closed one acts on the centres of its grains, and so
    /// does all else that loads the specimen: the average is that over the polygon through them.
    /// Between walls, which act on whole grains, it is that over the outer area. The strip from the
    /// centres to the outer points carries the pressure across, and nothing along the sides but the
    /// contacts.
    fn within(&self, shape: &MembraneShape) -> Option<[[f64; 2]; 2]> {
        let (inner, thickness) = (shape.area()?, self.analysis.thickness);
        let (area, across) = match shape.along() {
            Some(along) => (shape.outer_area()?, along),
            None => (inner, DVec2::ZERO),
        };
        let mut stress = average_stress(self.solved(), area, thickness);
        let strip = shape.pressure * (area - inner) / area;
        for (i, row) in stress.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry += strip * across[i] * across[j];
            }
        }
        Some(stress)
    }

    /// The membrane whose width is the length of a wall stress.
    fn membrane_of(&self, length: MeasureLength) -> Option<&MembraneShape> {
        let MeasureLength::Membrane(membrane) = length else { return None };
        self.membranes.get(membrane).ok()
    }

    /// The length of a wall stress, m, with these distances of walls.
    fn length(
        &self,
        length: MeasureLength,
        distance: impl Fn(Entity, Entity) -> Option<f64>,
    ) -> Option<f64> {
        match length {
            MeasureLength::Fixed(length) => Some(length),
            MeasureLength::Between(a, b) => distance(a, b),
            MeasureLength::Membrane(_) => self.membrane_of(length)?.outer_width(),
        }
    }

    /// Distance of two walls at the start of the increment, m. The load of a stress-controlled wall
    /// acts on this length, so the stress is measured on it.
    fn distance(&self, first: Entity, second: Entity) -> Option<f64> {
        let bodies = self.solved().bodies;
        let start = |wall: Entity| {
            let row = bodies.entities.iter().position(|e| *e == wall)?;
            Some(bodies.positions[row])
        };
        let (wall, _) = self.geometry.get(first).ok()?;
        Some((start(second)? - start(first)?).dot(wall.inward()))
    }
}

/// The error of a stress of the last increment that the tolerance of its solution allows, Pa.
///
/// Residuals are relative to the maximum force F and the maximum displacement U. The error of a
/// force is at most `residual F`. The error of a gap is at most `residual U`, which an elastic
/// contact converts to the force `residual U / C_N`. The result is the sum over the interactions
/// that contribute to the stress.
pub fn stress_error(In(measure): In<StressMeasure>, tables: StressTables) -> f64 {
    let Solved { bodies, contacts, program, solution } = tables.solved();
    let force = force_scale(program, &solution.forces);
    let motion = displacement_scale(program, &solution.displacements);
    let errors = contacts.0.iter().zip(&program.interactions).map(|(contact, c)| {
        let elastic = if c.normal_compliance > 0.0 { motion / c.normal_compliance } else { 0.0 };
        (contact, solution.tolerance * (force + elastic))
    });
    let distance = |a: Entity, b: Entity| Some(wall_distance(a, b, &tables.geometry));
    let (sum, area) = match &measure {
        StressMeasure::Walls { walls, length } => {
            let row = |wall: &Entity| {
                let (.., id) = tables.forces.get(*wall).ok()?;
                bodies.row(*id).map(|row| row as u32)
            };
            let walls: Vec<u32> = walls.iter().filter_map(row).collect();
            let at_walls = errors.filter(|(contact, _)| walls.contains(&contact.b));
            let sum: f64 = at_walls.map(|(_, error)| error).sum();
            (sum / walls.len() as f64, tables.length(*length, distance))
        }
        StressMeasure::Average { area, .. } => {
            let area = match area {
                MeasureArea::Membrane(membrane) => {
                    tables.membranes.get(*membrane).ok().and_then(MembraneShape::area)
                }
                _ => area_of(area, bodies.cell, distance),
            };
            let error = |(contact, error): (&Contact, f64)| error * branch(bodies, contact).abs();
            (errors.map(error).sum(), area)
        }
        StressMeasure::Region { min, max, .. } => {
            let (min, max) = (DVec2::from(*min), DVec2::from(*max));
            let error = |(contact, error): (&Contact, f64)| {
                let inside = part_inside(bodies, contact, min, max);
                error * inside * branch(bodies, contact).abs()
            };
            (errors.map(error).sum(), Some((max - min).element_product()))
        }
        // The pressure is imposed, so that it has no error.
        StressMeasure::Membrane(_) => return 0.0,
    };
    sum / (area.unwrap_or(f64::NAN) * tables.analysis.thickness)
}
