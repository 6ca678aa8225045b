//! The program in units of its scales, interaction by interaction, as the condensed solver reads
//! it.
//!
//! Interaction c: `min 1/2 s'Cs + l's`, `A s + w = b`, `w >= 0` with s = (p, q, tau); stationarity
//! `l + C s - e(u) + A' lambda = 0`. Bodies: `m u + G s = f` on free degrees of freedom.

use crate::program::{ConeProgram, Dof, Interaction, ProgramBody};

use super::images::Images;
use super::matrix::places;

/// Maximum number of limits of an interaction: two of shear and two of rolling, which imply that of
/// tension.
pub const ROWS: usize = 4;

/// The forces and limits of an interaction. The inner loops of the solver are compiled for each
/// kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// p alone, with the limit of tension.
    Normal,
    /// p and q, with two limits of shear.
    Friction,
    /// p and q, with two limits of shear and that of tension.
    Bond,
    /// p, q and tau, with two limits of shear and two of rolling.
    Rolling,
    /// p and tau, with two limits of rolling; q is a dummy with a compliance and without load.
    Wheel,
}

/// One interaction.
#[derive(Clone, Debug)]
pub struct Local {
    /// Bodies, by their places in the order of elimination; images come after all bodies.
    pub bodies: [usize; 2],
    /// Its forces and limits.
    pub kind: Kind,
    /// Rows of the two bodies: `[body][dof][force]`, zero where the degree of freedom is fixed.
    pub rows: [[[f64; 3]; 3]; 2],
    /// Which of p, q, tau exist.
    pub has: [bool; 3],
    /// Compliances.
    pub compliance: [f64; 3],
    /// Linear terms, less the kinematics of the fixed degrees of freedom.
    pub linear: [f64; 3],
    /// Limits: coefficients.
    pub limits: [[f64; 3]; ROWS],
    /// Limits: right sides.
    pub right: [f64; ROWS],
    /// Number of limits.
    pub count: usize,
}

impl Local {
    /// An interaction from the rows of its bodies and the kinematics of their fixed degrees of
    /// freedom.
    fn new(
        Units { du, df, stiffness, length }: &Units,
        c: &Interaction,
        bodies: [usize; 2],
        rows: [[[f64; 3]; 3]; 2],
        fixed: [f64; 3],
    ) -> Self {
        let l = &c.limits;
        let has = forces_of(c);
        let kind = match (l.has_shear(), l.has_rolling()) {
            (false, false) => Kind::Normal,
            (true, false) if l.has_tension_row() => Kind::Bond,
            (true, false) => Kind::Friction,
            (true, true) => Kind::Rolling,
            (false, true) => Kind::Wheel,
        };
        let of_moment = c.rolling_compliance * df[2] / du[2];
        let mut local = Self {
            bodies,
            kind,
            rows,
            has,
            compliance: [
                c.normal_compliance * stiffness,
                if has[1] { c.tangential_compliance * stiffness } else { 1.0 },
                if has[2] { of_moment } else { 0.0 },
            ],
            linear: [
                c.offset / du[0] - fixed[0],
                // Without a shear force no force is left over from the last increment.
                if has[1] {
                    -c.tangential_compliance * stiffness * c.previous_shear / df[0] - fixed[1]
                } else {
                    0.0
                },
                if has[2] { -of_moment * c.previous_moment / df[2] - fixed[2] } else { -fixed[2] },
            ],
            limits: [[0.0; 3]; ROWS],
            right: [0.0; ROWS],
            count: 0,
        };
        if l.has_shear() {
            local.limit([-l.friction, 1.0, 0.0], l.cohesion / df[0]);
            local.limit([-l.friction, -1.0, 0.0], l.cohesion / df[0]);
        }
        if l.has_rolling() {
            local.limit([-l.rolling / length, 0.0, 1.0], l.moment / df[2]);
            local.limit([-l.rolling / length, 0.0, -1.0], l.moment / df[2]);
        }
        if l.has_tension_row() {
            local.limit([-1.0, 0.0, 0.0], l.tension / df[0]);
        }
        local
    }

    /// Adds a limit.
    fn limit(&mut self, row: [f64; 3], right: f64) {
        self.limits[self.count] = row;
        self.right[self.count] = right;
        self.count += 1;
    }
}

/// Which of p, q, tau an interaction has.
fn forces_of(c: &Interaction) -> [bool; 3] {
    [true, c.limits.has_shear(), c.limits.has_rolling()]
}

