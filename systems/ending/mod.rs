//! Judge: is the solution an equilibrium where the increment ends?
//!
//! The program has the geometry of the start. Its forces balance there, but the bodies are
//! elsewhere when the increment ends. The increment is therefore solved again with the [`geometry`]
//! about a guess of its end, which is called a pass, until the end has no force out of balance by
//! more than `MAX_IMBALANCE` of the maximum, and another pass would move no body by more than
//! `MAX_IDLE_MOTION` of the motion of the increment.
//!
//! Only the second condition measures the error of the motion. Near a buckling load a force of 1e-7
//! of the maximum moves bodies by half of their motion, and in a stiff cantilever one of five times
//! the maximum moves them by a thousandth. Before the first pass the idle motion is the linear
//! response of the solution to what is out of balance. With a growth g from pass to pass, all
//! further passes together move 1/(1 - g) times as much. From g = 1 on the equilibrium that the
//! passes would find is not stable, and they leave it for one that is, as a column that buckles. No
//! step between guesses turns a bond or a loaded contact further than one solution may. Where
//! contacts slide, the forces depend on the path as much as on the end, the next increment begins
//! with what was out of balance, and the first condition alone decides.
//!
//! In statics, passes are for what guides a body over many increments: elastic bonds, rigid ones from
//! which something hangs, rigid groups and curved walls. The contacts of loose grains last for few, and with smaller increments the peaks of sand did not
//! come closer to those with passes. There the out-of-balance force is recorded. In time steps with
//! theta < 1 passes also are for elastic contacts, since they keep the energy of an impact, and for rigid
//! bonds, which gain energy where they turn with the normals of the start.

mod energy;
pub mod geometry;
mod mixing;

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use clastic_components::prelude::*;
use clastic_cone::condensed::response::LinearResponse;
use clastic_cone::program::{ConeProgram, ConeSolution, Interaction, ProgramBody};
use clastic_cone::residuals::force_scale;

use self::geometry::{Ending, Increment};
use crate::assemble_program::scales::determined_force;
use crate::places::digits;
use crate::solved::{Solved, SolvedTables};
use crate::turns::{carrying, furthest, of_bonded, of_loaded};

/// Maximum out-of-balance force at the end over the maximum force where nothing slides.
const MAX_IMBALANCE: f64 = 1e-3;
/// Maximum out-of-balance force where contacts slide. At 1e-2 passes take a tenth more time in
/// sand, and peaks do not come closer to those of smaller increments.
const MAX_IMBALANCE_OF_SLIDING: f64 = 5e-2;
/// Maximum idle motion over the motion of the increment.
const MAX_IDLE_MOTION: f64 = 1e-3;
/// Motion, mean radii, that is no error whatever the motion of the increment is.
pub(crate) const NO_MOTION: f64 = 1e-6;
/// Stretch of a bond by the maximum force over the motion of the increment, below which the specimen
/// moves almost as rigid bodies.
const FREE: f64 = 1e-3;
/// Minimum of the maximum force, over that of the last increment: the forces of a specimen that is
/// unloaded are round-off.
const LAST_FORCE: f64 = 1e-3;
/// Maximum turn of a contact, rad, from which a solution says where the increment ends.
const MAX_TURN: f64 = 2.0;
/// Maximum number of passes. Columns at up to twice their buckling load take 40 in one increment.
const MAX_PASSES: u32 = 60;
/// Maximum number of passes in which the error does not fall to [`PROGRESS`] of its minimum.
const MAX_STALLED: u32 = 3;
/// Factor by which a pass must reduce the error to count as progress.
const PROGRESS: f64 = 0.7;

/// Factor of the stiffness at the last solution.
#[derive(Resource, Default)]
pub struct Stiffness(LinearResponse);

/// Tables of the increment.
#[derive(SystemParam)]
pub struct Tables<'w> {
    acceptance: Res<'w, Acceptance>,
    analysis: Res<'w, ClasticAnalysis>,
    progress: Res<'w, ClasticProgress>,
    solved: SolvedTables<'w>,
}

