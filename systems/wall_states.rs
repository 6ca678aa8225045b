//! Controls of walls as stored in a state, which names other walls by identity instead of entity.

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use clastic_components::body::BodyId;
use clastic_components::wall::{LoadedLength, TableOf, WallControl};

use crate::identities::IdentityTable;
use crate::state::StateOf;

/// Name of [`ControlStates`] in a state.
pub const WALL_CONTROL: &str = "wall_control";

/// The controls of all walls, by identity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControlStates(pub Vec<(BodyId, ControlState)>);

/// A [`WallControl`] that names walls by identity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum ControlState {
    /// Does not move.
    Fixed,
    /// Displacement in every increment, m.
    Displacement(DVec2),
    /// Velocity, m/s.
    Velocity(DVec2),
    /// Force from and to, N.
    Force(f64, f64),
    /// Stress from and to, Pa.
    Stress(f64, f64, LengthState),
    /// Another system sets the drive.
    Custom,
    /// Displacement from a table.
    DisplacementTable,
    /// Force from a table.
    ForceTable,
    /// Stress from a table.
    StressTable(LengthState),
    /// Rotation about a point in every increment, rad.
    Rotation(DVec2, f64),
    /// Angular velocity about a point, rad/s.
    Spin(DVec2, f64),
    /// Angle about a point from a table.
    RotationTable(DVec2),
}

/// A [`LoadedLength`] that names walls by identity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum LengthState {
    /// The wall's own segment.
    Segment,
    /// Distance between two walls. `None` means that the wall was removed.
    Between(Option<BodyId>, Option<BodyId>),
}

impl ControlState {
    /// Whether the load on the wall changes over the stage.
    #[must_use]
    pub fn is_ramp(&self) -> bool {
        match self {
            Self::Force(from, to) | Self::Stress(from, to, _) => from != to,
            Self::DisplacementTable | Self::ForceTable => true,
            Self::StressTable(_) | Self::RotationTable(_) => true,
            _ => false,
        }
    }

    fn of(world: &World, control: &WallControl) -> Self {
        let id = |wall: Entity| world.get::<BodyId>(wall).copied();
        let of = |length: LoadedLength| match length {
            LoadedLength::Segment => LengthState::Segment,
            LoadedLength::Between(a, b) => LengthState::Between(id(a), id(b)),
        };
        match *control {
            WallControl::Fixed => Self::Fixed,
            WallControl::Displacement(u) => Self::Displacement(u),
            WallControl::Velocity(v) => Self::Velocity(v),
            WallControl::Force { from, to } => Self::Force(from, to),
            WallControl::Stress { from, to, length } => Self::Stress(from, to, of(length)),
            WallControl::Custom => Self::Custom,
            WallControl::Rotation { about, angle } => Self::Rotation(about, angle),
            WallControl::Spin { about, rate } => Self::Spin(about, rate),
            WallControl::Table(TableOf::Displacement) => Self::DisplacementTable,
            WallControl::Table(TableOf::Force) => Self::ForceTable,
            WallControl::Table(TableOf::Rotation(about)) => Self::RotationTable(about),
            WallControl::Table(TableOf::Stress(length)) => Self::StressTable(of(length)),
        }
    }

    fn control(self, identities: &IdentityTable) -> WallControl {
        let wall = |id: Option<BodyId>| {
            id.and_then(|id| identities.body(id)).unwrap_or(Entity::PLACEHOLDER)
        };
        let of = |length: LengthState| match length {
            LengthState::Segment => LoadedLength::Segment,
            LengthState::Between(a, b) => LoadedLength::Between(wall(a), wall(b)),
        };
        match self {
            Self::Fixed => WallControl::Fixed,
            Self::Displacement(u) => WallControl::Displacement(u),
            Self::Velocity(v) => WallControl::Velocity(v),
            Self::Force(from, to) => WallControl::Force { from, to },
            Self::Stress(from, to, length) => WallControl::Stress { from, to, length: of(length) },
            Self::Custom => WallControl::Custom,
            Self::Rotation(about, angle) => WallControl::Rotation { about, angle },
            Self::Spin(about, rate) => WallControl::Spin { about, rate },
            Self::DisplacementTable => WallControl::Table(TableOf::Displacement),
            Self::ForceTable => WallControl::Table(TableOf::Force),
            Self::RotationTable(about) => WallControl::Table(TableOf::Rotation(about)),
            Self::StressTable(length) => WallControl::Table(TableOf::Stress(of(length))),
        }
    }
}

impl StateOf for ControlStates {
    fn take(world: &mut World) -> Option<Self> {
        let mut query = world.query::<(&BodyId, &WallControl)>();
        let state =
            |(id, control): (&BodyId, &WallControl)| (*id, ControlState::of(world, control));
        let mut walls: Vec<_> = query.iter(world).map(state).collect();
        walls.sort_unstable_by_key(|(id, _)| *id);
        Some(Self(walls))
    }

    fn put(self, world: &mut World) {
        for (id, state) in self.0 {
            let identities = world.get_resource_or_init::<IdentityTable>();
            let Some(entity) = identities.body(id) else { continue };
            let control = state.control(&identities);
            world.entity_mut(entity).insert(control);
        }
    }
}
