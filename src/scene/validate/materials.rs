//! Contact and bond laws.

use std::fmt::Arguments;

use clastic_components::domain;

use crate::scene::format::{Bond, Contact, Scatter, Spread};
use crate::scene::spans::join;

use super::findings::Findings;
use super::restitution;

pub(super) fn check(findings: &mut Findings) {
    for (name, material) in &findings.context.scene.materials {
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

/// Checks the bond law of a wall, which does not scatter.
pub(super) fn bond_of_wall(path: Arguments, of: Option<Bond>, findings: &mut Findings) {
    bond(path, of, findings);
    if of.is_some_and(|bond| bond.scatter.is_some()) {
        let help = "give it to the material, or to the `bond` of a stage `Cement`";
        findings.add(format_args!("{path}.scatter"), "bonds of a wall do not scatter", help);
    }
}

/// Checks the scatter of a bond law.
fn scatter(path: Arguments, bond: &Bond, scatter: &Scatter, findings: &mut Findings) {
    let Scatter { strength, stiffness, cohesion, tensile_strength, .. } = scatter;
    let Scatter { normal_stiffness, tangential_stiffness, .. } = scatter;
    let (normal, tangential) = (bond.normal_stiffness, bond.tangential_stiffness);
    let is_elastic = [normal, tangential, bond.rolling_stiffness].iter().any(Option::is_some);
    let spreads = [
        ("strength", strength, true),
        ("stiffness", stiffness, is_elastic),
        ("cohesion", cohesion, true),
        ("tensile_strength", tensile_strength, true),
        ("normal_stiffness", normal_stiffness, normal.is_some()),
        ("tangential_stiffness", tangential_stiffness, tangential.is_some()),
    ];
    if spreads.iter().all(|(_, spread, _)| spread.is_none()) {
        let help = "name what scatters, as in `strength: Weibull(modulus: 4.0)`";
        findings.add(path, "nothing scatters", help);
    }
    for (name, spread, is_elastic) in spreads {
        let path = format_args!("{path}.{name}");
        match *spread {
            None => continue,
            Some(Spread::Weibull { modulus }) => {
                let allowed = |m| (0.2..=1000.0).contains(&m);
                let what = "a modulus of 0.2 to 1000";
                findings.number(format_args!("{path}.modulus"), modulus, allowed, what);
            }
            Some(Spread::LogNormal { deviation }) => {
                let allowed = |s| (0.0..=3.0).contains(&s);
                let what = "a standard deviation of the logarithm of 0 to 3";
                findings.number(format_args!("{path}.deviation"), deviation, allowed, what);
            }
        }
        if !is_elastic {
            let help = "give the law this stiffness, or leave the scatter out";
            findings.add(path, "the law is rigid, and has no stiffness to scatter", help);
        }
        let both = match name {
            "cohesion" | "tensile_strength" => ("strength", strength),
            "normal_stiffness" | "tangential_stiffness" => ("stiffness", stiffness),
            _ => continue,
        };
        if both.1.is_some() {
            let message = format!("it scatters with `{}` already", both.0);
            findings.add(path, message, "leave one of the two out");
        }
    }
}

/// Checks the optional bond law of a material or a wall.
pub(super) fn bond(path: Arguments, bond: Option<Bond>, findings: &mut Findings) {
    let Some(bond) = bond else { return };
    stiffnesses(path, (bond.normal_stiffness, bond.tangential_stiffness), findings);
    frictions(path, (bond.friction, bond.rolling_friction), findings);
    rolling(path, (bond.rolling_stiffness, bond.rolling_friction), findings);
    findings.within(format_args!("{path}.cohesion"), bond.cohesion, domain::COHESION);
    let path_of_strength = format_args!("{path}.tensile_strength");
    findings.within(path_of_strength, bond.tensile_strength, domain::TENSILE_STRENGTH);
    if let Some(of) = &bond.scatter {
        scatter(format_args!("{path}.scatter"), &bond, of, findings);
    }
}

/// Checks the contact law of a material or a wall.
pub(super) fn contact(path: Arguments, contact: Contact, findings: &mut Findings) {
    stiffnesses(path, (contact.normal_stiffness, contact.tangential_stiffness), findings);
    frictions(path, (contact.friction, contact.rolling_friction), findings);
    rolling(path, (contact.rolling_stiffness, contact.rolling_friction), findings);
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

/// Checks the elasticity of rolling.
fn rolling(path: Arguments, (stiffness, friction): (Option<f64>, f64), findings: &mut Findings) {
    let Some(stiffness) = stiffness else { return };
    let path = format_args!("{path}.rolling_stiffness");
    let what = "a stiffness in N m/rad greater than 0, or leave it out for a rigid law";
    let is_fine = findings.number(path, stiffness, |stiffness| stiffness > 0.0, what);
    if is_fine && friction == 0.0 {
        let message = "a rolling stiffness without a rolling moment";
        let help =
            "give `rolling_friction` too, the coefficient of its limit mu_r r p, or leave it out";
        findings.add(path, message, help);
    }
}

fn frictions(path: Arguments, (friction, rolling): (f64, f64), findings: &mut Findings) {
    findings.within(format_args!("{path}.friction"), friction, domain::COEFFICIENT);
    findings.within(format_args!("{path}.rolling_friction"), rolling, domain::COEFFICIENT);
}
