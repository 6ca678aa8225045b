//! The attempts at one increment, and the judges that accept, extend or reject them.
//!
//! Judges run in this order, each only while the verdict is still to accept: [`converged`],
//! [`closing_mechanism`], [`restraints`], [`thrown_grains`], [`closed_pairs`], [`snaps`], [`push_out`],
//! [`coulomb`], [`corrector`], [`cascade`]. What an attempt finds out (pairs, restraints, openings,
//! ruptures) is kept in [`Attempt`] until the increment is committed.
//!
//! A rejected increment is tried again: with the magnitudes that the failed attempt found as
//! scales, unless it moved grains very far; then with every body regularised and the centre of the
//! regularisation following the solution, so that no bias is left; then with half the increment, and
//! so on. Where a solution would throw grains, they [`settle`] first. Where a specimen gives way instead,
//! a mechanism is sought that proves its collapse.

pub mod cascade;
pub mod closed_pairs;
pub mod closing_mechanism;
pub mod converged;
pub mod corrector;
pub mod coulomb;
mod giving_way;
pub mod push_out;
pub mod restraints;
pub mod settle;
pub mod snaps;
pub mod thrown_grains;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::attempt::{Attempt, IncrementStatus, Verdict};
use clastic_components::body::{AppliedLoad, Ramp};
use clastic_components::contact::{Bodies, ContactHistory};
use clastic_components::increment::{
    Acceptance, Analysis, AnalysisKind, Corrector, FrictionLaw, Progress, RuptureRules,
};
use clastic_components::program::{ConeSolution, SolveStatus};
use clastic_components::wall::WallDrive;

use self::giving_way::give_way;
use self::settle::Settled;
use crate::assemble_program::loose;
use crate::schedule::{AttemptIncrement, AttemptSystems, Increment, IncrementSystems, start_clock};

/// Adds [`run_attempts`] and the judges.
pub struct AttemptPlugin;

impl Plugin for AttemptPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Attempt>()
            .init_resource::<Acceptance>()
            .init_resource::<Analysis>()
            .init_resource::<FrictionLaw>()
            .init_resource::<Corrector>()
            .init_resource::<RuptureRules>()
            .init_resource::<Progress>()
            .add_systems(
                Increment,
                (start_clock, run_attempts).chain().in_set(IncrementSystems::Attempts),
            )
            .add_systems(
                AttemptIncrement,
                (
                    converged::judge,
                    closing_mechanism::judge.run_if(collapsed),
                    restraints::judge.run_if(collapsed),
                    thrown_grains::judge.run_if(accepted),
                    closed_pairs::judge.run_if(accepted),
                    snaps::judge.run_if(accepted),
                    push_out::judge.run_if(accepted),
                    coulomb::judge.run_if(accepted),
                    corrector::judge.run_if(accepted),
                    cascade::judge.run_if(accepted),
                )
                    .chain()
                    .in_set(AttemptSystems::Judge),
            );
    }
}

/// Run condition: no judge has objected so far.
fn accepted(attempt: Res<Attempt>) -> bool {
    attempt.verdict == Verdict::Accept && attempt.status == IncrementStatus::Solved
}

/// Run condition: the program has no equilibrium, and nothing else is the matter.
fn collapsed(attempt: Res<Attempt>) -> bool {
    attempt.verdict == Verdict::Accept && attempt.status == IncrementStatus::Collapsed
}

/// More solves than this in one increment mean that the attempts go round in circles.
const MAX_SOLVES: u32 = 1000;

/// A grain that an unconverged solution moves further than this, in its radii, has nothing to hold it.
const FLUNG: f64 = 10.0;

/// A throw of more than this fraction of what it was in the whole increment has other reasons.
const IN_VAIN: f64 = 0.75;