/// Units of the scaled program, by degree of freedom where they are arrays.
struct Units {
    /// Displacements.
    du: [f64; 3],
    /// Forces.
    df: [f64; 3],
    /// Stiffness.
    stiffness: f64,
    /// Length.
    length: f64,
}

impl Units {
    fn of(program: &ConeProgram) -> Self {
        let (du, df) = program.scales.units();
        let s = &program.scales;
        Self { du, df, stiffness: s.force / s.displacement, length: s.length }
    }

    /// The rows of a body in these units, for the forces that exist.
    fn rows(&self, raw: &[[f64; 3]; 3], has: [bool; 3]) -> [[f64; 3]; 3] {
        let df = &self.df;
        std::array::from_fn(|k| {
            std::array::from_fn(|f| {
                let unit = if f == 2 { df[2] } else { df[0] };
                if has[f] { raw[k][f] * unit / df[k] } else { 0.0 }
            })
        })
    }
}

/// The program.
#[derive(Clone, Debug, Default)]
pub struct Scaled {
    /// Interactions.
    pub locals: Vec<Local>,
    /// Free degrees of freedom.
    pub free: Vec<[bool; 3]>,
    /// Weights m (inertia and regularisation).
    pub weight: Vec<[f64; 3]>,
    /// Right sides f.
    pub right: Vec<[f64; 3]>,
    /// Known displacements; zero where free.
    pub known: Vec<[f64; 3]>,
    /// Images of bodies in a periodic cell.
    pub images: Images,
}

impl Scaled {
    /// Scales a program. Its bodies come in this `order`: here, body k is `order[k]` of the
    /// program.
    #[must_use]
    pub fn new(program: &ConeProgram, order: &[usize]) -> Self {
        let units = Units::of(program);
        let mut out = Self::default();
        let place = places(order);
        for body in order.iter().map(|body| &program.bodies[*body]) {
            out.add_body(&units, body);
        }
        out.images = Images::of(program, &place, &out.free);
        // Entries are large: a vector that grows would copy them.
        out.locals.reserve_exact(program.interactions.len());
        for (number, c) in program.interactions.iter().enumerate() {
            let (bodies, rows, fixed) = out.rows(program, &units, &place, number, c);
            out.locals.push(Local::new(&units, c, bodies, rows, fixed));
        }
        out
    }

    /// Adds a body.
    fn add_body(&mut self, Units { du, df, .. }: &Units, body: &ProgramBody) {
        let (mut free, mut weight, mut right, mut known) =
            ([false; 3], [0.0; 3], [0.0; 3], [0.0; 3]);
        for k in 0..3 {
            match &body.dofs[k] {
                Dof::Fixed(u) => known[k] = u / du[k],
                Dof::Free(f) => {
                    free[k] = true;
                    weight[k] = (f.inertia + f.proximal) * du[k] / df[k];
                    right[k] = (f.load + f.proximal * f.reference) / df[k];
                }
            }
        }
        self.free.push(free);
        self.weight.push(weight);
        self.right.push(right);
        self.known.push(known);
    }

    /// Places of the bodies of an interaction, their rows, and the kinematics of the fixed degrees
    /// of freedom.
    fn rows(
        &self,
        program: &ConeProgram,
        units: &Units,
        place: &[usize],
        number: usize,
        c: &Interaction,
    ) -> ([usize; 2], [[[f64; 3]; 3]; 2], [f64; 3]) {
        let has = forces_of(c);
        let mut places = [c.a, c.b].map(|i| place[i as usize]);
        let mut rows = [[[0.0; 3]; 3]; 2];
        let mut fixed = [0.0; 3];
        for (side, (body, first)) in [(c.a, true), (c.b, false)].into_iter().enumerate() {
            let all = units.rows(&c.rows(program.bodies[body as usize].axis, first), has);
            let body = places[side];
            for k in 0..3 {
                for f in 0..3 {
                    if self.free[body][k] {
                        rows[side][k][f] = all[k][f];
                    } else {
                        fixed[f] += all[k][f] * self.known[body][k];
                    }
                }
            }
        }
        if let Some((k, _)) = self.images.at(number) {
            let of_image = units.rows(&c.rows(program.bodies[c.b as usize].axis, false), has);
            let by_cell = self.images.known_by_cell(k, &self.known, &of_image);
            for f in 0..3 {
                fixed[f] += by_cell[f];
            }
            (places[1], rows[1]) = (self.free.len() + k, of_image);
        }
        (places, rows, fixed)
    }

