//! Arithmetic in place of a number: `2 * cohesion`, `height / 1000`, `tan(pi / 6)`.
//!
//! No crate reads it: values must have the same bits on every machine, which functions of `libm`
//! have and those of the standard library have not, and their units are checked.

use std::f64::consts::{PI, TAU};

use super::dimension::Dimension;
use super::units;

/// Maximum length of an expression in bytes. It bounds the depth of the recursion.
const LONGEST: usize = 1000;

#[derive(Clone, Debug)]
pub(crate) enum Expression {
    Number(f64),
    /// A name that `let` defines.
    Name(String),
    /// Two operands with `+`, `-`, `*`, `/` or `^` between them.
    Operation(char, Box<[Self; 2]>),
    /// A function of one argument.
    Function(&'static Function, Box<Self>),
}

#[derive(Debug)]
pub(crate) struct Function {
    name: &'static str,
    value: fn(f64) -> f64,
    /// Power of the unit of the argument in that of the value. `None`: argument and value are plain
    /// numbers.
    power: Option<f64>,
}

const FUNCTIONS: [Function; 11] = [
    Function { name: "sqrt", value: libm::sqrt, power: Some(0.5) },
    Function { name: "abs", value: libm::fabs, power: Some(1.0) },
    Function { name: "round", value: libm::round, power: Some(1.0) },
    Function { name: "floor", value: libm::floor, power: Some(1.0) },
    Function { name: "ceil", value: libm::ceil, power: Some(1.0) },
    Function { name: "sin", value: libm::sin, power: None },
    Function { name: "cos", value: libm::cos, power: None },
    Function { name: "tan", value: libm::tan, power: None },
    Function { name: "atan", value: libm::atan, power: None },
    Function { name: "exp", value: libm::exp, power: None },
    Function { name: "ln", value: libm::log, power: None },
];

pub(crate) fn is_function(word: &str) -> bool {
    FUNCTIONS.iter().any(|function| function.name == word)
}

pub(crate) fn parse(text: &str) -> Result<Expression, String> {
    if text.len() > LONGEST {
        return Err(format!("give parts of it names in `let`: it has more than {LONGEST} bytes"));
    }
    let mut parser = Parser { rest: text };
    let expression = parser.sum()?;
    match parser.peek() {
        None => Ok(expression),
        Some(c) => Err(format!("an operator or the end was due at `{c}`")),
    }
}

struct Parser<'t> {
    rest: &'t str,
}

impl<'t> Parser<'t> {
    fn peek(&mut self) -> Option<char> {
        self.rest = self.rest.trim_start();
        self.rest.chars().next()
    }

    /// Takes a character if it is one of these.
    fn take(&mut self, any: &[char]) -> Option<char> {
        let c = self.peek().filter(|c| any.contains(c))?;
        self.rest = &self.rest[c.len_utf8()..];
        Some(c)
    }

    fn sum(&mut self) -> Result<Expression, String> {
        self.chain(&['+', '-'], |parser| parser.chain(&['*', '/'], Self::power))
    }

    fn chain(
        &mut self,
        operators: &[char],
        operand: impl Fn(&mut Self) -> Result<Expression, String>,
    ) -> Result<Expression, String> {
        let mut left = operand(self)?;
        while let Some(operator) = self.take(operators) {
            left = Expression::Operation(operator, Box::new([left, operand(self)?]));
        }
        Ok(left)
    }

    /// A power binds more than the sign before it.
    fn power(&mut self) -> Result<Expression, String> {
        let mut is_negative = false;
        while let Some(sign) = self.take(&['+', '-']) {
            is_negative ^= sign == '-';
        }
        let mut power = self.operand()?;
        if self.take(&['^']).is_some() {
            let sign = self.take(&['-']);
            let exponent = self.operand()?;
            let exponent = if sign.is_some() { negative(exponent) } else { exponent };
            power = Expression::Operation('^', Box::new([power, exponent]));
        }
        Ok(if is_negative { negative(power) } else { power })
    }

