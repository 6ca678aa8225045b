//! The bonds on a limit at the end of an increment break together, where no
//! [event](super::events) is sought. It is the last word on an accepted attempt and objects to none.

use bevy_ecs::prelude::*;

use clastic_components::contact::{BodyTable, ContactTable};
use clastic_components::findings::Ruptures;
use clastic_components::increment::{ClasticProgress, RuptureRules};
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::bonds::{Met, find_ruptures};

/// Collects the bonds that the increment breaks.
pub fn collect(
    rules: Res<RuptureRules>,
    progress: Res<ClasticProgress>,
    bodies: Res<BodyTable>,
    contacts: Res<ContactTable>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    mut ruptures: ResMut<Ruptures>,
) {
    let (increment, contacts) = (progress.increment, &contacts.0);
    let found =
        find_ruptures(&rules, Met::Slack, increment, &bodies, contacts, &program, &solution);
    ruptures.list.extend(found);
}
