//! From a world to its state.

use bevy_ecs::prelude::*;

use clastic_components::body::{
    AngularVelocity, AppliedLoad, BodyId, Drives, ExternalForce, Group, LastMotion, LoadControl,
    Origin, Position, Probe, Rotation, Velocity,
};
use clastic_components::bond::{Bond, BondId, BondState};
use clastic_components::contact::ContactHistory;
use clastic_components::energy::EnergyLedger;
use clastic_components::identity::Identities;
use clastic_components::increment::{Analysis, Progress};
use clastic_components::material::{ContactLaw, Materials};
use clastic_components::observation::{Measures, Observation, RuptureCount};
use clastic_components::particle::{MaterialIndex, Particle, Swinging};
use clastic_components::wall::{LoadedLength, Wall, WallControl, WallDrive, WallName};
use clastic_systems::solve_program::Solver;

use super::{ControlState, LengthState, ParticleState, ScriptState, WallState, WorldState};
use crate::run::stages::{Before, Outcome, Script};

impl WorldState {
    /// The state of a world in which no increment is under way. If the last increment stalled, it
    /// is the state before that increment: nothing of it was committed.
    pub fn capture(world: &mut World) -> Self {
        let particles = particles(world);
        let walls = walls(world);
        let mut bonds = world.query::<(&BondId, &Bond, &BondState)>();
        let mut bonds: Vec<_> = bonds.iter(world).map(|(id, b, state)| (*id, *b, *state)).collect();
        bonds.sort_unstable_by_key(|(id, ..)| *id);

        let script = world.resource::<Script>();
        let stalled = matches!(script.outcome, Some(Outcome::Undecided { .. }));
        let before = world.get_resource::<Before>().filter(|_| stalled);
        let mut ends = script.ends.clone();
        if let Some(end) = ends.last_mut().filter(|_| before.is_some()) {
            end.increments -= 1;
            end.ended_by = None;
        }
        let (progress, observation, solver) = match before {
            Some(before) => (&before.progress, &before.observation, before.solver.as_slice()),
            None => (
                world.resource::<Progress>(),
                world.resource::<Observation>(),
                world.get_resource::<Solver>().map_or(&[][..], |solver| solver.0.memory()),
            ),
        };
        Self {
            progress: progress.clone(),
            script: ScriptState {
                begun: script.begun,
                speed: script.speed,
                peak: script.peak,
                collapse: script.collapse.clone(),
                ends,
            },
            analysis: *world.resource::<Analysis>(),
            reference: world.resource::<Measures>().reference,
            observation: observation.clone(),
            ruptures: *world.resource::<RuptureCount>(),
            bonds_created: world.resource::<Identities>().next().bond,
            ledger: world.get_resource::<EnergyLedger>().cloned(),
            contacts: world.resource::<ContactHistory>().clone(),
            solver: solver.to_vec(),
            materials: world.resource::<Materials>().0.iter().map(|m| m.name.clone()).collect(),
            particles,
            walls,
            bonds,
        }
    }
}

fn particles(world: &mut World) -> Vec<ParticleState> {
    let mut query = world.query::<(
        (&BodyId, &Particle, &MaterialIndex),
        (&Position, &Origin, &Rotation, &Velocity, &AngularVelocity, &LastMotion),
        (&Drives, &LoadControl, &AppliedLoad, &ExternalForce),
        (Option<&Group>, Option<&Probe>, Has<Swinging>),
    )>();
    let state = |(body, motion, loads, names): (
        (&BodyId, &Particle, &MaterialIndex),
        (&Position, &Origin, &Rotation, &Velocity, &AngularVelocity, &LastMotion),
        (&Drives, &LoadControl, &AppliedLoad, &ExternalForce),
        (Option<&Group>, Option<&Probe>, bool),
    )| ParticleState {
        id: *body.0,
        particle: *body.1,
        material: *body.2,
        position: *motion.0,
        origin: *motion.1,
        rotation: *motion.2,
        velocity: *motion.3,
        angular_velocity: *motion.4,
        last_motion: *motion.5,
        drives: *loads.0,
        load_control: *loads.1,
        applied_load: *loads.2,
        external_force: *loads.3,
        swinging: names.2,
        group: names.0.cloned(),
        probe: names.1.cloned(),
    };
    let mut particles: Vec<_> = query.iter(world).map(state).collect();
    particles.sort_unstable_by_key(|p| p.id);
    particles
}

fn walls(world: &mut World) -> Vec<WallState> {
    let mut query = world.query::<(
        (&BodyId, &Wall, &ContactLaw),
        (&Position, &Origin, &LastMotion),
        (&WallControl, &WallDrive, &ExternalForce),
        (Option<&WallName>, Option<&Probe>),
    )>();
    let state = |(body, motion, control, names): (
        (&BodyId, &Wall, &ContactLaw),
        (&Position, &Origin, &LastMotion),
        (&WallControl, &WallDrive, &ExternalForce),
        (Option<&WallName>, Option<&Probe>),
    )| WallState {
        id: *body.0,
        wall: *body.1,
        law: *body.2,
        position: *motion.0,
        origin: *motion.1,
        last_motion: *motion.2,
        control: control_state(world, control.0),
        drive: *control.1,
        external_force: *control.2,
        name: names.0.cloned(),
        probe: names.1.cloned(),
    };
    let mut walls: Vec<_> = query.iter(world).map(state).collect();
    walls.sort_unstable_by_key(|w| w.id);
    walls
}

fn control_state(world: &World, control: &WallControl) -> ControlState {
    let id = |wall: Entity| world.get::<BodyId>(wall).copied();
    match *control {
        WallControl::Fixed => ControlState::Fixed,
        WallControl::Displacement(u) => ControlState::Displacement(u),
        WallControl::Velocity(v) => ControlState::Velocity(v),
        WallControl::Force { from, to } => ControlState::Force(from, to),
        WallControl::Stress { from, to, length } => {
            let length = match length {
                LoadedLength::Segment => LengthState::Segment,
                LoadedLength::Between(a, b) => LengthState::Between(id(a), id(b)),
            };
            ControlState::Stress(from, to, length)
        }
        WallControl::Custom => ControlState::Custom,
    }
}
