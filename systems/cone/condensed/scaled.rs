//! The program in units of its scales, interaction by interaction, as a solver reads it.
//!
//! Interaction c: `min 1/2 s'Cs + l's`, `A s + w = b`, `w >= 0` with s = (p, q, tau); stationarity
//! `l + C s - e(u) + A' lambda = 0`. Bodies: `m u + G s = f` on free degrees of freedom.

use std::iter::repeat_n;

use crate::program::{ConeProgram, Dof, Interaction, ProgramBody, Scales};

use super::images::Images;
use super::matrix::places;

/// Maximum number of limits of an interaction: two of shear and two of rolling, which imply that of
/// tension.
pub(crate) const ROWS: usize = 4;

/// The bodies of an interaction, and how they feel `F` forces.
#[derive(Clone, Copy, Debug)]
pub struct Arms<const F: usize> {
    /// Places in the order of elimination; images come after all bodies.
    pub bodies: [u32; 2],
    /// Rows of the two bodies: `[body][dof][force]`, zero where the degree of freedom is fixed.
    pub rows: [[[f64; F]; 3]; 2],
}

impl<const F: usize> Arms<F> {
    /// Those of the first forces of an interaction.
    pub fn of(local: &Local) -> Self {
        let Arms { bodies, rows } = local.arms;
        Self { bodies, rows: rows.map(|rows| rows.map(|row| first(&row))) }
    }

    /// Kinematics `e = G'u`, without the part of fixed degrees of freedom.
    #[inline]
    pub fn kinematics(&self, u: &[[f64; 3]]) -> [f64; F] {
        let mut e = [0.0; F];
        for (rows, body) in self.rows.iter().zip(self.bodies) {
            let v = &u[body as usize];
            for k in 0..3 {
                for f in 0..F {
                    e[f] += rows[k][f] * v[k];
                }
            }
        }
        e
    }

    /// Adds `sign G s` to the rows of free degrees of freedom.
    #[inline]
    pub fn add_forces(&self, s: &[f64; F], sign: f64, out: &mut [[f64; 3]]) {
        self.add_forces_from(0, s, sign, out);
    }

    /// As [`add_forces`](Self::add_forces), to rows that begin with those of the body at the place
    /// `first`.
    #[inline]
    pub(crate) fn add_forces_from(
        &self,
        first: u32,
        s: &[f64; F],
        sign: f64,
        out: &mut [[f64; 3]],
    ) {
        for (rows, body) in self.rows.iter().zip(self.bodies) {
            let out = &mut out[(body - first) as usize];
            for k in 0..3 {
                let mut sum = 0.0;
                for f in 0..F {
                    sum += rows[k][f] * s[f];
                }
                out[k] += sign * sum;
            }
        }
    }
}

/// The first of these numbers.
pub fn first<const N: usize>(x: &[f64]) -> [f64; N] {
    std::array::from_fn(|k| x[k])
}

/// Adds `factor` times other numbers to these.
#[inline]
pub(crate) fn add_times(x: &mut [f64], factor: f64, y: &[f64]) {
    for (x, y) in x.iter_mut().zip(y) {
        *x += factor * y;
    }
}

/// One interaction.
#[derive(Clone, Debug)]
pub struct Local {
    /// Its bodies and their rows.
    pub arms: Arms<3>,
    /// Which of p, q, tau exist.
    pub has: [bool; 3],
    /// Whether tension has a limit of its own.
    pub has_tension: bool,
    /// Compliances; 1 for a shear force that does not exist.
    pub compliance: [f64; 3],
    /// Linear terms, less the kinematics of the fixed degrees of freedom.
    pub linear: [f64; 3],
    /// Slopes of the limits `|q| <= c + mu p` and `|tau| <= m_0 + m p`: mu and m, 0 without the force.
    pub slopes: [f64; 2],
    /// f_t, c and m_0.
    pub strengths: [f64; 3],
}

impl Local {
    /// An interaction from the rows of its bodies and the kinematics of their fixed degrees of
    /// freedom.
    fn new(scales: &Scales, c: &Interaction, arms: Arms<3>, fixed: [f64; 3]) -> Self {
        let (du, df) = scales.units();
        let stiffness = scales.force / scales.displacement;
        let l = &c.limits;
        let has = l.forces();
        let of_moment = c.rolling_compliance * df[2] / du[2];
        Self {
            arms,
            has,
            has_tension: l.has_tension_row(),
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
            slopes: [l.friction, l.rolling / scales.length],
            strengths: [l.tension / df[0], l.cohesion / df[1], l.moment / df[2]],
        }
    }

    /// Slope and strength of its limits: two of shear, two of rolling, that of tension where the others
    /// do not imply it.
    pub fn limits(&self) -> impl Iterator<Item = (f64, f64)> {
        let ([f_t, c, m_0], [mu, m]) = (self.strengths, self.slopes);
        let [_, shear, rolling] = self.has.map(|has| if has { 2 } else { 0 });
        let tension = usize::from(self.has_tension);
        repeat_n((mu, c), shear)
            .chain(repeat_n((m, m_0), rolling))
            .chain(repeat_n((1.0, f_t), tension))
    }

