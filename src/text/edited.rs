//! Text of a scene with settings applied, and the source of each part.

use super::spans::Span;

/// A text in which settings have replaced parts.
#[derive(Clone, Debug)]
pub struct EditedText {
    /// The text with settings applied.
    pub text: String,
    /// The text of the file.
    pub file: String,
    edits: Vec<Edit>,
}

/// Source of a byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source<'a> {
    /// Byte of the file, or the byte at which a setting inserted its text.
    pub at: usize,
    /// The setting, `path=value`; `None` for text of the file.
    pub set: Option<&'a str>,
}

/// A replacement in the text as it was after those before.
#[derive(Clone, Debug)]
struct Edit {
    span: Span,
    /// Length of the new text.
    length: usize,
    set: String,
}

impl EditedText {
    /// A text without settings.
    pub fn of(file: &str) -> Self {
        Self { text: file.to_owned(), file: file.to_owned(), edits: Vec::new() }
    }

    /// Replaces a span of the text by the text of a setting.
    pub(crate) fn replace(&mut self, span: Span, new: &str, set: &str) {
        self.text.replace_range(span.clone(), new);
        self.edits.push(Edit { span, length: new.len(), set: set.to_owned() });
    }

    /// Source of a byte of the text.
    pub fn source(&self, at: usize) -> Source<'_> {
        let mut source = Source { at, set: None };
        for Edit { span, length, set } in self.edits.iter().rev() {
            if source.at >= span.start + length {
                source.at = source.at - length + span.len();
            } else if source.at >= span.start {
                source = Source { at: span.start, set: source.set.or(Some(set)) };
            }
        }
        Source { at: source.at.min(self.file.len()), ..source }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_knows_where_it_comes_from() {
        let mut edited = EditedText::of("(a: 1, b: 2, c: 3)");
        edited.replace(10..11, "20000", "b=20000");
        edited.replace(4..5, "x", "a=x");
        // This span lies within the text of a setting.
        edited.replace(11..12, "-", "b=2-000");
        assert_eq!(edited.text, "(a: x, b: 2-000, c: 3)");
        let source = |at| edited.source(at);
        assert_eq!(source(0), Source { at: 0, set: None });
        assert_eq!(source(4), Source { at: 4, set: Some("a=x") });
        assert_eq!(source(5), Source { at: 5, set: None });
        assert_eq!(source(10), Source { at: 10, set: Some("b=20000") });
        assert_eq!(source(11), Source { at: 10, set: Some("b=2-000") });
        assert_eq!(source(14), Source { at: 10, set: Some("b=20000") });
        assert_eq!(source(20), Source { at: 16, set: None });
        assert_eq!(source(99), Source { at: 18, set: None });
        for (i, c) in edited.text.char_indices().filter(|(i, _)| source(*i).set.is_none()) {
            assert_eq!(edited.file[source(i).at..].chars().next(), Some(c));
        }
    }

    #[test]
    fn insertions_at_the_ends() {
        let mut edited = EditedText::of("ab");
        edited.replace(2..2, "z", "z");
        edited.replace(0..0, "y", "y");
        assert_eq!(edited.text, "yabz");
        assert_eq!(edited.source(0), Source { at: 0, set: Some("y") });
        assert_eq!(edited.source(1), Source { at: 0, set: None });
        assert_eq!(edited.source(3), Source { at: 2, set: Some("z") });
    }
}
