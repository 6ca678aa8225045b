//! Larger specimens from stored ones: tiles, every other one mirrored, so that the disks that
//! touch the edge of a tile touch their mirror images, and the packing has no seams.

use clastic::scene::{StoredParticle, StoredSpecimen};

/// A specimen in the box from the origin to (`width`, `height`), m.
#[derive(Clone, Debug)]
pub struct Boxed {
    /// The particles.
    pub specimen: StoredSpecimen,
    /// Width of the box, m.
    pub width: f64,
    /// Height of the box, m.
    pub height: f64,
}

impl Boxed {
    /// `columns` times `rows` tiles, row by row from below.
    #[must_use]
    pub fn tiled(&self, columns: u32, rows: u32) -> Self {
        let place = |x: f64, tile: u32, size: f64| {
            let inside = if tile % 2 == 1 { size - x } else { x };
            f64::from(tile) * size + inside
        };
        let tiles = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
        let particles = tiles.flat_map(|(column, row)| {
            self.specimen.rows.iter().map(move |p| StoredParticle {
                x: place(p.x, column, self.width),
                y: place(p.y, row, self.height),
                ..p.clone()
            })
        });
        Self {
            specimen: StoredSpecimen::of(particles.collect()),
            width: f64::from(columns) * self.width,
            height: f64::from(rows) * self.height,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_touch_their_mirror_images() {
        let disk = |x, y| StoredParticle { x, y, r: 1.0, material: None };
        let one = Boxed {
            specimen: StoredSpecimen::of(vec![disk(1.0, 1.0), disk(3.0, 2.0)]),
            width: 4.0,
            height: 3.0,
        };
        let four = one.tiled(2, 2);
        assert_eq!((four.width, four.height), (8.0, 6.0));
        let places: Vec<_> = four.specimen.rows.iter().map(|p| (p.x, p.y)).collect();
        assert_eq!(
            places,
            [(1., 1.), (3., 2.), (7., 1.), (5., 2.), (1., 5.), (3., 4.), (7., 5.), (5., 4.)]
        );
    }
}
