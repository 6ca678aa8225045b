//! Which interactions a body takes part in.

/// The interactions of every body, in compressed rows.
pub struct Adjacency {
    starts: Vec<usize>,
    interactions: Vec<usize>,
}

impl Adjacency {
    /// Of interactions that join these pairs of so many bodies.
    #[must_use]
    pub fn new(bodies: usize, pairs: impl Iterator<Item = [usize; 2]> + Clone) -> Self {
        let mut starts = vec![0; bodies + 1];
        for body in pairs.clone().flatten() {
            starts[body + 1] += 1;
        }
        for i in 0..bodies {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut interactions = vec![0; starts[bodies]];
        for (k, pair) in pairs.enumerate() {
            for body in pair {
                interactions[next[body]] = k;
                next[body] += 1;
            }
        }
        Self { starts, interactions }
    }

    /// Numbers of the interactions of a body, ascending.
    #[must_use]
    pub fn of(&self, body: usize) -> &[usize] {
        &self.interactions[self.starts[body]..self.starts[body + 1]]
    }
}
