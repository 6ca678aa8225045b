//! `clastic new`: commented scenes to start from.

use crate::scene::format::Specimen;
use crate::scene::{load, shipped};
use crate::text::suggest;

use super::exit::{Exit, Failure, complain, say};

/// Names and texts of the rigs, with what each is for.
const RIGS: [(&str, &str, &str); 5] = [
    ("biaxial", "cemented sand under a confining stress", include_str!("../../rigs/biaxial.ron")),
    ("column_collapse", "grains behind a gate", include_str!("../../rigs/column_collapse.ron")),
    ("direct_tension", "rock pulled apart", include_str!("../../rigs/direct_tension.ron")),
    ("hopper", "grains that fall through an outlet", include_str!("../../rigs/hopper.ron")),
    ("uniaxial", "rock between two platens", include_str!("../../rigs/uniaxial.ron")),
];

/// Prints a rig or a shipped scene, or the names of all rigs.
pub fn new(name: Option<&str>) -> Result<Exit, Failure> {
    let Some(name) = name else {
        say("Rigs to start from; `clastic new RIG > my.ron` writes one:")?;
        for (name, what, _) in RIGS {
            say(format_args!("  {name:15}  {what}"))?;
        }
        say("and the scenes of `clastic list` that clastic ships, `clastic new footing > my.ron`")?;
        return Ok(Exit::Ok);
    };
    if let Some((_, _, text)) = RIGS.iter().find(|(rig, _, _)| *rig == name) {
        say(text.trim_end())?;
        return Ok(Exit::Ok);
    }
    let Some(path) = shipped::path(name) else {
        let names: Vec<_> = RIGS.iter().map(|(rig, ..)| *rig).chain(shipped::names()).collect();
        let help = suggest::help(name, &names, "rigs and scenes");
        let message = format!("no rig or shipped scene `{name}`; {help}");
        return Err(Failure::new(Exit::Usage, message));
    };
    let loaded = load(&path, &[])?;
    say(loaded.text.trim_end())?;
    if let Specimen::File { path, .. } | Specimen::State { path, .. } = &loaded.scene.specimen {
        complain(format_args!(
            "note: it reads `{path}`, which is part of clastic (scenes/{path} in its sources): put a copy beside \
             the scene"
        ));
    }
    Ok(Exit::Ok)
}
