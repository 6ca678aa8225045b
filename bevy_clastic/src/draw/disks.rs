//! Disks in the colours of a field.

use bevy::color::{LinearRgba, Mix};
use clastic::frames::Frame;

use super::strokes::Quads;

/// Adds the disks. Under force chains they are pale.
pub(super) fn draw(quads: &mut Quads, frame: &Frame, colours: &[LinearRgba], pale: bool) {
    let bodies = &frame.bodies;
    for (row, colour) in colours.iter().enumerate() {
        let colour = if pale { colour.mix(&LinearRgba::WHITE, 0.4) } else { *colour };
        let radius = f64::from(bodies.radius_m[row]);
        let angle = f64::from(bodies.rotation_rad[row]);
        quads.disk(frame.centre(row).into(), radius, angle, colour);
    }
}
