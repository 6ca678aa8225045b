//! A boundary condition of one's own: a lid whose height follows a sine.
//!
//! `WallControl::Custom` keeps the built-in controls away; a system in `ControlSystems::Custom`
//! says what the lid does in the increment that begins.

use std::f64::consts::TAU;

use bevy_app::App;
use bevy_ecs::prelude::*;
use clastic::prelude::*;
use glam::DVec2;

/// Height `rest + amplitude sin(2 pi n / period)` after n increments.
#[derive(Component)]
struct Sine {
    rest: f64,
    amplitude: f64,
    period: f64,
}

impl Sine {
    fn height(&self, n: f64) -> f64 {
        self.rest + self.amplitude * (TAU * n / self.period).sin()
    }
}

fn follow(progress: Res<ClasticProgress>, mut lids: Query<(&Sine, &BodyPosition, &mut WallDrive)>) {
    for (sine, place, mut drive) in &mut lids {
        // A drive is for a whole increment. If an increment was halved, only `left` of it remains.
        // The motion is computed from the position of the lid, so that no error adds up.
        let left = 1.0 - progress.done.fract();
        let motion = (sine.height(progress.done + left) - place.0.y) / left;
        *drive = WallDrive::Imposed(DVec2::new(0.0, motion));
    }
}

/// Runs the example.
pub fn main() {
    let mut app = App::new();
    app.add_plugins(ClasticPlugins::default());
    app.add_systems(ControlWalls, follow.in_set(ControlSystems::Custom));

    let sine = Sine { rest: 1.0, amplitude: 1.0e-3, period: 8.0 };
    let lid = (Wall { tangent: DVec2::NEG_X, half_length: 1.0 }, WallControl::Custom);
    let world = app.world_mut();
    let lid = world.spawn((lid, sine, BodyPosition(DVec2::Y))).id();

    for n in 1..=8 {
        app.update();
        let world = app.world();
        let height = world.get::<BodyPosition>(lid).map_or(0.0, |place| place.0.y);
        let wanted = world.get::<Sine>(lid).map_or(0.0, |sine| sine.height(f64::from(n)));
        println!("{height:.6} m");
        assert!((height - wanted).abs() < 1e-15);
    }
}
