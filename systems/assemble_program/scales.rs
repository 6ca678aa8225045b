//! Expected magnitudes of displacement and force. Conic solvers have partly absolute tolerances
//! and stall on raw rock stiffness: inside a solver everything is of the order of one.

use glam::DVec2;

use clastic_components::body::Drive;
use clastic_components::contact::{Bodies, ContactHistory};
use clastic_components::increment::{Analysis, AnalysisKind, Progress};
use clastic_components::wall::WallDrive;
use clastic_cone::program::{ConeProgram, Dof, FreeDof, Interaction, Scales};

/// Estimates the scales of the program; a rejected attempt's own magnitudes come first.
pub fn estimate(
    bodies: &Bodies,
    history: &ContactHistory,
    analysis: &Analysis,
    progress: &Progress,
    magnitudes: Option<(f64, f64)>,
    contacts: usize,
    program: &ConeProgram,
) -> Scales {
    let length = bodies.mean_radius;
    // Companions of taut bonds come after those of contacts, and are as soft as their tension is small.
    let interactions = &program.interactions[..contacts.min(program.interactions.len())];
    let known = displacement(bodies, analysis, progress).max(rigid_overlap(interactions));
    // Loaded from rest: what the loads do to one contact.
    let displacement =
        if known > 0.0 { known } else { greatest_load(program) * softest(interactions) };
    let displacement = displacement.max(1e-9 * length);
    let force = force(history, program, interactions, displacement);
    match magnitudes {
        // What a failed attempt found, as long as it found something: noise is no scale, and what a
        // solver diverged to neither, beside which no error would show.
        Some((u, f)) => {
            Scales { length, displacement: u, force: f.clamp(LEAST * force, MOST * force) }
        }
        None => Scales { length, displacement, force },
    }
}

/// The least force scale, as a fraction of what the displacement would cost in one contact or of
/// the strength. Forces that are far smaller are what is left of zero.
const LEAST: f64 = 1e-3;

/// Minimum fraction that the displacement scale counts with in an increment that ends with an event.
const LEAST_FRACTION: f64 = 0.05;

/// The greatest force scale that a failed attempt sets, over what is expected without it.
const MOST: f64 = 1e2;

fn displacement(bodies: &Bodies, analysis: &Analysis, progress: &Progress) -> f64 {
    // Up to an event an increment may take next to nothing of what is imposed, but bonds have broken before it.
    let is_cut = progress.fraction < progress.tried;
    let f = if is_cut { progress.fraction.max(LEAST_FRACTION) } else { progress.fraction };
    let drives = (0..bodies.particles).flat_map(|i| [bodies.drive(i, 0), bodies.drive(i, 1)]);
    let imposed = drives.map(|d| match d {
        Drive::Imposed(u) => f * u.abs(),
        Drive::Free => 0.0,
    });
    let walls = bodies.walls.iter().map(|w| match bodies.wall_drive(w) {
        WallDrive::Imposed(u) => f * u.length(),
        WallDrive::Loaded(_) => 0.0,
    });
    let moved = bodies.last_motion.iter().map(|u| f * DVec2::new(u[0], u[1]).length());
    let greatest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    match analysis.kind {
        AnalysisKind::Dynamic { dt, .. } => {
            let dt = dt * f;
            let v = greatest(&mut bodies.velocities.iter().map(|v| v.length()));
            greatest(&mut imposed.chain(walls)).max(v * dt).max(analysis.gravity.length() * dt * dt)
        }
        AnalysisKind::Static | AnalysisKind::LeastMotion { .. } => {
            let driven = greatest(&mut imposed.chain(walls));
            // A grain that jumped in the last increment must not set the scale of this one.
            let last = greatest(&mut moved.into_iter()).min(0.1 * bodies.mean_radius);
            driven.max(last)
        }
    }
}

fn free_translations(program: &ConeProgram) -> impl Iterator<Item = &FreeDof> {
    program.bodies.iter().flat_map(|body| &body.dofs[..2]).filter_map(|dof| match dof {
        Dof::Free(free) => Some(free),
        Dof::Fixed(_) => None,
    })
}

fn greatest_load(program: &ConeProgram) -> f64 {
    free_translations(program).map(|f| f.load.abs()).fold(0.0, f64::max)
}

/// The greatest overlap that rigid interactions have to take out, m.
fn rigid_overlap(interactions: &[Interaction]) -> f64 {
    let rigid = interactions.iter().filter(|c| c.normal_compliance == 0.0);
    rigid.map(|c| -c.offset).fold(0.0, f64::max)
}

/// The greatest normal compliance, m/N.
fn softest(interactions: &[Interaction]) -> f64 {
    interactions.iter().map(|c| c.normal_compliance).fold(0.0, f64::max)
}

fn force(
    history: &ContactHistory,
    program: &ConeProgram,
    interactions: &[Interaction],
    displacement: f64,
) -> f64 {
    let remembered = history.0.iter().map(|m| m.p.abs().max(m.q.abs())).fold(0.0, f64::max);
    let loads = greatest_load(program);
    let inertial = free_translations(program).map(|f| f.inertia * displacement).fold(0.0, f64::max);
    let expected = remembered.max(0.1 * loads).max(0.1 * inertial);
    // Driven from rest: a tenth of what the displacement would cost in one contact, or, where all
    // is rigid, the strength.
    let mut elastic = f64::INFINITY;
    let mut strength = 0.0_f64;
    for c in interactions {
        if c.normal_compliance > 0.0 {
            elastic = elastic.min(0.1 * displacement / c.normal_compliance);
        }
        strength = strength.max(c.limits.cohesion).max(c.limits.tension);
    }
    let driven = elastic.min(if strength > 0.0 { strength } else { f64::INFINITY });
    match (expected > 0.0, driven.is_finite()) {
        (true, true) => expected.max(LEAST * driven),
        (true, false) => expected,
        (false, true) => driven,
        (false, false) => 1.0,
    }
}
