//! Computes the drives of walls and the loads of particles and rigid groups for the next increment from
//! their controls. A force or a stress on a wall is imposed exactly, through the wall's own balance row
//! in the program.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_components::prelude::*;
use glam::DVec2;

use crate::schedule::{
    ClasticHalted, ControlSystems, ControlWalls, Increment, IncrementSystems, lap, start_clock,
};
use crate::state::RegisterState;
use crate::wall_states::{ControlStates, WALL_CONTROL};

/// Adds [`control_walls`] and [`control_loads`], and runs them in every increment.
pub struct ControlWallsPlugin;

impl Plugin for ControlWallsPlugin {
    fn build(&self, app: &mut App) {
        app.register_state::<ControlStates>(WALL_CONTROL)
            .register_component::<BodyId, WallDrive>("wall_drive")
            .register_component::<BodyId, WallSlide>("wall_slide")
            .register_component::<BodyId, WallTable>("wall_table")
            .register_component::<BodyId, WallRotation>("wall_rotation")
            .register_component::<BodyId, LoadControl>("load_control");
        let built_in = (control_walls, control_loads).in_set(ControlSystems::BuiltIn);
        app.add_systems(ControlWalls, built_in).add_systems(
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

/// Writes [`AppliedLoad`] for the increment that starts at [`ClasticProgress::done`].
pub fn control_loads(
    progress: Res<ClasticProgress>,
    mut loaded: Query<(&LoadControl, &mut AppliedLoad)>,
) {
    for (control, mut load) in &mut loaded {
        load.set_if_neq(AppliedLoad::next(control, &progress));
    }
}

/// Writes the [`WallDrive`] of every wall for the increment that starts at [`ClasticProgress::done`].
pub fn control_walls(
    progress: Res<ClasticProgress>,
    analysis: Res<ClasticAnalysis>,
    geometry: Query<(&Wall, &BodyPosition)>,
    mut walls: Query<(
        Entity,
        &WallControl,
        &mut WallDrive,
        Option<&WallTable>,
        Option<&WallSlide>,
    )>,
    names: Query<&WallName>,
    mut commands: Commands,
) {
    let dt = analysis.kind.dt();
    for (entity, control, mut drive, table, slide) in &mut walls {
        let next = match *control {
            WallControl::Fixed => WallDrive::default(),
            WallControl::Displacement(u) => WallDrive::Imposed(u),
            WallControl::Velocity(v) => {
                dt.map_or_else(WallDrive::default, |dt| WallDrive::Imposed(v * dt))
            }
            WallControl::Rotation { about, angle } => WallDrive::Turning { about, angle },
            WallControl::Spin { about, rate } => dt.map_or_else(WallDrive::default, |dt| {
                WallDrive::Turning { about, angle: rate * dt }
            }),
            WallControl::Force { from, to } => WallDrive::Loaded(progress.ramp(from, to)),
            WallControl::Stress { length, .. } | WallControl::Table(TableOf::Stress(length)) => {
                if let LoadedLength::Between(a, b) = length
                    && !(geometry.contains(a) && geometry.contains(b))
                {
                    // Without this message the wall would silently lose its load.
                    let name = |wall: Entity| match names.get(wall) {
                        Ok(WallName(name)) => format!("wall `{name}`"),
                        Err(_) if geometry.contains(wall) => format!("wall {wall}"),
                        Err(_) => "a removed wall".to_owned(),
                    };
                    commands.insert_resource(ClasticHalted(format!(
                        "the stress on {} acts on the distance between {} and {}; give it another \
                         control before that wall is removed",
                        name(entity),
                        name(a),
                        name(b)
                    )));
                    continue;
                }
                let stress = stress_of(control, table, &progress, dt).unwrap_or_default();
                let length = loaded_length(entity, length, &geometry);
                WallDrive::Loaded(stress.times(length * analysis.thickness))
            }
            WallControl::Table(of) => {
                let table = table.map_or([Ramp::default(); 2], |table| table.next(&progress, dt));
                let [x, y] = table.map(|ramp| ramp.to - ramp.from);
                match of {
                    TableOf::Displacement => WallDrive::Imposed(DVec2::new(x, y)),
                    TableOf::Rotation(about) => WallDrive::Turning { about, angle: x },
                    TableOf::Force | TableOf::Stress(_) => WallDrive::Loaded(table[0]),
                }
            }
            WallControl::Custom => continue,
        };
        let next = match (next, slide) {
            (WallDrive::Loaded(load), Some(slide)) => {
                let along = match *slide {
                    WallSlide::Displacement(u) => u,
                    WallSlide::Velocity(v) => dt.map_or(0.0, |dt| v * dt),
                };
                WallDrive::Sliding { load, along }
            }
            (next, _) => next,
        };
        drive.set_if_neq(next);
    }
}

/// Updates the drives of stress-controlled walls in the table. The stress acts on the current
/// length between the walls, which a followed motion may have changed.
pub(crate) fn renew_stresses<'w>(
    bodies: &mut BodyTable,
    table_of: impl Fn(Entity) -> Option<&'w WallTable>,
    progress: &ClasticProgress,
    analysis: &ClasticAnalysis,
) {
    for k in 0..bodies.walls.len() {
        let wall = &bodies.walls[k];
        let (WallControl::Stress { length, .. } | WallControl::Table(TableOf::Stress(length))) =
            wall.control
        else {
            continue;
        };
        let table = table_of(bodies.entities[wall.body as usize]);
        let Some(stress) = stress_of(&wall.control, table, progress, analysis.kind.dt()) else {
            continue;
        };
        let length = match length {
            LoadedLength::Segment => 2.0 * wall.half_length,
            LoadedLength::Between(first, second) => distance(first, second, |wall| {
                let row = bodies.entities.iter().position(|e| *e == wall)?;
                Some((bodies.positions[row], bodies.wall(row as u32)?.inward))
            }),
        };
        let load = stress.times(length * analysis.thickness);
        let drive = &mut bodies.walls[k].drive;
        *drive = match *drive {
            WallDrive::Sliding { along, .. } => WallDrive::Sliding { load, along },
            _ => WallDrive::Loaded(load),
        };
    }
}

/// Stress of a control over the next whole increment, Pa; `None` if it has none or lacks its table.
fn stress_of(
    control: &WallControl,
    table: Option<&WallTable>,
    progress: &ClasticProgress,
    dt: Option<f64>,
) -> Option<Ramp> {
    match *control {
        WallControl::Stress { from, to, .. } => Some(progress.ramp(from, to)),
        WallControl::Table(TableOf::Stress(_)) => Some(table?.next(progress, dt)[0]),
        _ => None,
    }
}

/// The length that a stress on `wall` acts on, m.
pub fn loaded_length(
    wall: Entity,
    length: LoadedLength,
    geometry: &Query<(&Wall, &BodyPosition)>,
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
pub(crate) fn wall_distance(
    first: Entity,
    second: Entity,
    geometry: &Query<(&Wall, &BodyPosition)>,
) -> f64 {
    distance(first, second, |wall| geometry.get(wall).ok().map(|(wall, x)| (x.0, wall.inward())))
}

/// [`wall_distance`] of walls with these positions (m) and inward normals; 0 if one is missing.
fn distance(first: Entity, second: Entity, wall: impl Fn(Entity) -> Option<(DVec2, DVec2)>) -> f64 {
    match (wall(first), wall(second)) {
        (Some((x, inward)), Some((y, _))) => (y - x).dot(inward),
        _ => 0.0,
    }
}
