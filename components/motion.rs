//! A motion that is followed if a static increment has no equilibrium near its start.
//!
//! The static program gets inertia. With W the weight of a step, k_0 a stiffness, m_i the relative
//! mass of body i and v_i its velocity, the balance rows are
//!
//! ```text
//! W k_0 m_i (u_i - v_i dt) + G s = f,      dt = 1/sqrt(W),      v_i <- u_i/dt
//! ```
//!
//! Time and mass have no physical meaning: the loads are constant, and only the state at rest
//! matters. Velocities are set to zero when the kinetic energy falls (kinetic damping, Cundall
//! 1982).

/// State of a motion between two steps.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Motion {
    /// Whether ruptures released the motion at an equilibrium. Otherwise it begins where
    /// equilibrium was lost.
    pub released: bool,
    /// Travel of the furthest grain that a step may have, in its radii.
    pub length: f64,
    /// Weight W of the step, without dimension. A small weight is a long step.
    pub weight: f64,
    /// Stiffness k_0, N/m, of a motion where equilibrium was lost: the force scale of the increment
    /// over the minimum travel of a motion. After a rupture it is the mean stiffness of the bonds.
    pub stiffness: f64,
    /// Relative masses by body: of the translations (1), and of the rotation (m^2).
    pub masses: Vec<[f64; 2]>,
    /// Displacements (m, m, rad) of the last step over its dt, by body in the axes of the body.
    pub velocities: Vec<[f64; 3]>,
    /// Kinetic energy after the last step, N m.
    pub kinetic: f64,
    /// Intended travel of the furthest grain in a step, in its radii.
    pub goal: f64,
    /// Whether the motion is repeated because the first one did not come to rest.
    pub repeated: bool,
    /// Sum of the travels of the furthest grain in each step, in its radii.
    pub travelled: f64,
    /// Travel of the furthest grain in the last step over its dt; 0 if the motion starts from rest.
    pub speed: f64,
    /// Maximum motion of a body that carries load in the last step, m.
    pub step: f64,
    /// Number of steps so far.
    pub steps: u32,
    /// Number of consecutive rejected steps.
    pub failures: u32,
    /// Number of steps with the minimum weight.
    pub free_steps: u32,
}

impl Motion {
    /// Duration of a step, in units in which the relative mass times k_0 is a mass.
    pub fn dt(&self) -> f64 {
        self.weight.sqrt().recip()
    }

    /// Weight (N/m; N m) and reference displacement (m; rad) of degree of freedom `k` of a body.
    pub fn inertia(&self, body: usize, k: usize) -> (f64, f64) {
        let mass = self.masses[body][usize::from(k == 2)];
        (mass * self.weight * self.stiffness, self.velocities[body][k] * self.dt())
    }
}