    /// The minimum of p that the limits allow.
    pub fn lowest(&self) -> f64 {
        let limits = self.limits().filter(|(slope, _)| *slope > 0.0);
        limits.map(|(slope, strength)| -strength / slope).fold(f64::NEG_INFINITY, f64::max)
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

/// Forces, N and N m, in units of the scales; 0 for the interactions without one.
pub(crate) fn forces_in_units(program: &ConeProgram, forces: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let (_, df) = program.scales.units();
    let mut out: Vec<_> = forces.iter().map(|s| [0, 1, 2].map(|f| s[f] / df[f])).collect();
    out.resize(program.interactions.len(), [0.0; 3]);
    out
}

impl Scaled {
    /// Scales a program. Its bodies come in this `order`: here, body k is `order[k]` of the
    /// program.
    pub fn new(program: &ConeProgram, order: &[usize]) -> Self {
        let mut out = Self::default();
        let place = places(order);
        for body in order.iter().map(|body| &program.bodies[*body]) {
            out.add_body(&program.scales, body);
        }
        out.images = Images::of(program, &place, &out.free);
        // Entries are large: a vector that grows would copy them.
        out.locals.reserve_exact(program.interactions.len());
        for (number, c) in program.interactions.iter().enumerate() {
            let (arms, fixed) = out.arms(program, &place, number, c);
            out.locals.push(Local::new(&program.scales, c, arms, fixed));
        }
        out
    }

    /// Scales a program in its own order.
    pub fn natural(program: &ConeProgram) -> Self {
        Self::new(program, &(0..program.bodies.len()).collect::<Vec<_>>())
    }

    /// Adds a body.
    fn add_body(&mut self, scales: &Scales, body: &ProgramBody) {
        let (du, df) = scales.units();
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

    /// The bodies of an interaction with their rows, and the kinematics of the fixed degrees of
    /// freedom.
    fn arms(
        &self,
        program: &ConeProgram,
        place: &[usize],
        number: usize,
        c: &Interaction,
    ) -> (Arms<3>, [f64; 3]) {
        let has = c.limits.forces();
        let mut bodies = [c.a, c.b].map(|i| place[i as usize]);
        let mut rows = [[[0.0; 3]; 3]; 2];
        let mut fixed = [0.0; 3];
        let (_, df) = program.scales.units();
        let of = |body: u32, first| {
            let raw = c.rows(program.bodies[body as usize].axis, first);
            [0, 1, 2]
                .map(|k| [0, 1, 2].map(|f| if has[f] { raw[k][f] * df[f] / df[k] } else { 0.0 }))
        };
        let all = [of(c.a, true), of(c.b, false)];
        for (side, body) in bodies.into_iter().enumerate() {
            for k in 0..3 {
                if self.free[body][k] {
                    rows[side][k] = all[side][k];
                } else {
                    add_times(&mut fixed, self.known[body][k], &all[side][k]);
                }
            }
        }
        if let Some((k, _)) = self.images.at(number) {
            let by_cell = self.images.kinematics_by_cell(k, &self.known, true, &all[1]);
            add_times(&mut fixed, 1.0, &by_cell);
            (bodies[1], rows[1]) = (self.free.len() + k, all[1]);
        }
        (Arms { bodies: bodies.map(|i| i as u32), rows }, fixed)
    }

    /// The displacements `u` of free degrees of freedom and the known ones of all others; those of
    /// the images come after them.
    pub(crate) fn with_known(&self, u: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let of = |i: usize, k: usize| if self.free[i][k] { u[i][k] } else { self.known[i][k] };
        let mut out: Vec<_> = (0..self.free.len()).map(|i| [0, 1, 2].map(|k| of(i, k))).collect();
        self.images.extend(&mut out);
        out
    }

    /// Number of bodies and images.
    pub fn places(&self) -> usize {
        self.free.len() + self.images.count()
    }

    /// The bodies of an interaction, whether or not the second takes part as an image.
    pub fn pair(&self, local: &Local) -> [usize; 2] {
        let [a, b] = local.arms.bodies;
        [a as usize, self.images.body(b as usize)]
    }

    /// The interaction between two bodies that remains of one with an image if the cell is held at
    /// the displacements `u`.
    pub(crate) fn with_cell_held(&self, local: &Local, u: &[[f64; 3]]) -> Local {
        let mut out = local.clone();
        let Arms { bodies, rows } = &mut out.arms;
        if let Some(k) = self.images.number(bodies[1] as usize) {
            let by_cell = self.images.kinematics_by_cell(k, u, false, &rows[1]);
            add_times(&mut out.linear, -1.0, &by_cell);
            *bodies = self.pair(local).map(|i| i as u32);
            (rows[1], _) = self.images.rows(k, &rows[1]);
        }
        out
    }

    /// Body and direction of all free degrees of freedom.
    pub(crate) fn all_free(&self) -> impl Iterator<Item = (usize, usize)> {
        let bodies = self.free.iter().enumerate();
        bodies.flat_map(|(i, free)| (0..3).filter(|k| free[*k]).map(move |k| (i, k)))
    }

    /// Sum of `term` of body and direction over all free degrees of freedom.
    pub(crate) fn sum_of_free(&self, term: impl Fn(usize, usize) -> f64) -> f64 {
        self.all_free().fold(0.0, |sum, (i, k)| sum + term(i, k))
    }

    /// Sets the entries of fixed degrees of freedom to zero.
    pub(crate) fn clear_fixed(&self, x: &mut [[f64; 3]]) {
        for (x, free) in x.iter_mut().zip(&self.free) {
            for k in (0..3).filter(|k| !free[*k]) {
                x[k] = 0.0;
            }
        }
    }

    /// Sets `out` to `m u - f` on free degrees of freedom: the balance without the forces of the
    /// interactions.
    pub(crate) fn balance_of_bodies(&self, u: &[[f64; 3]], out: &mut [[f64; 3]]) {
        out.fill([0.0; 3]);
        for (i, k) in self.all_free() {
            out[i][k] = self.weight[i][k] * u[i][k] - self.right[i][k];
        }
    }
}
