//! The sample of a laboratory scene: grain sizes, packing, contact law, and a stress that suits the
//! stiffness.

use crate::common::random::Random;

/// Properties of a scene, drawn from its seed.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Number of disks of the specimen, without the grains of platens and hoppers.
    pub count: u32,
    /// Mean radius, m.
    pub radius: f64,
    /// Maximum radius, m.
    pub largest: f64,
    /// Mean of the squared radius, m².
    pub square: f64,
    /// Sizes as the scene writes them.
    pub sizes: Sizes,
    /// Target porosity of the compaction.
    pub porosity: f64,
    /// Normal stiffness of contacts, N/m.
    pub stiffness: f64,
    /// Tangential over normal stiffness.
    pub ratio: f64,
    /// Friction between grains.
    pub friction: f64,
    /// Rolling friction between grains.
    pub rolling: f64,
    /// Friction of walls and platens.
    pub platen: f64,
    /// Stress times thickness over normal stiffness: the compression of a contact over the grain
    /// diameter.
    pub strain: f64,
    /// Whether sliding follows Coulomb's law.
    pub coulomb: bool,
}

/// Size distributions.
#[derive(Clone, Copy, Debug)]
pub enum Sizes {
    /// Uniform by number between two radii, m.
    Uniform(f64, f64),
    /// Log-normal: median, standard deviation of the logarithm, limits.
    LogNormal(f64, f64, f64, f64),
}

impl Sample {
    /// Draws a sample. `small` limits it to 300 disks.
    pub fn draw(random: &mut Random, small: bool) -> Self {
        let share = if small { 0.0 } else { random.unit() };
        let count = match share {
            s if s < 0.5 => random.decades(100.0, 300.0),
            s if s < 0.85 => random.decades(300.0, 800.0),
            _ => random.decades(800.0, 2000.0),
        };
        // Fine and coarse sand, gravel.
        let middle = random.pick(&[0.5e-3, 1.0e-3, 4.0e-3, 10.0e-3]);
        let spread = random.pick(&[1.3, 1.5, 1.7, 2.0, 2.0, 3.0, 4.0]);
        let (sizes, radius, largest, square) = if spread < 4.0 {
            let low = digits(2.0 * middle / (1.0 + spread), 3);
            let high = digits(spread * low, 3);
            let square = (low * low + low * high + high * high) / 3.0;
            (Sizes::Uniform(low, high), 0.5 * (low + high), high, square)
        } else {
            // Median times and over two: a ratio of four.
            let square = middle * middle * (2.0 * 0.3_f64 * 0.3).exp();
            let sizes = Sizes::LogNormal(middle, 0.3, 0.5 * middle, 2.0 * middle);
            (sizes, middle * (0.5 * 0.3_f64 * 0.3).exp(), 2.0 * middle, square)
        };
        let count = digits(count, 2) as u32;
        Self {
            count,
            radius,
            largest,
            square,
            sizes,
            porosity: digits(random.between(densest(count), 0.25), 3),
            stiffness: digits(random.decades(1e6, 1e10), 2),
            ratio: random.pick(&[0.5, 0.5, 0.7, 1.0]),
            friction: digits(random.between(0.2, 0.8), 2),
            rolling: random.maybe(0.4, |r| digits(r.between(0.02, 0.2), 2)).unwrap_or(0.0),
            platen: random.pick(&[0.0, 0.0, 0.2, 0.4]),
            strain: random.pick(&[5e-4, 1e-3, 2e-3]),
            coulomb: random.chance(0.25),
        }
    }

    /// A multiple of the stress that suits the stiffness, Pa.
    pub fn stress(&self, factor: f64) -> f64 {
        digits(factor * self.strain * self.stiffness, 2)
    }

