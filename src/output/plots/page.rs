//! Size and letters of a picture, and texts in it.

use std::fmt::Write as _;

use glam::DVec2;

/// Mean width of a letter over the size of the font. That of a wide sans-serif (DejaVu Sans), so
/// that lines stay within the page with any font.
const LETTER: f64 = 0.56;
/// pt in a mm.
const PT: f64 = 72.0 / 25.4;

/// Size and letters of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// Size of the font of labels, in units of the page: px, or pt of a printed page.
    pub font: f64,
    /// Maximum size of the drawing to scale, without margins and texts.
    pub fit: DVec2,
    /// Minimum width of the page.
    pub narrowest: f64,
    /// Margin of the page.
    pub margin: f64,
    /// Width of a printed page, mm; `None` for a screen, where the width follows the content.
    pub width_mm: Option<f64>,
}

impl Style {
    /// For a screen.
    pub const SCREEN: Self = Self {
        font: 13.0,
        fit: DVec2::new(900.0, 820.0),
        narrowest: 620.0,
        margin: 24.0,
        width_mm: None,
    };

    /// For a printed page of this width, with labels of `font` pt. What is drawn to scale is at
    /// most 1.5 times as high as wide.
    #[must_use]
    pub fn print(width_mm: f64, font: f64) -> Self {
        let (width, margin) = (width_mm * PT, 0.4 * font);
        let fit = DVec2::new(width - 2.0 * margin, 1.5 * width);
        Self { font, fit, narrowest: width, margin, width_mm: Some(width_mm) }
    }

    /// Attributes of the root element for a page of this size.
    #[must_use]
    pub fn root(&self, size: DVec2) -> String {
        let DVec2 { x, y } = size;
        let (size, family) = match self.width_mm {
            None => (format!("width=\"{x:.0}\" height=\"{y:.0}\""), "sans-serif"),
            Some(_) => (
                format!("width=\"{:.3}mm\" height=\"{:.3}mm\"", x / PT, y / PT),
                "Liberation Sans, Arial, Helvetica, sans-serif",
            ),
        };
        let (x, y) = if self.width_mm.is_some() { (x, y) } else { (x.round(), y.round()) };
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" {size} viewBox=\"0 0 {} {}\" \
             font-family=\"{family}\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
            short(x),
            short(y)
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

    #[test]
    fn a_printed_page_has_its_width() {
        let style = Style::print(84.0, 8.0);
        let root = style.root(DVec2::new(style.narrowest, 100.0));
        assert!(root.contains("width=\"84.000mm\""), "{root}");
        assert!(root.contains("viewBox=\"0 0 238.11 100\""), "{root}");
    }
}