/// Requests another pass until the end of the increment is in equilibrium.
pub fn judge(
    tables: Tables,
    mut stiffness: ResMut<Stiffness>,
    mut state: ResMut<Corrections>,
    mut attempt: ResMut<Attempt>,
) {
    let solved = tables.solved.get();
    let Solved { bodies, program, solution, .. } = solved;
    let state = &mut *state;
    let is_followed = state.idle_motion.is_some();
    let far = furthest(solved, is_followed);
    let Some(increment) = tables.increment(far) else { return };
    let is_static = tables.is_static();
    let counts = tables.counting();
    let ending = increment.ending(state, &counts);
    let last = LAST_FORCE * force_scale(program, &program.last_forces);
    let listed = &program.interactions[..solved.contacts.0.len()];
    let determined = determined_force(bodies, program, listed, 0.0);
    let unit = force_scale(program, &solution.forces).max(last).min(determined);
    state.imbalance = if ending.imbalance > 0.0 { ending.imbalance / unit } else { 0.0 };
    // Without a pass the geometry is that of the start, where a specimen at rest still is. All its
    // forces may be round-off, and so would be an imbalance over them.
    let has_stayed = state.passes == 0 && tables.is_at_rest();
    // Something hangs on rigid bonds and nothing else.
    let hangs = determined.is_finite() && program.has_bonds();
    if !(tables.is_guided() || hangs) || state.capped || has_stayed {
        return;
    }
    let motion = Motion::of(solved, &counts, is_static);
    let is_elastic = is_elastic(program, solution, &counts);
    let (idle, growth) = if is_elastic || !is_static {
        motion.idle(solved, &ending, &state.guesses, &mut stiffness)
    } else {
        (Vec::new(), 0.0)
    };
    // A time step has no other end to go to.
    let growth = if is_static { growth } else { 0.0 };
    let keeps_energy = tables.keeps_energy();
    let mut is_lost = is_static || !(state.imbalance <= MAX_IMBALANCE_OF_SLIDING);
    let error = if !is_static {
        let work = unit * bodies.mean_radius;
        let [error, over] = energy::errors(solved, &ending, work);
        if keeps_energy {
            is_lost = over > 1.0;
        }
        error
    } else if is_elastic {
        let idle = motion.over_own(&idle, growth);
        state.idle_motion = Some(idle);
        (state.imbalance / MAX_IMBALANCE).max(idle / MAX_IDLE_MOTION)
    } else {
        state.idle_motion = None;
        state.imbalance / MAX_IMBALANCE_OF_SLIDING
    };
    if error <= 1.0 {
        return;
    }
    state.needed = is_elastic || keeps_energy;
    let makes_way = growth >= 1.0 || state.guesses.makes_way(error, PROGRESS, MAX_STALLED);
    if makes_way && state.passes < MAX_PASSES {
        let guesses = &mut state.guesses;
        mixing::next(guesses, &motion.own, &idle, growth, bodies.mean_radius);
        if is_elastic {
            let displacements = motion.with_others(&guesses.last, solution);
            let end = ConeSolution { displacements, ..solution.clone() };
            let over = of_loaded(Solved { solution: &end, ..solved }) / tables.acceptance.turn;
            if over > 1.0 {
                mixing::shorten(guesses, 1.0 / over);
            }
        }
        let guess = motion.with_others(&guesses.last, solution);
        state.list = increment.about(&guess, &state.guesses.last);
        state.passes += 1;
        attempt.verdict = Verdict::Again;
    } else if is_lost {
        attempt.turn = far.and_then(|far| of_bonded(bodies, far));
        let why = if keeps_energy {
            let help = "a smaller `dt` resolves contacts and turns, `theta: 1.0` takes energy";
            format!("its energy would not stay; {help}")
        } else {
            format!("it is out of balance by {} of the maximum force", digits(state.imbalance))
        };
        attempt.verdict = fail(state, &why);
    }
}