    fn operand(&mut self) -> Result<Expression, String> {
        if self.take(&['(']).is_some() {
            let inner = self.sum()?;
            self.take(&[')']).ok_or("close the bracket")?;
            return Ok(inner);
        }
        let first = self.peek().ok_or("a number or a name was due at its end")?;
        let length = number_length(self.rest).max(name_length(self.rest));
        let (word, rest) = self.rest.split_at(length);
        self.rest = rest;
        if word.is_empty() {
            return Err(format!("a number or a name was due at `{first}`"));
        }
        if !first.is_alphabetic() && first != '_' {
            // The names of progress and time, s and t, are units too.
            let with_unit = |(number, unit): (f64, &str)| {
                let is_unit = units::is_unit(unit) && !["s", "t"].contains(&unit);
                is_unit.then(|| units::help(number, unit, None))
            };
            let number = ron::from_str(word).map_err(|_| {
                let help = units::split(word).and_then(with_unit);
                help.unwrap_or_else(|| format!("`{word}` is not a number"))
            })?;
            self.peek();
            let unit = &self.rest[..name_length(self.rest)];
            if let Some(help) = with_unit((number, unit)) {
                return Err(help);
            }
            return Ok(Expression::Number(number));
        }
        if self.peek() != Some('(') {
            return Ok(Expression::Name(word.to_owned()));
        }
        let Some(function) = FUNCTIONS.iter().find(|function| function.name == word) else {
            let names: Vec<_> = FUNCTIONS.iter().map(|function| function.name).collect();
            return Err(super::suggest::help(word, &names, "functions"));
        };
        Ok(Expression::Function(function, Box::new(self.operand()?)))
    }
}

fn negative(expression: Expression) -> Expression {
    Expression::Operation('-', Box::new([Expression::Number(0.0), expression]))
}

fn name_length(text: &str) -> usize {
    let inner = |c: char| c.is_alphanumeric() || c == '_';
    let starts = text.starts_with(|c: char| c.is_alphabetic() || c == '_');
    if starts { text.find(|c| !inner(c)).unwrap_or(text.len()) } else { 0 }
}

/// Length of a number without a sign: a sign belongs to it only after the `e` of its exponent.
pub(super) fn number_length(text: &str) -> usize {
    if !text.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
        return 0;
    }
    let mut before = ' ';
    let ends = |(_, c): &(usize, char)| {
        let sign = matches!(c, '+' | '-') && matches!(before, 'e' | 'E');
        before = *c;
        !(c.is_alphanumeric() || matches!(c, '.' | '_') || sign)
    };
    text.char_indices().find(ends).map_or(text.len(), |(at, _)| at)
}

impl Expression {
    /// Its value; `None` where a name has no value.
    pub fn value(&self, of: &impl Fn(&str) -> Option<f64>) -> Option<f64> {
        Some(match self {
            Self::Number(value) => *value,
            Self::Name(name) => of(name).or((name == "pi").then_some(PI))?,
            Self::Operation(operator, operands) => {
                let [a, b] = [operands[0].value(of)?, operands[1].value(of)?];
                match operator {
                    '+' => a + b,
                    '-' => a - b,
                    '*' => a * b,
                    '/' => a / b,
                    _ => libm::pow(a, b),
                }
            }
            Self::Function(function, argument) => (function.value)(argument.value(of)?),
        })
    }

    /// The first angle beyond a full turn in it, rad.
    pub fn wide_angle(&self, of: &impl Fn(&str) -> Option<f64>) -> Option<f64> {
        match self {
            Self::Number(_) | Self::Name(_) => None,
            Self::Operation(_, operands) => operands.iter().find_map(|part| part.wide_angle(of)),
            Self::Function(Function { name, .. }, argument) => {
                let is_angle = matches!(*name, "sin" | "cos" | "tan");
                let angle = argument.value(of).filter(|angle| is_angle && angle.abs() > TAU);
                angle.or_else(|| argument.wide_angle(of))
            }
        }
    }

