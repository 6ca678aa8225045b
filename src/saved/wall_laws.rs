//! Laws of walls as rows of numbers, and back.

use clastic_components::material::ContactLaw;

use crate::scene::format as scene;

pub(super) fn law_row(law: &ContactLaw) -> [f64; 5] {
    let ContactLaw {
        normal_compliance,
        tangential_compliance,
        friction,
        rolling_friction,
        restitution,
    } = *law;
    [normal_compliance, tangential_compliance, friction, rolling_friction, restitution]
}

/// A law of contact as the scene has it; no stiffness is infinite.
pub(super) fn contact_row(law: &scene::Contact) -> [f64; 5] {
    let [n, t] = [law.normal_stiffness, law.tangential_stiffness].map(rigid);
    [n, t, law.friction, law.rolling_friction, law.restitution]
}

pub(super) fn contact([n, t, friction, rolling_friction, restitution]: [f64; 5]) -> scene::Contact {
    let [normal_stiffness, tangential_stiffness] = [n, t].map(elastic);
    scene::Contact {
        normal_stiffness,
        tangential_stiffness,
        friction,
        rolling_friction,
        restitution,
    }
}

pub(super) fn bond_row(law: &scene::Bond) -> [f64; 6] {
    let [n, t] = [law.normal_stiffness, law.tangential_stiffness].map(rigid);
    [n, t, law.friction, law.rolling_friction, law.cohesion, law.tensile_strength]
}

/// A law of bonds; none if it is no number.
pub(super) fn bond(
    [n, t, friction, rolling_friction, cohesion, tensile]: [f64; 6],
) -> Option<scene::Bond> {
    let [normal_stiffness, tangential_stiffness] = [n, t].map(elastic);
    let law = scene::Bond {
        normal_stiffness,
        tangential_stiffness,
        friction,
        rolling_friction,
        cohesion,
        tensile_strength: tensile,
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
