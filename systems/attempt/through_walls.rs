//! Judge: does a solution take a particle through a thin wall?
//!
//! The program has the normal of the start. Where particle and wall move by radii relative to each other,
//! they may meet elsewhere: beyond the tangent of an arc, or past the corner of two segments. A time
//! step is then halved; in statics the motion is followed first.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::WallRow;

use crate::impacts::paths::Paths;
use crate::moved::Moved;
use crate::places::near;
use crate::solved::SolvedTables;

/// Rejects a solution in which the centre of a particle passes through a thin wall.
pub fn judge(tables: SolvedTables, paths: Paths, mut attempt: ResMut<Attempt>) {
    let solved = tables.get();
    let bodies = solved.bodies;
    if bodies.walls.iter().all(WallRow::is_line) {
        return;
    }
    let motion = paths.motion(solved);
    if let Some(pair) = Moved::by(solved, &motion, 1.0).first_through(bodies) {
        let pair = near(bodies, pair);
        attempt.verdict = Verdict::TooFar(format!("one passes through the other: {pair}"));
    }
}
