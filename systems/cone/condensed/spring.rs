//! The forces of an elastic interaction.
//!
//! The forces (p, q) that belong to kinematics (e_n, e_t) are the projection of the elastic trial
//! `p = k_n (e_n - l_n)`, `q = k_t (e_t - l_t)` onto the limits `|q| <= c + mu p`, `p >= -f_t`, in
//! the metric of the compliances.

use super::scaled::{Kind, Local};

/// An elastic interaction: stiffnesses and limits.
#[derive(Clone, Copy, Debug)]
pub struct Spring {
    /// Stiffness in normal and tangential direction, 1 over the compliance.
    stiffness: [f64; 2],
    /// Kinematics at which there is no force.
    linear: [f64; 2],
    /// Coefficient of friction.
    friction: f64,
    /// Cohesion.
    cohesion: f64,
    /// Tensile strength; infinite where the limits of the shear force imply it.
    tension: f64,
    /// Whether there is a shear force.
    shears: bool,
}

/// Forces (p, q) and their derivatives by the kinematics (e_n, e_t).
#[derive(Clone, Copy, Debug, Default)]
pub struct Response {
    /// Forces p and q.
    pub s: [f64; 2],
    /// Derivatives: of p by e_n, of p by e_t (equal to that of q by e_n), and of q by e_t.
    pub d: [f64; 3],
}

impl Spring {
    /// The spring of an interaction with a compliance for each of its forces and no rolling moment.
    pub fn new(l: &Local) -> Self {
        let (friction, cohesion, tension) = match l.kind {
            Kind::Normal => (0.0, 0.0, l.right[0]),
            Kind::Bond => (-l.limits[0][0], l.right[0], l.right[2]),
            Kind::Friction | Kind::Rolling | Kind::Wheel => {
                (-l.limits[0][0], l.right[0], f64::INFINITY)
            }
        };
        Self {
            stiffness: [1.0 / l.compliance[0], 1.0 / l.compliance[1]],
            linear: [l.linear[0], l.linear[1]],
            friction,
            cohesion,
            tension,
            shears: l.has[1],
        }
    }

    /// Projection of the elastic trial onto the limits.
    #[inline]
    pub fn respond(&self, e: [f64; 2]) -> Response {
        let [kn, kt] = self.stiffness;
        let pt = (e[0] - self.linear[0]) * kn;
        let qt = (e[1] - self.linear[1]) * kt;
        let size = qt.abs();
        let over = size - self.cohesion - self.friction * pt;
        if self.shears && over <= 0.0 && pt >= -self.tension {
            return Response { s: [pt, qt], d: [kn, 0.0, kt] };
        }
        self.limited(pt, qt)
    }

    /// Projection of the trial (pt, qt), which may be outside of the limits.
    fn limited(&self, pt: f64, qt: f64) -> Response {
        let [kn, kt] = self.stiffness;
        let (mu, cohesion, tension) = (self.friction, self.cohesion, self.tension);
        if !self.shears {
            return if pt > -tension {
                Response { s: [pt, 0.0], d: [kn, 0.0, 0.0] }
            } else {
                Response { s: [-tension, 0.0], d: [0.0; 3] }
            };
        }
        let sign = if qt < 0.0 { -1.0 } else { 1.0 };
        let size = qt.abs();
        // The corner of the limits: where tension cuts the shear cone, or the cone's own apex.
        let at_tension = cohesion - mu * tension;
        let (p0, q0) =
            if at_tension >= 0.0 { (-tension, at_tension) } else { (-cohesion / mu, 0.0) };
        let over = size - cohesion - mu * pt;
        if pt < p0 && (over <= 0.0 || size <= q0) {
            return if size <= q0 && q0 > 0.0 {
                Response { s: [p0, qt], d: [0.0, 0.0, kt] }
            } else {
                Response { s: [p0, sign * q0.min(size)], d: [0.0; 3] }
            };
        }
        if over <= 0.0 {
            return Response { s: [pt, qt], d: [kn, 0.0, kt] };
        }
        let sum = kt + mu * mu * kn;
        let slip = over / sum;
        let p = pt + mu * kn * slip;
        if p >= p0 {
            let (vn, vt) = (-mu * kn, sign * kt);
            let d = [kn - vn * vn / sum, -vn * vt / sum, kt - vt * vt / sum];
            return Response { s: [p, sign * (size - kt * slip)], d };
        }
        Response { s: [p0, sign * q0], d: [0.0; 3] }
    }
}
