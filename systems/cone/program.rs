//! The cone program of one increment, the input of every solver, and its solution.
//!
//! Unknowns are the forces (p, q, tau) of every interaction; the displacements are the
//! multipliers of the balance rows. With m the inertia weights,
//!
//! ```text
//! minimise   1/2 sum m u^2 + sum_c [ (g - e_n) p + 1/2 C_N p^2
//!                                    - e_t q + 1/2 C_T (q - q_0)^2
//!                                    - e_r tau + 1/2 C_R (tau - tau_0)^2 ]
//! subject to m u + G (p, q, tau) = f                    for every free degree of freedom
//!            |q| <= c A + mu p,  |tau| <= mu_r r (p + f_t),  p >= -f_t
//! ```
//!
//! with e the kinematics of the imposed displacements.
//!
//! G maps (p, q, tau) of contact c from body a to body b to the forces that a *resists*:
//! rows of a: `p n + q t`, `e_a p + l_a q + tau`; rows of b: `-(p n + q t)`,
//! `e_b p + l_b q - tau`, where `t = (-n_y, n_x)`. Its transpose gives the conjugate kinematics:
//! closing `d_n = n.(u_a - u_b) + e_a alpha_a + e_b alpha_b`, slip
//! `d_t = t.(u_a - u_b) + l_a alpha_a + l_b alpha_b`, relative rotation `d_r = alpha_a - alpha_b`.
//!
//! For forces at the point `x_c` the arms are moments about the reference points of the bodies:
//! `e_a = (x_c - x_a) x n`, `l_a = (x_c - x_a) x t`, and with the opposite sign on the other side
//! `e_b = -(x_c - x_b) x n`, `l_b = -(x_c - x_b) x t`. Between disks the normal passes through both
//! centres, and `e_a = e_b = 0`.
//!
//! In a periodic cell b may be the image of a body: the body, shifted by a vector s of the lattice.
//! With H the displacement gradient of the cell it moves by `u_b + H s`, and the force on it acts
//! on the cell as well: [`ProgramCell`].

#[cfg(all(feature = "bevy", feature = "reflect"))]
use bevy_ecs::reflect::ReflectResource;
use glam::DVec2;
use serde::{Deserialize, Serialize};

pub use crate::interaction::{Interaction, Limits, SlidingLaw};

/// One degree of freedom of a body of the program.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Dof {
    /// Its displacement is known: imposed, held, or zero because no force acts on it.
    Fixed(f64),
    /// Its displacement is unknown and its balance is a row of the program.
    Free(FreeDof),
}

/// A degree of freedom with a balance row `inertia u + proximal (u - reference) + G f = load`.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct FreeDof {
    /// Load: applied force plus gravity plus, in dynamics, `inertia v_0 dt`; N or N m.
    pub load: f64,
    /// The part `inertia v_0 dt` of the load. It stands for the motion at the start of the
    /// increment and counts as no force in the residuals.
    pub momentum: f64,
    /// Inertia `m / (theta dt^2)`, N/m (moments: N m/rad); 0 in static analysis.
    pub inertia: f64,
    /// Weight of the regularisation of a motion without stiffness, N/m (N m/rad); 0 otherwise.
    /// Its force is an error of the balance and is counted as such in the residuals.
    pub proximal: f64,
    /// Motion that the regularisation pulls to, m (rad).
    pub reference: f64,
}

/// A body of the program. Its translations are along `axis` and along `axis` turned by +90
/// degrees, so that a wall that moves along its normal has one translation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct ProgramBody {
    /// Unit vector of the first translation.
    pub axis: DVec2,
    /// First translation, second translation, rotation.
    pub dofs: [Dof; 3],
}

impl ProgramBody {
    /// Whether any of its displacements is unknown.
    pub fn is_free(&self) -> bool {
        self.free().next().is_some()
    }

    /// Its degrees of freedom whose displacements are unknown, with their numbers.
    pub fn free(&self) -> impl Iterator<Item = (usize, &FreeDof)> {
        let dofs = self.dofs.iter().enumerate();
        dofs.filter_map(|(k, dof)| if let Dof::Free(free) = dof { Some((k, free)) } else { None })
    }

    /// A displacement in the body's own axes turned into (x, y, rotation).
    pub fn to_global(&self, local: [f64; 3]) -> [f64; 3] {
        let v = self.axis * local[0] + self.axis.perp() * local[1];
        [v.x, v.y, local[2]]
    }
}

/// The deformation of a periodic cell as a body of the program.
///
/// With the translations U (in global axes) and the rotation T of that body, and l the length of
/// the cell, the displacement gradient is `H = [[U_x/l, arm T/l], [0, U_y/l]]`: an image with the
/// shift s moves by `u_b + H s`. The loads on the body are `-sigma_xx A h/l`, `-sigma_yy A h/l` and
/// `-sigma_xy A h arm/l`, with A the area, h the thickness and sigma the average stress
/// (compression positive), since the sum of the forces on images times their shifts is `sigma A h`.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct ProgramCell {
    /// Row of the body.
    pub body: u32,
    /// Displacement over the length of the cell per unit of rotation, m.
    pub arm: f64,
}

