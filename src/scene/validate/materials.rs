//! Contact and bond laws, and the analyses that their restitution permits.

use clastic_components::domain;

use crate::scene::format::{Analysis, Bond, Contact, Scatter, Spread, Stage};

use super::findings::At;

pub(super) fn check(at: &mut At) {
    for (name, material) in &at.context.scene.materials {
        let at = &mut at.entry("materials", name);
        if name.trim().is_empty() {
            at.add_at_key("empty name of a material", "give it a name");
        }
        at.positive("density", material.density, "a density in kg/m^3");
        contact(&mut at.field("contact"), material.contact);
        bond(&mut at.field("bond"), material.bond);
    }
}

pub(super) fn contact(at: &mut At, contact: Contact) {
    law(at, contact.stiffnesses(), [contact.friction, contact.rolling_friction]);
    let of = contact.restitution;
    let fine = at.within("restitution", of, domain::RESTITUTION);
    let message = format!("restitution of an elastic contact ({of:?})");
    let help = "leave out the stiffnesses, for a rigid contact, or the restitution: the springs of a \
                contact determine how it rebounds";
    at.refuse(fine && of > 0.0 && contact.stiffnesses() != [None; 3], "restitution", message, help);
}

/// Checks the optional bond law of a material or of cement.
pub(super) fn bond(at: &mut At, bond: Option<Bond>) {
    let Some(bond) = bond else { return };
    law(at, bond.stiffnesses(), [bond.friction, bond.rolling_friction]);
    at.within("cohesion", bond.cohesion, domain::COHESION);
    at.within("tensile_strength", bond.tensile_strength, domain::TENSILE_STRENGTH);
    if let Some(of) = &bond.scatter {
        scatter(&mut at.field("scatter"), &bond, of);
    }
}

/// Checks the bond law of a wall, which does not scatter.
pub(super) fn bond_of_wall(at: &mut At, of: Option<Bond>) {
    bond(at, of);
    let help = "give it to the material, or to the `bond` of a stage `Cement`";
    let what = "bonds of a wall do not scatter";
    at.refuse(of.is_some_and(|bond| bond.scatter.is_some()), "scatter", what, help);
}

/// Checks what contacts and bonds have in common.
fn law(at: &mut At, [normal, tangential, rolling]: [Option<f64>; 3], frictions: [f64; 2]) {
    let mut stiffness = |field: &str, value: Option<f64>, unit: &str| {
        let what = format!("a stiffness in {unit} greater than 0, or leave it out for a rigid law");
        at.number(field, value, |stiffness| stiffness > 0.0, &what)
    };
    stiffness("normal_stiffness", normal, "N/m");
    stiffness("tangential_stiffness", tangential, "N/m");
    let is_fine = stiffness("rolling_stiffness", rolling, "N m/rad");
    let [friction, rolling_friction] = frictions;
    at.within("friction", friction, domain::COEFFICIENT);
    at.within("rolling_friction", rolling_friction, domain::COEFFICIENT);
    let has_no_moment = is_fine && rolling.is_some() && rolling_friction == 0.0;
    let message = "a rolling stiffness without a rolling moment";
    let help =
        "give `rolling_friction` too, the coefficient of its limit mu_r r p, or leave it out";
    at.refuse(has_no_moment, "rolling_stiffness", message, help);
}

fn scatter(at: &mut At, bond: &Bond, scatter: &Scatter) {
    let Scatter { strength, stiffness, cohesion, tensile_strength, .. } = scatter;
    let Scatter { normal_stiffness, tangential_stiffness, .. } = scatter;
    let (normal, tangential) = (bond.normal_stiffness, bond.tangential_stiffness);
    let spreads = [
        ("strength", strength, true),
        ("stiffness", stiffness, bond.stiffnesses() != [None; 3]),
        ("cohesion", cohesion, true),
        ("tensile_strength", tensile_strength, true),
        ("normal_stiffness", normal_stiffness, normal.is_some()),
        ("tangential_stiffness", tangential_stiffness, tangential.is_some()),
    ];
    let help = "name what scatters, as in `strength: Weibull(modulus: 4.0)`";
    at.refuse(spreads.iter().all(|(_, spread, _)| spread.is_none()), "", "nothing scatters", help);
    for (name, spread, is_elastic) in spreads {
        let at = &mut at.field(name);
        match *spread {
            None => continue,
            Some(Spread::Weibull { modulus }) => {
                let allowed = |m| (0.2..=1000.0).contains(&m);
                at.number("modulus", modulus, allowed, "a modulus of 0.2 to 1000");
            }
            Some(Spread::LogNormal { deviation }) => {
                let allowed = |s| (0.0..=3.0).contains(&s);
                let what = "a standard deviation of the logarithm of 0 to 3";
                at.number("deviation", deviation, allowed, what);
            }
        }
        let help = "give the law this stiffness, or leave the scatter out";
        at.refuse(!is_elastic, "", "the law is rigid, and has no stiffness to scatter", help);
        let (name, both) = match name {
            "cohesion" | "tensile_strength" => ("strength", strength),
            "normal_stiffness" | "tangential_stiffness" => ("stiffness", stiffness),
            _ => continue,
        };
        let message = format!("it scatters with `{name}` already");
        at.refuse(both.is_some(), "", message, "leave one of the two out");
    }
}

/// Checks theta of dynamic stages. With restitution velocities have theta = 1, and springs require
/// theta = 1 as well.
pub(super) fn restitution(at: &mut At) {
    let scene = at.context.scene;
    let parts = ["materials", "walls", "analysis", "stages"];
    let has_springs = scene.stiffnesses().any(|law| law != [None; 3]);
    if !scene.has_restitution() || !has_springs || !at.are_sure_of(&parts) {
        return;
    }
    let has_analysis = |stage: &Stage| stage.load().is_some() || matches!(stage, Stage::Custom(_));
    if scene.stages.iter().any(|stage| has_analysis(stage) && stage.analysis().is_none()) {
        theta(at, Some(scene.analysis));
    }
    for (i, stage) in scene.stages.iter().enumerate() {
        theta(&mut at.item("stages", i), stage.analysis());
    }
}

fn theta(at: &mut At, analysis: Option<Analysis>) {
    if let Some(Analysis::Dynamic { theta, .. }) = analysis
        && theta > 0.0
        && theta < 1.0
    {
        let message = format!("theta below 1 ({theta:?}) in a scene with restitution and springs");
        let help = "give 1.0: impacts need velocities at the end of the increment, and theta weighs the forces \
                    of springs at its start; or leave out the restitution, or the stiffnesses of contacts and bonds";
        at.add("analysis.theta", message, help);
    }
}
