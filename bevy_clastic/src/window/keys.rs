//! Keys.

use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, save_to_disk};

use super::help::Help;
use super::{Axes, Fit, Slider};
use crate::draw::{Look, Shown};
use crate::engine::{Engine, Measured, Order};
use crate::picture::Motion;

/// Paces, increments in a second. After the last one there is no limit.
const PACES: [f64; 8] = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];

/// The pace: its place among those that the keys go through.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Pace(usize);

impl Default for Pace {
    fn default() -> Self {
        Self(PACES.len())
    }
}

impl Pace {
    /// Maximum number of increments in a second; `None` without a limit.
    #[must_use]
    pub fn limit(self) -> Option<f64> {
        PACES.get(self.0).copied()
    }
}

pub(super) fn keys(
    keys: Res<ButtonInput<KeyCode>>,
    engine: Res<Engine>,
    measured: Res<Measured>,
    mut shown: ResMut<Shown>,
    mut look: ResMut<Look>,
    mut axes: ResMut<Axes>,
    mut slider: ResMut<Slider>,
    mut fit: ResMut<Fit>,
    mut pace: ResMut<Pace>,
    mut help: Single<&mut Visibility, With<Help>>,
    mut commands: Commands,
    mut pictures: Local<u32>,
) {
    let shift = keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]);
    for key in keys.get_just_pressed() {
        match key {
            KeyCode::Space => engine.order(Order::Run(shown.now.motion != Motion::Runs)),
            KeyCode::KeyN => engine.order(Order::Step(if shift { 10 } else { 1 })),
            KeyCode::BracketLeft | KeyCode::BracketRight => {
                let faster = *key == KeyCode::BracketRight;
                pace.0 = if faster { (pace.0 + 1).min(PACES.len()) } else { pace.0.max(1) - 1 };
                engine.order(Order::Pace(pace.limit()));
            }
            KeyCode::KeyK => engine.order(Order::Keep),
            KeyCode::KeyR => engine.order(Order::Restore),
            KeyCode::Home => engine.order(Order::Restart),
            KeyCode::KeyC => look.field = look.field.next(shift),
            KeyCode::KeyZ => shown.since = shown.now.clone(),
            KeyCode::Digit1 => look.disks = !look.disks,
            KeyCode::Digit2 => look.bonds = !look.bonds,
            KeyCode::Digit3 => look.forces = !look.forces,
            KeyCode::Digit4 => look.cracks = !look.cracks,
            KeyCode::Digit5 => look.walls = !look.walls,
            KeyCode::KeyX => axes.next(&measured.0, 0, shift),
            KeyCode::KeyV => axes.next(&measured.0, 1, shift),
            KeyCode::KeyL => slider.next(&shown.now.loads, shift),
            KeyCode::ArrowLeft | KeyCode::ArrowRight => {
                let steps = if *key == KeyCode::ArrowRight { 1.0 } else { -1.0 };
                slider.turn(&shown.now.loads, steps, &engine);
            }
            KeyCode::KeyF => fit.again(),
            KeyCode::Escape => (look.marked, look.marked_pair) = (None, None),
            KeyCode::KeyH => {
                **help = match **help {
                    Visibility::Hidden => Visibility::Visible,
                    _ => Visibility::Hidden,
                };
            }
            KeyCode::KeyP => {
                *pictures += 1;
                let path = format!("clastic_{:03}.png", *pictures);
                commands.spawn(Screenshot::primary_window()).observe(save_to_disk(path));
            }
            _ => {}
        }
    }
}
