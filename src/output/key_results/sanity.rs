//! Whether a run stays where its theory holds: stiffness over pressure, overlaps, inertia.

use clastic_components::contact::{Bodies, Contacts};
use clastic_components::increment::{Analysis, AnalysisKind};
use clastic_components::observation::Observation;
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::{KeyResults, Phase, Results};

/// Stiffness over pressure below which the strength of a packing depends on it. Roux and Combe (2002,
/// C. R. Physique 3, 131-140) put the limit of rigid grains at 1e3 to 1e4.
const RIGID_GRAINS: f64 = 1e3;

/// Inertial number up to which a flow is quasi-static: da Cruz et al. (2005, Phys. Rev. E 72,
/// 021309).
const QUASI_STATIC: f64 = 1e-3;

/// Sine of the friction angle above which a packing counts as sheared.
const SHEARED: f64 = 0.1;

/// Maximum elastic overlap over the smaller radius.
pub(super) fn overlap(
    bodies: &Bodies,
    contacts: &Contacts,
    program: &ConeProgram,
    solution: &ConeSolution,
) -> f64 {
    let rows = contacts.0.iter().zip(&program.interactions).zip(&solution.forces);
    let overlaps = rows.map(|((contact, c), force)| {
        c.normal_compliance * force[0] / contact.common_radius(bodies)
    });
    overlaps.fold(0.0, f64::max)
}

impl KeyResults {
    /// Takes a committed increment under load.
    pub(super) fn see_limits(
        &mut self,
        o: &Observation,
        phase: Phase,
        analysis: &Analysis,
        (overlap, mean_mass): (f64, f64),
    ) {
        if phase == Phase::Preparation {
            return;
        }
        let results = &mut self.results;
        if overlap > 0.0 {
            let most = results.overlap_over_radius.unwrap_or(0.0);
            results.overlap_over_radius = Some(most.max(overlap));
        }
        let strains = o.axial_strain.map(|a| [a, o.lateral_strain.unwrap_or(0.0)]);
        let before = std::mem::replace(&mut self.last_strains, strains);
        let Some(axial) = o.axial_stress else { return };
        let pressure = o.lateral_stress.map_or(axial, |lateral| 0.5 * (axial + lateral));
        if !(pressure > 0.0) {
            return;
        }
        if let Some(k) = self.softest {
            let least = results.stiffness_over_pressure.unwrap_or(f64::INFINITY);
            results.stiffness_over_pressure = Some(least.min(k / pressure));
        }
        if let (AnalysisKind::Dynamic { dt, .. }, Some(now), Some(before)) =
            (analysis.kind, strains, before)
            && o.fraction > 0.0
        {
            let sheared = (now[0] - before[0] - now[1] + before[1]).abs();
            let inertia = (mean_mass / (pressure * analysis.thickness)).sqrt();
            let number = sheared / (dt * o.fraction) * inertia;
            results.inertial_number = Some(results.inertial_number.unwrap_or(0.0).max(number));
        }
    }
}

/// What a study should know of these numbers. Bonded specimens are elastic bodies, for which the
/// limit of rigid grains does not count.
#[must_use]
pub fn warnings(results: &Results) -> Vec<String> {
    let mut said = Vec::new();
    let sheared = results.friction_angle_rad.is_some_and(|angle| angle.sin() > SHEARED);
    if let Some(ratio) = results.stiffness_over_pressure
        && sheared
        && results.bonds_created == 0
        && ratio < RIGID_GRAINS
    {
        said.push(format!(
            "k / (p h) falls to {ratio:.0}: below about 1000 the friction angle depends on the stiffness of the \
             grains and on the pressure (Roux and Combe 2002); a greater `normal_stiffness` helps"
        ));
    }
    if let Some(number) = results.inertial_number.filter(|number| *number > QUASI_STATIC) {
        said.push(format!(
            "the inertial number rises to {number:.1e}: above 1e-3 the stresses depend on the rate of the test (da \
             Cruz et al. 2005); a lower speed, or a static analysis, helps"
        ));
    }
    said
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_sheared_packings_without_bonds_are_warned_of_their_stiffness() {
        let soft = Results {
            stiffness_over_pressure: Some(200.0),
            friction_angle_rad: Some(0.4),
            ..Results::default()
        };
        let said = warnings(&soft);
        assert!(said.len() == 1 && said[0].contains("falls to 200"), "{said:?}");
        for fine in [
            Results { stiffness_over_pressure: Some(2000.0), ..soft.clone() },
            Results { friction_angle_rad: Some(0.01), ..soft.clone() },
            Results { friction_angle_rad: None, ..soft.clone() },
            Results { bonds_created: 5, ..soft.clone() },
            Results { inertial_number: Some(1e-4), stiffness_over_pressure: None, ..soft.clone() },
        ] {
            assert_eq!(warnings(&fine), Vec::<String>::new());
        }
        let fast = Results { inertial_number: Some(0.02), ..Results::default() };
        assert!(warnings(&fast)[0].contains("2.0e-2"));
    }

    #[test]
    fn the_inertial_number_is_that_of_a_steady_shear() {
        let mut key = KeyResults::new(false);
        key.softest = Some(1e8);
        let kind = AnalysisKind::Dynamic { dt: 1e-3, theta: 1.0 };
        let analysis = Analysis { kind, thickness: 0.5, ..Analysis::default() };
        for k in 1..4 {
            let o = Observation {
                axial_strain: Some(1e-5 * f64::from(k)),
                lateral_strain: Some(-1e-5 * f64::from(k)),
                axial_stress: Some(3e4),
                lateral_stress: Some(1e4),
                fraction: 1.0,
                ..Observation::default()
            };
            key.see_limits(&o, Phase::Reference, &analysis, (2e-3 * f64::from(k), 0.1));
        }
        let results = key.results;
        // 0.02 per second, and sqrt(0.1 kg / (20 kPa 0.5 m)).
        let found = results.inertial_number.unwrap();
        assert!((found - 0.02 * (0.1_f64 / 1e4).sqrt()).abs() < 1e-12, "{found}");
        assert_eq!(results.stiffness_over_pressure, Some(1e8 / 2e4));
        assert_eq!(results.overlap_over_radius, Some(6e-3));
    }
}
