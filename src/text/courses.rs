//! Expressions in place of the points of a table: `Follow(Force(2 * load * s))`.
//!
//! The tree gets their values at the ends of the increments of the stage before it is read, so that
//! the rest of the program knows tables only. Points have the place of the expression.

use std::collections::BTreeSet;
use std::iter::once;

use super::diagnostic::{Finding, Placed};
use super::expression::{Expression, parse};
use super::read::Notes;
use super::spans::{join, unwrapped};
use super::suggest;
use super::tree::{Node, Shape};
use super::units;
use super::values::{a_number, help, stands};

/// Maximum number of points that expressions stand for in a scene. A slip in `increments` must not
/// fill the memory.
pub(crate) const MOST: f64 = 1e6;

/// A table that is given by an expression, or by two in a displacement.
pub(crate) struct Course<'n, 't> {
    pub path: String,
    pub parts: Vec<Part<'n, 't>>,
    /// Unit of the values.
    pub unit: &'static str,
    stage: Stage<'n, 't>,
}

/// An expression of a table.
pub(crate) struct Part<'n, 't> {
    /// Its value in the tree.
    pub node: &'n Node<'t>,
    /// Its path.
    pub path: String,
    /// The expression; `None` if it cannot be parsed.
    pub expression: Option<Expression>,
}

/// What a course needs of its stage.
#[derive(Clone)]
struct Stage<'n, 't> {
    increments: Option<&'n Node<'t>>,
    /// Time step. It is there in a dynamic stage only.
    dt: Option<&'n Node<'t>>,
    /// Numbers of repetitions of the stages around it.
    times: Vec<&'n Node<'t>>,
}

/// Finds the tables that are given by expressions.
pub(crate) fn find<'n, 't>(root: &'n Node<'t>) -> Vec<Course<'n, 't>> {
    let mut courses = Vec::new();
    if let Some(stages) = root.field("stages") {
        see(stages, "stages", (root.field("analysis"), &[]), &mut courses);
    }
    courses
}

fn see<'n, 't>(
    list: &'n Node<'t>,
    path: &str,
    (analysis, times): (Option<&'n Node<'t>>, &[&'n Node<'t>]),
    courses: &mut Vec<Course<'n, 't>>,
) {
    for (k, entry) in list.entries.iter().enumerate() {
        let path = format!("{path}[{k}]");
        let stage = unwrapped(&entry.value);
        if let Some(stages) = stage.field("stages") {
            let times: Vec<_> = times.iter().copied().chain(stage.field("times")).collect();
            see(stages, &join(&path, "stages"), (analysis, &times), courses);
            continue;
        }
        let own = stage.field("analysis").filter(|node| node.literal != "None");
        let dt = own.or(analysis).and_then(|node| unwrapped(node).field("dt"));
        let of = Stage { increments: stage.field("increments"), dt, times: times.to_vec() };
        let entries = |name| stage.field(name).map_or(&[][..], |value| &value.entries);
        let mut add = |path: String, nodes: &[&'n Node<'t>], unit| {
            let part = |(j, node): (usize, &&'n Node<'t>)| {
                let path = if nodes.len() == 1 { path.clone() } else { format!("{path}[{j}]") };
                Part { node, path, expression: parse(node.literal).ok() }
            };
            if nodes.iter().all(|node| node.shape == Shape::Number || stands(node)) {
                let parts = nodes.iter().enumerate().map(part).collect();
                courses.push(Course { path, parts, unit, stage: of.clone() });
            }
        };
        for entry in entries("scale") {
            let Some(key) = &entry.key else { continue };
            // A misspelt name has a message of its own.
            if suggest::nearest(&key.text, ["gravity", "strength", "loads"]).is_some() {
                add(join(&join(&path, "scale"), &key.text), &[&entry.value], "");
            }
        }
        for entry in entries("walls") {
            let is_followed = entry.value.name == Some("Follow");
            let Some(key) = entry.key.as_ref().filter(|_| is_followed) else { continue };
            let path = join(&join(&path, "walls"), &key.text);
            let table = unwrapped(&entry.value);
            match (table.name.unwrap_or_default(), &table.entries[..]) {
                ("Displacement", [x, y]) => add(path, &[&x.value, &y.value], "m"),
                ("Force", [force]) => add(path, &[&force.value], "N"),
                (name @ ("Stress" | "Rotation"), _) => {
                    let (key, unit) =
                        if name == "Stress" { ("stress", "Pa") } else { ("angle", "rad") };
                    if let Some(node) = table.field(key) {
                        add(join(&path, key), &[node], unit);
                    }
                }
                _ => {}
            }
        }
    }
}

