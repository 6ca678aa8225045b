//! Scales of colours with round ends.

/// Colours of a value from 0, by increasing value.
pub const SEQUENTIAL: [&str; 8] =
    ["#f3f1ec", "#dfe5e8", "#c8d5de", "#adc3d4", "#90afca", "#739abf", "#5684b2", "#3a6ea5"];
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
        let beyond = if self.exceeded { "; last colour: and more" } else { "" };
        let middle = 0.5 * (self.low + self.high);
        ([self.low, middle, self.high].map(number), format!("{}{unit}{beyond}", self.name))
    }
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
    }

    #[test]
    fn classes_cover_the_scale() {
        let scale = Scale::of_magnitudes(&[8.0], "", "");
        let classes = [-1.0, 0.0, 0.99, 1.0, 7.99, 8.0, 99.0, f64::NAN].map(|v| scale.class(v));
        assert_eq!(classes, [0, 0, 0, 1, 7, 7, 7, 0]);
    }
}
