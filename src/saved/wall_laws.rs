//! Laws of walls as rows of numbers, and back.

use clastic_components::material::ContactLaw;

use crate::scene::format as scene;

pub(super) fn law_row(law: &ContactLaw) -> [f64; 6] {
    [
        law.normal_compliance,
        law.tangential_compliance,
        law.rolling_compliance,
        law.friction,
        law.rolling_friction,
        law.restitution,
    ]
}

pub(super) fn law([n, t, r, friction, rolling_friction, restitution]: [f64; 6]) -> ContactLaw {
    ContactLaw {
        normal_compliance: n,
        tangential_compliance: t,
        rolling_compliance: r,
        friction,
        rolling_friction,
        restitution,
    }
}

/// A law of contact as the scene has it; no stiffness is infinite.
pub(super) fn contact_row(law: &scene::Contact) -> [f64; 6] {
    let stiffnesses = [law.normal_stiffness, law.tangential_stiffness, law.rolling_stiffness];
    let [n, t, r] = stiffnesses.map(rigid);
    [n, t, r, law.friction, law.rolling_friction, law.restitution]
}

pub(super) fn contact(
    [n, t, r, friction, rolling_friction, restitution]: [f64; 6],
) -> scene::Contact {
    let [normal_stiffness, tangential_stiffness, rolling_stiffness] = [n, t, r].map(elastic);
    scene::Contact {
        normal_stiffness,
        tangential_stiffness,
        rolling_stiffness,
        friction,
        rolling_friction,
        restitution,
    }
}

pub(super) fn bond_row(law: &scene::Bond) -> [f64; 7] {
    let stiffnesses = [law.normal_stiffness, law.tangential_stiffness, law.rolling_stiffness];
    let [n, t, r] = stiffnesses.map(rigid);
    [n, t, r, law.friction, law.rolling_friction, law.cohesion, law.tensile_strength]
}

/// A law of bonds; none if it is no number.
pub(super) fn bond(
    [n, t, r, friction, rolling_friction, cohesion, tensile_strength]: [f64; 7],
) -> Option<scene::Bond> {
    let [normal_stiffness, tangential_stiffness, rolling_stiffness] = [n, t, r].map(elastic);
    let law = scene::Bond {
        normal_stiffness,
        tangential_stiffness,
        rolling_stiffness,
        friction,
        rolling_friction,
        cohesion,
        tensile_strength,
        scatter: None,
    };
    (!n.is_nan()).then_some(law)
}

fn rigid(stiffness: Option<f64>) -> f64 {
    stiffness.unwrap_or(f64::INFINITY)
}

fn elastic(stiffness: f64) -> Option<f64> {
    Some(stiffness).filter(|k| k.is_finite())
}
