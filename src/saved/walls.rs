//! The walls of a saved state: those of the scene, whether they are there or not, then others.

use clastic_components::body::{BodyId, ExternalForce, LastMotion, Origin, Position, Probe, Ramp};
use clastic_components::increment::Progress;
use clastic_components::material::ContactLaw;
use clastic_components::wall::{Wall, WallDrive, WallName};
use clastic_systems::schedule::PROGRESS;
use clastic_systems::state::{StateError, WorldState};
use clastic_systems::wall_states::{ControlState, ControlStates, LengthState, WALL_CONTROL};
use glam::DVec2;

use super::SavedError;
use super::columns::{add, bad, finite, identities, of, some};
use crate::run::spawn::WallCatalogue;
use crate::scene::format as scene;
use crate::tables::{Array, Tables};

pub(super) const ENTRIES: [&str; 5] =
    ["contact_law", "wall", WALL_CONTROL, "wall_drive", "wall_name"];

/// Columns of finite numbers.
const NUMBERS: [&str; 8] = [
    "walls.drawn_start_m",
    "walls.drawn_end_m",
    "walls.middle_m",
    "walls.tangent",
    "walls.half_length_m",
    "walls.last_motion",
    "walls.external_force",
    "walls.law",
];

/// No wall, where the loaded length lies between two.
const NONE: u32 = u32::MAX;

/// Walls of a saved state.
pub(super) struct Walls {
    /// Identities of the walls that are there.
    pub ids: Vec<u32>,
    /// Identity of the first wall of the scene.
    pub first: u32,
    /// The walls of the scene.
    pub listed: Vec<scene::Wall>,
}

pub(super) fn write(
    state: &WorldState,
    catalogue: &WallCatalogue,
    tables: &mut Tables,
) -> Result<(), SavedError> {
    let there = state.components::<BodyId, Wall>("wall")?;
    let listed = catalogue.walls.len();
    let of_scene = (0..listed as u32).map(|k| BodyId(catalogue.first + k));
    let mut ids: Vec<_> = of_scene.collect();
    ids.extend(
        there
            .iter()
            .map(|(id, _)| *id)
            .filter(|id| id.0.checked_sub(catalogue.first).is_none_or(|k| k as usize >= listed)),
    );
    ids[listed..].sort_unstable();
    let ids = ids.as_slice();
    let walls = of::<Wall>(state, "wall", ids)?;
    let middles: Vec<_> = of::<Position>(state, "position", ids)?.iter().map(position).collect();
    let drawn = |k: usize| -> [DVec2; 2] {
        match catalogue.walls.get(k) {
            Some(wall) => [wall.start.into(), wall.end.into()],
            None => {
                let half = walls[k].map_or(DVec2::ZERO, |w| w.tangent * w.half_length);
                [middles[k] - half, middles[k] + half]
            }
        }
    };
    let all = || 0..ids.len();
    let text = |of: &dyn Fn(usize) -> Option<String>| {
        Array::text(all().map(of).map(Option::unwrap_or_default))
    };
    let named = of::<WallName>(state, "wall_name", ids)?;
    let probes = of::<Probe>(state, "probe", ids)?;
    tables.put("walls.id", Array::u32(ids.iter().map(|id| id.0).collect()));
    tables.put("walls.of_scene", Array::bool(all().map(|k| k < listed).collect()));
    tables.put("walls.present", Array::bool(walls.iter().map(Option::is_some).collect()));
    let name = |k: usize| {
        let listed = catalogue.walls.get(k).map(|wall| wall.name.clone());
        listed.or_else(|| named[k].as_ref().map(|name| name.0.clone()))
    };
    tables.put("walls.name", text(&name));
    let probe = |k: usize| match &walls[k] {
        Some(_) => probes[k].as_ref().map(|probe| probe.0.clone()),
        None => catalogue.walls.get(k)?.probe.clone(),
    };
    tables.put("walls.probe", text(&probe));
    tables.put("walls.drawn_start_m", Array::vectors(all().map(|k| drawn(k)[0].to_array())));
    tables.put("walls.drawn_end_m", Array::vectors(all().map(|k| drawn(k)[1].to_array())));
    tables.put("walls.middle_m", Array::vectors(middles.iter().map(|x| x.to_array())));
    let origins = of::<Origin>(state, "origin", ids)?;
    let origins = origins.iter().map(|x| x.unwrap_or_default().0.to_array());
    tables.put("walls.origin_m", Array::vectors(origins));
    let tangents = walls.iter().map(|w| w.map_or([0.0; 2], |w| w.tangent.to_array()));
    tables.put("walls.tangent", Array::vectors(tangents));
    let halves = walls.iter().map(|w| w.map_or(0.0, |w| w.half_length)).collect();
    tables.put("walls.half_length_m", Array::f64(halves));
    let motions = of::<LastMotion>(state, "last_motion", ids)?;
    let motions = motions.iter().map(|u| u.unwrap_or_default().0);
    tables.put("walls.last_motion", Array::vectors(motions));
    let forces = of::<ExternalForce>(state, "external_force", ids)?;
    let forces = forces.iter().map(|f| f.unwrap_or_default().0);
    tables.put("walls.external_force", Array::vectors(forces));
    let laws = of::<ContactLaw>(state, "contact_law", ids)?;
    let law = |law: &Option<ContactLaw>| law.map_or([0.0; 5], |law| law_row(&law));
    tables.put("walls.law", Array::vectors(laws.iter().map(law)));
    let contact = |k: usize| catalogue.walls.get(k).map_or([0.0; 5], |w| contact_row(&w.contact));
    tables.put("walls.contact", Array::vectors(all().map(contact)));
    let bond = |k: usize| catalogue.walls.get(k).and_then(|wall| wall.bond);
    let bonds = all().map(|k| bond(k).map_or([f64::NAN; 6], |bond| bond_row(&bond)));
    tables.put("walls.bond", Array::vectors(bonds));
    write_controls(state, ids, tables)
}

