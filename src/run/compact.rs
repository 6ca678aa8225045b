//! Compaction (4.4.1 of the paper): rigid, frictionless and static, by the smallest feasible
//! motion.
//!
//! The linearised non-penetration condition is safe (`|x| >= n.x`): potential contacts do not
//! overlap after an increment of any size.
//!
//! [By radii](CompactBy::Radii) grains grow (radius expansion): in an increment all radii grow by
//! the same factor before contacts are detected, and the overlaps that this makes are offsets of
//! the non-penetration conditions: the smallest motion that obeys them pushes the grains apart. The
//! factor follows from the current radii and from what is left of the stage, so that radii grow
//! linearly and nothing has to be remembered between increments.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;
use clastic_cone::program::{ConeSolution, SolveStatus};
use clastic_systems::stepping::{IncrementDue, IncrementUndone};

use super::cell;
use super::cement::intact;
use super::disks::{Disks, radii};
use super::script::Script;
use super::state::Before;
use super::walls::find_pair;
use crate::scene::format::{Compact, CompactBy, CompactTarget, Stage};

/// Moves the wall, or grows the radii, towards the target in equal steps.
pub fn begin(world: &mut World, stage: &Compact) {
    let disks = Disks::in_world(world);
    world.resource_mut::<ClasticAnalysis>().kind = AnalysisKind::Compaction {
        affine: true,
        agitation: stage.agitation * disks.mean_radius,
        seed: stage.seed,
    };
    if let Some(steps) = set_in_motion(world, stage, &disks) {
        world.resource_mut::<ClasticProgress>().total = steps;
    }
}

/// Number of steps to the target; `None` if there is nothing to do.
fn set_in_motion(world: &mut World, stage: &Compact, disks: &Disks) -> Option<f64> {
    if stage.by == CompactBy::Radii {
        hold_walls(world);
        cell::hold(world);
        let growth = (growth_factor(world, stage, disks)? - 1.0) * disks.largest;
        return (growth > 0.0).then(|| (growth / stage.step).ceil().max(1.0));
    }
    let porosity = target_porosity(stage, disks);
    if let Some(porosity) = porosity
        && world.contains_resource::<PeriodicCell>()
    {
        return cell::compact(world, disks.area, porosity, stage.step);
    }
    let [wall, base] = find_pair(world, &stage.wall, &stage.base)?;
    let (height, length) = enclosure(world, stage)?;
    hold_walls(world);
    let target = match stage.target {
        CompactTarget::Height(height) => height,
        CompactTarget::Porosity(_) | CompactTarget::Jammed => {
            disks.area / ((1.0 - porosity?) * length)
        }
    };
    let distance = height - target;
    if distance <= 0.0 {
        return None;
    }
    let steps = (distance / stage.step).ceil().max(1.0);
    let inward = world.get::<Wall>(base).map(Wall::inward).unwrap_or_default();
    world.entity_mut(wall).insert(WallControl::Displacement(-inward * (distance / steps)));
    Some(steps)
}

/// Run condition: the stage compacts by radii.
pub(super) fn are_growing(script: Option<Res<Script>>, progress: Res<ClasticProgress>) -> bool {
    script.is_some_and(|script| growing(&script, &progress).is_some())
}

fn growing<'a>(script: &'a Script, progress: &ClasticProgress) -> Option<&'a Compact> {
    match script.stage(progress.stage) {
        Some(Stage::Compact(stage)) if stage.by == CompactBy::Radii => Some(stage),
        _ => None,
    }
}

/// Factor that brings the disks to the porosity of the stage.
fn growth_factor(world: &mut World, stage: &Compact, disks: &Disks) -> Option<f64> {
    let (height, length) = enclosure(world, stage)?;
    let porosity = target_porosity(stage, disks)?;
    Some(((1.0 - porosity) * (height * length) / disks.area).sqrt())
}

/// Sets the radii of the tables to those at the end of the attempt. Exclusive, because it looks for
/// walls by name.
pub(super) fn grow(world: &mut World) {
    let progress = world.resource::<ClasticProgress>();
    let Some(stage) = growing(world.resource::<Script>(), progress).cloned() else { return };
    let share = (progress.fraction / (progress.total - progress.done)).min(1.0);
    let radii = radii(world);
    let disks = Disks::of(radii.iter().copied());
    let Some(to_target) = growth_factor(world, &stage, &disks) else { return };
    let now = 1.0 + (to_target - 1.0) * share;
    let mut bodies = world.resource_mut::<BodyTable>();
    bodies.radii = radii.iter().map(|radius| radius * now).collect();
    bodies.mean_radius = bodies.radii.iter().sum::<f64>() / radii.len().max(1) as f64;
}

/// Gives the particles the radii of a committed attempt. Their density stays.
pub(super) fn keep_radii(
    bodies: Res<BodyTable>,
    particles: Query<(Entity, &BodyId, &Particle)>,
    mut commands: Commands,
) {
    for (entity, id, disk) in &particles {
        let Some(row) = bodies.row(*id) else { continue };
        let radius = bodies.radii[row];
        let grown = (radius / disk.radius).powi(2);
        let (mass, inertia) = (disk.mass * grown, disk.inertia * grown * grown);
        commands.entity(entity).insert(Particle { radius, mass, inertia, ..*disk });
    }
}

