//! The rigid groups of a saved state.

use clastic_components::body::{
    BodyExternalForce, BodyId, BodyOrigin, BodyPosition, BodyRotation, LastMotion, Probe,
};
use clastic_components::rigid_group::{ContactForce, RigidGroup};
use clastic_systems::state::{StateError, WorldState};

use super::SavedError;
use super::columns::{add, add_motions, bad, each, finite, identities, none_of, of, some};
use super::controls;
use crate::tables::{Array, Tables};

pub(super) const ENTRIES: [&str; 2] = ["contact_force", ENTRY];

/// Entry with the groups.
const ENTRY: &str = "rigid_group";

/// Columns of finite numbers.
const NUMBERS: [&str; 12] = [
    "rigid.reference_rad",
    "rigid.position_m",
    "rigid.origin_m",
    "rigid.rotation_rad",
    "rigid.last_motion",
    "rigid.external_force",
    "rigid.contact_force",
    "rigid.load_from",
    "rigid.load_to",
    "rigid.applied_from",
    "rigid.applied_to",
    "rigid.imposed_motion",
];

/// Names of the groups of a state.
pub(super) fn names(state: &WorldState) -> Result<Vec<String>, StateError> {
    let groups = state.components::<BodyId, RigidGroup>(ENTRY)?;
    Ok(groups.into_iter().map(|(_, group)| group.name).collect())
}

/// Names of the groups that have one of these bodies as a member.
pub(super) fn with(state: &WorldState, bodies: &[BodyId]) -> Result<Vec<String>, StateError> {
    let groups = state.components::<BodyId, RigidGroup>(ENTRY)?;
    let has = |group: &RigidGroup| group.members.iter().any(|id| bodies.contains(id));
    Ok(groups.into_iter().filter(|(_, group)| has(group)).map(|(_, group)| group.name).collect())
}

/// Writes the groups; a state without any has none of these arrays.
pub(super) fn write(state: &WorldState, tables: &mut Tables) -> Result<(), SavedError> {
    let groups = state.components::<BodyId, RigidGroup>(ENTRY)?;
    if groups.is_empty() {
        return Ok(());
    }
    let ids: Vec<_> = groups.iter().map(|(id, _)| *id).collect();
    let ids = ids.as_slice();
    tables.put("rigid.id", Array::u32(ids.iter().map(|id| id.0).collect()));
    tables.put("rigid.name", Array::text(groups.iter().map(|(_, group)| group.name.clone())));
    tables.put("rigid.has_pivot", Array::bool(groups.iter().map(|(_, g)| g.has_pivot).collect()));
    let references = groups.iter().map(|(_, group)| group.reference).collect();
    tables.put("rigid.reference_rad", Array::f64(references));
    // One row per member.
    let members = || groups.iter().flat_map(|(id, g)| g.members.iter().map(|m| (id.0, m.0)));
    tables.put("rigid.member", Array::u32(members().map(|(_, member)| member).collect()));
    tables.put("rigid.member_of", Array::u32(members().map(|(group, _)| group).collect()));

    let positions = each::<BodyPosition>(state, "position", ids)?;
    tables.put("rigid.position_m", Array::vectors(positions.iter().map(|x| x.0.to_array())));
    let origins = each::<BodyOrigin>(state, "origin", ids)?;
    tables.put("rigid.origin_m", Array::vectors(origins.iter().map(|x| x.0.to_array())));
    let rotations = each::<BodyRotation>(state, "rotation", ids)?;
    tables.put("rigid.rotation_rad", Array::f64(rotations.iter().map(|r| r.0).collect()));
    let motions = each::<LastMotion>(state, "last_motion", ids)?;
    tables.put("rigid.last_motion", Array::vectors(motions.iter().map(|u| u.0)));
    let forces = each::<BodyExternalForce>(state, "external_force", ids)?;
    tables.put("rigid.external_force", Array::vectors(forces.iter().map(|f| f.0)));
    let forces = each::<ContactForce>(state, "contact_force", ids)?;
    tables.put("rigid.contact_force", Array::vectors(forces.iter().map(|f| f.0)));
    controls::write(state, "rigid", ids, tables)?;
    let probes = of::<Probe>(state, "probe", ids)?.into_iter();
    let probes = probes.map(|probe| probe.map(|probe| probe.0).unwrap_or_default());
    tables.put("rigid.probe", Array::text(probes));
    Ok(())
}

