//! Fabric tensor of the contacts of particles with each other.

use clastic_components::measure::{FabricComponent, Network};
use clastic_cone::residuals::Carrying;

use super::principal::Principal;
use crate::solved::Solved;

/// A component of the fabric tensor of the contacts that carry force, with normals at the present
/// places of the particles. `None` without such contacts.
pub fn fabric(solved: Solved, component: FabricComponent, network: Network) -> Option<f64> {
    let Solved { bodies, contacts, program, solution } = solved;
    let carrying = Carrying::new(program, solution);
    let between = |k: &usize| (contacts.0[*k].b as usize) < bodies.particles;
    let mut counted: Vec<usize> =
        (0..contacts.0.len()).filter(|k| between(k) && carrying.is_carrying(*k)).collect();
    let size = |k: &usize| solution.forces[*k][0].abs();
    if network == Network::Strong {
        let mean = counted.iter().map(size).sum::<f64>() / counted.len() as f64;
        counted.retain(|k| size(k) > mean);
    }
    let [mut xx, mut yy, mut xy] = [0.0; 3];
    for k in &counted {
        let n = bodies.way(contacts.0[*k].a as usize, contacts.0[*k].b as usize).normalize();
        xx += n.x * n.x;
        yy += n.y * n.y;
        xy += n.x * n.y;
    }
    if counted.is_empty() {
        return None;
    }
    let [xx, yy, xy] = [xx, yy, xy].map(|sum| sum / counted.len() as f64);
    let principal = Principal::of(xx, yy, xy);
    match component {
        FabricComponent::Xx => Some(xx),
        FabricComponent::Yy => Some(yy),
        FabricComponent::Xy => Some(xy),
        FabricComponent::Anisotropy => Some(2.0 * (principal.major - principal.minor)),
        FabricComponent::Direction => principal.direction,
    }
}
