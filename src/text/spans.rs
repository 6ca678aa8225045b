//! Place of each field of a scene in its text.
//!
//! A path names a field: `materials.grain.contact.friction`, `stages[3].increments`.
//!
//! - Names of structs and variants are left out: `analysis.dt`, `specimen.sizes.radius`.
//! - An item of a list, a tuple or a positional payload is `[0]`, `[1]`: `walls.top[0]` is the
//!   number in `Force(2.0)`. If the payload is a list or a struct, the index or name refers to its
//!   content: in `Particles([...])`, `specimen[3].radius` is that of a particle.
//! - An item of a list that has a `name` is also found by it: `stages.shear.increments`.
//! - A name that is not a plain word is in quotes: `materials["fine sand"].density`.

use super::scan::{scan, unquote};
pub use super::tree::Span;
use super::tree::{Entry, Key, Node, Shape};

/// Span of a value in a text. One with unbalanced brackets has no places.
pub fn span_of(text: &str, path: &str) -> Option<Span> {
    let (root, steps) = (scan(text).0?, parse_path(path)?);
    let found = descend(&root, &steps);
    (found.depth == steps.len()).then(|| found.node.span.clone())
}

/// Byte of a field: that of its value or its key. For a missing field it is that of the innermost
/// value around it.
pub(crate) fn nearest(root: &Node, path: &str, at_key: bool) -> usize {
    let Some(steps) = parse_path(path) else { return 0 };
    let found = descend(root, &steps);
    match found.key {
        Some(key) if at_key && found.depth == steps.len() => key.span.start,
        _ => found.node.span.start,
    }
}

/// A step of a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// A field, a map key or the name of a list item.
    Name(String),
    /// An index of a list or a tuple.
    Index(usize),
}

impl Step {
    /// Path of the part of the value at `path` to which the step leads.
    pub(crate) fn after(&self, path: &str) -> String {
        match self {
            Self::Name(name) => join(path, name),
            Self::Index(index) => format!("{path}[{index}]"),
        }
    }

    /// The name; `None` for an index.
    pub(crate) fn name(&self) -> Option<&str> {
        match self {
            Self::Name(name) => Some(name),
            Self::Index(_) => None,
        }
    }
}

/// Parses a path; `None` if it is malformed. The empty path is the scene itself.
pub(crate) fn parse_path(path: &str) -> Option<Vec<Step>> {
    let mut steps = Vec::new();
    let mut rest = path;
    while !rest.is_empty() {
        if let Some(inner) = rest.strip_prefix("[\"") {
            let (name, after) = inner.split_once("\"]")?;
            steps.push(Step::Name(name.to_owned()));
            rest = after;
        } else if let Some(inner) = rest.strip_prefix('[') {
            let (index, after) = inner.split_once(']')?;
            steps.push(Step::Index(index.parse().ok()?));
            rest = after;
        } else {
            let name = if steps.is_empty() { rest } else { rest.strip_prefix('.')? };
            let end = name.find(['.', '[']).unwrap_or(name.len());
            if end == 0 {
                return None;
            }
            steps.push(Step::Name(name[..end].to_owned()));
            rest = &name[end..];
        }
    }
    Some(steps)
}

/// Path of a named part of the value at `path`.
pub fn join(path: &str, name: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-');
    if name.is_empty() || !name.chars().all(plain) {
        format!("{path}[\"{name}\"]")
    } else if path.is_empty() {
        name.to_owned()
    } else {
        format!("{path}.{name}")
    }
}

/// Writes a path; the inverse of [`parse_path`].
pub(crate) fn write_path(steps: &[Step]) -> String {
    steps.iter().fold(String::new(), |path, step| step.after(&path))
}

/// Result of following a path.
pub(crate) struct Found<'n, 't> {
    /// The last value that was found.
    pub node: &'n Node<'t>,
    /// Key of this value.
    pub key: Option<&'n Key>,
    /// Number of steps that were followed.
    pub depth: usize,
}

/// Walks along a path and stops at the first step that the text does not have.
pub(crate) fn descend<'n, 't>(root: &'n Node<'t>, steps: &[Step]) -> Found<'n, 't> {
    let mut found = Found { node: root, key: None, depth: 0 };
    for step in steps {
        let Some(entry) = child(found.node, step) else { break };
        found = Found { node: &entry.value, key: entry.key.as_ref(), depth: found.depth + 1 };
    }
    found
}

/// The value whose parts a path addresses: the payload of a variant with one value in brackets,
/// else the value itself.
pub(crate) fn unwrapped<'n, 't>(node: &'n Node<'t>) -> &'n Node<'t> {
    match (node.shape, node.entries.as_slice()) {
        (Shape::Tuple, [only]) if is_group(&only.value) => unwrapped(&only.value),
        _ => node,
    }
}

pub(crate) fn is_group(node: &Node) -> bool {
    matches!(node.shape, Shape::Struct | Shape::Tuple | Shape::List | Shape::Map)
}

/// The `name` of a list item.
pub(crate) fn item_name(node: &Node) -> Option<String> {
    unquote(unwrapped(node).field("name")?.literal)
}

fn child<'n, 't>(node: &'n Node<'t>, step: &Step) -> Option<&'n Entry<'t>> {
    let node = unwrapped(node);
    match step {
        Step::Index(index) => {
            matches!(node.shape, Shape::Tuple | Shape::List).then(|| node.entries.get(*index))?
        }
        Step::Name(name) if node.shape == Shape::List => {
            node.entries.iter().find(|entry| item_name(&entry.value).as_ref() == Some(name))
        }
        Step::Name(name) => node.entry(name),
    }
}
