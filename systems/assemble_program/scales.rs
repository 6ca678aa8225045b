//! Expected magnitudes of displacement and force. The tolerances of conic solvers are partly
//! absolute, and with the stiffness of rock in SI units they stall. The solvers therefore scale the
//! program to the order of one.

use glam::DVec2;

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, FreeDof, Interaction, ProgramBody, Scales};

use super::Trial;

/// Estimates the scales of the program. The magnitudes of a rejected attempt take precedence.
pub(super) fn estimate(trial: &Trial, program: &ConeProgram) -> Scales {
    let Trial { bodies, contacts, progress, analysis, .. } = trial;
    let length = bodies.mean_radius;
    // Ties follow the contacts. Their stiffness is proportional to the tension and may be small, so
    // they are excluded.
    let interactions = &program.interactions[..contacts.0.len().min(program.interactions.len())];
    let driven = displacement(bodies, analysis, progress);
    let known = driven.max(rigid_overlap(interactions));
    // Loading from zero: displacement of one contact under the loads.
    let displacement =
        if known > 0.0 { known } else { maximum_load(program) * softest(interactions) };
    let displacement = displacement.max(1e-9 * length);
    let determined = determined_force(bodies, program, interactions, displacement);
    let remembered = trial.history.0.sizes(length).map(|(.., size)| size).fold(0.0, f64::max);
    let remembered = remembered.min(determined);
    let is_driven = maximum_imposed(bodies) > 0.0;
    let force = force(remembered, program, interactions, displacement, is_driven);
    match trial.attempt.magnitudes {
        // The magnitudes of a failed attempt are used unless they are round-off, or so large that
        // they would hide all errors because the solver diverged.
        Some((u, f)) => {
            let f = f.min(determined).clamp(MIN_SCALE * force, MAX_RATIO * force);
            Scales { length, displacement: u, force: f }
        }
        None => Scales { length, displacement, force },
    }
}

/// Minimum force scale, as a fraction of the force of the displacement in one contact, or of the
/// strength. Smaller forces are remainders of zero.
const MIN_SCALE: f64 = 1e-3;

/// Minimum fraction of the imposed displacement in the scale of an increment that ends with an
/// event.
const MIN_FRACTION: f64 = 0.05;

/// Maximum scale from the motion of grains in an earlier solution, mean radii.
pub(crate) const MAX_MOTION: f64 = 0.1;

/// Maximum force scale from a failed attempt, relative to the expected scale.
const MAX_RATIO: f64 = 1e2;

fn displacement(bodies: &BodyTable, analysis: &ClasticAnalysis, progress: &ClasticProgress) -> f64 {
    // An increment up to an event may have a small fraction of the imposed motion, but ruptures
    // precede it.
    let is_cut = progress.fraction < progress.tried;
    let f = if is_cut { progress.fraction.max(MIN_FRACTION) } else { progress.fraction };
    let driven = f * maximum_imposed(bodies);
    match analysis.kind {
        AnalysisKind::Dynamic { dt, .. } => {
            let dt = dt * f;
            let v = bodies.velocities.iter().map(|v| v.length()).fold(0.0, f64::max);
            driven.max(v * dt).max(analysis.gravity.length() * dt * dt)
        }
        AnalysisKind::Static | AnalysisKind::Compaction { .. } => {
            // The jump of a grain in the last increment must not set the scale.
            let moved = bodies.last_motion.iter().map(|u| f * DVec2::new(u[0], u[1]).length());
            driven.max(moved.fold(0.0, f64::max).min(MAX_MOTION * bodies.mean_radius))
        }
    }
}

/// Maximum displacement that is imposed in a whole increment, m: of a particle, a wall, a group, or
/// of one side of the cell relative to the other.
pub(crate) fn maximum_imposed(bodies: &BodyTable) -> f64 {
    let drives = (0..bodies.particles).flat_map(|i| [bodies.drive(i, 0), bodies.drive(i, 1)]);
    let drives = drives.filter_map(BodyDrive::imposed).map(f64::abs);
    let walls = bodies.walls.iter().map(|w| bodies.wall_travel(w, bodies.wall_drive(w)));
    let groups = bodies.groups.iter().map(|group| bodies.imposed_motion(group));
    let cell = bodies.cell.filter(|_| !bodies.drives_stopped).map(|cell| cell.imposed());
    drives.chain(walls).chain(groups).chain(cell).fold(0.0, f64::max)
}

/// The translations of bodies whose displacements are unknown.
pub(crate) fn free_translations(program: &ConeProgram) -> impl Iterator<Item = &FreeDof> {
    let all = program.bodies.iter().flat_map(ProgramBody::free);
    all.filter(|(k, _)| *k < 2).map(|(_, free)| free)
}

fn maximum_load(program: &ConeProgram) -> f64 {
    free_translations(program).map(|f| f.load.abs()).fold(0.0, f64::max)
}

/// Maximum overlap of rigid interactions, m.
fn rigid_overlap(interactions: &[Interaction]) -> f64 {
    let rigid = interactions.iter().filter(|c| c.normal_compliance == 0.0);
    rigid.map(|c| -c.offset).fold(0.0, f64::max)
}

/// Maximum normal compliance, m/N.
fn softest(interactions: &[Interaction]) -> f64 {
    interactions.iter().map(|c| c.normal_compliance).fold(0.0, f64::max)
}

/// Maximum force that the loads can determine, N, where every interaction is rigid: in dynamics without
/// strength, and in statics without imposed motions, the sum of all loads and inertial forces; else
/// infinite.
///
/// Rigid bodies that are wedged between others, or bonded in loops, carry forces that nothing determines. A
/// solver ends with some multiple of its scale of forces. As the next scale they would grow without bound.
pub(crate) fn determined_force(
    bodies: &BodyTable,
    program: &ConeProgram,
    interactions: &[Interaction],
    displacement: f64,
) -> f64 {
    let is_determined = if program.has_momentum() {
        interactions.iter().any(|c| c.limits.has_strength())
    } else {
        program.is_dynamic() || maximum_imposed(bodies) > 0.0
    };
    let forces = free_translations(program).map(|f| f.load.abs() + f.inertia * displacement);
    let sum: f64 = forces.sum();
    let are_rigid = interactions.iter().all(|c| c.normal_compliance == 0.0);
    if sum > 0.0 && are_rigid && !is_determined { sum } else { f64::INFINITY }
}

fn force(
    remembered: f64,
    program: &ConeProgram,
    interactions: &[Interaction],
    displacement: f64,
    is_driven: bool,
) -> f64 {
    let loads = maximum_load(program);
    let inertial = free_translations(program).map(|f| f.inertia * displacement).fold(0.0, f64::max);
    let expected = remembered.max(0.1 * loads).max(0.1 * inertial);
    // Driving from zero force: a tenth of the force of the displacement in one contact, or the
    // strength if all contacts are rigid.
    let mut elastic = f64::INFINITY;
    let mut strength = 0.0_f64;
    for c in interactions {
        if c.normal_compliance > 0.0 {
            elastic = elastic.min(0.1 * displacement / c.normal_compliance);
        }
        // Where nothing is driven, loads give the scale, however strong rigid bonds are.
        if is_driven || loads == 0.0 {
            strength = strength.max(c.limits.cohesion).max(c.limits.tension);
        }
    }
    let driven = elastic.min(if strength > 0.0 { strength } else { f64::INFINITY });
    match (expected > 0.0, driven.is_finite()) {
        (true, true) => expected.max(MIN_SCALE * driven),
        (true, false) => expected,
        (false, true) => driven,
        (false, false) => 1.0,
    }
}
