//! Selects the bodies that are eliminated and divides them into patches.

use super::super::scaled::Scaled;
use super::super::settings::LocalSettings;
use crate::adjacency::Adjacency;

/// Whether a body is treated as a wall: it has more than `max_interactions` interactions. A wall
/// touches bodies everywhere and would join all patches to one, so that it is held.
pub fn is_wall(adjacency: &Adjacency, settings: &LocalSettings, body: usize) -> bool {
    adjacency.of(body).len() > settings.max_interactions
}

/// Finds patches: bodies that are joined by interactions and are solved for together.
pub struct Patches<'a> {
    program: &'a Scaled,
    adjacency: &'a Adjacency,
    settings: &'a LocalSettings,
}

impl<'a> Patches<'a> {
    pub fn new(program: &'a Scaled, adjacency: &'a Adjacency, settings: &'a LocalSettings) -> Self {
        Self { program, adjacency, settings }
    }

    /// The patches around the seeds, each with its bodies in ascending order.
    pub fn grow(&self, is_seed: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
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
        // A patch moves with the cell held.
        self.program.free[i].contains(&true)
            && !is_wall(self.adjacency, self.settings, i)
            && !self.program.images.is_cell(i)
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
}

#[cfg(test)]
mod tests {
    use super::super::super::samples::column;
    use super::*;

    /// A column of nine bodies on body 0, which is held, with a seed in its middle.
    fn patches(change: impl Fn(&mut LocalSettings)) -> Vec<Vec<usize>> {
        let program = column(9, 0.1);
        let natural: Vec<usize> = (0..10).collect();
        let scaled = Scaled::new(&program, &natural);
        let adjacency = Adjacency::new(10, scaled.locals.iter().map(|l| l.bodies));
        let mut settings = LocalSettings::default();
        change(&mut settings);
        Patches::new(&scaled, &adjacency, &settings).grow(|i| i == 5)
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