impl<'t> Course<'_, 't> {
    /// Names that have a value in every increment.
    pub fn names(&self) -> &'static [&'static str] {
        if self.stage.dt.is_some() { &["s", "t"] } else { &["s"] }
    }

    /// The list of points in place of the expressions, made up if they have mistakes or a name has
    /// no number. `of` has the values of `names`, and `left` is the number of points that the scene
    /// may still have.
    pub fn sample(
        &self,
        names: &[String],
        of: &impl Fn(&str) -> Option<f64>,
        left: &mut f64,
        findings: &mut Vec<Finding>,
        notes: &mut Notes,
    ) -> Node<'t> {
        let number = |node: &Node| parse(node.literal).ok()?.value(of);
        // Wrong numbers of increments and time steps have messages of their own.
        let increments = self.stage.increments.and_then(number);
        let increments = increments.filter(|n| n.fract() == 0.0 && *n >= 1.0).unwrap_or(1.0);
        let dt = self.stage.dt.map(|node| number(node).filter(|dt| *dt > 0.0).unwrap_or(1.0));
        let times = self.stage.times.iter().map(|node| number(node).unwrap_or(1.0));
        *left -= (increments + 1.0) * times.product::<f64>();
        let mut points: Vec<Vec<f64>> = Vec::new();
        let before = findings.len();
        if *left < 0.0 {
            let message = format!("expressions stand for more than {MOST} points");
            let help = "give fewer increments or repetitions, or a table of points";
            findings.push(Finding::new(&self.path, message, help));
        }
        for part in &self.parts {
            let finding = self.mistake(part, names);
            findings.extend(finding.map(|(message, help)| Finding::new(&part.path, message, help)));
        }
        let mut is_made_up = findings.len() > before;
        let mut k = 0.0;
        while k <= increments && !is_made_up {
            let (s, t) = (k / increments, dt.map(|dt| k * dt));
            let of = |name: &str| match name {
                "s" => Some(s),
                "t" if t.is_some() => t,
                _ => of(name),
            };
            let mut point = vec![t.unwrap_or(s)];
            for Part { node, path, expression } in &self.parts {
                let value = expression.as_ref().and_then(|expression| expression.value(&of));
                is_made_up |= !value.is_some_and(f64::is_finite);
                if let Some(value) = value.filter(|value| !value.is_finite()) {
                    let literal = node.literal;
                    let message = format!("`{literal}` has no finite value at s = {s} ({value})");
                    let help = "it needs one from s = 0, the start of the stage, to s = 1, its end";
                    findings.push(Finding::new(path, message, help));
                }
                point.extend(value);
            }
            points.push(point);
            k += 1.0;
        }
        if is_made_up {
            notes.made_up.push(self.path.clone());
            points = [0.0, 1.0].map(|x| [vec![x], vec![0.0; self.parts.len()]].concat()).to_vec();
        }
        let Part { node: first, .. } = &self.parts[0];
        let nodes = || once(first).chain(self.parts.iter().map(|part| &part.node));
        let points = points.iter().map(|point| {
            let numbers = nodes().zip(point).map(|(node, x)| node.as_number(&format!("{x:?}")));
            first.as_group(Shape::Tuple, numbers)
        });
        notes.tables.push((self.path.clone(), increments));
        first.as_group(Shape::List, points)
    }

    /// What is wrong with an expression, apart from its unit and its values, and the remedy.
    fn mistake(
        &self,
        Part { node, expression, .. }: &Part,
        names: &[String],
    ) -> Option<(String, String)> {
        let literal = node.literal;
        let message = format!("expected {}, found `{literal}`", a_number(self.unit));
        let Some(expression) = expression else {
            let with_unit = units::split(literal).filter(|_| node.shape == Shape::Number);
            let help = match with_unit {
                Some((value, of)) => units::help(value, of, Some(self.unit)),
                None => help(node, names, Some(self.unit)),
            };
            return Some((message, help));
        };
        let is_known =
            |word: &&str| names.iter().any(|name| name == word) || self.names().contains(word);
        let word = expression.names().into_iter().find(|word| !is_known(word))?;
        let s = "`s` is the part of the increments that is done, 0 to 1";
        if word == "t" && self.stage.dt.is_none() {
            return Some((format!("`{literal}`: a static stage has no time `t`"), s.to_owned()));
        }
        let help = match names {
            [] => format!("give `{word}` a number in `let`"),
            _ => help(node, names, Some(self.unit)),
        };
        Some((message, format!("{help}; {s}")))
    }
}

/// Findings about points, at the expressions that they come from: one for each table.
pub(crate) fn gather(mut placed: Vec<Placed>, tables: &[(String, f64)]) -> Vec<Placed> {
    let mut seen = BTreeSet::new();
    placed.retain_mut(|Placed { finding, .. }| {
        let point = tables.iter().find_map(|(path, increments)| {
            let (k, _) = finding.path.strip_prefix(path)?.strip_prefix('[')?.split_once(']')?;
            Some((path, k.parse::<f64>().ok()? / increments))
        });
        let Some((path, s)) = point else { return true };
        finding.path.clone_from(path);
        finding.message += &format!(", at s = {s}");
        seen.insert(path)
    });
    placed
}
