//! The saved state from which a scene starts.

use std::collections::{BTreeMap, BTreeSet};

use crate::scene::diagnostic::MAX_SHOWN;
use crate::scene::spans::join;
use crate::scene::suggest;

use super::findings::Findings;
use super::outline::not_behind;

pub(super) fn check(renamed: &BTreeMap<String, String>, findings: &mut Findings) {
    let context = findings.context;
    for (name, new) in renamed {
        let path = join("specimen.materials", name);
        let known = &context.materials;
        findings.reference(format_args!("{path}"), new, ("material", "materials"), known);
    }
    // A run that is resumed does not read the state again.
    let Some(stored) = context.specimen.filter(|_| context.starts_here()) else { return };
    let Some(state) = &stored.state else { return };
    let Some(saved) = &state.saved else { return };
    let there: Vec<&str> = saved.materials.iter().map(|(name, _)| name.as_str()).collect();
    for name in renamed.keys().filter(|name| !there.contains(&name.as_str())) {
        let path = join("specimen.materials", name);
        let help = suggest::help(name, &there, "materials of the state");
        findings.add_at_key(
            format_args!("{path}"),
            format!("the state has no material `{name}`"),
            &help,
        );
    }
    let used: BTreeSet<&str> =
        stored.rows.iter().filter_map(|row| row.material.as_deref()).collect();
    let lost = used.iter().filter(|name| !context.materials.contains(name));
    // A name that `materials` gives is reported there.
    for name in lost.filter(|name| !renamed.values().any(|new| new == *name)) {
        if findings.is_sure_of("materials") {
            let message = format!("the scene lacks material `{name}` of the state");
            let help = format!(
                "add it to `materials` of the scene, or rename it: materials: {{{name:?}: NAME}}, \
                 with one of {}",
                suggest::list(&context.materials)
            );
            findings.add(format_args!("specimen"), message, &help);
        }
    }
    if !state.gives_walls {
        for name in saved.groups_with_walls().unwrap_or_default() {
            let message =
                format!("walls of the state, which belong to its rigid group `{name}`, go");
            let help = "release the group in the run that saves, or leave `walls` out";
            findings.add(format_args!("walls"), message, help);
        }
        let before = findings.len();
        for (i, row) in stored.rows.iter().enumerate() {
            let whose = format!("particle {i} of the state");
            let path = format_args!("specimen.path");
            not_behind(path, &whose, (row.x, row.y), row.r, findings);
            if findings.len() >= before + MAX_SHOWN {
                return;
            }
        }
    }
}
