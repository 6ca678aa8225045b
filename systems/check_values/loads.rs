//! Loads and springs that a program adds to a trial.

use clastic_components::contact::BodyTable;
use clastic_components::loads::TrialLoads;

use super::bad::{Bad, finite, not_negative};

/// Why the loads of a trial are refused; `None` if they are not.
pub(crate) fn refused_load(loads: &TrialLoads, bodies: &BodyTable) -> Option<String> {
    loads.iter().find_map(|(id, k, load)| {
        let Some(row) = bodies.row(id) else {
            let bad = Bad::new("body", id, "the identity of a body that is in the world");
            return Some(bad.in_words("a load of `AddTrialLoads`"));
        };
        let axis = (k > 2).then(|| Bad::new("degree of freedom", k, "0, 1 or 2 (x, y, rotation)"));
        let is_wall = bodies.wall(row as u32).is_some();
        let bad = axis
            .or_else(|| finite("force", load.force, "a force in N or a moment in N m"))
            .or_else(|| not_negative("stiffness", load.stiffness, "N/m or N m/rad, not below 0"))
            .or_else(|| {
                let is_member = bodies.group(row).is_some();
                let wanted = "0: a spring acts on a particle or on a rigid group as a whole";
                (load.stiffness > 0.0 && (is_wall || is_member))
                    .then(|| Bad::new("stiffness", load.stiffness, wanted))
            })?;
        let entity = bodies.entities[row];
        Some(bad.in_words(format_args!(
            "a load of `AddTrialLoads` on {}, entity {entity},",
            bodies.name(row)
        )))
    })
}
