//! Where equilibrium is lost the motion is followed: the static program with inertia, step by step
//! under constant loads, with kinetic damping, until it is at rest ([`Motion`]).
//!
//! A static solution has no path. With constant normals, a grain that has lost its support moves
//! far away and through other grains. In a step of a motion no grain moves by more than a fraction
//! of its radius, and contacts are detected again after each step. Loads have their values at the
//! end of the trial, and stresses act on the current distances between walls. The first step makes the
//! imposed motions of the trial: it may be these that destroy the equilibrium. After it, and in the
//! equilibrium that follows, they stand still. A motion that a rupture releases has no imposed motion.
//! By kinetic damping the motion loses the energy that it has gained since its last maximum, and
//! comes to rest without overshoot. Bonds that reach a limit on the way break. The equilibrium at
//! the end contains no inertia.
//!
//! With [`Avalanche::Dynamic`](clastic_components::increment::Avalanche) the motion that a rupture
//! releases is followed as well. Which bonds break in it depends on where waves carry the force of
//! the broken bond. Its steps are therefore short: lengths are measured in the elongation at which
//! bonds break instead of in radii, and the first step has the time sqrt(m/k) of a grain on a bond.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Mode, Verdict};
use clastic_components::contact::{BodyTable, BondRow, Contact};
use clastic_components::contact_history::DraftHistory;
use clastic_components::energy::EnergyLedger;
use clastic_components::findings::{AddedPairs, Centre, Corrections, Pushed, Reached, Ruptures};
use clastic_components::increment::{Acceptance, ClasticAnalysis, ClasticProgress};
use clastic_components::motion::Motion;
use clastic_cone::program::{ConeProgram, ConeSolution, SolveStatus};

use super::rest;
use super::slip::follow_slip;
use crate::contact_laws::Laws;
use crate::kinetic_damping;
use crate::motion_settings::MotionSettings;
use crate::places::{digits, near};
use crate::rupture::bonds::{BuiltInRule, Met, find_ruptures, most_yielding, release};
use crate::solved::{Solved, SolvedTables};
use crate::travel::furthest;
use crate::update_state::remembered;

/// Length of a step, in radii of the furthest grain, stiffness, N/m, and weight of the first step.
///
/// After a rupture they are means over the intact bonds: of the elongation `C_N f_t = 2 C_N h
/// sigma_t r` at strength over the radius, and of the stiffness `1/C_N`. A rupture that leaves no
/// bond is followed as a loss of equilibrium, since nothing else can break.
fn units(world: &World, released: bool) -> (f64, f64, f64) {
    let bonds = &world.resource::<BodyTable>().bonds;
    if !released || bonds.is_empty() {
        let settings = world.resource::<MotionSettings>();
        return (1.0, shown_stiffness(world), settings.first_weight);
    }
    let mean = |of: fn(&BondRow) -> f64| bonds.iter().map(of).sum::<f64>() / bonds.len() as f64;
    let elongation = mean(|bond| 2.0 * bond.law.normal_compliance * bond.law.tensile_strength);
    let length = (elongation * world.resource::<ClasticAnalysis>().thickness).min(1.0);
    (length, mean(|bond| bond.law.normal_compliance.recip()), 1.0)
}

/// The stiffness that the loads show, N/m, where they move a grain by the minimum travel of a motion.
/// The displacements of the increment show none: of rigid grains they are gaps, and after an idle
/// increment round-off.
fn shown_stiffness(world: &World) -> f64 {
    let (bodies, program) = (world.resource::<BodyTable>(), world.resource::<ConeProgram>());
    program.scales.force / (min_travel(world.resource(), world.resource()) * bodies.mean_radius)
}

/// Minimum travel of a motion, in radii of a grain: with less, the motion moves nothing.
pub(super) fn min_travel(acceptance: &Acceptance, settings: &MotionSettings) -> f64 {
    settings.min_travel * acceptance.turn
}

/// Starts a motion from rest. `released`: bonds have broken at an equilibrium; otherwise no
/// equilibrium was found nearby. A `repeated` motion aims at steps half as long.
pub fn begin(world: &mut World, released: bool, repeated: bool) {
    let (length, stiffness, weight) = units(world, released);
    let bodies = world.resource::<BodyTable>();
    let goal = length * aimed(world.resource());
    let motion = Motion {
        released,
        length,
        weight,
        stiffness,
        masses: kinetic_damping::relative_masses(bodies),
        velocities: vec![[0.0; 3]; bodies.rows_in_program()],
        goal: if repeated { 0.5 * goal } else { goal },
        repeated,
        ..Motion::default()
    };
    let mut attempt = world.resource_mut::<Attempt>();
    attempt.mode = Mode::Motion(motion);
    attempt.motions += 1;
    attempt.magnitudes = None;
    let stopped = released || attempt.is_driven;
    world.resource_mut::<BodyTable>().drives_stopped = stopped;
    forget_passes(world);
    forget_pairs(world);
}

/// Intended travel of the furthest grain in a step, in its radii. It is far enough below the limit
/// that few steps are rejected.
fn aimed(acceptance: &Acceptance) -> f64 {
    acceptance.motion_step.min(0.5 * Acceptance::MAX_TRAVEL)
}

/// Whether the increment has a step of a motion left.
pub(crate) fn has_step(
    attempt: &Attempt,
    acceptance: &Acceptance,
    settings: &MotionSettings,
) -> bool {
    let motion = attempt.motion();
    let released = attempt.released_steps;
    let max_steps = (settings.max_travel / aimed(acceptance)).ceil() as u32;
    motion.map_or(0, |motion| motion.failures) < settings.max_failures
        && if motion.is_some_and(|motion| motion.released) {
            released < settings.max_released_steps
        } else {
            attempt.motion_steps - released < max_steps
        }
}