/// Reads the groups, of these particles and beside these walls.
pub(super) fn read(
    tables: &Tables,
    particles: &[u32],
    walls: &[u32],
    state: &mut WorldState,
) -> Result<(), SavedError> {
    if !tables.has("rigid.id") {
        return none_of(tables, "rigid.", "rigid.id");
    }
    let numbers = identities(tables, "rigid.id")?;
    let taken = |id: &u32| particles.binary_search(id).is_ok() || walls.contains(id);
    if let Some(row) = numbers.iter().position(taken) {
        let what = format!("body {} in row {row}, which is a particle or a wall", numbers[row]);
        return Err(bad("rigid.id", what));
    }
    let ids: Vec<_> = numbers.iter().map(|id| BodyId(*id)).collect();
    let (ids, n) = (ids.as_slice(), ids.len());
    finite(tables, &NUMBERS)?;
    let groups = groups(tables, &numbers, particles, walls)?;
    add(state, ENTRY, ids, groups.into_iter().map(Some))?;

    let scalars = |name: &str| tables.f64(name, &[n]);
    let pairs = |name: &str| tables.vectors::<2>(name, n);
    let triples = |name: &str| tables.vectors::<3>(name, n);
    let places = pairs("rigid.position_m")?;
    add(state, "position", ids, places.into_iter().map(|x| Some(BodyPosition(x.into()))))?;
    let origins = pairs("rigid.origin_m")?;
    add(state, "origin", ids, origins.into_iter().map(|x| Some(BodyOrigin(x.into()))))?;
    let rotations = scalars("rigid.rotation_rad")?;
    add(state, "rotation", ids, rotations.iter().map(|r| Some(BodyRotation(*r))))?;
    let (motions, forces) = (triples("rigid.last_motion")?, triples("rigid.external_force")?);
    add_motions(state, ids, motions, forces)?;
    let forces = triples("rigid.contact_force")?;
    add(state, "contact_force", ids, forces.into_iter().map(|f| Some(ContactForce(f))))?;
    controls::read(tables, "rigid", ids, state)?;
    let probes = tables.text("rigid.probe", &[n])?;
    add(state, "probe", ids, probes.iter().map(|probe| some(probe).map(Probe)))?;
    Ok(())
}

/// The groups with their members, each of which is a particle or a wall of one group.
fn groups(
    tables: &Tables,
    ids: &[u32],
    particles: &[u32],
    walls: &[u32],
) -> Result<Vec<RigidGroup>, SavedError> {
    let n = ids.len();
    let m = tables.rows("rigid.member")?;
    let (members, of) = (tables.u32("rigid.member", &[m])?, tables.u32("rigid.member_of", &[m])?);
    let names = tables.text("rigid.name", &[n])?;
    let pivots = tables.bool("rigid.has_pivot", &[n])?;
    let references = tables.f64("rigid.reference_rad", &[n])?;
    let mut groups: Vec<_> = (0..n)
        .map(|k| RigidGroup {
            name: names[k].clone(),
            members: Vec::new(),
            has_pivot: pivots[k],
            reference: references[k],
        })
        .collect();
    let mut seen = members.to_vec();
    seen.sort_unstable();
    if let Some(twice) = seen.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(bad("rigid.member", format!("body {} twice", twice[0])));
    }
    for (row, (member, group)) in members.iter().zip(of).enumerate() {
        let is_wall = walls.contains(member);
        if particles.binary_search(member).is_err() && !is_wall {
            return Err(bad("rigid.member", format!("no particle or wall {member} in row {row}")));
        }
        let Ok(at) = ids.binary_search(group) else {
            return Err(bad("rigid.member_of", format!("no group {group} in row {row}")));
        };
        if is_wall && !groups[at].has_pivot {
            let what = format!("false in row {at}, and wall {member} is a member: it has no mass");
            return Err(bad("rigid.has_pivot", what));
        }
        groups[at].members.push(BodyId(*member));
    }
    for group in &mut groups {
        group.members.sort_unstable();
        if group.members.is_empty() {
            return Err(bad("rigid.member", format!("group `{}` has none", group.name)));
        }
    }
    Ok(groups)
}
