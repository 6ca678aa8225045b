//! Judge: does a time step take a particle through a thin wall?
//!
//! The program has the normal of the start. A particle that travels by many radii may find the wall
//! elsewhere: beyond the tangent of an arc, or past the corner of two segments. The step is then halved.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::{BodyTable, ContactTable, WallRow};
use clastic_components::findings::{Impacts, Pushed};
use clastic_components::increment::{Acceptance, AnalysisKind, ClasticAnalysis, ClasticProgress};
use clastic_cone::program::{ConeProgram, ConeSolution};

use crate::impacts::paths::paths;
use crate::moved::Moved;
use crate::places::near;

/// Rejects a time step in which the centre of a particle passes through a thin wall.
pub fn judge(
    settings: (Res<Acceptance>, Res<ClasticAnalysis>, Res<ClasticProgress>),
    bodies: Res<BodyTable>,
    contacts: Res<ContactTable>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    (pushed, impacts): (Res<Pushed>, Res<Impacts>),
    mut attempt: ResMut<Attempt>,
) {
    let (acceptance, analysis, progress) = settings;
    let is_dynamic = matches!(analysis.kind, AnalysisKind::Dynamic { .. });
    if !is_dynamic || bodies.walls.iter().all(WallRow::is_line) {
        return;
    }
    let (bodies, contacts) = (&*bodies, &*contacts);
    let motion =
        paths(bodies, contacts, &analysis, &acceptance, &progress, &program, &solution, &impacts);
    // A motion that separates overlaps moves the bodies instead.
    let motion = pushed.0.as_ref().or(motion.as_ref()).unwrap_or(&solution.displacements);
    if let Some(pair) = Moved::by(bodies, &program, motion, 1.0).first_through(bodies) {
        let pair = near(bodies, pair);
        attempt.verdict =
            Verdict::TooFar(format!("a time step takes one through the other: {pair}"));
    }
}
