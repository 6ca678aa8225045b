//! The window: camera, keys, panel with legend, curve and slider, and what is picked.

mod camera;
mod curve;
mod help;
mod keys;
mod legend;
mod panel;
mod pick;
mod plot;
mod slider;
mod status;

pub use camera::Fit;
pub use curve::Axes;
pub use keys::Pace;
pub use slider::Slider;

use bevy::prelude::*;
use bevy::window::WindowResolution;

use crate::draw::DrawPlugin;
use crate::engine::EnginePlugin;

/// Width of the panel on the right, pixels.
pub const PANEL: f32 = 360.0;
/// Units of Bevy's space in a metre: a millimetre is one.
pub const SCALE: f32 = 1.0e3;

/// Colour of texts.
const INK: Color = Color::srgb(0.13, 0.15, 0.18);
/// Colour of texts that matter less.
const PALE_INK: Color = Color::srgb(0.40, 0.43, 0.47);
/// Background of the panel.
const PAPER: Color = Color::srgb(0.955, 0.96, 0.965);
/// Colour of the curve and of the slider.
const ACCENT: Color = Color::srgb(0.08, 0.25, 0.48);

/// The window of an [`Engine`](crate::engine::Engine), which the app needs as a resource, in an app
/// with `DefaultPlugins`.
pub struct LivePlugin;

impl Plugin for LivePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((DrawPlugin { scale: SCALE }, EnginePlugin))
            .insert_resource(ClearColor(Color::WHITE))
            .init_resource::<Fit>()
            .init_resource::<Axes>()
            .init_resource::<Slider>()
            .init_resource::<Pace>()
            .add_systems(Startup, (camera::spawn, panel::spawn, help::spawn).chain())
            .add_systems(
                Update,
                (
                    keys::keys,
                    camera::zoom,
                    camera::drag,
                    camera::fit,
                    pick::pick,
                    slider::drag,
                    slider::show,
                    curve::choose,
                    curve::show,
                    legend::show,
                    status::show,
                    pick::show,
                )
                    .chain(),
            );
    }
}

/// The window as the program opens it.
#[must_use]
pub fn window(title: String) -> Window {
    Window { title, resolution: WindowResolution::new(1280, 860), ..default() }
}

/// A text of the panel.
fn text(size: f32, colour: Color) -> (Text, TextFont, TextColor) {
    (Text::default(), TextFont::from_font_size(size), TextColor(colour))
}

/// Replaces a text, if it differs. Letters that the font lacks have others in their place.
fn write(text: &mut Mut<Text>, new: &str) {
    let new = new.replace('µ', "u");
    if text.0 != new {
        text.0 = new;
    }
}
