//! The list of findings, and the checks that all topics share.

use std::collections::BTreeSet;
use std::fmt::Display;
use std::ops::{Deref, DerefMut};

use clastic_components::domain::{Domain, PLACE};

use crate::scene::format::Analysis;
use crate::scene::limits::{MAX_NUMBER, MIN_NUMBER};
use crate::text::diagnostic::{Finding, within};
use crate::text::spans::join;

use super::Context;

/// Collects findings of a scene.
pub(super) struct Findings<'a> {
    pub(super) context: &'a Context<'a>,
    /// Which walls are there in the stage that is checked.
    pub(super) present: Vec<bool>,
    /// The index of that stage, and its analysis.
    pub(super) stage: usize,
    pub(super) analysis: Analysis,
    pub(super) list: Vec<Finding>,
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

    /// The scene as a place.
    pub(super) fn root(&mut self) -> At<'_, 'a> {
        At { findings: self, path: String::new() }
    }

    /// Whether the stage that is checked certainly has no time.
    pub(super) fn is_timeless(&self) -> bool {
        let own = format!("stages[{}].analysis", self.stage);
        self.analysis == Analysis::Static && self.are_sure_of(&["analysis", &own])
    }

    /// Whether a wall is there in that stage; `None` if the scene has no such wall.
    pub(super) fn is_there(&self, wall: &str) -> Option<bool> {
        let index = self.context.walls.iter().position(|name| *name == wall)?;
        self.present.get(index).copied()
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

    /// Whether some parts of the scene contain no made-up value and have no mistake so far.
    pub(super) fn are_sound(&self, parts: &[&str]) -> bool {
        let has_none = |part: &&str| !self.list.iter().any(|wrong| within(&wrong.path, part));
        self.are_sure_of(parts) && parts.iter().all(has_none)
    }

    /// Adds a finding. Several stages may have the same mistake in one field, which is reported once.
    fn push(&mut self, finding: Finding) {
        if self.known.insert((finding.path.clone(), finding.message.clone())) {
            self.list.push(finding);
        }
    }
}

/// A value, or one that may be left out.
pub(super) trait Maybe<T>: Into<Option<T>> {}

impl<T, V: Into<Option<T>>> Maybe<T> for V {}

/// A place in the scene, where values are checked. Fields are relative to it: `radius`, `[0]` for an
/// item, and nothing for the place itself. A value that is left out is fine.
pub(super) struct At<'f, 'a> {
    findings: &'f mut Findings<'a>,
    path: String,
}

impl<'a> Deref for At<'_, 'a> {
    type Target = Findings<'a>;

    fn deref(&self) -> &Findings<'a> {
        self.findings
    }
}

impl<'a> DerefMut for At<'_, 'a> {
    fn deref_mut(&mut self) -> &mut Findings<'a> {
        self.findings
    }
}

