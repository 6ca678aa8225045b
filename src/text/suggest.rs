//! Suggestions for misspelt names.

use indexmap::IndexSet;

/// Names with less similarity than this (1 is equal) do not count as misspellings of each other.
const ALIKE: f64 = 0.6;

/// Maximum number of names in a message.
const MAX_NAMES: usize = 12;

/// The candidate that is most similar to a word, if any is similar enough.
pub(crate) fn nearest<'a>(
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
pub(crate) fn list(names: &[&str]) -> String {
    let shown: Vec<_> = names.iter().take(MAX_NAMES).map(|name| format!("`{name}`")).collect();
    let more = if names.len() > MAX_NAMES { ", ..." } else { "" };
    format!("{}{more}", shown.join(", "))
}

/// Help text: "did you mean `x`? `label` are ...". It is empty without names.
pub(crate) fn help(word: &str, names: &[&str], label: &str) -> String {
    // A name that is given twice is reported separately.
    let names: Vec<_> = names.iter().copied().collect::<IndexSet<_>>().into_iter().collect();
    let meant = nearest(word, names.iter().copied());
    let meant = meant.map_or(String::new(), |name| format!("did you mean `{name}`? "));
    match names.as_slice() {
        [] => format!("there are no {label}"),
        [only] => format!("{meant}there is only `{only}`"),
        _ => format!("{meant}there are the {label} {}", list(&names)),
    }
}
