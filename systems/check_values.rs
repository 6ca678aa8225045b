//! Checks the values of bodies, bonds and materials, which a program may have set since the last
//! increment. Those of a scene were checked when it was read.

use std::fmt::Display;

use bevy_ecs::prelude::*;

use clastic_components::body::Drive;
use clastic_components::contact::Bodies;
use clastic_components::material::{BondLaw, ContactLaw, Materials};
use clastic_components::wall::WallDrive;

use crate::stepping::Halted;

/// Halts the world at the first value that has no meaning, before an attempt works with it: a
/// position that is not a number would otherwise come back as an increment without a solution. It
/// runs in every increment: it reads what the system before it has just written.
pub fn check_values(
    bodies: Res<Bodies>,
    materials: Option<Res<Materials>>,
    halted: Option<Res<Halted>>,
    mut commands: Commands,
) {
    if halted.is_some() {
        return;
    }
    let laws = materials.iter().flat_map(|materials| &materials.0).enumerate();
    let of_material = laws.filter_map(|(i, material)| {
        let bond = || of_bond_law(material.bond.as_ref()?).map(|bad| bad.of("bond."));
        let bad = of_law(&material.contact).map(|bad| bad.of("contact.")).or_else(bond)?;
        Some(bad.in_words(format_args!("material {i} (`{}`)", material.name)))
    });
    let of_particle = (0..bodies.particles).filter_map(|i| Some((i, particle(&bodies, i)?)));
    let of_wall = bodies
        .walls
        .iter()
        .enumerate()
        .filter_map(|(k, wall)| Some((wall.body as usize, self::wall(&bodies, k)?)));
    let of_group = bodies.groups.iter().filter_map(|group| {
        let row = group.body as usize;
        let bad = place(&bodies, row).or_else(|| drives(&group.drives))?;
        Some((row, bad))
    });
    let of_body =
        of_particle.chain(of_wall).chain(of_group).map(|(row, bad)| bad.in_words(bodies.name(row)));
    let of_bond = bodies.bonds.iter().filter_map(|bond| {
        let gap = || finite("initial_gap", bond.initial_gap, "a length in m");
        let bad = of_bond_law(&bond.law).or_else(gap)?;
        let [a, b] = [bond.a, bond.b].map(|row| bodies.name(row as usize));
        Some(bad.in_words(format_args!("bond {} of {a} and {b}", bond.id.0)))
    });
    if let Some(message) = of_material.chain(of_body).chain(of_bond).next() {
        commands.insert_resource(Halted(message));
    }
}

/// A value that has no meaning.
struct Bad {
    field: String,
    value: f64,
    /// What it should be.
    wanted: &'static str,
}

impl Bad {
    /// The value as that of a part.
    fn of(self, part: &str) -> Self {
        Self { field: format!("{part}{}", self.field), ..self }
    }

    fn in_words(&self, owner: impl Display) -> String {
        let Self { field, value, wanted } = self;
        format!(
            "{owner} has {field} = {value:?}: give {wanted}, then remove `Halted` and insert `Running::Always`"
        )
    }
}

/// The value if it does not satisfy the condition, which NaN does not.
fn bad(field: &str, value: f64, is_fine: bool, wanted: &'static str) -> Option<Bad> {
    (!is_fine).then(|| Bad { field: field.to_owned(), value, wanted })
}

fn finite(field: &str, value: f64, wanted: &'static str) -> Option<Bad> {
    bad(field, value, value.is_finite(), wanted)
}

fn not_negative(field: &str, value: f64, wanted: &'static str) -> Option<Bad> {
    bad(field, value, value >= 0.0 && value.is_finite(), wanted)
}

