//! Text of a scene with settings applied, and the source of each part.

use super::spans::Span;

/// A text in which settings have replaced parts.
#[derive(Clone, Debug)]
pub struct EditedText {
    /// The text with settings applied.
    pub text: String,
    file: String,
    pieces: Vec<Piece>,
}

/// Source of a byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source<'a> {
    /// Byte of the file, or the byte at which a setting inserted its text.
    pub at: usize,
    /// The setting, `path=value`; `None` for text of the file.
    pub set: Option<&'a str>,
}

/// A stretch of the text from one source.
#[derive(Clone, Debug)]
struct Piece {
    length: usize,
    /// Byte of the file where the piece begins.
    at: usize,
    /// The setting that inserted it. All of it then comes from one byte of the file.
    set: Option<String>,
}

impl Piece {
    /// Splits the piece.
    fn split(self, length: usize) -> [Self; 2] {
        let at = self.at + if self.set.is_some() { 0 } else { length };
        let rest = Self { length: self.length - length, at, set: self.set.clone() };
        [Self { length, ..self }, rest]
    }
}

impl EditedText {
    /// A text without settings.
    pub fn of(file: &str) -> Self {
        let pieces = vec![Piece { length: file.len(), at: 0, set: None }];
        Self { text: file.to_owned(), file: file.to_owned(), pieces }
    }

    /// The text of the file.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Replaces a span of the text by the text of a setting.
    pub(super) fn replace(&mut self, span: Span, new: &str, set: &str) {
        let at = self.source(span.start).at;
        self.text.replace_range(span.clone(), new);
        let piece = Piece { length: new.len(), at, set: Some(set.to_owned()) };
        let cuts = self.cut(span.start)..self.cut(span.end);
        self.pieces.splice(cuts, Some(piece).filter(|piece| piece.length > 0));
    }

    /// Index of the piece that begins at a byte, where a piece is cut if none does.
    fn cut(&mut self, at: usize) -> usize {
        let (mut i, mut start) = (0, 0);
        while i < self.pieces.len() && start + self.pieces[i].length <= at {
            start += self.pieces[i].length;
            i += 1;
        }
        if at == start || i == self.pieces.len() {
            return i;
        }
        let parts = self.pieces[i].clone().split(at - start);
        self.pieces.splice(i..=i, parts);
        i + 1
    }

    /// Source of a byte of the text.
    pub fn source(&self, at: usize) -> Source<'_> {
        let mut start = 0;
        for piece in &self.pieces {
            if at < start + piece.length {
                let inside = if piece.set.is_some() { 0 } else { at - start };
                return Source { at: piece.at + inside, set: piece.set.as_deref() };
            }
            start += piece.length;
        }
        Source { at: self.file.len(), set: None }
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
            assert_eq!(edited.file()[source(i).at..].chars().next(), Some(c));
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
