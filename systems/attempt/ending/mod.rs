//! Judge: is the solution an equilibrium where the increment ends?
//!
//! The program has the geometry of the start. Its forces balance there, but the bodies are elsewhere
//! when the increment ends. The increment is therefore solved again with the [`geometry`]
//! about a guess of its end, until the end has no force out of balance by more than
//! `MAX_IMBALANCE` of the maximum, and another pass would move no body by more than
//! `MAX_IDLE_MOTION` of the motion of the increment.
//!
//! The second condition is the one that tells the error of the motion. Near a buckling load a force
//! of 1e-7 of the maximum moves bodies by half of their motion, and in a stiff cantilever one of five
//! times the maximum moves them by a thousandth. Before the first pass the idle motion is the linear
//! response of the solution to what is out of balance. With a growth g from pass to pass, all further
//! passes together move 1/(1 - g) times as much. From g = 1 on the equilibrium that the passes would
//! find is not stable, and they end. Where contacts slide, the forces depend on the
//! path as much as on the end, the next increment begins with what was out of balance, and the first
//! condition alone decides.
//!
//! Passes are for what guides a body over many increments: bonds, rigid groups and curved walls. The
//! contacts of loose grains last for few, and with smaller increments the peaks of sand did not come
//! closer to those with passes. There the out-of-balance force is recorded.

mod energy;
pub mod geometry;
mod mixing;

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::{Bodies, Contacts, WallRow};
use clastic_components::findings::{Corrections, Guesses};
use clastic_components::increment::{Analysis, AnalysisKind};
use clastic_components::wall_shape::WallShape;
use clastic_cone::condensed::response::LinearResponse;
use clastic_cone::program::{ConeProgram, ConeSolution};
use clastic_cone::residuals::{Carrying, force_scale};

use self::geometry::{Ending, Increment};
use super::places::digits;
use crate::turns::{furthest, of_bonded};

/// Maximum out-of-balance force at the end over the maximum force where nothing slides.
const MAX_IMBALANCE: f64 = 1e-3;
/// The same where contacts slide. At 1e-2 passes take a tenth more time in sand, and peaks do not come
/// closer to those of smaller increments.
const MAX_IMBALANCE_OF_SLIDING: f64 = 5e-2;
/// Maximum idle motion over the motion of the increment.
const MAX_IDLE_MOTION: f64 = 1e-3;
/// Motion, mean radii, that is no error whatever the motion of the increment is.
const NO_MOTION: f64 = 1e-6;
/// Part of the last maximum force that the maximum force counts as at least: a specimen that is
/// unloaded has forces of round-off.
const LAST_FORCE: f64 = 1e-3;
/// Maximum turn of a contact, rad, from which a solution says where the increment ends.
const MAX_TURN: f64 = 2.0;
/// Maximum growth of an idle motion that is judged before the first pass.
const MAX_FIRST_GROWTH: f64 = 0.9;
/// Maximum number of passes.
const MAX_PASSES: u32 = 20;
/// Maximum number of passes in which the error does not fall to [`PROGRESS`] of its minimum.
const MAX_STALLED: u32 = 3;
/// Part of the error to which a pass with progress reduces it.
const PROGRESS: f64 = 0.7;

/// Factor of the stiffness at the last solution.
#[derive(Resource, Default)]
pub struct Stiffness(LinearResponse);

