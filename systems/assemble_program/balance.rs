//! Balance rows of the program: unknown degrees of freedom, their loads and their inertia.
//!
//! Theta-method (equations 2 to 4 of the paper):
//! `m/(theta dt^2) u + G f = f_ext + m/(theta dt^2) v_0 dt`. A degree of freedom without
//! interactions needs no row, because its motion is known in advance.

use glam::DVec2;

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, Dof, FreeDof, ProgramBody};

use super::Trial;
use super::groups::{Turning, turning};

/// A body that does not move.
const STILL: ProgramBody = ProgramBody { axis: DVec2::X, dofs: [Dof::Fixed(0.0); 3] };

/// Fills the bodies of the program, one per row.
pub(super) fn assemble(trial: &Trial, program: &mut ConeProgram) {
    let rows = Rows::new(trial, program);
    let bodies = rows.bodies;
    let out = &mut program.bodies;
    out.clear();
    out.extend((0..bodies.particles).map(|i| rows.particle(i)));
    out.resize(bodies.positions.len(), STILL);
    for group in &bodies.groups {
        // Interactions act on the group.
        group.members.iter().for_each(|member| out[*member as usize] = STILL);
        out[group.body as usize] = rows.group(group);
    }
    for wall in bodies.walls.iter().filter(|wall| bodies.group(wall.body as usize).is_none()) {
        out[wall.body as usize] = rows.wall(wall);
    }
    out.extend(bodies.cell.map(|cell| rows.cell(&cell)));
}

/// What the rows of the bodies follow from.
pub(super) struct Rows<'a> {
    pub bodies: &'a BodyTable,
    pub analysis: &'a ClasticAnalysis,
    pub progress: &'a ClasticProgress,
    /// Loads of an embedding program by row; empty without any.
    added: Vec<[AddedLoad; 3]>,
    /// Whether interactions act on the (translation, rotation) of a body.
    touched: Vec<(bool, bool)>,
    affine: Option<Affine>,
    /// How rigid groups turn in statics; empty otherwise.
    pub turning: Vec<Turning<'a>>,
}

impl<'a> Rows<'a> {
    fn new(trial: &'a Trial, program: &ConeProgram) -> Self {
        let Trial { bodies, contacts, loads, progress, analysis, corrections, .. } = trial;
        let mut touched = vec![(false, false); bodies.positions.len()];
        for c in &program.interactions {
            let turns = c.limits.has_shear() || c.limits.has_rolling();
            for (body, normal_arm) in [(c.a, c.normal_arm_a), (c.b, c.normal_arm_b)] {
                let t = &mut touched[body as usize];
                *t = (true, t.1 || turns || normal_arm != 0.0);
            }
        }
        let added = if loads.is_empty() { Vec::new() } else { loads.sums(bodies) };
        let (gravity, fraction) = (analysis.gravity, progress.fraction);
        let guess = &corrections.guesses.last;
        let is_static = analysis.kind == AnalysisKind::Static;
        let turning = || turning(bodies, contacts, program, fraction, gravity, guess);
        Self {
            bodies,
            analysis,
            progress,
            added,
            touched,
            affine: Affine::of(bodies, analysis, fraction),
            turning: if is_static { turning() } else { Vec::new() },
        }
    }

    /// Loads of an embedding program on a body.
    pub fn added(&self, row: usize) -> [AddedLoad; 3] {
        self.added.get(row).copied().unwrap_or_default()
    }

    /// Mean motion of a compaction at a place, m.
    pub fn mean(&self, x: DVec2) -> DVec2 {
        self.affine.as_ref().map_or(DVec2::ZERO, |affine| affine.displacement(x))
    }

    /// A degree of freedom that no drive imposes: unknown if interactions act on it, otherwise
    /// known from its load.
    pub(crate) fn undriven(&self, row: usize, k: usize, free: FreeDof) -> Dof {
        let acted = if k < 2 { self.touched[row].0 } else { self.touched[row].1 };
        // In statics an inertia is a stiffness, and a step of a followed motion adds to it.
        let is_held = free.inertia > 0.0 && self.analysis.kind != AnalysisKind::Static;
        if acted || (!is_held && free.load != 0.0) {
            Dof::Free(free)
        } else if free.inertia > 0.0 {
            Dof::Fixed(free.load / free.inertia)
        } else {
            Dof::Fixed(0.0)
        }
    }

    /// Adds the inertia of a mass to a degree of freedom of a body in a time step.
    pub(crate) fn add_inertia(&self, row: usize, k: usize, mass: f64, free: &mut FreeDof) {
        if let AnalysisKind::Dynamic { dt, theta } = self.analysis.kind {
            let dt = dt * self.progress.fraction;
            free.inertia = mass / (theta * dt * dt);
            free.momentum = free.inertia * self.bodies.rates(row)[k] * dt;
            free.load += free.momentum;
        }
    }

    fn particle(&self, i: usize) -> ProgramBody {
        let dof = |k: usize| match self.bodies.drive(i, k) {
            BodyDrive::Imposed(u) => Dof::Fixed(self.progress.fraction * u),
            BodyDrive::Free => {
                let mut free = self.free_dof(i, k);
                free.load += self.added(i)[k].force;
                free.inertia += self.added(i)[k].stiffness;
                self.undriven(i, k, free)
            }
        };
        ProgramBody { axis: DVec2::X, dofs: [dof(0), dof(1), dof(2)] }
    }

