//! The walls of a saved state: those of the scene, whether they are there or not, then others.

use clastic_components::body::{
    BodyExternalForce, BodyId, BodyOrigin, BodyPosition, LastMotion, Probe,
};
use clastic_components::material::ContactLaw;
use clastic_components::wall::{Wall, WallName};
use clastic_systems::state::{StateError, WorldState};
use clastic_systems::wall_states::WALL_CONTROL;
use glam::DVec2;

use super::columns::{add, add_motions, bad, finite, identities, of, some};
use super::wall_laws::{bond, bond_row, contact, contact_row, law, law_row};
use super::{SavedError, wall_controls};
use crate::run::wall_pieces::{count, moved, pieces};
use crate::run::walls::WallCatalogue;
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

/// Walls of a saved state.
pub(super) struct Walls {
    /// Identities of the present walls.
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
    // One row per piece of a wall of the scene.
    let of_row: Vec<&scene::Wall> = catalogue
        .walls
        .iter()
        .flat_map(|wall| std::iter::repeat_n(wall, count(wall) as usize))
        .collect();
    let listed = of_row.len();
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
    let middles: Vec<_> =
        of::<BodyPosition>(state, "position", ids)?.iter().map(position).collect();
    let drawn = |k: usize| -> [DVec2; 2] {
        match of_row.get(k) {
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
        let listed = of_row.get(k).map(|wall| wall.name.clone());
        listed.or_else(|| named[k].as_ref().map(|name| name.0.clone()))
    };
    tables.put("walls.name", text(&name));
    let probe = |k: usize| match &walls[k] {
        Some(_) => probes[k].as_ref().map(|probe| probe.0.clone()),
        None => of_row.get(k)?.probe.clone(),
    };
    tables.put("walls.probe", text(&probe));
    tables.put("walls.drawn_start_m", Array::vectors(all().map(|k| drawn(k)[0].to_array())));
    tables.put("walls.drawn_end_m", Array::vectors(all().map(|k| drawn(k)[1].to_array())));
    tables.put("walls.middle_m", Array::vectors(middles.iter().map(DVec2::to_array)));
    let origins = of::<BodyOrigin>(state, "origin", ids)?;
    let origins = origins.iter().map(|x| x.unwrap_or_default().0.to_array());
    tables.put("walls.origin_m", Array::vectors(origins));
    let tangents = walls.iter().map(|w| w.map_or([0.0; 2], |w| w.tangent.to_array()));
    tables.put("walls.tangent", Array::vectors(tangents));
    let halves = walls.iter().map(|w| w.map_or(0.0, |w| w.half_length)).collect();
    tables.put("walls.half_length_m", Array::f64(halves));
    let motions = of::<LastMotion>(state, "last_motion", ids)?;
    let motions = motions.iter().map(|u| u.unwrap_or_default().0);
    tables.put("walls.last_motion", Array::vectors(motions));
    let forces = of::<BodyExternalForce>(state, "external_force", ids)?;
    let forces = forces.iter().map(|f| f.unwrap_or_default().0);
    tables.put("walls.external_force", Array::vectors(forces));
    let laws = of::<ContactLaw>(state, "contact_law", ids)?;
    let law = |law: &Option<ContactLaw>| law.map_or([0.0; 6], |law| law_row(&law));
    tables.put("walls.law", Array::vectors(laws.iter().map(law)));
    let shape = |k: usize| of_row.get(k).filter(|w| !w.shape.is_line()).map(|w| as_ron(&w.shape));
    tables.put("walls.shape", text(&shape));
    let touching = |k: usize| of_row.get(k).is_some_and(|wall| wall.touching);
    tables.put("walls.touching", Array::bool(all().map(touching).collect()));
    let contact = |k: usize| of_row.get(k).map_or([0.0; 6], |w| contact_row(&w.contact));
    tables.put("walls.contact", Array::vectors(all().map(contact)));
    let bond = |k: usize| of_row.get(k).and_then(|wall| wall.bond);
    let bonds = all().map(|k| bond(k).map_or([f64::NAN; 7], |bond| bond_row(&bond)));
    tables.put("walls.bond", Array::vectors(bonds));
    wall_controls::write(state, ids, tables)
}

/// A shape in RON.
fn as_ron(shape: &scene::WallShape) -> String {
    // The types of a shape are those that RON has.
    ron::to_string(shape).unwrap_or_default()
}

/// A shape from RON; a line without text.
fn shape(text: &str) -> Result<scene::WallShape, String> {
    if text.is_empty() {
        return Ok(scene::WallShape::Line);
    }
    ron::from_str(text).map_err(|error| error.to_string())
}

fn position(x: &Option<BodyPosition>) -> DVec2 {
    x.map_or(DVec2::ZERO, |x| x.0)
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
    add(state, "position", ids, middles.iter().map(|x| Some(BodyPosition(*x))))?;
    let origins = pairs("walls.origin_m")?;
    add(state, "origin", ids, origins.into_iter().map(|x| Some(BodyOrigin(x))))?;
    let (motions, forces) = (triples("walls.last_motion")?, triples("walls.external_force")?);
    add_motions(state, ids, motions, forces)?;
    let laws = tables.vectors::<6>("walls.law", n)?.into_iter().enumerate();
    let laws = laws.filter(|(k, _)| is_there(*k)).map(|(_, row)| Some(law(row)));
    add(state, "contact_law", ids, laws)?;
    let names = tables.text("walls.name", &[n])?;
    let probes = tables.text("walls.probe", &[n])?;
    let here = |texts: &[String]| -> Vec<Option<String>> {
        let texts = texts.iter().enumerate().filter(|(k, _)| is_there(*k));
        texts.map(|(_, text)| some(text)).collect()
    };
    add(state, "wall_name", ids, here(names).into_iter().map(|name| name.map(WallName)))?;
    add(state, "probe", ids, here(probes).into_iter().map(|probe| probe.map(Probe)))?;
    wall_controls::read(tables, &all, present, state)?;
    let (first, listed) = read_listed(tables, &all, next)?;
    Ok(Walls { ids: ids.iter().map(|id| id.0).collect(), first, listed })
}

/// Reads the identity of the first wall of the scene, and its walls as it drew them. `next` is the
/// identity that follows those of all bodies.
fn read_listed(
    tables: &Tables,
    all: &[u32],
    next: u32,
) -> Result<(u32, Vec<scene::Wall>), SavedError> {
    let n = all.len();
    let names = tables.text("walls.name", &[n])?;
    let probes = tables.text("walls.probe", &[n])?;
    let present = tables.bool("walls.present", &[n])?;
    let of_scene = tables.bool("walls.of_scene", &[n])?;
    let first = all.first().copied().filter(|_| of_scene.first() == Some(&true)).unwrap_or(next);
    let listed = of_scene.iter().take_while(|listed| **listed).count();
    let is_run = all[..listed].iter().zip(first..).all(|(id, expected)| *id == expected);
    if !is_run || of_scene[listed..].contains(&true) {
        return Err(bad("walls.of_scene", "walls of the scene do not follow one another"));
    }
    let starts = tables.vectors::<2>("walls.drawn_start_m", n)?;
    let ends = tables.vectors::<2>("walls.drawn_end_m", n)?;
    let contacts = tables.vectors::<6>("walls.contact", n)?;
    let bonds = tables.vectors::<7>("walls.bond", n)?;
    let shapes = tables.text("walls.shape", &[n])?;
    let touching = tables.bool("walls.touching", &[n])?;
    let mut of_scene = Vec::new();
    let mut k = 0;
    while k < listed {
        let shape =
            shape(&shapes[k]).map_err(|error| bad("walls.shape", format!("row {k}: {error}")))?;
        let wall = scene::Wall {
            name: names[k].clone(),
            start: starts[k].into(),
            end: ends[k].into(),
            shape,
            contact: contact(contacts[k]),
            bond: bond(bonds[k]),
            present: present[k],
            touching: touching[k],
            probe: some(&probes[k]),
        };
        k += count(&wall) as usize;
        of_scene.push(wall);
    }
    if k != listed {
        return Err(bad("walls.shape", "a polyline has fewer rows than pieces"));
    }
    Ok((first, of_scene))
}

/// Walls of the scene where they are now.
pub(super) fn now(
    state: &WorldState,
    first: u32,
    listed: &[scene::Wall],
) -> Result<Vec<scene::Wall>, StateError> {
    let mut next = first;
    let firsts: Vec<_> = listed
        .iter()
        .map(|wall| {
            next += count(wall);
            BodyId(next - count(wall))
        })
        .collect();
    let walls = of::<Wall>(state, "wall", &firsts)?;
    let middles = of::<BodyPosition>(state, "position", &firsts)?;
    let there = walls.into_iter().zip(middles);
    let now = listed.iter().zip(there).map(|(wall, there)| match there {
        (Some(line), Some(middle)) if wall.shape.is_line() => {
            let half = line.tangent * line.half_length;
            let mut wall = wall.clone();
            (wall.start, wall.end) = ((middle.0 - half).into(), (middle.0 + half).into());
            wall
        }
        (Some(now), Some(middle)) => match pieces(wall).first() {
            Some(drawn) => {
                let tangent = drawn.wall.tangent;
                let by = DVec2::new(tangent.dot(now.tangent), tangent.perp_dot(now.tangent));
                // A wall that has not turned keeps its digits.
                let by = if tangent == now.tangent { DVec2::X } else { by };
                moved(wall, drawn.position, by, middle.0)
            }
            None => wall.clone(),
        },
        _ => wall.clone(),
    });
    Ok(now.collect())
}
