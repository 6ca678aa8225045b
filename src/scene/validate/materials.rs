//! Contact and bond laws.

use std::fmt::Arguments;

use crate::scene::format::{Bond, Contact};
use crate::scene::spans::join;

use super::Context;
use super::findings::Findings;
use super::restitution;

pub(super) fn check(context: &Context, findings: &mut Findings) {
    for (name, material) in &context.scene.materials {
        let path = join("materials", name);
        let path = path.as_str();
        if name.trim().is_empty() {
            let message = "empty name of a material".to_owned();
            findings.add_at_key(format_args!("{path}"), message, "give it a name");
        }
        let density = material.density;
        findings.positive(format_args!("{path}.density"), density, "a density in kg/m^3");
        contact(format_args!("{path}.contact"), material.contact, findings);
        bond(format_args!("{path}.bond"), material.bond, findings);
    }
}

/// Checks the optional bond law of a material or a wall.
pub(super) fn bond(path: Arguments, bond: Option<Bond>, findings: &mut Findings) {
    let Some(bond) = bond else { return };
    stiffnesses(path, (bond.normal_stiffness, bond.tangential_stiffness), findings);
    frictions(path, (bond.friction, bond.rolling_friction), findings);
    findings.not_negative(format_args!("{path}.cohesion"), bond.cohesion, "a cohesion in Pa");
    findings.not_negative(
        format_args!("{path}.tensile_strength"),
        bond.tensile_strength,
        "a tensile strength in Pa",
    );
}

/// Checks the contact law of a material or a wall.
pub(super) fn contact(path: Arguments, contact: Contact, findings: &mut Findings) {
    stiffnesses(path, (contact.normal_stiffness, contact.tangential_stiffness), findings);
    frictions(path, (contact.friction, contact.rolling_friction), findings);
    restitution::law(path, contact, findings);
}

fn stiffnesses(
    path: Arguments,
    (normal, tangential): (Option<f64>, Option<f64>),
    findings: &mut Findings,
) {
    let what = "a stiffness in N/m greater than 0, or leave it out for a rigid law";
    for (name, value) in [("normal", normal), ("tangential", tangential)] {
        if let Some(value) = value {
            let path = format_args!("{path}.{name}_stiffness");
            findings.number(path, value, |value| value > 0.0, what);
        }
    }
}

fn frictions(path: Arguments, (friction, rolling): (f64, f64), findings: &mut Findings) {
    findings.not_negative(format_args!("{path}.friction"), friction, "a coefficient");
    findings.not_negative(format_args!("{path}.rolling_friction"), rolling, "a coefficient");
}
