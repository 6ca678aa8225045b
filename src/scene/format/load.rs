//! Loading stages, and what they do to membranes and rigid groups.

use std::collections::BTreeMap;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::{
    Analysis, CellControl, CellTarget, Motion, ParticleControl, Record, Select, Sides, Stop,
    WallControl,
};

/// Factors in the course of a stage, linear between points and constant after the last. The first
/// number of a point is that of a [`WallControl::Follow`]. Without points the factor on gravity and
/// strength is 1.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Scale {
    /// Factor on the gravity of the stage.
    pub gravity: Option<Vec<(f64, f64)>>,
    /// Factor on cohesion, tensile strength and friction of all contacts and bonds.
    pub strength: Option<Vec<(f64, f64)>>,
    /// Factor f of all loads that the stage brings to a target: each is at
    /// `last + f (target - last)`. Without points f is the part of the increments that is done.
    pub loads: Option<Vec<(f64, f64)>>,
}

/// See [`Stage::Load`](super::Stage::Load).
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Load {
    /// Name.
    pub name: String,
    /// Number of increments.
    pub increments: u32,
    /// Analysis of this stage; that of the scene if left out.
    pub analysis: Option<Analysis>,
    /// Gravity of this stage, m/s^2; that of the scene if left out.
    pub gravity: Option<(f64, f64)>,
    /// Factors on gravity and strength over the stage.
    #[serde(default)]
    pub scale: Scale,
    /// Control of walls by name. A wall without an entry keeps its load if it is loaded, and
    /// otherwise stays where it is.
    #[serde(default)]
    pub walls: BTreeMap<String, WallControl>,
    /// Walls that are removed at the start.
    #[serde(default)]
    pub remove_walls: Vec<String>,
    /// Walls that are added at the start.
    #[serde(default)]
    pub add_walls: Vec<String>,
    /// Controls of particles. Particles that no control selects are free.
    #[serde(default)]
    pub particles: Vec<ParticleControl>,
    /// Rigid groups by name. An entry with `select` makes a group, an entry without it controls a
    /// group that exists. A group without an entry keeps its loads, and stands still along the
    /// degrees of freedom that were held or driven.
    #[serde(default)]
    pub rigid: BTreeMap<String, RigidControl>,
    /// Rigid groups that end at the start: their members move on their own.
    #[serde(default)]
    pub release: Vec<String>,
    /// Flexible membranes by name. The first entry of a name makes a membrane, later ones change its
    /// pressure. A membrane without an entry keeps its pressure.
    #[serde(default)]
    pub membranes: BTreeMap<String, MembraneControl>,
    /// Membranes that are removed at the start.
    #[serde(default)]
    pub remove_membranes: Vec<String>,
    /// Control of the periodic cell, boxed since few stages have one.
    pub cell: Option<Box<CellControl>>,
    /// Conditions that end the stage early.
    #[serde(default)]
    pub stop: Vec<Stop>,
    /// Recording.
    #[serde(default)]
    pub record: Record,
}

impl Load {
    /// Whether a load goes to a target in this stage: also the reaction of a rigid group, to 0.
    pub(crate) fn has_target(&self) -> bool {
        let loaded = |wall: &WallControl| {
            use WallControl::{Force, Lid, Stress};
            matches!(wall, Force(_) | Stress { .. } | Lid { .. })
        };
        let stressed = |cell: &CellControl| {
            cell.targets().iter().any(|(_, target)| matches!(target, Some(CellTarget::Stress(_))))
        };
        self.walls.values().any(loaded)
            || self.particles.iter().any(ParticleControl::is_load)
            || !self.rigid.is_empty()
            || !self.membranes.is_empty()
            || self.cell.as_deref().is_some_and(stressed)
    }
}

/// Control of a membrane in a stage. The first entry of a name makes the membrane.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct MembraneControl {
    /// Pressure at the end of the stage, Pa. It varies linearly.
    pub pressure: f64,
    /// The two walls between which it lies; closed around the specimen if left out. Only where it
    /// is made.
    pub between: Option<(String, String)>,
    /// Sides of the way from the first of these walls to the second; both if left out.
    pub sides: Option<Sides>,
    /// Radius of the ball that finds the outermost grains, m; the maximum radius of the particles
    /// if left out. Only where the membrane is made.
    pub ball: Option<f64>,
}

/// Control of a rigid group in a stage. The entry that has `select` or `walls` makes the group.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct RigidControl {
    /// The members, chosen at the start of the stage; left out for a group that exists.
    pub select: Option<Select>,
    /// Names of walls that are members.
    #[serde(default)]
    pub walls: Vec<String>,
    /// Pivot (x, y) at the start of the stage, m, which moves with the group; the centre of mass if
    /// left out, which a group with walls may not do.
    pub about: Option<(f64, f64)>,
    /// Motion of the centre along x.
    #[serde(default)]
    pub x: Motion,
    /// Motion of the centre along y.
    #[serde(default)]
    pub y: Motion,
    /// Rotation about the centre.
    #[serde(default)]
    pub rotation: Motion,
    /// Force (x, y) on the centre at the end of the stage, N. It varies linearly from its value at
    /// the start.
    pub force: Option<(f64, f64)>,
    /// Moment about the centre at the end of the stage, N m. It varies linearly.
    pub moment: Option<f64>,
    /// Stress on a length at the end of the stage, a force on the centre. It varies linearly.
    pub stress: Option<Traction>,
}

/// A stress on a length.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Traction {
    /// Stress (x, y), Pa: force over length and thickness.
    pub value: (f64, f64),
    /// The length, m.
    pub length: f64,
}

impl RigidControl {
    /// Whether the entry makes the group.
    pub fn makes(&self) -> bool {
        self.select.is_some() || !self.walls.is_empty()
    }

    /// Force on the centre at the end of the stage, N, for bodies of this thickness (m); `None` if
    /// the entry gives none.
    pub(crate) fn total_force(&self, thickness: f64) -> Option<(f64, f64)> {
        let force = self.force.map(DVec2::from);
        let by_stress = self.stress.map(|of| DVec2::from(of.value) * (of.length * thickness));
        force.into_iter().chain(by_stress).reduce(|a, b| a + b).map(DVec2::into)
    }

    /// Motions along x, along y, and of the rotation, with their fields and units.
    pub fn motions(&self) -> [(&'static str, Motion, &'static str); 3] {
        [("x", self.x, "m"), ("y", self.y, "m"), ("rotation", self.rotation, "rad")]
    }
}
