//! The saved state from which a scene starts.

use std::collections::{BTreeMap, BTreeSet};

use crate::scene::diagnostic::MAX_SHOWN;
use crate::scene::suggest;

use super::findings::At;
use super::places::not_behind;

pub(super) fn check(at: &mut At, renamed: &BTreeMap<String, String>) {
    let context = at.context;
    for (name, new) in renamed {
        at.entry("specimen.materials", name).material("", new);
    }
    // A run that is resumed does not read the state again.
    let Some(stored) = context.specimen else { return };
    let Some(state) = &stored.state else { return };
    let Some(saved) = &state.saved else { return };
    let there: Vec<&str> = saved.materials.iter().map(|(name, _)| name.as_str()).collect();
    for name in renamed.keys().filter(|name| !there.contains(&name.as_str())) {
        let help = suggest::help(name, &there, "materials of the state");
        let message = format!("the state has no material `{name}`");
        at.entry("specimen.materials", name).add_at_key(message, help);
    }
    let used: BTreeSet<&str> =
        stored.rows.iter().filter_map(|row| row.material.as_deref()).collect();
    let lost = used.iter().filter(|name| !context.materials.contains(name));
    // A name that `materials` gives is reported there.
    for name in lost.filter(|name| !renamed.values().any(|new| new == *name)) {
        if at.is_sure_of("materials") {
            let message = format!("the scene lacks material `{name}` of the state");
            let help = format!(
                "add it to `materials` of the scene, or rename it: materials: {{{name:?}: NAME}}, \
                 with one of {}",
                suggest::list(&context.materials)
            );
            at.add("specimen", message, help);
        }
    }
    if state.gives_walls {
        return;
    }
    for name in saved.groups_with_walls().unwrap_or_default() {
        let message = format!("walls of the state, which belong to its rigid group `{name}`, go");
        let help = "release the group in the run that saves, or leave `walls` out";
        at.add("walls", message, help);
    }
    let before = at.list.len();
    for (i, row) in stored.rows.iter().enumerate() {
        let whose = format!("particle {i} of the state");
        not_behind(at, "specimen.path", &whose, (row.x, row.y), row.r);
        if at.list.len() >= before + MAX_SHOWN {
            return;
        }
    }
}
