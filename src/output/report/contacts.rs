//! Contacts without a bond in a page: one list for the frames from one whole frame to the next, so
//! that forces are differences from the preceding frame, like those of bonds. A contact that is
//! missing in a frame has no force there.

use super::columns::Columns;
use super::distinct;
use crate::frames::{FramePairs, NONE};

/// The contacts of some frames, ascending: indices of their bodies in the page, and the number of
/// the row among the rows of a frame with these bodies.
#[derive(Default)]
pub struct Contacts(Vec<(u32, u32, u32)>);

impl Contacts {
    /// Those of all these frames. `index` is the index of a body in the page.
    pub fn of<'a>(
        frames: impl Iterator<Item = &'a FramePairs>,
        index: impl Fn(u32) -> u32,
    ) -> Self {
        Self(distinct(frames.flat_map(|pairs| rows(pairs, &index)).map(|(_, key)| key)))
    }

    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Writes the bodies: the first as the difference from that of the row before, the second as
    /// that from the first.
    pub fn bodies(&self, to: &mut Columns) {
        let mut before = 0;
        let step =
            |key: &(u32, u32, u32)| key.0.wrapping_sub(std::mem::replace(&mut before, key.0));
        let first: Vec<_> = self.0.iter().map(step).collect();
        to.counts(&first);
        let second: Vec<_> = self.0.iter().map(|key| key.1.wrapping_sub(key.0)).collect();
        to.counts(&second);
    }

    /// A column of a frame, with 0 for contacts that it lacks.
    pub fn column(
        &self,
        pairs: &FramePairs,
        values: &[f32],
        index: impl Fn(u32) -> u32,
    ) -> Vec<f32> {
        let mut column = vec![0.0; self.len()];
        for (row, key) in rows(pairs, &index) {
            if let Ok(place) = self.0.binary_search(&key) {
                column[place] = values[row];
            }
        }
        column
    }
}

/// Rows of the contacts without a bond, and their keys.
fn rows<'a>(
    pairs: &'a FramePairs,
    index: &'a impl Fn(u32) -> u32,
) -> impl Iterator<Item = (usize, (u32, u32, u32))> + 'a {
    let mut last = (NONE, NONE, 0);
    (0..pairs.a.len()).filter(|row| pairs.bond[*row] == NONE).map(move |row| {
        let (a, b) = (index(pairs.a[row]), index(pairs.b[row]));
        // Rows are in the order of their bodies.
        let nth = if (last.0, last.1) == (a, b) { last.2 + 1 } else { 0 };
        last = (a, b, nth);
        (row, last)
    })
}
