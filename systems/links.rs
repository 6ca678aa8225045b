//! Links between bodies: their state, their rows in the tables, and their interactions.

use std::cmp::Ordering;

use bevy_app::{App, Plugin};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, ConeSolution, Interaction, Limits};

use crate::assemble_program::scales::free_translations;
use crate::schedule::{AttemptIncrement, AttemptSystems, ClasticHalted};
use crate::state::{RegisterState, StateOf, despawn_if};

/// Adds the hook that turns a [`LinkBetween`] into a [`Link`], the interactions of links, and their
/// state.
pub struct LinksPlugin;

impl Plugin for LinksPlugin {
    fn build(&self, app: &mut App) {
        app.world_mut().register_component_hooks::<LinkBetween>().on_add(linked);
        app.register_state::<AllLinks>("links").add_systems(
            AttemptIncrement,
            (
                set_limits.after(AttemptSystems::Balance).before(AttemptSystems::Solve),
                refuse_overload.after(AttemptSystems::Solve).before(AttemptSystems::Judge),
            ),
        );
    }
}

/// The links of a world.
#[derive(Serialize, Deserialize)]
struct AllLinks(Vec<Link>);

impl StateOf for AllLinks {
    fn take(world: &mut World) -> Option<Self> {
        let mut all: Vec<Link> = world.query::<&Link>().iter(world).copied().collect();
        all.sort_unstable_by(order);
        (!all.is_empty()).then_some(Self(all))
    }

    fn put(self, world: &mut World) {
        Self::forget(world);
        world.spawn_batch(self.0);
    }

    fn forget(world: &mut World) {
        despawn_if(world, |_: &Link| true);
    }
}

/// Orders links, whatever the order in which a query finds them.
fn order(x: &Link, y: &Link) -> Ordering {
    let of = |link: &Link| {
        let (p, q) = (link.on_a, link.on_b);
        let length = match link.kind {
            LinkKind::Hinge => -1.0,
            LinkKind::Length(length) => length,
        };
        ([link.a, link.b], [p.x, p.y, q.x, q.y, length, link.compliance])
    };
    let ((ends, x), (others, y)) = (of(x), of(y));
    let values = x.iter().zip(&y).map(|(x, y)| x.total_cmp(y));
    ends.cmp(&others).then(values.fold(Ordering::Equal, Ordering::then))
}

/// Why a link is refused.
///
/// The error goes to Bevy's error handler, which panics unless the app sets another one. The entity
/// then has no link.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the link of {a} and {b}: {what}")]
pub(crate) struct LinkError {
    /// First entity.
    pub a: Entity,
    /// Second entity.
    pub b: Entity,
    /// What is wrong and what would be right.
    pub what: &'static str,
}

/// Hook of [`LinkBetween`]: replaces it by a [`Link`] with the points as they lie on the bodies.
fn linked(mut world: DeferredWorld, context: HookContext) {
    let entity = context.entity;
    world.commands().queue(move |world: &mut World| -> Result<(), LinkError> {
        let Some(between) = world.entity_mut(entity).take::<LinkBetween>() else { return Ok(()) };
        let link = resolve(between, world)?;
        world.entity_mut(entity).insert(link);
        Ok(())
    });
}

fn resolve(between: LinkBetween, world: &World) -> Result<Link, LinkError> {
    let LinkBetween { bodies: [a, b], points, is_hinge, compliance } = between;
    let refuse = |what| LinkError { a, b, what };
    if a == b {
        return Err(refuse("a link joins two bodies, and these are one entity"));
    }
    let on = |entity: Entity, point: DVec2| {
        let what = "one of them is no particle and no wall; insert its Particle or Wall first, and \
                    link a member of a rigid group and not the group";
        let is_body =
            world.get::<Particle>(entity).is_some() || world.get::<Wall>(entity).is_some();
        let id = world.get::<BodyId>(entity).copied().filter(|_| is_body).ok_or(refuse(what))?;
        let at = world.get::<BodyPosition>(entity).map_or(DVec2::ZERO, |x| x.0);
        let turned = world.get::<BodyRotation>(entity).map_or(0.0, |rotation| rotation.0);
        let turned = world.get::<WallRotation>(entity).map_or(turned, |rotation| rotation.0);
        Ok((id, DVec2::from_angle(-turned).rotate(point - at)))
    };
    let ((a, on_a), (b, on_b)) = (on(a, points[0])?, on(b, points[1])?);
    let length = points[0].distance(points[1]);
    let kind = if is_hinge { LinkKind::Hinge } else { LinkKind::Length(length) };
    Ok(Link { a, b, on_a, on_b, kind, compliance })
}

/// The table of links.
pub(crate) fn gather(bodies: &BodyTable, links: &Query<(Entity, &Link)>) -> Vec<LinkRow> {
    let mut found: Vec<_> = links.iter().collect();
    found.sort_unstable_by(|x, y| order(x.1, y.1));
    let rows = found.into_iter().filter_map(|(entity, link)| {
        let row = |id| bodies.row(id).map(|row| row as u32);
        let ends = [(row(link.a)?, link.on_a), (row(link.b)?, link.on_b)];
        let [first, second] = if ends[0].0 < ends[1].0 { ends } else { [ends[1], ends[0]] };
        Some(LinkRow {
            rows: [first.0, second.0],
            arms: [first.1, second.1],
            entity,
            kind: link.kind,
            compliance: link.compliance,
        })
    });
    let mut rows: Vec<LinkRow> = rows.collect();
    rows.sort_by_key(|link| link.rows);
    rows
}

