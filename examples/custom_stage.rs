//! A kind of stage of one's own: `Tilt` turns gravity by an angle, so that a disk slides down.
//!
//! A plugin provides the kind and has a system that begins it; a scene names the kind and the
//! values.

use bevy_app::App;
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use clastic::run::plugin::{BeginStage, Provide, StageSystems, stage_is};
use clastic::run::spawn::spawn_scene;
use clastic::run::stages::CurrentStage;
use clastic::run::{ScenePlugin, advance};
use clastic::scene::format::Stage;
use glam::DVec2;

/// The plugin.
fn tilt(app: &mut App) {
    app.provide_stage("Tilt");
    let begin = begin_tilt.in_set(StageSystems::Custom).run_if(stage_is("Tilt"));
    app.add_systems(BeginStage, begin);
}

/// Gravity turns by `angle`, in radians.
fn begin_tilt(stage: Res<CurrentStage>, mut analysis: ResMut<ClasticAnalysis>) {
    let Stage::Custom(stage) = &stage.0 else { return };
    let angle = stage.values.get("angle").copied().unwrap_or(0.0);
    analysis.gravity = DVec2::from_angle(angle).rotate(analysis.gravity);
}

const SCENE: &str = r#"(
    version: 1, title: "tilted plane",
    materials: { "stone": (density: 2650.0) },
    specimen: Particles([(position: (0.0, 0.5), radius: 0.5)]),
    walls: [(name: "floor", start: (-9.0, 0.0), end: (9.0, 0.0))],
    gravity: (0.0, -9.81),
    stages: [Custom(name: "slide", kind: "Tilt", increments: 100, values: { "angle": 0.1 },
        analysis: Dynamic(dt: 1.0e-3, theta: 1.0))],
)"#;

/// Runs the example.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let loaded = clastic::scene::from_str(SCENE, "tilt.ron".as_ref(), "".as_ref(), &[])?;
    let mut app = App::new();
    app.add_plugins((ClasticPlugins::default(), ScenePlugin, tilt));
    spawn_scene(app.world_mut(), &loaded.scene, None);
    while advance(app.world_mut()) == Step::Increment {}
    // Without friction it has g sin(0.1) t after t = 0.1 s.
    let mut disks = app.world_mut().query_filtered::<&BodyVelocity, With<Particle>>();
    let speed = disks.single(app.world())?.0.x;
    println!("{speed:.6} m/s");
    assert!((speed - 9.81 * 0.1_f64.sin() * 0.1).abs() < 1e-9);

    // Without the plugin the scene is refused, by name.
    let mut bare = Simulation::new(&loaded.scene, None);
    let Outcome::Refused { message, .. } = bare.run() else { return Err("it ran".into()) };
    assert!(message.contains("`Tilt`"), "{message}");
    Ok(())
}
