//! The list of findings, and checks that all topics share.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Arguments;

use clastic_components::domain::{Domain, PLACE};

use crate::scene::diagnostic::{Finding, within};
use crate::scene::format::Analysis;
use crate::scene::limits::{MAX_NUMBER, MIN_NUMBER};
use crate::scene::suggest;

use super::Context;

/// Collects findings of a scene. Paths are formatted only for findings, since most checks find nothing.
pub(super) struct Findings<'a> {
    pub(super) context: &'a Context<'a>,
    /// Which walls are there in the stage that is checked.
    pub(super) present: Vec<bool>,
    /// The index of that stage, and its analysis.
    pub(super) stage: usize,
    pub(super) analysis: Analysis,
    list: Vec<Finding>,
    /// Paths and messages of the list.
    known: BTreeSet<(String, String)>,
    made_up: &'a [String],
}

impl<'a> Findings<'a> {
    pub(super) fn new(context: &'a Context<'a>, made_up: &'a [String]) -> Self {
        let scene = context.scene;
        Self {
            context,
            present: scene.walls.iter().map(|wall| wall.present).collect(),
            stage: 0,
            analysis: scene.analysis,
            list: Vec::new(),
            known: BTreeSet::new(),
            made_up,
        }
    }

    /// Whether the stage that is checked has no time.
    pub(super) fn is_timeless(&self) -> bool {
        self.analysis == Analysis::Static
    }

    /// Whether a wall is there in that stage; `None` if the scene has no such wall.
    pub(super) fn is_there(&self, wall: &str) -> Option<bool> {
        let index = self.context.walls.iter().position(|name| *name == wall)?;
        self.present.get(index).copied()
    }

    /// Findings about the scene with another specimen.
    pub(super) fn of<'b>(&self, context: &'b Context<'b>) -> Findings<'b>
    where
        'a: 'b,
    {
        Findings::new(context, self.made_up)
    }

    pub(super) fn extend(&mut self, others: Findings) {
        others.list.into_iter().for_each(|finding| self.push(finding));
    }

    pub(super) fn into_list(self) -> Vec<Finding> {
        self.list
    }

    /// Number of findings so far.
    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether a part of the scene contains no made-up value. Otherwise no conclusions may be drawn
    /// from it.
    pub(super) fn is_sure_of(&self, path: &str) -> bool {
        !self.made_up.iter().any(|made_up| within(made_up, path))
    }

    /// Whether none of some parts of the scene contains a made-up value.
    pub(super) fn are_sure_of(&self, parts: &[&str]) -> bool {
        parts.iter().all(|part| self.is_sure_of(part))
    }

    /// Like [`is_sure_of`](Self::is_sure_of), for a path that is formatted only if necessary.
    pub(super) fn is_sure_of_part(&self, path: Arguments) -> bool {
        self.made_up.is_empty() || self.is_sure_of(&path.to_string())
    }

    /// Whether a part of the scene contains no made-up value and has no mistake so far.
    pub(super) fn is_sound(&self, path: &str) -> bool {
        self.is_sure_of(path) && !self.list.iter().any(|finding| within(&finding.path, path))
    }

    /// Whether some parts of the scene contain no made-up value and have no mistake so far.
    pub(super) fn are_sound(&self, parts: &[&str]) -> bool {
        parts.iter().all(|part| self.is_sound(part))
    }

    pub(super) fn add(&mut self, path: Arguments, message: impl Into<String>, help: &str) {
        self.push(Finding::new(path.to_string(), message, help));
    }

    /// Adds a finding. Several stages may have the same mistake in one field, which is reported once.
    fn push(&mut self, finding: Finding) {
        if self.known.insert((finding.path.clone(), finding.message.clone())) {
            self.list.push(finding);
        }
    }

    /// A finding at the key of a field.
    pub(super) fn add_at_key(&mut self, path: Arguments, message: String, help: &str) {
        let finding = Finding::new(path.to_string(), message, help);
        self.push(Finding { at_key: true, ..finding });
    }

