//! Root element of a chart, and texts in it.

/// Mean width of a letter over the size of the font. That of a wide sans-serif (DejaVu Sans), so
/// that lines stay within the page with any font.
const LETTER: f64 = 0.56;

/// The root element of a page of this size, in px.
pub(super) fn root((width, height): (f64, f64)) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
    )
}

/// Estimated width of a text in a font of this size.
pub(super) fn width(text: &str, font: f64) -> f64 {
    LETTER * font * text.chars().count() as f64
}

/// A text in lines that fit into `room` in a font of this size. A longer word has its own line.
pub(super) fn wrapped(text: &str, font: f64, room: f64) -> Vec<String> {
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
