//! A specimen that gives way: it strains on and on under its loads, or takes no part of what is added to
//! them without doing so. That is a collapse; a mechanism of its state before may prove it.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, IncrementStatus, Verdict};
use clastic_components::contact::{Bodies, Contacts};
use clastic_components::program::{ConeProgram, ConeSolution};

use super::settle::Snapshot;
use crate::schedule::AttemptIncrement;

/// Mechanisms that are looked at for one that proves a collapse.
const MAX_PROOFS: u32 = 20;

/// Ends the increment as a collapse, with the specimen as it was `before`. Where no mechanism is found, what
/// the last attempt left is the record of the increment, and the `reason` says what was seen.
pub(super) fn give_way(world: &mut World, before: &Snapshot, reason: String) {
    before.restore(world);
    let attempt = world.resource::<Attempt>().clone();
    let tables = (
        world.resource::<Bodies>().clone(),
        world.resource::<Contacts>().clone(),
        world.resource::<ConeProgram>().clone(),
        world.resource::<ConeSolution>().clone(),
    );
    if !is_proved(world) {
        let (bodies, contacts, program, solution) = tables;
        world.insert_resource(attempt);
        world.insert_resource(bodies);
        world.insert_resource(contacts);
        world.insert_resource(program);
        world.insert_resource(ConeSolution { certificate: None, ..solution });
    }
    let mut attempt = world.resource_mut::<Attempt>();
    attempt.status = IncrementStatus::Collapsed;
    attempt.complaint = reason;
    attempt.verdict = Verdict::Accept;
}

/// Looks for mechanisms until one closes no pair that is not in the program. Returns whether one proves the
/// collapse.
fn is_proved(world: &mut World) -> bool {
    let mut attempt = world.resource_mut::<Attempt>();
    attempt.proving = true;
    attempt.effort = 0;
    // What a throw over many radii closed is out of the reach of a mechanism.
    attempt.added_pairs.clear();
    let mut proved = false;
    for _ in 0..MAX_PROOFS {
        world.run_schedule(AttemptIncrement);
        let mut attempt = world.resource_mut::<Attempt>();
        let verdict = std::mem::take(&mut attempt.verdict);
        if verdict != Verdict::Again {
            let collapsed = attempt.status == IncrementStatus::Collapsed;
            proved = verdict == Verdict::Accept && collapsed;
            break;
        }
    }
    world.resource_mut::<Attempt>().proving = false;
    proved
}