fn position(x: &Option<Position>) -> DVec2 {
    x.map_or(DVec2::ZERO, |x| x.0)
}

fn write_controls(
    state: &WorldState,
    ids: &[BodyId],
    tables: &mut Tables,
) -> Result<(), SavedError> {
    let progress: Progress = state.get(PROGRESS)?;
    let controls: ControlStates = state.get(WALL_CONTROL)?;
    let control = |id: &BodyId| {
        let found = controls.0.binary_search_by_key(id, |(id, _)| *id).ok();
        found.map_or(ControlState::Fixed, |k| controls.0[k].1)
    };
    // A load stays at what it has reached.
    let reached = |from: f64, to: f64| [from, progress.ramp(from, to).from];
    let mut rows = Vec::new();
    for control in ids.iter().map(control) {
        rows.push(match control {
            ControlState::Fixed => ("fixed", [0.0; 2], [NONE; 2]),
            ControlState::Displacement(u) => ("displacement", u.to_array(), [NONE; 2]),
            ControlState::Velocity(v) => ("velocity", v.to_array(), [NONE; 2]),
            ControlState::Force(from, to) => ("force", reached(from, to), [NONE; 2]),
            ControlState::Stress(from, to, LengthState::Segment) => {
                ("stress", reached(from, to), [NONE; 2])
            }
            ControlState::Stress(from, to, LengthState::Between(a, b)) => {
                let between = [a, b].map(|wall| wall.map_or(NONE, |id| id.0));
                ("stress_between", reached(from, to), between)
            }
            ControlState::Custom => ("custom", [0.0; 2], [NONE; 2]),
        });
    }
    tables.put("walls.control", Array::text(rows.iter().map(|row| row.0.to_owned())));
    tables.put("walls.control_value", Array::vectors(rows.iter().map(|row| row.1)));
    for (k, name) in ["walls.between_a", "walls.between_b"].into_iter().enumerate() {
        tables.put(name, Array::u32(rows.iter().map(|row| row.2[k]).collect()));
    }
    let drives = of::<WallDrive>(state, "wall_drive", ids)?;
    let drives = drives.iter().map(|drive| match drive.unwrap_or_default() {
        WallDrive::Imposed(u) => (false, u.to_array()),
        WallDrive::Loaded(ramp) => (true, [ramp.from, ramp.to]),
    });
    let (loaded, values): (Vec<_>, Vec<_>) = drives.unzip();
    tables.put("walls.is_loaded", Array::bool(loaded));
    tables.put("walls.drive", Array::vectors(values));
    Ok(())
}

