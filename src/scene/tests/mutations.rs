//! No text makes the reader panic.

use proptest::prelude::*;

use super::read;
use super::samples::FULL;
use crate::scene::LoadError;
use crate::scene::overrides::apply;
use crate::text::scan::scan;
use crate::text::spans::nearest;

/// Deletes, inserts or doubles a few bytes.
fn mutate(text: &str, edits: &[(usize, u8, usize, String)]) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for (at, kind, length, new) in edits {
        let at = at % (bytes.len() + 1);
        let end = bytes.len().min(at + length);
        match kind {
            0 => drop(bytes.drain(at..end)),
            1 => drop(bytes.splice(at..at, new.bytes())),
            _ => {
                let copy = bytes[at..end].to_vec();
                drop(bytes.splice(at..at, copy));
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutations_are_read_or_refused(
        edits in prop::collection::vec(
            (any::<usize>(), 0_u8..3, 0_usize..40, r#"[-(){}\[\]:,="'#/*a-z0-9.é ]{0,4}"#),
            1..5,
        ),
    ) {
        let text = mutate(FULL, &edits);
        if let Err(LoadError::Scene(errors)) = read(&text, &["thickness=1.0"]) {
            prop_assert!(!errors.list.is_empty());
            let lines = text.lines().count().max(1) + 1;
            prop_assert!(errors.list.iter().all(|error| error.line <= lines));
        }
    }

    #[test]
    fn any_setting_is_applied_or_refused(path in r#"[a-z.\[\]"0-9]{0,12}"#, value in ".{0,8}") {
        let _ = apply(FULL, &[format!("{path}={value}")]);
        let _ = scan(&value).0.map(|root| nearest(&root, &path, true));
    }
}

#[test]
fn deep_nesting_is_refused() {
    for bracket in ["(", "[", "{", "Some(", "a: (", "/*"] {
        assert!(read(&bracket.repeat(100_000), &[]).is_err());
    }
    assert!(read(&"(".repeat(100), &[]).is_err());
}
