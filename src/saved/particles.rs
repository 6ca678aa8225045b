//! The particles of a saved state.

use clastic_components::body::{
    BodyAngularVelocity, BodyExternalForce, BodyId, BodyOrigin, BodyPosition, BodyRotation,
    BodyVelocity, Group, LastMotion, Probe,
};
use clastic_components::particle::{MaterialIndex, Particle, SetAside, Swinging};
use clastic_systems::state::WorldState;
use glam::DVec2;

use super::SavedError;
use super::columns::{add, add_motions, bad, each, finite, identities, of, some};
use super::controls;
use crate::tables::{Array, Tables};

pub(super) const ENTRIES: [&str; 16] = [
    "angular_velocity",
    "applied_load",
    "drives",
    "external_force",
    "group",
    "last_motion",
    "load_control",
    "material",
    "origin",
    "particle",
    "position",
    "probe",
    "rotation",
    "set_aside",
    "swinging",
    "velocity",
];

/// Column of the particles that are set aside, in states with such particles.
const SET_ASIDE: &str = "particles.set_aside";

/// Columns of numbers.
const NUMBERS: [&str; 15] = [
    "particles.position_m",
    "particles.origin_m",
    "particles.rotation_rad",
    "particles.radius_m",
    "particles.mass_kg",
    "particles.inertia_kg_m2",
    "particles.velocity_m_s",
    "particles.angular_velocity_rad_s",
    "particles.last_motion",
    "particles.external_force",
    "particles.load_from",
    "particles.load_to",
    "particles.applied_from",
    "particles.applied_to",
    "particles.imposed_motion",
];

pub(super) fn write(state: &WorldState, tables: &mut Tables) -> Result<(), SavedError> {
    let particles = state.components::<BodyId, Particle>("particle")?;
    let ids: Vec<_> = particles.iter().map(|(id, _)| *id).collect();
    let ids = ids.as_slice();
    tables.put("particles.id", Array::u32(ids.iter().map(|id| id.0).collect()));
    let positions = each::<BodyPosition>(state, "position", ids)?;
    tables.put("particles.position_m", Array::vectors(positions.iter().map(|x| x.0.to_array())));
    let rotations = each::<BodyRotation>(state, "rotation", ids)?;
    tables.put("particles.rotation_rad", Array::f64(rotations.iter().map(|r| r.0).collect()));
    let column = |of: fn(&Particle) -> f64| particles.iter().map(|(_, p)| of(p)).collect();
    tables.put("particles.radius_m", Array::f64(column(|p| p.radius)));
    tables.put("particles.mass_kg", Array::f64(column(|p| p.mass)));
    tables.put("particles.inertia_kg_m2", Array::f64(column(|p| p.inertia)));
    let velocities = each::<BodyVelocity>(state, "velocity", ids)?;
    tables.put("particles.velocity_m_s", Array::vectors(velocities.iter().map(|v| v.0.to_array())));
    let spins =
        each::<BodyAngularVelocity>(state, "angular_velocity", ids)?.iter().map(|w| w.0).collect();
    tables.put("particles.angular_velocity_rad_s", Array::f64(spins));
    let materials = each::<MaterialIndex>(state, "material", ids)?;
    tables.put("particles.material", Array::u32(materials.iter().map(|m| m.0).collect()));
    let groups = of::<Group>(state, "group", ids)?.into_iter();
    let groups = groups.map(|group| group.map(|group| group.0).unwrap_or_default());
    tables.put("particles.group", Array::text(groups));
    let probes = of::<Probe>(state, "probe", ids)?.into_iter();
    let probes = probes.map(|probe| probe.map(|probe| probe.0).unwrap_or_default());
    tables.put("particles.probe", Array::text(probes));
    let origins = each::<BodyOrigin>(state, "origin", ids)?;
    tables.put("particles.origin_m", Array::vectors(origins.iter().map(|x| x.0.to_array())));
    let motions = each::<LastMotion>(state, "last_motion", ids)?;
    tables.put("particles.last_motion", Array::vectors(motions.iter().map(|u| u.0)));
    let forces = each::<BodyExternalForce>(state, "external_force", ids)?;
    tables.put("particles.external_force", Array::vectors(forces.iter().map(|f| f.0)));
    controls::write(state, "particles", ids, tables)?;
    let swinging = of::<Swinging>(state, "swinging", ids)?;
    tables.put("particles.swinging", Array::bool(swinging.iter().map(Option::is_some).collect()));
    let aside = of::<SetAside>(state, "set_aside", ids)?;
    if aside.iter().any(Option::is_some) {
        tables.put(SET_ASIDE, Array::bool(aside.iter().map(Option::is_some).collect()));
    }
    Ok(())
}

