//! A tolerant scanner of RON text, which finds the shape and place of all values but not their
//! meaning: the [tree](super::tree).
//!
//! It knows no types, and keeps the place of each value for messages. Small mistakes (a missing
//! comma, `=` instead of `:`) are recorded, and the scan continues.

use super::diagnostic::{Finding, Placed};
use super::expression::{is_function, number_length};
use super::tree::{Entry, Key, Node, Shape, Span};
use super::units::is_unit;

/// Maximum nesting. Deeper nesting is refused because recursion could overflow the stack.
const DEEPEST: usize = 128;

/// Scans a text. Returns all faults, and the value unless a fault prevents it.
pub fn scan(text: &str) -> (Option<Node<'_>>, Vec<Placed>) {
    let mut scanner = Scanner { text, at: 0, depth: 0, faults: Vec::new() };
    let root = scanner.document();
    let mut faults = scanner.faults;
    let root = root.map_err(|fault| faults.push(fault)).ok();
    (root, faults)
}

pub(crate) fn unquote(literal: &str) -> Option<String> {
    ron::from_str(literal).ok()
}

fn fault(at: usize, message: impl Into<String>, help: &str) -> Placed {
    Placed { at, finding: Finding::new("", message, help) }
}

struct Scanner<'t> {
    text: &'t str,
    at: usize,
    depth: usize,
    faults: Vec<Placed>,
}

