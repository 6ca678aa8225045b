//! The law of a contact, and what is left of the forces of a bond where it has broken.

use bevy_ecs::prelude::*;
use clastic_components::prelude::*;

/// What the laws of contacts in an increment follow from.
#[derive(Clone, Copy)]
pub struct Laws<'a> {
    /// Bodies of the contacts.
    pub bodies: &'a BodyTable,
    /// Their materials.
    pub materials: &'a Materials,
    /// Kind of analysis.
    pub analysis: &'a ClasticAnalysis,
}

impl<'a> Laws<'a> {
    /// The laws of a world.
    pub fn of(world: &'a World) -> Self {
        Self { bodies: world.resource(), materials: world.resource(), analysis: world.resource() }
    }

    /// Law of a contact in an increment: without friction in a compaction, and with the friction that
    /// an increment leaves.
    pub fn contact(self, contact: &Contact) -> ContactLaw {
        if matches!(self.analysis.kind, AnalysisKind::Compaction { .. }) {
            return ContactLaw::default();
        }
        let mut law = law_of_pair(self.bodies, self.materials, contact);
        law.friction *= self.analysis.strength;
        law.rolling_friction *= self.analysis.strength;
        law
    }
}

/// Law of a contact: that of the wall, or that of the two materials.
pub fn law_of_pair(bodies: &BodyTable, materials: &Materials, contact: &Contact) -> ContactLaw {
    let (a, b) = (contact.a as usize, contact.b as usize);
    if b < bodies.particles {
        return materials.contact(bodies.materials[a], bodies.materials[b]);
    }
    bodies.wall(contact.b).map_or_else(ContactLaw::default, |wall| wall.law)
}

/// Initial shear force of a contact whose bond has broken: the part that its friction can carry. It
/// is zero if the bond spanned a gap.
pub(crate) fn shear_after_rupture(q: f64, gap: f64, law: &ContactLaw) -> f64 {
    if law.tangential_compliance <= 0.0 || law.normal_compliance <= 0.0 {
        return 0.0;
    }
    let limit = law.friction * (-gap / law.normal_compliance).max(0.0);
    q.clamp(-limit, limit)
}

/// Initial rolling moment of a contact whose bond has broken: the part that its limit allows, with
/// the common radius of its bodies (m). It is zero if the bond spanned a gap, or if the contact
/// does not roll elastically.
pub(crate) fn moment_after_rupture(tau: f64, gap: f64, radius: f64, law: &ContactLaw) -> f64 {
    if law.rolling_compliance <= 0.0 || law.normal_compliance <= 0.0 {
        return 0.0;
    }
    let limit = law.rolling_friction * radius * (-gap / law.normal_compliance).max(0.0);
    tau.clamp(-limit, limit)
}
