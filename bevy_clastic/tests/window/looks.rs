//! Pictures of scenes in several colours, to be looked at. A scene must come to its end.

use std::process::ExitCode;

use bevy::prelude::*;
use bevy_clastic::draw::{Field, Look};
use bevy_clastic::picture::Motion;

use super::drive::{self, Steps, picture};

pub fn run(scene: &str) -> ExitCode {
    drive::run(scene, |steps| {
        steps.shot(&format!("{scene}_start"));
        steps.key(KeyCode::Space, false);
        steps.wait("the last stage", |world| {
            let [stage, stages] = picture(world).stage;
            let [done, total] = picture(world).done;
            stage == stages && done >= 0.3 * total && total > 0.0
        });
        for field in [Field::Displacement, Field::Rotation] {
            colour(steps, field);
        }
        steps.shot(&format!("{scene}_during"));
        steps.wait("the end", |world| matches!(picture(world).motion, Motion::Stopped(_)));
        colour(steps, Field::Fragment);
        steps.shot(&format!("{scene}_end"));
        steps.act("bonds and forces", |world| {
            let mut look = world.resource_mut::<Look>();
            (look.field, look.bonds, look.forces) = (Field::Coordination, true, true);
        });
        steps.shot(&format!("{scene}_forces"));
    })
}

fn colour(steps: &mut Steps, field: Field) {
    steps.act("field", move |world| world.resource_mut::<Look>().field = field);
}
