//! Contact and bond laws.

use clastic_components::domain::{
    COEFFICIENT, COHESION, COMPLIANCE, RESTITUTION, TENSILE_STRENGTH,
};
use clastic_components::material::{BondLaw, ContactLaw, Material};

use super::bad::{Bad, outside};

pub(super) fn of_material(material: &Material) -> Option<Bad> {
    let bond = || of_bond(material.bond.as_ref()?).map(|bad| bad.of("bond."));
    of_contact(&material.contact).map(|bad| bad.of("contact.")).or_else(bond)
}

pub(super) fn of_contact(law: &ContactLaw) -> Option<Bad> {
    outside("normal_compliance", law.normal_compliance, COMPLIANCE)
        .or_else(|| outside("tangential_compliance", law.tangential_compliance, COMPLIANCE))
        .or_else(|| outside("rolling_compliance", law.rolling_compliance, COMPLIANCE))
        .or_else(|| outside("friction", law.friction, COEFFICIENT))
        .or_else(|| outside("rolling_friction", law.rolling_friction, COEFFICIENT))
        .or_else(|| outside("restitution", law.restitution, RESTITUTION))
}

pub(super) fn of_bond(law: &BondLaw) -> Option<Bad> {
    outside("normal_compliance", law.normal_compliance, COMPLIANCE)
        .or_else(|| outside("tangential_compliance", law.tangential_compliance, COMPLIANCE))
        .or_else(|| outside("rolling_compliance", law.rolling_compliance, COMPLIANCE))
        .or_else(|| outside("friction", law.friction, COEFFICIENT))
        .or_else(|| outside("rolling_friction", law.rolling_friction, COEFFICIENT))
        .or_else(|| outside("cohesion", law.cohesion, COHESION))
        .or_else(|| outside("tensile_strength", law.tensile_strength, TENSILE_STRENGTH))
}
