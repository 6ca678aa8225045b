//! Apps that have begun no stage.

use bevy_app::App;
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use glam::DVec2;

/// A soft disk of 10 mm radius on a floor, under a lid that touches it. The lid is returned.
fn pressed_disk(control: WallControl, table: Vec<[f64; 3]>) -> (App, Entity) {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default());
    let law = ContactLaw { normal_compliance: 1.0 / STIFFNESS, ..Default::default() };
    let world = app.world_mut();
    let held = BodyDrives([BodyDrive::Imposed(0.0), BodyDrive::Free, BodyDrive::Imposed(0.0)]);
    let place = BodyPosition(DVec2::new(0.0, 0.01));
    world.spawn((Particle::disk(0.01, 2650.0, 1.0), place, held));
    world.spawn((Wall::between(DVec2::new(-0.02, 0.0), DVec2::new(0.02, 0.0)), law));
    let lid = Wall::between(DVec2::new(0.02, 0.02), DVec2::new(-0.02, 0.02));
    let lid = world.spawn((lid, law, control, WallTable(table))).id();
    (app, lid)
}

/// Normal stiffness of a contact of the disk with a wall, N/m.
const STIFFNESS: f64 = 1.0e6;

/// How far the lid has come down from where it touches the disk, m. Two springs in series carry
/// `STIFFNESS/2` times as much.
fn descent(app: &App, lid: Entity) -> f64 {
    0.02 - app.world().get::<BodyPosition>(lid).map_or(f64::NAN, |x| x.0.y)
}

/// The part of the stage that is done was 1/0 and 0/0 in an app without a stage.
#[test]
fn a_table_of_forces_without_a_stage_is_at_its_end() {
    let force = WallControl::Table(TableOf::Force);
    let (mut app, lid) = pressed_disk(force, vec![[0.0, 10.0, 0.0], [1.0, 50.0, 0.0]]);
    for _ in 0..3 {
        app.update();
        assert_eq!(app.world().resource::<Observation>().status, IncrementStatus::Solved);
        let found = descent(&app, lid);
        assert!((found - 2.0 * 50.0 / STIFFNESS).abs() < 1e-9, "{found} m");
    }
}

#[test]
fn a_table_of_displacements_moves_its_wall_in_a_stage_alone() {
    let table = vec![[0.0, 0.0, 0.0], [1.0, 0.0, -4.0e-5]];
    let (mut app, lid) = pressed_disk(WallControl::Table(TableOf::Displacement), table);
    let follow = |app: &mut App, expected: &[f64]| {
        for expected in expected {
            app.update();
            let found = descent(app, lid);
            assert!((found - expected).abs() < 1e-12, "{found} m instead of {expected} m");
        }
    };
    follow(&mut app, &[0.0, 0.0]);
    begin_stage(app.world_mut(), 4);
    follow(&mut app, &[1.0e-5, 2.0e-5, 3.0e-5, 4.0e-5, 4.0e-5, 4.0e-5]);
    // Each stage goes through the table again.
    begin_stage(app.world_mut(), 2);
    follow(&mut app, &[6.0e-5, 8.0e-5, 8.0e-5]);
}

#[test]
#[should_panic(expected = "has no direction")]
fn a_wall_between_one_point_is_refused() {
    let _ = Wall::between(DVec2::ONE, DVec2::ONE);
}
