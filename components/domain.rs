//! The values that settings and laws may have. Scenes and apps are checked against this one list.

/// The values that a quantity may have.
#[derive(Clone, Copy, Debug)]
pub struct Domain {
    /// Completes "give ...".
    pub what: &'static str,
    /// Whether it contains a finite value.
    pub contains: fn(f64) -> bool,
}

impl Domain {
    const fn new(what: &'static str, contains: fn(f64) -> bool) -> Self {
        Self { what, contains }
    }

    /// Whether a value is finite and in the domain. NaN is in none.
    pub fn has(&self, value: f64) -> bool {
        value.is_finite() && (self.contains)(value)
    }
}

/// [`ClasticAnalysis::thickness`](crate::increment::ClasticAnalysis::thickness).
pub const THICKNESS: Domain = Domain::new("a thickness in m greater than 0", |h| h > 0.0);
/// Components of [`ClasticAnalysis::gravity`](crate::increment::ClasticAnalysis::gravity).
pub const GRAVITY: Domain = Domain::new("an acceleration in m/s^2", |_| true);
/// [`ClasticAnalysis::strength`](crate::increment::ClasticAnalysis::strength).
pub const FACTOR: Domain = Domain::new("a factor greater than 0", |factor| factor > 0.0);
/// `agitation` of a compaction.
pub const AGITATION: Domain = Domain::new("a length in m of 0 or more", |a| a >= 0.0);
/// [`Acceptance::motion_step`](crate::increment::Acceptance::motion_step).
pub const MOTION_STEP: Domain = Domain::new("a number of radii greater than 0", |step| step > 0.0);
/// Fields that are a small part of something: overlap, slack, multiplier, regularisation.
pub const PART: Domain = Domain::new("a part from 0 to 1", |part| (0.0..=1.0).contains(&part));
/// `dt` of a dynamic analysis.
pub const TIME_STEP: Domain = Domain::new("a time step in s greater than 0", |dt| dt > 0.0);
/// `theta` of a dynamic analysis.
pub const THETA: Domain =
    Domain::new("a theta from 0.5 to 1: below, energy grows", |t| (0.5..=1.0).contains(&t));
/// [`Acceptance::residual`](crate::increment::Acceptance::residual).
pub const RESIDUAL: Domain =
    Domain::new("a residual above 0 and up to 1e-2", |r| r > 0.0 && r <= 1e-2);
/// [`Acceptance::turn`](crate::increment::Acceptance::turn).
pub const TURN: Domain = Domain::new("an angle in rad greater than 0", |t| t > 0.0);
/// [`RuptureRules::tolerance`](crate::increment::RuptureRules::tolerance).
pub const OVERLOAD: Domain = Domain::new("a tolerance between 0 and 0.1", |t| t > 0.0 && t <= 0.1);
/// [`RuptureRules::density`](crate::increment::RuptureRules::density).
pub const DENSITY_OF_RUPTURES: Domain =
    Domain::new("a share of the bonds per relative change of force, above 0", |density| {
        density > 0.0
    });
/// [`RuptureRules::brittleness`](crate::increment::RuptureRules::brittleness).
pub const BRITTLENESS: Domain =
    Domain::new("a multiple of the mean contact force, 0 or more", |b| b >= 0.0);
/// Radii of disks and arcs.
pub const RADIUS: Domain = Domain::new("a radius in m greater than 0", |r| r > 0.0);
/// Coordinates.
pub const PLACE: Domain = Domain::new("a place in m", |_| true);
/// Components of a velocity.
pub const VELOCITY: Domain = Domain::new("a velocity in m/s", |_| true);
/// Angular velocities.
pub const SPIN: Domain = Domain::new("a velocity in rad/s", |_| true);
/// Coefficient of restitution.
pub const RESTITUTION: Domain =
    Domain::new("a coefficient of restitution from 0 to 1", |e| (0.0..=1.0).contains(&e));
/// Compliances of contacts, bonds and links. Scenes give the stiffness.
pub const COMPLIANCE: Domain =
    Domain::new("1 over a stiffness above 0, or 0 for a rigid one", |c| c >= 0.0);
/// Coefficients of friction and of rolling friction.
pub const COEFFICIENT: Domain = Domain::new("a coefficient of 0 or more", |mu| mu >= 0.0);
/// [`BondLaw::cohesion`](crate::material::BondLaw::cohesion).
pub const COHESION: Domain = Domain::new("a cohesion in Pa of 0 or more", |c| c >= 0.0);
/// [`BondLaw::tensile_strength`](crate::material::BondLaw::tensile_strength).
pub const TENSILE_STRENGTH: Domain =
    Domain::new("a tensile strength in Pa of 0 or more", |s| s >= 0.0);