/// Requests another pass until the end of the increment is in equilibrium.
pub fn judge(
    analysis: Res<Analysis>,
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    mut stiffness: ResMut<Stiffness>,
    mut state: ResMut<Corrections>,
    mut attempt: ResMut<Attempt>,
) {
    let place = match analysis.kind {
        AnalysisKind::Static => 1.0,
        AnalysisKind::Dynamic { theta, .. } => 1.0 - theta,
        AnalysisKind::Compaction { .. } => return,
    };
    let is_static = analysis.kind == AnalysisKind::Static;
    let state = &mut *state;
    let far = furthest(&bodies, &contacts, &program, &solution);
    let at_rest =
        largest(&solution.displacements, bodies.mean_radius) <= NO_MOTION * bodies.mean_radius;
    // Impacts with restitution have normals and offsets of their own.
    if !is_static && (at_rest || analysis.path_theta.is_some()) {
        return;
    }
    if is_static && far.is_some_and(|(_, turn)| !(turn <= MAX_TURN)) {
        return;
    }
    let increment = Increment { bodies: &bodies, contacts: &contacts, program: &program, place };
    let ending = increment.ending(&solution, state);
    let last = LAST_FORCE * force_scale(&program, &program.last_forces);
    let unit = force_scale(&program, &solution.forces).max(last);
    state.imbalance = if ending.imbalance > 0.0 { ending.imbalance / unit } else { 0.0 };
    let guides = |wall: &WallRow| match wall.shape {
        WallShape::Arc { .. } => true,
        WallShape::Segment => is_static,
        WallShape::Line => false,
    };
    let is_guided =
        program.has_bonds() || !bodies.groups.is_empty() || bodies.walls.iter().any(guides);
    if !is_guided || state.capped {
        return;
    }
    let (u, radius) = (&solution.displacements, bodies.mean_radius);
    let (mut idle, mut is_stable) = (Vec::new(), true);
    let error = if !is_static {
        energy::error(&program, &solution, &ending, unit * radius)
    } else if !is_elastic(&program, &solution) {
        state.idle_motion = None;
        state.imbalance / MAX_IMBALANCE_OF_SLIDING
    } else {
        let growth;
        (idle, growth) =
            idle_motion(&increment, &solution, &ending, &state.guesses, &mut stiffness);
        is_stable = growth < 1.0;
        let all = if is_stable { (growth / (1.0 - growth)).max(1.0) } else { 1.0 };
        let relative = all * relative(&idle, u, radius);
        state.idle_motion = Some(relative);
        (state.imbalance / MAX_IMBALANCE).max(relative / MAX_IDLE_MOTION)
    };
    if error <= 1.0 {
        return;
    }
    let guesses = &mut state.guesses;
    if state.passes == 0 {
        guesses.best = f64::INFINITY;
    }
    guesses.stalled = if error < PROGRESS * guesses.best { 0 } else { guesses.stalled + 1 };
    guesses.best = guesses.best.min(error);
    if !is_stable || state.passes >= MAX_PASSES || guesses.stalled > MAX_STALLED {
        if state.imbalance <= MAX_IMBALANCE_OF_SLIDING {
            return;
        }
        if is_elastic(&program, &solution) && attempt.halved_turn.is_none() {
            attempt.turn = far.and_then(|far| of_bonded(&bodies, far));
            attempt.verdict = Verdict::TooFar(format!(
                "the end of the increment is out of balance by {} of the maximum force, and passes \
                 about it do not converge",
                digits(state.imbalance)
            ));
        } else {
            // The solution of the first program is the best that there is.
            *state = Corrections { capped: true, ..Corrections::default() };
            attempt.verdict = Verdict::Again;
        }
        return;
    }
    let best = (guesses.best, guesses.stalled);
    mixing::next(guesses, u, &idle, radius);
    (guesses.best, guesses.stalled) = best;
    state.list = increment.about(&state.guesses.last);
    state.passes += 1;
    attempt.verdict = Verdict::Again;
}

/// What another pass would move, and its growth from pass to pass. After a pass it is what the guess
/// missed, before the first one the linear response; empty where the stiffness has no factor.
fn idle_motion(
    Increment { bodies, program, .. }: &Increment,
    solution: &ConeSolution,
    ending: &Ending,
    guesses: &Guesses,
    stiffness: &mut Stiffness,
) -> (Vec<[f64; 3]>, f64) {
    let (u, radius) = (&solution.displacements, bodies.mean_radius);
    if guesses.last.len() == u.len() {
        let pairs = u.iter().zip(&guesses.last);
        let missed = pairs.map(|(u, v)| [0, 1, 2].map(|k| u[k] - v[k])).collect();
        return (missed, mixing::growth(guesses, u, radius));
    }
    let Ending { loads, misfits, .. } = ending;
    let idle = stiffness.0.to(program, solution, loads, misfits).unwrap_or_default();
    let squared = mixing::dot(u, u, radius);
    let growth = if squared > 0.0 { mixing::dot(&idle, u, radius) / squared } else { 0.0 };
    // The response is only a first order: a pass decides whether the end is stable.
    (idle, growth.min(MAX_FIRST_GROWTH))
}

/// An idle motion over that of the increment.
fn relative(idle: &[[f64; 3]], u: &[[f64; 3]], radius: f64) -> f64 {
    let size = if idle.is_empty() { f64::INFINITY } else { largest(idle, radius) };
    if size <= NO_MOTION * radius { 0.0 } else { size / largest(u, radius) }
}

/// Whether the end alone determines the forces: no contact slides.
fn is_elastic(program: &ConeProgram, solution: &ConeSolution) -> bool {
    let carrying = Carrying::new(program, solution);
    let mut forces = program.interactions.iter().zip(&solution.forces).enumerate();
    let slides = forces.any(|(k, (c, f))| {
        !c.limits.has_strength() && carrying.is_carrying(k) && c.limits.slides(f)
    });
    !slides
}

/// Maximum motion of a body, m. A rotation counts with the length `radius`, m.
fn largest(u: &[[f64; 3]], radius: f64) -> f64 {
    u.iter().map(|u| u[0].hypot(u[1]).max(radius * u[2].abs())).fold(0.0, f64::max)
}