impl ProgramCell {
    /// Displacement of an image in excess of that of its body, m, for the displacements of the cell
    /// in global axes.
    pub fn shift(&self, image: DVec2, u: [f64; 3]) -> DVec2 {
        DVec2::new(image.x * u[0] + image.y * self.arm * u[2], image.y * u[1])
    }

    /// Coefficients of the forces in the rows of the cell, in the axes of its body, for the rows of
    /// the image along x and y.
    pub fn rows<const F: usize>(
        &self,
        image: DVec2,
        axis: DVec2,
        of: &[[f64; F]; 2],
    ) -> [[f64; F]; 3] {
        let perp = axis.perp();
        let row = |of_x: f64, of_y: f64| -> [f64; F] {
            std::array::from_fn(|f| of_x * of[0][f] + of_y * of[1][f])
        };
        [
            row(axis.x * image.x, axis.y * image.y),
            row(perp.x * image.x, perp.y * image.y),
            row(self.arm * image.y, 0.0),
        ]
    }
}

/// Closing, slip and relative rotation of an interaction.
pub type Kinematics = [f64; 3];

/// The magnitudes that make the program non-dimensional inside a solver.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Scales {
    /// Length for moments and rotations, m: the mean radius.
    pub length: f64,
    /// Displacement, m.
    pub displacement: f64,
    /// Force, N.
    pub force: f64,
}

impl Scales {
    /// Units of the three degrees of freedom of a body: displacement (m, m, rad) and force (N, N,
    /// N m).
    pub fn units(&self) -> ([f64; 3], [f64; 3]) {
        let (u, f, l) = (self.displacement, self.force, self.length);
        ([u, u, u / l], [f, f, f * l])
    }
}

impl Default for Scales {
    fn default() -> Self {
        Self { length: 1.0, displacement: 1.0, force: 1.0 }
    }
}

/// One increment as a cone program, in SI units.
#[cfg_attr(feature = "bevy", derive(bevy_ecs::prelude::Resource))]
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
#[cfg_attr(all(feature = "bevy", feature = "reflect"), reflect(Resource))]
pub struct ConeProgram {
    /// Bodies, by identity.
    pub bodies: Vec<ProgramBody>,
    /// Interactions, sorted by (a, b).
    pub interactions: Vec<Interaction>,
    /// Expected magnitudes.
    pub scales: Scales,
    /// Forces (p, q, tau) at the end of the last increment, in the order of the interactions;
    /// interactions beyond the end of the list carried none. They are a guess of the solution and
    /// no part of the problem.
    pub last_forces: Vec<[f64; 3]>,
    /// The deformation of the periodic cell, if the bodies are in one.
    pub cell: Option<ProgramCell>,
}

impl ConeProgram {
    /// Whether an interaction has strength.
    pub fn has_bonds(&self) -> bool {
        self.interactions.iter().any(|c| c.limits.has_strength())
    }

    /// Closing, slip and relative rotation of interaction `c` for the displacements `u` by body,
    /// in the bodies' own axes.
    pub fn kinematics(&self, c: &Interaction, u: &[[f64; 3]]) -> Kinematics {
        let (a, b) = (c.a as usize, c.b as usize);
        let ua = self.bodies[a].to_global(u[a]);
        let ub = self.bodies[b].to_global(u[b]);
        let (mut d, t) = (DVec2::new(ua[0] - ub[0], ua[1] - ub[1]), c.normal.perp());
        if c.is_across()
            && let Some(cell) = &self.cell
        {
            let row = cell.body as usize;
            d -= cell.shift(c.image, self.bodies[row].to_global(u[row]));
        }
        [
            c.normal.dot(d) + c.normal_arm_a * ua[2] + c.normal_arm_b * ub[2],
            t.dot(d) + c.arm_a * ua[2] + c.arm_b * ub[2],
            ua[2] - ub[2],
        ]
    }

    /// Adds `G f` to `rows`, indexed by body and degree of freedom in the bodies' own axes.
    pub fn add_forces(&self, forces: &[[f64; 3]], rows: &mut [[f64; 3]]) {
        for (c, f) in self.interactions.iter().zip(forces) {
            for (body, g) in self.rows(c) {
                for (row, g) in rows[body].iter_mut().zip(&g) {
                    *row += g[0] * f[0] + g[1] * f[1] + g[2] * f[2];
                }
            }
        }
    }

    /// The bodies on which an interaction acts, the cell among them, with the coefficients of (p, q,
    /// tau) in their balance rows.
    pub fn rows(&self, c: &Interaction) -> impl Iterator<Item = (usize, [[f64; 3]; 3])> {
        let of = |body: u32, first| {
            let body = body as usize;
            (body, c.rows(self.bodies[body].axis, first))
        };
        [of(c.a, true), of(c.b, false)].into_iter().chain(self.rows_of_cell(c))
    }

