//! Contact and bond laws.

use clastic_components::domain::{COEFFICIENT, COHESION, TENSILE_STRENGTH};
use clastic_components::material::{BondLaw, ContactLaw, Material};

use super::bad::{Bad, bad, not_negative, outside};

/// A compliance of 0 is rigid.
const COMPLIANCE: &str = "1 over a stiffness above 0, or 0 for a rigid one";

pub(super) fn of_material(material: &Material) -> Option<Bad> {
    let bond = || of_bond(material.bond.as_ref()?).map(|bad| bad.of("bond."));
    of_contact(&material.contact).map(|bad| bad.of("contact.")).or_else(bond)
}

pub(super) fn of_contact(law: &ContactLaw) -> Option<Bad> {
    let is_restitution = (0.0..=1.0).contains(&law.restitution);
    not_negative("normal_compliance", law.normal_compliance, COMPLIANCE)
        .or_else(|| not_negative("tangential_compliance", law.tangential_compliance, COMPLIANCE))
        .or_else(|| not_negative("rolling_compliance", law.rolling_compliance, COMPLIANCE))
        .or_else(|| outside("friction", law.friction, COEFFICIENT))
        .or_else(|| outside("rolling_friction", law.rolling_friction, COEFFICIENT))
        .or_else(|| bad("restitution", law.restitution, is_restitution, "a number from 0 to 1"))
}

pub(super) fn of_bond(law: &BondLaw) -> Option<Bad> {
    not_negative("normal_compliance", law.normal_compliance, COMPLIANCE)
        .or_else(|| not_negative("tangential_compliance", law.tangential_compliance, COMPLIANCE))
        .or_else(|| not_negative("rolling_compliance", law.rolling_compliance, COMPLIANCE))
        .or_else(|| outside("friction", law.friction, COEFFICIENT))
        .or_else(|| outside("rolling_friction", law.rolling_friction, COEFFICIENT))
        .or_else(|| outside("cohesion", law.cohesion, COHESION))
        .or_else(|| outside("tensile_strength", law.tensile_strength, TENSILE_STRENGTH))
}
