//! Frames: what is needed to draw and to analyse a specimen at one moment, as documented arrays in
//! a `.npz` file. See `docs/outputs.md` for the arrays, their precision and their signs.
//!
//! A frame is made to be looked at: most of its numbers are `float32`. A run goes on from a
//! checkpoint or a [saved state](crate::saved), not from a frame.
//!
//! ```no_run
//! use clastic::frames::{Frame, list};
//!
//! for path in list("runs/uniaxial".as_ref())? {
//!     let frame = Frame::read(&path)?;
//!     let largest = frame.pairs.p_n.iter().fold(0.0_f32, |a, b| a.max(*b));
//!     println!("increment {}: normal forces up to {largest} N", frame.increment);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod files;
pub(crate) mod mesh;
pub(crate) mod pairs;
mod strains;
mod tables;
mod take;

#[cfg(test)]
mod tests;

pub use files::{list, series};
pub use strains::{Disk, Strain, strains};
pub use take::FrameTables;

/// Stands for none in columns of identities and indices.
pub const NONE: u32 = u32::MAX;

/// Codes of the column `state` of a [pair](FramePairs), in words.
pub const STATES: [&str; 5] =
    ["contact", "bond", "broken in tension", "broken in shear", "broken in rolling"];

/// A specimen at one moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Increment of the run after which the frame was taken; 0 before the first.
    pub increment: u64,
    /// Name of its stage.
    pub stage: String,
    /// Time since the start, s.
    pub time_s: f64,
    /// Out-of-plane thickness, m.
    pub thickness_m: f64,
    /// Axial strain, if the scene defines one; contraction is positive.
    pub axial_strain: Option<f64>,
    /// Axial stress, if the scene defines one, Pa; compression is positive.
    pub axial_stress_pa: Option<f64>,
    /// Point from which the centres of bodies are measured, m.
    pub origin_m: [f64; 2],
    /// Width, height and tilt of the periodic cell, m: the specimen repeats along (width, 0) and
    /// (tilt, height). `None` without a cell.
    pub cell_m: Option<[f64; 3]>,
    /// Names of the materials.
    pub materials: Vec<String>,
    /// Names of the groups.
    pub groups: Vec<String>,
    /// The particles.
    pub bodies: FrameBodies,
    /// Contacts and bonds.
    pub pairs: FramePairs,
    /// The walls.
    pub walls: FrameWalls,
    /// The chains of the membranes.
    pub membranes: FrameMembranes,
}

/// The particles of a frame by column, in the order of identities.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameBodies {
    /// Identities.
    pub id: Vec<u32>,
    /// Centres less [`Frame::origin_m`], m.
    pub offset_m: Vec<[f32; 2]>,
    /// Radii, m.
    pub radius_m: Vec<f32>,
    /// Displacements since the start of the first run, m.
    pub displacement_m: Vec<[f32; 2]>,
    /// Rotations since the start of the first run, rad.
    pub rotation_rad: Vec<f32>,
    /// Velocities, m/s. Static stages leave them as they are.
    pub velocity_m_s: Vec<[f32; 2]>,
    /// Angular velocities, rad/s.
    pub angular_velocity_rad_s: Vec<f32>,
    /// Indices into [`Frame::materials`].
    pub material: Vec<u32>,
    /// Indices into [`Frame::groups`]; [`NONE`] without a group.
    pub group: Vec<u32>,
    /// Mean stress in the disk, components xx, yy and xy, Pa, compression positive: the sum of
    /// `r (x) f` over its contacts and bonds, over its volume, symmetric part. r goes from the
    /// contact to the centre; f is the force on the disk.
    pub stress_pa: Vec<[f32; 3]>,
    /// Fragment: the lowest identity of the particles that intact bonds hold together.
    pub fragment: Vec<u32>,
}

/// Contacts and bonds of a frame by column: every pair of bodies that carries force, or has a bond,
/// intact or broken. Ordered by bodies and bond.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FramePairs {
    /// Identities of the first bodies, which are particles.
    pub a: Vec<u32>,
    /// Identities of the second bodies, which are particles or walls.
    pub b: Vec<u32>,
    /// Identities of the bonds; [`NONE`] without one.
    pub bond: Vec<u32>,
    /// Index into [`STATES`].
    pub state: Vec<u8>,
    /// Normal forces, N, compression positive. The force on b is p n + q t, with t the normal
    /// turned by +90 degrees.
    pub p_n: Vec<f32>,
    /// Shear forces, N.
    pub q_n: Vec<f32>,
    /// Rolling moments, N m.
    pub tau_nm: Vec<f32>,
    /// Gaps, m; negative is overlap.
    pub gap_m: Vec<f32>,
    /// Direction of the unit normal n from a to b, rad: n = (cos, sin).
    pub angle_rad: Vec<f32>,
}

/// The walls of a frame by column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameWalls {
    /// Identities.
    pub id: Vec<u32>,
    /// Names, empty without one.
    pub name: Vec<String>,
    /// Whether the wall is a thin plate or arc; others have material on the left of their line.
    pub is_thin: Vec<bool>,
    /// Force x and y, N, and moment, N m, of the outside world on the wall.
    pub force: Vec<[f64; 3]>,
    /// The line of wall k consists of the points from `first_point[k]` to `first_point[k + 1]`,
    /// exclusive.
    pub first_point: Vec<u32>,
    /// Points of all lines, m.
    pub point_m: Vec<[f64; 2]>,
}

/// The chains of the membranes of a frame by column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameMembranes {
    /// Name of the membrane to which a chain belongs.
    pub name: Vec<String>,
    /// Whether the last grain of a chain is followed by the first. An open chain begins and ends
    /// with a wall.
    pub is_closed: Vec<bool>,
    /// Chain k consists of the points from `first_point[k]` to `first_point[k + 1]`, exclusive.
    pub first_point: Vec<u32>,
    /// Identity of the grain or wall of each point.
    pub body: Vec<u32>,
    /// Centres of the grains, and feet of the perpendiculars from end grains to the walls, m.
    pub point_m: Vec<[f64; 2]>,
}

impl FrameMembranes {
    /// Range of the columns that holds the points of a chain.
    pub fn points(&self, chain: usize) -> std::ops::Range<usize> {
        self.first_point[chain] as usize..self.first_point[chain + 1] as usize
    }
}

impl Frame {
    /// Centre of the particle in a row, m.
    pub fn centre(&self, row: usize) -> [f64; 2] {
        let [x, y] = self.bodies.offset_m[row];
        [self.origin_m[0] + f64::from(x), self.origin_m[1] + f64::from(y)]
    }

    /// Row of a particle; `None` if the identity is that of a wall or of nothing.
    pub fn row(&self, id: u32) -> Option<usize> {
        self.bodies.id.binary_search(&id).ok()
    }

    /// Contact point of the pair in a row, the middle of the gap, m. A bond whose first body is
    /// not in the frame has none.
    pub fn contact_point(&self, row: usize) -> Option<[f64; 2]> {
        let pairs = &self.pairs;
        let a = self.row(pairs.a[row])?;
        let angle = f64::from(pairs.angle_rad[row]);
        let arm = f64::from(self.bodies.radius_m[a]) + 0.5 * f64::from(pairs.gap_m[row]);
        let [x, y] = self.centre(a);
        Some([x + arm * angle.cos(), y + arm * angle.sin()])
    }

    /// Points of the line of a wall, m.
    pub fn wall_line(&self, wall: usize) -> &[[f64; 2]] {
        let first = &self.walls.first_point;
        &self.walls.point_m[first[wall] as usize..first[wall + 1] as usize]
    }
}
