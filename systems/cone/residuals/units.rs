//! The units that residuals are relative to, and the residuals of one body or interaction in them.

use glam::DVec2;

use super::multipliers;
use crate::program::{
    ConeProgram, Dof, Interaction, Kinematics, ProgramBody, Residuals, SlidingLaw,
};

/// Maximum unit of force over the maximum of expected and applied forces. Rigid bodies that are
/// locked into each other carry any force, and relative to that a load without balance elsewhere
/// would not show.
const MAX_FORCE: f64 = 1e5;

/// Minimum unit of force over the force scale of the program, and over the maximum moment of a rolling
/// spring per length scale.
const MIN_FORCE: f64 = 1e-2;

/// Minimum unit of force, N. Under a moment alone forces are round-off. The moment of an elastic spring
/// counts: that of rigid bodies which are locked may be any.
pub(crate) fn min_force(program: &ConeProgram, forces: &[[f64; 3]]) -> f64 {
    let springs = program.interactions.iter().zip(forces);
    let springs = springs.filter(|(c, _)| c.rolling_compliance > 0.0);
    let moment = springs.map(|(_, f)| f[2].abs()).fold(0.0, f64::max);
    MIN_FORCE * program.scales.force.max(moment / program.scales.length)
}

/// Maximum force of the program, contact or applied, N; at least 1 % of the force scale and of the
/// maximum moment of a rolling spring over the length scale.
///
/// Contact forces count if they act on a free degree of freedom. Between a rigid wall and a disk
/// that is held against it any force is a solution, and relative to 1e24 N no error would show.
pub fn force_scale(program: &ConeProgram, forces: &[[f64; 3]]) -> f64 {
    let felt = |body: u32, direction: DVec2, normal_arm: f64| {
        let body = &program.bodies[body as usize];
        let axes = [body.axis, body.axis.perp()];
        let free = |k: usize| matches!(body.dofs[k], Dof::Free(_));
        (0..2).any(|k| free(k) && axes[k].dot(direction).abs() > 1e-9)
            || (normal_arm != 0.0 && free(2))
    };
    // An arm of the normal force goes with a body that turns, on which both forces act.
    let either = |c: &Interaction, direction| {
        felt(c.a, direction, c.normal_arm_a) || felt(c.b, direction, c.normal_arm_b)
    };
    let mut contact = 0.0_f64;
    for (c, f) in program.interactions.iter().zip(forces) {
        for (direction, f) in [(c.normal, f[0].abs()), (c.normal.perp(), f[1].abs())] {
            if f > contact && either(c, direction) {
                contact = f;
            }
        }
    }
    let applied = applied_force(program);
    // If all forces are zero (a bond has broken, a specimen is unloaded), the round-off of forces
    // that were there before must not count as an error.
    let expected = applied.max(program.scales.force);
    contact.min(MAX_FORCE * expected).max(applied).max(min_force(program, forces))
}

/// Maximum applied force, N.
pub(crate) fn applied_force(program: &ConeProgram) -> f64 {
    let translations = program.bodies.iter().flat_map(|b| b.free().filter(|(k, _)| *k < 2));
    translations.map(|(_, free)| (free.load - free.momentum).abs()).fold(0.0, f64::max)
}

/// Maximum displacement, m, between 1e-6 and 1 mean radii: relative to a body that a solver throws
/// far away every error of the other bodies would look small.
pub fn displacement_scale(program: &ConeProgram, displacements: &[[f64; 3]]) -> f64 {
    let length = program.scales.length;
    displacements.iter().map(|u| u[0].hypot(u[1])).fold(1e-6 * length, f64::max).min(length)
}

/// Displacement that the loads of an increment would give the bodies if nothing held them, m: the
/// minimum over the bodies that have a load; 0 in statics, and where no body was in motion.
///
/// The displacements of rigid bodies near rest are the small difference between this displacement
/// and that of the contact forces. Relative to the difference alone, a force that is exact to 1e-12
/// would leave a residual of any size.
fn free_displacement(program: &ConeProgram) -> f64 {
    if !program.has_momentum() {
        return 0.0;
    }
    let free = |body: &ProgramBody| {
        let translations = body.free().filter(|(k, free)| *k < 2 && free.inertia > 0.0);
        translations.map(|(_, f)| ((f.load - f.momentum) / f.inertia).powi(2)).sum::<f64>().sqrt()
    };
    let minimum =
        program.bodies.iter().map(free).filter(|u| *u > 0.0).fold(f64::INFINITY, f64::min);
    if minimum.is_finite() { minimum } else { 0.0 }
}