    /// Law of contacts as the scene writes it; rigid without a stiffness.
    pub fn law(&self, stiffness: Option<f64>, friction: f64, rolling: f64) -> String {
        let springs = stiffness.map_or(String::new(), |k| {
            let tangential = digits(self.ratio * k, 2);
            format!("normal_stiffness: {k:?}, tangential_stiffness: {tangential:?}, ")
        });
        let rolling =
            if rolling > 0.0 { format!(", rolling_friction: {rolling:?}") } else { String::new() };
        format!("({springs}friction: {friction:?}{rolling})")
    }

    /// Law of contacts between elastic grains.
    pub fn grains(&self) -> String {
        self.law(Some(self.stiffness), self.friction, self.rolling)
    }

    /// Law of contacts with elastic walls.
    pub fn walls(&self) -> String {
        self.law(Some(self.stiffness), self.platen, 0.0)
    }

    /// Expected area of the disks, m².
    pub fn area(&self) -> f64 {
        f64::from(self.count) * std::f64::consts::PI * self.square
    }

    /// Width (m) of a specimen that is `slenderness` times as high as wide at its target porosity.
    pub fn width(&self, slenderness: f64) -> f64 {
        let width = (self.area() / ((1.0 - self.porosity) * slenderness)).sqrt();
        // The loose grid needs at least four columns.
        digits(width.max(4.2 * self.spacing()), 3)
    }

    /// Expected height at the target porosity, m.
    pub fn height(&self, width: f64) -> f64 {
        digits(self.area() / ((1.0 - self.porosity) * width), 3)
    }

    /// Spacing of the loose grid, m.
    pub fn spacing(&self) -> f64 {
        digits(2.02 * self.largest, 3)
    }

    /// The initial loose grid in a box of the given width: text of the specimen, and height of the
    /// grid (m).
    pub fn packing(&self, width: f64, seed: u64) -> (String, f64) {
        let spacing = self.spacing();
        let columns = (width / spacing).floor() as u32;
        let rows = self.count.div_ceil(columns);
        let origin = digits(0.5 * (width - f64::from(columns) * spacing), 5);
        let text = format!(
            "Packing(count: {}, columns: {columns}, spacing: {spacing:?}, origin: ({origin:?}, 0.0),\n        \
             sizes: {}, seed: {seed})",
            self.count,
            self.sizes.text()
        );
        (text, digits(f64::from(rows) * spacing, 6))
    }
}

impl Sizes {
    /// As the scene writes them.
    pub fn text(&self) -> String {
        match *self {
            Self::Uniform(low, high) => format!("Uniform(radius: ({low:?}, {high:?}))"),
            Self::LogNormal(median, deviation, low, high) => format!(
                "LogNormal(radius: {median:?}, deviation: {deviation:?}, limits: ({low:?}, {high:?}))"
            ),
        }
    }

    /// A radius, m, for scenes that list their particles one by one.
    pub fn radius(&self, random: &mut Random) -> f64 {
        match *self {
            Self::Uniform(low, high) => random.between(low, high),
            Self::LogNormal(median, deviation, low, high) => loop {
                // Box and Muller.
                let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
                let normal = radius * (std::f64::consts::TAU * random.unit()).cos();
                let radius = median * (deviation * normal).exp();
                if (low..=high).contains(&radius) {
                    break radius;
                }
            },
        }
    }
}

/// Minimum target porosity. A compaction without friction jams below it. Small specimens jam
/// earlier, since walls leave additional pores beside them.
fn densest(count: u32) -> f64 {
    (0.165 + 0.6 / f64::from(count).sqrt()).max(0.17)
}

/// A number rounded to `count` significant digits.
pub fn digits(x: f64, count: usize) -> f64 {
    format!("{x:.*e}", count - 1).parse().unwrap()
}

/// A stress in words.
pub fn pascal(stress: f64) -> String {
    let (value, unit) = if stress < 1e4 {
        (stress, "Pa")
    } else if stress < 1e6 {
        (stress / 1e3, "kPa")
    } else {
        (stress / 1e6, "MPa")
    };
    format!("{} {unit}", digits(value, 3))
}
