//! Judge: does a time step take a particle through a thin wall?
//!
//! The program has the normal of the start. A particle that travels by many radii may find the wall
//! elsewhere: beyond the tangent of an arc, or past the corner of two segments. The step is then halved.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::WallRow;
use clastic_components::increment::{AnalysisKind, ClasticAnalysis};

use crate::impacts::paths::Paths;
use crate::moved::Moved;
use crate::places::near;
use crate::solved::SolvedTables;

/// Rejects a time step in which the centre of a particle passes through a thin wall.
pub fn judge(
    analysis: Res<ClasticAnalysis>,
    tables: SolvedTables,
    paths: Paths,
    mut attempt: ResMut<Attempt>,
) {
    let solved = tables.get();
    let bodies = solved.bodies;
    let is_dynamic = matches!(analysis.kind, AnalysisKind::Dynamic { .. });
    if !is_dynamic || bodies.walls.iter().all(WallRow::is_line) {
        return;
    }
    let motion = paths.motion(solved);
    if let Some(pair) = Moved::by(solved, &motion, 1.0).first_through(bodies) {
        let pair = near(bodies, pair);
        attempt.verdict =
            Verdict::TooFar(format!("a time step takes one through the other: {pair}"));
    }
}
