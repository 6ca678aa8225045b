//! Selects the bodies that are eliminated, divides them into patches of bodies that are joined by
//! interactions, and balances each with all other bodies held.

use super::super::matrix::{BodyMatrix, places};
use super::super::newton::{Goal, iterate};
use super::super::scaled::{Scaled, add_times};
use super::super::spring::Elastic;
use super::Elimination;

/// Bodies and their displacements.
pub(super) type Motion = Vec<(usize, [f64; 3])>;

impl Elimination<'_> {
    /// The patches around the seeds, each with its bodies in ascending order.
    pub(super) fn patches(&self, is_seed: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
        let n = self.program.free.len();
        let mut inside = vec![false; n];
        let mut bodies: Vec<usize> = (0..n).filter(|i| is_seed(*i) && self.is_mobile(*i)).collect();
        for i in &bodies {
            inside[*i] = true;
        }
        self.add_rings(&mut bodies, &mut inside);
        bodies.sort_unstable();
        self.components(&bodies, &inside)
    }

    fn is_mobile(&self, i: usize) -> bool {
        self.program.free[i].contains(&true) && !self.is_held(i)
    }

    /// The bodies that interactions join to body `i`.
    fn neighbours(&self, i: usize) -> impl Iterator<Item = usize> {
        let pairs =
            self.adjacency.of(i).iter().map(|k| self.program.pair(&self.program.locals[*k]));
        pairs.map(move |[a, b]| if a == i { b } else { a })
    }

    /// Adds the mobile bodies that are joined to those inside, ring by ring.
    fn add_rings(&self, bodies: &mut Vec<usize>, inside: &mut [bool]) {
        let mut first = 0;
        for _ in 0..self.settings.rings {
            let ring = first..bodies.len();
            first = ring.end;
            for at in ring {
                for j in self.neighbours(bodies[at]) {
                    if !inside[j] && self.is_mobile(j) {
                        inside[j] = true;
                        bodies.push(j);
                    }
                }
            }
        }
    }

    /// The connected components of the bodies inside, without those that are too large.
    fn components(&self, bodies: &[usize], inside: &[bool]) -> Vec<Vec<usize>> {
        let mut seen = vec![false; inside.len()];
        let mut patches = Vec::new();
        for &seed in bodies {
            if std::mem::replace(&mut seen[seed], true) {
                continue;
            }
            let mut members = vec![seed];
            let mut at = 0;
            while at < members.len() {
                for j in self.neighbours(members[at]) {
                    if inside[j] && !std::mem::replace(&mut seen[j], true) {
                        members.push(j);
                    }
                }
                at += 1;
            }
            if members.len() <= self.settings.max_bodies {
                members.sort_unstable();
                patches.push(members);
            }
        }
        patches
    }

    /// Displacements of the `members` with all others held where `start` has them; `None` if the
    /// result is not finite.
    pub(super) fn balance<S: Elastic<F>, const F: usize>(
        &self,
        members: &[usize],
        start: &[[f64; 3]],
        goal: Goal,
    ) -> Option<Motion> {
        let program = self.program;
        let mut used: Vec<usize> =
            members.iter().flat_map(|i| self.adjacency.of(*i)).copied().collect();
        used.sort_unstable();
        used.dedup();
        let joined = used.iter().flat_map(|k| program.pair(&program.locals[*k]));
        let mut bodies: Vec<usize> = joined.chain(members.iter().copied()).collect();
        bodies.sort_unstable();
        bodies.dedup();
        let number = |i: usize| bodies.binary_search(&i).unwrap_or(usize::MAX);
        let of_pair =
            |k: &usize| program.pair(&program.locals[*k]).map(|i| number(i) as u32).into();
        let pairs: Vec<(u32, u32)> = used.iter().map(of_pair).collect();
        let mut matrix = BodyMatrix::new(bodies.len(), &pairs);
        let place = places(matrix.order());
        let number = |i: usize| place[number(i)];
        let bodies: Vec<usize> = matrix.order().iter().map(|k| bodies[*k]).collect();
        let is_member = |i: usize| members.binary_search(&i).is_ok();
        let mut part = Scaled::default();
        for &i in &bodies {
            let free = if is_member(i) { program.free[i] } else { [false; 3] };
            part.free.push(free);
            part.weight.push(program.weight[i]);
            part.right.push(program.right[i]);
            part.known.push(start[i]);
        }
        let with_others_held = |&k: &usize| {
            let mut l = program.with_cell_held(&program.locals[k], start);
            let bodies = l.arms.bodies.map(|i| i as usize);
            for side in (0..2).filter(|side| !is_member(bodies[*side])) {
                let rows = std::mem::take(&mut l.arms.rows[side]);
                for (row, u) in rows.iter().zip(&start[bodies[side]]) {
                    add_times(&mut l.linear, -u, row);
                }
            }
            l.arms.bodies = bodies.map(|i| number(i) as u32);
            l
        };
        part.locals = used.iter().map(with_others_held).collect();
        let settings = &self.settings.newton;
        let result = iterate::<S, F>(&part, &mut matrix, &part.known, settings, goal, None);
        if result.iterations == 0 || !result.u.iter().flatten().all(|u| u.is_finite()) {
            return None;
        }
        Some(bodies.into_iter().zip(result.u).filter(|(i, _)| is_member(*i)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::settings::LocalSettings;
    use super::super::super::tests::column;
    use super::*;

    /// A column of nine bodies on body 0, which is held, with a seed in its middle.
    fn patches(change: impl Fn(&mut LocalSettings)) -> Vec<Vec<usize>> {
        let program = column(9, 0.1);
        let scaled = Scaled::natural(&program);
        let mut settings = LocalSettings::default();
        change(&mut settings);
        let goal = Goal { unbalance: 0.0, min_force: 0.0 };
        Elimination::new(&scaled, &settings, goal, false).patches(|i| i == 5)
    }

    #[test]
    fn a_patch_has_the_bodies_within_the_rings() {
        assert_eq!(patches(|_| {}), [[3, 4, 5, 6, 7]]);
        assert_eq!(patches(|s| s.rings = 0), [[5]]);
        // The held body is in no patch.
        assert_eq!(patches(|s| s.rings = 20), [[1, 2, 3, 4, 5, 6, 7, 8, 9]]);
    }

    #[test]
    fn large_patches_and_walls_are_left_out() {
        assert_eq!(patches(|s| s.max_bodies = 5).len(), 1);
        assert_eq!(patches(|s| s.max_bodies = 4).len(), 0);
        // With two interactions every body but the last is a wall.
        assert_eq!(patches(|s| s.max_interactions = 1).len(), 0);
    }
}
