//! The probes that drive a test: force against motion, both in the direction of the motion. Rigs
//! that define no stress have their curve and their peak from here.

use serde::Serialize;

use super::read_history::{History, TestPoint};

/// Columns of motion and of force, and the two directions.
const AXES: [(&str, &str, [&str; 2]); 3] = [
    (".x_m", ".force_x_n", ["+x", "-x"]),
    (".y_m", ".force_y_n", ["+y", "-y"]),
    (".rotation_rad", ".moment_nm", ["anticlockwise", "clockwise"]),
];
/// Part of the maximum work that a probe must do to count.
const IDLE: f64 = 1e-6;

/// A probe on which the outside world does work in the test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Drive {
    /// Name of the probe.
    pub probe: String,
    /// Direction of the maximum motion: `+x`, `-x`, `+y`, `-y`, `anticlockwise` or `clockwise`.
    pub direction: &'static str,
    /// Motion and force in this direction. The force is that of the outside world on the probe.
    pub points: Vec<TestPoint>,
}

impl Drive {
    /// The probes that drive the test along the axis with the most work, in the order of the
    /// history. Preparation does not count: it moves probes further, and its forces have no
    /// meaning.
    pub fn all(history: &History) -> Vec<Self> {
        let probes = history.probes();
        let along = |(motion, force, _): (&str, &str, _), probe: &str| {
            history.of_test(probe, [motion, force])
        };
        let total = |axis| probes.iter().map(|probe| work(&along(axis, probe))).fold(0.0, f64::max);
        let axes = AXES.map(|axis| (axis, total(axis))).into_iter();
        let axis = axes.max_by(|(_, a), (_, b)| a.total_cmp(b)).filter(|(_, most)| *most > 0.0);
        let Some((axis, most)) = axis else { return Vec::new() };
        let drives = probes.iter().map(|probe| Self::along(probe, axis.2, along(axis, probe)));
        drives.filter(|drive| work(&drive.points) > IDLE * most).collect()
    }

    /// The probe on which the most work is done; `None` if no work is done on any.
    pub fn first(history: &History) -> Option<Self> {
        Self::most(&Self::all(history)).cloned()
    }

    /// The drive with the most work; ties go to the first.
    pub fn most(drives: &[Self]) -> Option<&Self> {
        let of = |drive: &Self| work(&drive.points);
        drives.iter().reduce(|a, b| if of(b) > of(a) { b } else { a })
    }

    fn along(probe: &str, directions: [&'static str; 2], mut points: Vec<TestPoint>) -> Self {
        let farthest = points
            .iter()
            .map(|p| p.motion)
            .fold(0.0, |far: f64, motion| if motion.abs() > far.abs() { motion } else { far });
        let is_back = farthest < 0.0;
        if is_back {
            for point in &mut points {
                (point.motion, point.force) = (0.0 - point.motion, 0.0 - point.force);
            }
        }
        let direction = directions[usize::from(is_back)];
        Self { probe: probe.to_owned(), direction, points }
    }

    /// Whether motion is rotation, and force moment.
    pub fn turns(&self) -> bool {
        self.direction.ends_with("clockwise")
    }

    /// The first point with the maximum force; `None` if no force resists the motion.
    pub fn peak(&self) -> Option<TestPoint> {
        let higher = |a: TestPoint, b: TestPoint| if b.force > a.force { b } else { a };
        self.points.iter().copied().reduce(higher).filter(|peak| peak.force > 0.0)
    }
}

/// The peak of the force of a run without a stress, as `run.json` holds it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PeakForce {
    /// The probe on which the most work is done.
    pub probe: String,
    /// Direction of its motion.
    pub direction: &'static str,
    /// Increment of the peak.
    pub increment: u64,
    /// Force and displacement there, or moment and rotation of a probe that turns.
    #[serde(flatten)]
    pub at: Peak,
}

/// Force of the outside world and displacement since the start of the reference stage, both in the
/// direction of the motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Peak {
    /// Of a probe that moves.
    Moves {
        /// Force, N.
        force_n: f64,
        /// Displacement, m.
        displacement_m: f64,
    },
    /// Of a probe that turns.
    Turns {
        /// Moment, N m.
        moment_nm: f64,
        /// Rotation, rad.
        rotation_rad: f64,
    },
}