/// What follows where passes find no end. Where they are not needed, as contacts slide, it is the
/// solution with the geometry of the start, marked in the history: the next increment begins with
/// what is out of balance.
pub fn fail(state: &mut Corrections, why: &str) -> Verdict {
    if state.needed {
        return Verdict::TooFar(format!(
            "passes about the end of the increment do not converge: {why}"
        ));
    }
    *state = Corrections { capped: true, ..Corrections::default() };
    Verdict::Again
}

impl Tables<'_> {
    /// The increment with the place of its geometry, if its end is judged.
    fn increment(&self, far: Option<(usize, f64)>) -> Option<Increment<'_>> {
        // Impacts with restitution have normals and offsets of their own.
        let has_restitution = self.analysis.path_theta.is_some();
        let theta = match self.analysis.kind {
            AnalysisKind::Static if far.is_none_or(|(_, turn)| turn <= MAX_TURN) => None,
            AnalysisKind::Dynamic { theta, .. } if !has_restitution && !self.is_at_rest() => {
                Some(theta)
            }
            _ => return None,
        };
        let (fraction, gravity) = (self.progress.fraction, self.analysis.gravity);
        Some(Increment { solved: self.solved.get(), theta, fraction, gravity })
    }

    /// Which interactions the end is judged by: those that carry load, and in time steps all bonds. In
    /// statics a bond without load is mostly that of a loose grain, whose place depends on the weight
    /// that regularises it. It counts where the specimen moves almost without force: where the maximum
    /// force stretches the bond by less than [`FREE`] of the motion.
    fn counting(&self) -> Vec<bool> {
        let Solved { bodies, program, solution, .. } = self.solved.get();
        let maximum = force_scale(program, &solution.forces);
        let motion = largest(&solution.displacements, bodies.mean_radius);
        let is_free = |c: &Interaction| maximum * c.normal_compliance < FREE * motion;
        let interactions = program.interactions.iter().zip(carrying(solution));
        interactions
            .map(|(c, carries)| {
                let is_bond = c.limits.has_strength();
                let is_spring = c.normal_compliance > 0.0;
                carries
                    || if self.is_static() { is_bond && is_free(c) } else { is_bond || is_spring }
            })
            .collect()
    }

    /// Whether the increment ends where it began.
    fn is_at_rest(&self) -> bool {
        let Solved { bodies, solution, .. } = self.solved.get();
        let radius = bodies.mean_radius;
        largest(&solution.displacements, radius) <= NO_MOTION * radius
    }

    fn is_static(&self) -> bool {
        self.analysis.kind == AnalysisKind::Static
    }

    /// Whether a time step must keep the energy: theta = 1 dissipates more than the geometry of the
    /// start does wrongly.
    fn keeps_energy(&self) -> bool {
        matches!(self.analysis.kind, AnalysisKind::Dynamic { theta, .. } if theta < 1.0)
    }

    /// Whether something guides bodies over many increments.
    fn is_guided(&self) -> bool {
        let is_static = self.is_static();
        let guides = |wall: &WallRow| match wall.shape {
            WallShape::Arc { .. } => true,
            WallShape::Segment => is_static,
            WallShape::Line => false,
        };
        let Solved { bodies, program, .. } = self.solved.get();
        let keeps_energy = self.keeps_energy();
        let mut all = program.interactions.iter();
        all.any(|c| {
            let (is_bond, is_spring) = (c.limits.has_strength(), c.normal_compliance > 0.0);
            // A tie is a bond and a spring.
            if keeps_energy { is_bond || is_spring } else { is_bond && is_spring }
        }) || !bodies.groups.is_empty()
            || bodies.walls.iter().any(guides)
    }
}

/// The motion of the bodies that carry load. The motion of a loose grain depends on the weight that
/// regularises it, and is no motion of the specimen.
pub(crate) struct Motion {
    /// Whether a body carries load.
    loaded: Vec<bool>,
    /// Displacements, m and rad, by body in its own axes; zero without load.
    own: Vec<[f64; 3]>,
    /// Mean radius, m, with which rotations count.
    radius: f64,
}