impl<'a> At<'_, 'a> {
    pub fn path(&self, field: impl Display) -> String {
        let field = field.to_string();
        let is_joined = self.path.is_empty() || field.is_empty() || field.starts_with('[');
        format!("{}{}{field}", self.path, if is_joined { "" } else { "." })
    }

    /// A field as a place.
    pub fn field(&mut self, field: impl Display) -> At<'_, 'a> {
        let path = self.path(field);
        At { findings: self.findings, path }
    }

    /// An item of a list in a field.
    pub fn item(&mut self, list: &str, i: usize) -> At<'_, 'a> {
        self.field(format_args!("{list}[{i}]"))
    }

    /// The value of a key of a map in a field.
    pub fn entry(&mut self, map: &str, key: &str) -> At<'_, 'a> {
        let path = join(&self.path(map), key);
        At { findings: self.findings, path }
    }

    /// Checks the same place in the scene with another specimen.
    pub fn with(&mut self, context: &Context, check: impl FnOnce(&mut At)) {
        let mut others = Findings::new(context, self.made_up);
        check(&mut At { findings: &mut others, path: self.path.clone() });
        others.list.into_iter().for_each(|finding| self.push(finding));
    }

    /// Whether a field contains no made-up value.
    pub(crate) fn is_sure(&self, field: impl Display) -> bool {
        self.made_up.is_empty() || self.is_sure_of(&self.path(field))
    }

    pub fn add(
        &mut self,
        field: impl Display,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let path = self.path(field);
        self.push(Finding::new(path, message, help));
    }

    /// Adds a finding where something `is_wrong`.
    pub fn refuse(
        &mut self,
        is_wrong: bool,
        field: impl Display,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        if is_wrong {
            self.add(field, message, help);
        }
    }

    /// A finding at the key of the place.
    pub(crate) fn add_at_key(&mut self, message: impl Into<String>, help: impl Into<String>) {
        let finding = Finding::new(self.path.as_str(), message, help);
        self.push(finding.at_key());
    }

    /// Checks a number; `what` completes "give ...". If zero is not allowed, numbers below
    /// `MIN_NUMBER` are not either.
    pub fn number(
        &mut self,
        field: impl Display,
        value: impl Maybe<f64>,
        allowed: impl Fn(f64) -> bool,
        what: &str,
    ) -> bool {
        let Some(value) = value.into() else { return true };
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
            self.add(field, format!("{problem} ({value:?})"), format!("give {what}{limit}"));
        }
        fine
    }

    /// Checks a number that apps can set as well.
    pub fn within(&mut self, field: impl Display, value: impl Maybe<f64>, domain: Domain) -> bool {
        self.number(field, value, domain.contains, domain.what)
    }

    pub fn positive(&mut self, field: impl Display, value: impl Maybe<f64>, what: &str) -> bool {
        self.number(field, value, |value| value > 0.0, &format!("{what} greater than 0"))
    }

    pub fn not_negative(
        &mut self,
        field: impl Display,
        value: impl Maybe<f64>,
        what: &str,
    ) -> bool {
        self.number(field, value, |value| value >= 0.0, &format!("{what} of 0 or more"))
    }

    pub fn finite(&mut self, field: impl Display, value: impl Maybe<f64>, what: &str) -> bool {
        self.number(field, value, |_| true, what)
    }

    pub fn vector(
        &mut self,
        field: impl Display,
        value: impl Maybe<(f64, f64)>,
        what: &str,
    ) -> bool {
        let Some((x, y)) = value.into() else { return true };
        self.finite(format_args!("{field}[0]"), x, what)
            & self.finite(format_args!("{field}[1]"), y, what)
    }

    /// Checks a point of the plane.
    pub fn place(&mut self, field: impl Display, value: impl Maybe<(f64, f64)>) -> bool {
        self.vector(field, value, PLACE.what)
    }

    /// Checks two positive numbers in ascending order.
    pub fn range(&mut self, field: &str, (min, max): (f64, f64), what: &str) -> bool {
        let fine = self.positive(format_args!("{field}[0]"), min, what)
            & self.positive(format_args!("{field}[1]"), max, what);
        let message = format!("minimum above maximum ({min:?} > {max:?})");
        self.refuse(fine && min > max, field, message, "give (minimum, maximum)");
        fine && min <= max
    }

    /// Checks two corners of a rectangle that has an area.
    pub fn rectangle(&mut self, min: (f64, f64), max: (f64, f64)) -> bool {
        let fine = self.place("min", min) & self.place("max", max);
        let has_area = min.0 < max.0 && min.1 < max.1;
        let is_wrong = fine && !has_area && self.is_sure("min") && self.is_sure("max");
        let message = format!("not above and to the right of min ({max:?})");
        self.refuse(is_wrong, "max", message, "give a rectangle with an area");
        fine && has_area
    }

    /// Checks an integer of at least 1.
    pub(crate) fn at_least_one(&mut self, field: impl Display, value: u32, what: &str) -> bool {
        self.refuse(value == 0, field, "zero (0)", format!("give {what} of 1 or more"));
        value > 0
    }
}
