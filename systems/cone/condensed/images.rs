//! Images of bodies in a periodic cell.
//!
//! An interaction with the image of a body has three participants: body a, body b and the cell. Its
//! rows here are those of a and of the image, as if the image were a body. Images have the places
//! after all bodies. [`Images::spread`] computes their displacements from those of their bodies and
//! of the cell, and [`Images::fold`] moves the forces on them to bodies and cell. Passes over
//! interactions therefore need not know the cell. Only the matrix has the three participants
//! ([`Images::rows`]).

use glam::DVec2;

use crate::program::{ConeProgram, ProgramCell};

/// The image of a body.
#[derive(Clone, Copy, Debug)]
struct Image {
    /// Place of its body, and the free degrees of freedom there.
    of: usize,
    free: [bool; 3],
    /// Shift over the length of the cell.
    shift: DVec2,
}

/// The images of a program, one for every interaction with an image; empty without a cell.
#[derive(Clone, Debug, Default)]
pub struct Images {
    list: Vec<Image>,
    /// Number of the image by interaction; empty without images.
    of_interaction: Vec<Option<u32>>,
    /// Number of bodies: the first image has this place.
    bodies: usize,
    /// Place of the cell, and its axis.
    cell: usize,
    axis: DVec2,
    law: ProgramCell,
    /// Free degrees of freedom of the cell.
    of_cell: [bool; 3],
}

/// The pairs of bodies of a program whose blocks the matrix has: one of every interaction, then two
/// of every interaction with an image, of its bodies with the cell.
pub fn pairs(program: &ConeProgram) -> impl Iterator<Item = (u32, u32)> + Clone + '_ {
    let own = program.interactions.iter().map(|c| (c.a, c.b));
    let with_cell = program.cell.iter().flat_map(|cell| {
        let across = program.interactions.iter().filter(|c| c.is_across());
        across.flat_map(|c| [(c.a, cell.body), (c.b, cell.body)])
    });
    own.chain(with_cell)
}

impl Images {
    /// The images of a program whose bodies have these places; `free` are the free degrees of
    /// freedom by place.
    pub fn of(program: &ConeProgram, place: &[usize], free: &[[bool; 3]]) -> Self {
        let Some(law) = program.cell else { return Self::default() };
        let (mut list, mut of_interaction) = (Vec::new(), Vec::new());
        let interactions = program.interactions.iter().enumerate();
        for (number, c) in interactions.filter(|(_, c)| c.is_across()) {
            of_interaction.resize(program.interactions.len(), None);
            of_interaction[number] = Some(list.len() as u32);
            let of = place[c.b as usize];
            list.push(Image { of, free: free[of], shift: c.image });
        }
        let cell = place[law.body as usize];
        // The arm is a rotation times a length: in units of the scales it is a length over a
        // length.
        let law = ProgramCell { arm: law.arm / program.scales.length, ..law };
        Self {
            of_cell: free[cell],
            list,
            of_interaction,
            bodies: place.len(),
            cell,
            axis: program.bodies[law.body as usize].axis,
            law,
        }
    }

    /// Number of images.
    pub fn count(&self) -> usize {
        self.list.len()
    }

    /// Whether this is the place of the cell.
    pub(crate) fn is_cell(&self, place: usize) -> bool {
        self.bodies > 0 && place == self.cell
    }

    /// The image that takes part in an interaction, and the first of the two pairs that its bodies
    /// make with the cell.
    #[inline]
    pub fn at(&self, interaction: usize) -> Option<(usize, usize)> {
        let k = (*self.of_interaction.get(interaction)?)? as usize;
        Some((k, self.of_interaction.len() + 2 * k))
    }

    /// The body behind a place: the body of an image, or the body itself.
    #[inline]
    pub fn body(&self, place: usize) -> usize {
        self.number(place).map_or(place, |k| self.list[k].of)
    }

    /// Displacements of bodies with room for those of the images after them.
    pub fn extend(&self, u: &mut Vec<[f64; 3]>) {
        u.resize(u.len() + self.list.len(), [0.0; 3]);
        self.spread(u);
    }

    /// Displacement of image `k` by the known or the unknown displacements of the cell.
    fn by_cell(&self, k: usize, u: &[[f64; 3]], known: bool) -> DVec2 {
        let cell = &u[self.cell];
        let own: [f64; 3] =
            std::array::from_fn(|d| if self.of_cell[d] == known { 0.0 } else { cell[d] });
        let v = self.axis * own[0] + self.axis.perp() * own[1];
        self.law.shift(self.list[k].shift, [v.x, v.y, own[2]])
    }

    /// Sets the unknown displacements of the images to those that follow from the displacements of
    /// their bodies and of the cell.
    pub fn spread(&self, u: &mut [[f64; 3]]) {
        for (k, image) in self.list.iter().enumerate() {
            let shift = self.by_cell(k, u, false);
            let of = u[image.of];
            let own: [f64; 3] = std::array::from_fn(|d| if image.free[d] { of[d] } else { 0.0 });
            u[self.bodies + k] = [own[0] + shift.x, own[1] + shift.y, own[2]];
        }
    }

    /// Moves the forces on the images to the rows of their bodies and of the cell.
    pub fn fold(&self, rows: &mut [[f64; 3]]) {
        for (k, image) in self.list.iter().enumerate() {
            let force = std::mem::take(&mut rows[self.bodies + k]);
            for d in (0..3).filter(|d| image.free[*d]) {
                rows[image.of][d] += force[d];
            }
            let of_cell = self.law.rows(image.shift, self.axis, &[[force[0]], [force[1]]]);
            for d in (0..3).filter(|d| self.of_cell[*d]) {
                rows[self.cell][d] += of_cell[d][0];
            }
        }
    }

    /// The rows of the body of image `k` and of the cell, for the rows of the image.
    pub fn rows<const F: usize>(
        &self,
        k: usize,
        of: &[[f64; F]; 3],
    ) -> ([[f64; F]; 3], [[f64; F]; 3]) {
        let masked = |rows: &[[f64; F]; 3], free: &[bool; 3]| -> [[f64; F]; 3] {
            std::array::from_fn(|d| if free[d] { rows[d] } else { [0.0; F] })
        };
        let image = &self.list[k];
        let of_cell = self.law.rows(image.shift, self.axis, &[of[0], of[1]]);
        (masked(of, &image.free), masked(&of_cell, &self.of_cell))
    }

    /// The number of the image that has this place; `None` for a body.
    #[inline]
    pub fn number(&self, place: usize) -> Option<usize> {
        place.checked_sub(self.bodies).filter(|k| *k < self.list.len())
    }

    /// The kinematics that the known or the unknown displacements of the cell give image `k` with
    /// these rows.
    pub(crate) fn kinematics_by_cell(
        &self,
        k: usize,
        u: &[[f64; 3]],
        known: bool,
        rows: &[[f64; 3]; 3],
    ) -> [f64; 3] {
        let shift = self.by_cell(k, u, known);
        std::array::from_fn(|f| rows[0][f] * shift.x + rows[1][f] * shift.y)
    }
}
