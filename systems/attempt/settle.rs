//! Settling: where the next equilibrium lies so far away that a grain would be thrown, loose
//! grains are led towards it in small overdamped steps.
//!
//! A static solution knows no path. A grain that has lost its support finds its new place by
//! frozen normals, far away and through others. Instead, with walls and loads at rest and all but
//! the thrown grains and their surroundings held, the program is solved with a proximal term
//! (friction against the ground, of no physical meaning) that keeps the motion small, bodies are
//! moved, contacts are detected again at the new places, and so on, until the increment itself no
//! longer throws a grain. The states on the way are not recorded and break no bonds; the increment
//! that follows has no such term. If it fails after all, everything is put back to where it was.

use bevy_ecs::prelude::*;
use bevy_ecs::system::RunSystemOnce;
use glam::DVec2;

use clastic_components::attempt::{Attempt, IncrementStatus, Verdict};
use clastic_components::body::{AppliedLoad, Drive, Drives, LastMotion, Position, Ramp, Rotation};
use clastic_components::contact::{Bodies, ContactHistory};
use clastic_components::increment::Acceptance;
use clastic_components::program::{ConeProgram, ConeSolution};
use clastic_components::wall::{Wall, WallDrive};

use super::thrown_grains::{far_motions, furthest, mean_strain, motions};
use crate::control_walls::control_walls;
use crate::schedule::AttemptIncrement;
use crate::update_state::{move_bodies, remember_contacts};

/// Settling steps of one increment at most.
pub const MAX_STEPS: u32 = 200;
/// Motion of the grain that moves furthest in a settling step, in its radii: what is aimed at, and
/// what is not accepted, since the normals are those of the start.
const STEP: f64 = 0.2;
const TOO_FAR: f64 = 0.3;
const MUCH_TOO_FAR: f64 = 0.6;
/// Pairs closer than this, in mean radii, take part in every step.
const REACH: f64 = 0.1;
/// Grains that travelled less than this, in their radii, were at rest.
const RESTFUL: f64 = 1e-2;
/// Grains that move further than this fraction of the accepted throw settle with the thrown one,
/// and with them what lies within so many interactions.
const FAR: f64 = 0.25;
const RINGS: u32 = 4;
/// Where that leaves a throw of more than this fraction of what it was, what keeps the grains moving is
/// further away: all settle.
const CURED: f64 = 0.5;
/// The weight that damps nothing, in units of force scale over displacement scale. The last steps are
/// made with it, limited in number: what still moves then (bonds at their limits, which settling does
/// not break) would do so without end.
const LEAST_WEIGHT: f64 = 1e-9;
const MAX_LAST: u32 = 4;
/// It is the weight of the first step too where the throw exceeds the accepted one by no more than this
/// factor,
const NEARLY: f64 = 1.2;
/// else, or where that step goes too far, this one is.
const FIRST_WEIGHT: f64 = 1e-3;
/// The increment is tried where the grains move less than this, in their radii, with a weight below
/// that.
const NEAR_REST: f64 = 0.05;
const SMALL_WEIGHT: f64 = 1e-6;
/// Factor between a weight that throws grains and the next one tried, and the greatest between two
/// steps the other way.
const RISE: f64 = 10.0;
const FALL: f64 = 100.0;
/// The next weights stay above one that went too far by this factor, and by [`RISE`] less with every
/// step.
const ABOVE: f64 = 3.0;
/// Failures in a row that end the settling.
const MAX_FAILURES: u32 = 8;
/// Steps in which grains turned back or were thrown again, after which settling ends.
const MAX_TURNS: u32 = 6;

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
    pub fn restore(&self, world: &mut World) {
        for &(entity, position, rotation, motion) in &self.bodies {
            let mut entity = world.entity_mut(entity);
            entity.insert((position, motion));
            if let Some(rotation) = rotation {
                entity.insert(rotation);
            }
        }
        world.insert_resource(self.history.clone());
        let _ = world.run_system_once(control_walls);
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

/// Lets the grains that were thrown and their neighbours settle, with all others held: the
/// increment that follows lets go of all of them. Where nothing moves so, or that has not cured the
/// throw before, what keeps them is further away, and all settle. `strained` is what the mean field has
/// strained so far in this increment.
pub fn settle(world: &mut World, strained: &mut f64) -> Settled {
    let far = furthest_motion(world);
    let held = if is_cured(world) { patch(world) } else { Vec::new() };
    let mut attempt = world.resource_mut::<Attempt>();
    attempt.patched = (!held.is_empty()).then_some(far);
    attempt.held = held;
    let mut settled = approach(world, strained);
    let held = std::mem::take(&mut world.resource_mut::<Attempt>().held);
    if settled == Settled::AtRest && !held.is_empty() {
        settled = approach(world, strained);
    }
    // A stress acts on the length that there is now.
    let _ = world.run_system_once(control_walls);
    settled
}

/// Whether the last throw is much less than what grains were to settle for with others held.
pub fn is_cured(world: &World) -> bool {
    let before = world.resource::<Attempt>().patched;
    before.is_none_or(|before| furthest_motion(world) <= CURED * before)
}

/// What came of settling.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Settled {
    /// Nothing moved.
    AtRest,
    /// Grains moved: the increment is to be tried again.
    Moved,
    /// The specimen gave way under its loads and found no rest.
    GaveWay,
}