/// Porosity at which the motion of a compaction would end: of a packing that is to jam one that it
/// cannot have.
fn target_porosity(stage: &Compact, disks: &Disks) -> Option<f64> {
    match stage.target {
        CompactTarget::Height(_) => None,
        CompactTarget::Porosity(porosity) => Some(porosity),
        CompactTarget::Jammed => Some(disks.lowest_porosity()),
    }
}

/// Height and length of what encloses the grains, m: the periodic cell, or the distance of the wall
/// from the base and the length of the base.
fn enclosure(world: &mut World, stage: &Compact) -> Option<(f64, f64)> {
    if let Some(cell) = world.get_resource::<PeriodicCell>() {
        return Some((cell.height, cell.width));
    }
    let [wall, base] = find_pair(world, &stage.wall, &stage.base)?;
    let place = |wall| world.get::<BodyPosition>(wall).map(|x| x.0);
    let line = world.get::<Wall>(base)?;
    Some(((place(wall)? - place(base)?).dot(line.inward()), 2.0 * line.half_length))
}

/// Density of a packing.
pub struct Reached {
    /// Height between the walls of the stage or of the cell, m.
    pub height: f64,
    /// Mean radius, m.
    pub mean_radius: f64,
    /// Porosity there.
    pub porosity: f64,
}

/// What the packing of a compaction has reached after the last committed increment.
pub fn reached(world: &mut World, stage: &Compact) -> Option<Reached> {
    let (height, length) = enclosure(world, stage)?;
    let Disks { area, mean_radius, .. } = Disks::in_world(world);
    Some(Reached { height, mean_radius, porosity: 1.0 - area / (height * length) })
}

/// Why a compaction cannot begin: there are bonds, the packing is denser than its target, or no disks of
/// these radii are as dense.
pub(super) fn refusal(world: &mut World, stage: &Compact) -> Option<String> {
    if intact(world) > 0 {
        let message = "there are bonds, which a compaction of rigid disks would strain without forces; \
                       compact before `Cement`";
        return Some(message.to_owned());
    }
    let Reached { height: begin, porosity: now, .. } = reached(world, stage)?;
    let target = match stage.target {
        CompactTarget::Height(height) => 1.0 - (1.0 - now) * begin / height,
        CompactTarget::Porosity(porosity) => porosity,
        CompactTarget::Jammed => return None,
    };
    // A packing that is at its target already has nothing to do.
    if now < target - 1e-9 {
        return Some(format!(
            "the packing has a porosity of {now:.4} as it begins, and its target is {target:.4}: a compaction only \
             makes it denser; give a lower target, or leave the stage out"
        ));
    }
    Disks::in_world(world).refusal(target)
}

/// Ends a compaction to [`CompactTarget::Jammed`] where even the smallest part of an increment has
/// been proved to be impossible. This increment has committed nothing, and leaves no trace. Whether
/// it has done so.
pub(super) fn jams(world: &mut World, stage: &Stage) -> bool {
    let Stage::Compact(stage @ Compact { target: CompactTarget::Jammed, .. }) = stage else {
        return false;
    };
    let is_undecided = world.resource::<Attempt>().status == IncrementStatus::Undecided;
    if !is_undecided || world.resource::<ConeSolution>().status != SolveStatus::Locked {
        return false;
    }
    let Before { progress, observation, readings, .. } = world.resource::<Before>().clone();
    world.insert_resource(ClasticProgress { done: progress.total, ..progress });
    world.insert_resource(observation);
    world.insert_resource(readings);
    let porosity = reached(world, stage).map(|reached| reached.porosity);
    if let Some(end) = world.resource_mut::<Script>().ends.last_mut() {
        end.jammed_at = porosity;
    }
    world.insert_resource(IncrementDue(false));
    world.insert_resource(IncrementUndone(true));
    true
}

/// Sets the packing to rest without stress. The forces of the compaction come from its
/// regularisation and have no physical meaning.
pub fn end(world: &mut World) {
    cell::hold(world);
    world.resource_mut::<ContactHistory>().0.clear();
    let mut bodies = world.query::<(
        &mut LastMotion,
        &mut BodyExternalForce,
        Option<&mut BodyVelocity>,
        Option<&mut BodyAngularVelocity>,
    )>();
    for (mut motion, mut force, velocity, spin) in bodies.iter_mut(world) {
        *motion = LastMotion::default();
        // A later load on a wall starts from the force that the wall carries, which is zero.
        *force = BodyExternalForce::default();
        if let Some(mut velocity) = velocity {
            *velocity = BodyVelocity::default();
        }
        if let Some(mut spin) = spin {
            *spin = BodyAngularVelocity::default();
        }
    }
    hold_walls(world);
}

fn hold_walls(world: &mut World) {
    let mut walls = world.query::<&mut WallControl>();
    for mut control in walls.iter_mut(world) {
        *control = WallControl::Fixed;
    }
}
