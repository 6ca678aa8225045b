//! Disks together: their area, their radii, and how dense a packing of them can be.

use std::f64::consts::PI;

use bevy_ecs::prelude::*;

use clastic_components::body::BodyId;
use clastic_components::contact::BodyTable;
use clastic_components::observation::{MeasureArea, MeasureLength, StressMeasure};
use clastic_components::particle::Particle;

/// The disks of a packing.
pub(crate) struct Disks {
    /// Total area, m^2.
    pub area: f64,
    /// Mean radius, m.
    pub mean_radius: f64,
    /// Minimum radius, m.
    pub smallest: f64,
    /// Maximum radius, m.
    pub largest: f64,
}

impl Disks {
    /// Disks of these radii, m.
    pub fn of(radii: impl Iterator<Item = f64>) -> Self {
        let (mut area, mut sum, mut number) = (0.0, 0.0, 0_usize);
        let (mut smallest, mut largest) = (f64::INFINITY, 0.0_f64);
        for radius in radii {
            area += PI * radius * radius;
            sum += radius;
            number += 1;
            (smallest, largest) = (smallest.min(radius), largest.max(radius));
        }
        Self { area, mean_radius: sum / number.max(1) as f64, smallest, largest }
    }

    /// The particles of a world.
    pub(crate) fn in_world(world: &mut World) -> Self {
        Self::of(radii(world).into_iter())
    }

    /// A bound on the porosity of these disks.
    pub(crate) fn lowest_porosity(&self) -> f64 {
        lowest_porosity(self.smallest / self.largest)
    }

    /// Why the disks cannot be packed to a porosity; `None` if nothing speaks against it.
    pub fn refusal(&self, porosity: f64) -> Option<String> {
        let (lowest, Self { smallest, largest, .. }) = (self.lowest_porosity(), self);
        (porosity < lowest).then(|| {
            format!(
                "a porosity of {porosity:?} is below {lowest:.4}, the minimum of disks between \
                 {smallest:.3e} and {largest:.3e} m in radius in the plane (Florian 1960); random \
                 packings jam near 0.16"
            )
        })
    }
}

/// Radii of the particles of a world in the order of identities, m.
pub(super) fn radii(world: &mut World) -> Vec<f64> {
    let mut particles = world.query::<(&BodyId, &Particle)>();
    let ordered = particles.iter(world).sort_unstable::<&BodyId>();
    ordered.map(|(_, particle)| particle.radius).collect()
}

/// Lowest and highest of some points, each with a reach about it, m.
pub(crate) fn ends(points: impl Iterator<Item = (f64, f64)>) -> Option<(f64, f64)> {
    let spans = points.map(|(at, reach)| (at - reach, at + reach));
    spans.reduce(|(low, high), (l, h)| (low.min(l), high.max(h)))
}

/// Ratio of a length or an area to that of the specimen from which on its unit is another one: nearer to
/// the thousand of mm and m than to 1. A beam has a twentieth, the tension in a disk twice the area.
const OTHER_UNIT: f64 = 31.6;

/// Length or area that a stress gives as a number, if its unit is not that of a specimen with these sides.
pub(crate) fn in_other_unit<W>(of: &StressMeasure<W>, sides: [f64; 2]) -> Option<f64> {
    match of {
        StressMeasure::Walls { length: MeasureLength::Fixed(length), .. } => {
            Some(*length).filter(|length| is_apart(*length, sides))
        }
        StressMeasure::Average { area: MeasureArea::Fixed(area), .. } => {
            Some(*area).filter(|area| is_apart(*area, [sides[0] * sides[1]; 2]))
        }
        _ => None,
    }
}

/// Whether a value is far from both of two.
pub(crate) fn is_apart(value: f64, of: [f64; 2]) -> bool {
    value * OTHER_UNIT < of[0].min(of[1]) || value > OTHER_UNIT * of[0].max(of[1])
}

/// Width and height of the periodic cell, or of the box around the particles, m.
pub(crate) fn sides(bodies: &BodyTable) -> Option<[f64; 2]> {
    let side = |axis: usize| {
        let disks = bodies.positions[..bodies.particles].iter().zip(&bodies.radii);
        ends(disks.map(|(x, r)| (x[axis], *r))).map(|(low, high)| high - low)
    };
    match &bodies.cell {
        Some(cell) => Some([cell.width, cell.height]),
        None => Some([side(0)?, side(1)?]),
    }
}

/// Lower bound on the porosity of disks whose smallest radius is `ratio` times the largest: that of
/// the triangle between a largest and two smallest disks that touch (Florian 1960, Rend. Circ. Mat.
/// Palermo 9, 300-312). Of equal disks it is that of the hexagonal packing, 1 - pi/sqrt(12).
fn lowest_porosity(ratio: f64) -> f64 {
    if !(ratio > 0.0) {
        return 0.0;
    }
    let angle = (ratio / (1.0 + ratio)).asin();
    let disks = PI * ratio * ratio + 2.0 * (1.0 - ratio * ratio) * angle;
    1.0 - disks / (2.0 * ratio * (2.0 * ratio + 1.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_porosity_is_that_of_known_packings() {
        let hexagonal = 1.0 - PI / 12.0_f64.sqrt();
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
