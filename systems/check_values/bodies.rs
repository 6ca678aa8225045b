//! Particles, walls and rigid groups in the tables.

use clastic_components::domain::{PLACE, RADIUS, SPIN, VELOCITY};
use clastic_components::prelude::*;

use super::bad::{Bad, bad, finite, not_negative, outside};
use super::laws;

/// The thickness of a disk, if it is another one than that of the analysis.
pub(super) fn thickness(disk: &Particle, analysis: &ClasticAnalysis) -> Option<Bad> {
    let h = disk.thickness.filter(|h| *h != analysis.thickness)?;
    let wanted = format!("that of `ClasticAnalysis`, {:?} m, or set that one", analysis.thickness);
    Some(Bad::new("thickness", h, wanted))
}

/// A particle, where there are this number of materials. Without any all contacts are rigid.
pub(super) fn particle(bodies: &BodyTable, i: usize, materials: usize) -> Option<Bad> {
    let radius = bodies.radii[i];
    outside("radius", radius, RADIUS)
        .or_else(|| place(bodies, i))
        .or_else(|| not_negative("mass", bodies.masses[i], "a mass in kg, not below 0"))
        .or_else(|| not_negative("inertia", bodies.inertias[i], "kg m^2, not below 0"))
        .or_else(|| finite("Rotation", bodies.rotations[i], "an angle in rad"))
        .or_else(|| drives(&bodies.drives[i]))
        .or_else(|| loads(&bodies.loads[i]))
        .or_else(|| {
            let index = bodies.materials[i];
            let is_known = materials == 0 || (index as usize) < materials;
            let wanted = format!("an index below {materials}, the number of `Materials`");
            (!is_known).then(|| Bad::new("MaterialIndex", index, wanted))
        })
}

pub(super) fn wall(bodies: &BodyTable, wall: &WallRow) -> Option<Bad> {
    let length = wall.half_length;
    let drive = match wall.drive {
        WallDrive::Imposed(u) => [u.x, u.y, 0.0],
        WallDrive::Loaded(load) => [load.from, load.to, 0.0],
        WallDrive::Sliding { load, along } => [load.from, load.to, along],
        WallDrive::Turning { about, angle } => [about.x, about.y, angle],
    };
    bad("half_length", length, length >= 0.0, "a length in m, not below 0")
        .or_else(|| {
            let norm = wall.inward.length();
            bad("length of its tangent", norm, (norm - 1.0).abs() < 1e-6, "a unit vector")
        })
        .or_else(|| arc(&wall.shape))
        .or_else(|| place(bodies, wall.body as usize))
        .or_else(|| laws::of_contact(&wall.law))
        .or_else(|| {
            let wanted = "displacements in m, forces in N and angles in rad";
            drive.into_iter().find_map(|value| finite("WallDrive", value, wanted))
        })
}

fn arc(shape: &WallShape) -> Option<Bad> {
    let WallShape::Arc { centre, radius, axis, half_angle } = *shape else { return None };
    let is_angle = half_angle > 0.0 && half_angle.is_finite();
    outside("radius of its arc", radius, RADIUS)
        .or_else(|| bad("half_angle of its arc", half_angle, is_angle, "an angle above 0 in rad"))
        .or_else(|| {
            let all = [centre.x, centre.y, axis.x, axis.y];
            all.into_iter().find_map(|x| finite("WallShape", x, "a place and an axis"))
        })
}

/// A rigid group.
pub(super) fn group(bodies: &BodyTable, group: &GroupRow) -> Option<Bad> {
    place(bodies, group.body as usize)
        .or_else(|| drives(&group.drives))
        .or_else(|| loads(&group.loads))
}

/// The periodic cell.
pub(super) fn cell(cell: &PeriodicCell) -> Option<Bad> {
    let side =
        |name, side: f64| bad(name, side, side > 0.0 && side.is_finite(), "a length above 0 in m");
    side("width", cell.width)
        .or_else(|| side("height", cell.height))
        .or_else(|| finite("tilt", cell.tilt, "a length in m"))
        .or_else(|| {
            let mut ends = cell.controls.iter().flat_map(|control| match *control {
                CellControl::Imposed(u) => [u, u],
                CellControl::Stress { from, to } => [from, to],
            });
            let wanted = "displacements in m and stresses in Pa";
            ends.find_map(|value| finite("controls", value, wanted))
        })
}

/// Position, velocities and last motion of a body.
fn place(bodies: &BodyTable, row: usize) -> Option<Bad> {
    let (at, v) = (bodies.positions[row], bodies.velocities[row]);
    let moved = bodies.last_motion[row];
    outside("BodyPosition x", at.x, PLACE)
        .or_else(|| outside("BodyPosition y", at.y, PLACE))
        .or_else(|| outside("BodyVelocity x", v.x, VELOCITY))
        .or_else(|| outside("BodyVelocity y", v.y, VELOCITY))
        .or_else(|| outside("BodyAngularVelocity", bodies.angular_velocities[row], SPIN))
        .or_else(|| finite("LastMotion x", moved[0], "a displacement in m"))
        .or_else(|| finite("LastMotion y", moved[1], "a displacement in m"))
        .or_else(|| finite("rotation of LastMotion", moved[2], "an angle in rad"))
}

fn loads(loads: &[Ramp; 3]) -> Option<Bad> {
    let mut ends = loads.iter().flat_map(|ramp| [ramp.from, ramp.to]);
    ends.find_map(|end| finite("LoadControl", end, "forces in N and a moment in N m"))
}

fn drives(drives: &[BodyDrive; 3]) -> Option<Bad> {
    let wanted = "displacements in m and an angle in rad";
    drives.iter().find_map(|drive| finite("BodyDrives", drive.imposed()?, wanted))
}
