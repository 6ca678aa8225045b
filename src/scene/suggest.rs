//! Names that were probably meant.

/// Below this likeness (1 is equal) a name is another name, not a misspelt one.
const ALIKE: f64 = 0.6;

/// Longest list of names in a message.
const MOST_NAMES: usize = 12;

/// The candidate that is most like a word, if any is.
pub(super) fn nearest<'a>(
    word: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    let word = word.to_lowercase();
    candidates
        .into_iter()
        .map(|name| (strsim::normalized_damerau_levenshtein(&word, &name.to_lowercase()), name))
        .filter(|(likeness, _)| *likeness >= ALIKE)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

/// A list of names for a message: `a`, `b`, `c`.
pub(super) fn list(names: &[&str]) -> String {
    let shown: Vec<_> = names.iter().take(MOST_NAMES).map(|name| format!("`{name}`")).collect();
    let more = if names.len() > MOST_NAMES { ", ..." } else { "" };
    format!("{}{more}", shown.join(", "))
}

/// "did you mean `x`? `label` are ...", as far as there is something to say.
pub(super) fn help(word: &str, names: &[&str], label: &str) -> String {
    let mut names = names.to_vec();
    // A name that is given twice is a mistake of its own.
    let mut seen = std::collections::BTreeSet::new();
    names.retain(|name| seen.insert(*name));
    let meant = nearest(word, names.iter().copied())
        .map(|name| format!("did you mean `{name}`? "))
        .unwrap_or_default();
    match names.as_slice() {
        [] => format!("there are no {label}"),
        [only] => format!("{meant}there is only `{only}`"),
        _ => format!("{meant}there are the {label} {}", list(&names)),
    }
}
