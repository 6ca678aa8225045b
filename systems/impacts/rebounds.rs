//! Rebounds: impacts of rigid contacts with restitution, and the offsets that make them rebound.
//!
//! With restitution, velocities are those of theta = 1. The displacement of the program is
//! `u = v dt`, with v the velocity at the end, and an offset g bounds the closing speed w at the
//! end, `w <= g/dt`. Newton's law of restitution at the velocity level (Moreau 1988) is therefore
//! an offset. With the restitution e of the contact, the closing speed w_0 at the start, and the
//! closing acceleration a by the loads of the two bodies:
//!
//! | contact | bound of the closing speed w at the end |
//! |---|---|
//! | hit at the time t, by bodies that touch nothing else | `-(e w_t - a (dt - t))`, w_t the speed
//! then |
//! | not hit, by bodies that touch nothing else | none |
//! | hit where one of the bodies touches others, or as a result of another impact | `-e w_0` |
//! | separating at the start | `max(g_0/dt, e \|w_0\|)` |
//! | any other | `g_0/dt` |
//!
//! The third and fourth row hold if `e |w_0| > a_p dt`, with a_p the part of a by which each body
//! is loaded towards the other. If the loads reverse the separation before the step ends, the
//! contact stays closed instead. A grain thus comes to rest under gravity without a threshold on
//! its speed. The first row likewise holds only if its bracket is positive.
//!
//! Contacts that separate may approach as fast as Newton's law allows, so that bodies between walls
//! always have the solution `v = -e v_0`. With the displacement `dt (v + e v_0)/(1 + e)` neither
//! these contacts nor those with an impact overlap; see [`paths`](crate::impacts::paths).

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;
use clastic_cone::program::ConeProgram;

use super::hits::{Approach, Motion};
use super::push_out::{overlaps, residual_overlap};
use crate::contact_laws::Laws;

/// Run condition: contacts have restitution in this stage.
pub fn has_restitution(analysis: Res<ClasticAnalysis>) -> bool {
    analysis.path_theta.is_some() && matches!(analysis.kind, AnalysisKind::Dynamic { .. })
}

/// Sets offset and geometry of contacts with an impact, and fills [`Impacts`].
pub(crate) fn assemble_rebounds(
    bodies: Res<BodyTable>,
    contacts: Res<ContactTable>,
    materials: Res<Materials>,
    analysis: Res<ClasticAnalysis>,
    acceptance: Res<Acceptance>,
    progress: Res<ClasticProgress>,
    (pushed, reached): (Res<Pushed>, Res<Reached>),
    mut program: ResMut<ConeProgram>,
    mut impacts: ResMut<Impacts>,
) {
    impacts.single.clear();
    impacts.hit.clear();
    impacts.end_share = 0.0;
    let AnalysisKind::Dynamic { dt: whole, .. } = analysis.kind else { return };
    let dt = whole * progress.fraction;
    if pushed.0.is_none() && overlaps(&acceptance, &bodies, &contacts, &program) {
        // This solution removes overlaps. The next one determines the velocities.
        impacts.end_share = 1.0;
        return;
    }
    let motion = |i| Motion::of(&bodies, &program, [dt, whole], i);
    let motions: Vec<_> = (0..bodies.positions.len()).map(motion).collect();
    let pairs = || contacts.0.iter().zip(&program.interactions);
    let approaches: Vec<_> =
        pairs().map(|(contact, c)| Approach::of(&motions, contact, c)).collect();
    // Number of other bodies that each body touches or would close to.
    let touch = residual_overlap(&acceptance, &bodies);
    let near: Vec<_> = pairs()
        .zip(&approaches)
        .map(|((contact, c), approach)| {
            let closes = approach.is_none_or(|x| x.free_closing(dt) > x.gap || x.hit(dt).is_some());
            let is_reached = reached.speed((contact.a, contact.b)).is_some();
            c.limits.has_strength() || contact.gap <= touch || closes || is_reached
        })
        .collect();
    let mut touched = vec![0_u32; bodies.positions.len()];
    for ((_, c), _) in pairs().zip(&near).filter(|(_, near)| **near) {
        touched[c.a as usize] += 1;
        touched[c.b as usize] += 1;
    }
    let laws = Laws { bodies: &bodies, materials: &materials, analysis: &analysis };
    let ConeProgram { bodies: rows, interactions, .. } = &mut *program;
    for (k, (contact, c)) in contacts.0.iter().zip(interactions).enumerate() {
        let is_free = |body: u32| rows[body as usize].is_free();
        let Some(x) = approaches[k].filter(|_| is_free(c.a) || is_free(c.b)) else { continue };
        let pair = (contact.a, contact.b);
        let e = laws.contact(contact).restitution * reached.factor(pair);
        if c.normal_compliance > 0.0 || c.limits.has_strength() || e == 0.0 {
            continue;
        }
        let own = u32::from(near[k]);
        // A group moves on no parabola: its impacts are those of bodies that touch others.
        let is_group = |body: u32| body as usize >= bodies.first_group();
        let is_alone =
            |body: u32| !is_group(body) && (!is_free(body) || touched[body as usize] == own);
        let free_closing = x.free_closing(dt);
        let alone = is_alone(c.a) && is_alone(c.b);
        if alone && let Some(hit) = x.impact(&bodies, &motions, (contact, c), dt) {
            let rebound = e * hit.speed - hit.acceleration * (dt - hit.time);
            if rebound > 0.0 {
                c.offset = -rebound * dt;
                c.normal = hit.normal;
                c.arm_a = bodies.radii[c.a as usize];
                c.arm_b = bodies.radii.get(c.b as usize).copied().unwrap_or(0.0);
                impacts.single.push(Impact { interaction: k, time: hit.time });
                impacts.hit.push(k);
            }
        } else if alone && free_closing > c.offset && (contact.gap > touch || x.speed < 0.0) {
            // The bodies miss each other, or meet after the step, while `v dt` would have them meet
            // within it.
            c.offset = free_closing;
            impacts.single.push(Impact { interaction: k, time: dt });
        } else {
            let closing = reached.speed(pair);
            let is_hit = closing.is_some() || x.speed > 0.0 && free_closing > x.gap;
            let rebounds = e * closing.unwrap_or(x.speed.abs()) > x.pressing * dt;
            if rebounds && (is_hit || x.speed < 0.0) {
                let rebound = -e * x.speed * dt;
                c.offset = if is_hit { rebound } else { c.offset.max(rebound) };
                impacts.end_share = impacts.end_share.max(1.0 / (1.0 + e));
            }
            if rebounds && is_hit {
                impacts.hit.push(k);
            }
        }
    }
    if impacts.end_share == 0.0 {
        impacts.end_share = 1.0;
    }
}
