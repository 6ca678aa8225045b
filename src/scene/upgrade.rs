//! Version 1 of a scene written as version 2: the text with its comments.

use super::scan::scan;
use super::spans::unwrapped;
use super::tree::{Entry, Key, Node, Shape, Span};

/// The text of a scene of version 1 in version 2; `None` if it is of another version. The text must
/// be that of a scene without mistakes.
#[must_use]
pub fn upgrade(text: &str) -> Option<String> {
    let root = scan(text).0?;
    let field = |name: &str| entry(&root, name);
    let version = &field("version")?.1.span;
    if text.get(version.clone()) != Some("1") {
        return None;
    }
    let mut edits = Edits { text, list: Vec::new() };
    edits.replace(version.clone(), "2");
    if let Some((key, measures)) = field("measures") {
        edits.measures(key, measures);
    }
    for stage in field("stages").into_iter().flat_map(|(_, stages)| &stages.entries) {
        let stops = entry(unwrapped(&stage.value), "stop");
        for stop in stops.into_iter().flat_map(|(_, stops)| &stops.entries) {
            edits.stop(&stop.value);
        }
    }
    Some(edits.apply())
}

fn entry<'a>(node: &'a Node, name: &str) -> Option<(&'a Key, &'a Node)> {
    let with_key = |entry: &'a Entry| Some((entry.key.as_ref()?, &entry.value));
    node.entries.iter().filter_map(with_key).find(|(key, _)| key.text == name)
}

struct Edits<'a> {
    text: &'a str,
    list: Vec<(Span, String)>,
}

impl Edits<'_> {
    fn replace(&mut self, span: Span, new: impl Into<String>) {
        self.list.push((span, new.into()));
    }

    fn of(&self, span: &Span) -> &str {
        self.text.get(span.clone()).unwrap_or_default()
    }

    /// Fields in round brackets become items of a list; the reference stage becomes a field of the
    /// scene.
    fn measures(&mut self, key: &Key, measures: &Node) {
        let open = measures.name.as_ref().map_or(measures.span.start, |name| name.end);
        let open = open + self.text[open..].find('(').unwrap_or_default() + 1;
        let end = measures.span.end;
        self.replace(measures.span.start..open, "[");
        self.replace(end - 1..end, "]");
        for Entry { key: name, value } in &measures.entries {
            let Some(name) = name else { continue };
            if name.text == "reference_stage" {
                if let Some(stage) = self.given(value).map(|span| self.of(&span).to_owned()) {
                    let line = self.text[..key.span.start].rfind('\n').map_or(0, |at| at + 1);
                    let indent = &self.text[line..key.span.start];
                    let indent =
                        if indent.trim().is_empty() { format!("\n{indent}") } else { " ".into() };
                    let field = format!("reference_stage: {stage},{indent}");
                    self.replace(key.span.start..key.span.start, field);
                }
                self.remove(name.span.start..value.span.end);
                continue;
            }
            let Some(given) = self.given(value) else {
                self.remove(name.span.start..value.span.end);
                continue;
            };
            let kind = if name.text.ends_with("strain") { "Strain" } else { "Stress" };
            self.replace(name.span.clone(), format!("(name: {:?}, of", name.text));
            self.replace(value.span.start..given.start, format!("{kind}("));
            self.replace(given.end..value.span.end, "))");
        }
    }

    /// Span of a value without `Some`; `None` for `None`.
    fn given(&self, value: &Node) -> Option<Span> {
        if value.shape == Shape::Word && self.of(&value.span) == "None" {
            return None;
        }
        match (&value.name, value.entries.as_slice()) {
            (Some(name), [only]) if self.of(name) == "Some" => Some(only.value.span.clone()),
            _ => Some(value.span.clone()),
        }
    }

    /// Removes an entry with its comma and the blanks after it.
    fn remove(&mut self, span: Span) {
        let rest = self.text[span.end..].trim_start();
        let after = rest.strip_prefix(',').map_or(rest, str::trim_start);
        self.replace(span.start..self.text.len() - after.len(), "");
    }

    fn stop(&mut self, stop: &Node) {
        let is_strain = stop.name.as_ref().is_some_and(|name| self.of(name) == "AxialStrain");
        let ([only], true) = (stop.entries.as_slice(), is_strain) else { return };
        let strain = self.of(&only.value.span);
        let word = if strain.starts_with('-') { "Below" } else { "Above" };
        self.replace(stop.span.clone(), format!("{word}(\"axial_strain\", {strain})"));
    }

    fn apply(mut self) -> String {
        let mut text = self.text.to_owned();
        self.list.sort_by_key(|(span, _)| (span.start, span.end));
        for (span, new) in self.list.into_iter().rev() {
            text.replace_range(span, &new);
        }
        text
    }
}
