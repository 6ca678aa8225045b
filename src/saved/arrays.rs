//! System: the arrays of a saved state that programs such as numpy read.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;
use glam::DVec2;

use crate::frames::NONE;
use crate::frames::pairs::{code, contact};
use crate::tables::{Array, Tables};

type GroupParts<'a> = (
    &'a BodyId,
    &'a RigidGroup,
    &'a BodyPosition,
    &'a BodyRotation,
    &'a ContactForce,
    &'a BodyExternalForce,
);

/// Adds the arrays. The [`BodyTable`] must be up to date.
pub(super) fn write(
    InMut(tables): InMut<Tables>,
    bodies: Res<BodyTable>,
    (history, kept): (Res<ContactHistory>, Res<KeptRows>),
    cell: Option<Res<PeriodicCell>>,
    of_bodies: Query<(&BodyOrigin, &BodyExternalForce, Option<&Group>, Option<&Probe>)>,
    names: Query<&WallName>,
    groups: Query<GroupParts>,
    bonds: Query<(&BondId, &Bond, &BondState)>,
) {
    let n = bodies.particles;
    let mut put = |name: &str, array| tables.put(name, array);
    let numbers = |of: &[f64]| Array::column(of[..n].to_vec());
    let vectors = |of: &[DVec2]| Array::vectors(of[..n].iter().map(DVec2::to_array));
    let of_body = |row: usize| of_bodies.get(bodies.entities[row]).ok();
    let force = |row: usize| of_body(row).map_or([0.0; 3], |(_, force, ..)| force.0);
    put("particles.id", Array::column(bodies.ids[..n].iter().map(|id| id.0)));
    put("particles.position_m", vectors(&bodies.positions));
    let origins = (0..n).map(|k| of_body(k).map_or([0.0; 2], |(origin, ..)| origin.0.to_array()));
    put("particles.origin_m", Array::vectors(origins));
    put("particles.rotation_rad", numbers(&bodies.rotations));
    put("particles.radius_m", numbers(&bodies.radii));
    put("particles.mass_kg", numbers(&bodies.masses));
    put("particles.velocity_m_s", vectors(&bodies.velocities));
    put("particles.angular_velocity_rad_s", numbers(&bodies.angular_velocities));
    put("particles.external_force", Array::vectors((0..n).map(force)));
    put("particles.material", Array::column(bodies.materials[..n].to_vec()));
    let group = |k: usize| of_body(k)?.2.map(|group| group.0.clone());
    put("particles.group", Array::column((0..n).map(|k| group(k).unwrap_or_default())));
    let probe = |k: usize| of_body(k)?.3.map(|probe| probe.0.clone());
    put("particles.probe", Array::column((0..n).map(|k| probe(k).unwrap_or_default())));

    let rows = || bodies.walls.iter().map(|wall| wall.body as usize);
    put("walls.id", Array::column(rows().map(|k| bodies.ids[k].0)));
    let name = |k: usize| names.get(bodies.entities[k]).map(|name| name.0.clone());
    put("walls.name", Array::column(rows().map(|k| name(k).unwrap_or_default())));
    put("walls.middle_m", Array::vectors(rows().map(|k| bodies.positions[k].to_array())));
    let tangents = bodies.walls.iter().map(|wall| wall.tangent().to_array());
    put("walls.tangent", Array::vectors(tangents));
    put("walls.half_length_m", Array::column(bodies.walls.iter().map(|wall| wall.half_length)));
    put("walls.last_motion", Array::vectors(rows().map(|k| bodies.last_motion[k])));
    put("walls.external_force", Array::vectors(rows().map(force)));

    let list: Vec<_> = groups.iter().sort_unstable::<&BodyId>().collect();
    if !list.is_empty() {
        put("rigid.id", Array::column(list.iter().map(|(id, ..)| id.0)));
        put("rigid.name", Array::column(list.iter().map(|(_, group, ..)| group.name.clone())));
        let places = list.iter().map(|(_, _, place, ..)| place.0.to_array());
        put("rigid.position_m", Array::vectors(places));
        put("rigid.rotation_rad", Array::column(list.iter().map(|(_, _, _, turn, ..)| turn.0)));
        put("rigid.contact_force", Array::vectors(list.iter().map(|(.., force, _)| force.0)));
        put("rigid.external_force", Array::vectors(list.iter().map(|(.., force)| force.0)));
    }
    if let Some(cell) = cell {
        put("cell.size_m", Array::column([cell.width, cell.height, cell.tilt]));
        put("cell.shear", Array::single(cell.shear));
        put("cell.stress_pa", Array::column(cell.stress));
    }

    let list: Vec<_> = bonds.iter().sort_unstable::<&BondId>().collect();
    put("bonds.id", Array::column(list.iter().map(|(id, ..)| id.0)));
    put("bonds.a", Array::column(list.iter().map(|(_, bond, _)| bond.a.0)));
    put("bonds.b", Array::column(list.iter().map(|(_, bond, _)| bond.b.0)));
    put("bonds.state", Array::column(list.iter().map(|(.., state)| code(**state) - 1)));
    put("bonds.initial_gap_m", Array::column(list.iter().map(|(_, bond, _)| bond.initial_gap)));
    for (name, of) in LAW {
        put(name, Array::column(list.iter().map(|(_, bond, _)| of(&bond.law))));
    }

    let id = |row: u32| kept.ids.get(row as usize).copied().unwrap_or(BodyId(NONE));
    let ends: Vec<_> = history.0.iter().map(|m| (id(m.a), id(m.b))).collect();
    put("contacts.a", Array::column(ends.iter().map(|(a, _)| a.0)));
    put("contacts.b", Array::column(ends.iter().map(|(_, b)| b.0)));
    put("contacts.p_n", Array::column(history.0.iter().map(|m| m.p)));
    put("contacts.q_n", Array::column(history.0.iter().map(|m| m.q)));
    put("contacts.tau_nm", Array::column(history.0.iter().map(|m| m.tau)));
    let found: Vec<_> = ends.iter().map(|ends| contact(&bodies, *ends)).collect();
    let normals = found.iter().map(|c| c.map_or([f64::NAN; 2], |c| c.normal.to_array()));
    put("contacts.normal", Array::vectors(normals));
    put("contacts.gap_m", Array::column(found.iter().map(|c| c.map_or(f64::NAN, |c| c.gap))));
    let bonded = found.iter().map(|c| {
        let rows = c.map(|c| (c.a, c.b))?;
        let at = bodies.bonds.binary_search_by_key(&rows, |bond| (bond.a, bond.b)).ok()?;
        Some(bodies.bonds[at].id.0)
    });
    put("contacts.bond", Array::column(bonded.map(|id| id.unwrap_or(NONE))));
}

/// Arrays of the law of a bond.
const LAW: [(&str, fn(&BondLaw) -> f64); 7] = [
    ("bonds.normal_compliance_m_n", |law| law.normal_compliance),
    ("bonds.tangential_compliance_m_n", |law| law.tangential_compliance),
    ("bonds.rolling_compliance_rad_nm", |law| law.rolling_compliance),
    ("bonds.friction", |law| law.friction),
    ("bonds.rolling_friction", |law| law.rolling_friction),
    ("bonds.cohesion_pa", |law| law.cohesion),
    ("bonds.tensile_strength_pa", |law| law.tensile_strength),
];
