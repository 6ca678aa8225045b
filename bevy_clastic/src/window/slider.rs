//! The slider of a load.

use std::collections::BTreeMap;

use bevy::prelude::*;
use bevy::ui::RelativeCursorPosition;

use super::panel::{Bar, Filled, Part};
use super::write;
use crate::draw::Shown;
use crate::draw::scale::with_unit;
use crate::engine::{Engine, Order};
use crate::picture::Load;

/// Parts of the range of a slider that a key moves it by.
const STEPS: f64 = 20.0;
/// Upper end of the slider of gravity, m/s^2: two times that of the earth.
const GRAVITY: f64 = 19.62;

/// The load of the slider, the ranges, and the value that the engine does not have yet.
#[derive(Resource, Clone, Debug, Default)]
pub struct Slider {
    name: Option<String>,
    /// Ends by name: 0 and twice the first value of the stage that is not 0.
    ranges: BTreeMap<String, [f64; 2]>,
    /// Number of the stage.
    stage: usize,
    asked: Option<Load>,
    is_held: bool,
}

impl Slider {
    /// The load that the slider changes: the one that was chosen, or the last one that acts.
    fn load<'a>(&self, loads: &'a [Load]) -> Option<&'a Load> {
        let chosen = loads.iter().find(|load| Some(load.name()) == self.name);
        chosen.or_else(|| loads.iter().rfind(|load| load.value != 0.0)).or(loads.first())
    }

    /// Another load.
    pub(super) fn next(&mut self, loads: &[Load], back: bool) {
        let Some(now) = self.load(loads) else { return };
        let n = loads.len();
        let at = loads.iter().position(|load| load == now).unwrap_or(0);
        self.name = Some(loads[(at + if back { n - 1 } else { 1 }) % n].name());
    }

    /// Moves the slider by some steps.
    pub(super) fn turn(&mut self, loads: &[Load], steps: f64, engine: &Engine) {
        let Some(load) = self.load(loads).cloned() else { return };
        let [low, high] = self.range(&load);
        let value = self.value(&load) + steps * (high - low) / STEPS;
        // Without digits of round-off.
        let value = format!("{:.6e}", value.clamp(low, high)).parse().unwrap_or(value);
        self.ask(Load { value, ..load }, engine);
    }

    fn ask(&mut self, load: Load, engine: &Engine) {
        self.name = Some(load.name());
        self.asked = Some(load.clone());
        engine.order(Order::Load(load));
    }

    /// The value that was asked for, until the engine has it.
    fn value(&self, load: &Load) -> f64 {
        let asked = self.asked.as_ref().filter(|asked| asked.name() == load.name());
        asked.map_or(load.value, |asked| asked.value)
    }

    fn range(&mut self, load: &Load) -> [f64; 2] {
        if load.of.is_empty() {
            return [0.0, GRAVITY];
        }
        if load.value == 0.0 {
            return self.ranges.get(&load.name()).copied().unwrap_or([0.0, 1.0]);
        }
        let ends = [(2.0 * load.value).min(0.0), (2.0 * load.value).max(0.0)];
        *self.ranges.entry(load.name()).or_insert(ends)
    }
}

/// Whether two values differ by round-off alone.
fn is_near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * b.abs()
}

/// Moves the slider with the mouse.
pub(super) fn drag(
    buttons: Res<ButtonInput<MouseButton>>,
    bar: Single<&RelativeCursorPosition, With<Bar>>,
    shown: Res<Shown>,
    engine: Res<Engine>,
    mut slider: ResMut<Slider>,
) {
    if buttons.just_pressed(MouseButton::Left) && bar.cursor_over() {
        slider.is_held = true;
    }
    if !buttons.pressed(MouseButton::Left) && slider.is_held {
        slider.is_held = false;
    }
    let (true, Some(at)) = (slider.is_held, bar.normalized) else { return };
    let Some(load) = slider.load(&shown.now.loads).cloned() else { return };
    let [low, high] = slider.range(&load);
    let part = (f64::from(at.x) + 0.5).clamp(0.0, 1.0);
    // In hundredths of the range, so that a held slider asks for nothing new.
    let value = low + (100.0 * part).round() / 100.0 * (high - low);
    if value != slider.value(&load) {
        slider.ask(Load { value, ..load }, &engine);
    }
}

pub(super) fn show(
    shown: Res<Shown>,
    mut slider: ResMut<Slider>,
    mut filled: Single<&mut Node, With<Filled>>,
    mut texts: Query<(&Part, &mut Text)>,
) {
    if !shown.is_changed() && !slider.is_changed() {
        return;
    }
    let loads = &shown.now.loads;
    if slider.stage != shown.now.stage[0] {
        slider.stage = shown.now.stage[0];
        slider.ranges.clear();
        slider.asked = None;
    }
    if shown.is_changed()
        && let Some(asked) = &slider.asked
        && loads.iter().any(|load| load.name() == asked.name() && is_near(load.value, asked.value))
    {
        slider.asked = None;
    }
    let Some(load) = slider.load(loads).cloned() else { return };
    let [low, high] = slider.bypass_change_detection().range(&load);
    let value = slider.value(&load);
    let part = ((value - low) / (high - low)).clamp(0.0, 1.0);
    let width = percent(100.0 * part as f32);
    if filled.width != width {
        filled.width = width;
    }
    let at = loads.iter().position(|other| *other == load).map_or(0, |k| k + 1);
    let label = format!(
        "{}: {}\n    {} to {}; load {at} of {} (L)",
        load.name(),
        // No minus before a zero.
        with_unit(value + 0.0, load.unit),
        with_unit(low, load.unit),
        with_unit(high, load.unit),
        loads.len()
    );
    for (part, mut text) in &mut texts {
        if *part == Part::Load {
            write(&mut text, &label);
        }
    }
}
