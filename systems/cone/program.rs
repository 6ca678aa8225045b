//! The cone program of one increment, what every solver reads, and its solution.
//!
//! Unknowns are the forces (p, q, tau) of every interaction; the displacements are the
//! multipliers of the balance rows. With m the inertia weights,
//!
//! ```text
//! minimise   1/2 sum m u^2 + sum_c [ (g - e_n) p + 1/2 C_N p^2
//!                                    - e_t q + 1/2 C_T (q - q_0)^2 - e_r tau ]
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
//! With H the displacement gradient of the cell it moves by `u_b + H s`, and the force on it acts on
//! the cell as well: [`ProgramCell`].

#[cfg(all(feature = "bevy", feature = "reflect"))]
use bevy_ecs::reflect::ReflectResource;
use glam::DVec2;
use serde::{Deserialize, Serialize};

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
    #[serde(default)]
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

/// Limits of an interaction: `|q| <= cohesion + friction p`, `|tau| <= moment + rolling p`,
/// `p >= -tension`.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Limits {
    /// `c A`, N.
    pub cohesion: f64,
    /// Friction coefficient.
    pub friction: f64,
    /// `f_t`, N.
    pub tension: f64,
    /// `mu_r r`, m.
    pub rolling: f64,
    /// Moment that is transmitted without normal force, N m: `mu_r r f_t`.
    pub moment: f64,
}

impl Limits {
    /// The limits with these strengths: the moment follows from the tensile strength.
    #[must_use]
    pub fn new(cohesion: f64, friction: f64, tension: f64, rolling: f64) -> Self {
        Self { cohesion, friction, tension, rolling, moment: rolling * tension }
    }

    /// Whether the interaction has a shear force.
    #[must_use]
    pub fn has_shear(&self) -> bool {
        self.cohesion > 0.0 || self.friction > 0.0
    }

    /// Whether the interaction resists tension, or shear without pressure, as an intact bond does.
    /// An interaction without strength is a contact.
    #[must_use]
    pub fn has_strength(&self) -> bool {
        self.tension > 0.0 || self.cohesion > 0.0
    }

    /// Whether the interaction has a rolling moment.
    #[must_use]
    pub fn has_rolling(&self) -> bool {
        self.rolling > 0.0
    }

    /// The minimum normal force that the limits allow, N: `-f_t`, or the apex of the shear limit or
    /// of the rolling limit if that is larger.
    #[must_use]
    pub fn min_normal_force(&self) -> f64 {
        let apex = |at_zero: f64, slope: f64| {
            if slope > 0.0 { at_zero / slope } else { f64::INFINITY }
        };
        let apexes = apex(self.cohesion, self.friction).min(apex(self.moment, self.rolling));
        -self.tension.min(apexes)
    }

    /// Whether `p >= -f_t` needs a row of its own. The two rolling rows imply it; so do the two
    /// shear rows of a cohesionless, frictional contact without tension.
    #[must_use]
    pub fn has_tension_row(&self) -> bool {
        !(self.has_rolling()
            || (self.friction > 0.0 && self.cohesion == 0.0 && self.tension == 0.0))
    }
}

/// One interaction of the program: a contact or a bond.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Interaction {
    /// First body.
    pub a: u32,
    /// Second body.
    pub b: u32,
    /// Unit normal from a to b.
    pub normal: DVec2,
    /// Lever arm of the shear force at a, m.
    pub arm_a: f64,
    /// Lever arm of the shear force at b, m; 0 at a wall that does not turn.
    pub arm_b: f64,
    /// Lever arm of the normal force at a, m; 0 where it passes through the reference point of a.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub normal_arm_a: f64,
    /// Lever arm of the normal force at b, m; 0 where it passes through the reference point of b.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub normal_arm_b: f64,
    /// Offset g, m: gap, less the bond's initial gap, over theta where the contact is elastic.
    pub offset: f64,
    /// Normal compliance in the program, m/N.
    pub normal_compliance: f64,
    /// Tangential compliance in the program, m/N.
    pub tangential_compliance: f64,
    /// Shear force at the end of the last increment, N; 0 where the tangential compliance is 0.
    pub previous_shear: f64,
    /// Limits.
    pub limits: Limits,
    /// Share a of the associated dilation: sliding and rolling open the interaction by
    /// `a (mu |slip| + mu_r r |d_r|)`. 1 for the associated law, 0 for Coulomb's.
    #[serde(default = "associated")]
    pub dilation: f64,
    /// Shift s of the image of b in the [cell](ProgramCell), over the length of the cell; zero where
    /// b takes part itself.
    #[serde(default, skip_serializing_if = "is_none")]
    pub image: DVec2,
}

