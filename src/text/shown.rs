//! Text of a scene for display. A scene may come from an unknown source, so its text must neither
//! control a terminal nor flood it.

/// Maximum length of a token that is not shortened, characters.
const LONGEST: usize = 200;

/// Number of characters kept of a shortened token.
const KEPT: usize = 80;

/// Text with control characters escaped and line breaks kept.
pub fn escaped(text: &str) -> String {
    escape(text, |c| c == '\n')
}

/// A title or a name on one line, with control characters escaped, shortened if it is very long.
pub fn label(text: &str) -> String {
    escape(&shortened(text), |_| false)
}

/// A message that quotes a scene, on one line, with control characters escaped and very long tokens
/// shortened. A token is a text in backquotes or a text without blanks.
pub(crate) fn brief(message: &str) -> String {
    let words = |part: &str| part.split(' ').map(shortened).collect::<Vec<_>>().join(" ");
    let parts = message.split('`').enumerate();
    let parts = parts.map(|(k, part)| if k % 2 == 1 { shortened(part) } else { words(part) });
    escape(&parts.collect::<Vec<_>>().join("`"), |_| false)
}

/// The beginning of a very long text, and its length.
fn shortened(text: &str) -> String {
    match text.char_indices().nth(KEPT) {
        Some((kept, _)) if text.chars().nth(LONGEST).is_some() => {
            format!("{}... ({} characters)", &text[..kept], text.chars().count())
        }
        _ => text.to_owned(),
    }
}

fn escape(text: &str, keep: impl Fn(char) -> bool) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if !keep(c) && (c.is_control() || turns(c)) {
            shown.extend(c.escape_unicode());
        } else {
            shown.push(c);
        }
    }
    shown
}

/// Whether a character breaks a line or changes the direction of the text after it.
fn turns(c: char) -> bool {
    matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped() {
        let title = "\u{1b}[2Jred\u{7}\nnext\u{202e}back\u{9b}1m";
        let expected = "\\u{1b}[2Jred\\u{7}\\u{a}next\\u{202e}back\\u{9b}1m";
        assert_eq!(label(title), expected);
        assert_eq!(brief(title), expected);
        assert_eq!(escaped("a\n\u{1b}b µ"), "a\n\\u{1b}b µ");
        assert_eq!(label("Collapse of a column, σ = 2 MPa"), "Collapse of a column, σ = 2 MPa");
    }

    #[test]
    fn long_tokens_are_shortened_and_say_how_long_they_are() {
        let long = "µ".repeat(100_000);
        let short = format!("{}... (100000 characters)", "µ".repeat(80));
        assert_eq!(label(&long), short);
        assert_eq!(
            brief(&format!("unknown field `{long}`; try `x`")),
            format!("unknown field `{short}`; try `x`")
        );
        assert_eq!(brief(&format!("stages.{long} is wrong")).chars().count(), 80 + 23 + 9);
        let blank = "a b ".repeat(1000);
        assert!(brief(&format!("unknown wall (`{blank}`)")).contains("... (4000 characters)`)"));
        let fine = "a message of many words, ".repeat(40);
        assert_eq!(brief(&fine), fine);
    }
}
