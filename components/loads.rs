//! Loads that an embedding program adds to a trial.

use bevy_ecs::prelude::*;

use crate::body::BodyId;
use crate::contact::BodyTable;

/// Load added to one degree of freedom: a force, and a stiffness that resists the displacement.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct AddedLoad {
    /// Force (N) or moment (N m).
    pub force: f64,
    /// Stiffness k >= 0 of a spring to the ground, N/m or N m/rad. The spring adds the force
    /// `-k u`.
    pub stiffness: f64,
}

/// Loads of the trial, which the systems of the `AddTrialLoads` schedule add. The outside world
/// acts with
/// `force - stiffness u` on a degree of freedom with displacement u. Contributions add up. Their
/// sum does not depend on the order in which they were added.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct TrialLoads {
    added: Vec<(BodyId, usize, AddedLoad)>,
}

impl TrialLoads {
    /// Adds a force (x, y; N) and a moment (N m) on a body. A wall under `WallDrive::Loaded` takes
    /// the component along its inward normal. Any other wall takes none.
    pub fn add(&mut self, body: BodyId, force: [f64; 3]) {
        for (k, force) in force.into_iter().enumerate() {
            self.added.push((body, k, AddedLoad { force, stiffness: 0.0 }));
        }
    }

    /// Adds a spring on degree of freedom `k` (x, y, rotation) of a particle. It acts with `force`
    /// at displacement 0 and with `force - stiffness u` at displacement u (N, N/m; N m, N m/rad).
    /// A load on an unknown body, a degree of freedom above 2, and a negative stiffness halt the
    /// world.
    pub fn add_spring(&mut self, body: BodyId, k: usize, force: f64, stiffness: f64) {
        self.added.push((body, k, AddedLoad { force, stiffness }));
    }

    /// The loads, in the order in which they were added: body, degree of freedom, load.
    pub fn iter(&self) -> impl Iterator<Item = (BodyId, usize, AddedLoad)> + '_ {
        self.added.iter().copied()
    }

    /// Removes all loads.
    pub fn clear(&mut self) {
        self.added.clear();
    }

    /// Whether no load was added.
    pub fn is_empty(&self) -> bool {
        self.added.is_empty()
    }

    /// Sums by row of `bodies` and degree of freedom. A load on a body that is not in the table
    /// has no row here; it halts the world. Contributions are sorted before they are summed, because a sum of floating-point
    /// numbers depends on its order.
    pub fn sums(&self, bodies: &BodyTable) -> Vec<[AddedLoad; 3]> {
        let mut sorted = self.added.clone();
        sorted.sort_by(|(a, k, x), (b, l, y)| {
            (a, k)
                .cmp(&(b, l))
                .then(x.force.total_cmp(&y.force))
                .then(x.stiffness.total_cmp(&y.stiffness))
        });
        let mut sums = vec![[AddedLoad::default(); 3]; bodies.ids.len()];
        for (body, k, load) in sorted {
            let row = bodies.row(body).map(|row| &mut sums[row]);
            if let Some(sum) = row.and_then(|sums| sums.get_mut(k)) {
                sum.force += load.force;
                sum.stiffness += load.stiffness;
            }
        }
        sums
    }
}
