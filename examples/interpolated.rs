//! One increment over several frames: the time step of the simulation is longer than a frame, and
//! what is drawn moves evenly all the same.
//!
//! `LastMotion` of a body leads from the state before the last increment to the present one. Bevy's
//! `overstep_fraction` says which part of the next time step has passed. What is drawn lies that
//! part of the way from the state before to the present one, one time step behind.

use std::time::Duration;

use bevy_app::{App, FixedPostUpdate, Update};
use bevy_ecs::prelude::*;
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy};
use clastic::prelude::*;
use glam::DVec2;

/// Speed of the disk, m/s.
const SPEED: f64 = 2.0;

/// Where the disk was drawn in every frame, m.
#[derive(Resource, Default)]
struct Drawn(Vec<f64>);

/// In `Update`, after the increments of the frame.
fn draw(
    disks: Query<(&BodyPosition, &LastMotion)>,
    time: Res<Time<Fixed>>,
    mut drawn: ResMut<Drawn>,
) {
    for (position, motion) in &disks {
        let [x, ..] = motion.0;
        drawn.0.push(position.0.x - (1.0 - time.overstep_fraction_f64()) * x);
    }
}

/// Runs the example.
pub fn main() {
    let mut app = App::new();
    app.add_plugins((TimePlugin, ClasticPlugins::new(FixedPostUpdate)))
        .init_resource::<Drawn>()
        .add_systems(Update, draw)
        // Frames of 20 ms instead of the clock.
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(20)))
        .insert_resource(ClasticAnalysis {
            kind: AnalysisKind::Dynamic { dt: 0.1, theta: 1.0 },
            ..ClasticAnalysis::default()
        });
    let disk = Particle::disk(0.1, 2650.0, 1.0);
    app.world_mut().spawn((disk, BodyVelocity(DVec2::new(SPEED, 0.0))));
    // The first frame starts the clock.
    for _ in 0..51 {
        app.update();
    }
    let increments = app.world().resource::<ClasticProgress>().increment;
    let drawn = &app.world().resource::<Drawn>().0;
    println!("{increments} increments in {} frames, drawn up to {:.3} m", drawn.len(), drawn[50]);
    assert_eq!((increments, drawn.len()), (10, 51));
    // Until the first increment the disk lies still.
    let moved = drawn.windows(2).skip(5).map(|two| two[1] - two[0]);
    for motion in moved {
        assert!((motion - SPEED * 0.02).abs() < 1e-9, "{motion} m in a frame");
    }
}
