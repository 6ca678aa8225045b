//! `let`: values with names, and expressions with them, which stand for numbers of a scene.
//!
//! The tree has numbers in place of names and expressions before it is read. Its values keep the
//! places and the texts of the names and expressions.

use std::collections::{BTreeMap, BTreeSet};

use super::courses::{self, Part};
use super::diagnostic::{Finding, place};
use super::dimension::{Dimension, Known, conflict, solve};
use super::expression::{Expression, parse};
use super::read::Notes;
use super::spans::{is_group, join};
use super::suggest;
use super::tree::{Entry, Node, Shape, Span};
use super::units::{self, unit_of};

/// A place where a name or an expression stands for a number.
struct Use<'n, 't> {
    node: &'n Node<'t>,
    path: String,
    expression: Expression,
    unit: Option<&'static str>,
    /// Names with a value in every increment, if it stands for the points of a table.
    own: &'static [&'static str],
}

impl Use<'_, '_> {
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

fn defined<'n, 't>(root: &'n Node<'t>) -> &'n [Entry<'t>] {
    root.field("let").map_or(&[], |defined| &defined.entries)
}

/// Names that `let` defines, with their places.
fn defined_names(root: &Node) -> BTreeMap<String, Span> {
    let name = |entry: &Entry| Some((entry.key.as_ref()?.text.clone(), entry.value.span.clone()));
    defined(root).iter().filter_map(name).collect()
}

/// Names that `let` defines.
pub(crate) fn names(root: &Node) -> Vec<String> {
    defined_names(root).into_keys().collect()
}

/// Names that stand in the numbers of a text.
pub(crate) fn used(root: &Node) -> BTreeSet<String> {
    let mut uses = Vec::new();
    walk(root, String::new(), None, &mut uses);
    uses.iter().flat_map(|at| at.expression.names()).map(str::to_owned).collect()
}

/// Puts numbers in place of names and expressions. Names that are `spared` need no use: a setting has
/// taken it.
pub(crate) fn put_in(root: &mut Node, spared: &BTreeSet<String>) -> Notes {
    let (notes, mut replacements) = replacements(root, spared);
    replace(root, &mut replacements);
    notes
}

/// Values by the byte of the first value that each replaces, and the number of values.
type Replacements<'t> = BTreeMap<usize, (Node<'t>, usize)>;

fn replace<'t>(node: &mut Node<'t>, replacements: &mut Replacements<'t>) {
    let mut k = 0;
    while let Some(Entry { value, .. }) = node.entries.get_mut(k) {
        k += 1;
        match replacements.remove(&value.span.start) {
            Some((new, count)) => {
                *value = new;
                node.entries.drain(k..k + count - 1);
            }
            None => replace(value, replacements),
        }
    }
}

fn replacements<'t>(root: &Node<'t>, spared: &BTreeSet<String>) -> (Notes, Replacements<'t>) {
    let mut notes = Notes::default();
    let places = defined_names(root);
    let courses = courses::find(root);
    let mut uses = Vec::new();
    for course in &courses {
        for Part { node, path, expression } in &course.parts {
            let Some(expression) = expression.clone() else { continue };
            let (path, unit) = (path.clone(), Some(course.unit));
            uses.push(Use { node, path, expression, unit, own: course.names() });
        }
    }
    walk(root, String::new(), None, &mut uses);
    // Those of a course stay: the sort is stable.
    uses.sort_by_key(|at| at.node.span.start);
    uses.dedup_by_key(|at| at.node.span.start);
    uses.retain(|at| {
        let is_known = |name: &&str| places.contains_key(*name) || at.own.contains(name);
        at.expression.names().iter().all(is_known)
    });
    let mut findings = findings(&places, &uses, spared);
    let numbers = numbers(root, &uses);
    let value = |name: &str| Some(numbers.get(name)?.0);
    let mut replacements = Replacements::new();
    for at in uses.iter().filter(|at| at.own.is_empty()) {
        if let Some(angle) = at.expression.wide_angle(&value) {
            let message =
                format!("`{}` has an angle of {angle} rad, more than a full turn", at.node.literal);
            let help = format!("angles are in rad: write `{angle} * pi / 180` for degrees");
            findings.push(Finding::new(&at.path, message, help));
        }
        let new = match (&at.expression, at.expression.value(&value)) {
            // As it is written: a seed has more digits than a number with a point.
            (Expression::Name(name), Some(_)) if numbers.contains_key(name) => {
                at.node.as_number(&numbers[name].1)
            }
            (_, Some(value)) if value.is_finite() => at.node.as_number(&value.to_string()),
            // A name of `let` without a number has a message there.
            (_, None) if !at.path.starts_with("let.") => {
                notes.made_up.push(at.path.clone());
                at.node.as_group(Shape::MadeUp, [])
            }
            _ => continue,
        };
        replacements.insert(at.node.span.start, (new, 1));
    }
    let names: Vec<String> = places.into_keys().collect();
    let mut left = courses::MOST;
    for course in &courses {
        let points = course.sample(&names, &value, &mut left, &mut findings, &mut notes);
        replacements.insert(course.parts[0].node.span.start, (points, course.parts.len()));
    }
    notes.placed = place(root, findings, &[]);
    (notes, replacements)
}

