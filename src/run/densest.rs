//! The densest packings of disks in the plane.

/// Lower bound on the porosity of disks whose smallest radius is `ratio` times the largest: that of
/// the triangle between a largest and two smallest disks that touch (Florian 1960, Rend. Circ. Mat.
/// Palermo 9, 300-312). Of equal disks it is that of the hexagonal packing, 1 - pi/sqrt(12).
pub fn lowest_porosity(ratio: f64) -> f64 {
    if !(ratio > 0.0) {
        return 0.0;
    }
    let angle = (ratio / (1.0 + ratio)).asin();
    let disks = std::f64::consts::PI * ratio * ratio + 2.0 * (1.0 - ratio * ratio) * angle;
    1.0 - disks / (2.0 * ratio * (2.0 * ratio + 1.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_porosity_is_that_of_known_packings() {
        let hexagonal = 1.0 - std::f64::consts::PI / 12.0_f64.sqrt();
        assert!((lowest_porosity(1.0) - hexagonal).abs() < 1e-15);
        // A disk in every hole of the hexagonal packing, two to each large one: a packing of these
        // radii, above the bound.
        let hole = 2.0 / 3.0_f64.sqrt() - 1.0;
        let filled = 1.0 - (1.0 - hexagonal) * (1.0 + 2.0 * hole * hole);
        assert!(lowest_porosity(hole) < filled, "{} {filled}", lowest_porosity(hole));
        assert!(lowest_porosity(0.6) < hexagonal && lowest_porosity(0.6) > 0.07);
        assert!(lowest_porosity(1e-9) < 1e-8);
    }
}
