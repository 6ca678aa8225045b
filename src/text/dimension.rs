//! Dimensions of expressions: powers of units, and of names whose unit is still unknown.

use std::collections::BTreeMap;

use super::units::parse;
use super::values::a_number;

/// Dimension of an expression: a product of powers.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Dimension {
    /// Powers of m, kg and s, apart from those of names. An angle is a plain number.
    pub powers: [f64; 3],
    names: BTreeMap<String, f64>,
    /// Whether a number without a name is a factor. It may have a unit where nothing else has one:
    /// `1e6 * scale`.
    has_literal: bool,
}

/// Powers of m, kg and s of names whose unit is known.
pub(crate) type Known = BTreeMap<String, [f64; 3]>;

impl Dimension {
    /// That of a number without a name.
    pub fn literal() -> Self {
        Self { has_literal: true, ..Self::default() }
    }

    pub(crate) fn of_name(name: &str) -> Self {
        Self { names: [(name.to_owned(), 1.0)].into(), ..Self::default() }
    }

    pub(crate) fn of_unit(unit: &str) -> Self {
        let powers = parse(&unit.replace('^', "")).map_or([0; 4], |(_, powers)| powers);
        let [m, kg, s, _] = powers.map(f64::from);
        Self { powers: [m, kg, s], ..Self::default() }
    }

    /// Product with a power of another dimension.
    pub fn times(mut self, other: &Self, power: f64) -> Self {
        for (own, other) in self.powers.iter_mut().zip(other.powers) {
            *own += power * other;
        }
        for (name, of_name) in &other.names {
            *self.names.entry(name.clone()).or_default() += power * of_name;
        }
        self.names.retain(|_, power| *power != 0.0);
        self.has_literal |= other.has_literal;
        self
    }

    /// Puts in the names that are known.
    fn with(mut self, known: &Known) -> Self {
        self.names.retain(|name, power| {
            let Some(powers) = known.get(name) else { return true };
            for (own, of_name) in self.powers.iter_mut().zip(powers) {
                *own += *power * of_name;
            }
            false
        });
        self
    }

    /// The unit in words.
    fn said(&self) -> String {
        const UNITS: [&str; 13] =
            ["", "m", "s", "kg", "N", "Pa", "N/m", "m^2", "m/s", "m/s^2", "kg/m^3", "N m", "kg/s"];
        if let Some(unit) = UNITS.iter().find(|unit| Self::of_unit(unit).powers == self.powers) {
            return a_number(unit);
        }
        let powers = ["m", "kg", "s"].iter().zip(self.powers).filter(|(_, power)| *power != 0.0);
        let powers = powers.map(|(unit, power)| format!("{unit}^{power}"));
        a_number(&powers.collect::<Vec<_>>().join(" "))
    }
}

/// Finds the units of names from pairs of dimensions that are the same and have one name whose unit
/// is not known.
pub(crate) fn solve(pairs: &[&[Dimension; 2]], known: &mut Known) {
    loop {
        let before = known.len();
        for [a, b] in pairs.iter().filter(|pair| !pair.iter().any(|side| side.has_literal)) {
            let quotient = a.clone().times(b, -1.0).with(known);
            if let [(name, power)] = quotient.names.iter().collect::<Vec<_>>()[..] {
                known.insert(name.clone(), quotient.powers.map(|own| -own / power));
            }
        }
        if known.len() == before {
            return;
        }
    }
}

/// What is wrong with a pair of dimensions that must be the same; `None` if nothing is, or if it
/// cannot be told.
pub(crate) fn conflict([a, b]: &[Dimension; 2], known: &Known) -> Option<String> {
    let [a, b] = [a.clone().with(known), b.clone().with(known)];
    let sure = |side: &Dimension| !side.has_literal || side.powers != [0.0; 3];
    let differ = a.powers.iter().zip(b.powers).any(|(a, b)| (a - b).abs() > 1e-9);
    (differ && a.names.is_empty() && b.names.is_empty() && sure(&a) && sure(&b))
        .then(|| format!("{}, where {} is due", a.said(), b.said()))
}
