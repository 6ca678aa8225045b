//! Estimates how far bodies move in the increment. Pruning uses this estimate.

use glam::DVec2;

use clastic_components::prelude::*;

/// Gap up to which a pair takes part, over the expected relative displacement of the pair.
///
/// 2: the expected motion may be wrong by as much again; no study.
const MOTION: f64 = 2.0;
/// Additional gap, over the maximum imposed displacement.
///
/// 0.5: imposed motion passes on to bodies on which it is not imposed; no study.
const IMPOSED: f64 = 0.5;
/// Additional gap in dynamics, over the displacement of the faster body.
///
/// 0.25: a body that hits another gives it part of its motion, which the free flight of the two
/// does not predict.
const HIT: f64 = 0.25;
/// Minimum gap in dynamics, mean radii.
///
/// 0.06: more than in statics, for the same reason as [`HIT`].
const MIN_IN_DYNAMICS: f64 = 0.06;
/// Minimum gap in static and least-motion analysis, mean radii.
///
/// 0.01: a little, for bodies that are expected to rest; no study.
const MIN: f64 = 0.01;
/// Maximum gap, mean radii.
///
/// 2: a few radii suffice at first. The check of the solution finds pairs that come from further
/// away.
pub const MAX: f64 = 2.0;

/// Expected displacements by body, and the reach that follows from them.
pub(crate) struct ExpectedMotion {
    displacement: Vec<DVec2>,
    /// Additional gap in dynamics, over the motion of the faster body.
    hit: f64,
    /// Additional gap of every pair, m.
    margin: f64,
    ceiling: f64,
}

impl ExpectedMotion {
    /// The gap up to which the pair (a, b) is kept, m.
    pub(crate) fn pair_reach(&self, a: u32, b: u32) -> f64 {
        let [a, b] = [a as usize, b as usize];
        let [u, v] = [self.displacement[a], self.displacement[b]];
        let hit = self.hit * u.length().max(v.length());
        (MOTION * (u - v).length() + hit + self.margin).min(self.ceiling)
    }

    /// No pair of the first `n` bodies reaches further than this.
    pub(crate) fn max_reach(&self, n: usize) -> f64 {
        let maximum = self.displacement[..n].iter().map(|d| d.length()).fold(0.0, f64::max);
        ((2.0 * MOTION + self.hit) * maximum + self.margin).min(self.ceiling)
    }
}

/// The expected motion is the imposed motion, if any; otherwise free flight in dynamics, or the
/// motion of the last increment. Every pair is kept up to a gap of `minimum` (m).
pub(crate) fn expected_motion(
    bodies: &BodyTable,
    analysis: &ClasticAnalysis,
    progress: &ClasticProgress,
    minimum: f64,
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
        AnalysisKind::Compaction { .. } => vec![DVec2::ZERO; bodies.positions.len()],
    };
    let mut imposed = 0.0_f64;
    for i in 0..bodies.particles {
        for k in 0..2 {
            if let Some(u) = bodies.drive(i, k).imposed() {
                displacement[i][k] = f * u;
                imposed = imposed.max((f * u).abs());
            }
        }
    }
    for group in &bodies.groups {
        let u = [0, 1, 2].map(|k| Some(f * bodies.group_drive(group, k).imposed()?));
        if u.iter().all(Option::is_none) {
            continue;
        }
        imposed = imposed.max(f * bodies.imposed_motion(group));
        for &member in &group.members {
            let i = member as usize;
            let own = displacement[i];
            let lever = bodies.lever(group, i);
            let moved = GroupRow::carried(u.map(Option::unwrap_or_default), lever);
            // Along a free translation the member continues its last motion.
            displacement[i] =
                DVec2::new(u[0].map_or(own.x, |_| moved[0]), u[1].map_or(own.y, |_| moved[1]));
        }
    }
    let alone = |wall: &&WallRow| bodies.group(wall.body as usize).is_none();
    for wall in bodies.walls.iter().filter(alone) {
        let drive = bodies.wall_drive(wall);
        if let WallDrive::Imposed(u) = drive {
            displacement[wall.body as usize] = f * u;
            imposed = imposed.max(f * u.length());
        } else if let WallDrive::Turning { .. } = drive {
            // The contact point may move more than the wall's position: the margin covers it.
            displacement[wall.body as usize] = DVec2::ZERO;
            imposed = imposed.max(f * bodies.wall_travel(wall, drive));
        } else if let WallDrive::Sliding { along, .. } = drive {
            imposed = imposed.max(f * along.abs());
            if let AnalysisKind::Dynamic { .. } = analysis.kind {
                displacement[wall.body as usize] = f * along * wall.tangent();
            }
        } else if let AnalysisKind::Dynamic { .. } = analysis.kind {
            displacement[wall.body as usize] = DVec2::ZERO;
        }
    }
    if let Some(cell) = bodies.cell.filter(|_| !bodies.drives_stopped) {
        imposed = imposed.max(f * cell.imposed());
    }
    let (hit, floor) = match analysis.kind {
        AnalysisKind::Dynamic { .. } => (HIT, MIN_IN_DYNAMICS),
        AnalysisKind::Static | AnalysisKind::Compaction { .. } => (0.0, MIN),
    };
    ExpectedMotion {
        displacement,
        hit,
        margin: IMPOSED * imposed + minimum.max(floor * bodies.mean_radius),
        ceiling: MAX * bodies.mean_radius,
    }
}