/// Reads the walls. `next` is the identity that follows those of all bodies.
pub(super) fn read(
    tables: &Tables,
    next: u32,
    particles: &[u32],
    state: &mut WorldState,
) -> Result<Walls, SavedError> {
    let all = identities(tables, "walls.id")?;
    let n = all.len();
    finite(tables, &NUMBERS)?;
    if let Some(row) = all.iter().position(|id| particles.binary_search(id).is_ok()) {
        let what = format!("body {} in row {row}, which is a particle", all[row]);
        return Err(bad("walls.id", what));
    }
    let present = tables.bool("walls.present", &[n])?;
    let is_there = |k: usize| present[k];
    let pick = |ids: &[u32]| -> Vec<BodyId> {
        ids.iter().zip(present).filter(|(_, p)| **p).map(|(id, _)| BodyId(*id)).collect()
    };
    let ids = pick(&all);
    let ids = ids.as_slice();
    let pairs = |name: &str| -> Result<Vec<DVec2>, SavedError> {
        let rows = tables.vectors::<2>(name, n)?.into_iter().enumerate();
        Ok(rows.filter(|(k, _)| is_there(*k)).map(|(_, x)| x.into()).collect())
    };
    let triples = |name: &str| -> Result<Vec<[f64; 3]>, SavedError> {
        let rows = tables.vectors::<3>(name, n)?.into_iter().enumerate();
        Ok(rows.filter(|(k, _)| is_there(*k)).map(|(_, x)| x).collect())
    };
    let tangents = pairs("walls.tangent")?;
    if let Some(row) = tangents.iter().position(|t| !((t.length() - 1.0).abs() < 1e-12)) {
        return Err(bad("walls.tangent", format!("no unit vector: {:?}", tangents[row])));
    }
    let halves = tables.f64("walls.half_length_m", &[n])?;
    let halves = halves.iter().enumerate().filter(|(k, _)| is_there(*k)).map(|(_, half)| *half);
    let walls = tangents.into_iter().zip(halves);
    let walls = walls.map(|(tangent, half_length)| Some(Wall { tangent, half_length }));
    add(state, "wall", ids, walls)?;
    let middles = pairs("walls.middle_m")?;
    add(state, "position", ids, middles.iter().map(|x| Some(Position(*x))))?;
    let origins = pairs("walls.origin_m")?;
    add(state, "origin", ids, origins.into_iter().map(|x| Some(Origin(x))))?;
    let motions = triples("walls.last_motion")?;
    add(state, "last_motion", ids, motions.into_iter().map(|u| Some(LastMotion(u))))?;
    let forces = triples("walls.external_force")?;
    add(state, "external_force", ids, forces.into_iter().map(|f| Some(ExternalForce(f))))?;
    let laws = tables.vectors::<5>("walls.law", n)?.into_iter().enumerate();
    let laws = laws.filter(|(k, _)| is_there(*k)).map(|(_, [n, t, mu, roll, e])| {
        Some(ContactLaw {
            normal_compliance: n,
            tangential_compliance: t,
            friction: mu,
            rolling_friction: roll,
            restitution: e,
        })
    });
    add(state, "contact_law", ids, laws)?;
    let names = tables.text("walls.name", &[n])?;
    let probes = tables.text("walls.probe", &[n])?;
    let here = |texts: &[String]| -> Vec<Option<String>> {
        let texts = texts.iter().enumerate().filter(|(k, _)| is_there(*k));
        texts.map(|(_, text)| some(text)).collect()
    };
    add(state, "wall_name", ids, here(names).into_iter().map(|name| name.map(WallName)))?;
    add(state, "probe", ids, here(probes).into_iter().map(|probe| probe.map(Probe)))?;
    read_controls(tables, &all, present, state)?;
    let of_scene = tables.bool("walls.of_scene", &[n])?;
    let first = all.first().copied().filter(|_| of_scene.first() == Some(&true)).unwrap_or(next);
    let listed = of_scene.iter().take_while(|listed| **listed).count();
    let is_run = all[..listed].iter().zip(first..).all(|(id, expected)| *id == expected);
    if !is_run || of_scene[listed..].contains(&true) {
        return Err(bad("walls.of_scene", "walls of the scene do not follow one another"));
    }
    let starts = tables.vectors::<2>("walls.drawn_start_m", n)?;
    let ends = tables.vectors::<2>("walls.drawn_end_m", n)?;
    let contacts = tables.vectors::<5>("walls.contact", n)?;
    let bonds = tables.vectors::<6>("walls.bond", n)?;
    let listed = (0..listed).map(|k| scene::Wall {
        name: names[k].clone(),
        start: starts[k].into(),
        end: ends[k].into(),
        contact: contact(contacts[k]),
        bond: bond(bonds[k]),
        present: present[k],
        probe: some(&probes[k]),
    });
    let listed = listed.collect();
    Ok(Walls { ids: ids.iter().map(|id| id.0).collect(), first, listed })
}

