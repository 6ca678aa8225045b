//! Size and letters of a picture, and texts in it.

use std::fmt::Write as _;

use glam::DVec2;

/// Mean width of a letter over the size of the font. That of a wide sans-serif (DejaVu Sans), so
/// that lines stay within the page with any font.
const LETTER: f64 = 0.56;

/// Size and letters of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// Size of the font of labels, px.
    pub font: f64,
    /// Maximum size of the drawing to scale, without margins and texts.
    pub fit: DVec2,
    /// Minimum width of the page.
    pub narrowest: f64,
    /// Margin of the page.
    pub margin: f64,
}

impl Style {
    /// For a screen.
    pub const SCREEN: Self =
        Self { font: 13.0, fit: DVec2::new(900.0, 820.0), narrowest: 620.0, margin: 24.0 };

    /// Attributes of the root element for a page of this size.
    #[must_use]
    pub fn root(&self, size: DVec2) -> String {
        let DVec2 { x, y } = size.round();
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{x}\" height=\"{y}\" \
             viewBox=\"0 0 {x} {y}\" font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
        )
    }
}

/// A coordinate with two digits at most.
pub fn short(x: f64) -> String {
    let text = format!("{x:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Estimated width of a text in a font of this size.
pub fn width(text: &str, font: f64) -> f64 {
    LETTER * font * text.chars().count() as f64
}

/// A text in lines that fit into `room` in a font of this size. A longer word has its own line.
pub fn wrapped(text: &str, font: f64, room: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if width(line, font) + width(word, font) + LETTER * font <= room => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Adds a text whose baseline begins, is centred or ends (`anchor`) at a place.
pub fn text(svg: &mut String, at: DVec2, font: f64, anchor: &str, color: &str, what: &str) {
    let anchor = match anchor {
        "start" => String::new(),
        other => format!(" text-anchor=\"{other}\""),
    };
    // Writing to a string cannot fail.
    let _ = writeln!(
        svg,
        "<text x=\"{}\" y=\"{}\" font-size=\"{}\"{anchor} fill=\"{color}\">{}</text>",
        short(at.x),
        short(at.y),
        short(font),
        escape(what),
    );
}

/// A text without characters that XML reserves.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_break_between_words() {
        assert_eq!(wrapped("one two three", 10.0, width("one two", 10.0)), ["one two", "three"]);
        assert_eq!(wrapped("a verylongword b", 10.0, 20.0), ["a", "verylongword", "b"]);
        assert!(wrapped(" ", 10.0, 20.0).is_empty());
    }
}