impl<'t> Scanner<'t> {
    fn document(&mut self) -> Result<Node<'t>, Placed> {
        self.blank()?;
        while self.rest().starts_with("#!") {
            let end = self.rest().find(']').ok_or_else(|| {
                fault(self.at, "this attribute is never closed", "end it with `)]`")
            })?;
            self.at += end + 1;
            self.blank()?;
        }
        let root = self.value()?;
        self.blank()?;
        if let Some(c) = self.peek() {
            let message = format!("`{c}` after the end");
            self.faults.push(fault(self.at, message, "a file has one value: check the brackets"));
        }
        Ok(root)
    }

    fn rest(&self) -> &'t str {
        self.text.get(self.at..).unwrap_or_default()
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    /// Takes characters that satisfy a condition.
    fn take(&mut self, accept: impl Fn(char) -> bool) -> Span {
        let start = self.at;
        self.at += self.rest().find(|c| !accept(c)).unwrap_or(self.rest().len());
        start..self.at
    }

    /// Takes a character if it is one of these.
    fn take_one(&mut self, any: &[char]) -> Option<char> {
        let c = self.peek().filter(|c| any.contains(c))?;
        self.at += c.len_utf8();
        Some(c)
    }

    /// Skips white space and comments.
    fn blank(&mut self) -> Result<(), Placed> {
        loop {
            self.take(char::is_whitespace);
            if self.rest().starts_with("//") {
                self.take(|c| c != '\n');
            } else if self.rest().starts_with("/*") {
                self.block_comment()?;
            } else {
                return Ok(());
            }
        }
    }

    /// Block comments nest.
    fn block_comment(&mut self) -> Result<(), Placed> {
        let start = self.at;
        let mut open = 0_usize;
        loop {
            let rest = self.rest();
            if rest.starts_with("/*") {
                open += 1;
                self.at += 2;
            } else if rest.starts_with("*/") {
                open -= 1;
                self.at += 2;
                if open == 0 {
                    return Ok(());
                }
            } else if let Some(c) = rest.chars().next() {
                self.at += c.len_utf8();
            } else {
                return Err(fault(start, "this comment is never closed", "end it with `*/`"));
            }
        }
    }

    /// A value: an operand, and further ones with operators between them.
    fn value(&mut self) -> Result<Node<'t>, Placed> {
        let first = self.operand()?;
        let start = first.span.start;
        let Node { literal, name, .. } = first;
        let mut is_sign = literal == "-" || literal == "+";
        let mut is_expression = is_sign || name.is_some_and(is_function);
        let in_brackets = first.shape == Shape::Tuple && first.entries.len() == 1 && name.is_none();
        if !is_expression && !in_brackets && !matches!(first.shape, Shape::Number | Shape::Word) {
            return Ok(first);
        }
        loop {
            let end = self.at;
            self.blank()?;
            if !is_sign && !self.rest().starts_with(['+', '-', '*', '/', '^']) {
                self.at = end;
                break;
            }
            self.at += usize::from(!is_sign);
            (is_sign, is_expression) = (false, true);
            loop {
                self.blank()?;
                if self.take_one(&['+', '-']).is_none() {
                    break;
                }
            }
            self.operand()?;
        }
        Ok(if is_expression { self.leaf(start, Shape::Expression) } else { first })
    }

    fn operand(&mut self) -> Result<Node<'t>, Placed> {
        let start = self.at;
        let rest = self.rest();
        let Some(first) = rest.chars().next() else { return Ok(self.leaf(start, Shape::Nothing)) };
        let raw = rest.strip_prefix("br").or_else(|| rest.strip_prefix('r'));
        if let Some(hashes) = raw.and_then(raw_string_hashes) {
            return self.raw_string(start, hashes);
        }
        match first {
            '(' | '[' | '{' => self.group(start, None, first),
            '"' => self.quoted(start, '"', Shape::Text),
            '\'' => self.quoted(start, '\'', Shape::Char),
            'b' if rest.starts_with("b\"") => self.quoted(start + 1, '"', Shape::Text),
            'b' if rest.starts_with("b'") => self.quoted(start + 1, '\'', Shape::Number),
            '0'..='9' | '+' | '-' | '.' => {
                let sign = self.take_one(&['+', '-']);
                let length = number_length(self.rest());
                self.at += length;
                if sign.is_none() || length > 0 {
                    self.unit();
                }
                Ok(self.leaf(start, Shape::Number))
            }
            ',' | ')' | ']' | '}' => Ok(self.leaf(start, Shape::Nothing)),
            _ => match self.identifier() {
                Some(name) => {
                    self.blank()?;
                    if self.peek() == Some('(') {
                        return self.group(start, self.text.get(name), '(');
                    }
                    self.at = name.end;
                    Ok(self.leaf(start, Shape::Word))
                }
                None => {
                    let message = format!("unexpected character `{}`", first.escape_debug());
                    Err(fault(start, message, "a value was due here"))
                }
            },
        }
    }

    /// Takes a unit after a number on the same line, so that it counts as one mistake instead of
    /// several. A word that could be the key of the next field is not a unit.
    fn unit(&mut self) {
        let rest = self.rest();
        let line = &rest[..rest.find('\n').unwrap_or(rest.len())];
        let word = line.trim_start_matches([' ', '\t']);
        let blank = line.len() - word.len();
        let first = |c: char| c.is_alphabetic() || matches!(c, '%' | '°' | '²' | '³');
        let inner =
            |c: char| first(c) || c.is_ascii_digit() || matches!(c, '/' | '^' | '*' | '·' | ' ');
        let word = &word[..word.find(|c| !inner(c)).unwrap_or(word.len())];
        let word = word.find("//").map_or(word, |comment| &word[..comment]);
        let word = word.find("/*").map_or(word, |comment| &word[..comment]).trim_end();
        let after = line[blank + word.len()..].trim_start();
        let ends = after.is_empty() || after.starts_with([',', ')', ']', '}', '/']);
        if word.starts_with(first) && ends {
            self.at += blank + word.len();
            return;
        }
        // Before an operator only a unit counts, as in `2 mm * s`.
        let word = &word[..word.find([' ', '*']).unwrap_or(word.len())];
        let after = line[blank + word.len()..].trim_start();
        if is_unit(word) && after.starts_with(['+', '-', '*', '/']) {
            self.at += blank + word.len();
        }
    }

    fn leaf(&self, start: usize, shape: Shape) -> Node<'t> {
        self.node(start, None, shape, Vec::new())
    }

    /// A value that ends here.
    fn node(
        &self,
        start: usize,
        name: Option<&'t str>,
        shape: Shape,
        entries: Vec<Entry<'t>>,
    ) -> Node<'t> {
        let span = start..self.at;
        Node { literal: &self.text[span.clone()], span, number: None, name, shape, entries }
    }

    fn identifier(&mut self) -> Option<Span> {
        let first = self.peek()?;
        (first.is_alphabetic() || first == '_').then(|| {
            if self.rest().starts_with("r#") {
                self.at += 2;
            }
            self.take(|c| c.is_alphanumeric() || c == '_')
        })
    }

    fn quoted(&mut self, open: usize, quote: char, shape: Shape) -> Result<Node<'t>, Placed> {
        let start = self.at;
        self.at = open + 1;
        while let Some(c) = self.peek() {
            self.at += c.len_utf8();
            if c == quote {
                return Ok(self.leaf(start, shape));
            }
            if c == '\\' {
                self.at += self.peek().map_or(0, char::len_utf8);
            }
        }
        Err(fault(start, "this quote is never closed", "close the quote"))
    }

    /// Start of a word or number that ends at `end` and has probably lost the quote before it: the
    /// rest of its line has a quote without a partner.
    fn lost_quote(&self, node: &Node, end: usize) -> Option<usize> {
        let is_plain = matches!(node.shape, Shape::Word | Shape::Number | Shape::Expression);
        let line = self.text[end..].lines().next().unwrap_or_default();
        (is_plain && line.matches('"').count() % 2 == 1).then_some(node.span.start)
    }

    fn raw_string(&mut self, start: usize, hashes: usize) -> Result<Node<'t>, Placed> {
        let end = format!("\"{}", "#".repeat(hashes));
        let open = start + self.rest().find('"').unwrap_or_default() + 1;
        match self.text.get(open..).and_then(|body| body.find(&end)) {
            Some(length) => {
                self.at = open + length + end.len();
                Ok(self.leaf(start, Shape::Text))
            }
            None => Err(fault(start, "this raw string is never closed", "close the string")),
        }
    }

    fn group(
        &mut self,
        start: usize,
        name: Option<&'t str>,
        open: char,
    ) -> Result<Node<'t>, Placed> {
        let opened = self.at;
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(fault(opened, "too many brackets within brackets", "nest less"));
        }
        let close = match open {
            '(' => ')',
            '[' => ']',
            _ => '}',
        };
        self.at += 1;
        let mut entries: Vec<Entry<'t>> = Vec::new();
        let mut missing_comma = false;
        loop {
            self.blank()?;
            match self.peek() {
                None => {
                    let message = format!("this `{open}` is never closed");
                    let help = "close it, or check the brackets after it";
                    return Err(fault(opened, message, help));
                }
                Some(c) if c == close => break,
                Some(c @ (')' | ']' | '}')) => {
                    let line = 1 + self.text[..opened].matches('\n').count();
                    let message =
                        format!("`{c}` where the `{open}` of line {line} wants its `{close}`");
                    return Err(fault(self.at, message, "check the brackets"));
                }
                Some(_) => {}
            }
            let entry = self.entry(open)?;
            // The rest of a mistake that was recorded already would only confuse the following
            // messages.
            let leftover = missing_comma
                && entry.key.is_none() != entries.last().is_none_or(|last| last.key.is_none());
            if !leftover {
                entries.push(entry);
            }
            let end = self.at;
            self.blank()?;
            missing_comma = false;
            match self.peek() {
                Some(',') => self.at += 1,
                Some(c) if !matches!(c, ')' | ']' | '}') => {
                    if c == ':' || c == '=' {
                        let message = format!("unexpected character `{c}`");
                        return Err(fault(self.at, message, "a comma was due here"));
                    }
                    missing_comma = true;
                    // A string that extends over several lines up to here has probably lost its
                    // quote.
                    let last = entries.last().map(|entry| &entry.value).filter(|_| !leftover);
                    let lost = last.filter(|node| is_multiline_text(node));
                    if let Some(start) = lost.map(|node| node.span.start) {
                        let message = "this quote is not closed on its line";
                        return Err(fault(start, message, "close the quote"));
                    }
                    if let Some(start) = last.and_then(|node| self.lost_quote(node, end)) {
                        let message = "this text has no quote before it";
                        return Err(fault(start, message, "open the quote"));
                    }
                    let help = "put a comma between two values";
                    self.faults.push(fault(end, "missing comma", help));
                }
                _ => {}
            }
        }
        self.at += 1;
        self.depth -= 1;
        let shape = match open {
            '(' if entries.iter().any(|entry| entry.key.is_some()) => Shape::Struct,
            '(' => Shape::Tuple,
            '[' => Shape::List,
            _ => Shape::Map,
        };
        Ok(self.node(start, name, shape, entries))
    }

    fn entry(&mut self, open: char) -> Result<Entry<'t>, Placed> {
        if open == '[' {
            return Ok(Entry { key: None, value: self.value()? });
        }
        let first = self.value()?;
        let end = self.at;
        self.blank()?;
        match self.peek() {
            Some(':') => {}
            Some('=') if first.shape == Shape::Word => {
                self.faults.push(fault(self.at, "`=` after a field name", "write `:`"));
            }
            next if open == '{' && !matches!(next, Some(',' | '}')) => {
                return Err(fault(end, "missing `:` after a key", "write `key: value`"));
            }
            _ => {
                self.at = end;
                return Ok(Entry { key: None, value: first });
            }
        }
        self.at += 1;
        let quoted = first.shape == Shape::Text;
        let literal = first.literal;
        let text = if quoted { unquote(literal) } else { None };
        let text = text.unwrap_or_else(|| literal.trim_start_matches("r#").to_owned());
        let key = Key { span: first.span, text, quoted };
        self.blank()?;
        Ok(Entry { key: Some(key), value: self.value()? })
    }
}

fn is_multiline_text(node: &Node) -> bool {
    node.shape == Shape::Text && node.literal.starts_with('"') && node.literal.contains('\n')
}

/// Number of `#` before the quote; `None` if no raw string begins here.
fn raw_string_hashes(rest: &str) -> Option<usize> {
    let body = rest.trim_start_matches('#');
    body.starts_with('"').then(|| rest.len() - body.len())
}
