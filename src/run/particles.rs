//! The particles of a specimen, before any stage: explicit, lattice, loose packing, stored.

use glam::DVec2;

use super::cell::at_start;
use super::mixed::mix;
use super::random::Random;
use super::sieve;
use crate::scene::format::{Cell, Particle, Scene, Sizes, Specimen};
use crate::scene::specimen_file::{StoredParticle, StoredSpecimen};

/// Name of the group of the outermost particles of a lattice.
pub(crate) const BOUNDARY: &str = "boundary";

/// A particle at rest.
fn at_rest(position: DVec2, radius: f64, material: Option<&String>) -> Particle {
    Particle {
        position: position.into(),
        radius,
        material: material.cloned(),
        velocity: (0.0, 0.0),
        angular_velocity: 0.0,
        group: None,
        probe: None,
    }
}

/// Particles of a scene's specimen in the order of identities.
pub fn particles(scene: &Scene, stored: Option<&StoredSpecimen>) -> Vec<Particle> {
    match &scene.specimen {
        Specimen::Particles(list) => list.clone(),
        Specimen::Lattice { columns, rows, radius, origin, material } => {
            lattice(*columns, *rows, *radius, (*origin).into(), material.as_ref())
        }
        Specimen::Packing { count, columns, spacing, origin, sizes, seed, material } => {
            // A packing without columns is refused, after its other mistakes were looked for.
            let columns = &(*columns).max(1);
            let mut random = Random::stream(*seed, 0);
            let sieved = match sizes {
                Sizes::Sieve { passing } => sieve::radii(passing, *count, *seed),
                _ => Vec::new(),
            };
            let (radii, mut places): (Vec<_>, Vec<_>) = (0..*count)
                .map(|k| {
                    let square =
                        DVec2::new(f64::from(k % columns) + 0.5, f64::from(k / columns) + 0.5);
                    let listed = sieved.get(k as usize).copied();
                    let radius = listed.unwrap_or_else(|| random.radius(sizes));
                    // The position is random within the square, so that disks never overlap. A
                    // regular grid would consist of straight columns, which rigid frictionless
                    // walls cannot buckle.
                    let room = 0.5 * spacing - radius;
                    let jitter =
                        DVec2::new(random.between(-room, room), random.between(-room, room));
                    (radius, DVec2::from(*origin) + *spacing * square + jitter)
                })
                .unzip();
            let grid = [*columns, count.div_ceil(*columns)].map(|n| spacing * f64::from(n));
            // One that is smaller than the grid is refused.
            let holds = |cell: &&Cell| {
                let most = 1.0 + 1e-9;
                grid[0] <= most * cell.size.0 && grid[1] <= most * cell.size.1
            };
            if let Some(cell) = scene.cell.as_ref().filter(holds) {
                let origin = DVec2::from(*origin);
                places.iter_mut().for_each(|place| *place -= origin);
                mix(&at_start(cell), &radii, &mut places, &mut random);
                places.iter_mut().for_each(|place| *place += origin);
            }
            let disks = places.into_iter().zip(radii);
            disks.map(|(place, radius)| at_rest(place, radius, material.as_ref())).collect()
        }
        Specimen::File { material, .. } => rows(stored, material.as_ref()),
        Specimen::State { .. } => rows(stored, None),
    }
}

/// Particles of a file.
fn rows(stored: Option<&StoredSpecimen>, default: Option<&String>) -> Vec<Particle> {
    let Some(stored) = stored else { return Vec::new() };
    let seed = |(k, row): (usize, &StoredParticle)| {
        let material = row.material.as_ref().or(default);
        Particle {
            group: stored.groups.get(k).cloned().flatten(),
            ..at_rest(DVec2::new(row.x, row.y), row.r, material)
        }
    };
    stored.rows.iter().enumerate().map(seed).collect()
}

fn lattice(
    columns: u32,
    rows: u32,
    radius: f64,
    origin: DVec2,
    material: Option<&String>,
) -> Vec<Particle> {
    let mut out = Vec::new();
    for row in 0..rows {
        let odd = row % 2 == 1;
        let width = if odd { columns.saturating_sub(1) } else { columns };
        for column in 0..width {
            let x = 2.0 * radius * f64::from(column) + if odd { radius } else { 0.0 };
            let y = 3.0_f64.sqrt() * radius * f64::from(row);
            let outer = row == 0 || row + 1 == rows || column == 0 || column + 1 == width;
            out.push(Particle {
                group: outer.then(|| BOUNDARY.to_owned()),
                ..at_rest(origin + DVec2::new(x, y), radius, material)
            });
        }
    }
    out
}
