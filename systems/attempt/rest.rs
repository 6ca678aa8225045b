//! Judge: is a followed motion at rest after a step, or has the specimen moved too far to find rest?
//!
//! A long step that moves little is the last one of a motion, unless the specimen is at the beginning of a
//! long way: past its limit load an arch moves little at first, and further from step to step. The
//! steps of a motion that ends shrink.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::BondRow;
use clastic_components::findings::Sliding;
use clastic_components::increment::{Acceptance, ClasticAnalysis};
use clastic_components::motion::Motion;

use super::loose_grains::{Lost, lost, may_fall};
use super::motion::{has_step, min_travel};
use crate::ending;
use crate::measures::fragments::fragments;
use crate::motion_settings::MotionSettings;
use crate::places::moves_most;
use crate::solved::{Solved, SolvedTables};
use crate::travel::furthest;
use crate::turns::{carrying, centre_of_curve, is_imposed};

/// Ends the motion where it is at rest or finds none.
pub fn judge(
    tables: SolvedTables,
    analysis: Res<ClasticAnalysis>,
    acceptance: Res<Acceptance>,
    settings: Res<MotionSettings>,
    mut attempt: ResMut<Attempt>,
) {
    let solved = tables.get();
    let (grain, far) = furthest(solved).unwrap_or_default();
    let Some(motion) = attempt.motion() else { return };
    let Solved { bodies, program, solution, .. } = solved;
    let is_free = motion.weight <= settings.min_weight;
    // A step is solved loosely: forces with a residual beyond the bound are in no equilibrium.
    let is_balanced = solution.residuals.worst() <= Sliding::bound(&acceptance);
    let is_slow = (is_balanced
        && motion.weight <= settings.rest_weight
        && far <= motion.length * settings.max_travel_at_rest)
        || (is_free && motion.free_steps + 1 >= settings.max_free_steps);
    let settles = settles(solved, motion);
    // Where no equilibrium was found at the rest of another motion, there is a long way to go.
    let at_rest = is_slow && (settles || attempt.motions == 1);
    let travelled = motion.travelled + far;
    let is_idle =
        at_rest && settles && !motion.released && travelled <= min_travel(&acceptance, &settings);
    if is_idle && attempt.is_proved {
        // What moves in the proved mechanism is no grain, but a gate that nothing touches.
        attempt.verdict = Verdict::GivesWay("the followed motion moves no grain".to_owned());
        return;
    }
    let limit = travel_to_rest(solved, grain, travelled, &settings);
    if at_rest || travelled <= limit {
        attempt.verdict = if at_rest { Verdict::AtRest } else { Verdict::Moving };
        // Another motion from here would move as little.
        if is_idle {
            attempt.motions = settings.max_motions;
        }
        return;
    }
    let most = moves_most(bodies, program, &solution.displacements);
    let gives_way = format!(
        "the motion under constant loads does not come to rest: its furthest grains travelled more \
         than {limit:.0} radii in {} steps{}",
        motion.steps + 1,
        most.map_or(String::new(), |most| format!(" ({most})"))
    );
    let goes_on = has_step(&attempt, &acceptance, &settings) && may_fall(travelled, &settings);
    attempt.verdict = match lost(solved, analysis.gravity, goes_on) {
        Lost::Specimen => Verdict::GivesWay(gives_way),
        Lost::Falling => Verdict::Moving,
        Lost::Grains(grains) => {
            attempt.left = grains;
            Verdict::AtRest
        }
    };
}

/// Travel in which a motion has to come to rest, radii, where `grain` moves furthest. What hangs, as a rigid
/// group or by bonds, may turn by half a turn, and what lies in a bowl may roll through half of it.
fn travel_to_rest(solved: Solved, grain: usize, travelled: f64, settings: &MotionSettings) -> f64 {
    let bodies = solved.bodies;
    let within =
        |extent: f64| settings.travel_to_rest + std::f64::consts::PI * extent / bodies.mean_radius;
    let of_groups = bodies.groups.iter().map(|group| group.extent).fold(0.0, f64::max);
    if travelled <= within(of_groups) {
        return within(of_groups);
    }
    let fragments = fragments(bodies);
    let moves = |i: usize| fragments.get(i) == Some(&fragments[grain]);
    let touched = solved.contacts.0.iter().filter(|contact| moves(contact.a as usize));
    let bowls = touched.filter_map(|contact| centre_of_curve(bodies, contact));
    let of_bowls = bowls.map(DVec2::length).fold(0.0, f64::max);
    within(of_groups.max(of_bowls).max(tether(solved, moves)))
}

/// Maximum distance between two particles of a fragment, the first one that is held or bonded to a held wall
/// and another, m; 0 if nothing holds it.
fn tether(solved: Solved, moves: impl Fn(usize) -> bool) -> f64 {
    let Solved { bodies, program, .. } = solved;
    let members = || (0..bodies.particles).filter(|i| moves(*i));
    // A wall under a force moves with what it is bonded to.
    let stands = |wall: usize| !program.bodies[wall].free().any(|(k, _)| k < 2);
    let is_on = |bond: &BondRow, i: usize| {
        let other = bond.b as usize;
        bond.a as usize == i && other >= bodies.particles && stands(other)
    };
    let holds = |i: &usize| is_imposed(bodies, *i) || bodies.bonds.iter().any(|b| is_on(b, *i));
    let from = members().find(holds).map(|i| bodies.positions[i]);
    from.map_or(0.0, |from| {
        members().map(|i| bodies.positions[i].distance(from)).fold(0.0, f64::max)
    })
}

/// Part of the step before to which a step shrinks that leads to an equilibrium.
const SHRINKS: f64 = 0.5;

/// Whether the steps of the bodies that carry load shrink, so that they lead to an equilibrium. Only elastic
/// bodies snap. Where contacts slide, the steps follow no geometric series and are not compared.
fn settles(solved: Solved, motion: &Motion) -> bool {
    let Solved { bodies, program, solution, .. } = solved;
    let carrying = carrying(solution);
    let mut loaded = program.interactions.iter().zip(&carrying).filter(|(_, carries)| **carries);
    let step = loaded_step(solved);
    motion.released
        || step <= ending::NO_MOTION * bodies.mean_radius
        || step <= SHRINKS * motion.step
        || loaded.any(|(c, _)| c.normal_compliance == 0.0)
        || !ending::is_elastic(program, solution, &carrying)
}

/// Maximum motion of a body that carries load, m.
pub(super) fn loaded_step(solved: Solved) -> f64 {
    ending::Motion::of(solved, &carrying(solved.solution), true).size()
}
