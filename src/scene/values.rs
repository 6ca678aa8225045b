//! `let`: values with names, and expressions with them, which stand for numbers of a scene.
//!
//! The text has numbers in place of names and expressions before it is read. Messages keep the
//! places of the file.

use std::collections::{BTreeMap, BTreeSet};

use super::courses;
use super::diagnostic::Finding;
use super::dimension::{Dimension, Known, conflict, solve};
use super::edited::EditedText;
use super::expression::{Expression, parse};
use super::scan::scan;
use super::spans::{is_group, join};
use super::suggest;
use super::tree::{Entry, Node, Shape, Span};
use super::units::{self, unit_of};

/// A place where a name or an expression stands for a number.
struct Use {
    span: Span,
    path: String,
    expression: Expression,
    unit: Option<&'static str>,
    /// Names with a value in every increment, if it stands for the points of a table.
    own: &'static [&'static str],
}

impl Use {
    /// Whether a name occurs in it.
    fn has(&self, name: &str) -> bool {
        self.expression.names().contains(&name)
    }

    /// The name, if it stands alone or with a sign before it.
    fn name(&self) -> Option<&str> {
        match &self.expression {
            Expression::Name(name) => Some(name),
            Expression::Operation('-', operands) => match &**operands {
                [Expression::Number(0.0), Expression::Name(name)] => Some(name),
                _ => None,
            },
            _ => None,
        }
    }
}

/// The entries of `let`.
fn defined(root: &Node) -> &[Entry] {
    root.field("let").map_or(&[], |defined| &defined.entries)
}

/// Names that `let` defines, with their places.
fn defined_names(root: &Node) -> BTreeMap<String, Span> {
    let name = |entry: &Entry| Some((entry.key.as_ref()?.text.clone(), entry.value.span.clone()));
    defined(root).iter().filter_map(name).collect()
}

/// Names that `let` defines.
pub(super) fn names(root: &Node) -> Vec<String> {
    defined_names(root).into_keys().collect()
}

/// A text with numbers in place of names and expressions.
pub(super) struct Values {
    /// The text.
    pub text: EditedText,
    /// Mistakes in the use of names and expressions.
    pub findings: Vec<Finding>,
    /// Tables that expressions stood for: path and number of increments.
    pub tables: Vec<(String, f64)>,
    /// Paths of such tables whose points are made up.
    pub made_up: Vec<String>,
}

/// Puts numbers in place of names and expressions.
pub(super) fn put_in(edited: &EditedText) -> Values {
    let text = edited.text.as_str();
    let mut new = Values {
        text: edited.clone(),
        findings: Vec::new(),
        tables: Vec::new(),
        made_up: Vec::new(),
    };
    let Some(root) = scan(text).0 else { return new };
    let places = defined_names(&root);
    let mut uses = Vec::new();
    walk(&root, text, String::new(), None, &mut uses);
    let courses = courses::find(&root, text);
    let parts: BTreeSet<_> =
        courses.iter().flat_map(|course| &course.parts).map(|part| part.node.span.start).collect();
    uses.retain(|at| !parts.contains(&at.span.start));
    for course in &courses {
        for part in &course.parts {
            let Some(expression) = part.expression.clone() else { continue };
            let (span, path) = (part.node.span.clone(), part.path.clone());
            uses.push(Use { span, path, expression, unit: Some(course.unit), own: course.names() });
        }
    }
    uses.sort_by_key(|at| at.span.start);
    uses.retain(|at| {
        let is_known = |name: &&str| places.contains_key(*name) || at.own.contains(name);
        at.expression.names().iter().all(is_known)
    });
    new.findings = findings(text, &places, &uses);
    let numbers = numbers(text, &root, &uses);
    let value = |name: &str| Some(numbers.get(name)?.0);
    let mut texts = Vec::new();
    for at in uses.iter().filter(|at| at.own.is_empty()) {
        let number = match &at.expression {
            // As it is written: a seed has more digits than a number with a point.
            Expression::Name(name) if numbers.contains_key(name) => numbers[name].1.clone(),
            expression => match expression.value(&value).filter(|value| value.is_finite()) {
                Some(value) => value.to_string(),
                None => continue,
            },
        };
        texts.push((at.span.clone(), number));
    }
    let names: Vec<String> = places.into_keys().collect();
    let mut left = courses::MOST;
    for course in &courses {
        let sampled = course.sample(text, &names, &value, &mut left);
        texts.extend(sampled.texts);
        if !sampled.findings.is_empty() {
            new.made_up.push(course.path.clone());
        }
        new.findings.extend(sampled.findings);
        new.tables.push((course.path.clone(), sampled.increments));
    }
    texts.sort_by_key(|(span, _)| span.start);
    for (span, number) in texts.into_iter().rev() {
        new.text.put_in(span, &number);
    }
    new
}