    /// Checks a number; `what` completes "give ...". If zero is not allowed, numbers below
    /// `MIN_NUMBER` are not either.
    pub(super) fn number(
        &mut self,
        path: Arguments,
        value: f64,
        allowed: impl Fn(f64) -> bool,
        what: &str,
    ) -> bool {
        let tiny = value != 0.0 && value.abs() < MIN_NUMBER && !allowed(0.0);
        let huge = value.is_finite() && value.abs() > MAX_NUMBER;
        let fine = value.is_finite() && allowed(value) && !tiny && !huge;
        if !fine {
            let (problem, limit) = match value {
                _ if !value.is_finite() => ("not finite", String::new()),
                _ if !allowed(value) && value < 0.0 => ("negative", String::new()),
                _ if value == 0.0 => ("zero", String::new()),
                _ if tiny => ("too small", format!(", and not below {MIN_NUMBER:e}")),
                _ if huge => ("too large", format!(", within {MAX_NUMBER:e}")),
                _ => ("out of range", String::new()),
            };
            self.add(path, format!("{problem} ({value:?})"), &format!("give {what}{limit}"));
        }
        fine
    }

    /// Checks a number that apps can set as well.
    pub(super) fn within(&mut self, path: Arguments, value: f64, domain: Domain) -> bool {
        self.number(path, value, domain.contains, domain.what)
    }

    pub(super) fn positive(&mut self, path: Arguments, value: f64, what: &str) -> bool {
        self.number(path, value, |value| value > 0.0, &format!("{what} greater than 0"))
    }

    pub(super) fn not_negative(&mut self, path: Arguments, value: f64, what: &str) -> bool {
        self.number(path, value, |value| value >= 0.0, &format!("{what} of 0 or more"))
    }

    pub(super) fn finite(&mut self, path: Arguments, value: f64, what: &str) -> bool {
        self.number(path, value, |_| true, what)
    }

    pub(super) fn vector(&mut self, path: Arguments, (x, y): (f64, f64), what: &str) -> bool {
        self.finite(format_args!("{path}[0]"), x, what)
            & self.finite(format_args!("{path}[1]"), y, what)
    }

    /// Checks two positive numbers in ascending order.
    pub(super) fn range(&mut self, path: Arguments, (min, max): (f64, f64), what: &str) -> bool {
        let fine = self.positive(format_args!("{path}[0]"), min, what)
            & self.positive(format_args!("{path}[1]"), max, what);
        if fine && min > max {
            let message = format!("minimum above maximum ({min:?} > {max:?})");
            self.add(path, message, "give (minimum, maximum)");
        }
        fine && min <= max
    }

    /// Checks two corners of a rectangle that has an area.
    pub(super) fn rectangle(&mut self, path: Arguments, min: (f64, f64), max: (f64, f64)) -> bool {
        let fine = self.vector(format_args!("{path}.min"), min, PLACE.what)
            & self.vector(format_args!("{path}.max"), max, PLACE.what);
        let has_area = min.0 < max.0 && min.1 < max.1;
        if fine && !has_area {
            let message = format!("not above and to the right of min ({max:?})");
            self.add(format_args!("{path}.max"), message, "give a rectangle with an area");
        }
        fine && has_area
    }

    /// Checks an integer of at least 1.
    pub(super) fn at_least_one(&mut self, path: Arguments, value: u32, what: &str) {
        if value == 0 {
            self.add(path, "zero (0)", &format!("give {what} of 1 or more"));
        }
    }

    /// Checks a reference to a named part of the scene. `topic` is the field that defines such
    /// parts.
    pub(super) fn reference(
        &mut self,
        path: Arguments,
        name: &str,
        (kind, topic): (&str, &str),
        names: &[&str],
    ) -> bool {
        let known = names.contains(&name);
        if !known && self.is_sure_of(topic) {
            let help = suggest::help(name, names, &format!("{kind}s"));
            self.add(path, format!("unknown {kind} (`{name}`)"), &help);
        }
        known
    }

    /// Checks two references to different parts.
    pub(super) fn pair<T: PartialEq>(&mut self, path: Arguments, (a, b): (T, T), kind: &str) {
        if a == b {
            self.add(path, format!("a {kind} given twice"), &format!("name two {kind}s"));
        }
    }

    /// Checks that names are not empty and are unique.
    pub(super) fn unique<'n>(
        &mut self,
        kind: &str,
        names: impl IntoIterator<Item = (String, &'n str)>,
    ) {
        let mut seen: BTreeMap<&str, String> = BTreeMap::new();
        for (path, name) in names {
            if name.trim().is_empty() {
                self.add(format_args!("{path}"), format!("empty {kind}"), "give a name");
            } else if let Some(first) = seen.get(name) {
                let message = format!("{kind} given twice (`{name}`)");
                let help = format!("it is also that of {first}");
                self.add(format_args!("{path}"), message, &help);
            } else {
                seen.insert(name, path);
            }
        }
    }
}