fn particle(bodies: &Bodies, i: usize) -> Option<Bad> {
    let radius = bodies.radii[i];
    let is_radius = radius > 0.0 && radius.is_finite();
    bad("radius", radius, is_radius, "a length above 0 in m")
        .or_else(|| place(bodies, i))
        .or_else(|| not_negative("mass", bodies.masses[i], "a mass in kg, not below 0"))
        .or_else(|| not_negative("inertia", bodies.inertias[i], "kg m^2, not below 0"))
        .or_else(|| finite("Rotation", bodies.rotations[i], "an angle in rad"))
        .or_else(|| drives(&bodies.drives[i]))
        .or_else(|| {
            let load = bodies.loads[i].iter().flat_map(|ramp| [ramp.from, ramp.to]);
            load.filter_map(|f| finite("AppliedLoad", f, "forces in N and a moment in N m")).next()
        })
}

fn wall(bodies: &Bodies, k: usize) -> Option<Bad> {
    let wall = &bodies.walls[k];
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
        .or_else(|| place(bodies, wall.body as usize))
        .or_else(|| of_law(&wall.law))
        .or_else(|| {
            let wanted = "displacements in m, forces in N and angles in rad";
            drive.into_iter().filter_map(|value| finite("WallDrive", value, wanted)).next()
        })
}

/// Position, velocities and last motion of a body.
fn place(bodies: &Bodies, row: usize) -> Option<Bad> {
    let (at, v) = (bodies.positions[row], bodies.velocities[row]);
    let moved = bodies.last_motion[row];
    finite("Position x", at.x, "a coordinate in m")
        .or_else(|| finite("Position y", at.y, "a coordinate in m"))
        .or_else(|| finite("Velocity x", v.x, "a velocity in m/s"))
        .or_else(|| finite("Velocity y", v.y, "a velocity in m/s"))
        .or_else(|| finite("AngularVelocity", bodies.angular_velocities[row], "rad/s"))
        .or_else(|| finite("LastMotion x", moved[0], "a displacement in m"))
        .or_else(|| finite("LastMotion y", moved[1], "a displacement in m"))
        .or_else(|| finite("rotation of LastMotion", moved[2], "an angle in rad"))
}

fn drives(drives: &[Drive; 3]) -> Option<Bad> {
    let imposed = drives.iter().filter_map(|drive| match drive {
        Drive::Imposed(u) => Some(*u),
        Drive::Free => None,
    });
    let wanted = "displacements in m and an angle in rad";
    imposed.filter_map(|u| finite("Drives", u, wanted)).next()
}

/// A compliance of 0 is rigid.
const COMPLIANCE: &str = "1 over a stiffness above 0, or 0 for a rigid one";
const COEFFICIENT: &str = "a number not below 0";

fn of_law(law: &ContactLaw) -> Option<Bad> {
    let is_restitution = (0.0..=1.0).contains(&law.restitution);
    not_negative("normal_compliance", law.normal_compliance, COMPLIANCE)
        .or_else(|| not_negative("tangential_compliance", law.tangential_compliance, COMPLIANCE))
        .or_else(|| not_negative("rolling_compliance", law.rolling_compliance, COMPLIANCE))
        .or_else(|| not_negative("friction", law.friction, COEFFICIENT))
        .or_else(|| not_negative("rolling_friction", law.rolling_friction, COEFFICIENT))
        .or_else(|| bad("restitution", law.restitution, is_restitution, "a number from 0 to 1"))
}

fn of_bond_law(law: &BondLaw) -> Option<Bad> {
    let wanted = "a strength in N/m^2 not below 0";
    not_negative("normal_compliance", law.normal_compliance, COMPLIANCE)
        .or_else(|| not_negative("tangential_compliance", law.tangential_compliance, COMPLIANCE))
        .or_else(|| not_negative("rolling_compliance", law.rolling_compliance, COMPLIANCE))
        .or_else(|| not_negative("friction", law.friction, COEFFICIENT))
        .or_else(|| not_negative("rolling_friction", law.rolling_friction, COEFFICIENT))
        .or_else(|| not_negative("cohesion", law.cohesion, wanted))
        .or_else(|| not_negative("tensile_strength", law.tensile_strength, wanted))
}
