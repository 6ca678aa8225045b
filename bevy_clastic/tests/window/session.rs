//! A session with `biaxial_small`: what is drawn, pausing, going back, a load that is changed, a
//! grain that is picked.

use std::process::ExitCode;

use bevy::prelude::*;
use bevy_clastic::draw::{Field, Look, Shown, colouring};
use bevy_clastic::picture::{Load, Motion};
use glam::DVec2;

use super::drive::{self, on_screen, picture, pixel};

/// The disk whose colour and values are looked at.
const ROW: usize = 200;
/// Stress that five presses of a key give the walls that have 200 kPa: five twentieths of 400 kPa
/// more.
const STRESS: f64 = 300.0e3;

/// What steps keep for later ones.
#[derive(Resource, Default)]
struct Seen {
    increment: u64,
    places: Vec<[f64; 2]>,
}

fn increment(world: &World) -> u64 {
    picture(world).frame.increment
}

fn places(world: &World) -> Vec<[f64; 2]> {
    let frame = &picture(world).frame;
    (0..frame.bodies.id.len()).map(|row| frame.centre(row)).collect()
}

fn is_paused(world: &World) -> bool {
    picture(world).motion == Motion::Paused
}

/// The disk has the colour that the field gives it, between its centre and its rim, away from the
/// radius that shows its rotation.
fn has_its_colour(world: &mut World, shot: &str) {
    let (place, expected) = {
        let shown = world.resource::<Shown>();
        let bodies = &shown.now.frame.bodies;
        let angle = f64::from(bodies.rotation_rad[ROW]) + std::f64::consts::PI;
        let arm = 0.5 * f64::from(bodies.radius_m[ROW]) * DVec2::from_angle(angle);
        let (colours, _) = colouring(shown, world.resource::<Look>().field);
        (DVec2::from(shown.now.frame.centre(ROW)) + arm, colours[ROW])
    };
    let at = on_screen(world, place);
    let expected = Srgba::from(expected).to_u8_array_no_alpha();
    let drawn = pixel(world, shot, at);
    let differs = drawn.iter().zip(expected).any(|(a, b)| a.abs_diff(b) > 2);
    assert!(!differs, "{shot}: disk {ROW} is {drawn:?} at {at}, and not {expected:?}");
}

pub fn run() -> ExitCode {
    drive::run("biaxial_small", |steps| {
        steps.act("start", |world| {
            world.init_resource::<Seen>();
            let frame = &picture(world).frame;
            assert_eq!((frame.bodies.id.len(), frame.increment), (400, 0));
        });
        steps.shot("session_start");
        steps.act("colour of a material", |world| has_its_colour(world, "session_start"));

        // Space runs and pauses, and N makes one increment.
        steps.key(KeyCode::Space, false);
        steps.wait("30 increments", |world| increment(world) >= 30);
        steps.key(KeyCode::Space, false);
        steps.wait("pause", is_paused);
        steps.frames(5);
        steps.act("paused at", |world| {
            let now = increment(world);
            world.resource_mut::<Seen>().increment = now;
        });
        steps.frames(60);
        steps.act("nothing moves in a pause", |world| {
            assert_eq!(increment(world), world.resource::<Seen>().increment);
        });
        steps.key(KeyCode::KeyN, false);
        steps.wait("one increment", |world| increment(world) > world.resource::<Seen>().increment);
        steps.frames(30);
        steps.act("one increment alone", |world| {
            assert_eq!(increment(world), world.resource::<Seen>().increment + 1);
        });

        // K keeps a state, and R goes back to it, to the bit.
        steps.key(KeyCode::KeyK, false);
        steps.wait("kept", |world| picture(world).kept.is_some());
        steps.act("keep the places", |world| {
            let (increment, places) = (increment(world), places(world));
            *world.resource_mut::<Seen>() = Seen { increment, places };
        });
        steps.key(KeyCode::KeyN, true);
        steps.wait("ten more", |world| {
            is_paused(world) && increment(world) == world.resource::<Seen>().increment + 10
        });
        steps.act("it has moved", |world| {
            assert!(places(world) != world.resource::<Seen>().places);
        });
        steps.key(KeyCode::KeyR, false);
        steps.wait("back", |world| increment(world) == world.resource::<Seen>().increment);
        steps.act("places as they were", |world| {
            assert!(places(world) == world.resource::<Seen>().places);
        });

        // The slider changes the stress of the lateral walls, and the specimen answers.
        steps.act("the loads", |world| {
            let names: Vec<_> = picture(world).loads.iter().map(Load::name).collect();
            let expected = ["gravity", "bottom, top: motion per increment", "left, right: stress"];
            assert_eq!(names, expected);
        });
        // Three times L comes back to the last one, with which the slider begins.
        for _ in 0..3 {
            steps.key(KeyCode::KeyL, false);
        }
        for _ in 0..5 {
            steps.key(KeyCode::ArrowRight, false);
        }
        steps.key(KeyCode::KeyN, true);
        steps.key(KeyCode::KeyN, true);
        steps.wait("twice ten increments", |world| {
            is_paused(world) && increment(world) == world.resource::<Seen>().increment + 20
        });
        steps.act("the stress", |world| {
            let stress = picture(world).value("lateral_stress").unwrap_or(0.0);
            assert!((stress - STRESS).abs() < 1e-3 * STRESS, "{stress} Pa");
        });

        // Fields, forces, and a grain that is picked.
        for _ in 0..Field::ALL.iter().position(|f| *f == Field::MeanStress).unwrap_or(0) {
            steps.key(KeyCode::KeyC, false);
        }
        steps.shot("session_stress");
        steps.act("colour of a stress", |world| has_its_colour(world, "session_stress"));
        steps.key(KeyCode::Digit3, false);
        steps.click(|world| picture(world).frame.centre(ROW).into());
        steps.wait("picked", |world| {
            world.resource::<Look>().marked == Some(picture(world).frame.bodies.id[ROW])
        });
        steps.shot("session_forces");
        steps.key(KeyCode::KeyH, false);
        steps.shot("session_keys");
        steps.key(KeyCode::KeyH, false);

        // To the end, and from there back to the start.
        steps.key(KeyCode::Space, false);
        steps.wait("the end", |world| matches!(picture(world).motion, Motion::Stopped(_)));
        steps.shot("session_end");
        steps.key(KeyCode::Home, false);
        steps.wait("the start", |world| increment(world) == 0);
        steps.key(KeyCode::KeyN, false);
        steps.wait("a run that has ended goes on", |world| increment(world) == 1);
    })
}