impl Motion {
    pub(crate) fn of(
        Solved { bodies, program, solution, .. }: Solved,
        counts: &[bool],
        is_static: bool,
    ) -> Self {
        // In statics a rigid group that its weight turns back has an inertia.
        let has_inertia = |body: &ProgramBody| body.free().any(|(_, free)| free.inertia > 0.0);
        let is_turned = |body| is_static && has_inertia(body);
        let mut loaded: Vec<bool> = program.bodies.iter().map(is_turned).collect();
        for (c, counts) in program.interactions.iter().zip(counts) {
            if *counts {
                (loaded[c.a as usize], loaded[c.b as usize]) = (true, true);
            }
        }
        let mut motion = Self { loaded, own: Vec::new(), radius: bodies.mean_radius };
        motion.own = motion.of_loaded(&solution.displacements);
        motion
    }

    /// Displacements of the bodies that carry load, zero for others.
    fn of_loaded(&self, u: &[[f64; 3]]) -> Vec<[f64; 3]> {
        u.iter().zip(&self.loaded).map(|(u, loaded)| if *loaded { *u } else { [0.0; 3] }).collect()
    }

    /// Maximum motion of a body, m.
    pub(crate) fn size(&self) -> f64 {
        largest(&self.own, self.radius)
    }

    /// What another pass would move, and its growth from pass to pass. After a pass it is what the
    /// guess missed, before the first pass the linear response; empty where the stiffness matrix
    /// cannot be factorised.
    fn idle(
        &self,
        Solved { program, solution, .. }: Solved,
        ending: &Ending,
        guesses: &Guesses,
        stiffness: &mut Stiffness,
    ) -> (Vec<[f64; 3]>, f64) {
        let Self { own, radius, .. } = self;
        if guesses.last.len() == own.len() {
            let missed = mixing::difference(own, &guesses.last);
            return (missed, mixing::growth(guesses, own, *radius));
        }
        let Ending { loads, misfits, .. } = ending;
        let idle = stiffness.0.to(program, solution, loads, misfits).unwrap_or_default();
        let idle = self.of_loaded(&idle);
        let squared = mixing::dot(own, own, *radius);
        let growth = if squared > 0.0 { mixing::dot(&idle, own, *radius) / squared } else { 0.0 };
        (idle, growth)
    }

    /// An idle motion, with those of all further passes, over the motion of the increment.
    fn over_own(&self, idle: &[[f64; 3]], growth: f64) -> f64 {
        let all = if growth < 1.0 { (growth / (1.0 - growth)).max(1.0) } else { f64::INFINITY };
        let size = if idle.is_empty() { f64::INFINITY } else { largest(idle, self.radius) };
        if size <= NO_MOTION * self.radius { 0.0 } else { all * size / self.size() }
    }

    /// A guess of all displacements; for bodies without load those of the solution.
    fn with_others(&self, guess: &[[f64; 3]], solution: &ConeSolution) -> Vec<[f64; 3]> {
        let all = guess.iter().zip(&solution.displacements).zip(&self.loaded);
        all.map(|((guess, u), loaded)| if *loaded { *guess } else { *u }).collect()
    }
}

/// Whether the end alone determines the forces: no contact that carries load slides.
pub(crate) fn is_elastic(program: &ConeProgram, solution: &ConeSolution, counts: &[bool]) -> bool {
    let mut forces = program.interactions.iter().zip(&solution.forces).zip(counts);
    !forces.any(|((c, f), counts)| *counts && !c.limits.has_strength() && c.limits.slides(f))
}

/// Maximum motion of a body, m. A rotation counts with the length `radius`, m.
fn largest(u: &[[f64; 3]], radius: f64) -> f64 {
    u.iter().map(|u| u[0].hypot(u[1]).max(radius * u[2].abs())).fold(0.0, f64::max)
}
