//! Strength over confining stress: Mohr-Coulomb and Hoek-Brown.

/// A strength at a confining stress, Pa, compression positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strength {
    /// Minor principal stress `sigma_3`: the confining stress.
    pub confining: f64,
    /// Major principal stress `sigma_1` at the peak.
    pub peak: f64,
}

/// Linear envelope `tau = c + sigma tan phi`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MohrCoulomb {
    /// Cohesion c, Pa.
    pub cohesion: f64,
    /// Friction angle phi, degrees.
    pub friction_angle: f64,
}

/// Envelope of intact rock, `sigma_1 = sigma_3 + sigma_ci sqrt(m_i sigma_3 / sigma_ci + 1)`
/// (Hoek and Brown 1980, with s = 1 and a = 1/2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoekBrown {
    /// Uniaxial compressive strength `sigma_ci`, Pa.
    pub strength: f64,
    /// Constant `m_i`.
    pub m: f64,
}

/// Least-squares line through points: value at 0, and slope. The error is the reason.
fn line(points: impl Iterator<Item = (f64, f64)> + Clone) -> Result<(f64, f64), &'static str> {
    let n = points.clone().count() as f64;
    let (mx, my) = points.clone().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (xx, xy) = points
        .fold((0.0, 0.0), |(xx, xy), (x, y)| (xx + (x - mx) * (x - mx), xy + (x - mx) * (y - my)));
    let slope = xy / xx;
    if !slope.is_finite() {
        return Err("peaks at two confining stresses are needed");
    }
    Ok((my - slope * mx, slope))
}

impl MohrCoulomb {
    /// Least-squares fit of `sigma_1 = 2 c sqrt(N) + N sigma_3` with
    /// `N = (1 + sin phi)/(1 - sin phi)`.
    ///
    /// # Errors
    /// The reason why it does not exist: fewer than two confining stresses, or N < 1, which belongs
    /// to no friction angle.
    pub fn fit(strengths: &[Strength]) -> Result<Self, &'static str> {
        let (start, slope) = line(strengths.iter().map(|s| (s.confining, s.peak)))?;
        if slope < 1.0 {
            return Err("sigma_1 rises less than sigma_3");
        }
        let friction_angle = ((slope - 1.0) / (slope + 1.0)).asin().to_degrees();
        Ok(Self { cohesion: 0.5 * start / slope.sqrt(), friction_angle })
    }
}

impl HoekBrown {
    /// Least-squares fit of the straight line `(sigma_1 - sigma_3)^2 = sigma_ci^2 + m_i sigma_ci
    /// sigma_3`, as Hoek and Brown fit triaxial tests.
    ///
    /// # Errors
    /// The reason why it does not exist: fewer than two confining stresses, or a line without a
    /// positive strength at `sigma_3 = 0`, as that of most soils.
    pub fn fit(strengths: &[Strength]) -> Result<Self, &'static str> {
        let points = strengths.iter().map(|s| (s.confining, (s.peak - s.confining).powi(2)));
        let (square, slope) = line(points)?;
        if square <= 0.0 {
            return Err("the fitted line has no strength at sigma_3 = 0");
        }
        let strength = square.sqrt();
        Ok(Self { strength, m: slope / strength })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() <= 1e-9 * expected.abs(), "{found} for {expected}");
    }

    /// Strengths of a material with c = 2 MPa and phi = 30 degrees: N = 3.
    #[test]
    fn a_line_gives_back_its_cohesion_and_friction() {
        let at = |s3: f64| Strength { confining: s3, peak: 4e6 * 3_f64.sqrt() + 3.0 * s3 };
        let found = MohrCoulomb::fit(&[at(0.0), at(5e6), at(20e6)]).unwrap();
        near(found.cohesion, 2e6);
        near(found.friction_angle, 30.0);
    }

    /// Table of Hoek and Brown: sigma_ci = 100 MPa, m_i = 10 gives 173.2 + 20 MPa at 20 MPa.
    #[test]
    fn an_intact_rock_gives_back_its_constants() {
        let at = |s3: f64| Strength { confining: s3, peak: s3 + 1e8 * (s3 / 1e7 + 1.0).sqrt() };
        near(at(2e7).peak, 2e7 + 1e8 * 3_f64.sqrt());
        let found = HoekBrown::fit(&[at(0.0), at(5e6), at(2e7), at(5e7)]).unwrap();
        near(found.strength, 1e8);
        near(found.m, 10.0);
    }

    #[test]
    fn one_confining_stress_has_no_envelope() {
        let one = [Strength { confining: 1e6, peak: 3e6 }; 3];
        assert!(MohrCoulomb::fit(&one).is_err());
        assert!(HoekBrown::fit(&one).is_err());
        let falls =
            [Strength { confining: 0.0, peak: 3e6 }, Strength { confining: 1e6, peak: 2e6 }];
        assert!(MohrCoulomb::fit(&falls).is_err());
    }
}