/// Bodies to hold: all but the grains that the last solution moves far about the mean field, and
/// what lies within [`RINGS`] interactions of them.
fn patch(world: &World) -> Vec<bool> {
    let (bodies, program) = (world.resource::<Bodies>(), world.resource::<ConeProgram>());
    let solution = world.resource::<ConeSolution>();
    let far = far_motions(bodies, program, solution);
    let greatest = far.iter().copied().fold(0.0, f64::max);
    let least = (FAR * world.resource::<Acceptance>().throw).min(0.5 * greatest);
    let mut held = vec![true; program.bodies.len()];
    for (held, far) in held.iter_mut().zip(&far) {
        *held = !(*far >= least);
    }
    for _ in 0..RINGS {
        let inner = held.clone();
        for c in &program.interactions {
            let (a, b) = (c.a as usize, c.b as usize);
            // A wall is no bridge: it touches grains everywhere.
            if b < bodies.particles && inner[a] != inner[b] {
                held[a] = false;
                held[b] = false;
            }
        }
    }
    if held[..bodies.particles].iter().filter(|h| !**h).count() > bodies.particles / 2 {
        return Vec::new();
    }
    held
}

/// Takes settling steps of about the same motion: the weight follows from how far grains moved in
/// the step before, and grows where they turn back. Ends when grains hardly move at a vanishing
/// weight: then the increment itself may be tried again.
fn approach(world: &mut World, strained: &mut f64) -> Settled {
    let rest = Rest::begin(world);
    let reach = REACH * world.resource::<Bodies>().mean_radius;
    world.resource_mut::<Attempt>().reach = reach;
    let nearly = furthest_motion(world) <= NEARLY * world.resource::<Acceptance>().throw;
    let mut weight = if nearly { LEAST_WEIGHT } else { FIRST_WEIGHT };
    // Not to fall at once to what went too far.
    let mut least = LEAST_WEIGHT;
    let mut failures = 0;
    // A grain on a hinge swings to and fro and never comes to rest; the others do.
    let mut turns = 0;
    let mut last_steps = 0;
    let mut travelled = 0.0;
    let mut last = Vec::new();
    loop {
        let mut attempt = world.resource_mut::<Attempt>();
        if attempt.settled >= MAX_STEPS || failures > MAX_FAILURES || turns > MAX_TURNS {
            break;
        }
        attempt.settled += 1;
        attempt.settling = Some(weight);
        attempt.replies = 0;
        let far = if solves(world) { furthest_motion(world) } else { f64::INFINITY };
        if !(far <= TOO_FAR) {
            failures += 1;
            turns += u32::from(travelled > 0.0);
            least = weight * ABOVE;
            weight = if weight < SMALL_WEIGHT { FIRST_WEIGHT } else { weight * RISE };
            continue;
        }
        failures = 0;
        // The two systems run outside of their schedule: the step is no increment.
        let _ = world.run_system_once(move_bodies);
        let _ = world.run_system_once(remember_contacts);
        travelled += far;
        *strained += mean_strain(world.resource(), world.resource(), world.resource());
        if gives_way(world, *strained) {
            break;
        }
        last_steps += u32::from(weight <= LEAST_WEIGHT);
        if (weight <= SMALL_WEIGHT && far <= NEAR_REST) || last_steps >= MAX_LAST {
            break;
        }
        let particles = world.resource::<Bodies>().particles;
        let motion = motions(particles, world.resource(), world.resource());
        let along: f64 = motion.iter().zip(&last).map(|(u, v): (&DVec2, &DVec2)| u.dot(*v)).sum();
        weight = if far > RESTFUL && along < 0.0 {
            turns += 1;
            (weight * RISE).max(FIRST_WEIGHT)
        } else {
            (weight * (far / STEP).powi(3).clamp(1.0 / FALL, 1.0)).max(least)
        };
        least = (least / RISE).max(LEAST_WEIGHT);
        last = motion;
    }
    let mut attempt = world.resource_mut::<Attempt>();
    attempt.settling = None;
    (attempt.learnt, attempt.replies) = (false, 0);
    attempt.reach = 0.0;
    attempt.status = IncrementStatus::Solved;
    rest.end(world);
    if gives_way(world, *strained) {
        Settled::GaveWay
    } else if travelled > RESTFUL {
        Settled::Moved
    } else {
        Settled::AtRest
    }
}

fn gives_way(world: &World, strained: f64) -> bool {
    world.resource::<Attempt>().bounded && strained > world.resource::<Acceptance>().snap
}

/// How far, in its radii, the grain that moves furthest moves about the mean field.
pub fn furthest_motion(world: &World) -> f64 {
    furthest(world.resource(), world.resource(), world.resource()).map_or(0.0, |(_, far)| far)
}

/// Solves the settling step, with the pairs that it closes; whether it can be accepted. What goes much
/// too far is not worth the search for the pairs that it closes on the way.
fn solves(world: &mut World) -> bool {
    for _ in 0..20 {
        world.run_schedule(AttemptIncrement);
        let mut attempt = world.resource_mut::<Attempt>();
        match std::mem::take(&mut attempt.verdict) {
            Verdict::Accept => return attempt.status == IncrementStatus::Solved,
            Verdict::Reject(_) => return false,
            Verdict::Thrown(_) if !std::mem::take(&mut attempt.learnt) => return false,
            Verdict::Again | Verdict::Thrown(_) if furthest_motion(world) <= MUCH_TOO_FAR => {}
            Verdict::Again | Verdict::Thrown(_) => return false,
        }
    }
    false
}
