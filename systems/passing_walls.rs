//! Halts a run in which two walls that face each other would change sides.
//!
//! Beyond that no place is inside of both, and elastic contacts would overlap further and further.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;

use crate::schedule::ClasticHalted;

/// Two inward normals with this cosine or less are opposite.
const OPPOSITE: f64 = 1e-9 - 1.0;

/// Looks at what is left of the imposed motions of the increment. Runs after bodies are gathered.
pub(crate) fn refuse_passing_walls(
    bodies: Res<BodyTable>,
    progress: Res<ClasticProgress>,
    mut commands: Commands,
) {
    let left = 1.0 - progress.done.fract();
    let inward = |wall: &WallRow| match bodies.wall_drive(wall) {
        WallDrive::Imposed(u) => left * u.dot(wall.inward),
        _ => 0.0,
    };
    let lines = || bodies.walls.iter().filter(|wall| wall.is_line());
    for (k, a) in lines().enumerate() {
        for b in lines().skip(k + 1).filter(|b| a.inward.dot(b.inward) <= OPPOSITE) {
            let [from, to] = [a, b].map(|wall| wall.body as usize);
            let distance = (bodies.positions[to] - bodies.positions[from]).dot(a.inward);
            let closing = inward(a) + inward(b);
            if closing > 0.0 && distance <= closing {
                commands.insert_resource(ClasticHalted(format!(
                    "{} and {} would meet or pass each other: they are {distance:.4e} m apart and close by \
                     {closing:.4e} m in this increment; give less motion, or end the stage before",
                    bodies.name(from),
                    bodies.name(to)
                )));
                return;
            }
        }
    }
}
