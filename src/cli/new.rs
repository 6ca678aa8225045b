//! `clastic new`: commented scenes to start from.

use crate::scene::suggest;

use super::exit::{Exit, Failure, say};

/// Names and texts of the rigs, with what each is for.
const RIGS: [(&str, &str, &str); 5] = [
    ("biaxial", "cemented sand under a confining stress", include_str!("../../rigs/biaxial.ron")),
    ("column_collapse", "grains behind a gate", include_str!("../../rigs/column_collapse.ron")),
    ("direct_tension", "rock pulled apart", include_str!("../../rigs/direct_tension.ron")),
    ("hopper", "grains that fall through an outlet", include_str!("../../rigs/hopper.ron")),
    ("uniaxial", "rock between two platens", include_str!("../../rigs/uniaxial.ron")),
];

/// Prints a rig, or the names of all.
pub fn new(rig: Option<&str>) -> Result<Exit, Failure> {
    let Some(rig) = rig else {
        say("Rigs to start from; `clastic new RIG > my.ron` writes one:")?;
        for (name, what, _) in RIGS {
            say(format_args!("  {name:15}  {what}"))?;
        }
        return Ok(Exit::Ok);
    };
    let Some((_, _, text)) = RIGS.iter().find(|(name, _, _)| *name == rig) else {
        let names = RIGS.map(|(name, _, _)| name);
        let message = format!("no rig `{rig}`; {}", suggest::help(rig, &names, "rigs"));
        return Err(Failure { exit: Exit::Usage, message });
    };
    say(text.trim_end())?;
    Ok(Exit::Ok)
}
