//! Computes the drives of walls for the next increment from their controls. A force or a stress is
//! imposed exactly, through the wall's own balance row in the program.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_components::body::{BodyId, Position};
use clastic_components::contact::Bodies;
use clastic_components::increment::{Analysis, AnalysisKind, Progress};
use clastic_components::wall::{LoadedLength, Wall, WallControl, WallDrive};

use crate::schedule::{
    ControlSystems, ControlWalls, Increment, IncrementSystems, lap, start_clock,
};
use crate::state::RegisterState;
use crate::stepping::Halted;
use crate::wall_states::{ControlStates, WALL_CONTROL};

/// Adds [`control_walls`] and runs it in every increment.
pub struct ControlWallsPlugin;

impl Plugin for ControlWallsPlugin {
    fn build(&self, app: &mut App) {
        app.register_state::<ControlStates>(WALL_CONTROL)
            .register_component::<BodyId, WallDrive>("wall_drive");
        app.add_systems(ControlWalls, control_walls.in_set(ControlSystems::BuiltIn)).add_systems(
            Increment,
            (
                start_clock,
                |world: &mut World| world.run_schedule(ControlWalls),
                lap(|t| &mut t.walls),
            )
                .chain()
                .in_set(IncrementSystems::Controls),
        );
    }
}

/// Writes the [`WallDrive`] of every wall for the increment that starts at [`Progress::done`].
pub fn control_walls(
    progress: Res<Progress>,
    analysis: Res<Analysis>,
    geometry: Query<(&Wall, &Position)>,
    mut walls: Query<(Entity, &WallControl, &mut WallDrive)>,
    mut commands: Commands,
) {
    for (entity, control, mut drive) in &mut walls {
        let next = match *control {
            WallControl::Fixed => WallDrive::default(),
            WallControl::Displacement(u) => WallDrive::Imposed(u),
            WallControl::Velocity(v) => match analysis.kind {
                AnalysisKind::Dynamic { dt, .. } => WallDrive::Imposed(v * dt),
                AnalysisKind::Static | AnalysisKind::LeastMotion { .. } => WallDrive::default(),
            },
            WallControl::Force { from, to } => WallDrive::Loaded(progress.ramp(from, to)),
            WallControl::Stress { length: LoadedLength::Between(a, b), .. }
                if !(geometry.contains(a) && geometry.contains(b)) =>
            {
                // The wall would be unloaded without a word.
                commands.insert_resource(Halted(format!(
                    "the stress on wall {entity} acts on the distance of walls {a} and {b}, of which one \
                     is gone; give it another control before the wall goes"
                )));
                continue;
            }
            WallControl::Stress { from, to, length } => {
                let length = loaded_length(entity, length, &geometry);
                WallDrive::Loaded(progress.ramp(from, to).times(length * analysis.thickness))
            }
            WallControl::Custom => continue,
        };
        drive.set_if_neq(next);
    }
}

/// Updates the drives of stress-controlled walls in the table. The stress acts on the current
/// length between the walls, which a followed motion may have changed.
pub fn renew_stresses(bodies: &mut Bodies, progress: &Progress, analysis: &Analysis) {
    for k in 0..bodies.walls.len() {
        let WallControl::Stress { from, to, length } = bodies.walls[k].control else { continue };
        let length = match length {
            LoadedLength::Segment => 2.0 * bodies.walls[k].half_length,
            LoadedLength::Between(first, second) => {
                let place = |wall: Entity| bodies.entities.iter().position(|e| *e == wall);
                let inward = |i: usize| bodies.walls.iter().find(|w| w.body as usize == i);
                match (place(first), place(second)) {
                    (Some(i), Some(j)) => inward(i).map_or(0.0, |wall| {
                        (bodies.positions[j] - bodies.positions[i]).dot(wall.inward)
                    }),
                    _ => 0.0,
                }
            }
        };
        let ramp = progress.ramp(from, to).times(length * analysis.thickness);
        bodies.walls[k].drive = WallDrive::Loaded(ramp);
    }
}

/// The length that a stress on `wall` acts on, m.
pub fn loaded_length(
    wall: Entity,
    length: LoadedLength,
    geometry: &Query<(&Wall, &Position)>,
) -> f64 {
    match length {
        LoadedLength::Segment => geometry.get(wall).map_or(0.0, |(w, _)| 2.0 * w.half_length),
        // The distance is measured along the normal of `first`. Opposite walls that name one pair
        // then get equal bits.
        LoadedLength::Between(first, second) => wall_distance(first, second, geometry),
    }
}

/// Distance of the line of `second` from the line of `first`, along the inward normal of `first`
/// through the middle of `second`, m.
pub fn wall_distance(first: Entity, second: Entity, geometry: &Query<(&Wall, &Position)>) -> f64 {
    match (geometry.get(first), geometry.get(second)) {
        (Ok((wall, x)), Ok((_, y))) => (y.0 - x.0).dot(wall.inward()),
        _ => 0.0,
    }
}