/// Walls of the scene where they are now.
pub(super) fn now(
    state: &WorldState,
    first: u32,
    listed: &[scene::Wall],
) -> Result<Vec<scene::Wall>, StateError> {
    let ids: Vec<_> = (first..).take(listed.len()).map(BodyId).collect();
    let walls = of::<Wall>(state, "wall", &ids)?;
    let middles = of::<Position>(state, "position", &ids)?;
    let there = walls.into_iter().zip(middles);
    let moved = listed.iter().zip(there).map(|(wall, there)| {
        let mut wall = wall.clone();
        if let (Some(line), Some(middle)) = there {
            let half = line.tangent * line.half_length;
            (wall.start, wall.end) = ((middle.0 - half).into(), (middle.0 + half).into());
        }
        wall
    });
    Ok(moved.collect())
}

fn read_controls(
    tables: &Tables,
    all: &[u32],
    present: &[bool],
    state: &mut WorldState,
) -> Result<(), SavedError> {
    let n = all.len();
    let kinds = tables.text("walls.control", &[n])?;
    let values = tables.vectors::<2>("walls.control_value", n)?;
    let between = [tables.u32("walls.between_a", &[n])?, tables.u32("walls.between_b", &[n])?];
    let loaded = tables.bool("walls.is_loaded", &[n])?;
    let drives = tables.vectors::<2>("walls.drive", n)?;
    let (mut controls, mut driven, mut ids) = (Vec::new(), Vec::new(), Vec::new());
    for k in (0..n).filter(|k| present[*k]) {
        let [a, b] = values[k];
        let length = between.map(|ids| (ids[k] != NONE).then_some(BodyId(ids[k])));
        let control = match kinds[k].as_str() {
            "fixed" => ControlState::Fixed,
            "displacement" => ControlState::Displacement(DVec2::new(a, b)),
            "velocity" => ControlState::Velocity(DVec2::new(a, b)),
            "force" => ControlState::Force(a, b),
            "stress" => ControlState::Stress(a, b, LengthState::Segment),
            "stress_between" => {
                ControlState::Stress(a, b, LengthState::Between(length[0], length[1]))
            }
            "custom" => ControlState::Custom,
            other => return Err(bad("walls.control", format!("`{other}` in row {k}"))),
        };
        controls.push((BodyId(all[k]), control));
        ids.push(BodyId(all[k]));
        driven.push(Some(match loaded[k] {
            true => WallDrive::Loaded(Ramp { from: drives[k][0], to: drives[k][1] }),
            false => WallDrive::Imposed(drives[k].into()),
        }));
    }
    state.set(WALL_CONTROL, &ControlStates(controls))?;
    add(state, "wall_drive", &ids, driven)?;
    Ok(())
}

fn law_row(law: &ContactLaw) -> [f64; 5] {
    let ContactLaw {
        normal_compliance,
        tangential_compliance,
        friction,
        rolling_friction,
        restitution,
    } = *law;
    [normal_compliance, tangential_compliance, friction, rolling_friction, restitution]
}

/// A law of contact as the scene has it; no stiffness is infinite.
fn contact_row(law: &scene::Contact) -> [f64; 5] {
    let [n, t] = [law.normal_stiffness, law.tangential_stiffness].map(rigid);
    [n, t, law.friction, law.rolling_friction, law.restitution]
}

fn contact([n, t, friction, rolling_friction, restitution]: [f64; 5]) -> scene::Contact {
    let [normal_stiffness, tangential_stiffness] = [n, t].map(elastic);
    scene::Contact {
        normal_stiffness,
        tangential_stiffness,
        friction,
        rolling_friction,
        restitution,
    }
}

fn bond_row(law: &scene::Bond) -> [f64; 6] {
    let [n, t] = [law.normal_stiffness, law.tangential_stiffness].map(rigid);
    [n, t, law.friction, law.rolling_friction, law.cohesion, law.tensile_strength]
}

/// A law of bonds; none if it is no number.
fn bond([n, t, friction, rolling_friction, cohesion, tensile]: [f64; 6]) -> Option<scene::Bond> {
    let [normal_stiffness, tangential_stiffness] = [n, t].map(elastic);
    let law = scene::Bond {
        normal_stiffness,
        tangential_stiffness,
        friction,
        rolling_friction,
        cohesion,
        tensile_strength: tensile,
    };
    (!n.is_nan()).then_some(law)
}

fn rigid(stiffness: Option<f64>) -> f64 {
    stiffness.unwrap_or(f64::INFINITY)
}

fn elastic(stiffness: f64) -> Option<f64> {
    Some(stiffness).filter(|k| k.is_finite())
}