/// The deformation of a periodic cell as a body of the program.
///
/// With the translations U (in global axes) and the rotation T of that body, and l the length of the
/// cell, the displacement gradient is `H = [[U_x/l, arm T/l], [0, U_y/l]]`: an image with the shift s
/// moves by `u_b + H s`. The loads on the body are `-sigma_xx A h/l`, `-sigma_yy A h/l` and
/// `-sigma_xy A h arm/l`, with A the area, h the thickness and sigma the average stress (compression
/// positive), since the sum of the forces on images times their shifts is `sigma A h`.
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
    #[must_use]
    pub fn shift(&self, image: DVec2, u: [f64; 3]) -> DVec2 {
        DVec2::new(image.x * u[0] + image.y * self.arm * u[2], image.y * u[1])
    }

    /// Coefficients of the forces in the rows of the cell, in the axes of its body, for the rows of
    /// the image along x and y.
    #[must_use]
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

/// The dilation of a dump that does not state it.
fn associated() -> f64 {
    1.0
}

/// Whether a dump leaves a shift out.
fn is_none(shift: &DVec2) -> bool {
    *shift == DVec2::ZERO
}

/// Whether a dump leaves a number out.
fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// Closing, slip and relative rotation of an interaction.
pub type Kinematics = [f64; 3];

impl ProgramBody {
    /// Whether any of its displacements is unknown.
    #[must_use]
    pub fn is_free(&self) -> bool {
        self.dofs.iter().any(|dof| matches!(dof, Dof::Free(_)))
    }

    /// A displacement in the body's own axes turned into (x, y, rotation).
    #[must_use]
    pub fn to_global(&self, local: [f64; 3]) -> [f64; 3] {
        let v = self.axis * local[0] + self.axis.perp() * local[1];
        [v.x, v.y, local[2]]
    }
}

impl Interaction {
    /// A rigid interaction without friction or strength from body `a` to body `b`: normal along x,
    /// no arms, no gap, associated law.
    #[must_use]
    pub fn between(a: u32, b: u32) -> Self {
        Self {
            a,
            b,
            normal: DVec2::X,
            arm_a: 0.0,
            arm_b: 0.0,
            normal_arm_a: 0.0,
            normal_arm_b: 0.0,
            offset: 0.0,
            normal_compliance: 0.0,
            tangential_compliance: 0.0,
            previous_shear: 0.0,
            limits: Limits::default(),
            dilation: 1.0,
            image: DVec2::ZERO,
        }
    }

    /// Whether b takes part as an image, so that the cell takes part too.
    #[must_use]
    pub fn is_across(&self) -> bool {
        self.image != DVec2::ZERO
    }

    /// Coefficients of (p, q, tau) in the three balance rows of body `a` (`first`) or `b`, in the
    /// axes of that body: `rows[i][j]` belongs to degree of freedom i and force j.
    #[must_use]
    pub fn rows(&self, axis: DVec2, first: bool) -> [[f64; 3]; 3] {
        let (sign, arm, of_normal) = if first {
            (1.0, self.arm_a, self.normal_arm_a)
        } else {
            (-1.0, self.arm_b, self.normal_arm_b)
        };
        let (n, t) = (self.normal * sign, self.normal.perp() * sign);
        let other = axis.perp();
        [[n.dot(axis), t.dot(axis), 0.0], [n.dot(other), t.dot(other), 0.0], [of_normal, arm, sign]]
    }

    /// The interaction with the forces of body `a` (`first`) or `b` acting on body `body` instead,
    /// whose reference point is at `-lever` from that of the body it replaces.
    #[must_use]
    pub fn carried_by(mut self, first: bool, body: u32, lever: DVec2) -> Self {
        let (of_normal, of_shear) =
            (lever.perp_dot(self.normal), lever.perp_dot(self.normal.perp()));
        if first {
            self.a = body;
            self.normal_arm_a += of_normal;
            self.arm_a += of_shear;
        } else {
            self.b = body;
            self.normal_arm_b -= of_normal;
            self.arm_b -= of_shear;
        }
        self
    }
}

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
    /// Residual at which the solver may stop; 0 means its own default.
    pub tolerance: f64,
    /// Forces (p, q, tau) at the end of the last increment, in the order of the interactions;
    /// interactions beyond the end of the list carried none. They are a guess of the solution and
    /// no part of the problem.
    pub last_forces: Vec<[f64; 3]>,
    /// The deformation of the periodic cell, if the bodies are in one.
    pub cell: Option<ProgramCell>,
}