/// Values of names, and their texts.
fn numbers(text: &str, root: &Node, uses: &[Use]) -> BTreeMap<String, (f64, String)> {
    let mut numbers = BTreeMap::new();
    loop {
        let before = numbers.len();
        for Entry { key, value } in defined(root) {
            let Some(name) = key.as_ref().map(|key| key.text.clone()) else { continue };
            let literal = value.literal(text);
            let of = |name: &str| numbers.get(name).map(|(value, _): &(f64, String)| *value);
            let number = match uses.iter().find(|at| at.span == value.span) {
                Some(at) => at.expression.value(&of).map(|value| (value, value.to_string())),
                None if value.shape != Shape::Number => None,
                None => ron::from_str(literal).ok().map(|value| (value, literal.to_owned())),
            };
            if let Some(number) = number.filter(|(value, _)| value.is_finite()) {
                numbers.insert(name, number);
            }
        }
        if numbers.len() == before {
            return numbers;
        }
    }
}

fn findings(text: &str, places: &BTreeMap<String, Span>, uses: &[Use]) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut known = Known::new();
    let at_key = |path: &str, message: String, help: String| Finding {
        at_key: true,
        ..Finding::new(path, message, help)
    };
    for name in places.keys() {
        let path = join("let", name);
        if !is_name(name) {
            let help = match name.as_str() {
                "pi" => "leave it out: it has its value without `let`",
                _ => "write a word in lower case, as in `confining` or `step_2`",
            };
            let message = format!("`{name}` cannot stand for a number");
            findings.push(at_key(&path, message, help.to_owned()));
            continue;
        }
        let course = uses.iter().find(|at| at.own.contains(&name.as_str()) && at.has(name));
        if let Some(Use { path: at, .. }) = course {
            let what = if name == "s" { "progress" } else { "time" };
            let message = format!("`{name}` is the {what} of the stage at {at}");
            findings.push(at_key(&path, message, format!("give `{name}` another name in `let`")));
        }
        if !uses.iter().any(|at| at.has(name)) {
            let others = places.keys().map(String::as_str).filter(|other| other != name);
            let help = match suggest::nearest(name, others) {
                Some(near) => format!("did you mean `{near}`? Else leave it out"),
                None => format!("write `{name}`, without quotes, for a number, or leave it out"),
            };
            findings.push(at_key(&path, format!("no number uses it (`{name}`)"), help));
            continue;
        }
        let alone = uses.iter().filter(|at| at.name() == Some(name));
        let mut alone = alone.filter_map(|at| Some((at, at.unit?)));
        let Some((first, unit)) = alone.next() else { continue };
        known.insert(name.clone(), Dimension::of_unit(unit).powers());
        for (at, here) in alone.filter(|(_, here)| *here != unit) {
            let [here, there] = [here, unit].map(a_number);
            let message = format!("`{name}` is {here} here, and {there} at {}", first.path);
            let help = "give each its own name in `let`".to_owned();
            findings.push(Finding::new(&at.path, message, help));
        }
    }
    for (name, unit) in [("s", ""), ("t", "s")] {
        if !places.contains_key(name) {
            known.insert(name.to_owned(), Dimension::of_unit(unit).powers());
        }
    }
    // Names that stand alone are compared above.
    let composite = uses
        .iter()
        .filter(|at| at.unit.is_none() || at.name().is_none_or(|name| at.own.contains(&name)));
    let pairs: Vec<_> = composite.map(|at| (at, pairs(at, places))).collect();
    let all: Vec<_> = pairs.iter().flat_map(|(_, pairs)| pairs).collect();
    solve(&all, &mut known);
    for (at, pairs) in &pairs {
        if let Some(conflict) = pairs.iter().find_map(|pair| conflict(pair, &known)) {
            let message =
                format!("`{}`: {conflict}", text.get(at.span.clone()).unwrap_or_default());
            let help = "factors with a unit need names in `let`";
            findings.push(Finding::new(&at.path, message, help));
        }
    }
    findings
}