/// Reads the particles, whose materials are below `materials`. Returns their identities.
pub(super) fn read(
    tables: &Tables,
    materials: usize,
    state: &mut WorldState,
) -> Result<Vec<u32>, SavedError> {
    let numbers = identities(tables, "particles.id")?;
    let ids: Vec<_> = numbers.iter().map(|id| BodyId(*id)).collect();
    let (ids, n) = (ids.as_slice(), ids.len());
    finite(tables, &NUMBERS)?;
    let scalars = |name: &str| tables.f64(name, &[n]);
    let pairs = |name: &str| -> Result<Vec<DVec2>, SavedError> {
        Ok(tables.vectors::<2>(name, n)?.into_iter().map(DVec2::from).collect())
    };
    let triples = |name: &str| tables.vectors::<3>(name, n);

    let (radii, masses) = (scalars("particles.radius_m")?, scalars("particles.mass_kg")?);
    if let Some(row) = radii.iter().position(|radius| !(*radius > 0.0)) {
        return Err(bad("particles.radius_m", format!("not greater than 0 in row {row}")));
    }
    let disks = radii.iter().zip(masses).zip(scalars("particles.inertia_kg_m2")?);
    let disks = disks.map(|((radius, mass), inertia)| {
        let (radius, mass) = (*radius, *mass);
        Some(Particle { radius, mass, inertia: *inertia, thickness: None })
    });
    add(state, "particle", ids, disks)?;
    let places = pairs("particles.position_m")?;
    add(state, "position", ids, places.into_iter().map(|x| Some(BodyPosition(x))))?;
    let origins = pairs("particles.origin_m")?;
    add(state, "origin", ids, origins.into_iter().map(|x| Some(BodyOrigin(x))))?;
    let rotations = scalars("particles.rotation_rad")?;
    add(state, "rotation", ids, rotations.iter().map(|r| Some(BodyRotation(*r))))?;
    let velocities = pairs("particles.velocity_m_s")?;
    add(state, "velocity", ids, velocities.into_iter().map(|v| Some(BodyVelocity(v))))?;
    let spins = scalars("particles.angular_velocity_rad_s")?;
    add(state, "angular_velocity", ids, spins.iter().map(|w| Some(BodyAngularVelocity(*w))))?;
    let indices = tables.u32("particles.material", &[n])?;
    if let Some(row) = indices.iter().position(|m| *m as usize >= materials) {
        let what = format!("material {} in row {row}, of {materials}", indices[row]);
        return Err(bad("particles.material", what));
    }
    add(state, "material", ids, indices.iter().map(|m| Some(MaterialIndex(*m))))?;
    let groups = tables.text("particles.group", &[n])?;
    add(state, "group", ids, groups.iter().map(|group| some(group).map(Group)))?;
    let probes = tables.text("particles.probe", &[n])?;
    add(state, "probe", ids, probes.iter().map(|probe| some(probe).map(Probe)))?;
    let (motions, forces) =
        (triples("particles.last_motion")?, triples("particles.external_force")?);
    add_motions(state, ids, motions, forces)?;
    controls::read(tables, "particles", ids, state)?;
    let swinging = tables.bool("particles.swinging", &[n])?;
    add(state, "swinging", ids, swinging.iter().map(|swings| swings.then_some(Swinging)))?;
    if tables.has(SET_ASIDE) {
        let aside = tables.bool(SET_ASIDE, &[n])?;
        add(state, "set_aside", ids, aside.iter().map(|is_aside| is_aside.then_some(SetAside)))?;
    }
    Ok(numbers)
}