/// The units that residuals are relative to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Units {
    /// Force, N.
    pub(crate) force: f64,
    /// Displacement, m.
    pub(crate) displacement: f64,
    /// Displacement of rigid contacts, m: at least that of free bodies.
    pub(crate) rigid: f64,
    /// Length by which a moment is divided, m.
    pub(crate) length: f64,
}

impl Units {
    /// The units of a program with these forces and displacements.
    pub(crate) fn of(
        program: &ConeProgram,
        forces: &[[f64; 3]],
        displacements: &[[f64; 3]],
    ) -> Self {
        let (displacement, length) =
            (displacement_scale(program, displacements), program.scales.length);
        Self {
            force: force_scale(program, forces),
            displacement,
            rigid: displacement.max(free_displacement(program).min(length)),
            length,
        }
    }

    /// Unit of the displacements of an interaction, m. The error of a spring is an error of its
    /// force.
    pub(crate) fn displacement_of(&self, c: &Interaction) -> f64 {
        if c.normal_compliance == 0.0 { self.rigid } else { self.displacement }
    }

    /// The residual of the balance of a body; `row` is the force of its interactions.
    pub(crate) fn of_balance(
        &self,
        body: &ProgramBody,
        row: &[f64; 3],
        u: &[f64; 3],
        regularisation: f64,
    ) -> Residuals {
        let mut out = Residuals::default();
        for (k, f) in body.free() {
            let pull = regularisation * f.proximal * (u[k] - f.reference);
            let defect = f.inertia * u[k] + pull + row[k] - f.load;
            let unit = if k < 2 { self.force } else { self.force * self.length };
            worsen(&mut out.balance, defect.abs() / unit);
        }
        out
    }

    /// The other residuals of an interaction.
    pub(crate) fn of_interaction(
        &self,
        law: SlidingLaw,
        c: &Interaction,
        e: &Kinematics,
        f: &[f64; 3],
    ) -> Residuals {
        let mut out = Residuals::default();
        let Units { force, length, .. } = *self;
        let displacement = self.displacement_of(c);
        let mut m = multipliers(law, c, e, f);
        let l = &c.limits;
        let [p, q, tau] = *f;
        let shear = l.cohesion + l.friction * p;
        let roll = l.moment + l.rolling * p;
        // A limit further away than the maximum force is not active: its multiplier is zero, and
        // the remainder of the stationarity row is an error of the kinematics. Multiplied by a
        // strength or a friction of 1e6 times the forces, round-off of that row would look like an
        // error.
        let is_far = |slack: f64, length: f64| slack.abs() > force * length;
        let slacks = [shear - q * m.slip.signum(), roll - tau * m.rotation.signum()];
        if is_far(slacks[0], 1.0) {
            m.tension += law.dilation(c) * l.friction * m.slip.abs();
        }
        if is_far(slacks[1], length) {
            m.tension += law.dilation(c) * l.rolling * m.rotation.abs();
        }
        worsen(&mut out.kinematics, -m.tension / displacement);
        worsen(&mut out.cone, (q.abs() - shear.max(0.0)) / force);
        worsen(&mut out.cone, (tau.abs() - roll.max(0.0)) / (force * length));
        worsen(&mut out.cone, -(p + l.tension) / force);
        if l.has_shear() {
            worsen(&mut out.cone, -shear / force);
        }

        let mut product = |multiplier: f64, slack: f64, length: f64| {
            if is_far(slack, length) {
                worsen(&mut out.kinematics, (multiplier * length).abs() / displacement);
            } else {
                let product = (multiplier * slack).abs();
                worsen(&mut out.complementarity, product / (force * displacement));
            }
        };
        product(m.tension.max(0.0), p - l.min_normal_force(), 1.0);
        product(m.slip, slacks[0], 1.0);
        product(m.rotation, slacks[1], length);
        out
    }
}

/// The larger one of each residual; NaN stays NaN.
pub(super) fn larger(mut all: Residuals, other: Residuals) -> Residuals {
    worsen(&mut all.balance, other.balance);
    worsen(&mut all.kinematics, other.kinematics);
    worsen(&mut all.cone, other.cone);
    worsen(&mut all.complementarity, other.complementarity);
    all
}

/// The larger number; NaN if either is NaN, which `f64::max` would drop.
pub(crate) fn max_or_nan(m: f64, x: f64) -> f64 {
    if x <= m || m.is_nan() { m } else { x }
}

/// Raises a residual to a value; NaN stays NaN.
fn worsen(residual: &mut f64, value: f64) {
    if residual.is_finite() && (value > *residual || !value.is_finite()) {
        *residual = if value.is_finite() { value } else { f64::NAN };
    }
}