    fn free_dof(&self, i: usize, k: usize) -> FreeDof {
        let Self { bodies, analysis, progress, .. } = *self;
        let applied = bodies.loads[i][k].at(progress.fraction);
        let mass = bodies.mass_of(i, k);
        let mut free = match analysis.kind {
            AnalysisKind::Static => {
                let weight = if k < 2 { bodies.static_weight(i, analysis.gravity)[k] } else { 0.0 };
                FreeDof { load: applied + weight, ..FreeDof::default() }
            }
            AnalysisKind::Compaction { agitation, seed, .. } => {
                let mean = if k < 2 { self.mean(bodies.positions[i])[k] } else { 0.0 };
                let shaken = shake(seed, progress.increment, bodies.ids[i].0 as usize, k);
                FreeDof { load: mean + agitation * shaken, inertia: 1.0, ..FreeDof::default() }
            }
            AnalysisKind::Dynamic { .. } => {
                let weight = if k < 2 { mass * analysis.gravity[k] } else { 0.0 };
                FreeDof { load: applied + weight, ..FreeDof::default() }
            }
        };
        self.add_inertia(i, k, mass, &mut free);
        free
    }

    fn wall(&self, wall: &WallRow) -> ProgramBody {
        let (row, fraction) = (wall.body as usize, self.progress.fraction);
        let drive = self.bodies.wall_drive(wall);
        let dofs = match drive {
            WallDrive::Imposed(u) => [
                Dof::Fixed(fraction * u.dot(wall.inward)),
                Dof::Fixed(fraction * u.dot(wall.inward.perp())),
                Dof::Fixed(0.0),
            ],
            WallDrive::Turning { about, angle } => {
                let angle = fraction * angle;
                let u = self.bodies.swing(wall, about, angle);
                [u.dot(wall.inward), u.dot(wall.inward.perp()), angle].map(Dof::Fixed)
            }
            WallDrive::Loaded(force) | WallDrive::Sliding { load: force, .. } => {
                let [x, y, _] = self.added(row).map(|load| load.force);
                let load = force.at(fraction) + wall.inward.dot(DVec2::new(x, y));
                // A loaded wall without contact stands still until the specimen touches it.
                let waits = !self.touched[row].0 && load == 0.0;
                let free = Dof::Free(FreeDof { load, ..FreeDof::default() });
                let along = if waits { Dof::Fixed(0.0) } else { free };
                // The second axis is the negative tangent.
                let slid = match drive {
                    WallDrive::Sliding { along, .. } => -fraction * along,
                    _ => 0.0,
                };
                [along, Dof::Fixed(slid), Dof::Fixed(0.0)]
            }
        };
        ProgramBody { axis: wall.inward, dofs }
    }
}

/// Deterministic number in [-1, 1) that depends on the arguments only. It is equal in every attempt
/// and after a restart. Mixing function of SplitMix64 (Steele, Lea and Flood 2014).
fn shake(seed: u64, increment: u64, body: usize, dof: usize) -> f64 {
    let mix = |mut z: u64| {
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let step = 0x9e37_79b9_7f4a_7c15_u64;
    let state = mix(mix(seed.wrapping_add(step)).wrapping_add(step.wrapping_mul(increment)));
    let bits = mix(state.wrapping_add(step.wrapping_mul(3 * body as u64 + dof as u64 + 1)));
    (bits >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Mean motion of a compaction.
enum Affine {
    /// The deformation of a periodic cell, by its displacement gradient: width, height and shear.
    Cell([f64; 3]),
    /// Linear between zero at the opposite wall, which is fixed, and `u` at the moving one.
    Walls { base: DVec2, inward: DVec2, u: DVec2, height: f64 },
}

impl Affine {
    fn of(bodies: &BodyTable, analysis: &ClasticAnalysis, fraction: f64) -> Option<Self> {
        let AnalysisKind::Compaction { affine: true, .. } = analysis.kind else { return None };
        if let Some(cell) = &bodies.cell {
            let gradient = |k: usize, length: f64| match cell.controls[k] {
                CellControl::Imposed(u) => fraction * u / length,
                CellControl::Stress { .. } => 0.0,
            };
            let along = [cell.width, cell.height, cell.height];
            return Some(Self::Cell([0, 1, 2].map(|k| gradient(k, along[k]))));
        }
        let (wall, u) = bodies.walls.iter().find_map(|wall| match wall.drive {
            WallDrive::Imposed(u) if u != DVec2::ZERO => Some((wall, fraction * u)),
            _ => None,
        })?;
        // The opposite wall is the fixed wall whose normal is closest to the opposite direction.
        let opposite = bodies
            .walls
            .iter()
            .filter(|w| w.body != wall.body && w.inward.dot(wall.inward) < -0.5)
            .min_by(|a, b| a.inward.dot(wall.inward).total_cmp(&b.inward.dot(wall.inward)))?;
        let (base, inward) = (bodies.positions[opposite.body as usize], opposite.inward);
        let height = (bodies.positions[wall.body as usize] - base).dot(inward);
        (height > 0.0).then_some(Self::Walls { base, inward, u, height })
    }

    fn displacement(&self, x: DVec2) -> DVec2 {
        match *self {
            Self::Cell([xx, yy, xy]) => DVec2::new(xx * x.x + xy * x.y, yy * x.y),
            Self::Walls { base, inward, u, height } => {
                u * ((x - base).dot(inward) / height).clamp(0.0, 1.0)
            }
        }
    }
}
