//! The outermost disks of an assembly: those touched by a ball that rolls along its outside.
//!
//! If all disks grow by the radius of the ball, their outer boundary is the path of its centre. The
//! path consists of arcs, and the ball goes from disk to disk where arcs meet. It rolls with the
//! assembly on its left. The chain is the outer boundary of the alpha shape of Edelsbrunner,
//! Kirkpatrick and Seidel (1983), "On the shape of a set of points in the plane", IEEE Transactions
//! on Information Theory 29, 551-559, for points with radii.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec2;

/// Rotations of the ball that differ by less than this count as equal, rad: within rounding, three
/// disks touch the ball at once.
const AT_ONCE: f64 = 1e-9;
/// Minimum overlap of the ball with two disks between which it does not pass, over the distance of
/// their centres: below it the ball just fits, within rounding. Above it rotations are exact to
/// [`AT_ONCE`].
const FITS: f64 = 1e-12;

/// A straight wall, which bounds the path of the ball.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    /// A point of it, m.
    pub point: DVec2,
    /// Unit normal into the assembly.
    pub inward: DVec2,
}

impl Line {
    fn height(&self, x: DVec2) -> f64 {
        (x - self.point).dot(self.inward)
    }

    /// Foot of the perpendicular from a point, m.
    pub fn foot(&self, x: DVec2) -> DVec2 {
        x - self.inward * self.height(x)
    }
}

/// Row and column of the cell of a point.
fn cell(x: DVec2, edge: f64) -> (i64, i64) {
    ((x.y / edge).floor() as i64, (x.x / edge).floor() as i64)
}

/// A ball that rolls along disks.
pub(super) struct RollingBall<'a> {
    positions: &'a [DVec2],
    radii: &'a [f64],
    ball: f64,
    /// Edge of a cell, m: disks that the ball touches at once are at most one cell apart.
    edge: f64,
    /// Cells (row, column) with their disks, in order.
    cells: Vec<((i64, i64), usize)>,
}

/// The object that the ball meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Met {
    Disk(usize),
    First,
    Second,
    Nothing,
}

impl<'a> RollingBall<'a> {
    /// A ball of radius `ball` (m). `None`: the maximum radius of the disks.
    pub fn new(positions: &'a [DVec2], radii: &'a [f64], ball: Option<f64>) -> Self {
        let largest = radii.iter().copied().fold(0.0, f64::max);
        let ball = ball.unwrap_or(largest);
        let edge = 2.0 * (largest + ball);
        let disks = positions.iter().enumerate();
        let mut cells: Vec<_> = disks.map(|(i, x)| (cell(*x, edge), i)).collect();
        cells.sort_unstable();
        Self { positions, radii, ball, edge, cells }
    }

    /// Distance of the centre of the ball from the centre of a disk that it touches, m.
    fn reach(&self, disk: usize) -> f64 {
        self.radii[disk] + self.ball
    }