/// Runs [`AttemptIncrement`] until an attempt is accepted, the increment collapses, or nothing
/// that helps is left.
pub fn run_attempts(world: &mut World) {
    let acceptance = *world.resource::<Acceptance>();
    let bounded = carries_loads(world);
    *world.resource_mut::<Attempt>() = Attempt { bounded, ..Attempt::default() };
    {
        let mut progress = world.resource_mut::<Progress>();
        progress.increment += 1;
        // Fractions end where whole increments do; what was halved may grow again.
        let left = 1.0 - progress.done.fract();
        progress.fraction = (2.0 * progress.fraction).clamp(f64::MIN_POSITIVE, left);
    }
    let before = settle::Snapshot::take(world);
    let mut strained = 0.0;
    // How far grains were thrown when the increment was last halved for it.
    let mut halved: Option<f64> = None;
    // Whether grains settled without bonds that a cascade had broken.
    let mut parted = false;
    // Of a whole increment, not of what the last one could take: else a specimen that is stuck
    // would creep on in ever smaller steps.
    let finest = 0.5_f64.powf(f64::from(acceptance.halvings));
    loop {
        world.run_schedule(AttemptIncrement);
        let mut attempt = world.resource_mut::<Attempt>();
        let verdict = match std::mem::take(&mut attempt.verdict) {
            Verdict::Again if attempt.solves >= MAX_SOLVES => {
                Verdict::Reject(format!("{MAX_SOLVES} solves"))
            }
            verdict => verdict,
        };
        let mut snaps = false;
        let rejected = matches!(verdict, Verdict::Reject(_));
        let reason = match verdict {
            Verdict::Accept => {
                if attempt.status == IncrementStatus::Solved && attempt.capped {
                    attempt.status = IncrementStatus::Capped;
                }
                if attempt.status == IncrementStatus::Collapsed {
                    // A collapse commits no motion, that of settling grains neither.
                    before.restore(world);
                }
                return;
            }
            Verdict::Again => continue,
            Verdict::Reject(reason) => {
                // Rigid bodies that have no motion have none with other scales either.
                let locked = attempt.status == IncrementStatus::Locked;
                if !locked && attempt.effort < loose::RETRY && attempt.solves < MAX_SOLVES {
                    let flung = is_flung(world);
                    let mut attempt = world.resource_mut::<Attempt>();
                    attempt.effort = if flung { loose::RETRY } else { attempt.effort + 1 };
                    forget(&mut attempt, reason);
                    continue;
                }
                reason
            }
            Verdict::Thrown(reason) => {
                snaps = attempt.snaps;
                let settled = attempt.settled;
                let learnt = std::mem::take(&mut attempt.learnt);
                let far = settle::furthest_motion(world);
                // Grains that go as far as before they settled follow what moves in this increment:
                // in half of it they go half as far.
                let by_half = !snaps
                    && !settle::is_cured(world)
                    && 0.5 * far <= acceptance.throw
                    && halved.is_none_or(|before| far <= IN_VAIN * before)
                    && 0.5 * world.resource::<Progress>().fraction >= finest;
                let mut attempt = world.resource_mut::<Attempt>();
                if by_half {
                    halved = Some(far);
                } else if settled < settle::MAX_STEPS {
                    // What a cascade broke stays broken while the grains settle: it is why they do.
                    parted |= !attempt.ruptures.is_empty();
                    forget_solution(&mut attempt, reason.clone());
                    match settle::settle(world, &mut strained) {
                        Settled::Moved => continue,
                        Settled::AtRest if learnt => continue,
                        Settled::AtRest => {}
                        Settled::GaveWay => {
                            return give_way(world, &before, reason);
                        }
                    }
                } else if learnt && attempt.solves < MAX_SOLVES {
                    forget_solution(&mut attempt, reason);
                    continue;
                }
                reason
            }
        };
        let half = 0.5 * world.resource::<Progress>().fraction;
        let mut attempt = world.resource_mut::<Attempt>();
        if half < finest || attempt.solves >= MAX_SOLVES {
            if snaps {
                return give_way(world, &before, reason);
            }
            let mut attempt = world.resource_mut::<Attempt>();
            attempt.status = final_status(attempt.status);
            attempt.complaint = reason;
            if let Some((best, _)) = attempt.best.take().filter(|_| rejected) {
                world.resource_mut::<ConeSolution>().residuals = best;
            }
            before.restore(world);
            return;
        }
        attempt.effort = 0;
        attempt.magnitudes = None;
        forget(&mut attempt, reason);
        world.resource_mut::<Progress>().fraction = half;
        if std::mem::take(&mut parted) {
            // Half the increment may break none of them.
            before.restore(world);
            strained = 0.0;
        }
    }
}

/// Whether a static solution that did not converge moves a grain very far: what it lacks is a hold, not
/// other scales.
fn is_flung(world: &World) -> bool {
    let complete = world.resource::<ConeSolution>().displacements.len()
        == world.resource::<Bodies>().positions.len();
    complete
        && world.resource::<Analysis>().kind == AnalysisKind::Static
        && settle::furthest_motion(world) > FLUNG
}

/// Whether anything but walls that move as they are told to acts on a specimen that carries something
/// already. One that does not may come to its first support over any distance.
fn carries_loads(world: &mut World) -> bool {
    let acts = |ramp: &Ramp| ramp.from != 0.0 || ramp.to != 0.0;
    let mut walls = world.query::<&WallDrive>();
    let mut loads = world.query::<&AppliedLoad>();
    world.resource::<ContactHistory>().0.iter().any(|m| m.p != 0.0)
        && (world.resource::<Analysis>().gravity != DVec2::ZERO
            || walls.iter(world).any(|d| matches!(d, WallDrive::Loaded(ramp) if acts(ramp)))
            || loads.iter(world).any(|load| load.0.iter().any(acts)))
}

/// A locked program that no halving unlocks stays locked; all else has stalled.
fn final_status(status: IncrementStatus) -> IncrementStatus {
    if status == IncrementStatus::Locked { status } else { IncrementStatus::Stalled }
}

/// Drops what a rejected attempt had concluded; pairs stay, they cost little.
fn forget(attempt: &mut Attempt, reason: String) {
    forget_solution(attempt, reason);
    attempt.ruptures.clear();
    attempt.cascade_rounds = 0;
}

/// Drops what a rejected attempt had concluded, except for what a cascade has broken.
fn forget_solution(attempt: &mut Attempt, reason: String) {
    attempt.complaint = reason;
    attempt.snaps = false;
    attempt.replies = 0;
    attempt.capped = false;
    attempt.openings.clear();
    attempt.coulomb_passes = 0;
    attempt.corrections.clear();
    attempt.corrector_passes = 0;
    attempt.pushed = None;
    attempt.centre.clear();
    attempt.centres = 0;
    attempt.status = IncrementStatus::Solved;
}

/// Greatest displacement and force of a solution, as scales for the next attempt.
fn magnitudes(solution: &ConeSolution, mean_radius: f64) -> Option<(f64, f64)> {
    if !matches!(solution.status, SolveStatus::Stalled | SolveStatus::Solved) {
        return None;
    }
    let u = solution.displacements.iter().map(|u| u[0].hypot(u[1])).fold(0.0, f64::max);
    let f = solution.forces.iter().map(|f| f[0].abs().max(f[1].abs())).fold(0.0, f64::max);
    let sound = u.is_finite() && f.is_finite() && u > 0.0 && f > 0.0;
    // A grain thrown far must not set the scale.
    sound.then(|| (u.min(0.1 * mean_radius), f))
}
