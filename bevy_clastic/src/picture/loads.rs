//! Loads and motions of a world that a slider can change.

use std::collections::BTreeMap;

use bevy::ecs::prelude::*;
use clastic::components::cell::{CellControl, PeriodicCell};
use clastic::components::increment::{ClasticAnalysis, ClasticProgress};
use clastic::components::membrane::Membrane;
use clastic::components::wall::{Wall, WallControl, WallName};
use glam::DVec2;

/// Increments over which a force, a stress or a pressure goes to a new value, so that bonds break
/// at the load at which they reach their limits.
const INCREMENTS: f64 = 10.0;

/// A load or a motion that can be changed. Bodies with the same one have it together, since opposite
/// walls with unequal stresses would push the specimen away.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// Names of the walls, of the membrane, or `cell`; none for gravity.
    pub of: Vec<String>,
    /// Quantity.
    pub what: String,
    /// Unit of the value.
    pub unit: &'static str,
    /// Value that it has or goes to.
    pub value: f64,
}

impl Load {
    /// Bodies and quantity.
    #[must_use]
    pub fn name(&self) -> String {
        let of = self.of.join(", ");
        if of.is_empty() { self.what.clone() } else { format!("{of}: {}", self.what) }
    }
}

/// A body, empty for gravity, and a quantity.
type Key = (String, String);

/// Loads on their way, and directions of motions that were set to 0.
#[derive(Resource, Default)]
struct OnTheWay {
    /// Stage, increments of it that are done on arrival, and the value.
    targets: BTreeMap<Key, (usize, f64, f64)>,
    /// Directions of gravity and of the motions of walls.
    directions: BTreeMap<Key, DVec2>,
}

