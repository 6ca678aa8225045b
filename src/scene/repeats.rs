//! Places of the stages of a text with `Repeat`: the scene has each repetition, and messages keep
//! the places of the text.

use super::format::MAX_STAGES;
use crate::text::diagnostic::Finding;
use crate::text::spans::{join, unwrapped};
use crate::text::tree::{Entry, Node, Shape};

fn is_repeat(entry: &Entry) -> bool {
    entry.value.name == Some("Repeat")
}

/// Places of the stages in a text.
#[derive(Default)]
pub(super) struct Written {
    /// Path of every stage of the scene; empty if the text has no `Repeat`.
    paths: Vec<String>,
    /// Mistakes of the `Repeat`s themselves.
    pub findings: Vec<Finding>,
}

impl Written {
    /// Reads the places from a tree.
    pub fn of(root: &Node) -> Self {
        let mut written = Self::default();
        let Some(list) = root.field("stages").filter(|list| list.entries.iter().any(is_repeat))
        else {
            return written;
        };
        written.see(list, "stages");
        if written.paths.len() > MAX_STAGES {
            let last = written.paths.last().map_or("", String::as_str);
            let path = last
                .split_once(".stages")
                .map_or("stages".to_owned(), |(repeat, _)| join(repeat, "times"));
            let message = format!("more than {MAX_STAGES} stages");
            written.findings.push(Finding::new(path, message, "repeat them fewer times"));
        }
        written
    }

    fn see(&mut self, list: &Node, path: &str) {
        for (k, entry) in list.entries.iter().enumerate() {
            if self.paths.len() > MAX_STAGES {
                return;
            }
            let path = format!("{path}[{k}]");
            if !is_repeat(entry) {
                self.paths.push(path);
                continue;
            }
            let repeat = unwrapped(&entry.value);
            let times = repeat.field("times");
            let times = times.and_then(|node| node.value().parse::<u32>().ok());
            if times == Some(0) {
                let help = "give a number of 1 or more";
                self.findings.push(Finding::new(format!("{path}.times"), "zero (0)", help));
            }
            let Some(stages) = repeat.field("stages") else { continue };
            if stages.entries.is_empty() && stages.shape == Shape::List {
                let finding = Finding::new(
                    format!("{path}.stages"),
                    "no stage: nothing would be repeated",
                    "add one, such as Load(name: \"load\", increments: 10)",
                );
                self.findings.push(finding);
                continue;
            }
            for k in 0..times.unwrap_or(1) {
                let before = self.findings.len();
                self.see(stages, &format!("{path}.stages"));
                // A mistake inside is one mistake, however often it is repeated.
                if k > 0 {
                    self.findings.truncate(before);
                }
                if self.paths.len() > MAX_STAGES {
                    return;
                }
            }
        }
    }

    /// Findings at the places of the text, each once.
    pub fn place(&self, findings: Vec<Finding>) -> Vec<Finding> {
        if self.paths.is_empty() {
            return findings;
        }
        let mut placed: Vec<Finding> = Vec::new();
        for mut finding in findings {
            finding.path = self.written(&finding.path);
            finding.help = finding.help.map(|help| self.written(&help));
            if !placed.contains(&finding) {
                placed.push(finding);
            }
        }
        placed
    }

    /// A text with the paths of stages as written.
    fn written(&self, text: &str) -> String {
        const START: &str = "stages[";
        let mut parts = text.split(START);
        let mut new = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            let (index, rest) = part.split_once(']').unwrap_or((part, ""));
            let path = index.parse().ok().and_then(|k: usize| self.paths.get(k));
            match path {
                Some(path) => new += &format!("{path}{rest}"),
                None => new += &format!("{START}{part}"),
            }
        }
        new
    }
}
