//! A moment from a saved state.

use clastic_components::bond::RuptureMode;
use clastic_components::wall_shape::WallShape;
use glam::DVec2;

use super::moment::{Disk, Link, Moment, Pair, Piece};
use crate::run::wall_pieces::pieces;
use crate::saved::{SavedError, SavedState};
use crate::tables::{TableError, Tables};

/// Reads the arrays of a saved state.
///
/// # Errors
/// If they are no saved state.
pub fn moment(tables: &Tables) -> Result<Moment, SavedError> {
    let state = SavedState::read(tables)?;
    Ok(Moment {
        increment: tables.u64("increment", &[])?[0],
        stage: tables.text("stage", &[])?[0].clone(),
        time: tables.f64("time_s", &[])?[0],
        thickness: state.thickness,
        materials: state.materials.iter().map(|(name, _)| name.clone()).collect(),
        disks: disks(tables)?,
        walls: walls(tables, &state)?,
        pairs: pairs(tables)?,
        bonds: bonds(tables)?,
    })
}

fn disks(tables: &Tables) -> Result<Vec<Disk>, TableError> {
    let n = tables.rows("particles.id")?;
    let ids = tables.u32("particles.id", &[n])?;
    let vectors = |name: &str| tables.vectors::<2>(name, n);
    let (x, origin) = (vectors("particles.position_m")?, vectors("particles.origin_m")?);
    let velocity = vectors("particles.velocity_m_s")?;
    let radius = tables.f64("particles.radius_m", &[n])?;
    let rotation = tables.f64("particles.rotation_rad", &[n])?;
    let spin = tables.f64("particles.angular_velocity_rad_s", &[n])?;
    let material = tables.u32("particles.material", &[n])?;
    let disk = |k: usize| {
        let position = DVec2::from(x[k]);
        Disk {
            id: ids[k],
            position,
            radius: radius[k],
            displacement: position - DVec2::from(origin[k]),
            rotation: rotation[k],
            velocity: velocity[k].into(),
            spin: spin[k],
            material: material[k],
        }
    };
    Ok((0..n).map(disk).collect())
}

fn walls(tables: &Tables, state: &SavedState) -> Result<Vec<Piece>, SavedError> {
    let n = tables.rows("walls.id")?;
    let ids = tables.u32("walls.id", &[n])?;
    let names = tables.text("walls.name", &[n])?;
    let present = tables.bool("walls.present", &[n])?;
    let middle = tables.vectors::<2>("walls.middle_m", n)?;
    let tangent = tables.vectors::<2>("walls.tangent", n)?;
    let half = tables.f64("walls.half_length_m", &[n])?;
    let force = tables.vectors::<3>("walls.external_force", n)?;
    // Rows are the pieces of the walls of the scene, then walls that a program has added.
    let drawn: Vec<_> = state.walls_now()?.iter().flat_map(pieces).collect();
    let mut walls = Vec::new();
    for k in (0..n).filter(|k| present[*k]) {
        let straight = DVec2::from(tangent[k]) * half[k];
        let shape = drawn.get(k).map_or(WallShape::Line, |piece| piece.shape);
        let points = match (drawn.get(k), shape) {
            (Some(piece), WallShape::Arc { .. }) => shape.outline(&piece.wall),
            _ => vec![-straight, straight],
        };
        walls.extend(points.windows(2).map(|ends| Piece {
            id: ids[k],
            name: names[k].clone(),
            ends: [DVec2::from(middle[k]) + ends[0], DVec2::from(middle[k]) + ends[1]],
            is_line: matches!(shape, WallShape::Line),
            external_force: force[k],
        }));
    }
    Ok(walls)
}

fn pairs(tables: &Tables) -> Result<Vec<Pair>, TableError> {
    let n = tables.rows("contacts.a")?;
    let bodies = |name: &str| tables.u32(name, &[n]);
    let (a, b, bond) = (bodies("contacts.a")?, bodies("contacts.b")?, bodies("contacts.bond")?);
    let numbers = |name: &str| tables.f64(name, &[n]);
    let (p, q) = (numbers("contacts.p_n")?, numbers("contacts.q_n")?);
    let (tau, gap) = (numbers("contacts.tau_nm")?, numbers("contacts.gap_m")?);
    let normal = tables.vectors::<2>("contacts.normal", n)?;
    let pair = |k: usize| Pair {
        a: a[k],
        b: b[k],
        normal_force: p[k],
        shear_force: q[k],
        moment: tau[k],
        normal: normal[k].into(),
        gap: gap[k],
        bond: Some(bond[k]).filter(|bond| *bond != u32::MAX),
    };
    // A pair whose body is gone has no normal.
    Ok((0..n).map(pair).filter(|pair| pair.normal.is_finite()).collect())
}

fn bonds(tables: &Tables) -> Result<Vec<Link>, TableError> {
    let n = tables.rows("bonds.id")?;
    let ids = tables.u32("bonds.id", &[n])?;
    let (a, b) = (tables.u32("bonds.a", &[n])?, tables.u32("bonds.b", &[n])?);
    let state = tables.u8("bonds.state", &[n])?;
    let link = |k: usize| Link { id: ids[k], a: a[k], b: b[k], broken: mode(state[k]) };
    Ok((0..n).map(link).collect())
}

/// Mode of a broken bond, from its number in a state; `None` for an intact one.
#[must_use]
pub fn mode(state: u8) -> Option<RuptureMode> {
    match state {
        1 => Some(RuptureMode::Tension),
        2 => Some(RuptureMode::Shear),
        3 => Some(RuptureMode::Rolling),
        _ => None,
    }
}
