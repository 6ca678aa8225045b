//! Walls that stages add. Where the particles are by then is not known, but if all of them start
//! behind a wall, it is drawn from its end to its start.

use super::findings::Findings;
use super::places::is_behind;
use crate::run::particles::ParticleSeed;
use crate::scene::format::Stage;

/// Checks that no wall comes with the whole specimen behind it. Particles that pour in or that a
/// plugin moves may be elsewhere by then.
pub(super) fn check(findings: &mut Findings) {
    let context = findings.context;
    let scene = context.scene;
    let comes = |name: &str| {
        let is_known = |stage: &&Stage| !matches!(stage, Stage::Pour(_) | Stage::Custom(_));
        let mut loads = scene.stages.iter().take_while(is_known).filter_map(Stage::load);
        loads.find(|load| load.add_walls.iter().any(|wall| wall == name))
    };
    let absent = scene.walls.iter().enumerate().filter(|(_, wall)| !wall.present);
    let added: Vec<_> =
        absent.filter_map(|(i, wall)| Some((i, wall, comes(&wall.name)?))).collect();
    let sound = findings.are_sound(&["specimen", "walls", "stages"]);
    if added.is_empty() || !context.is_read() || context.is_resumed() || !sound {
        return;
    }
    let seeds = context.at_start();
    for (i, wall, stage) in added {
        let place = |seed: &ParticleSeed| (seed.position.x, seed.position.y);
        let behind = |seed: &ParticleSeed| is_behind(wall, place(seed), seed.radius);
        if !seeds.is_empty() && seeds.iter().all(behind) {
            let message = format!(
                "the whole specimen is behind this wall, which stage `{}` adds",
                stage.name
            );
            let help = "exchange start and end: a wall has its inside on the left of start to end";
            findings.add(format_args!("walls[{i}]"), message, help);
        }
    }
}