/// Whether another motion may begin.
pub(crate) fn may_begin(
    attempt: &Attempt,
    acceptance: &Acceptance,
    settings: &MotionSettings,
) -> bool {
    attempt.motions < settings.max_motions && has_step(attempt, acceptance, settings)
}

/// Ends the motion under way. Imposed motions that it has made are not made again.
pub fn end(world: &mut World) {
    let stopped = world.resource::<Attempt>().is_driven;
    world.resource_mut::<BodyTable>().drives_stopped = stopped;
}

/// Drops the pairs that solutions have added from other positions: each step detects its own.
pub(crate) fn forget_pairs(world: &mut World) {
    world.resource_mut::<AddedPairs>().0.clear();
}

/// Drops findings that hold only for the last solution.
pub(crate) fn forget_passes(world: &mut World) {
    world.insert_resource(Corrections::default());
    world.insert_resource(Pushed::default());
    world.insert_resource(Reached::default());
    world.insert_resource(Centre::default());
}

/// Judge: is the step short enough for constant normals? In a motion that a rupture released, it
/// must also be so short that bonds break close to their limits.
pub fn judge_length(
    tables: SolvedTables,
    acceptance: Res<Acceptance>,
    settings: Res<MotionSettings>,
    mut attempt: ResMut<Attempt>,
) {
    let solved = tables.get();
    let length = attempt.motion().map_or(1.0, |motion| motion.length);
    if let Some((grain, far)) = furthest(solved)
        && !(far <= length * Acceptance::MAX_TRAVEL)
    {
        let (grain, far) = (near(solved.bodies, [grain, grain]), digits(far));
        let message = format!("a step of the motion moves {grain} by {far} radii");
        attempt.verdict = Verdict::TooFar(message);
        return;
    }
    if attempt.motion().is_some_and(|motion| motion.released) {
        let max = 1.0 + settings.max_overload * aimed(&acceptance);
        let overload = most_yielding(solved).filter(|(_, overload)| *overload > max);
        if let Some((contact, overload)) = overload {
            let Contact { a, b, .. } = solved.contacts.0[contact];
            attempt.verdict = Verdict::TooFar(format!(
                "a step of the motion loads the bond of {} to {overload:.2} times its limit",
                near(solved.bodies, [a as usize, b as usize])
            ));
        }
    }
}

/// Repeats the step in a shorter time.
pub fn shorten(world: &mut World) {
    let solved = world.resource::<ConeSolution>().status == SolveStatus::Solved;
    let far = furthest(Solved::of(world));
    let settings = *world.resource::<MotionSettings>();
    let mut attempt = world.resource_mut::<Attempt>();
    count_step(&mut attempt);
    if let Mode::Motion(motion) = &mut attempt.mode {
        let max = motion.length * Acceptance::MAX_TRAVEL;
        let too_far = far.map(|(_, far)| far).filter(|far| solved && *far > max);
        kinetic_damping::shorten(motion, too_far, &settings);
    }
}

fn count_step(attempt: &mut Attempt) {
    attempt.motion_steps += 1;
    attempt.released_steps += u32::from(attempt.motion().is_some_and(|motion| motion.released));
}

/// Moves the tables by the solution of the step, breaks bonds, and sets the weight of the next
/// step.
pub(crate) fn take_step(world: &mut World) {
    let solved = Solved::of(world);
    let far = furthest(solved).map_or(0.0, |(_, far)| far);
    let step = rest::loaded_step(solved);
    let displacements = solved.solution.displacements.clone();
    move_tables(world);
    forget_pairs(world);
    let settings = *world.resource::<MotionSettings>();
    let mut attempt = world.resource_mut::<Attempt>();
    count_step(&mut attempt);
    attempt.is_driven |= attempt.motion().is_some_and(|motion| !motion.released);
    if let Mode::Motion(motion) = &mut attempt.mode {
        kinetic_damping::carry_on(motion, &displacements, far, &settings);
        motion.step = step;
    }
    world.resource_mut::<BodyTable>().drives_stopped = true;
}

/// Moves bodies and contact memory by the solution of the step and breaks the bonds that it brings
/// to a limit.
fn move_tables(world: &mut World) {
    let solved = Solved::of(world);
    let draft = world.resource::<DraftHistory>();
    let mut history = remembered(solved, world.resource(), world.resource(), &draft.0);
    follow_slip(solved, world.resource(), &mut history);
    // A program with a rule of rupture of its own breaks bonds when the increment is committed.
    let broken = if world.contains_resource::<BuiltInRule>() {
        let increment = world.resource::<ClasticProgress>().increment;
        find_ruptures(solved, world.resource(), Met::Overload, increment)
    } else {
        Vec::new()
    };
    release(broken.iter(), Laws::of(world), solved.contacts, &mut history);
    let displacements = solved.program.bodies.iter().zip(&solved.solution.displacements);
    let moved: Vec<_> = displacements.map(|(body, u)| body.to_global(*u)).collect();
    if world.contains_resource::<EnergyLedger>() {
        crate::energy_ledger::book_step(world, &history, &moved, &broken);
    }
    let mut bodies = world.resource_mut::<BodyTable>();
    bodies.move_by(moved.into_iter());
    bodies.break_bonds(&broken.iter().map(|rupture| rupture.bond).collect::<Vec<_>>());
    world.resource_mut::<DraftHistory>().0 = history;
    let mut ruptures = world.resource_mut::<Ruptures>();
    ruptures.list.extend(broken);
    ruptures.on_the_way = ruptures.list.len();
}