impl ConeProgram {
    /// Closing, slip and relative rotation of interaction `c` for the displacements `u` by body,
    /// in the bodies' own axes.
    #[must_use]
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
            for (body, first) in [(c.a as usize, true), (c.b as usize, false)] {
                let g = c.rows(self.bodies[body].axis, first);
                for (row, g) in rows[body].iter_mut().zip(&g) {
                    *row += g[0] * f[0] + g[1] * f[1] + g[2] * f[2];
                }
            }
            if let Some((cell, g)) = self.rows_of_cell(c) {
                for (row, g) in rows[cell].iter_mut().zip(&g) {
                    *row += g[0] * f[0] + g[1] * f[1] + g[2] * f[2];
                }
            }
        }
    }

    /// Row of the body of the cell and coefficients of (p, q, tau) in its balance rows; `None` for an
    /// interaction in which no image takes part.
    #[must_use]
    pub fn rows_of_cell(&self, c: &Interaction) -> Option<(usize, [[f64; 3]; 3])> {
        let cell = self.cell.as_ref().filter(|_| c.is_across())?;
        let body = cell.body as usize;
        let [x, y, _] = c.rows(DVec2::X, false);
        Some((body, cell.rows(c.image, self.bodies[body].axis, &[x, y])))
    }

    /// Whether the deformation of the cell is not known.
    #[must_use]
    pub fn has_free_cell(&self) -> bool {
        self.cell.is_some_and(|cell| self.bodies[cell.body as usize].is_free())
    }

    /// Replaces the displacements of degrees of freedom with inertia by `u = (load - G f)/inertia`,
    /// so that momentum holds to round-off whatever the solver's tolerance. An error of the forces
    /// then shows in the motion: it is that motion whose residuals count.
    pub fn displacements_from_forces(&self, solution: &mut ConeSolution) {
        let mut rows = vec![[0.0; 3]; self.bodies.len()];
        self.add_forces(&solution.forces, &mut rows);
        for ((body, row), u) in self.bodies.iter().zip(&rows).zip(&mut solution.displacements) {
            for k in 0..3 {
                if let Dof::Free(free) = &body.dofs[k]
                    && free.inertia > 0.0
                {
                    u[k] = (free.load - row[k]) / free.inertia;
                }
            }
        }
    }

    /// Displacements by body in its own axes as far as they are imposed; zero where they are free.
    #[must_use]
    pub fn imposed(&self) -> Vec<[f64; 3]> {
        let known = |dof| if let Dof::Fixed(u) = dof { u } else { 0.0 };
        self.bodies.iter().map(|body| body.dofs.map(known)).collect()
    }

    /// Whether any body was in motion when the increment began.
    #[must_use]
    pub fn has_momentum(&self) -> bool {
        let moves = |dof: &Dof| matches!(dof, Dof::Free(f) if f.momentum != 0.0);
        self.bodies.iter().any(|body| body.dofs.iter().any(moves))
    }

    /// Whether any body has inertia.
    #[must_use]
    pub fn is_dynamic(&self) -> bool {
        let inert = |dof: &Dof| matches!(dof, Dof::Free(f) if f.inertia > 0.0);
        self.bodies.iter().any(|body| body.dofs.iter().any(inert))
    }

    /// Number of force variables, balance rows and limit rows that a solver needs.
    #[must_use]
    pub fn size(&self) -> ProgramSize {
        let mut size = ProgramSize { forces: 0, inertias: 0, balance_rows: 0, limit_rows: 0 };
        for c in &self.interactions {
            let l = &c.limits;
            size.forces += 1 + usize::from(l.has_shear()) + usize::from(l.has_rolling());
            size.limit_rows += 2 * usize::from(l.has_shear())
                + 2 * usize::from(l.has_rolling())
                + usize::from(l.has_tension_row());
        }
        for dof in self.bodies.iter().flat_map(|b| &b.dofs) {
            if let Dof::Free(f) = dof {
                size.balance_rows += 1;
                size.inertias += usize::from(f.inertia + f.proximal > 0.0);
            }
        }
        size
    }
}

/// Size of a [`ConeProgram`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProgramSize {
    /// Variables p, q, tau.
    pub forces: usize,
    /// Variables t, r: degrees of freedom with inertia or regularisation.
    pub inertias: usize,
    /// Balance rows: free degrees of freedom.
    pub balance_rows: usize,
    /// Limit rows.
    pub limit_rows: usize,
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
    #[must_use]
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
    /// Maximum violation of the mechanism's kinematic conditions over its maximum motion.
    pub defect: f64,
}

/// What a solver returns.
#[cfg_attr(feature = "bevy", derive(bevy_ecs::prelude::Resource))]
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
#[cfg_attr(all(feature = "bevy", feature = "reflect"), reflect(Resource))]
pub struct ConeSolution {
    /// How it ended.
    pub status: SolveStatus,
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
