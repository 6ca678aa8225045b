//! Expressions in place of the points of a table: `Follow(Force(2 * load * s))`.
//!
//! The text gets their values at the ends of the increments of the stage before it is read, so that
//! the rest of the program knows tables only. Messages keep the place of the expression.

use std::collections::BTreeSet;

use super::diagnostic::{Finding, Placed};
use super::expression::{Expression, parse};
use super::spans::{join, unwrapped};
use super::tree::{Node, Shape, Span};
use super::units;
use super::values::{a_number, help, is_name};

/// Maximum number of points that expressions stand for in a scene. A slip in `increments` must not
/// fill the memory.
pub(super) const MOST: f64 = 1e6;

/// A table that is given by an expression, or by two in a displacement.
pub(super) struct Course<'t> {
    /// Path of the table.
    pub path: String,
    /// The expressions.
    pub parts: Vec<Part<'t>>,
    /// Unit of the values.
    pub unit: &'static str,
    stage: Stage<'t>,
}

/// An expression of a table.
pub(super) struct Part<'t> {
    /// Its value in the tree.
    pub node: &'t Node,
    /// Its path.
    pub path: String,
    /// The expression; `None` if it cannot be parsed.
    pub expression: Option<Expression>,
}

/// What a course needs of its stage.
#[derive(Clone)]
struct Stage<'t> {
    increments: Option<&'t Node>,
    /// Time step. It is there in a dynamic stage only.
    dt: Option<&'t Node>,
    /// Numbers of repetitions of the stages around it.
    times: Vec<&'t Node>,
}

/// A table with points in place of its expressions.
pub(super) struct Sampled {
    /// Texts for the expressions.
    pub texts: Vec<(Span, String)>,
    /// Number of increments.
    pub increments: f64,
    /// Mistakes in the expressions. The points are made up if there are any.
    pub findings: Vec<Finding>,
}

/// Finds the tables that are given by expressions.
pub(super) fn find<'t>(root: &'t Node, text: &'t str) -> Vec<Course<'t>> {
    let mut courses = Vec::new();
    if let Some(stages) = root.field("stages") {
        see(stages, text, "stages", (root.field("analysis"), &[]), &mut courses);
    }
    courses
}

