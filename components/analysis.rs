//! The kind of analysis and the friction law.

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// How bodies resist motion.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum AnalysisKind {
    /// No inertia: every increment is an equilibrium.
    #[default]
    Static,
    /// Prepares packings (4.4.1 of the paper): rigid grains without friction make the smallest
    /// motion that separates them. Each has unit inertia, starts from rest, and theta is 1.
    Compaction {
        /// Whether the motion is the smallest relative to the mean motion, which is linear between
        /// the moving wall and the one opposite. Otherwise it is the smallest relative to the
        /// ground.
        affine: bool,
        /// Maximum of the random part of the reference motion, m, which shakes the packing.
        agitation: f64,
        /// Seed of the random part.
        seed: u64,
    },
    /// Theta-method with theta-averaged elastic forces.
    Dynamic {
        /// Time step, s.
        dt: f64,
        /// Weight of the end of the increment, 1/2 to 1: below 1/2 energy grows.
        theta: f64,
    },
}

impl AnalysisKind {
    /// Weight of the end of the increment: 1 where an increment has no duration.
    pub fn theta(self) -> f64 {
        match self {
            Self::Dynamic { theta, .. } => theta,
            Self::Static | Self::Compaction { .. } => 1.0,
        }
    }

    /// Theta of a time step; `None` where no time passes.
    pub fn theta_of_step(self) -> Option<f64> {
        self.dt().map(|_| self.theta())
    }

    /// Time step, s, where time passes.
    pub fn dt(self) -> Option<f64> {
        match self {
            Self::Dynamic { dt, .. } => Some(dt),
            Self::Static | Self::Compaction { .. } => None,
        }
    }
}

/// Kind of analysis, gravity and thickness.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct ClasticAnalysis {
    /// Static, compaction or dynamic.
    pub kind: AnalysisKind,
    /// Acceleration of gravity, m/s^2.
    pub gravity: DVec2,
    /// Factor on cohesion, tensile strength and friction of all contacts and bonds.
    pub strength: f64,
    /// Out-of-plane thickness h, m.
    pub thickness: f64,
    /// Theta of the path of particles where contacts have restitution; velocities and forces then
    /// have theta = 1 in [`kind`](Self::kind). `None`: particles move by the displacements of the
    /// program.
    pub path_theta: Option<f64>,
}

impl Default for ClasticAnalysis {
    fn default() -> Self {
        Self {
            kind: AnalysisKind::Static,
            gravity: DVec2::ZERO,
            strength: 1.0,
            thickness: 1.0,
            path_theta: None,
        }
    }
}

/// Friction law of contacts without strength: the paper's, convex, by which sliding opens the
/// contact by mu |slip|, or Coulomb's.
// The scene's law is another type (`friction_law`): it names combinations of the two fields.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct FrictionLaw {
    /// Coulomb's law in static increments. `None` is the associated law of the paper.
    pub in_statics: Option<Coulomb>,
    /// Coulomb's law in dynamic increments. `None` is the associated law of the paper.
    pub in_dynamics: Option<Coulomb>,
}

/// Coulomb's law: sliding and rolling do not open the contact.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Coulomb {
    /// Maximum number of factorisations of one solve. A time step that may be halved takes at most 120.
    pub factorisations: u32,
}

impl Coulomb {
    /// Default of [`factorisations`](Self::factorisations).
    pub const FACTORISATIONS: u32 = 600;
}

impl Default for Coulomb {
    fn default() -> Self {
        Self { factorisations: Self::FACTORISATIONS }
    }
}

impl FrictionLaw {
    /// Coulomb's law, if it is the law of this kind of analysis.
    pub fn coulomb(&self, kind: AnalysisKind) -> Option<Coulomb> {
        match kind {
            AnalysisKind::Static => self.in_statics,
            AnalysisKind::Dynamic { .. } => self.in_dynamics,
            // A packing is made without friction.
            AnalysisKind::Compaction { .. } => None,
        }
    }
}
