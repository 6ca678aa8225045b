//! From attempt to attempt: the tables of an increment, and what the next action does to them.

use bevy_ecs::prelude::*;
use clastic_components::attempt::{Attempt, IncrementStatus, Mode, Verdict};
use clastic_components::contact::{BodyTable, ContactTable};
use clastic_components::contact_history::DraftHistory;
use clastic_components::energy::MotionEnergies;
use clastic_components::findings::{AddedPairs, EventSearch, Ruptures, Sliding};
use clastic_components::increment::{Acceptance, AnalysisKind, ClasticAnalysis, ClasticProgress};
use clastic_components::loads::TrialLoads;
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::motion;
use super::next::{Budget, Next, next};
use crate::check_values::refused_load;
use crate::control_walls::renew_stresses;
use crate::mechanism::share;
use crate::motion_settings::MotionSettings;
use crate::rupture::events;
use crate::schedule::{AddTrialLoads, AttemptIncrement, ClasticHalted};
use crate::solved::Solved;

/// Runs [`AttemptIncrement`] until the increment has ended.
pub fn run_attempts(world: &mut World) {
    let before = world.resource::<ClasticProgress>().clone();
    begin_increment(world);
    // The tables before the first motion, for restoring them.
    let mut start = None;
    loop {
        if !world.contains_resource::<ClasticHalted>() {
            world.run_schedule(AttemptIncrement);
        }
        if let Some(ClasticHalted(reason)) = world.get_resource::<ClasticHalted>() {
            world.resource_mut::<Attempt>().complaint = reason.clone();
            end_increment(world, IncrementStatus::Undecided, start.as_ref());
            world.insert_resource(before);
            return;
        }
        let budget = budget(world);
        let verdict = std::mem::take(&mut world.resource_mut::<Attempt>().verdict);
        if let (Verdict::GivesWay(_), Some(start)) = (&verdict, &start) {
            let moving = moved(world.resource(), &start.bodies);
            let share = share(&start.bodies, &start.draft.0, &moving);
            world.resource_mut::<Attempt>().moved = Some(share);
        }
        let mut attempt = world.resource_mut::<Attempt>();
        let next = next(&attempt.mode, &verdict, budget);
        complain(&mut attempt, &verdict, next);
        attempt.is_proved |= next == Next::Follow && verdict == Verdict::Impossible;
        if let Next::End(status) = next {
            return end_increment(world, status, start.as_ref());
        }
        act(world, next, &mut start);
    }
}

/// Which particles are more than a radius from where they were.
fn moved(now: &BodyTable, then: &BodyTable) -> Vec<bool> {
    let far = |i: usize| now.positions[i].distance(then.positions[i]) > then.radii[i];
    (0..then.particles).map(far).collect()
}

/// Keeps why the attempt failed, and how a motion that ends here went.
fn complain(attempt: &mut Attempt, verdict: &Verdict, next: Next) {
    use Verdict::{GivesWay, TooFar, Unconverged};
    if let Unconverged(reason) | TooFar(reason) | GivesWay(reason) = verdict
        && attempt.mode != Mode::Proof
    {
        attempt.complaint.clone_from(reason);
    }
    if let (Mode::Motion(motion), Next::Halve | Next::OneRound | Next::End(_)) =
        (&attempt.mode, next)
    {
        let end = format!("the followed motion failed after {} steps", motion.steps);
        // A fraction of the increment that fails like the one before adds nothing.
        if !attempt.complaint.ends_with(&end) {
            let gap = if attempt.complaint.is_empty() { "" } else { "; " };
            attempt.complaint += &format!("{gap}{end}");
        }
    }
}

