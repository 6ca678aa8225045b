//! The gradual release of the forces of broken bonds.

use bevy_ecs::prelude::*;
#[cfg(feature = "reflect")]
use bevy_ecs::reflect::ReflectResource;
use serde::{Deserialize, Serialize};

use crate::body::BodyId;

/// Forces of broken bonds that still act on the ends of these bonds, with
/// [`Avalanche::Gradual`](crate::increment::Avalanche). Increments at constant load take them back
/// until none is left.
#[derive(Resource, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Release {
    /// Forces at the start of the increment.
    pub forces: Vec<BondForce>,
    /// Share of `forces` that acts at its end.
    pub kept: f64,
    /// Forces of the bonds that broke at its end, without what their contacts keep subtracted.
    pub broken: Vec<BondForce>,
    /// Share of the forces after the last rupture that still acts at the start of the increment.
    pub left: f64,
}

/// A force between the two bodies that a bond joined.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct BondForce {
    /// First body, a particle.
    pub a: BodyId,
    /// Second body.
    pub b: BodyId,
    /// (p, q, tau) as those of a contact, N, N, N m.
    pub forces: [f64; 3],
}

impl Default for Release {
    fn default() -> Self {
        Self { forces: Vec::new(), kept: 0.0, broken: Vec::new(), left: 1.0 }
    }
}

impl Release {
    /// Whether forces are left to be released in the next increment.
    #[must_use]
    pub fn goes_on(&self) -> bool {
        !self.broken.is_empty() || (self.kept > 0.0 && !self.forces.is_empty())
    }

    /// Notes the end of an increment: the share that is kept, and the bonds that broke.
    pub fn end_increment(&mut self, kept: f64, broken: Vec<BondForce>) {
        self.kept = kept;
        self.left = if broken.is_empty() { self.left * kept } else { 1.0 };
        self.broken = broken;
    }

    /// Forces at the start of the next increment: those kept of the last one, and the bonds that
    /// broke at its end. Returns the index of the first of the latter.
    pub fn begin_increment(&mut self) -> usize {
        let kept = self.kept;
        self.forces.retain(|_| kept > 0.0);
        for force in &mut self.forces {
            force.forces = force.forces.map(|f| kept * f);
        }
        let first = self.forces.len();
        self.forces.append(&mut self.broken);
        self.kept = 1.0;
        first
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn force(a: u32, p: f64) -> BondForce {
        BondForce { a: BodyId(a), b: BodyId(a + 1), forces: [p, 0.5 * p, 0.0] }
    }

    #[test]
    fn forces_shrink_together_and_new_ones_join_them() {
        let mut release = Release::default();
        assert!(!release.goes_on());
        release.end_increment(0.0, vec![force(0, -8.0)]);
        assert!(release.goes_on());
        assert_eq!((release.begin_increment(), release.forces.clone()), (0, vec![force(0, -8.0)]));
        release.end_increment(0.25, vec![force(4, 2.0)]);
        assert_eq!(release.begin_increment(), 1);
        assert_eq!(release.forces, [force(0, -2.0), force(4, 2.0)]);
        release.end_increment(0.5, Vec::new());
        assert_eq!((release.left, release.goes_on()), (0.5, true));
        release.begin_increment();
        assert_eq!(release.forces, [force(0, -1.0), force(4, 1.0)]);
        release.end_increment(0.0, Vec::new());
        assert!(!release.goes_on());
        release.begin_increment();
        assert!(release.forces.is_empty());
    }

    /// An increment that is not committed begins anew.
    #[test]
    fn beginning_twice_changes_nothing() {
        let mut release = Release::default();
        release.end_increment(0.0, vec![force(0, -8.0)]);
        release.begin_increment();
        let once = release.clone();
        assert_eq!(release.begin_increment(), 1);
        assert_eq!(release, once);
    }
}
