//! The camera: pan, zoom, and a view of the whole specimen.

use bevy::input::mouse::{AccumulatedMouseMotion, MouseScrollUnit, MouseWheel};
use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use clastic::output::view::{near, range};
use glam::DVec2;

use super::{PANEL, SCALE};
use crate::draw::Shown;

/// Part of the window that is left free around the specimen.
const MARGIN: f32 = 0.06;
/// Change of the extent of the specimen, over its size, at which the view follows.
const FOLLOW: f64 = 0.1;

/// Whether the view follows the specimen, and the box that it shows, m. Panning and zooming end it.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Fit {
    /// Whether it follows.
    pub follows: bool,
    shown: Option<[DVec2; 2]>,
    /// Size of the window.
    window: Vec2,
}

impl Default for Fit {
    fn default() -> Self {
        Self { follows: true, shown: None, window: Vec2::ZERO }
    }
}

impl Fit {
    /// Shows the whole specimen, and follows it.
    pub fn again(&mut self) {
        *self = Self::default();
    }
}

pub(super) fn spawn(mut commands: Commands) {
    commands.spawn((Camera2d, Msaa::Off));
}

/// Centre of the part of the window beside the panel, over the size of the window.
fn origin(window: &Window) -> Vec2 {
    let width = window.width().max(1.0);
    Vec2::new(0.5 * (width - PANEL).max(0.0) / width, 0.5)
}

/// Position of the cursor, if it is beside the panel.
pub(super) fn cursor(window: &Window) -> Option<Vec2> {
    window.cursor_position().filter(|at| at.x < window.width() - PANEL)
}

/// Zooms about the cursor.
pub(super) fn zoom(
    mut wheel: MessageReader<MouseWheel>,
    window: Single<&Window, With<PrimaryWindow>>,
    camera: Single<(&Camera, &GlobalTransform, &mut Transform, &mut Projection)>,
    mut fit: ResMut<Fit>,
) {
    let turned = |event: &MouseWheel| match event.unit {
        MouseScrollUnit::Line => event.y,
        MouseScrollUnit::Pixel => event.y / 40.0,
    };
    let turned: f32 = wheel.read().map(turned).sum();
    let (camera, global, mut place, mut projection) = camera.into_inner();
    let Some(at) = cursor(&window).filter(|_| turned != 0.0) else { return };
    let (Ok(at), Projection::Orthographic(projection)) =
        (camera.viewport_to_world_2d(global, at), &mut *projection)
    else {
        return;
    };
    let factor = 1.15_f32.powf(-turned);
    projection.scale *= factor;
    let centre = place.translation.truncate();
    place.translation = (at + factor * (centre - at)).extend(place.translation.z);
    fit.follows = false;
}

/// Moves the view with the mouse.
pub(super) fn drag(
    buttons: Res<ButtonInput<MouseButton>>,
    motion: Res<AccumulatedMouseMotion>,
    window: Single<&Window, With<PrimaryWindow>>,
    camera: Single<(&mut Transform, &Projection), With<Camera2d>>,
    mut fit: ResMut<Fit>,
) {
    let held = [MouseButton::Left, MouseButton::Middle, MouseButton::Right];
    if !buttons.any_pressed(held) || motion.delta == Vec2::ZERO || cursor(&window).is_none() {
        return;
    }
    let (mut place, projection) = camera.into_inner();
    let Projection::Orthographic(projection) = projection else { return };
    let moved = projection.scale * motion.delta * Vec2::new(-1.0, 1.0);
    place.translation += moved.extend(0.0);
    fit.follows = false;
}

/// Shows the whole specimen, while the view follows it.
pub(super) fn fit(
    shown: Res<Shown>,
    window: Single<&Window, With<PrimaryWindow>>,
    camera: Single<(&mut Transform, &mut Projection), With<Camera2d>>,
    mut fit: ResMut<Fit>,
) {
    let size = Vec2::new(window.width(), window.height());
    if !shown.is_changed() && !fit.is_changed() && size == fit.window {
        return;
    }
    let (mut place, mut projection) = camera.into_inner();
    let Projection::Orthographic(projection) = &mut *projection else { return };
    if size != fit.window {
        projection.viewport_origin = origin(&window);
        (fit.window, fit.shown) = (size, None);
    }
    let Some([low, high]) = bounds(&shown).filter(|_| fit.follows) else { return };
    let extent = (high - low).max_element();
    let moved = |[l, h]: [DVec2; 2]| l.distance(low).max(h.distance(high)) > FOLLOW * extent;
    if fit.shown.is_some_and(|before| !moved(before)) {
        return;
    }
    fit.shown = Some([low, high]);
    let room = (1.0 - 2.0 * MARGIN) * Vec2::new(size.x - PANEL, size.y).max(Vec2::splat(50.0));
    let extent = SCALE * (high - low).as_vec2();
    projection.scale = (extent / room).max_element();
    let centre = SCALE * (0.5 * (low + high)).as_vec2();
    place.translation = centre.extend(place.translation.z);
}

/// The box of the specimen without its stray disks, and of its walls near it, m.
fn bounds(shown: &Shown) -> Option<[DVec2; 2]> {
    let frame = &shown.now.frame;
    let ends = |axis: usize, sign: f64| {
        let end = |(row, r): (usize, &f32)| frame.centre(row)[axis] + sign * f64::from(*r);
        frame.bodies.radius_m.iter().enumerate().map(end).collect()
    };
    let [left, right] = range(ends(0, -1.0), ends(0, 1.0))?;
    let [bottom, top] = range(ends(1, -1.0), ends(1, 1.0))?;
    let disks = (DVec2::new(left, bottom), DVec2::new(right, top));
    let walls: Vec<[DVec2; 2]> = (0..frame.walls.id.len())
        .flat_map(|wall| frame.wall_line(wall).windows(2))
        .map(|ends| [DVec2::from(ends[0]), DVec2::from(ends[1])])
        .collect();
    let fold = |(low, high): (DVec2, DVec2), x: DVec2| (low.min(x), high.max(x));
    let (low, high) = near(disks, &walls).fold(disks, fold);
    Some([low, high])
}