impl PeakForce {
    /// The peak of a history; `None` if nothing drives the test, or if no force above `least` resists
    /// (N, and N m of a probe that turns).
    pub fn of(history: &History, least: [f64; 2]) -> Option<Self> {
        let drive = Drive::first(history)?;
        let turns = drive.turns();
        let peak = drive.peak().filter(|peak| peak.force > least[usize::from(turns)])?;
        let TestPoint { increment, motion, force } = peak;
        let at = match turns {
            false => Peak::Moves { force_n: force, displacement_m: motion },
            true => Peak::Turns { moment_nm: force, rotation_rad: motion },
        };
        Some(Self { probe: drive.probe, direction: drive.direction, increment, at })
    }

    /// The peak in a line.
    pub fn line(&self) -> String {
        let of = match self.at {
            Peak::Moves { force_n, displacement_m } => {
                format!("force {force_n:.4e} N at a displacement of {displacement_m:.4e} m")
            }
            Peak::Turns { moment_nm, rotation_rad } => {
                format!("moment {moment_nm:.4e} N m at a rotation of {rotation_rad:.4e} rad")
            }
        };
        format!("peak {of} ({}, {})", self.probe, self.direction)
    }
}

/// Work along a path: |integral of force over motion|, trapezoidal.
fn work(points: &[TestPoint]) -> f64 {
    let piece = |w: &[TestPoint]| 0.5 * (w[0].force + w[1].force) * (w[1].motion - w[0].motion);
    points.windows(2).map(piece).sum::<f64>().abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history(text: &str) -> Result<History, std::io::Error> {
        let file = tempfile::NamedTempFile::new()?;
        std::fs::write(file.path(), text)?;
        History::read(file.path()).map_err(std::io::Error::other)
    }

    /// A beam that is pressed down: its force is largest, and not smallest, at the peak.
    #[test]
    fn motion_and_force_of_a_probe_count_in_the_direction_of_its_motion() -> std::io::Result<()> {
        let rows = "increment,stage,a.x_m,a.y_m,a.force_x_n,a.force_y_n,b.x_m,b.y_m,b.force_x_n,\
                    b.force_y_n\n\
                    4,bend,0,-0.5,0,-10,0,0,0,5\n5,bend,0,-1,0,-30,0,0,0,15\n\
                    6,bend,0,-1.5,0,-2,0,0,0,1\n";
        let history = history(rows)?.after(3);
        let drive = Drive::first(&history);
        let drive = drive.unwrap_or_else(|| unreachable!("work is done"));
        assert_eq!((drive.probe.as_str(), drive.direction), ("a", "-y"));
        let peak = TestPoint { increment: 5, motion: 1.0, force: 30.0 };
        assert_eq!((drive.points[1], drive.peak()), (peak, Some(peak)));
        assert_eq!(Drive::all(&history).len(), 1, "a support does no work");
        Ok(())
    }

    #[test]
    fn a_test_without_work_has_no_drive() -> std::io::Result<()> {
        let rows = "increment,stage,a.x_m,a.y_m,a.force_x_n,a.force_y_n\n1,fall,0,-1,0,0\n";
        assert_eq!(Drive::first(&history(rows)?), None);
        Ok(())
    }

    /// A wall that pushed loose grains had "a peak force of 9.9e-14 N" beside contact forces of 1 N.
    #[test]
    fn round_off_is_no_peak() -> std::io::Result<()> {
        let rows = "increment,stage,a.x_m,a.y_m,a.force_x_n,a.force_y_n\n\
                    1,push,0,-1,0,-9.9e-14\n2,push,0,-2,0,-1e-14\n";
        let history = history(rows)?;
        let force = |peak: PeakForce| match peak.at {
            Peak::Moves { force_n, .. } => Some(force_n),
            Peak::Turns { .. } => None,
        };
        let peak = |least| PeakForce::of(&history, [least, 0.0]).and_then(force);
        assert_eq!((peak(0.0), peak(1e-9)), (Some(9.9e-14), None));
        Ok(())
    }
}