    /// Row of the body of the cell and coefficients of (p, q, tau) in its balance rows; `None` for
    /// an interaction in which no image takes part.
    pub(crate) fn rows_of_cell(&self, c: &Interaction) -> Option<(usize, [[f64; 3]; 3])> {
        let cell = self.cell.as_ref().filter(|_| c.is_across())?;
        let body = cell.body as usize;
        let [x, y, _] = c.rows(DVec2::X, false);
        Some((body, cell.rows(c.image, self.bodies[body].axis, &[x, y])))
    }

    /// Replaces the displacements of degrees of freedom with inertia by `u = (load - G f)/inertia`, with
    /// the weight of a regularisation beside the inertia, so that momentum holds to round-off whatever
    /// the solver's tolerance. An error of the forces then appears in the displacements, of which the
    /// residuals are computed.
    pub fn displacements_from_forces(&self, solution: &mut ConeSolution) {
        let mut rows = vec![[0.0; 3]; self.bodies.len()];
        self.add_forces(&solution.forces, &mut rows);
        for ((body, row), u) in self.bodies.iter().zip(&rows).zip(&mut solution.displacements) {
            for (k, free) in body.free().filter(|(_, free)| free.inertia > 0.0) {
                let pull = free.proximal * free.reference;
                u[k] = (free.load + pull - row[k]) / (free.inertia + free.proximal);
            }
        }
    }

    /// Imposed displacements by body in its own axes; zero where they are free.
    pub fn imposed(&self) -> Vec<[f64; 3]> {
        let known = |dof| if let Dof::Fixed(u) = dof { u } else { 0.0 };
        self.bodies.iter().map(|body| body.dofs.map(known)).collect()
    }

    /// Whether any body was in motion when the increment began.
    pub fn has_momentum(&self) -> bool {
        self.free().any(|free| free.momentum != 0.0)
    }

    /// Whether every free degree of freedom has a weight: inertia or regularisation.
    pub(crate) fn is_damped(&self) -> bool {
        self.free().all(|free| free.inertia + free.proximal > 0.0)
    }

    /// Whether any body has inertia.
    pub fn is_dynamic(&self) -> bool {
        self.free().any(|free| free.inertia > 0.0)
    }

    /// The free degrees of freedom of all bodies.
    fn free(&self) -> impl Iterator<Item = &FreeDof> {
        self.bodies.iter().flat_map(|body| body.free().map(|(_, free)| free))
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum SolveStatus {
    /// Optimal to the residuals that stand beside it.
    Solved,
    /// No forces balance the loads within the limits: the certificate is the mechanism.
    Collapsed,
    /// Rigid bodies with no feasible motion: the forces are unbounded.
    Locked,
    /// Neither was reached.
    #[default]
    Stalled,
}

/// KKT residuals of a solution: the maximum over all rows of each kind, without dimension.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Residuals {
    /// |balance row| over the maximum force (moments: over force x mean radius).
    pub balance: f64,
    /// |stationarity row| over the maximum displacement.
    pub kinematics: f64,
    /// Violation of a limit over the maximum force.
    pub cone: f64,
    /// Slack x multiplier over force x displacement.
    pub complementarity: f64,
}

impl Residuals {
    /// Maximum of the four; NaN if any of them is not finite.
    pub fn worst(&self) -> f64 {
        let all = [self.balance, self.kinematics, self.cone, self.complementarity];
        // f64::max drops NaN, which would turn a broken solution into a perfect one.
        if all.iter().any(|r| !r.is_finite()) {
            f64::NAN
        } else {
            all.iter().copied().fold(0.0, f64::max)
        }
    }
}

/// Proof that no forces balance the loads: a mechanism along which the loads do more work than
/// the limits can dissipate.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Certificate {
    /// Displacements of the mechanism by body, in the bodies' own axes; the maximum component is 1.
    pub mechanism: Vec<[f64; 3]>,
    /// Work of the loads less the maximum dissipation, over the work of the loads. A positive
    /// margin proves the collapse, up to the defect.
    pub margin: f64,
    /// Maximum violation of the mechanism's kinematic conditions over the mean motion of the bodies,
    /// weighted by the work that the loads do on each.
    pub defect: f64,
}

/// The solution of a program.
#[cfg_attr(feature = "bevy", derive(bevy_ecs::prelude::Resource))]
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
#[cfg_attr(all(feature = "bevy", feature = "reflect"), reflect(Resource))]
pub struct ConeSolution {
    /// How it ended.
    pub status: SolveStatus,
    /// The law that the forces and displacements solve.
    pub law: SlidingLaw,
    /// Maximum residual with which it counts as a solution.
    pub tolerance: f64,
    /// The solver's own words about how it ended.
    pub message: String,
    /// Iterations of the solver.
    pub iterations: u32,
    /// Residuals that our own code computed from the forces and displacements.
    pub residuals: Residuals,
    /// (p, q, tau) of every interaction, N, N, N m.
    pub forces: Vec<[f64; 3]>,
    /// Displacements by body in the bodies' own axes, m, m, rad.
    pub displacements: Vec<[f64; 3]>,
    /// Mechanism of a collapse.
    pub certificate: Option<Certificate>,
}
