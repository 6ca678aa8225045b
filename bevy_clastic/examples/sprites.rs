//! Sprites that follow grains: a heap of disks is poured on a floor, in the time of the clock.

use bevy::prelude::*;
use bevy_clastic::FollowPlugin;
use clastic::prelude::*;
use glam::DVec2;

/// The app; `main` runs it.
pub fn app() -> App {
    let kind = AnalysisKind::Dynamic { dt: 5.0e-3, theta: 1.0 };
    let mut app = App::new();
    app.add_plugins((DefaultPlugins, ClasticPlugins::new(FixedPostUpdate)))
        // 300 pixels in a metre.
        .add_plugins(FollowPlugin { scale: 300.0 })
        .insert_resource(ClasticAnalysis { kind, gravity: DVec2::new(0.0, -9.81), ..default() })
        .insert_resource(material::Materials(vec![material::Material {
            contact: ContactLaw { friction: 0.5, ..default() },
            ..default()
        }]))
        .add_systems(Startup, spawn);
    app
}

/// Runs the example.
pub fn main() {
    app().run();
}

fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<ColorMaterial>>,
) {
    commands.spawn(Camera2d);
    let floor = Wall::between(DVec2::new(-1.5, -1.0), DVec2::new(1.5, -1.0));
    commands.spawn((floor, ContactLaw { friction: 0.5, ..default() }));
    let disk = Mesh2d(meshes.add(RegularPolygon::new(0.05 * 300.0, 7)));
    for k in 0..60 {
        let (column, row) = (f64::from(k % 6), f64::from(k / 6));
        let place = 0.11 * DVec2::new(column + 0.1 * (row % 3.0), row);
        let colour = materials.add(Color::hsl(6.0 * k as f32, 0.6, 0.6));
        let body = (Particle::disk(0.05, 2650.0, 1.0), BodyPosition(place));
        commands.spawn((body, disk.clone(), MeshMaterial2d(colour)));
    }
}
