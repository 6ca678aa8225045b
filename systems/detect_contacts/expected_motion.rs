//! How far bodies are expected to move in the increment: what pruning goes by.

use glam::DVec2;

use clastic_components::body::Drive;
use clastic_components::contact::Bodies;
use clastic_components::increment::{Analysis, AnalysisKind, Progress};
use clastic_components::wall::WallDrive;

/// In dynamics one body that hits another gives it part of its motion, and free flight of the two says
/// nothing of it: pairs reach further by this part of the motion of the faster one,
const HIT: f64 = 0.25;
/// and at least so many mean radii; elsewhere this many.
const LEAST_IN_DYNAMICS: f64 = 0.06;
const LEAST: f64 = 0.01;

/// Expected displacements by body and the greatest imposed one.
pub struct ExpectedMotion {
    displacement: Vec<DVec2>,
    imposed: f64,
    /// Part of the motion of the faster body that comes on top in dynamics.
    hit: f64,
    floor: f64,
    ceiling: f64,
}

impl ExpectedMotion {
    /// The gap up to which the pair (a, b) is kept: twice the expected relative motion, half the
    /// greatest imposed motion, and a little, in dynamics part of the motion of the faster.
    pub fn pair_reach(&self, a: u32, b: u32) -> f64 {
        let [a, b] = [a as usize, b as usize];
        let [u, v] = [self.displacement[a], self.displacement[b]];
        let hit = self.hit * u.length().max(v.length());
        (2.0 * (u - v).length() + hit + self.margin()).min(self.ceiling)
    }

    /// No pair of the first `n` bodies reaches further than this.
    pub fn greatest_reach(&self, n: usize) -> f64 {
        let greatest = self.displacement[..n].iter().map(|d| d.length()).fold(0.0, f64::max);
        ((4.0 + self.hit) * greatest + self.margin()).min(self.ceiling)
    }

    fn margin(&self) -> f64 {
        0.5 * self.imposed + self.floor
    }
}

/// Imposed motion where there is one; in dynamics free flight; else the last increment again. Every
/// pair is kept up to a gap of `least` (m).
pub fn expected_motion(
    bodies: &Bodies,
    analysis: &Analysis,
    progress: &Progress,
    least: f64,
) -> ExpectedMotion {
    let f = progress.fraction;
    let mut displacement: Vec<DVec2> = match analysis.kind {
        AnalysisKind::Dynamic { dt, .. } => bodies
            .velocities
            .iter()
            .map(|v| *v * (dt * f) + analysis.gravity * (dt * f * dt * f))
            .collect(),
        AnalysisKind::Static => {
            bodies.last_motion.iter().map(|u| f * DVec2::new(u[0], u[1])).collect()
        }
        AnalysisKind::LeastMotion { .. } => vec![DVec2::ZERO; bodies.positions.len()],
    };
    let mut imposed = 0.0_f64;
    for i in 0..bodies.particles {
        for k in 0..2 {
            if let Drive::Imposed(u) = bodies.drive(i, k) {
                displacement[i][k] = f * u;
                imposed = imposed.max((f * u).abs());
            }
        }
    }
    for wall in &bodies.walls {
        if let WallDrive::Imposed(u) = bodies.wall_drive(wall) {
            displacement[wall.body as usize] = f * u;
            imposed = imposed.max(f * u.length());
        } else if let AnalysisKind::Dynamic { .. } = analysis.kind {
            displacement[wall.body as usize] = DVec2::ZERO;
        }
    }
    let (hit, floor) = match analysis.kind {
        AnalysisKind::Dynamic { .. } => (HIT, LEAST_IN_DYNAMICS),
        AnalysisKind::Static | AnalysisKind::LeastMotion { .. } => (0.0, LEAST),
    };
    // A few radii are always enough to begin with: what comes from further away is found by the
    // check of the solution.
    ExpectedMotion {
        displacement,
        imposed,
        hit,
        floor: least.max(floor * bodies.mean_radius),
        ceiling: 2.0 * bodies.mean_radius,
    }
}
