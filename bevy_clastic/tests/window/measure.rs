//! Frames in a second of a scene, and the time of the processor that drawing takes.

use std::process::ExitCode;
use std::time::Instant;

use bevy::prelude::*;
use bevy_clastic::draw::{DrawingTime, Look, Shown};

use super::drive::{self, Steps, picture};

const FRAMES: u32 = 120;

#[derive(Resource)]
struct Since(Instant);

/// Frames with one mesh for all, whether it is made anew in every frame or not.
fn measure(steps: &mut Steps, what: &'static str, anew: bool) {
    steps.act("clock", |world| {
        *world.resource_mut::<DrawingTime>() = DrawingTime::default();
        world.insert_resource(Since(Instant::now()));
    });
    let mut left = FRAMES;
    steps.each_frame("frames", move |world| {
        if anew {
            world.resource_mut::<Shown>().set_changed();
        }
        left -= 1;
        left == 0
    });
    steps.act("print", move |world| {
        let frame = world.resource::<Since>().0.elapsed().as_secs_f64() / f64::from(FRAMES);
        let drawing = *world.resource::<DrawingTime>();
        let each = 1e3 * drawing.total.as_secs_f64() / f64::from(drawing.number.max(1));
        println!(
            "{} disks, {} pairs, {what}: {:.1} ms a frame ({:.1} in a second); drawn anew {} times, {each:.2} ms each",
            picture(world).frame.bodies.id.len(),
            picture(world).frame.pairs.a.len(),
            1e3 * frame,
            1.0 / frame,
            drawing.number,
        );
    });
}

pub fn run(scene: &str) -> ExitCode {
    drive::run(scene, |steps| {
        measure(steps, "at the start", false);
        steps.key(KeyCode::Space, false);
        steps.wait("the last stage", |world| {
            let [stage, stages] = picture(world).stage;
            stage == stages && picture(world).done[0] >= 2.0
        });
        measure(steps, "while the engine runs", false);
        steps.key(KeyCode::Space, false);
        steps.frames(30);
        measure(steps, "paused", false);
        measure(steps, "made anew in every frame", true);
        steps.act("all layers", |world| {
            let mut look = world.resource_mut::<Look>();
            (look.bonds, look.forces) = (true, true);
        });
        measure(steps, "with bonds and forces, anew", true);
    })
}