/// Pairs of dimensions that must be the same where an expression stands.
fn pairs(at: &Use, places: &BTreeMap<String, Span>) -> Vec<[Dimension; 2]> {
    let mut pairs = Vec::new();
    let own = at.expression.dimension(&mut pairs);
    let name = places.iter().find(|(_, span)| **span == at.span).map(|(name, _)| name);
    let due = name.map(|name| Dimension::of_name(name)).or_else(|| at.unit.map(Dimension::of_unit));
    if let Some(due) = due.filter(|_| own != Dimension::literal()) {
        pairs.push([own, due]);
    }
    pairs
}

pub(super) fn a_number(unit: &str) -> String {
    if unit.is_empty() { "a plain number".to_owned() } else { format!("a number in {unit}") }
}

/// Whether a word can stand for a number. Words of the format begin with a capital, apart from
/// these.
pub(super) fn is_name(name: &str) -> bool {
    let first = |c: char| c.is_lowercase() || c == '_';
    name.starts_with(first)
        && name.chars().all(|c| c.is_alphanumeric() || c == '_')
        && !["true", "false", "inf", "pi"].contains(&name)
}

/// The expression that stands for a number.
fn expression(node: &Node, text: &str) -> Option<Expression> {
    let literal = node.literal(text);
    match node.shape {
        Shape::Word if is_name(literal) || literal == "pi" => parse(literal).ok(),
        Shape::Expression => parse(literal).ok(),
        _ => None,
    }
}

/// Collects names and expressions below a value that may stand for numbers. Paths and units are those of the
/// reader.
fn walk(node: &Node, text: &str, path: String, unit: Option<&'static str>, uses: &mut Vec<Use>) {
    if let Some(expression) = expression(node, text) {
        uses.push(Use { span: node.span.clone(), path, expression, unit, own: &[] });
        return;
    }
    let variant = node.variant(text);
    let inside = variant.map_or(unit, |variant| unit_of(variant, unit));
    for (k, entry) in node.entries.iter().enumerate() {
        match &entry.key {
            Some(key) => {
                let unit = if node.shape == Shape::Map { None } else { unit_of(&key.text, None) };
                walk(&entry.value, text, join(&path, &key.text), unit, uses);
            }
            // The payload of a variant has the path of the variant.
            None if node.name.is_some() && node.entries.len() == 1 && is_group(&entry.value) => {
                walk(&entry.value, text, path.clone(), inside, uses);
            }
            None => walk(&entry.value, text, format!("{path}[{k}]"), inside, uses),
        }
    }
}

/// Help for a word or an expression that stands for no number. `unit` is that of the number.
pub(super) fn help(node: &Node, text: &str, names: &[String], unit: Option<&str>) -> String {
    let literal = node.literal(text);
    let expression = match parse(literal) {
        Ok(expression) if node.shape == Shape::Expression || is_name(literal) => expression,
        Err(help) if node.shape == Shape::Expression => return help,
        _ => return String::new(),
    };
    if let Some((value, of)) = units::split(literal).filter(|(_, of)| units::is_unit(of)) {
        return units::help(value, of, unit);
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    match expression.names().into_iter().find(|word| !names.contains(word)) {
        Some(_) if names.is_empty() && node.shape == Shape::Word => String::new(),
        Some(word) if names.is_empty() => format!("give `{word}` a number in `let`"),
        Some(word) => suggest::help(word, &names, "values of `let`"),
        None if node.shape == Shape::Word => format!("give `{literal}` a number in `let`"),
        None => "its value is not finite, or a name in it has none".to_owned(),
    }
}
