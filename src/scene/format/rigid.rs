//! Rigid groups in a stage.

use serde::{Deserialize, Serialize};

use super::{Motion, Select};

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
    #[must_use]
    pub fn makes(&self) -> bool {
        self.select.is_some() || !self.walls.is_empty()
    }

    /// Force on the centre at the end of the stage, N, for bodies of this thickness (m); `None` if
    /// the entry gives none.
    #[must_use]
    pub fn total_force(&self, thickness: f64) -> Option<(f64, f64)> {
        let by_stress = self.stress.map(|traction| {
            let area = traction.length * thickness;
            (traction.value.0 * area, traction.value.1 * area)
        });
        match (self.force, by_stress) {
            (Some((x, y)), Some((sx, sy))) => Some((x + sx, y + sy)),
            (force, by_stress) => force.or(by_stress),
        }
    }

    /// Motions along x, along y, and of the rotation, with their fields and units.
    #[must_use]
    pub fn motions(&self) -> [(&'static str, Motion, &'static str); 3] {
        [("x", self.x, "m"), ("y", self.y, "m"), ("rotation", self.rotation, "rad")]
    }
}
