//! `let`: values with names, which stand for numbers of a scene.
//!
//! The text has the values in place of the names before it is read. Messages keep the places of the
//! file.

use std::collections::BTreeMap;

use super::diagnostic::Finding;
use super::edited::EditedText;
use super::scan::scan;
use super::spans::{is_group, join};
use super::suggest;
use super::tree::{Entry, Node, Shape, Span};
use super::units::unit_of;

/// A number of the scene for which a name stands.
struct Use {
    span: Span,
    path: String,
    name: String,
    negative: bool,
    unit: Option<&'static str>,
}

/// Names that `let` defines, with the texts of their values.
fn defined<'a>(root: &Node, text: &'a str) -> BTreeMap<String, (&'a str, Shape)> {
    let is_let = |entry: &&Entry| entry.key.as_ref().is_some_and(|key| key.text == "let");
    let Some(Entry { value, .. }) = root.entries.iter().find(is_let) else {
        return BTreeMap::new();
    };
    let literal = |entry: &Entry| {
        let value = text.get(entry.value.span.clone()).unwrap_or_default();
        Some((entry.key.as_ref()?.text.clone(), (value, entry.value.shape)))
    };
    value.entries.iter().filter_map(literal).collect()
}

/// Names that `let` defines.
pub(super) fn names(root: &Node, text: &str) -> Vec<String> {
    defined(root, text).into_keys().collect()
}

/// Puts the values in place of their names. Returns the new text, and mistakes in their use.
pub(super) fn put_in(edited: &EditedText) -> (EditedText, Vec<Finding>) {
    let text = edited.text.as_str();
    let nothing = || (edited.clone(), Vec::new());
    // Most scenes have no `let`, and scanning a large one takes time.
    if !text.contains("let") {
        return nothing();
    }
    let Some(root) = scan(text).0 else { return nothing() };
    let values = defined(&root, text);
    if values.is_empty() {
        return nothing();
    }
    let mut uses = Vec::new();
    for entry in &root.entries {
        let Some(key) = entry.key.as_ref().filter(|key| key.text != "let") else { continue };
        walk(&entry.value, text, key.text.clone(), unit_of(&key.text, None), &mut uses);
    }
    uses.retain(|at| values.contains_key(&at.name));
    let findings = findings(&values, &uses);
    let mut new = edited.clone();
    for at in uses.iter().rev() {
        let (value, shape) = values[&at.name];
        if shape != Shape::Number {
            continue;
        }
        let value = match (at.negative, value.strip_prefix('-')) {
            (false, _) => value.to_owned(),
            (true, Some(positive)) => positive.to_owned(),
            (true, None) => format!("-{value}"),
        };
        new.put_in(at.span.clone(), &value);
    }
    (new, findings)
}

fn findings(values: &BTreeMap<String, (&str, Shape)>, uses: &[Use]) -> Vec<Finding> {
    let mut findings = Vec::new();
    let at_key = |path: &str, message: String, help: String| Finding {
        at_key: true,
        ..Finding::new(path, message, help)
    };
    for name in values.keys() {
        let path = join("let", name);
        if !is_name(name) {
            let help = "write a word in lower case, as in `confining` or `step_2`".to_owned();
            findings.push(at_key(&path, format!("`{name}` cannot stand for a number"), help));
            continue;
        }
        let mut used = uses.iter().filter(|at| at.name == *name);
        let Some(mut first) = used.next() else {
            let others = values.keys().map(String::as_str).filter(|other| other != name);
            let help = match suggest::nearest(name, others) {
                Some(near) => format!("did you mean `{near}`? Else leave it out"),
                None => format!("write `{name}`, without quotes, for a number, or leave it out"),
            };
            findings.push(at_key(&path, format!("no number uses it (`{name}`)"), help));
            continue;
        };
        for at in used {
            let (Some(before), Some(here)) = (first.unit, at.unit) else {
                if first.unit.is_none() {
                    first = at;
                }
                continue;
            };
            if before != here {
                let message = format!(
                    "`{name}` is {} here, and {} at {}",
                    a_number(here),
                    a_number(before),
                    first.path
                );
                let help = "give each its own name in `let`".to_owned();
                findings.push(Finding::new(&at.path, message, help));
            }
        }
    }
    findings
}

fn a_number(unit: &str) -> String {
    if unit.is_empty() { "a plain number".to_owned() } else { format!("a number in {unit}") }
}

/// Whether a word can stand for a number. Words of the format begin with a capital, apart from
/// these.
fn is_name(name: &str) -> bool {
    let first = |c: char| c.is_lowercase() || c == '_';
    name.starts_with(first)
        && name.chars().all(|c| c.is_alphanumeric() || c == '_')
        && !["true", "false", "inf"].contains(&name)
}

/// The name that stands for a number, and whether a minus sign is before it.
pub(super) fn name_of<'a>(node: &Node, text: &'a str) -> Option<(&'a str, bool)> {
    let literal = text.get(node.span.clone())?;
    let (name, negative) = match node.shape {
        Shape::Word => (literal, false),
        Shape::Number => (literal.strip_prefix('-')?, true),
        _ => return None,
    };
    is_name(name).then_some((name, negative))
}

/// Collects the words below a value that may stand for numbers. Paths and units are those of the
/// reader.
fn walk(node: &Node, text: &str, path: String, unit: Option<&'static str>, uses: &mut Vec<Use>) {
    if let Some((name, negative)) = name_of(node, text) {
        let (span, name) = (node.span.clone(), name.to_owned());
        uses.push(Use { span, path, name, negative, unit });
        return;
    }
    let variant = node.name.clone().and_then(|name| text.get(name));
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

/// Help for a word that stands for no number.
pub(super) fn help(word: &str, names: &[String]) -> String {
    if names.iter().any(|name| name == word) {
        return format!("give `{word}` a number in `let`");
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    suggest::help(word, &names, "values of `let`")
}
