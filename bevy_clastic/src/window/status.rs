//! Title, stage, increment and what the engine does.

use std::time::Instant;

use bevy::prelude::*;

use super::panel::Part;
use super::{Pace, write};
use crate::draw::Shown;
use crate::draw::scale::with_unit;
use crate::engine::Engine;
use crate::picture::Motion;

/// Time without a new state after which the window says that the engine is at work, s.
const LONG: f32 = 1.0;

/// When the last state came, and the increments in a second.
pub(super) struct Rate {
    at: Instant,
    increment: u64,
    rate: f64,
}

impl Default for Rate {
    fn default() -> Self {
        Self { at: Instant::now(), increment: 0, rate: 0.0 }
    }
}

pub(super) fn show(
    shown: Res<Shown>,
    engine: Res<Engine>,
    pace: Res<Pace>,
    mut rate: Local<Rate>,
    mut texts: Query<(&Part, &mut Text)>,
) {
    let now = &shown.now;
    let waits = rate.at.elapsed().as_secs_f32();
    if now.frame.increment != rate.increment && waits > 0.5 || now.motion != Motion::Runs {
        let made = now.frame.increment.saturating_sub(rate.increment);
        let (increment, seconds) = (now.frame.increment, f64::from(waits).max(1e-3));
        *rate = Rate { at: Instant::now(), increment, rate: made as f64 / seconds };
    }
    let motion = match &now.motion {
        _ if engine.has_panicked() => "the engine has panicked; see the terminal".to_owned(),
        Motion::Paused => "paused (space goes on)".to_owned(),
        Motion::Stopped(why) => format!("stopped: {why}"),
        Motion::Runs if waits > LONG => format!("in an increment for {waits:.0} s"),
        Motion::Runs => format!("{:.1} increments/s", rate.rate),
    };
    let pace = pace.limit().map_or_else(String::new, |limit| format!(", at most {limit}/s"));
    let [stage, stages] = now.stage;
    let mut status = String::new();
    if now.frame.stage.is_empty() && stages > 0 {
        status += &format!("before the first of {stages} stages\n");
    } else if stages > 0 {
        let [done, total] = now.done;
        let name = &now.frame.stage;
        status += &format!("stage {stage} of {stages}: {name}, {done:.0} of {total:.0}\n");
    }
    status += &format!("increment {}", now.frame.increment);
    if now.time_step.is_some() {
        status += &format!(", time {}", with_unit(now.frame.time_s, "s"));
    }
    let broken: usize = now.broken.iter().sum();
    status += &format!("\n{motion}{pace}\n{} disks", now.frame.bodies.id.len());
    if now.bonds + broken > 0 {
        status += &format!(", {} bonds, {broken} broken", now.bonds);
    }
    let kept = now.kept.map_or("the start".to_owned(), |kept| format!("increment {kept}"));
    status += &format!("\nR goes back to {kept}; H: keys");
    for (part, mut text) in &mut texts {
        match part {
            Part::Title => write(&mut text, &now.title),
            Part::Status => write(&mut text, &status),
            Part::Answer => write(&mut text, &now.answer),
            _ => {}
        }
    }
}
