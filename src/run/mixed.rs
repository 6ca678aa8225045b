//! Start positions in a periodic cell: a grid of disks, mixed until it has no order left.
//!
//! A cell shrinks in the same proportion along all directions and has no walls, so that a packing in it keeps
//! the order of its start. The disks move as those of a hard-disk liquid: each in turn by a random step,
//! unless it would overlap another one there (Metropolis et al. 1953, J. Chem. Phys. 21, 1087-1092).

use clastic_components::cell::PeriodicCell;
use glam::DVec2;

use super::random::Random;

/// Number of steps of each disk. Half of them leave directions of neighbours by chance where the spacing is
/// 1.2 maximum diameters and radii are spread by 1 : 1.7 or more.
const STEPS: usize = 100;
/// Maximum step along an axis, over the mean gap of the grid. A third of such steps is free.
const REACH: f64 = 1.5;

/// Moves disks at `places`, m, of these radii, m, and puts them into the cell.
pub(super) fn mix(cell: &PeriodicCell, radii: &[f64], places: &mut [DVec2], random: &mut Random) {
    let largest = radii.iter().copied().fold(0.0, f64::max);
    let count = radii.len().max(1) as f64;
    let mean = radii.iter().sum::<f64>() / count;
    let step = REACH * ((cell.area() / count).sqrt() - 2.0 * mean).max(0.0);
    // Between two places in the cell.
    let short = |way: f64, length: f64| match way {
        way if way > 0.5 * length => way - length,
        way if way < -0.5 * length => way + length,
        way => way,
    };
    let mut boxes = Boxes::of(cell, 2.0 * largest, places);
    for _ in 0..STEPS {
        for i in 0..places.len() {
            let by = DVec2::new(random.between(-step, step), random.between(-step, step));
            let to = cell.wrapped(places[i] + by);
            let is_free = |j: &u32| {
                let j = *j as usize;
                let way = places[j] - to;
                let way = DVec2::new(short(way.x, cell.width), short(way.y, cell.height));
                i == j || way.length_squared() >= (radii[i] + radii[j]).powi(2)
            };
            if boxes.around(to).all(|of_box| of_box.iter().all(is_free)) {
                boxes.change(i as u32, places[i], to);
                places[i] = to;
            }
        }
    }
}

/// Disks by the box in which their centres are. Boxes are as wide as the largest disk or wider.
struct Boxes {
    size: DVec2,
    columns: usize,
    rows: usize,
    disks: Vec<Vec<u32>>,
}

impl Boxes {
    fn of(cell: &PeriodicCell, width: f64, places: &mut [DVec2]) -> Self {
        // As many as disks are enough, however small these are.
        let most = (places.len() as f64).sqrt().max(1.0);
        let [columns, rows] =
            [cell.width, cell.height].map(|l| (l / width).min(most).max(1.0) as usize);
        let size = DVec2::new(cell.width / columns as f64, cell.height / rows as f64);
        let mut boxes = Self { size, columns, rows, disks: vec![Vec::new(); columns * rows] };
        for (i, place) in places.iter_mut().enumerate() {
            *place = cell.wrapped(*place);
            let at = boxes.index(*place);
            boxes.disks[at].push(i as u32);
        }
        boxes
    }

    fn index(&self, place: DVec2) -> usize {
        let [column, row] = [place.x / self.size.x, place.y / self.size.y].map(|x| x as usize);
        column.min(self.columns - 1) + row.min(self.rows - 1) * self.columns
    }

    /// The disks of the boxes around a place.
    fn around(&self, place: DVec2) -> impl Iterator<Item = &[u32]> {
        let at = self.index(place);
        let (column, row) = (at % self.columns, at / self.columns);
        [self.rows - 1, 0, 1].into_iter().flat_map(move |up| {
            let row = (row + up) % self.rows * self.columns;
            let columns = [self.columns - 1, 0, 1].map(|right| (column + right) % self.columns);
            columns.map(|column| self.disks[row + column].as_slice())
        })
    }

    fn change(&mut self, disk: u32, from: DVec2, to: DVec2) {
        let (from, to) = (self.index(from), self.index(to));
        if from != to {
            self.disks[from].retain(|other| *other != disk);
            self.disks[to].push(disk);
        }
    }
}
