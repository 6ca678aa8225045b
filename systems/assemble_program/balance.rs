//! Balance rows of the program: unknown degrees of freedom, their loads and their inertia.
//!
//! Theta-method (equations 2 to 4 of the paper):
//! `m/(theta dt^2) u + G f = f_ext + m/(theta dt^2) v_0 dt`. A degree of freedom without
//! interactions needs no row, because its motion is known in advance.

use glam::DVec2;

use clastic_components::body::BodyDrive;
use clastic_components::cell::CellControl;
use clastic_components::contact::BodyTable;
use clastic_components::increment::{AnalysisKind, ClasticAnalysis, ClasticProgress};
use clastic_components::loads::TrialLoads;
use clastic_components::rigid_group::GroupRow;
use clastic_components::wall::WallDrive;
use clastic_cone::program::{Dof, FreeDof, Interaction, ProgramBody};

/// Fills `out` with one entry per body.
pub fn assemble(
    bodies: &BodyTable,
    analysis: &ClasticAnalysis,
    progress: &ClasticProgress,
    interactions: &[Interaction],
    loads: &TrialLoads,
    out: &mut Vec<ProgramBody>,
) {
    let fraction = progress.fraction;
    // Whether interactions act on the (translation, rotation) of a body.
    let mut touched = vec![(false, false); bodies.positions.len()];
    for c in interactions {
        let turns = c.limits.has_shear() || c.limits.has_rolling();
        for (body, normal_arm) in [(c.a, c.normal_arm_a), (c.b, c.normal_arm_b)] {
            let t = &mut touched[body as usize];
            *t = (true, t.1 || turns || normal_arm != 0.0);
        }
    }
    let added = if loads.is_empty() { Vec::new() } else { loads.sums(bodies) };
    let added = |i: usize| added.get(i).copied().unwrap_or_default();
    let affine = Affine::of(bodies, analysis, fraction);
    let still = ProgramBody { axis: DVec2::X, dofs: [Dof::Fixed(0.0); 3] };
    out.clear();
    out.resize(bodies.positions.len(), still);
    for i in 0..bodies.particles {
        for k in 0..3 {
            out[i].dofs[k] = match bodies.drive(i, k) {
                BodyDrive::Imposed(u) => Dof::Fixed(fraction * u),
                BodyDrive::Free => {
                    let mut free =
                        particle_dof(bodies, analysis, progress.increment, fraction, &affine, i, k);
                    free.load += added(i)[k].force;
                    free.inertia += added(i)[k].stiffness;
                    let acted = if k < 2 { touched[i].0 } else { touched[i].1 };
                    if acted || (free.inertia == 0.0 && free.load != 0.0) {
                        Dof::Free(free)
                    } else if free.inertia > 0.0 {
                        Dof::Fixed(free.load / free.inertia)
                    } else {
                        Dof::Fixed(0.0)
                    }
                }
            };
        }
    }
    for group in &bodies.groups {
        let row = group.body as usize;
        for &member in &group.members {
            // Interactions act on the group.
            out[member as usize] = still;
        }
        let mean = |x| affine.displacement(x);
        out[row] =
            super::groups::body(bodies, analysis, fraction, group, touched[row], added, mean);
    }
    for wall in &bodies.walls {
        if bodies.group(wall.body as usize).is_some() {
            continue;
        }
        let drive = bodies.wall_drive(wall);
        let dofs = match drive {
            WallDrive::Imposed(u) => [
                Dof::Fixed(fraction * u.dot(wall.inward)),
                Dof::Fixed(fraction * u.dot(wall.inward.perp())),
                Dof::Fixed(0.0),
            ],
            WallDrive::Turning { about, angle } => {
                let angle = fraction * angle;
                let arm = bodies.positions[wall.body as usize] - about;
                let [x, y, _] = GroupRow::carried([0.0, 0.0, angle], arm);
                let u = DVec2::new(x, y);
                [
                    Dof::Fixed(u.dot(wall.inward)),
                    Dof::Fixed(u.dot(wall.inward.perp())),
                    Dof::Fixed(angle),
                ]
            }
            WallDrive::Loaded(force) | WallDrive::Sliding { load: force, .. } => {
                let [x, y, _] = added(wall.body as usize).map(|load| load.force);
                let load = force.at(fraction) + wall.inward.dot(DVec2::new(x, y));
                let load = FreeDof { load, ..FreeDof::default() };
                // A loaded wall without contact stands still until the specimen touches it.
                let waits = !touched[wall.body as usize].0 && load.load == 0.0;
                let along = if waits { Dof::Fixed(0.0) } else { Dof::Free(load) };
                // The second axis is the negative tangent.
                let slid = match drive {
                    WallDrive::Sliding { along, .. } => -fraction * along,
                    _ => 0.0,
                };
                [along, Dof::Fixed(slid), Dof::Fixed(0.0)]
            }
        };
        out[wall.body as usize] = ProgramBody { axis: wall.inward, dofs };
    }
    if let Some(cell) = &bodies.cell {
        out.push(super::cell::body(bodies, cell, analysis, progress));
    }
}

