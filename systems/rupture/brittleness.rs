//! How much force ruptures release: pure functions of contacts and forces.
//!
//! A bond of rock loses its whole force, which is of the order of the forces around it, and its
//! neighbours follow. A bond of cemented sand that shears under a confining stress keeps normal
//! force and friction: it releases its cohesion, which is small beside the forces around it.

use clastic_components::contact::Contact;

use crate::contact_laws::Laws;

/// Mean force that the ruptures of bonds release, over the mean of the contact forces,
///
/// ```text
/// b = (1/n) sum_i |f_i - f_i'| / ((1/m) sum|f|)
/// ```
///
/// with n bonds `due`, given by their contacts, f_i the force (p, q) of a bond as it breaks, f_i'
/// what its contact keeps of it, and m contacts that carry a force. A contact keeps a compressive
/// p and |q| up to friction, and nothing where the bond spans a gap. Infinite without bonds.
pub fn brittleness(due: &[usize], contacts: &[Contact], forces: &[[f64; 3]], laws: Laws) -> f64 {
    let sizes = forces.iter().map(|[p, q, _]| p.hypot(*q)).filter(|f| *f > 0.0);
    let (sum, carrying) = sizes.fold((0.0, 0_usize), |(sum, n), f| (sum + f, n + 1));
    let released: f64 = due.iter().map(|k| released(&contacts[*k], forces[*k], laws)).sum();
    if due.is_empty() || carrying == 0 {
        return f64::INFINITY;
    }
    released / due.len() as f64 / (sum / carrying as f64)
}

fn released(contact: &Contact, [p, q, _]: [f64; 3], laws: Laws) -> f64 {
    let law = laws.contact(contact);
    let kept = if contact.gap <= 0.0 { p.max(0.0) } else { 0.0 };
    (p - kept).hypot((q.abs() - law.friction * kept).max(0.0))
}

/// Forces at a fraction of the way from one state to another.
pub fn between(from: &[[f64; 3]], to: &[[f64; 3]], part: f64) -> Vec<[f64; 3]> {
    let starts = from.iter().copied().chain(std::iter::repeat([0.0; 3]));
    starts.zip(to).map(|(a, b)| [0, 1, 2].map(|k| a[k] + part * (b[k] - a[k]))).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use clastic_components::contact::BodyTable;
    use clastic_components::increment::ClasticAnalysis;
    use clastic_components::material::{ContactLaw, Material, Materials};

    use super::*;

    fn contact(gap: f64) -> Contact {
        Contact { a: 0, b: 1, normal: DVec2::X, gap, bond: None }
    }

    fn b(due: &[usize], forces: &[[f64; 3]]) -> f64 {
        let contact_law = ContactLaw { friction: 0.5, ..ContactLaw::default() };
        let material = Material { contact: contact_law, ..Material::default() };
        let materials = Materials(vec![material]);
        let bodies = BodyTable { particles: 2, materials: vec![0, 0], ..BodyTable::default() };
        let laws =
            Laws { bodies: &bodies, materials: &materials, analysis: &ClasticAnalysis::default() };
        brittleness(due, &[contact(0.0), contact(0.0), contact(1e-6)], forces, laws)
    }

    #[test]
    fn a_bond_in_tension_or_across_a_gap_releases_all_of_its_force() {
        let forces = [[-3.0, 4.0, 0.0], [5.0, 0.0, 0.0], [3.0, 4.0, 0.0]];
        assert!((b(&[0], &forces) - 1.0).abs() < 1e-12);
        assert!((b(&[2], &forces) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_bond_that_shears_under_pressure_keeps_pressure_and_friction() {
        // |q| = 6 exceeds friction by 1; the mean of the forces is 13/2.
        let forces = [[10.0, -6.0, 0.0], [0.0; 3], [0.8, 0.0, 0.0]];
        let mean = 0.5 * (10.0_f64.hypot(6.0) + 0.8);
        assert!((b(&[0], &forces) - 1.0 / mean).abs() < 1e-12);
    }

    #[test]
    fn without_bonds_or_forces_nothing_is_mild() {
        assert_eq!(b(&[], &[[1.0, 0.0, 0.0]; 3]), f64::INFINITY);
        assert_eq!(b(&[0], &[[0.0; 3]; 3]), f64::INFINITY);
    }

    #[test]
    fn forces_between_two_states_are_interpolated() {
        let found = between(&[[1.0, 0.0, 0.0]], &[[3.0, 2.0, 0.0], [4.0, 0.0, 0.0]], 0.25);
        assert_eq!(found, [[1.5, 0.5, 0.0], [1.0, 0.0, 0.0]]);
    }
}