/// Values of names, and their texts.
fn numbers(root: &Node, uses: &[Use]) -> BTreeMap<String, (f64, String)> {
    let mut numbers = BTreeMap::new();
    loop {
        let before = numbers.len();
        for Entry { key, value } in defined(root) {
            let Some(name) = key.as_ref().map(|key| key.text.clone()) else { continue };
            let of = |name: &str| numbers.get(name).map(|(value, _): &(f64, String)| *value);
            let number = match uses.iter().find(|at| at.node.span == value.span) {
                Some(at) => at.expression.value(&of).map(|value| (value, value.to_string())),
                None if value.shape != Shape::Number => None,
                None => {
                    let number = ron::from_str(value.literal).ok();
                    number.map(|number| (number, value.literal.to_owned()))
                }
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

fn findings(
    places: &BTreeMap<String, Span>,
    uses: &[Use],
    spared: &BTreeSet<String>,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut known = Known::new();
    for name in places.keys() {
        let path = join("let", name);
        if !is_name(name) {
            let help = match name.as_str() {
                "pi" => "leave it out: it has its value without `let`",
                _ => "write a word in lower case, as in `confining` or `step_2`",
            };
            let message = format!("`{name}` cannot stand for a number");
            findings.push(Finding::new(path, message, help).at_key());
            continue;
        }
        let course = uses.iter().find(|at| at.own.contains(&name.as_str()) && at.has(name));
        if let Some(Use { path: at, .. }) = course {
            let what = if name == "s" { "progress" } else { "time" };
            let message = format!("`{name}` is the {what} of the stage at {at}");
            let help = format!("give `{name}` another name in `let`");
            findings.push(Finding::new(&path, message, help).at_key());
        }
        if !spared.contains(name) && !uses.iter().any(|at| at.has(name)) {
            let others = places.keys().map(String::as_str).filter(|other| other != name);
            let help = match suggest::nearest(name, others) {
                Some(near) => format!("did you mean `{near}`? Else leave it out"),
                None => format!("write `{name}`, without quotes, for a number, or leave it out"),
            };
            let message = format!("no number uses it (`{name}`)");
            findings.push(Finding::new(path, message, help).at_key());
            continue;
        }
        let alone = uses.iter().filter(|at| at.name() == Some(name));
        let mut alone = alone.filter_map(|at| Some((at, at.unit?)));
        let Some((first, unit)) = alone.next() else { continue };
        known.insert(name.clone(), Dimension::of_unit(unit).powers);
        for (at, here) in alone.filter(|(_, here)| *here != unit) {
            let [here, there] = [here, unit].map(a_number);
            let message = format!("`{name}` is {here} here, and {there} at {}", first.path);
            let help = "give each its own name in `let`";
            findings.push(Finding::new(&at.path, message, help));
        }
    }
    for (name, unit) in [("s", ""), ("t", "s")] {
        if !places.contains_key(name) {
            known.insert(name.to_owned(), Dimension::of_unit(unit).powers);
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
            let message = format!("`{}`: {conflict}", at.node.literal);
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
    let name = places.iter().find(|(_, span)| **span == at.node.span).map(|(name, _)| name);
    let due = name.map(|name| Dimension::of_name(name)).or_else(|| at.unit.map(Dimension::of_unit));
    if let Some(due) = due.filter(|_| own != Dimension::literal()) {
        pairs.push([own, due]);
    }
    pairs
}

pub(crate) fn a_number(unit: &str) -> String {
    if unit.is_empty() { "a plain number".to_owned() } else { format!("a number in {unit}") }
}

/// Whether a word can stand for a number. Words of the format begin with a capital, apart from
/// these.
fn is_name(name: &str) -> bool {
    let first = |c: char| c.is_lowercase() || c == '_';
    name.starts_with(first)
        && name.chars().all(|c| c.is_alphanumeric() || c == '_')
        && !["true", "false", "inf", "pi"].contains(&name)
}

/// Whether a value is a name or an expression, which can stand for a number.
pub(crate) fn stands(node: &Node) -> bool {
    let is_word = || is_name(node.literal) || node.literal == "pi";
    node.shape == Shape::Expression || (node.shape == Shape::Word && is_word())
}

/// Collects names and expressions below a value that may stand for numbers. Paths and units are those of the
/// reader.
fn walk<'n, 't>(
    node: &'n Node<'t>,
    path: String,
    unit: Option<&'static str>,
    uses: &mut Vec<Use<'n, 't>>,
) {
    if stands(node)
        && let Ok(expression) = parse(node.literal)
    {
        uses.push(Use { node, path, expression, unit, own: &[] });
        return;
    }
    let inside = node.name.map_or(unit, |variant| unit_of(variant, unit));
    for (k, entry) in node.entries.iter().enumerate() {
        match &entry.key {
            Some(key) => {
                let unit = if node.shape == Shape::Map { None } else { unit_of(&key.text, None) };
                walk(&entry.value, join(&path, &key.text), unit, uses);
            }
            // The payload of a variant has the path of the variant.
            None if node.name.is_some() && node.entries.len() == 1 && is_group(&entry.value) => {
                walk(&entry.value, path.clone(), inside, uses);
            }
            None => walk(&entry.value, format!("{path}[{k}]"), inside, uses),
        }
    }
}

/// Help for a word or an expression that stands for no number. `unit` is that of the number.
pub(crate) fn help(node: &Node, names: &[String], unit: Option<&str>) -> String {
    let literal = node.literal;
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
