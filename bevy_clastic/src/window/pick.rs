//! A grain or a pair of bodies is picked with a click, and its values are shown.

use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use clastic::frames::{Frame, NONE, STATES};
use glam::DVec2;

use super::panel::Part;
use super::{SCALE, camera, write};
use crate::draw::scale::with_unit;
use crate::draw::{Look, Shown, contacts};

/// A click within this part of the smaller radius from a contact point picks the pair.
const NEAR: f64 = 0.3;
/// Motion of the mouse, pixels, from which a press is no click.
const STILL: f32 = 4.0;

/// Picks what is under the cursor when the mouse is released where it was pressed.
pub(super) fn pick(
    buttons: Res<ButtonInput<MouseButton>>,
    window: Single<&Window, With<PrimaryWindow>>,
    camera: Single<(&Camera, &GlobalTransform), With<Camera2d>>,
    shown: Res<Shown>,
    mut look: ResMut<Look>,
    mut pressed: Local<Option<Vec2>>,
) {
    let at = camera::cursor(&window);
    if buttons.just_pressed(MouseButton::Left) {
        *pressed = at;
    }
    if !buttons.just_released(MouseButton::Left) {
        return;
    }
    let (Some(from), Some(at)) = (pressed.take(), at) else { return };
    if from.distance(at) > STILL {
        return;
    }
    let (camera, global) = *camera;
    let Ok(at) = camera.viewport_to_world_2d(global, at) else { return };
    let at = at.as_dvec2() / f64::from(SCALE);
    let frame = &shown.now.frame;
    look.marked_pair = pair(frame, at);
    look.marked = if look.marked_pair.is_some() { None } else { disk(frame, at) };
}

fn disk(frame: &Frame, at: DVec2) -> Option<u32> {
    let radius = |row: usize| f64::from(frame.bodies.radius_m[row]);
    let is_under = |row: &usize| DVec2::from(frame.centre(*row)).distance(at) <= radius(*row);
    (0..frame.bodies.id.len()).find(is_under).map(|row| frame.bodies.id[row])
}

/// The pair with the contact point nearest to the click, if it is near.
fn pair(frame: &Frame, at: DVec2) -> Option<[u32; 2]> {
    let pairs = &frame.pairs;
    let distance = |k: usize| {
        let [a, b] = [pairs.a[k], pairs.b[k]].map(|id| frame.row(id));
        let radius = |row: Option<usize>| row.map_or(f32::MAX, |row| frame.bodies.radius_m[row]);
        let near = NEAR * f64::from(radius(a).min(radius(b)));
        let apart = DVec2::from(frame.contact_point(k)?).distance(at);
        (apart <= near).then_some((k, apart))
    };
    let all = (0..pairs.a.len()).filter_map(distance);
    let (k, _) = all.min_by(|(_, x), (_, y)| x.total_cmp(y))?;
    Some([pairs.a[k], pairs.b[k]])
}

/// The values of what is picked.
pub(super) fn show(shown: Res<Shown>, look: Res<Look>, mut texts: Query<(&Part, &mut Text)>) {
    if !shown.is_changed() && !look.is_changed() {
        return;
    }
    let frame = &shown.now.frame;
    let words = match (look.marked, look.marked_pair) {
        (Some(id), _) => of_disk(frame, id),
        (_, Some(ids)) => of_pair(frame, ids),
        _ => None,
    };
    for (part, mut text) in &mut texts {
        if *part == Part::Picked {
            write(&mut text, words.as_deref().unwrap_or(""));
        }
    }
}

fn length([x, y]: [f32; 2]) -> f64 {
    f64::from(x.hypot(y))
}

fn of_disk(frame: &Frame, id: u32) -> Option<String> {
    let row = frame.row(id)?;
    let bodies = &frame.bodies;
    let [x, y] = frame.centre(row).map(|x| with_unit(x, "m"));
    let [xx, yy, xy] = bodies.stress_pa[row];
    let unit = |value: f64, unit| with_unit(value, unit);
    let group = bodies.group[row];
    let group = if group == NONE {
        String::new()
    } else {
        format!(", group {}", frame.groups.get(group as usize)?)
    };
    Some(format!(
        "disk {id} of {}{group}\n\
         radius {}, at ({x}, {y})\n\
         displacement {}, rotation {}\n\
         speed {}, {}\n\
         mean stress {}, shear {}\n\
         {} contacts and bonds with force, fragment {}",
        frame.materials.get(bodies.material[row] as usize)?,
        unit(f64::from(bodies.radius_m[row]), "m"),
        unit(length(bodies.displacement_m[row]), "m"),
        unit(f64::from(bodies.rotation_rad[row]), "rad"),
        unit(length(bodies.velocity_m_s[row]), "m/s"),
        unit(f64::from(bodies.angular_velocity_rad_s[row]), "rad/s"),
        unit(f64::from(0.5 * (xx + yy)), "Pa"),
        unit(f64::from((0.5 * (xx - yy)).hypot(xy)), "Pa"),
        contacts(frame)[row],
        bodies.fragment[row],
    ))
}

fn of_pair(frame: &Frame, [a, b]: [u32; 2]) -> Option<String> {
    let pairs = &frame.pairs;
    let k = (0..pairs.a.len()).find(|k| (pairs.a[*k], pairs.b[*k]) == (a, b))?;
    let wall = frame.walls.id.iter().position(|id| *id == b);
    let second = match wall {
        Some(wall) => format!("wall {}", frame.walls.name[wall]),
        None => format!("disk {b}"),
    };
    let bond = pairs.bond[k];
    let state = STATES.get(usize::from(pairs.state[k]))?;
    let state = if bond == NONE { (*state).to_owned() } else { format!("bond {bond}: {state}") };
    Some(format!(
        "disk {a} and {second}\n{state}\n\
         normal force {} (compression +)\n\
         shear force {}\nmoment {}\ngap {}",
        with_unit(f64::from(pairs.p_n[k]), "N"),
        with_unit(f64::from(pairs.q_n[k]), "N"),
        with_unit(f64::from(pairs.tau_nm[k]), "N m"),
        with_unit(f64::from(pairs.gap_m[k]), "m"),
    ))
}
