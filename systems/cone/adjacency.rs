//! Adjacency lists of bodies, in compressed rows.

/// A list of numbers for every body: of its interactions, or of its neighbours.
pub struct Adjacency {
    starts: Vec<usize>,
    entries: Vec<usize>,
}

impl Adjacency {
    /// The interactions of every body, ascending: interaction k joins the k-th pair of bodies.
    pub fn new(bodies: usize, pairs: impl Iterator<Item = [usize; 2]> + Clone) -> Self {
        let numbered = pairs.enumerate().flat_map(|(k, [a, b])| [(a, k), (b, k)]);
        Self::collect(bodies, numbered)
    }

    /// The neighbours of every body, ascending and each of them once.
    pub(crate) fn of_neighbours(bodies: usize, pairs: &[(u32, u32)]) -> Self {
        let pairs = pairs.iter().map(|(a, b)| (*a as usize, *b as usize));
        let mut both: Vec<_> = pairs.flat_map(|(a, b)| [(a, b), (b, a)]).collect();
        both.sort_unstable();
        both.dedup();
        Self::collect(bodies, both.into_iter())
    }

    /// Lists of the entries by body, in their order.
    pub(crate) fn collect(
        bodies: usize,
        entries: impl Iterator<Item = (usize, usize)> + Clone,
    ) -> Self {
        let mut starts = vec![0; bodies + 1];
        for (body, _) in entries.clone() {
            starts[body + 1] += 1;
        }
        for i in 0..bodies {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut out = vec![0; starts[bodies]];
        for (body, entry) in entries {
            out[next[body]] = entry;
            next[body] += 1;
        }
        Self { starts, entries: out }
    }

    /// Number of bodies.
    pub fn bodies(&self) -> usize {
        self.starts.len() - 1
    }

    /// The list of a body.
    pub fn of(&self, body: usize) -> &[usize] {
        &self.entries[self.starts[body]..self.starts[body + 1]]
    }

    /// Where the list of every body starts in [`entries`](Self::entries), and where the last ends.
    pub fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// All lists, one after the other.
    pub fn entries(&self) -> &[usize] {
        &self.entries
    }
}

#[cfg(test)]
mod tests {
    use super::Adjacency;

    /// A triangle with one pair twice, and a body that touches nothing.
    #[test]
    fn lists_of_a_triangle() {
        let pairs = [(2, 0), (0, 1), (1, 2), (0, 2)];
        let interactions = Adjacency::new(4, pairs.iter().map(|&(a, b)| [a, b]));
        let lists: Vec<_> = (0..4).map(|i| interactions.of(i).to_vec()).collect();
        assert_eq!(lists, [vec![0, 1, 3], vec![1, 2], vec![0, 2, 3], vec![]]);

        let pairs = pairs.map(|(a, b)| (a as u32, b as u32));
        let neighbours = Adjacency::of_neighbours(4, &pairs);
        let lists: Vec<_> = (0..4).map(|i| neighbours.of(i).to_vec()).collect();
        assert_eq!(lists, [vec![1, 2], vec![0, 2], vec![0, 1], vec![]]);
        assert_eq!(neighbours.starts(), [0, 2, 4, 6, 6]);
        assert_eq!(neighbours.entries(), [1, 2, 0, 2, 0, 1]);
        assert_eq!(neighbours.bodies(), 4);
    }
}
