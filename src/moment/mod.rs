//! The state of a run at one moment, from its frames, as exports need it, and fields between two
//! moments.

pub mod fields;
mod frames;
pub mod mesh;
pub mod run;

use clastic_components::bond::RuptureMode;
use clastic_components::cell;
use glam::DVec2;

use crate::frames::FrameError;
use crate::output::OutputError;
use crate::output::crack::Crack;

/// Why a run has no such moment.
#[derive(Debug, thiserror::Error)]
pub enum MomentError {
    /// The run has no frame of the moment.
    #[error("{0}")]
    Absent(String),
    /// A file cannot be read or written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A frame cannot be read.
    #[error(transparent)]
    Frame(#[from] FrameError),
}

/// A disk.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Disk {
    /// Identity.
    pub id: u32,
    /// Centre, m.
    pub position: DVec2,
    /// Radius, m.
    pub radius: f64,
    /// Displacement since the start of the first run, m.
    pub displacement: DVec2,
    /// Rotation since then, rad, anticlockwise positive.
    pub rotation: f64,
    /// Velocity, m/s.
    pub velocity: DVec2,
    /// Angular velocity, rad/s.
    pub spin: f64,
    /// Index of the material.
    pub material: u32,
    /// Mean stress, components xx, yy and xy, Pa, compression positive.
    pub stress: [f64; 3],
    /// Fragment: the lowest identity of the disks that intact bonds hold together.
    pub fragment: u32,
}

/// A straight piece of a wall.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Identity of the wall.
    pub id: u32,
    /// Name; empty where it has none.
    pub name: String,
    /// Ends, m. Material is on the left of the way from the first to the second one.
    pub ends: [DVec2; 2],
    /// Whether the wall is an infinite line, which is drawn between these ends.
    pub is_line: bool,
    /// Force of the outside world on the wall: x and y in N, moment in N m.
    pub force: [f64; 3],
}

/// A pair of bodies that carries force.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// First body, a disk.
    pub a: u32,
    /// Second body, a disk or a wall.
    pub b: u32,
    /// Normal force, N, compression positive.
    pub normal_force: f64,
    /// Shear force along the normal turned by +90 degrees, N; on b from a.
    pub shear_force: f64,
    /// Rolling moment, N m.
    pub moment: f64,
    /// Unit normal from a to b.
    pub normal: DVec2,
    /// Distance less radii, m.
    pub gap: f64,
    /// The intact bond of the pair.
    pub bond: Option<u32>,
}

/// A bond that was created.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// Identity.
    pub id: u32,
    /// First body, a disk.
    pub a: u32,
    /// Second body, a disk or a wall.
    pub b: u32,
    /// Limit at which it broke; `None` while it holds.
    pub broken: Option<RuptureMode>,
}

/// The state of a run at one moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moment {
    /// Last increment.
    pub increment: u64,
    /// Name of its stage.
    pub stage: String,
    /// Time, s.
    pub time: f64,
    /// Axial strain, if the scene defines one; contraction is positive.
    pub strain: Option<f64>,
    /// Names of the materials.
    pub materials: Vec<String>,
    /// Width, height and tilt of the periodic cell, m, if there is one.
    pub cell: Option<[f64; 3]>,
    /// Disks by identity.
    pub disks: Vec<Disk>,
    /// Pieces of the walls at this moment.
    pub walls: Vec<Piece>,
    /// Pairs that carry force.
    pub pairs: Vec<Pair>,
    /// Bonds by identity.
    pub bonds: Vec<Link>,
    /// Links of the chains of the membranes, m.
    pub membranes: Vec<[DVec2; 2]>,
}

impl Moment {
    /// The disk with an identity.
    #[must_use]
    pub fn disk(&self, id: u32) -> Option<&Disk> {
        self.row(id).map(|row| &self.disks[row])
    }

    /// Row of the disk with an identity.
    #[must_use]
    pub fn row(&self, id: u32) -> Option<usize> {
        self.disks.binary_search_by_key(&id, |disk| disk.id).ok()
    }