/// Prepares the next solve.
fn act(world: &mut World, next: Next, start: &mut Option<Start>) {
    match next {
        Next::Solve | Next::End(_) => {}
        Next::Try(effort) => {
            world.resource_mut::<Attempt>().mode = Mode::Equilibrium(effort);
            motion::forget_passes(world);
        }
        Next::Approach => {
            let target = world.resource::<EventSearch>().target;
            world.resource_mut::<ClasticProgress>().fraction = target;
            seek_equilibrium(world);
            open_trial(world);
        }
        Next::Follow => {
            start.get_or_insert_with(|| Start::take(world));
            let is_released =
                events::is_released(world.resource(), world.resource(), world.resource());
            world.resource_mut::<EventSearch>().moved = true;
            motion::begin(world, is_released, false);
        }
        Next::Move => {
            motion::take_step(world);
            open_trial(world);
        }
        Next::Shorten => motion::shorten(world),
        Next::Rest => {
            motion::take_step(world);
            let left = std::mem::take(&mut world.resource_mut::<Attempt>().left);
            let aside = &mut world.resource_mut::<BodyTable>().set_aside;
            left.into_iter().for_each(|i| aside[i] = true);
            open_trial(world);
            seek_equilibrium(world);
        }
        Next::Repeat => {
            put_back(world, start.as_ref());
            let attempt = world.resource::<Attempt>();
            let is_released = attempt.motion().is_some_and(|motion| motion.released);
            open_trial(world);
            motion::begin(world, is_released, true);
        }
        Next::Halve => {
            let mut attempt = world.resource_mut::<Attempt>();
            attempt.halved_turn = attempt.turn.take();
            undo(world, start.take());
            events::halve(world);
            open_trial(world);
        }
        Next::OneRound => {
            undo(world, start.take());
            let mut progress = world.resource_mut::<ClasticProgress>();
            progress.tried = progress.left_of_increment();
            progress.fraction = progress.tried;
            world.insert_resource(EventSearch::default());
            open_trial(world);
        }
        Next::Prove => {
            put_back(world, start.as_ref());
            let mut attempt = world.resource_mut::<Attempt>();
            attempt.mode = Mode::Proof;
            attempt.magnitudes = None;
            open_trial(world);
        }
    }
}

/// Part of a turn below which a halving must reduce it. A turn in proportion to the increment falls
/// to a half, that of a jump stays.
const SHRUNK: f64 = 2.0 / 3.0;

/// The tables that a motion changes.
struct Start {
    bodies: BodyTable,
    draft: DraftHistory,
    ruptures: Ruptures,
    energies: MotionEnergies,
    /// What proves that the increment has no equilibrium, if something does.
    proof: Option<(ContactTable, ConeProgram, ConeSolution)>,
}

impl Start {
    fn take(world: &World) -> Self {
        Self {
            bodies: world.resource::<BodyTable>().clone(),
            draft: world.resource::<DraftHistory>().clone(),
            ruptures: world.resource::<Ruptures>().clone(),
            energies: world.resource::<MotionEnergies>().clone(),
            proof: world.resource::<Attempt>().is_proved.then(|| {
                let Solved { contacts, program, solution, .. } = Solved::of(world);
                (contacts.clone(), program.clone(), solution.clone())
            }),
        }
    }
}

/// Restores the tables to the state before the first motion.
fn put_back(world: &mut World, start: Option<&Start>) {
    world.resource_mut::<Attempt>().is_driven = false;
    motion::end(world);
    if let Some(start) = start {
        motion::forget_pairs(world);
        world.resource_mut::<BodyTable>().clone_from(&start.bodies);
        world.resource_mut::<DraftHistory>().clone_from(&start.draft);
        world.resource_mut::<Ruptures>().clone_from(&start.ruptures);
        world.resource_mut::<MotionEnergies>().clone_from(&start.energies);
    }
}

/// Restores the tables for another fraction of the increment.
fn undo(world: &mut World, start: Option<Start>) {
    put_back(world, start.as_ref());
    seek_equilibrium(world);
    world.insert_resource(Ruptures::default());
    let mut attempt = world.resource_mut::<Attempt>();
    attempt.motions = 0;
    attempt.is_proved = false;
}