    /// Its names but `pi`.
    pub fn names(&self) -> Vec<&str> {
        match self {
            Self::Number(_) => Vec::new(),
            Self::Name(name) if name == "pi" => Vec::new(),
            Self::Name(name) => vec![name],
            Self::Operation(_, operands) => operands.iter().flat_map(Self::names).collect(),
            Self::Function(_, argument) => argument.names(),
        }
    }

    /// Its dimension. Adds pairs of dimensions that must be the same.
    pub fn dimension(&self, same: &mut Vec<[Dimension; 2]>) -> Dimension {
        match self {
            Self::Number(_) => Dimension::literal(),
            Self::Name(name) if name == "pi" => Dimension::literal(),
            Self::Name(name) => Dimension::of_name(name),
            Self::Operation(operator, operands) => {
                let [a, b] = [operands[0].dimension(same), operands[1].dimension(same)];
                match operator {
                    '*' => a.times(&b, 1.0),
                    '/' => a.times(&b, -1.0),
                    '^' => match operands[1].value(&|_| None) {
                        Some(power) => Dimension::default().times(&a, power),
                        None => {
                            same.push([b, Dimension::default()]);
                            same.push([a, Dimension::default()]);
                            Dimension::default()
                        }
                    },
                    _ if a == Dimension::literal() => b,
                    _ if b == Dimension::literal() => a,
                    _ => {
                        same.push([a.clone(), b]);
                        a
                    }
                }
            }
            Self::Function(Function { power, .. }, argument) => {
                let argument = argument.dimension(same);
                match power {
                    Some(power) => Dimension::default().times(&argument, *power),
                    None => {
                        same.push([argument, Dimension::default()]);
                        Dimension::literal()
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> f64 {
        let names =
            |name: &str| [("a", 3.0), ("b", -4.0)].iter().find(|n| n.0 == name).map(|n| n.1);
        parse(text).unwrap_or_else(|error| panic!("{text}: {error}")).value(&names).unwrap()
    }

    #[test]
    fn values_of_expressions() {
        for (text, expected) in [
            ("2 * a", 6.0),
            ("-a", -3.0),
            ("1 - 2 - 3", -4.0),
            ("12 / 2 / 3", 2.0),
            ("1+2*3", 7.0),
            ("(1 + 2) * 3", 9.0),
            ("-2^2", -4.0),
            ("2^-1", 0.5),
            ("--a", 3.0),
            ("2 * -a", -6.0),
            ("1e-3*2e+3", 2.0),
            ("a-1", 2.0),
            ("2-a", -1.0),
            ("1_000 / 8", 125.0),
            ("sqrt(a^2 + b^2)", 5.0),
            ("abs(b) - floor(4.7) + ceil(4.2) + round(2.5)", 8.0),
            ("atan(1) * 4 / pi", 1.0),
            ("exp(ln(2.0)) + tan(0) + sin(0) + cos(0)", 3.0),
        ] {
            assert!((value(text) - expected).abs() < 1e-15 * expected.abs(), "{text}");
        }
    }

    #[test]
    fn mistakes_are_named() {
        for (text, said) in [
            ("2 *", "a number or a name was due at its end"),
            ("2 * * 3", "a number or a name was due at `*`"),
            ("2 3", "an operator or the end was due at `3`"),
            ("2^3^4", "an operator or the end was due at `^`"),
            ("(1 + 2", "close the bracket"),
            ("1.2.3 + 1", "`1.2.3` is not a number"),
            ("sqr(2)", "did you mean `sqrt`?"),
            ("2 mm * a", "numbers are in SI units: write 0.002"),
            ("a * 2kPa", "numbers are in SI units: write 2000.0"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.starts_with(said), "{text}: {error}");
        }
        assert!(parse(&"-".repeat(100_000)).is_err() && parse(&"1+".repeat(999)).is_err());
    }
}
