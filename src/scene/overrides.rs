//! `--set path=value`: edits of the scene's text before it is read.
//!
//! The text is edited instead of the values, so that comments survive and later messages still
//! refer to places. A value is RON. A bare word counts as a string if only a string fits. A missing
//! field is inserted together with the structs around it, and the place after the last item of a
//! list takes a new item.

use std::fmt;

use super::format::Scene;
use crate::text::diagnostic::Finding;
use crate::text::edited::EditedText;
use crate::text::read::read;
use crate::text::scan::scan;
use crate::text::shown::brief;
use crate::text::spans::{
    Step, descend, is_group, item_name, join, parse_path, unwrapped, write_path,
};
use crate::text::tree::{Entry, Node, Shape, Span};
use crate::text::{suggest, values};

/// A `--set` that cannot be applied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SetError {
    /// The setting, `path=value`.
    pub set: String,
    /// The mistake.
    pub message: String,
    /// The remedy.
    pub help: Option<String>,
}

impl fmt::Display for SetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "--set {}: {}", brief(&self.set), brief(&self.message))?;
        self.help.as_ref().map_or(Ok(()), |help| write!(f, "; {}", brief(help)))
    }
}

impl std::error::Error for SetError {}

/// Applies settings in order, those of `let` first, since others may use its names. Returns the new
/// text with the source of every part.
///
/// A text with unbalanced brackets is returned unchanged, and reading it reports the mistake.
pub fn apply(text: &str, sets: &[impl AsRef<str>]) -> Result<EditedText, SetError> {
    let names_a_number = |set: &str| {
        let path = set.split_once('=').and_then(|(path, _)| parse_path(path.trim()));
        path.is_some_and(|steps| steps.first().and_then(Step::name) == Some("let"))
    };
    let mut sets: Vec<&str> = sets.iter().map(AsRef::as_ref).collect();
    sets.sort_by_key(|set| !names_a_number(set));
    sets.into_iter().try_fold(EditedText::of(text), apply_one)
}

fn apply_one(mut edited: EditedText, set: &str) -> Result<EditedText, SetError> {
    let error = |message: &str, help: String| SetError {
        set: set.to_owned(),
        message: message.to_owned(),
        help: Some(help).filter(|help| !help.is_empty()),
    };
    let parts = set.split_once('=').map(|(path, value)| (parse_path(path.trim()), value.trim()));
    let Some((Some(steps), value)) = parts.filter(|(steps, _)| steps != &Some(Vec::new())) else {
        let help = "write path=value, as in `materials.grain.contact.friction=0.3`";
        return Err(error("not a setting", help.to_owned()));
    };
    let text = edited.text.as_str();
    let Some(root) = scan(text).0 else { return Ok(edited) };
    let place = Place::find(&root, &steps).map_err(|help| error("no such field", help))?;

    let (plain, quoted) = (place.with(value), place.with(&format!("{value:?}")));
    let refusal = if is_one_value(value) {
        place.refusal(text, &plain)
    } else {
        Some(Finding::new("", format!("`{value}` is not a value in RON"), ""))
    };
    let new = match refusal {
        None => plain,
        Some(_) if !value.starts_with('"') && place.refusal(text, &quoted).is_none() => quoted,
        Some(wrong) => return Err(error(&wrong.message, wrong.help.unwrap_or_default())),
    };
    edited.replace(place.span, &new, set);
    Ok(edited)
}

/// Whether a text is exactly one value, so that it cannot affect the text after it.
fn is_one_value(value: &str) -> bool {
    let (node, faults) = scan(value);
    let whole = |node: Node| node.span == (0..value.len()) && node.shape != Shape::Nothing;
    faults.is_empty() && node.is_some_and(whole)
}

/// Place of a value: `before`, the value and `after` replace `span`.
struct Place {
    span: Span,
    before: String,
    after: String,
}

impl Place {
    /// Place of a field, or help that names the existing fields.
    fn find(root: &Node, steps: &[Step]) -> Result<Self, String> {
        let found = descend(root, steps);
        let Some(next) = steps.get(found.depth) else {
            let span = found.node.span.clone();
            return Ok(Self { span, before: String::new(), after: String::new() });
        };
        let parent = unwrapped(found.node);
        let (at, comma) = match parent.entries.last() {
            Some(last) => (last.value.span.end, ", "),
            None => (parent.span.end.saturating_sub(1), ""),
        };
        let absent = &steps[found.depth..];
        // The place after the last item of a list takes a new item.
        if parent.shape == Shape::List && *absent == [Step::Index(parent.entries.len())] {
            return Ok(Self { span: at..at, before: comma.to_owned(), after: String::new() });
        }
        let names: Option<Vec<&str>> = absent.iter().map(Step::name).collect();
        let no_field = || nearest_paths(parent, &steps[..found.depth], next);
        let names = names.ok_or_else(no_field)?;
        // A new entry of a map must be complete. Otherwise a misspelt name would create a second
        // entry.
        let fits = match parent.shape {
            Shape::Struct => true,
            Shape::Tuple => parent.entries.is_empty(),
            Shape::Map => names.len() == 1,
            _ => false,
        };
        if !fits {
            return Err(no_field());
        }
        let names: Vec<String> = match parent.shape {
            Shape::Map => names.iter().map(|name| format!("{name:?}: ")).collect(),
            _ => names.iter().map(|name| format!("{name}: ")).collect(),
        };
        let (before, after) = (names.join("("), ")".repeat(names.len() - 1));
        Ok(Self { span: at..at, before: format!("{comma}{before}"), after })
    }

    /// Text at the place with this value.
    fn with(&self, value: &str) -> String {
        format!("{}{value}{}", self.before, self.after)
    }

    /// The first mistake in the new text. Mistakes elsewhere belong to the scene.
    fn refusal(&self, text: &str, new: &str) -> Option<Finding> {
        let mut edited = text.to_owned();
        edited.replace_range(self.span.clone(), new);
        let (root, mut placed) = scan(&edited);
        if let Some(mut root) = root {
            values::put_in(&mut root, &Default::default());
            placed.extend(read::<Scene>(&root).1.placed);
        }
        let span = self.span.start..self.span.start + new.len();
        placed.retain(|placed| span.contains(&placed.at));
        Some(placed.into_iter().min_by_key(|placed| placed.at)?.finding)
    }
}

/// Help that names the existing paths that are nearest to a missing one.
fn nearest_paths(parent: &Node, path: &[Step], next: &Step) -> String {
    let path = write_path(path);
    if !is_group(parent) || parent.entries.is_empty() {
        let value = parent.literal;
        return format!("`{path}` is `{value}`, which has no fields");
    }
    let name = |(i, entry): (usize, &Entry)| match (&entry.key, item_name(&entry.value)) {
        (Some(key), _) => Step::Name(key.text.clone()),
        (None, Some(name)) if parent.shape == Shape::List => Step::Name(name),
        _ => Step::Index(i),
    };
    let steps: Vec<Step> = parent.entries.iter().enumerate().map(name).collect();
    let wanted = next.name().unwrap_or_default();
    let meant = suggest::nearest(wanted, steps.iter().filter_map(Step::name));
    let meant = meant.map(|name| format!("did you mean `{}`? ", join(&path, name)));
    let meant = meant.unwrap_or_default();
    let paths: Vec<String> = steps.iter().map(|step| step.after(&path)).collect();
    let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
    format!("{meant}there is {}", suggest::list(&paths))
}
