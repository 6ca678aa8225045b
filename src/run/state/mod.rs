//! The state of a run as plain data: all that the next increment depends on and that does not
//! follow from the scene.
//!
//! [`WorldState::capture`] reads it from a world, [`restore`](WorldState::restore) makes a world of
//! it that goes on with the same bits. Entities have no place in it: walls and particles are named
//! by [`BodyId`]. What the next increment makes anew (contacts, program, solution) is not in it, and
//! neither are the settings of the scene, which may have been changed in between.
//!
//! A new component or resource that lives from one increment to the next gets a field here, a line
//! in `capture.rs` and one in `restore.rs`; a test knows all components and resources and fails for
//! one that nobody thought of.

mod capture;
mod restore;
#[cfg(test)]
mod tests;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use clastic_components::body::{
    AngularVelocity, AppliedLoad, BodyId, Drives, ExternalForce, Group, LastMotion, LoadControl,
    Origin, Position, Probe, Rotation, Velocity,
};
use clastic_components::bond::{Bond, BondId, BondState};
use clastic_components::contact::ContactHistory;
use clastic_components::energy::EnergyLedger;
use clastic_components::increment::{Analysis, Progress};
use clastic_components::material::ContactLaw;
use clastic_components::observation::{Observation, RuptureCount};
use clastic_components::particle::{MaterialIndex, Particle};
use clastic_components::wall::{Wall, WallDrive, WallName};

use super::stages::{Collapse, StageEnd};
use crate::scene::{StoredParticle, StoredSpecimen};

/// The state of a run between two increments.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorldState {
    /// How far the run has come.
    pub progress: Progress,
    /// Where it stands among the stages.
    pub script: ScriptState,
    /// Analysis of the stage.
    pub analysis: Analysis,
    /// Distances that strains are measured from, m: axial and lateral.
    pub reference: Option<[f64; 2]>,
    /// Record of the last increment.
    pub observation: Observation,
    /// Bonds broken so far.
    pub ruptures: RuptureCount,
    /// Bonds ever created.
    pub bonds_created: u32,
    /// Energy ledger, where one is kept.
    pub ledger: Option<EnergyLedger>,
    /// Memory of the contacts.
    pub contacts: ContactHistory,
    /// Where the solver's warm start begins, by body.
    pub solver: Vec<[f64; 3]>,
    /// Names of the materials that particles have an index of.
    pub materials: Vec<String>,
    /// Particles, by identity.
    pub particles: Vec<ParticleState>,
    /// Walls that are there, by identity.
    pub walls: Vec<WallState>,
    /// Bonds, by identity; broken ones too.
    pub bonds: Vec<(BondId, Bond, BondState)>,
}

/// What a [`Script`](super::stages::Script) remembers besides its scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScriptState {
    /// Whether the stage has begun.
    pub begun: bool,
    /// Greatest speed after the last increment of the stage, m/s.
    pub speed: Option<f64>,
    /// Axial stress of the greatest magnitude in the stage so far, Pa.
    pub peak: f64,
    /// The first collapse.
    pub collapse: Option<Collapse>,
    /// The stages so far and how they ended.
    pub ends: Vec<StageEnd>,
}

/// A particle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParticleState {
    /// Its identity.
    pub id: BodyId,
    /// Radius, mass, inertia.
    pub particle: Particle,
    /// Material.
    pub material: MaterialIndex,
    /// Centre.
    pub position: Position,
    /// Centre before the first stage.
    pub origin: Origin,
    /// Rotation since then.
    pub rotation: Rotation,
    /// Velocity.
    pub velocity: Velocity,
    /// Angular velocity.
    pub angular_velocity: AngularVelocity,
    /// Motion of the last increment.
    pub last_motion: LastMotion,
    /// Imposed motion.
    pub drives: Drives,
    /// Loads of the stage.
    pub load_control: LoadControl,
    /// Loads of the next increment.
    pub applied_load: AppliedLoad,
    /// What the outside world exerted.
    pub external_force: ExternalForce,
    /// Whether it swings about its bonds.
    pub swinging: bool,
    /// Group.
    pub group: Option<Group>,
    /// Probe.
    pub probe: Option<Probe>,
}

/// A wall.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WallState {
    /// Its identity.
    pub id: BodyId,
    /// Direction and length.
    pub wall: Wall,
    /// Name.
    pub name: Option<WallName>,
    /// Law of its contacts.
    pub law: ContactLaw,
    /// Middle.
    pub position: Position,
    /// Middle before the first stage.
    pub origin: Origin,
    /// Motion of the last increment.
    pub last_motion: LastMotion,
    /// What is wanted of it in the stage.
    pub control: ControlState,
    /// What it does in the next increment.
    pub drive: WallDrive,
    /// What the outside world exerted.
    pub external_force: ExternalForce,
    /// Probe.
    pub probe: Option<Probe>,
}

/// A [`WallControl`](clastic_components::wall::WallControl) that names walls by identity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum ControlState {
    /// It stays.
    Fixed,
    /// Displacement in every increment, m.
    Displacement(DVec2),
    /// Velocity, m/s.
    Velocity(DVec2),
    /// Force from and to, N.
    Force(f64, f64),
    /// Stress from and to, Pa.
    Stress(f64, f64, LengthState),
    /// Another system drives it.
    Custom,
}

/// A [`LoadedLength`](clastic_components::wall::LoadedLength) that names walls by identity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum LengthState {
    /// The wall's own segment.
    Segment,
    /// The distance of two walls; none is a wall that is no longer there.
    Between(Option<BodyId>, Option<BodyId>),
}

impl ControlState {
    /// Whether the load on the wall changes over the stage.
    #[must_use]
    pub fn is_ramp(&self) -> bool {
        match self {
            Self::Force(from, to) | Self::Stress(from, to, _) => from != to,
            _ => false,
        }
    }
}

impl WorldState {
    /// The particles as they were before the first stage, as a stored specimen.
    #[must_use]
    pub fn specimen(&self) -> StoredSpecimen {
        let rows = self.particles.iter().map(|p| StoredParticle {
            x: p.origin.0.x,
            y: p.origin.0.y,
            r: p.particle.radius,
            material: self.materials.get(p.material.0 as usize).cloned(),
        });
        StoredSpecimen { rows: rows.collect() }
    }

    /// Whether the stage under way has begun and is not at its end.
    #[must_use]
    pub fn is_within_stage(&self) -> bool {
        self.script.begun && !self.progress.is_over()
    }
}
