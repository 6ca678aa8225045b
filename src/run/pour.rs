//! Stages that pour grains in: which grain comes next, and when.
//!
//! Size, mineral and place of a grain follow from the seed, from the number of the grain and from
//! the number of places that were tried before, so that a run that goes on from any state pours the
//! same grains.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;

use super::laws::material_of;
use super::pour_room::Room;
use super::random::Random;
use super::script::Script;
use super::{load, sieve};
use crate::scene::format::{Pour, Rate, Scene, Sizes, Stage, Stream};

/// Name of [`Poured`] in a state.
pub const POURED: &str = "poured";

/// Number of grains that follow a sieve curve together.
const BLOCK: u64 = 100;
/// Kinds of random numbers. Every grain and every place has a sequence of its own.
const SIZE: u64 = 0;
const MINERAL: u64 = 1;
const PLACE: u64 = 2;

/// Sets up a stage that pours.
pub fn begin(world: &mut World, stage: &Pour) {
    load::begin(world, &stage.load);
    let poured = world.get_resource::<Poured>().copied().unwrap_or_default();
    let before = (poured.number, poured.mass);
    world.insert_resource(Poured { before, tries: 0, waits_since: None, ..poured });
}

/// Brings in the grains that are due by the end of the increment that begins, as long as they find
/// room. Exclusive, because it adds bodies.
pub(super) fn pour(world: &mut World) {
    let script = world.resource::<Script>();
    let progress = world.resource::<ClasticProgress>();
    let Some(Stage::Pour(stage)) = script.stage(progress.stage) else { return };
    let Stream { rate, .. } = stage.stream;
    let Some(dt) = world.resource::<ClasticAnalysis>().kind.dt() else { return };
    let Some(poured) = world.get_resource::<Poured>() else { return };
    let (time, total) = (progress.time, progress.total);
    // A halved increment brings its grains at its start.
    let increments = (progress.done.floor() + 1.0).min(total);
    let due = rate.due(increments, total, dt);
    let scene = &script.scene;
    let first = Grain::next(scene, &stage.stream, poured);
    if !first.is_due(rate, due, come(rate, poured)) {
        return;
    }
    let (stream, scene, mut poured) = (stage.stream.clone(), scene.clone(), *poured);
    let mut room = Room::new(world);
    loop {
        let grain = Grain::next(&scene, &stream, &poured);
        if !grain.is_due(rate, due, come(rate, &poured)) {
            break;
        }
        let place = room.find(stream.through, grain.disk.radius, || {
            poured.tries += 1;
            numbers(&stream, &poured, PLACE, poured.tries - 1)
        });
        let Some(place) = place else {
            poured.waits_since.get_or_insert(time);
            break;
        };
        poured.waits_since = None;
        poured.number += 1;
        poured.mass += grain.disk.mass;
        room.take(place, grain.disk.radius);
        let mut entity = world.spawn((
            grain.disk,
            BodyPosition(place),
            BodyOrigin(place),
            BodyVelocity(stream.velocity.into()),
            MaterialIndex(grain.material),
        ));
        if let Some(group) = &stream.group {
            entity.insert(Group(group.clone()));
        }
    }
    world.insert_resource(poured);
}

/// Number or mass (kg) that has come in the stage.
fn come(rate: Rate, poured: &Poured) -> f64 {
    if rate.is_of_mass() {
        poured.mass - poured.before.1
    } else {
        (poured.number - poured.before.0) as f64
    }
}

/// Share of what is due in a whole stage that has come, where a grain waits for room.
pub(super) fn came(world: &World, stage: &Stage) -> Option<f64> {
    let Stage::Pour(stage) = stage else { return None };
    let poured = world.get_resource::<Poured>().filter(|poured| poured.waits_since.is_some())?;
    let dt = world.resource::<ClasticAnalysis>().kind.dt()?;
    let (rate, total) = (stage.stream.rate, world.resource::<ClasticProgress>().total);
    Some(come(rate, poured) / rate.due(total, total, dt))
}

/// Random numbers of a kind for the grain or place with this index in the stage. Stages of one seed
/// differ by what was poured before them.
fn numbers(stream: &Stream, poured: &Poured, kind: u64, index: u64) -> Random {
    // Sequences 0 and 1 belong to specimens of the same seed.
    Random::stream(stream.seed.wrapping_add(poured.before.0), 4 * (index + 1) + kind)
}

/// The grain that comes next.
struct Grain {
    disk: Particle,
    material: u32,
}

impl Grain {
    fn next(scene: &Scene, stream: &Stream, poured: &Poured) -> Self {
        let index = poured.number - poured.before.0;
        let radius = match &stream.sizes {
            Sizes::Sieve { passing } => {
                let block = match stream.rate {
                    Rate::NumberOverStage(number) => BLOCK.min(number.into()).max(1),
                    _ => BLOCK,
                };
                let seed = stream.seed.wrapping_add(poured.before.0 + index / block);
                sieve::radii(passing, block as u32, seed)[(index % block) as usize]
            }
            sizes => numbers(stream, poured, SIZE, index).radius(sizes),
        };
        let chosen = numbers(stream, poured, MINERAL, index).unit();
        let mut below = 0.0;
        let mineral = stream.minerals.iter().find(|(_, share)| {
            below += **share;
            chosen < below
        });
        let name = mineral.map(|(name, _)| name).or(stream.material.as_ref());
        let (material, density) = material_of(scene, name);
        Self { disk: Particle::disk(radius, density, scene.thickness), material }
    }

    /// Whether the grain is due, so that the number or mass stays within half a grain of the
    /// intended one.
    fn is_due(&self, rate: Rate, due: f64, come: f64) -> bool {
        let size = if rate.is_of_mass() { self.disk.mass } else { 1.0 };
        due - come >= 0.5 * size
    }
}