/// Appends one interaction per link, behind those of contacts. Its geometry is that halfway of the
/// expected motion, where the change of a distance is its component along the link, and the motion
/// of a point that turns with its body is the angle times the arm.
pub(crate) fn assemble(
    bodies: &BodyTable,
    analysis: &ClasticAnalysis,
    fraction: f64,
    interactions: &mut Vec<Interaction>,
) {
    for link in &bodies.links {
        let [a, b] = link.rows.map(|row| row as usize);
        let arm = |row: usize, arm: DVec2| DVec2::from_angle(bodies.rotations[row]).rotate(arm);
        let (now_a, now_b) = (arm(a, link.arms[0]), arm(b, link.arms[1]));
        let motion = |row: usize| fraction * expected_motion(bodies, analysis, row);
        let (of_a, of_b) = (motion(a), motion(b));
        let half = |turn: f64, arm: DVec2| DVec2::from_angle(0.5 * turn).rotate(arm);
        let (on_a, on_b) = (half(of_a.z, now_a), half(of_b.z, now_b));
        let apart = bodies.positions[b] - bodies.positions[a] + bodies.shift(a, b);
        let distance = (apart + now_b - now_a).length();
        let halfway = apart + 0.5 * (of_b - of_a).truncate() + on_b - on_a;
        let (along, offset, cohesion) = match link.kind {
            LinkKind::Hinge => (apart + now_b - now_a, distance, 1.0),
            LinkKind::Length(length) if link.compliance > 0.0 => (halfway, distance - length, 0.0),
            // With the distance d_0 at the start and d_1 at the end, d_1^2 - d_0^2 is (d_0 + d_1)
            // times the motion: no error is left where the expectation is right.
            LinkKind::Length(length) => {
                let change = (distance - length) * (distance + length);
                (halfway, change / (2.0 * halfway.length()), 0.0)
            }
        };
        let normal = along.try_normalize().unwrap_or(DVec2::X);
        let tangent = normal.perp();
        // The force of an elastic link is its mean over the increment, as that of a bond is.
        let theta = if link.compliance > 0.0 { analysis.kind.theta() } else { 1.0 };
        interactions.push(Interaction {
            normal,
            normal_arm_a: on_a.perp_dot(normal),
            normal_arm_b: -on_b.perp_dot(normal),
            arm_a: on_a.perp_dot(tangent),
            arm_b: -on_b.perp_dot(tangent),
            offset: offset / theta,
            normal_compliance: link.compliance / theta,
            tangential_compliance: cohesion * link.compliance / theta,
            limits: Limits { tension: 1.0, cohesion, ..Limits::default() },
            ..Interaction::between(a as u32, b as u32)
        });
    }
}

/// Motion (m, m, rad) of a body in a whole increment if it goes on as before.
fn expected_motion(bodies: &BodyTable, analysis: &ClasticAnalysis, row: usize) -> DVec3 {
    let velocity = bodies.velocities[row].extend(bodies.angular_velocities[row]);
    let last = DVec3::from_array(bodies.last_motion[row]);
    let mut motion = match analysis.kind {
        AnalysisKind::Dynamic { dt, .. } if row < bodies.particles => dt * velocity,
        _ => last,
    };
    for k in 0..3 {
        if row < bodies.particles
            && let BodyDrive::Imposed(u) = bodies.drive(row, k)
        {
            motion[k] = u;
        }
    }
    motion
}

/// Strength of links in units of the largest force that is expected. A program needs a finite one.
const STRENGTH: f64 = 1e5;

/// Gives links a strength that no solution reaches.
fn set_limits(
    bodies: Res<BodyTable>,
    contacts: Res<ContactTable>,
    mut program: ResMut<ConeProgram>,
) {
    if bodies.links.is_empty() {
        return;
    }
    let program = &mut *program;
    let loads = free_translations(program).map(|free| free.load.abs());
    let strength = STRENGTH * loads.sum::<f64>().max(program.scales.force);
    for c in program.interactions.iter_mut().skip(contacts.0.len()).take(bodies.links.len()) {
        c.limits.tension *= strength;
        c.limits.cohesion *= strength;
    }
}

/// Halts the world, before the increment is committed, where a link has reached that strength, and so
/// has given way.
fn refuse_overload(
    bodies: Res<BodyTable>,
    contacts: Res<ContactTable>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    mut commands: Commands,
) {
    let forces = program.interactions.iter().zip(&solution.forces).skip(contacts.0.len());
    for (link, (c, [p, q, _])) in bodies.links.iter().zip(forces) {
        if (-p).max(q.abs()) > 0.5 * c.limits.tension {
            let [a, b] = link.rows.map(|row| bodies.name(row as usize));
            commands.insert_resource(ClasticHalted(format!(
                "the link of {a} and {b} carries {:.3e} N, {STRENGTH:e} times what loads and inertia \
                 give: links work against each other; give one of them a compliance, or take it away",
                p.hypot(*q)
            )));
        }
    }
}
