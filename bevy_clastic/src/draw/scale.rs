//! Scales of colours with round ends.

/// Colours of a value from 0, by increasing value.
pub const SEQUENTIAL: [&str; 8] =
    ["#f3f1ec", "#dfe5e8", "#c8d5de", "#adc3d4", "#90afca", "#739abf", "#5684b2", "#3a6ea5"];
/// Colours of a value of either sign, from the lowest (ColorBrewer's RdBu).
pub const DIVERGING: [&str; 9] = [
    "#2166ac", "#4393c3", "#92c5de", "#d1e5f0", "#f7f7f7", "#fddbc7", "#f4a582", "#d6604d",
    "#b2182b",
];
/// Colours of kinds that have no order (Okabe and Ito, legible with any colour vision).
pub const KINDS: [&str; 8] =
    ["#56b4e9", "#e69f00", "#009e73", "#f0e442", "#cc79a7", "#0072b2", "#d55e00", "#999999"];

/// A scale of colours for a quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Colours from the lower to the upper end. The first and the last also show what is beyond.
    pub colors: &'static [&'static str],
    /// Quantity, without its unit.
    pub name: String,
    /// Unit without prefix; empty for a pure number.
    pub unit: &'static str,
    /// Whether values lie beyond the ends.
    pub exceeded: bool,
}

impl Scale {
    /// A scale from 0 for magnitudes. Its end is the round number above 98 % of the values, so that
    /// a few large ones do not take all the colours.
    #[must_use]
    pub fn of_magnitudes(values: &[f64], name: &str, unit: &'static str) -> Self {
        let high = round_up(quantile(values.iter().copied()));
        let exceeded = values.iter().any(|v| *v > high);
        Self { low: 0.0, high, colors: &SEQUENTIAL, name: name.to_owned(), unit, exceeded }
    }

    /// A scale that is symmetric about 0, with the same rule for its ends.
    #[must_use]
    pub fn of_signed(values: &[f64], name: &str, unit: &'static str) -> Self {
        let high = round_up(quantile(values.iter().map(|v| v.abs())));
        let exceeded = values.iter().any(|v| v.abs() > high);
        Self { low: -high, high, colors: &DIVERGING, name: name.to_owned(), unit, exceeded }
    }

    /// Index of the colour of a value.
    #[must_use]
    pub fn class(&self, value: f64) -> usize {
        let share = (value - self.low) / (self.high - self.low);
        if share > 0.0 {
            ((share * self.colors.len() as f64) as usize).min(self.colors.len() - 1)
        } else {
            0
        }
    }

    /// Numbers at the lower end, in the middle and at the upper end, and the quantity with the unit
    /// that they count.
    #[must_use]
    pub fn labels(&self) -> ([String; 3], String) {
        let (prefix, size) = prefix(self.high, self.unit);
        let number = |value: f64| {
            let value: f64 = format!("{:.6e}", value / size).parse().unwrap_or(value);
            (value + 0.0).to_string()
        };
        let unit = format!("{prefix}{}", self.unit);
        let unit = if unit.is_empty() { String::new() } else { format!(", {unit}") };
        let beyond = match (self.exceeded, self.low < 0.0) {
            (false, _) => "",
            (true, false) => "; last colour: and more",
            (true, true) => "; end colours: and beyond",
        };
        let middle = 0.5 * (self.low + self.high);
        ([self.low, middle, self.high].map(number), format!("{}{unit}{beyond}", self.name))
    }
}

/// A value with its unit and a suitable prefix, without digits of round-off.
#[must_use]
pub fn with_unit(value: f64, unit: &str) -> String {
    let (prefix, size) = prefix(value, unit);
    let value: f64 = format!("{:.3e}", value / size).parse().unwrap_or(value);
    format!("{value} {prefix}{unit}")
}

/// The value that 98 % do not exceed.
fn quantile(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.get(sorted.len() * 49 / 50).or(sorted.last()).copied().unwrap_or(0.0)
}

/// The next number of few digits that is not below a value; 1 for 0.
fn round_up(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 1.0;
    }
    let size = value.log10().floor();
    let steps = [1.0, 1.2, 1.6, 2.0, 2.4, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    // By text, since a power of ten times a step has digits of round-off.
    let ends = steps.map(|step| format!("{step}e{size}").parse().unwrap_or(value));
    ends.into_iter().find(|end| *end >= value * (1.0 - 1e-9)).unwrap_or(value)
}

/// Prefix of the unit in which a value has one to three digits before the point.
fn prefix(value: f64, unit: &str) -> (&'static str, f64) {
    match value.abs() {
        _ if unit.is_empty() || unit == "%" => ("", 1.0),
        0.0 => ("", 1.0),
        v if v >= 0.9995e9 => ("G", 1e9),
        v if v >= 0.9995e6 => ("M", 1e6),
        v if v >= 0.9995e3 => ("k", 1e3),
        v if v >= 0.9995 => ("", 1.0),
        v if v >= 0.9995e-3 => ("m", 1e-3),
        v if v >= 0.9995e-6 => ("µ", 1e-6),
        _ => ("n", 1e-9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_round_and_labels_short() {
        let found = [0.93, 41.5, 4.15e-5, 1.0, 0.0, 7.0e8].map(round_up);
        assert_eq!(found, [1.0, 50.0, 5e-5, 1.0, 1.0, 8e8]);
        let scale = Scale::of_magnitudes(&[0.1, 0.0123], "rotation", "rad");
        assert_eq!(
            scale.labels(),
            (["0", "50", "100"].map(str::to_owned), "rotation, mrad".to_owned())
        );
        let scale = Scale::of_signed(&[-3e-6, 1e-6], "rotation", "rad");
        assert_eq!(scale.labels().0, ["-3", "0", "3"]);
    }

    #[test]
    fn classes_cover_the_scale() {
        let scale = Scale::of_magnitudes(&[8.0], "", "");
        let classes = [-1.0, 0.0, 0.99, 1.0, 7.99, 8.0, 99.0, f64::NAN].map(|v| scale.class(v));
        assert_eq!(classes, [0, 0, 0, 1, 7, 7, 7, 0]);
        let signed = Scale::of_signed(&[-9.0, 1.0], "", "");
        assert_eq!([-20.0, -0.9, 0.0, 0.9, 20.0].map(|v| signed.class(v)), [0, 4, 4, 4, 8]);
    }
}
