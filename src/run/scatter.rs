//! Scatter of bonds: the law of one bond from that of its material.
//!
//! The draws of a bond depend on the seed and on where its two bodies were at the start of the run
//! ([`BodyOrigin`](clastic_components::body::BodyOrigin)), which is stored with them, and not on the
//! order of the particles or of the bonds.

use glam::DVec2;
use libm::{exp, log, pow, sqrt, tgamma};

use clastic_components::material::BondLaw;

use super::laws::bond_law;
use super::random::Random;
use crate::scene::format::{Bond, Spread};

/// The law of a bond between bodies that were at these places at the start of the run, m.
pub fn scattered(bond: &Bond, places: [DVec2; 2]) -> BondLaw {
    let law = bond_law(bond);
    let Some(scatter) = &bond.scatter else { return law };
    let mut random = numbers(scatter.seed, places);
    // In (0, 1].
    let mut unit = || random.unit() + 0.5 * f64::EPSILON;
    // Every factor has a draw at a fixed place, whether it is asked for or not.
    let mut factor = |spread: Option<Spread>| {
        let (u, v) = (unit(), unit());
        spread.map_or(1.0, |spread| of(spread, u, v))
    };
    let (strength, stiffness) = (factor(scatter.strength), factor(scatter.stiffness));
    let cohesion = strength * factor(scatter.cohesion);
    let tensile = strength * factor(scatter.tensile_strength);
    let normal = stiffness * factor(scatter.normal_stiffness);
    let tangential = stiffness * factor(scatter.tangential_stiffness);
    BondLaw {
        normal_compliance: law.normal_compliance / normal,
        tangential_compliance: law.tangential_compliance / tangential,
        rolling_compliance: law.rolling_compliance / stiffness,
        cohesion: law.cohesion * cohesion,
        tensile_strength: law.tensile_strength * tensile,
        ..law
    }
}

/// A factor with a mean of 1 from two numbers in (0, 1].
fn of(spread: Spread, u: f64, v: f64) -> f64 {
    match spread {
        // The mean of a Weibull distribution of scale s is s gamma(1 + 1/m).
        Spread::Weibull { modulus } => pow(-log(u), 1.0 / modulus) / tgamma(1.0 + 1.0 / modulus),
        // Box-Muller transform; the mean of exp(s z) is exp(s^2 / 2).
        Spread::LogNormal { deviation: s } => {
            let normal = sqrt(-2.0 * log(u)) * libm::cos(std::f64::consts::TAU * v);
            exp(s * normal - 0.5 * s * s)
        }
    }
}

/// Random numbers of the bond between two places.
fn numbers(seed: u64, places: [DVec2; 2]) -> Random {
    // Negative zero is the same place as zero.
    let mut places = places.map(|x| [x.x + 0.0, x.y + 0.0].map(f64::to_bits));
    places.sort_unstable();
    let key = places.map(|place| place.map(u64::to_le_bytes));
    Random::keyed(key.as_flattened().as_flattened(), seed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::format::Scatter;

    const NONE: Scatter = Scatter {
        seed: 0,
        strength: None,
        stiffness: None,
        cohesion: None,
        tensile_strength: None,
        normal_stiffness: None,
        tangential_stiffness: None,
    };

    fn bond(scatter: Scatter) -> Bond {
        Bond {
            normal_stiffness: Some(2.0e6),
            tangential_stiffness: Some(1.0e6),
            rolling_stiffness: Some(2.0e2),
            friction: 0.5,
            rolling_friction: 0.0,
            cohesion: 3.0e3,
            tensile_strength: 5.0e3,
            scatter: Some(scatter),
        }
    }

    /// Laws of bonds on a line.
    fn laws(scatter: Scatter, count: u32) -> Vec<BondLaw> {
        let law = bond(scatter);
        let place = |k| DVec2::new(0.01 * f64::from(k), 0.3);
        (0..count).map(|k| scattered(&law, [place(k), place(k + 1)])).collect()
    }

    fn mean_and_deviation(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
        let n = values.clone().count() as f64;
        let mean = values.clone().sum::<f64>() / n;
        (mean, (values.map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt())
    }

    #[test]
    fn both_distributions_have_their_mean_and_their_deviation() {
        // A Weibull distribution of modulus 4: coefficient of variation 0.2806. Four standard
        // errors of 20000 draws are 0.8 % of the mean and some 3 % of the deviation.
        for (spread, deviation) in [
            (Spread::Weibull { modulus: 4.0 }, 0.280_55),
            (Spread::Weibull { modulus: 1.0 }, 1.0),
            (Spread::LogNormal { deviation: 0.3 }, (0.09_f64.exp() - 1.0).sqrt()),
        ] {
            for seed in [3, 17, 401] {
                let all = laws(Scatter { seed, tensile_strength: Some(spread), ..NONE }, 20_000);
                let factors = all.iter().map(|law| law.tensile_strength / 5.0e3);
                let (mean, found) = mean_and_deviation(factors);
                assert!((mean - 1.0).abs() < 4.0 * deviation / 20_000_f64.sqrt(), "{mean}");
                assert!((found / deviation - 1.0).abs() < 0.05, "{found} for {deviation}");
                assert!(all.iter().all(|law| law.cohesion == 3.0e3 && law.friction == 0.5));
            }
        }
    }

    #[test]
    fn strengths_have_one_factor_together_and_two_apart() {
        let weibull = Some(Spread::Weibull { modulus: 3.0 });
        let together = laws(Scatter { strength: weibull, stiffness: weibull, ..NONE }, 2000);
        for law in &together {
            let factor = law.cohesion / 3.0e3;
            assert!((law.tensile_strength / 5.0e3 / factor - 1.0).abs() < 1e-14);
            let stiffer = 1.0 / 2.0e6 / law.normal_compliance;
            assert!((1.0 / 1.0e6 / law.tangential_compliance / stiffer - 1.0).abs() < 1e-14);
            assert!((1.0 / 2.0e2 / law.rolling_compliance / stiffer - 1.0).abs() < 1e-14);
            assert!((stiffer - factor).abs() > 1e-9);
        }
        let apart = laws(Scatter { cohesion: weibull, tensile_strength: weibull, ..NONE }, 2000);
        let a = mean_and_deviation(apart.iter().map(|law| law.cohesion / 3.0e3));
        let b = mean_and_deviation(apart.iter().map(|law| law.tensile_strength / 5.0e3));
        let product = apart.iter().map(|law| law.cohesion * law.tensile_strength / 15.0e6);
        let correlation = (mean_and_deviation(product).0 - a.0 * b.0) / (a.1 * b.1);
        assert!(correlation.abs() < 4.0 / 2000_f64.sqrt(), "{correlation}");
    }

    #[test]
    fn draws_depend_on_the_places_and_the_seed_alone() {
        let weibull = Some(Spread::Weibull { modulus: 3.0 });
        let law = bond(Scatter { seed: 5, strength: weibull, ..NONE });
        let (a, b) = (DVec2::new(0.0, 1.0), DVec2::new(2.0, 1.0));
        assert_eq!(scattered(&law, [a, b]), scattered(&law, [b, a]));
        assert_eq!(scattered(&law, [DVec2::new(-0.0, 1.0), b]), scattered(&law, [a, b]));
        assert_ne!(scattered(&law, [a, a]), scattered(&law, [a, b]));
        let other = bond(Scatter { seed: 6, strength: weibull, ..NONE });
        assert_ne!(scattered(&other, [a, b]), scattered(&law, [a, b]));
        assert_eq!(scattered(&Bond { scatter: None, ..law }, [a, b]), bond_law(&law));
    }
}
