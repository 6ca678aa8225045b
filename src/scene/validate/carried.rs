//! Stresses that walls keep from stage to stage, on the distance of two walls: both must stay.

use clastic_components::body::BodyId;
use clastic_components::wall::{WallControl, WallName};
use clastic_systems::wall_states::{ControlStates, WALL_CONTROL};

use crate::scene::StoredSpecimen;
use crate::scene::format::Load;

use super::findings::At;

/// A wall that keeps a stress, and the two walls on whose distance it acts.
pub(super) struct Carried {
    wall: String,
    between: (String, String),
}

/// The stresses of a saved state from which the scene starts with its walls.
pub(super) fn inherited(specimen: Option<&StoredSpecimen>) -> Vec<Carried> {
    let state = specimen.and_then(StoredSpecimen::gives_walls);
    let Some(saved) = state.and_then(|state| state.saved.as_ref()) else { return Vec::new() };
    let (Ok(controls), Ok(names)) = (
        saved.world.get::<ControlStates>(WALL_CONTROL),
        saved.world.components::<BodyId, WallName>("wall_name"),
    ) else {
        return Vec::new();
    };
    let name = |id: BodyId| {
        names.iter().find(|(other, _)| *other == id).map(|(_, WallName(name))| name.clone())
    };
    let carried = |(id, control, between): (_, _, [_; 2])| match (control, between) {
        (WallControl::Stress { .. }, [Some(a), Some(b)]) => {
            Some(Carried { wall: name(id)?, between: (name(a)?, name(b)?) })
        }
        _ => None,
    };
    controls.0.into_iter().filter_map(carried).collect()
}

/// Checks the walls that a stage removes; `carried` are the stresses from before, and afterwards
/// those that the next stage finds.
pub(super) fn check(at: &mut At, stage: &Load, carried: &mut Vec<Carried>) {
    let is_gone = |wall: &String| stage.remove_walls.contains(wall);
    // A wall with a control of its own, or that goes, no longer has the stress from before.
    carried.retain(|Carried { wall, .. }| !stage.walls.contains_key(wall) && !is_gone(wall));
    for (i, gone) in stage.remove_walls.iter().enumerate() {
        let needs = |carried: &&Carried| carried.between.0 == *gone || carried.between.1 == *gone;
        let keeps: Vec<_> = carried.iter().filter(needs).collect();
        if let [Carried { wall, between: (a, b) }, ..] = keeps[..]
            && at.are_sure_of(&["stages", "walls"])
        {
            let message = format!(
                "the stress that wall `{wall}` keeps acts on the distance of walls `{a}` and `{b}`"
            );
            let others = keeps.iter().map(|carried| format!("\"{}\": Fixed", carried.wall));
            let others = others.collect::<Vec<_>>().join(", ");
            let help = format!("give it another control in this stage: `walls: {{ {others} }}`");
            at.add(format_args!("remove_walls[{i}]"), message, help);
        }
    }
    carried.retain(|Carried { between: (a, b), .. }| !is_gone(a) && !is_gone(b));
    for (wall, control) in &stage.walls {
        if let Some(Some(between)) = control.loaded_between() {
            carried.push(Carried { wall: wall.clone(), between: between.clone() });
        }
    }
}