    /// The disks that the ball can touch together with a disk.
    fn neighbours(&self, disk: usize) -> impl Iterator<Item = usize> + '_ {
        let x = self.positions[disk];
        let (row, column) = cell(x, self.edge);
        let slices = (row - 1..=row + 1).map(move |row| {
            let start = self.cells.partition_point(|(cell, _)| *cell < (row, column - 1));
            let end = self.cells.partition_point(|(cell, _)| *cell <= (row, column + 1));
            &self.cells[start..end]
        });
        slices.flatten().map(|(_, disk)| *disk).filter(move |other| {
            let reach = (self.reach(disk) + self.reach(*other)) * (1.0 - FITS);
            *other != disk && x.distance_squared(self.positions[*other]) < reach * reach
        })
    }

    /// The next disk that the ball meets as it rolls on `disk` from the polar angle `angle` of its
    /// centre, with the rotation about the disk. `from` is the disk on which it came.
    fn next_disk(&self, disk: usize, from: Option<usize>, angle: f64) -> Option<(usize, f64)> {
        let (x, reach) = (self.positions[disk], self.reach(disk));
        let mut next: Option<(usize, f64)> = None;
        // Cosine of the angle at the centre of the ball between `disk` and the next one.
        let mut nearest = -1.0;
        for other in self.neighbours(disk) {
            let between = self.positions[other] - x;
            let distance = between.length();
            let beyond = self.reach(other);
            let cosine =
                (reach * reach + distance * distance - beyond * beyond) / (2.0 * reach * distance);
            // If one of two disks lies within the other, the ball cannot touch them at once.
            if !(cosine.abs() <= 1.0) {
                continue;
            }
            let mut turn = (between.to_angle() - cosine.acos() - angle).rem_euclid(TAU);
            if turn > TAU - AT_ONCE && from != Some(other) {
                turn = 0.0;
            }
            let beside =
                (reach * reach + beyond * beyond - distance * distance) / (2.0 * reach * beyond);
            // If the ball meets several disks at once, the chain takes each of them, in order
            // around the ball.
            if next.is_none_or(|(_, least)| {
                turn < least - AT_ONCE || (turn <= least + AT_ONCE && beside > nearest)
            }) {
                next = Some((other, turn));
                nearest = beside;
            }
        }
        next
    }

    /// Rotation about `disk` after which the ball touches a line.
    fn to_line(&self, disk: usize, angle: f64, line: &Line) -> Option<f64> {
        let cosine = (self.ball - line.height(self.positions[disk])) / self.reach(disk);
        // Otherwise the ball passes above the line.
        (cosine.abs() <= 1.0)
            .then(|| (line.inward.to_angle() + cosine.acos() - angle).rem_euclid(TAU))
    }

    /// The closed chain around the largest piece of the assembly, anticlockwise. A piece is a set
    /// of disks between which the ball does not pass. `None` without disks.
    pub fn around(&self) -> Option<Vec<usize>> {
        let piece = self.largest_piece();
        let lowest = |i: &usize| self.positions[*i].y - self.radii[*i];
        let start = piece.into_iter().min_by(|i, j| lowest(i).total_cmp(&lowest(j)))?;
        let (mut disk, mut from, mut angle) = (start, None, -FRAC_PI_2);
        let mut chain = Vec::new();
        while chain.len() <= self.most_links() {
            chain.push(disk);
            let next = self.next_disk(disk, from, angle);
            // The start is the lowest point. The chain is closed when the ball rolls over this
            // point again.
            let to_start = (-FRAC_PI_2 - angle).rem_euclid(TAU);
            if disk == start && chain.len() > 1 && next.is_none_or(|(_, turn)| to_start <= turn) {
                chain.pop();
                return Some(chain);
            }
            let Some((next, turn)) = next else { return Some(chain) };
            (from, angle) = (Some(disk), self.angle_on(next, disk, angle + turn));
            disk = next;
        }
        None
    }

    /// The open chain from the line `first` to the line `second`. The ball comes along `first` from
    /// the outside, on the side to which the inward normal points when it is turned clockwise.
    /// Where it comes back to `first`, the disks up to there lie outside of the chain. `None` if no
    /// chain reaches `second`.
    pub fn between(&self, first: &Line, second: &Line) -> Option<Vec<usize>> {
        let along = -first.inward.perp();
        // Where the ball on the line touches a disk as it comes from outside, largest first.
        let mut starts: Vec<(f64, usize)> = (0..self.positions.len())
            .filter_map(|i| {
                let above = first.height(self.positions[i]) - self.ball;
                let squared = self.reach(i).powi(2) - above * above;
                let beside = (self.positions[i] - first.point).dot(along);
                (squared > 0.0).then(|| (beside + squared.sqrt(), i))
            })
            .collect();
        starts.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut passed = vec![false; self.positions.len()];
        let mut limit = f64::INFINITY;
        for (place, start) in starts {
            if passed[start] || place > limit + AT_ONCE * self.ball {
                continue;
            }
            let centre = first.point + along * place + first.inward * self.ball;
            let mut angle = (centre - self.positions[start]).to_angle();
            let (mut disk, mut from) = (start, None);
            let mut chain = Vec::new();
            limit = loop {
                chain.push(disk);
                if chain.len() > self.most_links() {
                    return None;
                }
                let (met, turn) = self.meets(disk, from, angle, first, second);
                match met {
                    Met::Second => return Some(chain),
                    Met::Disk(next) => {
                        (from, angle) = (Some(disk), self.angle_on(next, disk, angle + turn));
                        disk = next;
                    }
                    Met::First => {
                        let centre = self.positions[disk]
                            + DVec2::from_angle(angle + turn) * self.reach(disk);
                        break (centre - first.point).dot(along);
                    }
                    Met::Nothing => return None,
                }
            };
            for disk in chain {
                passed[disk] = true;
            }
        }
        None
    }

    fn meets(
        &self,
        disk: usize,
        from: Option<usize>,
        angle: f64,
        first: &Line,
        second: &Line,
    ) -> (Met, f64) {
        let mut met = (Met::Nothing, f64::INFINITY);
        if let Some((next, turn)) = self.next_disk(disk, from, angle) {
            met = (Met::Disk(next), turn);
        }
        if let Some(turn) = self.to_line(disk, angle, first).filter(|turn| *turn < met.1) {
            met = (Met::First, turn);
        }
        let over = |turn: &f64| if *turn > TAU - AT_ONCE { 0.0 } else { *turn };
        let second = self.to_line(disk, angle, second).as_ref().map(over);
        match second.filter(|turn| *turn <= met.1) {
            Some(turn) => (Met::Second, turn),
            None => met,
        }
    }

    /// Polar angle on `next` of the ball that has the polar angle `angle` on `disk`.
    fn angle_on(&self, next: usize, disk: usize, angle: f64) -> f64 {
        let centre = self.positions[disk] + DVec2::from_angle(angle) * self.reach(disk);
        (centre - self.positions[next]).to_angle()
    }

    /// A disk has at most one arc between two neighbours; pairs of neighbours are a planar graph.
    fn most_links(&self) -> usize {
        6 * self.positions.len() + 6
    }

    /// The piece with the most disks; ties go to the piece with the first disk.
    fn largest_piece(&self) -> Vec<usize> {
        let mut largest = Vec::new();
        let mut seen = vec![false; self.positions.len()];
        for first in 0..self.positions.len() {
            if std::mem::replace(&mut seen[first], true) {
                continue;
            }
            let mut piece = vec![first];
            let mut done = 0;
            while let Some(disk) = piece.get(done).copied() {
                done += 1;
                for next in self.neighbours(disk) {
                    if !std::mem::replace(&mut seen[next], true) {
                        piece.push(next);
                    }
                }
            }
            if piece.len() > largest.len() {
                largest = piece;
            }
        }
        largest
    }
}

#[cfg(test)]
mod tests;
