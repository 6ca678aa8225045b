//! Flexible membranes, which press on the outer grains of a specimen.

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::body::{BodyId, Ramp};
use crate::increment::ClasticProgress;

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
    pub fn ramp(&self, progress: &ClasticProgress) -> Ramp {
        progress.ramp(self.pressure.0, self.pressure.1)
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
    /// Area that the chains enclose, together with the two walls if they are open, m^2. The chains
    /// run through the centres of the grains, where the pressure acts, so that its work is the
    /// pressure times the change of this area. `None` if only one side is covered.
    pub fn area(&self) -> Option<f64> {
        self.area_within(self.chains.iter().flat_map(|chain| &chain.points).copied().collect())
    }

    /// Area within the outer points of the chains ([`Chain::outer_points`]), m^2: the area of the
    /// specimen with its outermost grains. `None` if only one side is covered.
    pub fn outer_area(&self) -> Option<f64> {
        self.area_within(self.chains.iter().flat_map(Chain::outer_points).collect())
    }

    /// Area within these points of the chains in order, m^2, positive anticlockwise. `None` unless
    /// the chains enclose the specimen, alone or with two walls.
    fn area_within(&self, points: Vec<DVec2>) -> Option<f64> {
        let is_around = match self.chains.as_slice() {
            [one] => one.closed,
            [_, _] => true,
            _ => false,
        };
        let first = *points.first().filter(|_| is_around)?;
        let next = points[1..].iter().chain([&first]);
        // Relative to the first point, which keeps digits where the origin is far away.
        Some(points.iter().zip(next).map(|(a, b)| 0.5 * (*a - first).perp_dot(*b - first)).sum())
    }

    /// Mean width, m: area over the distance of the two walls. `None` unless both sides are
    /// covered.
    pub fn width(&self) -> Option<f64> {
        self.area().filter(|_| self.height > 0.0).map(|area| area / self.height)
    }

    /// Mean width with the outermost grains, m: outer area over the distance of the two walls.
    /// `None` unless both sides are covered.
    pub fn outer_width(&self) -> Option<f64> {
        self.outer_area().filter(|_| self.height > 0.0).map(|area| area / self.height)
    }

    /// Distance between the feet of the two chains on one of the two walls, m. `None` unless both
    /// sides are covered, and for any other body.
    pub fn base(&self, wall: BodyId) -> Option<f64> {
        let [one, other] = self.chains.as_slice() else { return None };
        let foot = |chain: &Chain| {
            let at = [0, chain.bodies.len().checked_sub(1)?];
            at.into_iter().find(|i| chain.bodies[*i] == wall).map(|i| chain.points[i])
        };
        Some(foot(one)?.distance(foot(other)?))
    }

    /// Unit vector along the first wall, in either direction. `None` if the membrane is closed.
    pub fn along(&self) -> Option<DVec2> {
        let chain = self.chains.first().filter(|chain| !chain.closed)?;
        let [foot, grain, ..] = chain.points.as_slice() else { return None };
        (*grain - *foot).try_normalize().map(DVec2::perp)
    }

    /// Test whether a particle, given its identity and its centre, belongs to the specimen: it is a
    /// grain of the chains, or its centre lies within them.
    pub fn holds(&self) -> impl Fn(BodyId, DVec2) -> bool + use<> {
        let grains = self.ids();
        let points: Vec<DVec2> =
            self.chains.iter().flat_map(|chain| &chain.points).copied().collect();
        move |id, x| {
            if grains.binary_search(&id).is_ok() {
                return true;
            }
            // Around a point within, the boundary winds once.
            let crosses = |a: DVec2, b: DVec2| {
                let side = (b - a).perp_dot(x - a);
                let (up, down) = (a.y <= x.y && b.y > x.y, a.y > x.y && b.y <= x.y);
                i32::from(up && side > 0.0) - i32::from(down && side < 0.0)
            };
            let next = points.iter().skip(1).chain(points.first());
            points.iter().zip(next).map(|(a, b)| crosses(*a, *b)).sum::<i32>() != 0
        }
    }

    /// Number of grains in the chains. A grain that a chain passes twice counts once.
    pub fn grains(&self) -> usize {
        self.ids().len()
    }

    /// Identities of the grains in the chains, in order.
    fn ids(&self) -> Vec<BodyId> {
        let mut ids: Vec<BodyId> = self.chains.iter().flat_map(Chain::grains).copied().collect();
        ids.sort_unstable();
        ids.dedup();
        ids
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
    /// Radii of the grains, m; 0 for a wall.
    pub radii: Vec<f64>,
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
    pub fn shares(&self, a: usize, b: usize) -> [f64; 2] {
        let is_wall = |end: usize| !self.closed && (end == 0 || end + 1 == self.points.len());
        match (is_wall(a), is_wall(b)) {
            (true, false) => [0.0, 1.0],
            (false, true) => [1.0, 0.0],
            _ => [0.5, 0.5],
        }
    }

    /// The outer points. The resultant of the pressure on a grain meets its surface a radius from
    /// the centre: there is the outer point of the grain, or at its centre if no force acts on it.
    /// That of a wall is the foot of the perpendicular from the outer point beside it.
    pub fn outer_points(&self) -> Vec<DVec2> {
        let mut ways = vec![DVec2::ZERO; self.points.len()];
        for (a, b) in self.links() {
            let way = self.points[b] - self.points[a];
            let [on_a, on_b] = self.shares(a, b);
            ways[a] += on_a * way;
            ways[b] += on_b * way;
        }
        let outer = |((point, way), radius): ((&DVec2, &DVec2), &f64)| {
            // The specimen is on the left of the way.
            *point - way.normalize_or_zero().perp() * *radius
        };
        let mut points: Vec<DVec2> =
            self.points.iter().zip(&ways).zip(&self.radii).map(outer).collect();
        let n = points.len();
        if !self.closed && n > 2 {
            for (wall, next) in [(0, 1), (n - 1, n - 2)] {
                let normal = (self.points[next] - self.points[wall]).normalize_or_zero();
                let height = (points[next] - self.points[wall]).dot(normal);
                points[wall] = points[next] - normal * height;
            }
        }
        points
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
        let points: Vec<DVec2> = points.iter().map(|x| DVec2::from(*x)).collect();
        let mut radii = vec![0.5; points.len()];
        if let ([first, .., last], false) = (radii.as_mut_slice(), closed) {
            (*first, *last) = (0.0, 0.0);
        }
        Chain { bodies, points, radii, closed }
    }

    /// Ten disks of radius 0.5: two columns of five between walls at 0 and 5.
    #[test]
    fn outer_points_lie_a_radius_from_the_centres_on_the_side_of_the_pressure() {
        let column = |x: f64| (0..5).map(move |k| (x, 0.5 + f64::from(k)));
        let right: Vec<_> =
            [(1.0, 0.0)].into_iter().chain(column(1.0)).chain([(1.0, 5.0)]).collect();
        let mut left: Vec<_> =
            [(0.0, 0.0)].into_iter().chain(column(0.0)).chain([(0.0, 5.0)]).collect();
        left.reverse();
        let mut chains = vec![chain(&right, false), chain(&left, false)];
        // Walls 100 and 101; the grains of the chains have other identities.
        for (chain, ends) in chains.iter_mut().zip([[100, 101], [101, 100]]) {
            let n = chain.bodies.len();
            (chain.bodies[0], chain.bodies[n - 1]) = (BodyId(ends[0]), BodyId(ends[1]));
        }
        let shape = MembraneShape { chains, height: 5.0, pressure: 0.0 };
        assert_eq!((shape.area(), shape.width()), (Some(5.0), Some(1.0)));
        assert_eq!((shape.outer_area(), shape.outer_width()), (Some(10.0), Some(2.0)));
        assert_eq!((shape.base(BodyId(100)), shape.base(BodyId(101))), (Some(1.0), Some(1.0)));
        assert_eq!((shape.base(BodyId(2)), shape.along().map(DVec2::abs)), (None, Some(DVec2::X)));
        // The identity of a grain of the chain, a centre within, and one without.
        let holds = shape.holds();
        assert!(holds(BodyId(1), DVec2::new(9.0, 9.0)));
        assert!(holds(BodyId(50), DVec2::new(0.5, 2.0)));
        assert!(!holds(BodyId(50), DVec2::new(1.4, 2.0)));
    }

    /// The outer points of a ring lie on the circle that is a radius larger.
    #[test]
    fn outer_points_of_a_ring_are_a_ring() {
        let n = 10;
        let turn = std::f64::consts::TAU / f64::from(n);
        let place = |k: i32| (3.0 * (turn * f64::from(k)).cos(), 3.0 * (turn * f64::from(k)).sin());
        let ring: Vec<_> = (0..n).map(place).collect();
        let shape = MembraneShape { chains: vec![chain(&ring, true)], ..Default::default() };
        let expected = 0.5 * f64::from(n) * turn.sin() * 3.5 * 3.5;
        assert!((shape.outer_area().unwrap() - expected).abs() < 1e-12 * expected);
        assert_eq!(shape.along(), None);
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
}
