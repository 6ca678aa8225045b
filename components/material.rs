//! Contact and bond laws.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

/// Law of an unbonded contact.
///
/// `|q| <= mu p`, `|tau| <= mu_r r p`, `p >= 0`, with elastic compliances `C = 1/k` in the normal
/// and the tangential direction and in rolling; `C = 0` is rigid.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct ContactLaw {
    /// Normal compliance `1/k_N`, m/N; 0 is rigid.
    pub normal_compliance: f64,
    /// Tangential compliance `1/k_T`, m/N; 0 is rigid.
    pub tangential_compliance: f64,
    /// Rolling compliance `1/k_R`, rad/(N m); 0 is rigid.
    pub rolling_compliance: f64,
    /// Coefficient of friction mu.
    pub friction: f64,
    /// Coefficient of rolling friction mu_r. 0 means that the contact has no rolling moment.
    pub rolling_friction: f64,
    /// Coefficient of restitution e, 0 to 1, of a rigid contact in dynamics: normal separation
    /// speed after an impact over closing speed before it. 0 in an elastic contact.
    pub restitution: f64,
}

impl ContactLaw {
    /// Contact law between two different materials if the scene gives none: the mean compliances,
    /// the smaller friction and the smaller restitution.
    pub fn between(self, other: Self) -> Self {
        Self {
            normal_compliance: 0.5 * (self.normal_compliance + other.normal_compliance),
            tangential_compliance: 0.5 * (self.tangential_compliance + other.tangential_compliance),
            rolling_compliance: 0.5 * (self.rolling_compliance + other.rolling_compliance),
            friction: self.friction.min(other.friction),
            rolling_friction: self.rolling_friction.min(other.rolling_friction),
            restitution: self.restitution.min(other.restitution),
        }
    }
}

/// Law of an intact bond: `p >= -f_t`, `|q| <= c A + mu_b p`, `|tau| <= mu_r r (p + f_t)` with
/// `f_t = 2 r h sigma_t`, `A = 2 r h`, r the smaller radius (equations 18, 26 and 28 of the paper).
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct BondLaw {
    /// Normal compliance `1/k_N`, m/N; 0 is rigid.
    pub normal_compliance: f64,
    /// Tangential compliance `1/k_T`, m/N; 0 is rigid.
    pub tangential_compliance: f64,
    /// Rolling compliance `1/k_R`, rad/(N m); 0 is rigid.
    pub rolling_compliance: f64,
    /// Internal friction coefficient mu_b.
    pub friction: f64,
    /// Coefficient of rolling friction mu_r. 0 means that the bond has no rolling moment and never
    /// breaks by rolling.
    pub rolling_friction: f64,
    /// Cohesion c, Pa.
    pub cohesion: f64,
    /// Tensile strength sigma_t, Pa.
    pub tensile_strength: f64,
}

impl BondLaw {
    /// Law of a bond between two different materials: the mean compliances, the smaller value of each
    /// strength.
    pub fn between(self, other: Self) -> Self {
        Self {
            normal_compliance: 0.5 * (self.normal_compliance + other.normal_compliance),
            tangential_compliance: 0.5 * (self.tangential_compliance + other.tangential_compliance),
            rolling_compliance: 0.5 * (self.rolling_compliance + other.rolling_compliance),
            friction: self.friction.min(other.friction),
            rolling_friction: self.rolling_friction.min(other.rolling_friction),
            cohesion: self.cohesion.min(other.cohesion),
            tensile_strength: self.tensile_strength.min(other.tensile_strength),
        }
    }

    /// This law, with the compliances of the contact where the bond names none.
    pub fn on(self, contact: &ContactLaw) -> Self {
        let or = |own: f64, of_contact: f64| if own > 0.0 { own } else { of_contact };
        Self {
            normal_compliance: or(self.normal_compliance, contact.normal_compliance),
            tangential_compliance: or(self.tangential_compliance, contact.tangential_compliance),
            rolling_compliance: or(self.rolling_compliance, contact.rolling_compliance),
            ..self
        }
    }
}

/// Material of particles. The default is rigid and frictionless, and forms no bonds.
#[derive(Clone, Debug, PartialEq, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Material {
    /// Name in the scene.
    pub name: String,
    /// Density, kg/m^3.
    pub density: f64,
    /// Law of contacts between two particles of this material.
    pub contact: ContactLaw,
    /// Law of bonds between two particles of this material; `None` if it forms no bonds.
    pub bond: Option<BondLaw>,
}

/// All particle materials, in scene order. If the list is empty, contacts between particles are
/// rigid and frictionless.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Materials(pub Vec<Material>);

impl Materials {
    /// Contact law of two particles with the given material indices.
    ///
    /// # Panics
    /// If a particle has an index beyond the last material.
    pub fn contact(&self, a: u32, b: u32) -> ContactLaw {
        if self.0.is_empty() {
            return ContactLaw::default();
        }
        let (la, lb) = (self.law(a), self.law(b));
        if a == b { la } else { la.between(lb) }
    }

    fn law(&self, index: u32) -> ContactLaw {
        let material = self.0.get(index as usize);
        let count = self.0.len();
        material.map(|material| material.contact).unwrap_or_else(|| {
            panic!("a particle has MaterialIndex({index}), and the world has {count} Materials")
        })
    }
}
