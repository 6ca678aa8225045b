//! Settling: where the next equilibrium lies so far away that a grain would be thrown, loose
//! grains are led towards it in small overdamped steps.
//!
//! A static solution knows no path. A grain that has lost its support finds its new place by
//! frozen normals, far away and through others. Instead, with walls and loads at rest, the program
//! is solved with a proximal term (friction against the ground, of no physical meaning) that keeps
//! the motion small, bodies are moved, contacts are detected again at the new places, and so on,
//! until the increment itself no longer throws a grain. The states on the way are not recorded and
//! break no bonds; the increment that follows has no such term. If it fails after all, everything
//! is put back to where it was.

use bevy_ecs::prelude::*;
use bevy_ecs::system::RunSystemOnce;

use clastic_components::attempt::{Attempt, IncrementStatus, Verdict};
use clastic_components::body::{AppliedLoad, Drive, Drives, LastMotion, Position, Ramp, Rotation};
use clastic_components::contact::ContactHistory;
use clastic_components::increment::Acceptance;
use clastic_components::wall::{Wall, WallDrive};

use super::thrown_grains::furthest;
use crate::schedule::AttemptIncrement;
use crate::update_state::{move_bodies, remember_contacts};

/// Settling steps of one increment at most.
pub const MAX_STEPS: u32 = 200;
/// Weight of the first step, in units of force scale over displacement scale.
const FIRST_WEIGHT: f64 = 1e-4;
/// Factor between a weight that throws grains and the next one tried, and the greatest between two
/// steps the other way.
const FACTOR: f64 = 10.0;
/// Failures in a row that end the settling.
const MAX_FAILURES: u32 = 8;
/// At this weight the increment itself is tried.
const LAST_WEIGHT: f64 = 1e-8;

/// What settling changes, to be put back.
pub struct Snapshot {
    bodies: Vec<(Entity, Position, Option<Rotation>, LastMotion)>,
    history: ContactHistory,
}

impl Snapshot {
    /// Takes down places and contact history.
    pub fn take(world: &mut World) -> Self {
        let mut query = world.query::<(Entity, &Position, Option<&Rotation>, &LastMotion)>();
        let bodies = query.iter(world).map(|(e, x, r, m)| (e, *x, r.copied(), *m)).collect();
        Self { bodies, history: world.resource::<ContactHistory>().clone() }
    }

    /// Puts them back.
    pub fn restore(self, world: &mut World) {
        for (entity, position, rotation, motion) in self.bodies {
            let mut entity = world.entity_mut(entity);
            entity.insert((position, motion));
            if let Some(rotation) = rotation {
                entity.insert(rotation);
            }
        }
        world.insert_resource(self.history);
    }
}

/// Walls and loads at rest for the time of settling, with what they were to do.
struct Rest {
    walls: Vec<(Entity, WallDrive)>,
    drives: Vec<(Entity, Drives)>,
    loads: Vec<(Entity, AppliedLoad)>,
}

impl Rest {
    fn begin(world: &mut World) -> Self {
        let mut walls = Vec::new();
        let mut query = world.query_filtered::<(Entity, &mut WallDrive), With<Wall>>();
        for (entity, mut drive) in query.iter_mut(world) {
            walls.push((entity, *drive));
            *drive = match *drive {
                WallDrive::Imposed(_) => WallDrive::default(),
                WallDrive::Loaded(ramp) => WallDrive::Loaded(still(ramp)),
            };
        }
        let (mut drives, mut loads) = (Vec::new(), Vec::new());
        let mut query = world.query::<(Entity, &mut Drives, &mut AppliedLoad)>();
        for (entity, mut drive, mut load) in query.iter_mut(world) {
            drives.push((entity, *drive));
            loads.push((entity, *load));
            drive.0 = drive.0.map(|d| match d {
                Drive::Imposed(_) => Drive::Imposed(0.0),
                Drive::Free => Drive::Free,
            });
            load.0 = load.0.map(still);
        }
        Self { walls, drives, loads }
    }

    fn end(self, world: &mut World) {
        for (entity, drive) in self.walls {
            world.entity_mut(entity).insert(drive);
        }
        for (entity, drives) in self.drives {
            world.entity_mut(entity).insert(drives);
        }
        for (entity, load) in self.loads {
            world.entity_mut(entity).insert(load);
        }
    }
}

fn still(ramp: Ramp) -> Ramp {
    Ramp { from: ramp.from, to: ramp.from }
}

/// Takes settling steps of about the same motion: the weight follows from how far grains moved in
/// the step before. Ends when grains hardly move at a vanishing weight: then the increment itself
/// may be tried again. Returns whether anything moved.
pub fn settle(world: &mut World) -> bool {
    let rest = Rest::begin(world);
    let wanted = 0.7 * world.resource::<Acceptance>().throw;
    let mut weight = FIRST_WEIGHT;
    let mut failures = 0;
    let mut moved = false;
    loop {
        let mut attempt = world.resource_mut::<Attempt>();
        if attempt.settled >= MAX_STEPS || failures > MAX_FAILURES {
            break;
        }
        attempt.settled += 1;
        attempt.settling = Some(weight);
        if !solves(world) {
            failures += 1;
            weight *= FACTOR;
            continue;
        }
        failures = 0;
        let far =
            furthest(world.resource(), world.resource(), world.resource()).map_or(0.0, |f| f.1);
        // The two systems run outside of their schedule: the step is no increment.
        let _ = world.run_system_once(move_bodies);
        let _ = world.run_system_once(remember_contacts);
        moved = true;
        if weight <= LAST_WEIGHT {
            break;
        }
        weight = (weight * (far / wanted).clamp(1.0 / FACTOR, 1.0)).max(LAST_WEIGHT);
    }
    let mut attempt = world.resource_mut::<Attempt>();
    attempt.settling = None;
    attempt.status = IncrementStatus::Solved;
    rest.end(world);
    moved
}

/// Solves the settling step, with the pairs that it closes; whether it can be accepted.
fn solves(world: &mut World) -> bool {
    for _ in 0..20 {
        world.run_schedule(AttemptIncrement);
        let mut attempt = world.resource_mut::<Attempt>();
        match std::mem::take(&mut attempt.verdict) {
            Verdict::Accept => return attempt.status == IncrementStatus::Solved,
            Verdict::Again => {}
            Verdict::Reject(_) | Verdict::Thrown(_) => return false,
        }
    }
    false
}