fn particle_dof(
    bodies: &BodyTable,
    analysis: &ClasticAnalysis,
    increment: u64,
    fraction: f64,
    affine: &Affine,
    i: usize,
    k: usize,
) -> FreeDof {
    let mass = if k < 2 { bodies.masses[i] } else { bodies.inertias[i] };
    let applied = bodies.loads[i][k].at(fraction);
    match analysis.kind {
        AnalysisKind::Static => {
            let weight = if k < 2 { bodies.static_weight(i, analysis.gravity)[k] } else { 0.0 };
            FreeDof { load: applied + weight, ..FreeDof::default() }
        }
        AnalysisKind::Compaction { agitation, seed, .. } => {
            let mean = if k < 2 { affine.displacement(bodies.positions[i])[k] } else { 0.0 };
            let u = mean + agitation * shake(seed, increment, bodies.ids[i].0 as usize, k);
            FreeDof { load: u, inertia: 1.0, ..FreeDof::default() }
        }
        AnalysisKind::Dynamic { dt, theta } => {
            let dt = dt * fraction;
            let inertia = mass / (theta * dt * dt);
            let v = if k < 2 { bodies.velocities[i][k] } else { bodies.angular_velocities[i] };
            let momentum = inertia * v * dt;
            let weight = if k < 2 { mass * analysis.gravity[k] } else { 0.0 };
            let load = applied + weight + momentum;
            FreeDof { load, momentum, inertia, ..FreeDof::default() }
        }
    }
}

/// Deterministic number in [-1, 1) that depends on the arguments only. It is equal in every attempt
/// and after a restart. Mixing function of SplitMix64 (Steele, Lea and Flood 2014).
fn shake(seed: u64, increment: u64, body: usize, dof: usize) -> f64 {
    let mix = |mut z: u64| {
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let step = 0x9e37_79b9_7f4a_7c15_u64;
    let state = mix(mix(seed.wrapping_add(step)).wrapping_add(step.wrapping_mul(increment)));
    let bits = mix(state.wrapping_add(step.wrapping_mul(3 * body as u64 + dof as u64 + 1)));
    (bits >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Mean motion of a compaction. In a periodic cell it is the deformation of the cell. Otherwise it
/// is linear between zero at the fixed walls and the motion of the wall at the moving wall.
struct Affine {
    moving: Option<(DVec2, DVec2, DVec2, f64)>,
    /// Displacement gradient of a periodic cell: width, height and shear.
    cell: Option<[f64; 3]>,
}

impl Affine {
    fn of(bodies: &BodyTable, analysis: &ClasticAnalysis, fraction: f64) -> Self {
        let AnalysisKind::Compaction { affine: true, .. } = analysis.kind else {
            return Self { moving: None, cell: None };
        };
        if let Some(cell) = &bodies.cell {
            let gradient = |k: usize, length: f64| match cell.controls[k] {
                CellControl::Imposed(u) => fraction * u / length,
                CellControl::Stress { .. } => 0.0,
            };
            let along = [cell.width, cell.height, cell.height];
            let cell = Some([0, 1, 2].map(|k| gradient(k, along[k])));
            return Self { moving: None, cell };
        }
        let moving = bodies.walls.iter().find_map(|wall| match wall.drive {
            WallDrive::Imposed(u) if u != DVec2::ZERO => Some((wall, fraction * u)),
            _ => None,
        });
        let moving = moving.and_then(|(wall, u)| {
            let x = bodies.positions[wall.body as usize];
            // The opposite wall is the fixed wall whose normal is closest to the opposite
            // direction.
            let base = bodies
                .walls
                .iter()
                .filter(|w| w.body != wall.body && w.inward.dot(wall.inward) < -0.5)
                .min_by(|a, b| a.inward.dot(wall.inward).total_cmp(&b.inward.dot(wall.inward)))?;
            let height = (x - bodies.positions[base.body as usize]).dot(base.inward);
            (height > 0.0).then_some((bodies.positions[base.body as usize], base.inward, u, height))
        });
        Self { moving, cell: None }
    }

    fn displacement(&self, x: DVec2) -> DVec2 {
        if let Some([xx, yy, xy]) = self.cell {
            return DVec2::new(xx * x.x + xy * x.y, yy * x.y);
        }
        self.moving.map_or(DVec2::ZERO, |(base, inward, u, height)| {
            u * ((x - base).dot(inward) / height).clamp(0.0, 1.0)
        })
    }
}