    /// The displacements `u` of free degrees of freedom and the known ones of all others; those of
    /// the images come after them.
    #[must_use]
    pub fn with_known(&self, u: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let of = |i: usize, k: usize| if self.free[i][k] { u[i][k] } else { self.known[i][k] };
        let mut out: Vec<_> = (0..self.free.len()).map(|i| [0, 1, 2].map(|k| of(i, k))).collect();
        self.images.extend(&mut out);
        out
    }

    /// Number of bodies and images.
    #[must_use]
    pub fn places(&self) -> usize {
        self.free.len() + self.images.count()
    }

    /// The bodies of an interaction, whether or not the second takes part as an image.
    #[must_use]
    pub fn pair(&self, local: &Local) -> [usize; 2] {
        [local.bodies[0], self.images.body(local.bodies[1])]
    }

    /// The interaction between two bodies that remains of one with an image if the cell is held at
    /// the displacements `u`.
    #[must_use]
    pub fn with_cell_held(&self, local: &Local, u: &[[f64; 3]]) -> Local {
        let mut out = local.clone();
        if let Some(k) = self.images.number(local.bodies[1]) {
            let by_cell = self.images.kinematics_by_cell(k, u, &local.rows[1]);
            for f in 0..3 {
                out.linear[f] -= by_cell[f];
            }
            out.bodies = self.pair(local);
            (out.rows[1], _) = self.images.rows(k, &local.rows[1]);
        }
        out
    }

    /// Sum of `term` of body and direction over all free degrees of freedom.
    pub fn sum_of_free(&self, term: impl Fn(usize, usize) -> f64) -> f64 {
        let mut sum = 0.0;
        for (i, free) in self.free.iter().enumerate() {
            for k in 0..3 {
                if free[k] {
                    sum += term(i, k);
                }
            }
        }
        sum
    }

    /// Whether every free degree of freedom has a weight: inertia or regularisation.
    #[must_use]
    pub fn is_damped(&self) -> bool {
        let free = self.free.iter().flatten().zip(self.weight.iter().flatten());
        free.filter(|(free, _)| **free).all(|(_, weight)| *weight > 0.0)
    }

    /// Sets `out` to `m u - f` on free degrees of freedom: the balance without the forces of the
    /// interactions.
    pub fn balance_of_bodies(&self, u: &[[f64; 3]], out: &mut [[f64; 3]]) {
        out[self.free.len()..].fill([0.0; 3]);
        for (i, out) in out[..self.free.len()].iter_mut().enumerate() {
            for k in 0..3 {
                out[k] = if self.free[i][k] {
                    self.weight[i][k] * u[i][k] - self.right[i][k]
                } else {
                    0.0
                };
            }
        }
    }

    /// Kinematics `e = G'u` of an interaction, without the part of fixed degrees of freedom.
    #[must_use]
    pub fn kinematics(local: &Local, u: &[[f64; 3]]) -> [f64; 3] {
        kinematics(local.bodies.map(|i| i as u32), &local.rows, u)
    }
}

/// Kinematics of `F` forces with these rows, without the part of fixed degrees of freedom.
#[inline]
pub fn kinematics<const F: usize>(
    bodies: [u32; 2],
    rows: &[[[f64; F]; 3]; 2],
    u: &[[f64; 3]],
) -> [f64; F] {
    let mut e = [0.0; F];
    for (rows, body) in rows.iter().zip(bodies) {
        let v = &u[body as usize];
        for k in 0..3 {
            for f in 0..F {
                e[f] += rows[k][f] * v[k];
            }
        }
    }
    e
}

/// Adds `sign G s` of `F` forces with these rows to the rows of free degrees of freedom.
#[inline]
pub fn add_forces<const F: usize>(
    bodies: [u32; 2],
    rows: &[[[f64; F]; 3]; 2],
    s: &[f64; F],
    sign: f64,
    out: &mut [[f64; 3]],
) {
    for (rows, body) in rows.iter().zip(bodies) {
        let out = &mut out[body as usize];
        for k in 0..3 {
            let mut sum = 0.0;
            for f in 0..F {
                sum += rows[k][f] * s[f];
            }
            out[k] += sign * sum;
        }
    }
}