fn see<'t>(
    list: &'t Node,
    text: &'t str,
    path: &str,
    (analysis, times): (Option<&'t Node>, &[&'t Node]),
    courses: &mut Vec<Course<'t>>,
) {
    for (k, entry) in list.entries.iter().enumerate() {
        let path = format!("{path}[{k}]");
        let stage = unwrapped(&entry.value);
        if let Some(stages) = stage.field("stages") {
            let times: Vec<_> = times.iter().copied().chain(stage.field("times")).collect();
            see(stages, text, &join(&path, "stages"), (analysis, &times), courses);
            continue;
        }
        let own = stage.field("analysis").filter(|node| node.literal(text) != "None");
        let dt = own.or(analysis).and_then(|node| unwrapped(node).field("dt"));
        let of = Stage { increments: stage.field("increments"), dt, times: times.to_vec() };
        let entries = |name| stage.field(name).map_or(&[][..], |value| &value.entries);
        let mut add = |path: String, nodes: &[&'t Node], unit| {
            let part = |(j, node): (usize, &&'t Node)| {
                let path = if nodes.len() == 1 { path.clone() } else { format!("{path}[{j}]") };
                Part { node, path, expression: parse(node.literal(text)).ok() }
            };
            if nodes.iter().all(|node| stands(node, text)) {
                let parts = nodes.iter().enumerate().map(part).collect();
                courses.push(Course { path, parts, unit, stage: of.clone() });
            }
        };
        for entry in entries("scale") {
            let Some(key) = &entry.key else { continue };
            if ["gravity", "strength", "loads"].contains(&key.text.as_str()) {
                add(join(&join(&path, "scale"), &key.text), &[&entry.value], "");
            }
        }
        for entry in entries("walls") {
            let is_followed = entry.value.variant(text) == Some("Follow");
            let Some(key) = entry.key.as_ref().filter(|_| is_followed) else { continue };
            let path = join(&join(&path, "walls"), &key.text);
            let table = unwrapped(&entry.value);
            match (table.variant(text).unwrap_or_default(), &table.entries[..]) {
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

/// Whether a value can be an expression.
fn stands(node: &Node, text: &str) -> bool {
    match node.shape {
        Shape::Number | Shape::Expression => true,
        Shape::Word => node.literal(text) == "pi" || is_name(node.literal(text)),
        _ => false,
    }
}

impl Course<'_> {
    /// Names that have a value in every increment.
    pub fn names(&self) -> &'static [&'static str] {
        if self.stage.dt.is_some() { &["s", "t"] } else { &["s"] }
    }

    /// Puts points in place of the expressions. `of` has the values of `names`, and `left` is the
    /// number of points that the scene may still have.
    pub fn sample(
        &self,
        text: &str,
        names: &[String],
        of: &impl Fn(&str) -> Option<f64>,
        left: &mut f64,
    ) -> Sampled {
        let number = |node: &Node| parse(node.literal(text)).ok()?.value(of);
        // Wrong numbers of increments and time steps have messages of their own.
        let increments = self.stage.increments.and_then(number);
        let increments = increments.filter(|n| n.fract() == 0.0 && *n >= 1.0).unwrap_or(1.0);
        let dt = self.stage.dt.map(|node| number(node).filter(|dt| *dt > 0.0).unwrap_or(1.0));
        let times = self.stage.times.iter().map(|node| number(node).unwrap_or(1.0));
        *left -= (increments + 1.0) * times.product::<f64>();
        let mut points: Vec<String> = Vec::new();
        let mut findings = Vec::new();
        if *left < 0.0 {
            let message = format!("expressions stand for more than {MOST} points");
            let help = "give fewer increments or repetitions, or a table of points";
            findings.push(Finding::new(&self.path, message, help));
        }
        for part in &self.parts {
            let finding = self.mistake(part, text, names);
            findings.extend(finding.map(|(message, help)| Finding::new(&part.path, message, help)));
        }
        let mut k = 0.0;
        while k <= increments && findings.is_empty() {
            let (s, t) = (k / increments, dt.map(|dt| k * dt));
            let of = |name: &str| match name {
                "s" => Some(s),
                "t" if t.is_some() => t,
                _ => of(name),
            };
            let mut point = format!("({:?}", t.unwrap_or(s));
            for Part { node, path, expression } in &self.parts {
                let value = expression.as_ref().and_then(|expression| expression.value(&of));
                let value = value.unwrap_or(f64::NAN);
                if !value.is_finite() {
                    let literal = node.literal(text);
                    let message = format!("`{literal}` has no finite value at s = {s} ({value})");
                    let help = "it needs one from s = 0, the start of the stage, to s = 1, its end";
                    findings.push(Finding::new(path, message, help));
                }
                point += &format!(", {value:?}");
            }
            points.push(point + ")");
            k += 1.0;
        }
        if !findings.is_empty() {
            let zeros = ", 0.0".repeat(self.parts.len());
            points = vec![format!("(0.0{zeros})"), format!("(1.0{zeros})")];
        }
        // A comma stands between the two expressions of a displacement: the first has one point.
        let (first, rest) = points.split_at(1);
        let texts = match &self.parts[..] {
            [x, y] => vec![
                (x.node.span.clone(), format!("[{}", first[0])),
                (y.node.span.clone(), format!("{}]", rest.join(", "))),
            ],
            parts => vec![(parts[0].node.span.clone(), format!("[{}]", points.join(", ")))],
        };
        Sampled { texts, increments, findings }
    }

    /// What is wrong with an expression, apart from its unit and its values, and the remedy.
    fn mistake(
        &self,
        Part { node, expression, .. }: &Part,
        text: &str,
        names: &[String],
    ) -> Option<(String, String)> {
        let literal = node.literal(text);
        let message = format!("expected {}, found `{literal}`", a_number(self.unit));
        let Some(expression) = expression else {
            let with_unit = units::split(literal).filter(|_| node.shape == Shape::Number);
            let help = match with_unit {
                Some((value, of)) => units::help(value, of, Some(self.unit)),
                None => help(node, text, names, Some(self.unit)),
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
            _ => help(node, text, names, Some(self.unit)),
        };
        Some((message, format!("{help}; {s}")))
    }
}

/// Findings about points, at the expressions that they come from: one for each table.
pub(super) fn gather(mut placed: Vec<Placed>, tables: &[(String, f64)]) -> Vec<Placed> {
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