/// What a load is a part of.
enum Part<'a> {
    Gravity(&'a mut DVec2),
    /// Value at the start and at the end of the stage.
    Ramp(&'a mut f64, &'a mut f64),
    /// Displacement in every increment, or velocity.
    Motion(&'a mut DVec2),
    /// Angle in every increment, or angular velocity.
    Turn(&'a mut f64),
}

/// Calls `with` for the load of every body: gravity, walls by name, membranes, cell.
fn each(world: &mut World, mut with: impl FnMut(Key, &'static str, Part)) {
    let gravity = &mut world.resource_mut::<ClasticAnalysis>().gravity;
    with((String::new(), "gravity".to_owned()), "m/s^2", Part::Gravity(gravity));
    let mut walls = world.query_filtered::<(&WallName, &mut WallControl), With<Wall>>();
    let mut walls: Vec<_> = walls.iter_mut(world).collect();
    walls.sort_unstable_by(|a, b| a.0.0.cmp(&b.0.0));
    for (WallName(name), mut control) in walls {
        let (what, unit, part) = match &mut *control {
            WallControl::Force { from, to } => ("force", "N", Part::Ramp(from, to)),
            WallControl::Stress { from, to, .. } => ("stress", "Pa", Part::Ramp(from, to)),
            WallControl::Displacement(u) => ("motion per increment", "m", Part::Motion(u)),
            WallControl::Velocity(v) => ("velocity", "m/s", Part::Motion(v)),
            WallControl::Rotation { angle, .. } => {
                ("rotation per increment", "rad", Part::Turn(angle))
            }
            WallControl::Spin { rate, .. } => ("angular velocity", "rad/s", Part::Turn(rate)),
            WallControl::Fixed | WallControl::Custom | WallControl::Table(_) => continue,
        };
        with((name.clone(), what.to_owned()), unit, part);
    }
    let mut membranes = world.query::<&mut Membrane>();
    for mut membrane in membranes.iter_mut(world) {
        let Membrane { name, pressure: (from, to), .. } = &mut *membrane;
        with((name.clone(), "pressure".to_owned()), "Pa", Part::Ramp(from, to));
    }
    let Some(mut cell) = world.get_resource_mut::<PeriodicCell>() else { return };
    let PeriodicCell { controls, by_mean, .. } = &mut *cell;
    let key = |what: String| ("cell".to_owned(), what);
    let names = if *by_mean { ["mean", "difference", "shear"] } else { ["xx", "yy", "shear"] };
    for (control, name) in controls.iter_mut().zip(names) {
        match control {
            CellControl::Stress { from, to } => {
                with(key(format!("stress {name}")), "Pa", Part::Ramp(from, to));
            }
            CellControl::Imposed(u) if *u != 0.0 => {
                with(key(format!("motion {name} per increment")), "m", Part::Turn(u));
            }
            CellControl::Imposed(_) => {}
        }
    }
}

/// The loads of a world.
pub(super) fn loads(world: &mut World) -> Vec<Load> {
    let way = world.remove_resource::<OnTheWay>().unwrap_or_default();
    let mut list: Vec<Load> = Vec::new();
    each(world, |key, unit, part| {
        let value = match part {
            Part::Gravity(vector) | Part::Motion(vector) => along(&way, &key, *vector).dot(*vector),
            Part::Turn(angle) => *angle,
            Part::Ramp(_, to) => way.targets.get(&key).map_or(*to, |(.., target)| *target),
        };
        let (of, what) = key;
        match list.iter_mut().find(|load| load.what == what && load.value == value) {
            Some(load) => load.of.push(of),
            None => {
                let of = Vec::from_iter(Some(of).filter(|of| !of.is_empty()));
                list.push(Load { of, what, unit, value });
            }
        }
    });
    world.insert_resource(way);
    list
}

/// Direction in which a vector counts: its own, or that before it was set to 0; of gravity otherwise
/// downwards.
fn along(way: &OnTheWay, key: &Key, vector: DVec2) -> DVec2 {
    let own = vector.try_normalize();
    let before = way.directions.get(key).copied();
    let is_along = |before: &DVec2| own.is_none_or(|own| own.perp_dot(*before).abs() < 1e-9);
    let otherwise = if key.0.is_empty() { -DVec2::Y } else { DVec2::ZERO };
    before.filter(is_along).or(own).unwrap_or(otherwise)
}

/// Gives a load its value. Motions and gravity have it from the next increment on. A force, a
/// stress or a pressure goes there over ten increments, or over those that are left of the stage; at
/// once where loads follow a course.
pub fn set_load(world: &mut World, load: &Load) {
    let progress = world.resource::<ClasticProgress>().clone();
    let mut way = world.remove_resource::<OnTheWay>().unwrap_or_default();
    let value = load.value;
    each(world, |key, _, part| {
        let (of, what) = &key;
        let is_meant = if of.is_empty() { load.of.is_empty() } else { load.of.contains(of) };
        if !is_meant || *what != load.what {
            return;
        }
        match part {
            Part::Gravity(vector) | Part::Motion(vector) => {
                let direction = along(&way, &key, *vector);
                *vector = value * direction;
                way.directions.insert(key, direction);
            }
            Part::Turn(angle) => *angle = value,
            Part::Ramp(from, to) => {
                let now = progress.ramp(*from, *to).from;
                let arrival = (progress.done.floor() + INCREMENTS).min(progress.total);
                if arrival <= progress.done || !progress.course.is_empty() {
                    (*from, *to) = (value, value);
                    return;
                }
                let slope = (value - now) / (arrival - progress.done);
                *from = now - slope * progress.done;
                // At the end of the stage without round-off.
                let is_end = arrival == progress.total;
                *to = if is_end { value } else { *from + slope * progress.total };
                way.targets.insert(key, (progress.stage, arrival, value));
            }
        }
    });
    world.insert_resource(way);
}

/// Forgets loads on their way. It belongs to a world that has gone back to another state.
pub fn forget_loads(world: &mut World) {
    world.remove_resource::<OnTheWay>();
}

/// Keeps loads that have arrived where they are. It belongs between two increments.
pub fn settle_loads(world: &mut World) {
    let Some(mut way) = world.remove_resource::<OnTheWay>() else { return };
    let progress = world.resource::<ClasticProgress>().clone();
    // Another stage, or an earlier moment of this one, has controls of its own.
    way.targets.retain(|_, (stage, arrival, _)| {
        *stage == progress.stage && progress.done >= *arrival - INCREMENTS
    });
    let arrived = |arrival: f64| progress.done >= arrival - 1e-9;
    if way.targets.values().any(|(_, arrival, _)| arrived(*arrival)) {
        each(world, |key, _, part| {
            if let (Part::Ramp(from, to), Some((_, arrival, value))) =
                (part, way.targets.get(&key).copied())
                && arrived(arrival)
            {
                (*from, *to) = (value, value);
                way.targets.remove(&key);
            }
        });
    }
    world.insert_resource(way);
}

#[cfg(test)]
mod tests {
    use bevy::app::App;
    use clastic::prelude::*;
    use clastic::run::spawn::spawn_scene;

    use super::*;

    /// A disk on a floor under a lid with a force. The floor carries what the lid presses with.
    fn pressed() -> App {
        let text = r#"(
            version: 1, title: "a pressed disk",
            materials: { "m": (contact: (normal_stiffness: 1.0e7)) },
            specimen: Particles([(position: (0.0, 0.05), radius: 0.05)]),
            walls: [
                (name: "floor", start: (-1.0, 0.0), end: (1.0, 0.0), probe: "floor",
                    contact: (normal_stiffness: 1.0e7)),
                (name: "lid", start: (1.0, 0.1), end: (-1.0, 0.1),
                    contact: (normal_stiffness: 1.0e7)),
            ],
            stages: [
                Load(name: "press", increments: 4, walls: { "lid": Force(100.0) }),
                Load(name: "hold", increments: 30),
            ],
        )"#;
        let loaded = clastic::scene::from_str(text, "lid.ron".as_ref(), "".as_ref(), &[]).unwrap();
        let mut app = App::new();
        app.add_plugins((ClasticPlugins::default(), ScenePlugin));
        spawn_scene(app.world_mut(), &loaded.scene, None);
        app
    }

    /// Forces on the floor after some increments, N.
    fn forces(app: &mut App, increments: usize) -> Vec<f64> {
        let next = |_| {
            app.update();
            settle_loads(app.world_mut());
            app.world().resource::<Observation>().probes[0].force[1]
        };
        (0..increments).map(next).collect()
    }

    #[test]
    fn a_force_goes_to_its_new_value_in_ten_increments_and_stays_there() {
        let mut app = pressed();
        forces(&mut app, 6);
        let lid = loads(app.world_mut()).into_iter().find(|load| load.of == ["lid"]).unwrap();
        assert_eq!((lid.name().as_str(), lid.value), ("lid: force", 100.0));
        set_load(app.world_mut(), &Load { value: 200.0, ..lid });
        let found = forces(&mut app, 15);
        for (k, force) in found.iter().enumerate() {
            let expected = 100.0 + 10.0 * (k + 1).min(10) as f64;
            assert!((force - expected).abs() < 1e-5, "{force} N after {}", k + 1);
        }
    }

    #[test]
    fn gravity_that_was_zero_points_downwards_and_comes_back() {
        let mut app = pressed();
        let weight = |app: &mut App, value| {
            let gravity = loads(app.world_mut()).remove(0);
            set_load(app.world_mut(), &Load { value, ..gravity });
            app.world().resource::<ClasticAnalysis>().gravity
        };
        assert_eq!(weight(&mut app, 9.81), DVec2::new(0.0, -9.81));
        assert_eq!(weight(&mut app, 0.0), DVec2::ZERO);
        assert_eq!(loads(app.world_mut())[0].value, 0.0);
    }
}