fn begin_increment(world: &mut World) {
    world.insert_resource(Attempt::default());
    world.insert_resource(AddedPairs::default());
    world.insert_resource(MotionEnergies::default());
    world.insert_resource(Ruptures::default());
    world.insert_resource(Sliding::default());
    motion::forget_passes(world);
    let mut progress = world.resource_mut::<ClasticProgress>();
    progress.increment += 1;
    // Fractions end where whole increments end. A halved fraction may grow again.
    let left = 1.0 - progress.done.fract();
    if !progress.relaxing {
        progress.tried = (2.0 * progress.tried).clamp(f64::MIN_POSITIVE, left);
    }
    progress.fraction = if progress.relaxing { 0.0 } else { progress.tried };
    events::begin(world);
    open_trial(world);
}

/// Options that the increment still has.
fn budget(world: &World) -> Budget {
    let attempt = world.resource::<Attempt>();
    let settings = world.resource::<MotionSettings>();
    let search = world.resource::<EventSearch>();
    let is_static = world.resource::<ClasticAnalysis>().kind == AnalysisKind::Static;
    Budget {
        motion: is_static && attempt.motions < settings.max_motions,
        step: motion::has_step(attempt, world.resource(), settings),
        half: world.resource::<Acceptance>().halves(world.resource::<ClasticProgress>().fraction),
        searches: search.active,
        breaks: search.active || search.dense,
        shrinks: attempt.motions == 0
            && attempt.turn.is_some_and(|turn| {
                attempt.halved_turn.is_none_or(|halved| turn <= SHRUNK * halved)
            }),
        is_proved: attempt.is_proved,
    }
}

/// Begins a trial: another fraction of the increment, or other positions of the bodies. Asks for the
/// loads of an embedding program; one without a meaning halts the world.
fn open_trial(world: &mut World) {
    if world.resource::<BodyTable>().drives_stopped {
        world.resource_scope(|world, mut bodies: Mut<BodyTable>| {
            let (world, table_of) = (&*world, |wall| world.get(wall));
            renew_stresses(&mut bodies, table_of, world.resource(), world.resource());
        });
    }
    world.resource_mut::<TrialLoads>().clear();
    world.run_schedule(AddTrialLoads);
    if let Some(message) = refused_load(world.resource(), world.resource()) {
        world.insert_resource(ClasticHalted(message));
    }
}

/// Seeks the equilibrium from the current positions.
fn seek_equilibrium(world: &mut World) {
    motion::end(world);
    motion::forget_passes(world);
    let mut attempt = world.resource_mut::<Attempt>();
    attempt.mode = Mode::default();
    attempt.magnitudes = None;
}

fn end_increment(world: &mut World, status: IncrementStatus, start: Option<&Start>) {
    motion::end(world);
    if status == IncrementStatus::Solved {
        let broken = std::mem::take(&mut world.resource_mut::<EventSearch>().broken);
        world.resource_mut::<Ruptures>().list.extend(broken);
    } else {
        world.resource_mut::<EventSearch>().in_avalanche = false;
    }
    let is_capped = status == IncrementStatus::Solved && world.resource::<Sliding>().capped;
    let status = if is_capped { IncrementStatus::Capped } else { status };
    if status == IncrementStatus::Collapsed {
        // A collapse does not commit the motion.
        put_back(world, start);
        if let Some((contacts, program, solution)) = start.and_then(|start| start.proof.clone()) {
            world.insert_resource(contacts);
            world.insert_resource(program);
            world.insert_resource(solution);
        }
    }
    if status == IncrementStatus::Undecided
        && let Some(best) = world.resource_mut::<Attempt>().best.take()
    {
        world.resource_mut::<ConeSolution>().residuals = best.residuals;
    }
    world.resource_mut::<Attempt>().status = status;
}