    /// End of a line from `a` to body `b`, m: the centre of a disk, the nearest point of a wall. In
    /// a periodic cell it is the centre of the image that is nearest to `a`.
    #[must_use]
    pub fn far_end(&self, a: u32, b: u32) -> Option<DVec2> {
        match self.disk(b) {
            Some(disk) => Some(self.image(self.disk(a)?.position, disk.position)),
            None => self.foot(self.disk(a)?.position, b),
        }
    }

    /// The image of a point that is nearest to `from`, m.
    fn image(&self, from: DVec2, point: DVec2) -> DVec2 {
        point + self.cell.map_or(DVec2::ZERO, |cell| cell::shift(cell, point - from))
    }

    /// Point of a wall that is nearest to a point, m.
    fn foot(&self, point: DVec2, wall: u32) -> Option<DVec2> {
        let feet = self.walls.iter().filter(|piece| piece.id == wall).map(|piece| {
            let [start, end] = piece.ends;
            let along = end - start;
            let share = (point - start).dot(along) / along.length_squared();
            start + along * if piece.is_line { share } else { share.clamp(0.0, 1.0) }
        });
        feet.min_by(|x, y| x.distance(point).total_cmp(&y.distance(point)))
    }

    /// Broken bonds as strokes across their contacts.
    #[must_use]
    pub fn cracks(&self) -> Vec<(u32, Crack)> {
        let crack = |link: &Link| {
            let mode = link.broken?;
            let a = self.disk(link.a)?;
            let disk = (a.position, a.radius);
            let crack = match self.disk(link.b) {
                Some(b) => {
                    let place = self.image(a.position, b.position);
                    Crack::between_disks(disk, (place, b.radius), mode)
                }
                None => Crack::at_wall(disk, self.foot(a.position, link.b)?, mode),
            };
            Some((link.id, crack))
        };
        self.bonds.iter().filter_map(crack).collect()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Three disks of radius 1 in a row above a floor, the first two bonded.
    pub(crate) fn row_of_three() -> Moment {
        let disk = |id: u32| Disk {
            id,
            position: DVec2::new(2.0 * f64::from(id), 1.0),
            radius: 1.0,
            ..Default::default()
        };
        let pair = |a, b, normal| Pair {
            a,
            b,
            normal_force: 2.0,
            shear_force: 1.0,
            moment: 0.0,
            normal,
            gap: 0.0,
            bond: None,
        };
        Moment {
            disks: (0..3).map(disk).collect(),
            walls: vec![Piece {
                id: 7,
                name: "floor".to_owned(),
                ends: [DVec2::ZERO, DVec2::new(4.0, 0.0)],
                is_line: true,
                force: [0.0; 3],
            }],
            pairs: vec![pair(0, 1, DVec2::X), pair(1, 7, DVec2::NEG_Y)],
            bonds: vec![
                Link { id: 0, a: 0, b: 1, broken: None },
                Link { id: 1, a: 1, b: 2, broken: Some(RuptureMode::Shear) },
                Link { id: 2, a: 2, b: 7, broken: Some(RuptureMode::Tension) },
            ],
            ..Default::default()
        }
    }

    #[test]
    fn a_pair_across_the_side_of_a_cell_ends_at_the_near_image() {
        let mut moment = row_of_three();
        assert_eq!(moment.far_end(0, 2), Some(DVec2::new(4.0, 1.0)));
        moment.cell = Some([6.0, 3.0, 1.0]);
        assert_eq!(moment.far_end(0, 2), Some(DVec2::new(-2.0, 1.0)));
        assert_eq!(moment.far_end(2, 0), Some(DVec2::new(6.0, 1.0)));
        // One row up the images are moved by the tilt.
        moment.disks[1].position = DVec2::new(1.5, 4.0);
        assert_eq!(moment.far_end(0, 1), Some(DVec2::new(0.5, 1.0)));
    }

    #[test]
    fn cracks_lie_at_their_contacts() {
        let cracks = row_of_three().cracks();
        assert_eq!(cracks.len(), 2);
        assert_eq!(cracks[0].1.ends, [DVec2::new(3.0, 0.0), DVec2::new(3.0, 2.0)]);
        assert_eq!(cracks[1].1.ends, [DVec2::new(3.0, 0.0), DVec2::new(5.0, 0.0)]);
    }
}
