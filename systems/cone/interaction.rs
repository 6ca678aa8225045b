//! An interaction of the program, and its limits.

use glam::DVec2;
use serde::{Deserialize, Serialize};

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

/// Part of a limit from which a force counts as on it: solutions meet limits to about 1e-8.
const ON_LIMIT: f64 = 1.0 - 1e-6;

impl Limits {
    /// The limits with these strengths: the moment follows from the tensile strength.
    pub fn new(cohesion: f64, friction: f64, tension: f64, rolling: f64) -> Self {
        Self { cohesion, friction, tension, rolling, moment: rolling * tension }
    }

    /// Whether the interaction has a shear force.
    pub fn has_shear(&self) -> bool {
        self.cohesion > 0.0 || self.friction > 0.0
    }

    /// Whether the interaction resists tension, or shear without pressure, as an intact bond does.
    /// An interaction without strength is a contact.
    pub fn has_strength(&self) -> bool {
        self.tension > 0.0 || self.cohesion > 0.0
    }

    /// Whether the interaction has a rolling moment.
    pub fn has_rolling(&self) -> bool {
        self.rolling > 0.0
    }

    /// Which of p, q, tau the interaction has.
    pub fn forces(&self) -> [bool; 3] {
        [true, self.has_shear(), self.has_rolling()]
    }

    /// Whether the shear force of `f` = (p, q, tau) is on its limit, so that the interaction slides.
    pub fn slides(&self, f: &[f64; 3]) -> bool {
        self.has_shear() && f[1].abs() >= ON_LIMIT * (self.cohesion + self.friction * f[0])
    }

    /// Whether the moment of `f` = (p, q, tau) is on its limit, so that the interaction rolls.
    pub fn rolls(&self, f: &[f64; 3]) -> bool {
        self.has_rolling() && f[2].abs() >= ON_LIMIT * (self.moment + self.rolling * f[0])
    }

    /// The minimum normal force that the limits allow, N: `-f_t`, or the apex of the shear limit or
    /// of the rolling limit if that is larger.
    pub fn min_normal_force(&self) -> f64 {
        let apex = |at_zero: f64, slope: f64| {
            if slope > 0.0 { at_zero / slope } else { f64::INFINITY }
        };
        let apexes = apex(self.cohesion, self.friction).min(apex(self.moment, self.rolling));
        -self.tension.min(apexes)
    }

    /// Whether `p >= -f_t` needs a row of its own. The two rolling rows imply it; so do the two
    /// shear rows of a cohesionless, frictional contact without tension.
    pub fn has_tension_row(&self) -> bool {
        !(self.has_rolling()
            || (self.friction > 0.0 && self.cohesion == 0.0 && self.tension == 0.0))
    }
}

/// The law of sliding and rolling that a solution of a program obeys. With a the
/// [dilation](Self::dilation) of an interaction, s_t its slip and s_r its rotation, the gap opens by
///
/// ```text
/// a (mu |s_t| + mu_r r |s_r|)
/// ```
///
/// The program itself does not depend on the law: the admissible forces are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum SlidingLaw {
    /// a = 1: the solution is the minimum of the program.
    #[default]
    Associated,
    /// a = 0 without strength. Interactions with strength keep a = 1: their law is that of the
    /// bond.
    Coulomb,
}

impl SlidingLaw {
    /// The dilation a of an interaction.
    pub fn dilation(self, c: &Interaction) -> f64 {
        f64::from(u8::from(self == Self::Associated || c.limits.has_strength()))
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
    /// Rolling compliance in the program, rad/(N m).
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rolling_compliance: f64,
    /// Rolling moment at the end of the last increment, N m; 0 where the rolling compliance is 0.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub previous_moment: f64,
    /// Limits.
    pub limits: Limits,
    /// Shift s of the image of b in the [cell](crate::program::ProgramCell), over the length of the
    /// cell; zero where b takes part itself.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub image: DVec2,
}

impl Interaction {
    /// A rigid interaction without friction or strength from body `a` to body `b`: normal along x,
    /// no arms, no gap.
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
            rolling_compliance: 0.0,
            previous_moment: 0.0,
            limits: Limits::default(),
            image: DVec2::ZERO,
        }
    }

    /// Whether b takes part as an image, so that the cell takes part too.
    pub fn is_across(&self) -> bool {
        self.image != DVec2::ZERO
    }

    /// Coefficients of (p, q, tau) in the three balance rows of body `a` (`first`) or `b`, in the
    /// axes of that body: `rows[i][j]` belongs to degree of freedom i and force j.
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

    /// Force on body b of `f` = (p, q, tau), N; that on a is opposite.
    pub fn force(&self, f: &[f64; 3]) -> DVec2 {
        self.normal * f[0] + self.normal.perp() * f[1]
    }

    /// The interaction with the forces of body `a` (`first`) or `b` acting on body `body` instead,
    /// whose reference point is at `-lever` from that of the body it replaces.
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

/// Whether a dump leaves a value out.
fn is_zero<T: Default + PartialEq>(x: &T) -> bool {
    *x == T::default()
}
