//! Flexible membranes, which press on the outer grains of a specimen.

use bevy_ecs::prelude::*;
#[cfg(feature = "reflect")]
use bevy_ecs::reflect::ReflectComponent;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::body::{BodyId, Ramp};
use crate::increment::Progress;

/// A flexible membrane without weight or stiffness: a pressure on the chains of the outermost
/// grains, which are found anew for every trial. It is an entity of its own and no body.
#[derive(Component, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
#[require(MembraneShape)]
pub struct Membrane {
    /// Name.
    pub name: String,
    /// Pressure at the start and at the end of the stage, Pa, at least 0. It varies linearly.
    pub pressure: (f64, f64),
    /// Where it lies.
    pub course: Course,
    /// Radius of the ball that finds the outermost grains, m. Without it, the maximum radius of
    /// the particles.
    pub ball: Option<f64>,
}

impl Membrane {
    /// Pressure over the next whole increment, Pa.
    #[must_use]
    pub fn ramp(&self, progress: &Progress) -> Ramp {
        progress.ramp(self.pressure.0, self.pressure.1)
    }

    /// Changes the target at the end of the stage. The pressure continues from the value that it
    /// has reached.
    pub fn retarget(&mut self, progress: &Progress, target: f64) {
        let now = self.ramp(progress).from;
        // The ramp over the whole stage that has the present value now.
        let left = 1.0 - progress.done / progress.total;
        let from = if left > 0.0 { target + (now - target) / left } else { target };
        self.pressure = (from, target);
    }
}

/// Where a membrane lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Course {
    /// Closed around the specimen.
    Closed,
    /// From a wall to the wall opposite. Both are straight.
    Between {
        /// The first wall.
        first: BodyId,
        /// The wall opposite.
        second: BodyId,
        /// The side or sides of the specimen that it covers.
        sides: Sides,
    },
}

/// Sides of the way from the first wall of a membrane to the second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Sides {
    /// Left and right.
    #[default]
    Both,
    /// Left.
    Left,
    /// Right.
    Right,
}

/// The chains of a [`Membrane`] at the start of the trial, and after a committed increment at its
/// end.
#[derive(Component, Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct MembraneShape {
    /// The chains, with the specimen on the left. Of two, the first goes from the first wall to the
    /// second on the right, and the other one back.
    pub chains: Vec<Chain>,
    /// Distance of the two walls, m; 0 if the membrane is closed.
    pub height: f64,
    /// Pressure of the trial, Pa.
    pub pressure: f64,
}

impl MembraneShape {
    /// Area that the chains enclose, together with the two walls if they are open, m^2. It runs
    /// through the centres of the grains. `None` if only one side is covered.
    #[must_use]
    pub fn area(&self) -> Option<f64> {
        let is_closed = match self.chains.as_slice() {
            [one] => one.closed,
            [_, _] => true,
            _ => false,
        };
        let points: Vec<DVec2> =
            self.chains.iter().flat_map(|chain| &chain.points).copied().collect();
        let first = *points.first().filter(|_| is_closed)?;
        let next = points[1..].iter().chain([&first]);
        // Relative to the first point, which keeps digits where the origin is far away.
        Some(points.iter().zip(next).map(|(a, b)| 0.5 * (*a - first).perp_dot(*b - first)).sum())
    }

    /// Mean width, m: area over the distance of the two walls. `None` unless both sides are
    /// covered.
    #[must_use]
    pub fn width(&self) -> Option<f64> {
        self.area().filter(|_| self.height > 0.0).map(|area| area / self.height)
    }

    /// Number of grains in the chains. A grain that a chain passes twice counts once.
    #[must_use]
    pub fn grains(&self) -> usize {
        let mut ids: Vec<BodyId> = self.chains.iter().flat_map(Chain::grains).copied().collect();
        ids.sort_unstable();
        ids.dedup();
        ids.len()
    }

    /// The links of all chains, from point to point, m.
    pub fn links(&self) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        self.chains
            .iter()
            .flat_map(|chain| chain.links().map(|(i, j)| [chain.points[i], chain.points[j]]))
    }
}

/// A chain of neighbouring grains with the specimen on its left.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Chain {
    /// Bodies in order. An open chain begins and ends with a wall.
    pub bodies: Vec<BodyId>,
    /// Centres of the grains, and the feet of the perpendiculars from the outer grains to the
    /// walls, m.
    pub points: Vec<DVec2>,
    /// Whether the last grain is followed by the first.
    pub closed: bool,
}

impl Chain {
    /// Links as pairs of indices of [`points`](Self::points).
    pub fn links(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let n = self.points.len();
        let count = if self.closed { n } else { n.saturating_sub(1) };
        (0..count).map(move |i| (i, (i + 1) % n))
    }

    /// Shares of the force of a link (a, b) that act on its two ends: half each. A wall takes
    /// nothing, and the grain beside it all.
    #[must_use]
    pub fn shares(&self, a: usize, b: usize) -> [f64; 2] {
        let is_wall = |end: usize| !self.closed && (end == 0 || end + 1 == self.points.len());
        match (is_wall(a), is_wall(b)) {
            (true, false) => [0.0, 1.0],
            (false, true) => [1.0, 0.0],
            _ => [0.5, 0.5],
        }
    }

    /// The grains of the chain.
    fn grains(&self) -> &[BodyId] {
        let n = self.bodies.len();
        if self.closed || n < 2 { &self.bodies } else { &self.bodies[1..n - 1] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(points: &[(f64, f64)], closed: bool) -> Chain {
        let bodies = (0..points.len() as u32).map(BodyId).collect();
        Chain { bodies, points: points.iter().map(|x| DVec2::from(*x)).collect(), closed }
    }

    #[test]
    fn area_and_width_are_those_of_the_polygon() {
        let right = chain(&[(3.0, 0.0), (3.5, 1.0), (3.0, 2.0)], false);
        let left = chain(&[(0.0, 2.0), (0.5, 1.0), (0.0, 0.0)], false);
        let both = MembraneShape { chains: vec![right.clone(), left], height: 2.0, pressure: 0.0 };
        assert_eq!((both.area(), both.width(), both.grains()), (Some(6.0), Some(3.0), 1));
        let one = MembraneShape { chains: vec![right], height: 2.0, pressure: 0.0 };
        assert_eq!((one.area(), one.width()), (None, None));
        let square = chain(&[(9.0, 9.0), (10.0, 9.0), (10.0, 10.0), (9.0, 10.0)], true);
        let closed = MembraneShape { chains: vec![square], ..Default::default() };
        assert_eq!((closed.area(), closed.width(), closed.grains()), (Some(1.0), None, 4));
        assert_eq!(closed.links().count(), 4);
    }

    #[test]
    fn a_new_target_is_approached_from_the_pressure_that_is_reached() {
        let mut progress = Progress { done: 5.0, total: 20.0, ..Progress::default() };
        let mut membrane = Membrane {
            name: String::new(),
            pressure: (0.0, 200.0),
            course: Course::Closed,
            ball: None,
        };
        membrane.retarget(&progress, 80.0);
        assert!((membrane.ramp(&progress).from - 50.0).abs() < 1e-12);
        progress.done = 19.0;
        assert_eq!(membrane.ramp(&progress).to, 80.0);
    }
}
