//! Specimen of a scene from a file, with its state if it has one.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::diagnostic::SceneErrors;
use super::format::{Cell, Wall};
use crate::saved::SavedState;

/// A specimen that is stored in a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StoredSpecimen {
    /// Its particles.
    pub rows: Vec<StoredParticle>,
    /// Number of indices of particles, in use or not: more than rows where particles were taken
    /// away before the state was stored.
    pub indices: u64,
    /// Group of every particle; empty where the file has no column for it.
    pub groups: Vec<Option<String>>,
    /// What a saved state has besides.
    pub state: Option<StoredState>,
}

impl StoredSpecimen {
    /// Particles at rest and free of stress.
    pub fn of(rows: Vec<StoredParticle>) -> Self {
        Self { indices: rows.len() as u64, rows, groups: Vec::new(), state: None }
    }

    /// The state, if the scene takes its walls.
    pub(crate) fn gives_walls(&self) -> Option<&StoredState> {
        self.state.as_ref().filter(|state| state.gives_walls)
    }

    /// Whether these are the particles of a run that is resumed, which its scene has cut already.
    pub fn is_resumed(&self) -> bool {
        self.state.as_ref().is_some_and(|state| state.saved.is_none())
    }
}

/// A particle of a stored specimen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredParticle {
    /// Centre, m.
    pub x: f64,
    /// Centre, m.
    pub y: f64,
    /// Radius, m.
    pub r: f64,
    /// Material; `None` means the material of the scene's specimen.
    pub material: Option<String>,
}

/// Why a stored specimen cannot be read.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be read.
    #[error("{0}")]
    File(String),
    /// Rows of the file are wrong.
    #[error(transparent)]
    Rows(SceneErrors),
}

/// A membrane of a saved state.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoredMembrane {
    /// Name.
    pub name: String,
    /// Names of the walls between which it lies; closed around the specimen without.
    pub between: Option<(String, String)>,
}

/// What a saved state has besides its particles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StoredState {
    /// Its walls where the run begins.
    pub walls: Vec<Wall>,
    /// Whether they are the walls of the scene, which lists none.
    pub gives_walls: bool,
    /// Its membranes, which go with its walls: a scene that lists walls of its own has none of
    /// them.
    pub membranes: Vec<StoredMembrane>,
    /// Its periodic cell where the run begins.
    pub cell: Option<Cell>,
    /// Whether it is the cell of the scene, which gives none.
    pub gives_cell: bool,
    /// Names of its groups, in order.
    pub groups: Vec<String>,
    /// Names of the rigid groups that are there where the run begins.
    pub rigid: Vec<String>,
    /// Names under which its particles were recorded, by index.
    pub probes: BTreeMap<String, u32>,
    /// The state; `None` for a run that is resumed, which has a state of its own.
    pub saved: Option<Arc<SavedState>>,
}
